// The page in a browser, with the real program. One process and one browser, with tests in sequence: a loop that keeps
// time needs the machine for itself.

import { afterEach, test } from "node:test";
import { endAll } from "./program.mjs";
import { closeBrowser } from "./visit.mjs";

// Processes of a failed test would disturb the following tests.
afterEach(endAll);

await import("./live/hand.mjs");
await import("./live/settings.mjs");
await import("./live/curves.mjs");
await import("./live/exports.mjs");
await import("./live/connection.mjs");
await import("./live/looks.mjs");
await import("./live/worlds.mjs");
await import("./live/several.mjs");

// A test rather than an after-all hook, which would wait for the browser to end.
test("the browser ends", closeBrowser);
