// The loop behind the page: a worker instead of the server of `palpate live`.

export class Loop {
  /**
   * @param {{text: (message: object) => void, samples: (bytes: ArrayBuffer) => void, pace: (report: object) => void,
   *     drawn: (drawn: object) => void, world: (now: object) => void, ready: () => void, failed: (why: string) => void}} on
   */
  constructor(on) {
    this.on = on;
    this.goes = false;
    /** Whether it has stopped completely, so that no further message arrives. */
    this.isStill = true;
    this.worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => {
      this.goes = false;
      on.failed(event.message || "the loop's worker cannot be loaded");
    };
    this.ask({ type: "load", wasm: new URL("palpate.wasm", import.meta.url).href });
  }

  ask(message) {
    this.worker.postMessage(message);
  }

  hear({ kind, ...said }) {
    const { on } = this;
    switch (kind) {
      case "text":
        on.text(JSON.parse(said.text));
        break;
      case "samples":
        on.samples(said.bytes);
        break;
      case "pace":
        on.pace(said);
        break;
      case "drawn":
        on.drawn(said.drawn);
        break;
      case "world":
        on.world(said.now);
        break;
      case "stopped":
        this.isStill = !this.goes;
        break;
      case "ready":
        on.ready();
        break;
      default:
        this.goes = false;
        on.failed(said.text);
    }
  }

  /** A message as to the server of `palpate live`. */
  say(message) {
    this.ask({ type: "say", message });
    return true;
  }

  go() {
    this.goes = true;
    this.isStill = false;
    this.ask({ type: "go" });
  }

  stop() {
    this.goes = false;
    this.ask({ type: "stop" });
  }
}
