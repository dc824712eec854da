// Reads a comma-separated table (RFC 4180).

/** @returns {{header: string[], rows: string[][]}} */
export function parse(text) {
  const lines = [];
  let line = [];
  let field = "";
  let quoted = false;
  for (let i = 0; i < text.length; i += 1) {
    const c = text[i];
    if (quoted) {
      if (c === '"' && text[i + 1] === '"') {
        field += c;
        i += 1;
      } else if (c === '"') {
        quoted = false;
      } else {
        field += c;
      }
    } else if (c === '"') {
      quoted = true;
    } else if (c === "," || c === "\n") {
      line.push(field);
      field = "";
      if (c === "\n") {
        lines.push(line);
        line = [];
      }
    } else {
      field += c;
    }
  }
  const [header, ...rows] = lines;
  if (rows.some((row) => row.length !== header.length)) {
    throw new Error("a line has another number of fields than the first");
  }
  return { header, rows };
}
