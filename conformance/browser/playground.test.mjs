// The playground in a browser, as `web/build` has built it. One browser, one test after the other: a loop that keeps
// time does not share a machine with a second one.

import { test } from "node:test";
import { closeBrowser } from "./visit.mjs";

await import("./playground/loop.mjs");
await import("./playground/link.mjs");
await import("./playground/worlds.mjs");
await import("./playground/looks.mjs");

test("the browser ends", closeBrowser);
