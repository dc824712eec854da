// The playground in a browser, as built by `web/build`. One browser, with tests in sequence: a loop that keeps time
// needs the machine for itself.

import { test } from "node:test";
import { closeBrowser } from "./visit.mjs";

await import("./playground/loop.mjs");
await import("./playground/link.mjs");
await import("./playground/worlds.mjs");
await import("./playground/looks.mjs");

test("the browser ends", closeBrowser);
