// The loop, on a separate thread: it advances simulated time by the elapsed real time, and reports its results.
//
// Its messages are those of the server of `palpate live` (docs/reference/live-protocol.md), and `pace`: how well it
// keeps up.

import { Engine, Refusal } from "./engine.js";
import { Pacer } from "./pacer.js";

const TURN_MS = 8;
const PACE_MS = 500;
const STATE_MS = 100;

let engine = null;
/** "contact" or "world": the open scene. */
let kind = null;
let timer = null;
let paceSentMs = 0;
let stateSentMs = 0;
const pacer = new Pacer();

function say(message, transfer = []) {
  postMessage(message, transfer);
}

function tell(text) {
  say({ kind: "text", text });
}

/** Calls the engine; refusals are reported, and errors end the loop. */
function guarded(act) {
  try {
    act();
  } catch (error) {
    if (error instanceof Refusal) {
      const isMessage = error.message.startsWith("{");
      tell(isMessage ? error.message : JSON.stringify({ type: "refused", about: "open", text: error.message }));
    } else {
      stop();
      kind = null;
      say({ kind: "failed", text: String(error.message ?? error) });
    }
  }
}

const asked = {
  async load({ wasm }) {
    try {
      engine = await Engine.from(wasm);
      say({ kind: "ready" });
    } catch (error) {
      say({ kind: "failed", text: `the loop cannot be loaded: ${error.message}` });
    }
  },
  open({ scene, messages }) {
    tell(engine.open(scene));
    kind = "contact";
    begin(messages);
  },
  /** Applies all of these messages, and restarts. */
  begin({ messages }) {
    begin(messages);
  },
  say({ message }) {
    const isAnew = message.type === "restart" || message.type === "device" || "period_s" in message || "lanes" in message;
    const before = engine.timeS;
    const state = engine.hear(message);
    if (isAnew && engine.timeS < before) {
      pacer.anew(performance.now(), engine.timeS);
    }
    if (message.type !== "hand") {
      tell(state);
    }
  },
  openWorld({ world, methods }) {
    const drawn = engine.openWorld(world, methods);
    kind = "world";
    say({ kind: "drawn", drawn });
    pacer.anew(performance.now(), 0);
  },
  lead({ device, to }) {
    engine.lead(device, to);
  },
  go() {
    if (timer === null) {
      pacer.goOn(performance.now());
      timer = setInterval(() => guarded(turn), TURN_MS);
    }
  },
  stop() {
    stop();
    if (kind === "contact") {
      tell(engine.state);
    }
    say({ kind: "stopped" });
  },
};

function begin(messages) {
  for (const message of messages) {
    guarded(() => engine.hear(message));
  }
  engine.hear({ type: "restart" });
  tell(engine.state);
  pacer.anew(performance.now(), engine.timeS);
}

function stop() {
  clearInterval(timer);
  timer = null;
  pacer.hold();
}

function turn() {
  const begun = performance.now();
  const untilS = pacer.until(begun);
  if (kind === "contact") {
    pacer.ran(engine.advance(untilS), engine.timeS);
    for (const lane of [0, 1]) {
      const bytes = engine.frame(lane);
      if (bytes) {
        say({ kind: "samples", bytes }, [bytes]);
      }
    }
    const { notes } = engine;
    notes.forEach(tell);
    if (notes.length > 0 || begun - stateSentMs >= STATE_MS) {
      stateSentMs = begun;
      tell(engine.state);
    }
  } else if (kind === "world") {
    const ticks = engine.advanceWorld(untilS);
    const now = engine.world;
    pacer.ran(ticks, now.t_s);
    say({ kind: "world", now });
  }
  const ended = performance.now();
  pacer.worked(ended - begun);
  if (ended - paceSentMs >= PACE_MS) {
    paceSentMs = ended;
    say({ kind: "pace", ...pacer.report(ended) });
  }
}

onmessage = ({ data }) => guarded(() => asked[data.type](data));
