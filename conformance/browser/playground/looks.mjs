import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { WIDE } from "../visit.mjs";
import { play } from "./open.mjs";

const FOLDER = process.env.PALPATE_SCREENSHOTS;
const PHONE = { width: 390, height: 844, isMobile: true, hasTouch: true, deviceScaleFactor: 2 };

for (const [name, viewport] of [["wide", WIDE], ["phone", PHONE]]) {
  for (const scheme of ["light", "dark"]) {
    for (const [what, fragment] of [["contact", "#stiffness_n_per_m=200&mass_kg=0.05&virtual_force_n=-0.4905&period_s=0.02"], ["world", "#world=pinch"]]) {
      test(`${what}, ${name} and ${scheme}: everything fits, and is drawn in the scheme's colours`, async () => {
        const { open, leave } = await play(fragment, { viewport, scheme });
        await open.until("it runs", (what) => (what === "world" ? palpate.worlds.now?.t_s > 0.5 : palpate.model.newestS > 2.2), what);
        const { across, panel, canvases } = await open.get(() => ({
          across: document.scrollingElement.scrollWidth - document.documentElement.clientWidth,
          panel: getComputedStyle(document.querySelector("header")).backgroundColor,
          canvases: [...document.querySelectorAll("canvas")].filter((canvas) => canvas.checkVisibility()).map(({ clientWidth, clientHeight }) => [clientWidth, clientHeight]),
        }));
        assert.equal(across, 0, "nothing sticks out");
        assert.equal(Number(/\d+/.exec(panel)[0]) < 128, scheme === "dark");
        assert.ok(canvases.length >= 2 && canvases.every(([width, height]) => width > 120 && height > 60), JSON.stringify(canvases));
        if (FOLDER) {
          mkdirSync(FOLDER, { recursive: true });
          await open.page.screenshot({ path: join(FOLDER, `playground-${what}-${name}-${scheme}.png`), fullPage: name === "phone" });
        }
        await leave();
      });
    }
  }
}
