// A visit to the playground.

import { existsSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { serve } from "../serve.mjs";
import { visit } from "../visit.mjs";

const TARGET = process.env.CARGO_TARGET_DIR ?? fileURLToPath(new URL("../../../target", import.meta.url));
export const FOLDER = process.env.PALPATE_PLAYGROUND ?? join(TARGET, "playground");

if (!existsSync(FOLDER)) {
  throw new Error(`${FOLDER} is not there: web/build, or say where with PALPATE_PLAYGROUND`);
}

/** Opens the playground with this end of its link, on a server of its own. */
export async function play(fragment = "", how = {}) {
  const server = await serve(FOLDER);
  const open = await visit(server.url + fragment, { ...how, wait: how.wait ?? !fragment.includes("world=") });
  return {
    open,
    server,
    async leave(expected) {
      await open.leave(expected);
      await server.end();
    },
  };
}

/** Energy that each lane's held force has created over these seconds of its run [J]. */
export function created(open, fromS, toS) {
  return open.get(
    (fromS, toS) =>
      palpate.model.lanes.map(({ ring }) => {
        const at = palpate.model.column("leak_held_j");
        return ring.value(at, ring.rowAt(toS)) - ring.value(at, Math.max(0, ring.rowAt(fromS)));
      }),
    fromS,
    toS,
  );
}
