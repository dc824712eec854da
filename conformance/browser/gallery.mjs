// Draws docs/gallery.md: a picture of each world that the page of `palpate live` can show.
//
//     npm run gallery --prefix conformance/browser
//     npm run gallery --prefix conformance/browser -- stylus pinch
//
// With names, only those are drawn.
//
// Requirements are those of the tests beside it: the program, built for release, and Chromium.

import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { endAll, startLive } from "./program.mjs";
import { closeBrowser, visit } from "./visit.mjs";

const here = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const WORLDS = here("experiments/worlds");
const PICTURES = here("docs/figures/gallery");
const SIZE = { width: 1200, height: 760 };
/** The animation stops once the tool touches something; the picture is taken at this time at the latest [s]. */
const LATEST_S = 2;

const field = (text, pattern) => pattern.exec(text)?.[1];

/** Moves each tool gradually from its start to the scene's hand position, until one touches. */
async function leadTo(open, rests) {
  const starts = await open.get(() => palpate.model.hello.world.tools.map((tool) => tool.position_m));
  for (let share = 0.05; share < 1.01; share += 0.05) {
    const to = rests.map((rest, device) => rest.map((x, axis) => starts[device][axis] + share * (x - starts[device][axis])));
    const say = (to) => to.every((position_m, device) => palpate.link.say({ type: "tool", device, position_m }));
    const isThere = (await open.get(() => palpate.space.standsStill)) || !(await open.get(say, to));
    if (isThere) {
      return;
    }
    await new Promise((go) => setTimeout(go, 25));
  }
}

// Ends all programs in any case.
process.on("exit", endAll);
const named = process.argv.slice(2);
if (named.length === 0) {
  rmSync(PICTURES, { recursive: true, force: true });
}
mkdirSync(PICTURES, { recursive: true });
const drawn = [];
const left = [];
for (const file of readdirSync(WORLDS).filter((name) => name.endsWith(".toml")).sort()) {
  const name = file.replace(/\.toml$/, "");
  const text = readFileSync(`${WORLDS}/${file}`, "utf8");
  const title = field(text, /^title = "(.*)"$/m);
  const why = reason(name, text);
  if (why) {
    left.push({ name, title, why });
    continue;
  }
  drawn.push({ name, title });
  if (named.length > 0 && !named.includes(name)) {
    continue;
  }
  const live = await startLive(`${WORLDS}/${file}`, "--device", "pointer", "--method", "coupled", "--priority", "0");
  const open = await visit(live.url, { viewport: SIZE });
  await open.until("it has begun", () => palpate.model.run !== null);
  const run = await open.get(() => {
    const { model, space } = palpate;
    const [before, take] = [model.run, space.take.bind(space)];
    space.take = (world) => {
      if (!space.standsStill) {
        take(world);
        space.standsStill = world.run !== before && space.lanes[0].felt.shown > 0;
      }
    };
    return before;
  });
  await open.page.click("#restart");
  await open.until("it has begun anew", (before) => palpate.model.run !== before, run);
  const rests = [...text.matchAll(/^rest_m = (\[.*\])$/gm)].map(([, rest]) => JSON.parse(rest));
  if (rests.length > 0) {
    await leadTo(open, rests);
  }
  const isTime = (latest) => palpate.space.standsStill || palpate.model.newestS > latest;
  await open.until(`${name} touches`, isTime, LATEST_S);
  const canvas = await open.page.$("#space");
  await canvas.screenshot({ path: `${PICTURES}/${name}.webp`, type: "webp", quality: 70 });
  await open.leave();
  await live.end();
  console.log(name);
}
await closeBrowser();

const cell = ({ name, title }) =>
  `![${name}](figures/gallery/${name}.webp)<br>**[${name}](../experiments/worlds/${name}.toml)** ${title}`;
const rows = [];
for (let i = 0; i < drawn.length; i += 2) {
  rows.push(`| ${cell(drawn[i])} | ${drawn[i + 1] ? cell(drawn[i + 1]) : ""} |`);
}
writeFileSync(
  here("docs/gallery.md"),
  `# Worlds to touch

Each of these [worlds](worlds.md) is a file in \`experiments/worlds\`. Touch one with the mouse, rendered by two methods side by
side:

\`\`\`sh
palpate live experiments/worlds/paddle.toml --device pointer --method basic,coupled
\`\`\`

The pictures are of the page that this opens, as the tool touches something or after 2 s: the tool is blue, bodies that move
are brown, arrows are the forces of contacts. \`npm run gallery --prefix conformance/browser\` draws them, and writes this
page.

| | |
|---|---|
${rows.join("\n")}

Not drawn:

| world | | why |
|---|---|---|
${left.map(({ name, title, why }) => `| [${name}](../experiments/worlds/${name}.toml) | ${title} | ${why} |`).join("\n")}
`,
);

/** Explains a missing picture of a world, if it is missing. */
function reason(name, text) {
  if (name.endsWith("-rough")) {
    return `looks like ${name.replace("-rough", "")}`;
  }
  if (/^\[\[field\]\]/m.test(text) && !/^\[\[body\]\]/m.test(text)) {
    return "has fields alone, which are not drawn";
  }
  return null;
}
