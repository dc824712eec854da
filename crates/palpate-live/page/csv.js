// Table of the buffered rows.

const FORMAT = "palpate_live_1";
const ROWS_AT_ONCE = 4000;

const ABOUT_ROWS =
  "grouped 0: the row is a tick. grouped 1: the loop is faster than 1 kHz; ticks are grouped over at least 2 ms. " +
  "Each column of a row holds the minimum or maximum of its group, in the order of time; the values of a row may " +
  "belong to different instants. settings: index into the list of settings.";

/** A value as its column prints it: the fewest digits that read back to the same 32-bit number. */
export function shortest(value) {
  if (Number.isNaN(value)) {
    return "";
  }
  for (const count of [6, 7, 8]) {
    const short = Number(value.toPrecision(count));
    if (Math.fround(short) === value) {
      return String(short);
    }
  }
  return String(Number(value.toPrecision(9)));
}

/** A field of a table, in quotes where it needs them. */
export function field(text) {
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/**
 * The table, part after part: a generator, so that the page can do other things in between.
 *
 * @param {string[]} columns names with units
 * @param {{lane: number, ring: import("./ring.js").Ring}[]} lanes
 * @param {object[]} settings what the rows were rendered with
 * @param {number} settingsFrom which number rows have for the first of them
 * @param {object} about what else is to be said; goes into the first row as JSON
 */
export function* table(columns, lanes, settings, settingsFrom, about) {
  yield `lane,method,settings,grouped,t_s,${columns.map(field).join(",")},${FORMAT}\n`;
  let said = `,${field(JSON.stringify({ ...about, rows: ABOUT_ROWS, settings }))}`;
  for (const { lane, ring } of lanes) {
    for (let from = 0; from < ring.length; from += ROWS_AT_ONCE) {
      const lines = [];
      const to = Math.min(from + ROWS_AT_ONCE, ring.length);
      for (let row = from; row < to; row += 1) {
        if (ring.isGap(row)) {
          continue;
        }
        const at = ring.place(row);
        const set = ring.settings[at] - settingsFrom;
        const method = settings[set]?.lanes?.[lane]?.method ?? "";
        let line = `${lane},${method},${set},${ring.isGrouped(row) ? 1 : 0},${Number(ring.timeS[at].toFixed(9))}`;
        for (const column of ring.columns) {
          line += `,${shortest(column[at])}`;
        }
        lines.push(`${line}${said || ","}\n`);
        said = "";
      }
      yield lines.join("");
    }
  }
}
