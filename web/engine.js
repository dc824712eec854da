// The compiled loop, called with numbers, and with text through an input and an output buffer
// (bindings/wasm/src/edge.rs).

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** A refusal of the engine, in its words: a message as text, or a plain sentence. */
export class Refusal extends Error {}

export class Engine {
  /** @param {WebAssembly.Instance} instance */
  constructor(instance) {
    this.exports = instance.exports;
  }

  /** @param {BufferSource} bytes of `palpate.wasm` */
  static async of(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Engine(instance);
  }

  /** Loads it from an address; compiles while downloading if the server sends the content type. */
  static async from(url) {
    const response = await fetch(url);
    if (!response.ok) {
      throw new Error(`${url}: the server answers ${response.status}`);
    }
    return Engine.of(await response.arrayBuffer());
  }

  give(text) {
    const bytes = encoder.encode(text);
    const at = this.exports.palpate_input(bytes.length);
    // The memory may have grown, so its buffer is fetched each time.
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
  }

  /** Output of the last call: a copy, because the next call overwrites it. */
  get bytes() {
    const { memory, palpate_output: at, palpate_output_bytes: length } = this.exports;
    return new Uint8Array(memory.buffer, at(), length()).slice();
  }

  /** Calls a function by name; returns its output, or throws a refusal. */
  ask(name, { text = "", values = [] } = {}) {
    this.give(text);
    const refused = this.exports[name](...values);
    const { bytes } = this;
    if (refused) {
      throw new Refusal(decoder.decode(bytes));
    }
    return bytes;
  }

  words(name, how) {
    return decoder.decode(this.ask(name, how));
  }

  /** Opens a scene of one contact; the greeting as text. */
  open(scene) {
    return this.words("palpate_open", { text: scene });
  }

  /** Applies a message; returns the state as text. */
  hear(message) {
    return this.words("palpate_hear", { text: JSON.stringify(message) });
  }

  get state() {
    return this.words("palpate_state");
  }

  /** Ticks up to a time of the run [s]; returns the number of ticks of all renderings. */
  advance(untilS) {
    return this.exports.palpate_advance(untilS);
  }

  /** Time of the run reached by all renderings [s]. */
  get timeS() {
    return this.exports.palpate_time();
  }

  /** New rows of a rendering; null if there are none. */
  frame(lane) {
    const bytes = this.ask("palpate_frame", { values: [lane] });
    return bytes.length > 0 ? bytes.buffer : null;
  }

  /** Events since the last call: messages as texts. */
  get notes() {
    const text = this.words("palpate_notes");
    return text === "" ? [] : text.split("\n");
  }

  /** Opens a world with a rendering for each of these methods; returns the objects to draw. */
  openWorld(world, methods) {
    return JSON.parse(this.words("palpate_open_world", { text: `${world}\0${methods.join(",")}` }));
  }

  lead(device, [x, y, z]) {
    this.ask("palpate_lead", { values: [device, x, y, z] });
  }

  advanceWorld(untilS) {
    return this.exports.palpate_advance_world(untilS);
  }

  /** Positions of all objects of the world. */
  get world() {
    return JSON.parse(this.words("palpate_world"));
  }

  /** Every number of a run by all methods, as bits. */
  numbers(scene) {
    return this.words("palpate_numbers", { text: scene });
  }
}
