#!/usr/bin/env python3
"""Measures a spring contact of MuJoCo on the paper's scenes: FRE in percent, as in docs/results/other-engines.md.

    scripts/mujoco_discrete.py                            the integrator `discrete`, ten steps per sample
    scripts/mujoco_discrete.py --steps 1 --integrator RK4

Needs Python 3.11 with mujoco (4.0 for `discrete`) and numpy. The engine simulates object and contact. The device is a
point mass outside it, integrated exactly under the mean force of the steps of the last period. Its plate moves on with
the mean velocity of the last period, or stays at the sample with `--still`.
"""

import argparse
import math
import tomllib
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
FINE = 200  # points of the ideal in a period
MODEL = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="{integrator}" iterations="200" tolerance="1e-14"/>
  <default><geom condim="1" solref="{spring} -1e-9" solimp="1e-4 1e-4 0.001 0.5 2"/></default>
  <worldbody>
    <body mocap="true"><geom type="box" size="1 1 0.5" pos="0 0 -0.5"/></body>
    <body pos="0 0 {height}"><joint type="slide" axis="0 0 1"/><geom type="sphere" size="0.01" mass="{mass}"/></body>
  </worldbody>
</mujoco>"""


class Scene:
    def __init__(self, name):
        tables = tomllib.loads((ROOT / f"experiments/{name}.toml").read_text())
        device, body = tables["device"][0], tables["body"][0]
        self.stiffness = tables["contact"][0]["stiffness_n_per_m"]
        self.period, self.collisions = tables["loop"]["period_s"], tables["measure"]["collisions"]
        self.device_mass, self.push = device["mass_kg"], device["hand"]["force_n"][0]
        self.mass, self.weight, self.height = body["mass_kg"], body["force_n"][0], body["position_m"][0]

    def advanced(self, state, time, touches):
        """Device and object `time` later, without a change of contact: x, v, y, w."""
        x, v, y, w = state
        a, b = self.push / self.device_mass, self.weight / self.mass
        if not touches:
            return x + v * time + a * time**2 / 2, v + a * time, y + w * time + b * time**2 / 2, w + b * time
        total = self.device_mass + self.mass
        omega = math.sqrt(self.stiffness * (1 / self.device_mass + 1 / self.mass))
        rest, cos, sin = (a - b) / omega**2, math.cos(omega * time), math.sin(omega * time)
        off, rate = x - y - rest, v - w
        depth, rate = rest + off * cos + rate / omega * sin, rate * cos - off * omega * sin
        shared = (self.push + self.weight) / total
        velocity = (self.device_mass * v + self.mass * w) / total
        place = (self.device_mass * x + self.mass * y) / total + velocity * time + shared * time**2 / 2
        velocity += shared * time
        ours, theirs = self.mass / total, self.device_mass / total
        return place + ours * depth, velocity + ours * rate, place - theirs * depth, velocity - theirs * rate

    def ideal(self):
        """Force of the ideal at FINE points of each period, up to the period in which the last collision ends [N]."""
        state, touches, ended, forces = (0.0, 0.0, self.height, 0.0), False, 0, [0.0]
        time = self.period / FINE
        while ended < self.collisions or len(forces) % FINE != 1:
            after = self.advanced(state, time, touches)
            if (after[0] > after[2]) != touches:
                begin, end = 0.0, time
                for _ in range(60):
                    middle = (begin + end) / 2
                    there = self.advanced(state, middle, touches)
                    begin, end = (begin, middle) if (there[0] > there[2]) != touches else (middle, end)
                ended += touches
                touches = not touches
                after = self.advanced(self.advanced(state, end, not touches), time - end, touches)
            state = after
            forces.append(self.stiffness * (state[0] - state[2]) if touches else 0.0)
        return np.array(forces)

    def rendered(self, periods, steps, integrator, is_still):
        """Held force of each period [N]."""
        words = {"step": self.period / steps, "integrator": integrator, "spring": -self.stiffness / self.mass}
        text = MODEL.format(**words, height=self.height + 0.01, mass=self.mass)
        model = mujoco.MjModel.from_xml_string(text)
        data, (x, v), before, forces = mujoco.MjData(model), (0.0, 0.0), 0.0, []
        for _ in range(periods):
            moved, before, impulse = 0.0 if is_still else x - before, x, 0.0
            for step in range(steps):
                data.mocap_pos[0, 2] = x + moved * step / steps
                data.qfrc_applied[0] = self.weight
                mujoco.mj_step(model, data)
                impulse += data.qfrc_constraint[0]
            forces.append(impulse / steps)
            gained = (self.push - forces[-1]) / self.device_mass * self.period
            x, v = x + (v + gained / 2) * self.period, v + gained
        return np.array(forces)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--integrator", default="discrete")
    parser.add_argument("--still", action="store_true")
    arguments = parser.parse_args()
    print(f"MuJoCo {mujoco.__version__}, {arguments.integrator}, {arguments.steps} steps per sample")
    for name in ("fig2", "experiment1", "experiment2"):
        scene = Scene(name)
        ideal = scene.ideal()
        means = 0.5 * (ideal[1:] + ideal[:-1])

        def error(held):
            off = np.repeat(held, FINE) - means
            return 100 * math.sqrt((off @ off) / (means @ means))

        periods = len(means) // FINE
        bound = error(means.reshape(periods, FINE).mean(axis=1))
        found = error(scene.rendered(periods, arguments.steps, arguments.integrator, arguments.still))
        print(f"{name}: FRE {found:.1f}, hold bound {bound:.1f}")


if __name__ == "__main__":
    main()
