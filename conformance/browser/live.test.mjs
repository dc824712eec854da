// The page in a browser, on the real program. One process, one browser, one test after the other: a loop that keeps
// time does not share a machine with a second one.

import { afterEach, test } from "node:test";
import { endAll } from "./program.mjs";
import { closeBrowser } from "./visit.mjs";

// What a test that has failed leaves running would disturb those after it.
afterEach(endAll);

await import("./live/hand.mjs");
await import("./live/settings.mjs");
await import("./live/curves.mjs");
await import("./live/exports.mjs");
await import("./live/connection.mjs");
await import("./live/looks.mjs");
await import("./live/worlds.mjs");
await import("./live/several.mjs");

// As a test, not as something after all tests: that would wait for the browser to end.
test("the browser ends", closeBrowser);
