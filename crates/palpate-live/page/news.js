// Messages about server and loop: the connection, the loop's end, and its notes.

/** Most notes in the list. */
const MAX_NOTES = 200;

export class News {
  /** `place` gives the element of an id. */
  constructor(place, model, banners) {
    Object.assign(this, { place, banners });
    model.addEventListener("hello", () => {
      this.connection("live", "live");
      banners.show("wrong", null);
    });
    model.addEventListener("ended", ({ detail }) => {
      const isOver = detail !== null;
      banners.show("ended", isOver ? `The loop is over: ${detail}.` : null);
      this.connection(isOver ? "ended" : "live", isOver ? "over" : "live");
    });
    model.addEventListener("note", ({ detail }) => this.note(detail));
  }

  /** Another loop: its title, and no notes yet. */
  begin(title) {
    document.title = `${title} – palpate`;
    this.place("title").textContent = title;
    this.place("note-list").replaceChildren();
    this.place("note-count").textContent = "";
  }

  connection(kind, text) {
    this.place("connection").dataset.kind = kind;
    this.place("connection").textContent = text;
  }

  /** The server is gone; `again` opens the connection at once. */
  lost(why, waitMs, again) {
    const wait = waitMs < 1000 ? "at once" : `in ${Math.round(waitMs / 1000)} s`;
    const text = `The server is gone: ${why}. The curves are kept; retrying ${wait}.`;
    this.banners.show("lost", text, { label: "Try now", act: again });
    this.connection("lost", "not connected");
  }

  /** The server is there again. */
  found() {
    this.banners.show("lost", null);
  }

  wrong(error) {
    console.error(error);
    this.banners.show("wrong", `Invalid message from the server: ${error.message}.`);
  }

  note({ lane, t_s, kind, text }) {
    const item = document.createElement("li");
    const when = document.createElement("span");
    when.className = `lane-${lane + 1}`;
    when.textContent = `${t_s.toFixed(3)} s`;
    item.append(when, ` ${kind}: ${text}`);
    const list = this.place("note-list");
    list.prepend(item);
    while (list.children.length > MAX_NOTES) {
      list.lastChild.remove();
    }
    this.place("note-count").textContent = `(${list.children.length})`;
  }
}
