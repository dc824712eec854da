"""Compares an engine's own contacts with those of palpate in the same engine.

    python -m palpate.engines.table                    # needs palpate[mujoco]
    python -m palpate.engines.table --engine pybullet  # needs palpate[pybullet]
    python -m palpate.engines.table --engine drake     # needs palpate[drake]
    python -m palpate.engines.table --steps 1,4,10 --integrators RK4,Euler --model-mass-factor 1,1.5

A device with three masses, in a hand with spring and damper, is simulated exactly outside the engine. Each force is
held for a period and evaluated against the mean force of the reference solution over the period. E is the error. FRE
over the zero-order-hold bound compares the held force with the best possible held force. The reference solution is that
of `palpate simulate`: device, bodies and contacts in continuous time, computed by code that shares nothing with the
renderer. The engine's floor has the same spring and damper.

- engine: the engine's own contact of the tool, a spring of the same stiffness, with the device fixed at its sample; the
  mean force over the steps of the period.
- engine, tuned: the damping that minimises E of this scene, found with the reference solution, and the tool fixed at
  its sample or moved with its last velocity, whichever gives the lower E.
- palpate: `Contact` of `palpate.engines.mujoco`, `palpate.engines.pybullet` or `palpate.engines.drake`.
"""

from __future__ import annotations

import argparse
import json
import math
from importlib import import_module
from typing import Any, NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from .._scene import simulate
from ._scenes import BODY_MASS, RATES, evaluated, scenes

ENGINES = ("mujoco", "pybullet", "drake")
DAMPING_RATIOS = (0.0, *(0.02 * 1.25**step for step in range(17)))
"""Damping ratios of the engine's contact for the tuning."""


class Row(NamedTuple):
    """Result of one contact in a scene."""

    scene: str
    period_s: float
    stiffness_n_per_m: float
    way: str
    steps: int
    integrator: str
    mean_force_error_percent: float
    error_over_bound: float
    microseconds_per_step: float
    """Median time of a step of the engine with the contact, from Python."""
    setting: str


def engine(name: str) -> Any:
    """Returns the module that runs the scenes in an engine: `with_engine`, `with_palpate`, `INTEGRATORS` and `VERSION`.

    Raises:
        ImportError: The engine is not installed.
    """
    return import_module(f"._with_{name}", __package__)


def rows(bench: Any, steps: Sequence[int], integrators: Sequence[str], mass_factors: Sequence[float]) -> list[Row]:
    """Computes all rows of the table."""
    made = []
    for period, stiffness in RATES:
        for scene in scenes(period, stiffness):
            ideal = simulate(scene.world)
            samples = ideal.ideal.shape[1]
            for count in steps:
                for integrator in integrators:

                    def row(contact: str, found: tuple[NDArray[np.float64], float], setting: str) -> Row:
                        error, over = evaluated(found[0], ideal)
                        where = (scene.name, period, stiffness, contact, count, integrator)
                        return Row(*where, error, over, 1e6 * found[1], setting)

                    made.append(row("engine", bench.with_engine(scene, count, integrator, 0.0, samples), ""))
                    critical = 2 * math.sqrt(stiffness * BODY_MASS)
                    tuned = [
                        row(
                            "engine, tuned",
                            bench.with_engine(scene, count, integrator, ratio * critical, samples, moves),
                            f"damping ratio {ratio:.2f}" + (", tool moved on" if moves else ""),
                        )
                        for ratio in DAMPING_RATIOS
                        for moves in (False, True)
                    ]
                    made.append(min(tuned, key=lambda row: row.mean_force_error_percent))
                    for factor in mass_factors:
                        setting = "" if factor == 1 else f"model mass {factor:g} times the true mass"
                        made.append(row("palpate", bench.with_palpate(scene, count, integrator, factor, samples), setting))
    return made


def main() -> None:
    """Prints the table."""

    def several(kind: Any) -> Any:
        return lambda text: [kind(part) for part in text.split(",")]

    parser = argparse.ArgumentParser(prog="python -m palpate.engines.table", description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--engine", choices=ENGINES, default=ENGINES[0], help="the engine (mujoco)")
    parser.add_argument("--steps", type=several(int), default=[4], help="steps of the engine in a period (4)")
    parser.add_argument("--integrators", type=several(str), help="integrators of MuJoCo: RK4, Euler, implicitfast (RK4)")
    parser.add_argument(
        "--model-mass-factor",
        type=several(float),
        default=[1.0, 1.5],
        help="model value of the device mass over the true mass (1,1.5)",
    )
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    given = parser.parse_args()
    bench = engine(given.engine)
    integrators = given.integrators or bench.INTEGRATORS[:1]
    unknown = [name for name in integrators if name not in bench.INTEGRATORS]
    if unknown:
        parser.error(f"--integrators {unknown[0]}: {given.engine} has {', '.join(bench.INTEGRATORS)}")
    found = rows(bench, given.steps, integrators, given.model_mass_factor)
    if given.json:
        print(json.dumps([row._asdict() for row in found], indent=2))
        return
    print(f"{bench.VERSION}; E in percent; us: time of a step of the engine with its contact, from Python\n")
    print("| scene | T ms | K N/m | steps | integrator | contact | E % | FRE/bound | us | |")
    print("|---|---:|---:|---:|---|---|---:|---:|---:|---|")
    for row in found:
        numbers = f"{row.mean_force_error_percent:.2f} | {row.error_over_bound:.2f} | {row.microseconds_per_step:.0f}"
        print(
            f"| {row.scene} | {1000 * row.period_s:g} | {row.stiffness_n_per_m:g} | {row.steps} | {row.integrator} | {row.way} | "
            f"{numbers} | {row.setting} |"
        )


if __name__ == "__main__":
    main()
