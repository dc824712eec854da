import assert from "node:assert/strict";
import { test } from "node:test";
import { Axis } from "../../../crates/palpate-live/page/axis.js";
import { Hand } from "../../../crates/palpate-live/page/hand.js";

/** A drag target without a browser. */
class Place extends EventTarget {
  attributes = new Map();
  classList = { add() {}, remove() {} };

  setPointerCapture() {}

  focus() {}

  getAttribute(name) {
    return this.attributes.get(name) ?? null;
  }

  setAttribute(name, value) {
    this.attributes.set(name, value);
  }

  does(kind, how) {
    this.dispatchEvent(Object.assign(new Event(kind), { button: 0, pointerId: 1, shiftKey: false, ...how }));
  }
}

/** A hand without a user, and a device at this position [m], both in view. */
function apart(deviceM) {
  const axis = new Axis([-0.05, 0.05]);
  axis.lay(0, 400);
  axis.include([deviceM], 1);
  const scene = { axis, ledM: null, handM: null };
  const model = { hello: { device: { pointer: true } }, newest: () => deviceM };
  const place = new Place();
  const sent = [];
  const hand = new Hand(place, scene, model, (message) => sent.push(message));
  return { hand, place, scene, sent };
}

test("keys that are pressed faster than the server answers add up", () => {
  const { hand, place, scene, sent } = apart(0);
  scene.handM = 0.01;
  for (const key of ["ArrowUp", "ArrowUp", "ArrowUp", "PageDown"]) {
    place.does("keydown", { key });
  }
  hand.flush();
  assert.equal(sent.length, 1);
  assert.ok(Math.abs(sent[0].position_m - 0.003) < 1e-12);
});

for (const deviceM of [1.7, -1.7]) {
  const end = Math.sign(deviceM);

  test(`a device at ${deviceM} m can be taken by dragging: what is said stays within 1 m`, () => {
    const { hand, place, scene, sent } = apart(deviceM);
    place.does("pointerdown", { clientY: 200 });
    hand.flush();
    assert.deepEqual(sent.at(-1), { type: "hand", position_m: end });
    // Towards 0 it follows at once, from its grasp position.
    place.does("pointermove", { clientY: 200 + 40 * end });
    hand.flush();
    const wanted = end - (40 * end) / scene.axis.pxPerM;
    assert.ok(Math.abs(sent.at(-1).position_m - wanted) < 1e-12);
    place.does("pointermove", { clientY: 200 - 4000 * end });
    hand.flush();
    assert.equal(sent.at(-1).position_m, end);
  });

  test(`a device at ${deviceM} m can be taken by keys, and the slider says how far it goes`, () => {
    const { hand, place, sent } = apart(deviceM);
    for (const key of ["ArrowUp", "ArrowDown", "PageUp", "PageDown", end > 0 ? "End" : "Home"]) {
      place.does("keydown", { key });
      hand.flush();
      assert.ok(Math.abs(sent.at(-1).position_m) <= 1, `${key}: ${sent.at(-1).position_m}`);
    }
    assert.equal(sent.at(-1).position_m, end);
    hand.describe();
    assert.equal(place.getAttribute(end > 0 ? "aria-valuemax" : "aria-valuemin"), (end * 1000).toFixed(1));
  });
}
