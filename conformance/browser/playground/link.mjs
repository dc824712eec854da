import assert from "node:assert/strict";
import { test } from "node:test";
import { play } from "./open.mjs";

const shown = () => {
  const { lanes, stiffness_n_per_m, mass_kg, virtual_force_n, period_s, device, hand_m } = palpate.model.state;
  return {
    methods: lanes.map(({ method, damping_n_s_per_m }) => [method, damping_n_s_per_m]),
    values: [stiffness_n_per_m, mass_kg, virtual_force_n, period_s],
    device,
    handMm: Math.round(1e3 * hand_m),
  };
};

test("the address carries what is set, and another page shows the same", async () => {
  const first = await play();
  const { open } = first;
  await open.page.select("#method-1", "hfcr");
  await open.until("it renders by hfcr", () => palpate.model.state.lanes[0].method === "hfcr");
  await open.enter('#contact [data-name="stiffness_n_per_m"] input[type="text"]', "431");
  await open.enter('#contact [data-name="period_s"] input[type="text"]', "250");
  await open.enter('#device [data-name="delay_s"] input[type="text"]', "3");
  await open.enter('#device [data-name="device_mass_kg"] input[type="text"]', "0.4");
  await open.get(() => palpate.link.say({ type: "hand", position_m: -0.007 }));
  const fragment = await open.until("the address says so", () => {
    const { hash } = location;
    return ["methods=hfcr", "stiffness_n_per_m=431", "period_s=0.004", "delay_s=0.003", "device_mass_kg=0.4", "hand_m=-0.007"].every((part) => hash.includes(part)) && hash;
  });
  const was = await open.get(shown);
  assert.deepEqual(was.values, [431, 0.1, -0.981, 0.004]);
  assert.deepEqual(was.device, { mass_kg: 0.4, delay_s: 0.003, cut_off: false });
  await first.leave();
  const second = await play(fragment);
  await second.open.until("the hand is there", () => palpate.model.state.hand_m < -0.006);
  assert.deepEqual(await second.open.get(shown), was);
  assert.equal(await second.open.get(() => location.hash), fragment);
  await second.leave();
});

test("a link that is entered while the page is open counts", async () => {
  const { open, leave } = await play();
  await open.get(() => {
    location.hash = "#mass_kg=wall&stiffness_n_per_m=900";
  });
  await open.until("a wall is rendered", () => palpate.model.state.mass_kg === null && palpate.model.state.stiffness_n_per_m === 900);
  await leave();
});

test("what a link says wrongly is said, and nothing else is lost", async () => {
  const { open, leave } = await play("#mass_kg=heavy&stiffness_n_per_m=700&colour=red");
  const text = await open.get(() => document.querySelector("#banners").textContent);
  assert.match(text, /mass_kg is “heavy”, and has to be a number; “colour” is not a setting/);
  await open.until("the rest counts", () => palpate.model.state.stiffness_n_per_m === 700);
  await leave();
});

test("a value that no page takes is refused with what is allowed", async () => {
  const { open, leave } = await play("#stiffness_n_per_m=1e9&methods=basic,nothing");
  await open.until("it is said", () => /allowed|unknown|did you mean|nothing/.test(document.body.textContent) && palpate.model.state.stiffness_n_per_m === 600);
  await leave();
});

test("a world that is not there is said, and one contact is shown instead", async () => {
  const { open, leave } = await play("#world=nowhere", { wait: true });
  await open.until("it is said", () => document.querySelector("#banners").textContent.includes("“nowhere”"));
  await leave(/404/);
});
