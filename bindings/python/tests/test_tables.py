"""The tables of `palpate.engines.table`, by each engine."""

from __future__ import annotations

from typing import Any, NamedTuple

import palpate
import pytest
from palpate.engines import table


class Engine(NamedTuple):
    """An engine, and what is required of its table."""

    name: str
    module: str
    """What it is imported as."""
    integrator: str
    error: float
    """E with palpate's contact, at most [%]."""
    alone: float
    """E of the engine's own contact, above this [%]: the scenes are none that it renders well."""
    over: float
    """The force that it makes of the ideal one, above this."""


ENGINES = [
    Engine("mujoco", "mujoco", "RK4", 2, 10, 1.5),
    Engine("pybullet", "pybullet", "Euler", 5, 8, 1.1),
    Engine("drake", "pydrake", "sap", 5, 8, 1.1),
]


@pytest.fixture(params=ENGINES, ids=[engine.name for engine in ENGINES])
def engine(request: Any) -> Engine:
    pytest.importorskip(request.param.module, reason=f"pip install palpate[{request.param.name}]")
    return request.param  # type: ignore[no-any-return]


@pytest.mark.parametrize("period, stiffness", table.RATES)
def test_with_palpate_the_force_is_the_mean_of_the_ideal_one(engine: Engine, period: float, stiffness: float) -> None:
    bench = table.engine(engine.name)
    for scene in table.scenes(period, stiffness):
        ideal = palpate.simulate(scene.world)
        samples = ideal.ideal.shape[1]
        for mass_factor in (1.0, 1.5):
            error, _ = table.evaluated(bench.with_palpate(scene, 4, engine.integrator, mass_factor, samples)[0], ideal)
            assert error < engine.error, (scene.name, mass_factor, error)
        alone, over = table.evaluated(bench.with_engine(scene, 4, engine.integrator, 0.0, samples)[0], ideal)
        assert alone > engine.alone and over > engine.over, (scene.name, alone)


def test_the_table_says_every_way(engine: Engine, capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(table, "RATES", [(0.01, 400.0)])
    monkeypatch.setattr(table, "DAMPING_RATIOS", (0.0, 0.05))
    arguments = ["table", "--engine", engine.name, "--steps", "2", "--model-mass-factor", "1", "--integrators"]
    monkeypatch.setattr("sys.argv", [*arguments, engine.integrator])
    table.main()
    said = capsys.readouterr().out
    for scene in ("ball", "ball on floor", "box on floor"):
        for way in ("engine", "engine, tuned", "palpate"):
            assert f"| {scene} | 10 | 400 | 2 | {engine.integrator} | {way} |" in said
    assert "damping ratio 0.0" in said
    monkeypatch.setattr("sys.argv", [*arguments, "leapfrog"])
    with pytest.raises(SystemExit):
        table.main()
    assert f"--integrators leapfrog: {engine.name} has " in capsys.readouterr().err
