"""A loop at 1 kHz renders a ball of an engine at 60 Hz; the hand pushes the ball away.

    python low_rate_simulator.py

The device is simulated, and this program moves its hand. `Ball` stands for a physics engine.
"""

from __future__ import annotations

import time

import numpy as np
import palpate
from palpate.engines import SlowContact, LowRateSimulator, body_row

RATE = 60.0
TOOL = 0.01


class Ball:
    """Ball that only the tool moves."""

    MASS, RADIUS = 0.1, 0.03

    def __init__(self) -> None:
        self.place, self.velocity = np.array([0.045, 0.0, 0.0]), np.zeros(3)

    def step(self, wrench: np.ndarray, h: float) -> None:
        """Advances the ball by `h` [s] under a held wrench."""
        acceleration = wrench[:3] / self.MASS
        self.place = self.place + h * self.velocity + 0.5 * h * h * acceleration
        self.velocity = self.velocity + h * acceleration

    def row(self) -> np.ndarray:
        moment = 0.4 * self.MASS * self.RADIUS**2
        mobility = np.diag([1 / self.MASS] * 3 + [1 / moment] * 3)
        return body_row(self.place, [1, 0, 0, 0], self.velocity, [0, 0, 0], [0, 0, 0], [0, 0, 0], mobility)

    def contact(self, tool: np.ndarray) -> SlowContact:
        """Returns the potential contact of the tool: the point of the ball nearest to the tool."""
        normal = (tool - self.place) / np.linalg.norm(tool - self.place)
        return SlowContact(self.place + self.RADIUS * normal, normal, stiffness=1500.0, on=0, curvature=1 / self.RADIUS)


def device() -> palpate.devices.PointerInWorld:
    """Creates a device of 0.25 kg at the origin; a real device needs no world."""
    tool = {"name": "tool", "mass_kg": 0.25, "tool": {"sphere": {"radius_m": TOOL}}}
    floor = {"name": "floor", "fixed": True, "shape": {"half_space": {"normal": [0, 0, 1], "offset_m": -1.0}}}
    contact = {"between": ["tool", "floor"], "stiffness_n_per_m": 1500.0}
    world = palpate.World(loop={"period_s": 0.001}, devices=[tool], bodies=[floor], contacts=[contact])
    return palpate.devices.PointerInWorld(world)


def main() -> Ball:
    """Pushes the ball until it is 10 cm away, for a minute at most."""
    ball, hand = Ball(), device()
    host = LowRateSimulator(period=0.001, device_mass=0.25, tool_radius=TOOL, bodies=1, contacts=1)
    with palpate.Loop(hand, host):
        before = host.progress
        hand.move_to([0.03, 0.0, 0.0])
        for _ in range(round(60.0 * RATE)):
            if ball.place[0] > 0.1:
                break
            now = host.progress
            ball.step(now.wrench_since(before, 0), now.time_since(before))
            host.publish(now, [ball.row()], [ball.contact(now.position)])
            before = now
            time.sleep(1 / RATE)
    print(f"impulse on the ball {1e3 * before.impulses[0].linear[0]:.1f} mN s, velocity {ball.velocity[0]:.2f} m/s")
    return ball


if __name__ == "__main__":
    main()
