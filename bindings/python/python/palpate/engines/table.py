"""What an engine's own contacts make of a scene, and what palpate's make of it with the same engine.

    python -m palpate.engines.table                 # needs palpate[mujoco]
    python -m palpate.engines.table --steps 1,4,10 --integrators RK4,Euler --told 1,1.5

A device with three masses, in a hand with spring and damper, is simulated exactly outside the engine. Each force is
held for a period, and judged by the mean force of the ideal over each period: E is the error, and FRE over the hold
floor says how far the held force is from the best that a held force can be. The ideal is `palpate simulate`'s: device,
bodies and contacts in continuous time, computed by code that shares nothing with the renderer. The engine's floor is
set up as the same spring and damper.

- engine: MuJoCo's contact of the tool, a spring of the same stiffness, with the device held where it was sampled; the
  mean of its force over the steps of the period.
- engine, tuned: the damping that gives the least E of this scene, found with knowledge of its ideal, and the tool held
  as it was sampled or moved on by its last velocity, whichever gives less.
- palpate: `palpate.engines.mujoco.Contact`.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from typing import Any, NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from .._report import WorldRuns
from .._scene import simulate
from .._world import World
from ._device import SimulatedDevice
from .mujoco import Contact

# After it, which says how to get MuJoCo where it is not there.
import mujoco  # noqa: E402  isort: skip

BODY_MASS = 0.1
DEVICE_MASS = (0.1, 0.16, 0.25)
HAND = (60.0, 1.5)
GRAVITY = 9.81
DURATION = 0.4
RATES = ((0.01, 400.0), (0.004, 1500.0), (0.001, 4000.0))
"""Periods [s], each with a stiffness [N/m]."""
DAMPING_RATIOS = (0.0, *(0.02 * 1.25**step for step in range(17)))
"""Damping ratios of the engine's contact that are tried."""


class Scene(NamedTuple):
    """A scene, as the judge has it and as the engine has it."""

    name: str
    world: World
    xml: str
    """A model of MuJoCo, with {h}, {integrator} and {damping} to be filled in."""
    tool_radius: float
    start: tuple[float, float, float]
    hand_force: tuple[float, float, float]
    rest: tuple[float, float, float]
    stiffness: float
    period: float

    def model(self, steps: int, integrator: str, damping: float = 0.0) -> mujoco.MjModel:
        """The engine's model; `damping` is that of the engine's own contact of the tool [N s/m]."""
        rate = -(damping / BODY_MASS + 1e-9)
        return mujoco.MjModel.from_xml_string(self.xml.format(h=self.period / steps, integrator=integrator, damping=rate))

    def device(self) -> SimulatedDevice:
        """The device in its hand."""
        return SimulatedDevice(DEVICE_MASS, self.start, *HAND, self.rest, self.hand_force, self.period)


def _spring(stiffness: float, damping: str, shares: int = 1) -> str:
    """MuJoCo's contact as a spring and a damper between a body of BODY_MASS and what is fixed: an impedance near 0
    takes the inertia out of its law."""
    return f'solref="{-stiffness / BODY_MASS / shares} {damping}" solimp="1e-4 1e-4 0.001 0.5 2"'


def scenes(period: float, stiffness: float) -> list[Scene]:
    """The scenes at a period [s], with this stiffness of the tool's contact [N/m]."""
    floor_stiffness = 2 * stiffness
    floor_damping = 0.3 * math.sqrt(floor_stiffness * BODY_MASS)
    resting = 0.02 - GRAVITY * BODY_MASS / floor_stiffness
    made = []
    for name, place, radius, start, hand, shape in [
        ("ball", (0.002, -0.001, 0.075), 0.04, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), "sphere"),
        ("ball on floor", (0.0, 0.0, resting), 0.01, (0.003, 0.001, resting + 0.032), (0.0, 0.0, -2.0), "sphere"),
        ("box on floor", (0.0, 0.0, resting), 0.01, (0.003, 0.001, resting + 0.032), (0.0, 0.0, -2.0), "box"),
    ]:
        bodies: list[dict[str, Any]] = [
            {
                "name": "body",
                "mass_kg": BODY_MASS,
                "position_m": place,
                "force_n": (0.0, 0.0, -GRAVITY * BODY_MASS),
                "shape": {"sphere": {"radius_m": 0.02}} if shape == "sphere" else {"box": {"size_m": (0.04,) * 3}},
            }
        ]
        contacts: list[dict[str, Any]] = [{"between": ("tool", "body"), "stiffness_n_per_m": stiffness}]
        floor = ""
        if name != "ball":
            bodies.append({"name": "floor", "fixed": True, "shape": {"half_space": {"normal": (0, 0, 1), "offset_m": 0.0}}})
            contacts.append(
                {"between": ("body", "floor"), "stiffness_n_per_m": floor_stiffness, "damping_n_s_per_m": floor_damping}
            )
            # The engine has a contact at each corner of a box that lies flat.
            shares = 4 if shape == "box" else 1
            law = _spring(floor_stiffness, str(-floor_damping / BODY_MASS / shares), shares)
            floor = f'<geom type="plane" size="1 1 1" contype="0" conaffinity="1" condim="1" priority="1" {law}/>'
        rest = (start[0], start[1], start[2])
        world = World(
            title=name,
            loop={"period_s": period},
            devices=[
                {
                    "name": "tool",
                    "mass_kg": DEVICE_MASS,
                    "position_m": start,
                    "hand_force_n": hand,
                    "hand_stiffness_n_per_m": HAND[0],
                    "hand_damping_n_s_per_m": HAND[1],
                    "hand_rest_m": rest,
                    "tool": {"sphere": {"radius_m": radius}},
                }
            ],
            bodies=bodies,
            contacts=contacts,
            measure={"duration_s": DURATION},
        )
        size = "0.02" if shape == "sphere" else "0.02 0.02 0.02"
        where = " ".join(map(str, place))
        xml = (
            f'<mujoco><option timestep="{{h}}" integrator="{{integrator}}" gravity="0 0 {-GRAVITY}"><flag eulerdamp='
            f'"disable"/></option><worldbody>{floor}<body name="body" pos="{where}"><freejoint/><geom type="{shape}" '
            f'size="{size}" mass="{BODY_MASS}" condim="1" contype="1" conaffinity="2"/></body><body mocap="true"><geom '
            f'name="tool" type="sphere" size="{radius}" contype="2" conaffinity="0" condim="1" priority="2" '
            f'{_spring(stiffness, "{damping}")}/></body></worldbody></mujoco>'
        )
        made.append(Scene(name, world, xml, radius, start, hand, rest, stiffness, period))
    return made


class Row(NamedTuple):
    """What one way of rendering made of a scene."""

    scene: str
    period_s: float
    stiffness_n_per_m: float
    way: str
    steps: int
    integrator: str
    mean_force_error_percent: float
    error_over_floor: float
    microseconds_per_step: float
    """Median of what a step of the engine costs, with the contact, from Python."""
    setting: str


def judged(forces: NDArray[np.float64], ideal: WorldRuns) -> tuple[float, float]:
    """E [%] and FRE over the hold floor of the forces that were held on the device, a row for each period."""
    floor = ideal["methods"][0].sum.hold_floor_percent / 100
    weight = 1 / np.array(DEVICE_MASS)
    means = ideal.ideal[0]
    off = np.sum((forces - means) ** 2 * weight) / np.sum(means**2 * weight)
    error = math.sqrt(off * (1 - floor**2)) if np.isfinite(off) else math.inf
    return 100 * error, math.hypot(error, floor) / floor


def with_engine(
    scene: Scene, steps: int, integrator: str, damping: float, samples: int, moves: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Forces of the engine's own contact, and the time of a step [s]. `moves`: over a period the tool goes on as it did
    over the last."""
    model = scene.model(steps, integrator, damping)
    data = mujoco.MjData(model)
    device = scene.device()
    tool = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "tool")
    forces, times, wrench = np.zeros((samples, 3)), [], np.zeros(6)
    last = device.position
    for sample in range(samples):
        begin = time.perf_counter()
        way = device.position - last if moves else np.zeros(3)
        last = device.position
        for step in range(steps):
            data.mocap_pos[0] = device.position + way * (step / steps)
            mujoco.mj_step(model, data)
            for number, contact in enumerate(data.contact[: data.ncon]):
                if tool in contact.geom:
                    mujoco.mj_contactForce(model, data, number, wrench)
                    # The contact's x axis points from the first geom to the second, which is pushed along it.
                    sign = 1.0 if contact.geom[1] == tool else -1.0
                    forces[sample] += sign * contact.frame[:3] * wrench[0] / steps
        times.append(time.perf_counter() - begin)
        device.hold(forces[sample])
        if not np.abs(device.position).max() < 1e3:
            forces[sample:] = math.inf
            break
    return forces, float(np.median(times)) / steps


def with_palpate(scene: Scene, steps: int, integrator: str, told: float, samples: int) -> tuple[NDArray[np.float64], float]:
    """Forces of palpate's contact in the same engine, and the time of a step [s]. `told` is the mass of the device as
    palpate is told, over the true one."""
    model = scene.model(steps, integrator)
    contact = Contact(
        model,
        mujoco.MjData(model),
        tool="tool",
        bodies=["body"],
        stiffness=scene.stiffness,
        device_mass=told * np.array(DEVICE_MASS),
        period=scene.period,
        force_limit=math.inf,
        soft_start=0,
    )
    device = scene.device()
    forces, times = np.zeros((samples, 3)), []
    for sample in range(samples):
        begin = time.perf_counter()
        forces[sample] = contact.step(device.position)
        times.append(time.perf_counter() - begin)
        device.hold(forces[sample])
    return forces, float(np.median(times)) / steps


def rows(steps: Sequence[int], integrators: Sequence[str], told: Sequence[float]) -> list[Row]:
    """Every row of the table."""
    made = []
    for period, stiffness in RATES:
        for scene in scenes(period, stiffness):
            ideal = simulate(scene.world)
            samples = ideal.ideal.shape[1]
            for count in steps:
                for integrator in integrators:

                    def row(way: str, found: tuple[NDArray[np.float64], float], setting: str) -> Row:
                        error, over = judged(found[0], ideal)
                        where = (scene.name, period, stiffness, way, count, integrator)
                        return Row(*where, error, over, 1e6 * found[1], setting)

                    made.append(row("engine", with_engine(scene, count, integrator, 0.0, samples), ""))
                    critical = 2 * math.sqrt(stiffness * BODY_MASS)
                    tuned = [
                        row(
                            "engine, tuned",
                            with_engine(scene, count, integrator, ratio * critical, samples, moves),
                            f"damping ratio {ratio:.2f}" + (", tool moved on" if moves else ""),
                        )
                        for ratio in DAMPING_RATIOS
                        for moves in (False, True)
                    ]
                    made.append(min(tuned, key=lambda row: row.mean_force_error_percent))
                    for factor in told:
                        setting = "" if factor == 1 else f"told {factor:g} times the mass"
                        made.append(row("palpate", with_palpate(scene, count, integrator, factor, samples), setting))
    return made


def main() -> None:
    """Prints the table."""

    def several(kind: Any) -> Any:
        return lambda text: [kind(part) for part in text.split(",")]

    parser = argparse.ArgumentParser(prog="python -m palpate.engines.table", description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--steps", type=several(int), default=[4], help="steps of the engine in a period (4)")
    parser.add_argument("--integrators", type=several(str), default=["RK4"], help="of the engine: RK4, Euler, implicitfast (RK4)")
    parser.add_argument("--told", type=several(float), default=[1.0, 1.5], help="told mass over the true one (1,1.5)")
    parser.add_argument("--json", action="store_true", help="rows as JSON")
    given = parser.parse_args()
    found = rows(given.steps, given.integrators, given.told)
    if given.json:
        print(json.dumps([row._asdict() for row in found], indent=2))
        return
    print(f"MuJoCo {mujoco.__version__}; E in percent; us: time of a step of the engine with its contact, from Python\n")
    print("| scene | T ms | K N/m | steps | integrator | contact | E % | FRE/floor | us | |")
    print("|---|---:|---:|---:|---|---|---:|---:|---:|---|")
    for row in found:
        numbers = f"{row.mean_force_error_percent:.2f} | {row.error_over_floor:.2f} | {row.microseconds_per_step:.0f}"
        print(
            f"| {row.scene} | {1000 * row.period_s:g} | {row.stiffness_n_per_m:g} | {row.steps} | {row.integrator} | {row.way} | "
            f"{numbers} | {row.setting} |"
        )


if __name__ == "__main__":
    main()
