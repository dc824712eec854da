// Prints every number of a run by the compiled loop: node web/numbers.mjs PALPATE.wasm SCENE.toml

import { readFileSync, writeSync } from "node:fs";
import { Engine } from "./engine.js";

const [wasm, scene] = process.argv.slice(2);
const engine = await Engine.of(readFileSync(wasm));
const bytes = Buffer.from(engine.numbers(readFileSync(scene, "utf8")));
for (let at = 0; at < bytes.length; ) {
  at += writeSync(1, bytes, at);
}
