// A plain static file server.

import { createReadStream, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";

const TYPES = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript; charset=utf-8",
  ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml",
  ".wasm": "application/wasm",
};

/** Serves a folder below a path, so that absolute addresses in a page fail. */
export async function serve(folder, below = "/some/where/") {
  const asked = [];
  const server = createServer(({ url }, answer) => {
    asked.push(url);
    const { pathname } = new URL(url, "http://localhost");
    const name = pathname.startsWith(below) ? pathname.slice(below.length) || "index.html" : null;
    const path = name === null ? null : join(folder, normalize(name));
    if (path === null || !path.startsWith(folder) || !statSync(path, { throwIfNoEntry: false })?.isFile()) {
      answer.writeHead(404).end();
      return;
    }
    answer.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/plain; charset=utf-8" });
    createReadStream(path).pipe(answer);
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  // A failed test does not end it, and it does not keep the process alive.
  server.unref();
  const { port } = server.address();
  return {
    url: `http://127.0.0.1:${port}${below}`,
    /** The requested addresses. */
    asked,
    end: () =>
      new Promise((done) => {
        server.closeAllConnections();
        server.close(done);
      }),
  };
}
