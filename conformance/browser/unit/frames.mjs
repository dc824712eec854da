// Frames in the server's format, for tests.

/** Bytes of a frame of samples; `rows` are lists of values, `times` their seconds. */
export function frameOf({ lane = 0, number = 0, run = 1, times, rows, kind = 1, columns = rows[0]?.length ?? 1 }) {
  const bytes = new ArrayBuffer(24 + 4 * times.length * (1 + columns));
  const view = new DataView(bytes);
  view.setUint8(0, kind);
  view.setUint8(1, lane);
  view.setUint16(2, columns, true);
  view.setUint32(4, times.length, true);
  view.setUint32(8, number, true);
  view.setUint32(12, run, true);
  view.setFloat64(16, times[0] ?? 0, true);
  times.forEach((time, row) => {
    view.setFloat32(24 + 4 * row, time - times[0], true);
    for (let column = 0; column < columns; column += 1) {
      view.setFloat32(24 + 4 * (times.length * (1 + column) + row), rows[row][column], true);
    }
  });
  return bytes;
}
