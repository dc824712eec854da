"""A square peg in a hole with a felt force, as a vectorised environment of Gymnasium.

    pip install palpate gymnasium
    python gymnasium_peg.py

Each environment has a peg of 10 mm, held by a spring and a damper to a target that the actions move, above a hole with
0.1 mm of clearance to each wall. Nothing tells where the hole is. Its world runs at 1 kHz, and an action lasts 20 ms. The
program compares two policies: one pushes down, the other one feels.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

import palpate

PERIOD = 0.001
TICKS = 20
"""Samples per action."""
DEEP = 0.015
"""Depth at which the peg is in [m]."""
MASS, INERTIA = 0.15, np.array([8e-5, 8e-5, 2e-5])
STIFFNESS, ROTATIONAL_STIFFNESS = 800.0, 0.5
DAMPING, ROTATIONAL_DAMPING = 2.0 * np.sqrt(STIFFNESS * MASS), 2.0 * np.sqrt(ROTATIONAL_STIFFNESS * INERTIA)
LARGEST_PULL = 5.0
"""Largest force of the spring along each axis [N]."""
STEP_M, STEP_RAD = 2e-4, 2e-3
"""Motion of the target by an action of 1."""

Array = NDArray[np.float64]


def hole() -> palpate.World:
    """Returns a peg above four blocks around a hole; the origin is the middle of its mouth."""
    half, far = 0.0051, 0.0251
    middle = (half + far) / 2.0
    walls = [
        {
            "name": name,
            "fixed": True,
            "position_m": position,
            "shape": {"box": {"size_m": [0.02, 0.0502, 0.03] if position[0] else [0.0502, 0.02, 0.03]}},
        }
        for name, position in [
            ("left", [-middle, 0.0, -0.015]),
            ("right", [middle, 0.0, -0.015]),
            ("front", [0.0, -middle, -0.015]),
            ("back", [0.0, middle, -0.015]),
        ]
    ]
    peg = {"name": "peg", "mass_kg": MASS, "inertia_kg_m2": INERTIA.tolist(), "tool": {"box": {"size_m": [0.01, 0.01, 0.04]}}}
    law = {"between": ["*", "*"], "stiffness_n_per_m": 2e4, "damping_n_s_per_m": 8.0, "friction": 0.05}
    return palpate.World(loop={"period_s": PERIOD}, devices=[peg], bodies=walls, contacts=[law], soft_start=0.0)


class PegInHole(VectorEnv[Array, Array, Array]):
    """Pegs above holes. An action moves the targets by up to 0.2 mm and 2 mrad along each axis.

    An observation has the displacement since the start [mm], the rotation vector [rad], and the mean felt force [N] and
    torque [N cm]. A reward is the depth that was gained [mm] minus 0.01 per newton of felt force.
    """

    def __init__(self, num_envs: int, max_steps: int = 400) -> None:
        self.num_envs, self.max_steps = num_envs, max_steps
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}
        self.single_action_space = gymnasium.spaces.Box(-1.0, 1.0, (6,), np.float64)
        self.single_observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (12,), np.float64)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.worlds = palpate.Worlds(hole(), num_envs)
        self.target, self.start, self.at, self.speed, self.felt = (np.zeros((num_envs, 6)) for _ in range(5))
        self.steps = np.zeros(num_envs, int)
        self.over = np.zeros(num_envs, bool)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        super().reset(seed=seed)
        self._start(np.ones(self.num_envs, bool))
        return self._observe(), {}

    def _start(self, chosen: NDArray[np.bool_]) -> None:
        """Puts the chosen pegs above the mouth, up to 1 mm beside its middle and tilted by up to 1 degree."""
        count = int(chosen.sum())
        starts = np.zeros((count, 6))
        starts[:, :2] = self.np_random.uniform(-1e-3, 1e-3, (count, 2))
        starts[:, 2] = 0.0205
        starts[:, 3:5] = self.np_random.uniform(-0.0175, 0.0175, (count, 2))
        self.target[chosen] = self.start[chosen] = self.at[chosen] = starts
        for array in (self.speed, self.felt):
            array[chosen] = 0.0
        self.steps[chosen] = 0
        self.worlds.reset(chosen)

    def step(self, actions: Array) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        begun = self.over.copy()
        if begun.any():
            self._start(begun)
        before = self.at[:, 2].copy()
        change = np.clip(actions, -1.0, 1.0) * ([STEP_M] * 3 + [STEP_RAD] * 3)
        sum_felt = np.zeros_like(self.felt)
        for _ in range(TICKS):
            self.target += np.where(begun[:, None], 0.0, change) / TICKS
            near = LARGEST_PULL / STIFFNESS
            self.target[:, :3] = np.clip(self.target[:, :3], self.at[:, :3] - near, self.at[:, :3] + near)
            self._move(self.worlds.step(self._poses()))
            sum_felt += self.felt
        self.felt = sum_felt / TICKS
        self.steps += ~begun
        terminated = self._depth() > DEEP
        truncated = ~terminated & (self.steps >= self.max_steps)
        self.over = terminated | truncated
        reward = 1e3 * (before - self.at[:, 2]) - 0.01 * np.linalg.norm(self.felt[:, :3], axis=1)
        return self._observe(), np.where(begun, 0.0, reward), terminated, truncated, {}

    def _move(self, felt: Array) -> None:
        """Moves the pegs by a period: spring and damper to the target, and the held wrench."""
        self.felt = felt
        pull = STIFFNESS * (self.target - self.at)[:, :3] - DAMPING * self.speed[:, :3]
        turn = ROTATIONAL_STIFFNESS * (self.target - self.at)[:, 3:] - ROTATIONAL_DAMPING * self.speed[:, 3:]
        self.speed[:, :3] += PERIOD * (pull + felt[:, :3]) / MASS
        self.speed[:, 3:] += PERIOD * (turn + felt[:, 3:]) / INERTIA
        self.at += PERIOD * self.speed

    def _poses(self) -> Array:
        """Returns position and quaternion of each peg, from its rotation vector."""
        angle = np.linalg.norm(self.at[:, 3:], axis=1, keepdims=True)
        vector = self.at[:, 3:] * 0.5 * np.sinc(0.5 * angle / np.pi)
        return np.hstack([self.at[:, :3], np.cos(0.5 * angle), vector])

    def _depth(self) -> Array:
        return 0.02 - self.at[:, 2]

    def _observe(self) -> Array:
        moved = self.at[:, :3] - self.start[:, :3]
        return np.hstack([1e3 * moved, self.at[:, 3:], self.felt[:, :3], 1e2 * self.felt[:, 3:]])


def pushes(seen: Array, step: int) -> Array:
    """Moves down."""
    return np.tile([0.0, 0.0, -0.5, 0.0, 0.0, 0.0], (len(seen), 1))


def feels(seen: Array, step: int) -> Array:
    """Searches in a spiral while the peg stands on the edge, and yields to forces and torques once it is in."""
    lateral, force, torque = seen[:, :2], seen[:, 6:9], seen[:, 9:12]
    action = np.zeros((len(seen), 6))
    # It presses with 1 N.
    action[:, 2] = np.clip(0.5 * (force[:, 2] - 1.0), -0.5, 0.5)
    # Turns at a distance of 0.15 mm, passed at constant speed.
    turn = np.sqrt(4.0 * np.pi * 0.12 * step / 0.15)
    spiral = 0.15 * turn / (2.0 * np.pi) * np.array([np.cos(turn), np.sin(turn)])
    action[:, :2] = np.clip((spiral - lateral) / (1e3 * STEP_M), -1.0, 1.0)
    is_in = seen[:, 2] < -0.8
    action[is_in, :2] = 0.3 * force[is_in, :2]
    action[:, 3:5] = 0.3 * torque[:, :2] - 5.0 * seen[:, 3:5]
    return action


def inserted(policy: Any, num_envs: int = 32, seed: int = 1) -> tuple[float, float]:
    """Returns the share of the pegs that a policy inserts, and the largest mean force of an action [N]."""
    pegs = PegInHole(num_envs)
    seen, _ = pegs.reset(seed=seed)
    done, is_in, most = np.zeros(num_envs, bool), np.zeros(num_envs, bool), 0.0
    for step in range(pegs.max_steps):
        seen, _, terminated, truncated, _ = pegs.step(policy(seen, step))
        is_in |= terminated & ~done
        most = max(most, float(np.abs(seen[~done, 6:9]).max(initial=0.0)))
        done |= terminated | truncated
        if done.all():
            break
    return float(is_in.mean()), most


if __name__ == "__main__":
    for policy in (pushes, feels):
        share, most = inserted(policy)
        print(f"a policy that {policy.__name__}: {100.0 * share:.0f} % of the pegs are in, largest force {most:.1f} N")
