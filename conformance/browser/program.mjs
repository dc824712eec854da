// The real program, started as by a user.

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

const TARGET = process.env.CARGO_TARGET_DIR ?? fileURLToPath(new URL("../../target", import.meta.url));
const PROGRAM = process.env.PALPATE ?? join(TARGET, "release/palpate");
const START_MS = 60_000;

if (!existsSync(PROGRAM)) {
  throw new Error(`${PROGRAM} is not there: cargo build --release -p palpate-cli, or say where with PALPATE`);
}

const running = new Set();

/** Ends every running program. */
export function endAll() {
  for (const child of running) {
    child.kill("SIGKILL");
  }
}

/** Starts `palpate live` with these arguments; ready once it has printed the address of its page. */
export async function startLive(...args) {
  const folder = mkdtempSync(join(tmpdir(), "palpate-browser-"));
  const listen = args.includes("--listen") ? [] : ["--listen", "127.0.0.1:0"];
  // On a loaded machine a loop waits for long, which ends it without this flag.
  const patient = args.includes("--stall-after-periods") ? [] : ["--stall-after-periods", "1000"];
  const child = spawn(PROGRAM, ["live", ...listen, ...patient, ...args], { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  running.add(child);
  child.on("exit", () => running.delete(child));
  let said = "";
  const url = await new Promise((done, failed) => {
    const timer = setTimeout(() => failed(new Error(`no address after ${START_MS / 1000} s; it said: ${said}`)), START_MS);
    const hear = (text) => {
      said += text;
      const found = /http:\/\/\S+/.exec(said);
      if (found && /\s/.test(said[found.index + found[0].length] ?? "")) {
        clearTimeout(timer);
        done(found[0]);
      }
    };
    child.stdout.setEncoding("utf8").on("data", hear);
    child.stderr.setEncoding("utf8").on("data", hear);
    child.on("exit", (code) => failed(new Error(`palpate live ended with ${code}: ${said}`)));
  });
  return {
    url,
    folder,
    address: new URL(url).host,
    said: () => said,
    /** Ends it and waits; returns the exit code, or the signal. */
    end(signal = "SIGINT") {
      return new Promise((done) => {
        if (child.exitCode !== null || child.signalCode !== null) {
          done(child.exitCode ?? child.signalCode);
          return;
        }
        child.on("exit", (code, by) => done(code ?? by));
        child.kill(signal);
      });
    },
    /**
     * Ends it, and checks its exit code. On a busy machine a loop that misses its deadlines can generate energy, and
     * safety disables the motors; or most samples come after too long a gap, and the renderer refuses them. Both are
     * reported.
     */
    async endsWell(signal) {
      const code = await this.end(signal);
      const isStopped = code === 5 && /\b[1-9]\d* deadlines missed/.test(said) && /\nerror: .*(the safety layer kept the motors off|the renderer refused the samples)/.test(said);
      assert.ok(code === 0 || isStopped, `it ended with ${code}: ${said}`);
    },
    forget() {
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** Runs another command of the program. */
export function palpate(...args) {
  const { status, stdout, stderr } = spawnSync(PROGRAM, args, { encoding: "utf8" });
  return { status, stdout, stderr };
}
