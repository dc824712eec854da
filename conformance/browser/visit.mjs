// A browser, and visits to the page in it.

import { existsSync } from "node:fs";
import puppeteer from "puppeteer-core";

const CHROMIUM = process.env.CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);
// Timeout of a wait; on a machine with many builds a wait may be long.
const PATIENCE_MS = 60_000;

let browser = null;

async function launch() {
  if (!CHROMIUM) {
    throw new Error("no Chromium: apt-get install chromium, or say where with CHROMIUM");
  }
  browser ??= await puppeteer.launch({
    executablePath: CHROMIUM,
    // The tests may run as root, and in containers with little shared memory.
    // The page of a world draws by WebGL, possibly without a graphics processor.
    args: [
      "--no-sandbox",
      "--disable-dev-shm-usage",
      "--force-color-profile=srgb",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
    ],
  });
  return browser;
}

export async function closeBrowser() {
  await browser?.close();
  browser = null;
}

/** Opens a separate page for a document other than the page of `palpate live`. */
export async function openPage(url, viewport) {
  const page = await (await launch()).newPage();
  await page.setViewport(viewport);
  await page.goto(url);
  return page;
}

export const WIDE = { width: 1400, height: 900 };
export const NARROW = { width: 360, height: 740, isMobile: true, hasTouch: true, deviceScaleFactor: 2 };

/** Opens the page in a new window, and waits for curves. `first` runs in the page before the page's own scripts. */
export async function visit(url, { viewport = WIDE, scheme = "light", motion = "no-preference", wait = true, first = () => {} } = {}) {
  const context = await (await launch()).createBrowserContext();
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warn") {
      errors.push(message.text());
    }
  });
  page.on("pageerror", (error) => errors.push(String(error.stack ?? error)));
  await page.evaluateOnNewDocument(() => {
    globalThis.violations = [];
    addEventListener("securitypolicyviolation", (event) => globalThis.violations.push(event.violatedDirective));
  });
  await page.evaluateOnNewDocument(first);
  await page.setViewport(viewport);
  await page.emulateMediaFeatures([
    { name: "prefers-color-scheme", value: scheme },
    { name: "prefers-reduced-motion", value: motion },
  ]);
  const response = await page.goto(url);
  const open = new Visit(page, context, errors, response);
  if (wait) {
    await open.until("curves have come", () => palpate.model.lanes.length > 0 && palpate.model.newestS > 0.1);
  }
  return open;
}

export class Visit {
  constructor(page, context, errors, response) {
    Object.assign(this, { page, context, errors, response });
  }

  /** Evaluates an expression in the page; the page's own state is `palpate`. */
  get(expression, ...args) {
    return this.page.evaluate(expression, ...args);
  }

  /** Waits until a condition holds; returns its value. */
  async until(what, condition, ...args) {
    const end = Date.now() + PATIENCE_MS;
    for (;;) {
      const is = await this.get(condition, ...args);
      if (is) {
        return is;
      }
      if (Date.now() > end) {
        const state = await this.get(() => JSON.stringify(palpate.model.state));
        throw new Error(`after ${PATIENCE_MS / 1000} s not yet: ${what}; state ${state}; errors ${this.errors.join(" | ")}`);
      }
      await new Promise((go) => setTimeout(go, 40));
    }
  }

  /** Waits until the loop has advanced by this many seconds. */
  async pass(seconds) {
    const from = await this.get(() => palpate.model.newestS);
    await this.until(`${seconds} s have passed`, (to) => palpate.model.newestS >= to, from + seconds);
  }

  /** Waits for the next status; returns it with the number of rows of each rendering by then. */
  async nextStatus() {
    const wait = () =>
      new Promise((resolve) => {
        const { model } = palpate;
        const hear = () => resolve({ lanes: model.status.lanes, rows: model.lanes.map(({ ring }) => ring.length) });
        model.addEventListener("status", hear, { once: true });
      });
    return this.get(wait);
  }

  /** Enters a text into a field, as by a person. */
  async enter(selector, text) {
    await this.page.click(selector, { count: 3 });
    await this.page.keyboard.type(text);
    await this.page.keyboard.press("Enter");
  }

  /** Mean, spread (greatest less least) and number of a column of a rendering over the last seconds. */
  over(lane, column, seconds) {
    return this.get(
      (lane, column, seconds) => {
        const { ring } = palpate.model.lanes[lane];
        const at = palpate.model.column(column);
        const values = [];
        for (let row = ring.rowAt(ring.lastS - seconds) + 1; row < ring.length; row += 1) {
          const value = ring.value(at, row);
          if (!Number.isNaN(value)) {
            values.push(value);
          }
        }
        const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
        return { mean, spread: Math.max(...values) - Math.min(...values), count: values.length };
      },
      lane,
      column,
      seconds,
    );
  }

  /** Returns the centre of an element on the screen. */
  async middle(selector) {
    const element = await this.page.$(selector);
    const { x, y, width, height } = await element.boundingBox();
    return { x: x + width / 2, y: y + height / 2, width, height, left: x, top: y };
  }

  /** Ends the visit; errors of the page since its start are failures, except for expected ones. */
  async leave(expected = /^$/) {
    const violations = await this.get(() => globalThis.violations);
    await this.context.close();
    const wrong = [...this.errors.filter((error) => !expected.test(error)), ...violations];
    if (wrong.length > 0) {
      throw new Error(`the page has reported: ${wrong.join(" | ")}`);
    }
  }
}
