// The connection to the server: it is opened again by itself, later and later.

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 5000;
// Status comes twice a second: one that is silent for this long is gone, though nothing has closed.
const SILENCE_MS = 4000;

/** How long to wait before this try to open again [ms], the first being 0. */
export function waitMs(tries) {
  return Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** tries);
}

export class Link {
  /**
   * @param {string} search of the page's address: its token is passed on
   * @param {{text: (message: object) => void, samples: (bytes: ArrayBuffer) => void, open: () => void,
   *     lost: (why: string, waitMs: number) => void, wrong: (error: Error) => void}} heard
   */
  constructor(search, heard) {
    const token = new URLSearchParams(search).get("token");
    this.path = token === null ? "/live" : `/live?token=${encodeURIComponent(token)}`;
    this.heard = heard;
    this.tries = 0;
    this.socket = null;
    this.timer = 0;
    this.open();
  }

  /** Opens a connection now, in place of the one before: there is one at most that is heard. */
  open() {
    clearTimeout(this.timer);
    const before = this.socket;
    this.socket = null;
    before?.close();
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}${this.path}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    let opened = false;
    // One that is closed may still have something on its way.
    const hear = (kind, listener) =>
      socket.addEventListener(kind, (event) => {
        if (this.socket === socket) {
          listener(event);
        }
      });
    hear("open", () => {
      opened = true;
      this.tries = 0;
      this.listen(socket);
      this.heard.open();
    });
    hear("message", ({ data }) => {
      this.heardAt = performance.now();
      try {
        if (typeof data === "string") {
          this.heard.text(JSON.parse(data));
        } else {
          this.heard.samples(data);
        }
      } catch (error) {
        this.heard.wrong(error);
      }
    });
    hear("close", ({ reason }) => this.lost(opened, reason));
  }

  /** Whether what is said now is heard. */
  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  say(message) {
    if (!this.isOpen) {
      return false;
    }
    this.socket.send(JSON.stringify(message));
    return true;
  }

  listen(socket) {
    this.heardAt = performance.now();
    const watch = setInterval(() => {
      if (this.socket !== socket || socket.readyState !== WebSocket.OPEN) {
        clearInterval(watch);
      } else if (performance.now() - this.heardAt > SILENCE_MS) {
        clearInterval(watch);
        this.socket = null;
        socket.close();
        this.lost(true, "no message for 4 s");
      }
    }, 500);
  }

  async lost(opened, reason) {
    const wait = waitMs(this.tries);
    this.tries += 1;
    this.timer = setTimeout(() => this.open(), wait);
    this.heard.lost(reason || (opened ? "the connection was closed" : "no answer"), wait);
    if (!opened) {
      const why = await this.whyRefused();
      if (why && !this.isOpen) {
        this.heard.lost(why, wait);
      }
    }
  }

  /** A browser does not tell why a WebSocket was refused; a request to the same address does. */
  async whyRefused() {
    const reasons = {
      401: "the token is missing or wrong: open the address that the server has printed",
      403: "this page's origin is not allowed",
      421: "this host name is not allowed; start the server with --allow-host",
      503: "the limit of clients is reached",
    };
    try {
      return reasons[(await fetch(this.path, { cache: "no-store" })).status];
    } catch {
      return undefined;
    }
  }
}
