import assert from "node:assert/strict";
import { test } from "node:test";
import { across, outside } from "../../../crates/palpate-live/page/space.js";

const HALF = 0.4;
const plane = (normal) => ({ shape: { half_space: { normal, offset_m: 0 } }, orientation: [1, 0, 0, 0] });
const tool = (...position_m) => ({ position_m });

test("tools beside each other are looked at across, one alone from where one always looks", () => {
  assert.equal(across([tool(0, 0, 0)]), -2.1);
  assert.ok(Math.abs(across([tool(-0.02, 0, 0), tool(0.02, 0, 0)]) + Math.PI / 2) < 1e-12);
});

test("a groove is looked at along its walls, from outside of both", () => {
  const steep = [plane([-Math.sqrt(0.75), 0, 0.5]), plane([Math.sqrt(0.75), 0, 0.5])];
  const angle = outside(steep, -2.1, HALF);
  assert.ok(Math.abs(angle + Math.PI / 2) < 0.3, `${angle}`);
  // A wall that is turned with its body.
  const turned = { ...plane([0, 0, 1]), orientation: [Math.SQRT1_2, Math.SQRT1_2, 0, 0] };
  assert.ok(Math.sin(outside([turned], 2.1, HALF)) < -0.1);
});

test("what is seen already is looked at from where one always looks, and so is a hole that nobody can look into from outside", () => {
  assert.equal(outside([plane([0, 0, 1])], -2.1, HALF), -2.1);
  assert.equal(outside([], -2.1, HALF), -2.1);
  const walls = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]].map(plane);
  assert.equal(outside(walls, -2.1, HALF), -2.1);
});
