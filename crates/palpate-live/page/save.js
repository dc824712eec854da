// Files that the user can save from the page.

import { table } from "./csv.js";
import { picture } from "./picture.js";

/** The name of a file of now: palpate-2026-11-21T22-05-09.csv. */
function nameOf(kind) {
  return `palpate-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.${kind}`;
}

function handOver(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** All rows that are in the buffers. */
export async function saveTable(model) {
  const lanes = model.lanes
    .map(({ ring }, lane) => ({ lane, ring: ring.copy() }))
    .filter(({ ring }) => ring.length > 0);
  const about = {
    title: model.hello.title,
    palpate_version: model.hello.version,
    made: new Date().toISOString(),
    run: model.run,
    frames_dropped_on_the_way: model.droppedFrames,
    rows_not_kept_while_paused: model.refusedRows,
    notes: [...model.notes],
  };
  const parts = [];
  for (const part of table(model.names, lanes, [...model.settings], model.settingsFrom, about)) {
    parts.push(part);
    // Let the page draw in between.
    await new Promise((go) => setTimeout(go));
  }
  handOver(new Blob(parts, { type: "text/csv" }), nameOf("csv"));
}

/** What is to be seen. */
export async function savePicture(model, view, scene, charts) {
  const canvas = picture(model, view, scene, charts);
  const blob = await new Promise((done) => canvas.toBlob(done, "image/png"));
  handOver(blob, nameOf("png"));
}
