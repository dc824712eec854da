"""Arrays as callers have them: every function that takes one gives the numbers of the plain array of the same numbers, or says
what it takes."""

from __future__ import annotations

import json
import math
from typing import Any, Callable, Iterator

import numpy as np
import pytest

import palpate
from conftest import ROOT
from palpate import devices, distributed

FIG2 = "experiments/fig2.toml"
CONTACT: dict[str, Any] = {"stiffness": 400.0, "mass": 0.1, "period": 1e-3, "device_mass": 0.25}


def strided(plain: np.ndarray) -> np.ndarray:
    """Every third number of each axis of a larger array."""
    if plain.ndim == 0:
        return plain
    large = np.full([3 * length for length in plain.shape], np.nan)
    view: np.ndarray = large[tuple(slice(1, None, 3) for _ in plain.shape)]
    view[...] = plain
    return view


def backwards(plain: np.ndarray) -> np.ndarray:
    """A view with steps below 0 along each axis."""
    turned: np.ndarray = np.flip(np.flip(plain).copy())
    return turned


def read_only(plain: np.ndarray) -> np.ndarray:
    kept = plain.copy()
    kept.flags.writeable = False
    return kept


def unaligned(plain: np.ndarray) -> np.ndarray:
    """Numbers side by side, where no number of 64 bits may begin."""
    return np.frombuffer(b"?" + plain.tobytes(), np.float64, offset=1).reshape(plain.shape)


def of_records(plain: np.ndarray) -> np.ndarray:
    """A field of packed records, 9 bytes each: its steps are no whole number of numbers."""
    records = np.zeros(plain.shape, [("code", "u1"), ("value", "f8")])
    records["value"][...] = plain
    view: np.ndarray = records["value"]
    return view


LAYOUTS: dict[str, Callable[[np.ndarray], Any]] = {
    "strided": strided,
    "backwards": backwards,
    "of Fortran": lambda plain: np.asfortranarray(plain),
    "transposed": lambda plain: plain.T.copy().T,
    "big-endian": lambda plain: plain.astype(">f8"),
    "little-endian": lambda plain: plain.astype("<f8"),
    "read-only": read_only,
    "unaligned": unaligned,
    "of records": of_records,
    "long double": lambda plain: plain.astype(np.longdouble),
    "objects that are no numbers of NumPy": lambda plain: plain.tolist(),
    "a memoryview": lambda plain: memoryview(np.ascontiguousarray(plain)),
    "masked, with nothing hidden": lambda plain: np.ma.array(plain, mask=False),
}
NARROW: dict[str, Callable[[np.ndarray], Any]] = {
    "float32": lambda plain: plain.astype(np.float32),
    "strided float32": lambda plain: strided(plain).astype(np.float32)[..., ::1],
    "float32 backwards": lambda plain: backwards(plain.astype(np.float32)),
    "big-endian float32": lambda plain: plain.astype(">f4"),
    "float16": lambda plain: plain.astype(np.float16),
    "whole": lambda plain: np.rint(100 * plain).astype(np.int32),
    "whole, of 8 bits": lambda plain: np.rint(100 * plain).astype(np.int8),
    "whole and unsigned": lambda plain: np.rint(np.abs(100 * plain)).astype(np.uint16),
}
WRONG: list[tuple[Callable[[np.ndarray], Any], str]] = [
    (lambda plain: plain * 1j, "is of type complex128, but must be of numbers"),
    (lambda plain: plain.astype(str), "is of type <U32, but must be of numbers"),
    (lambda plain: plain > 0, "is of type bool, but must be of numbers"),
    (lambda plain: np.full(plain.shape, None), "is of type object, but must be of numbers"),
    (lambda plain: np.zeros(plain.shape, "M8[s]"), r"is of type datetime64\[s\], but must be of numbers"),
    (lambda plain: np.ma.array(plain, mask=np.arange(plain.size).reshape(plain.shape) == 1), "has masked values, but every value must be known"),
    (lambda plain: [*plain.tolist()[:-1], [0.0, [1.0]]], "is not an array of numbers"),
]
"""What is refused, and how."""


def rendered(x: Any) -> Any:
    t = 1e-3 * np.arange(len(LEAD))
    return palpate.render(t, x, **{**CONTACT, "method": "coupled"}, unit="m").ticks["coupled"].tobytes()


def rendered_at(t: Any) -> Any:
    return palpate.render(t, LEAD, **{**CONTACT, "method": "basic"}, unit="m").ticks["basic"].tobytes()


def ball(count: int) -> palpate.World:
    body = {"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.05], "shape": {"sphere": {"radius_m": 0.03}}}
    tools = [
        {"name": f"tool{i}", "mass_kg": 0.2, "position_m": [0.1 * i, 0, 0], "tool": {"sphere": {"radius_m": 0.01}}}
        for i in range(count)
    ]
    law = {"stiffness_n_per_m": 2000.0}
    return palpate.World(
        loop={"period_s": 0.001},
        devices=tools,
        bodies=[body],
        contacts=[{"between": [tool["name"], "ball"], **law} for tool in tools],
        soft_start=0.0,
    )


def stepped(count: int) -> Callable[[Any], Any]:
    def answers(place: Any) -> Any:
        world = ball(count)
        return [world.step(place).tobytes() for _ in range(3)], world.output.fault  # type: ignore[union-attr]

    return answers


def turned(pose: Any) -> Any:
    world = palpate.World("experiments/worlds/peg.toml", soft_start=0.0)
    return [world.step(pose).tobytes() for _ in range(3)], world.output.fault  # type: ignore[union-attr]


def report_sent_of(force: Any) -> Any:
    world = ball(1)
    world.step([0.0, 0.0, 0.015])
    world.report_sent(force)
    return world.step([0.0, 0.0, 0.016]).tobytes()


def led_to(target: Any) -> Any:
    pointer = devices.PointerInWorld(palpate.World("experiments/worlds/paddle.toml"))
    pointer.move_to(target)
    return pointer.target


def turned_to(orientation: Any) -> Any:
    pointer = devices.PointerInWorld(palpate.World("experiments/worlds/peg.toml"))
    pointer.turn_to(orientation)
    return pointer.orientation


def placed(origin: Any) -> Any:
    diy = devices.TwoDiy("nowhere", origin=origin, normal=origin, watchdog=False)._given()
    return diy["origin"], diy["normal"], devices.Inverse3(origin=origin)._given()["origin"]


def tuned(values: Any) -> Any:
    return palpate.tune(FIG2, "hfcr", values=values)


def swept(values: Any) -> Any:
    return palpate.sweep(FIG2, "damping", values, "hfcr")


def with_tables(place: Any) -> Any:
    tool = {"name": "tool", "mass_kg": 0.2, "position_m": place, "tool": {"sphere": {"radius_m": 0.01}}}
    return palpate.World(loop={"period_s": 0.001}, devices=[tool]).to_dict()["device"][0]["position_m"]


def engine_device(place: Any) -> Any:
    from palpate.engines import SimulatedDevice

    device = SimulatedDevice(np.abs(np.asarray(place, float)) + 0.1, place, 100.0, 1.0, place, place, 1e-3)
    device.hold(place)
    return device.position.tobytes(), device.velocity.tobytes()


def engine_masses(mass: Any) -> Any:
    """The mass decides how the device moves, whatever the width of its numbers."""
    from palpate.engines import SimulatedDevice

    device = SimulatedDevice(mass, [0.0] * 3, 100.0, 1.0, [0.01] * 3, [0.0] * 3, 1e-3)
    device.hold([1.0] * 3)
    return device.position.tobytes(), device.velocity.tobytes()


def ball_of_an_engine() -> tuple[Any, np.ndarray]:
    """A contact of a tool with a ball that an engine moves, and the row of the ball."""
    from palpate.engines._contact import EngineContact, PlacedShape, body_row

    contact = EngineContact(
        tools={"tool": 0.01},
        bodies=[("ball", [PlacedShape("sphere", (0.03,))])],  # type: ignore[list-item]
        period=1e-3,
        device_mass=np.array([0.2, 0.2, 0.2]),
        stiffness=1000.0,
        soft_start=0.0,
    )
    mobility = np.eye(6) * 10.0
    return contact, np.array([body_row([0, 0, 0.035], [1, 0, 0, 0], [0] * 3, [0] * 3, [0] * 3, [0] * 3, mobility)])


def engine_contact(position: Any) -> Any:
    contact, rows = ball_of_an_engine()
    forces = []
    for _ in range(3):
        contact.sample(position)
        contact.meet(1e-3, rows)
        forces.append(contact.hold().tobytes())
        contact.report_sent(position)
    return forces


def met(rows: Any) -> bytes:
    contact, _ = ball_of_an_engine()
    contact.sample([0.0, 0.0, 0.0])
    return bytes(contact.meet(1e-3, rows).tobytes())


LEAD = 0.004 * np.sin(0.05 * np.arange(300))
# Valid arguments, also when rounded to float32 or to hundredths.
TAKEN: dict[str, tuple[Callable[[Any], Any], np.ndarray, str]] = {
    "render, positions": (rendered, LEAD, "x"),
    "render, times": (rendered_at, 1e-3 * np.arange(len(LEAD)), "t"),
    "World.step": (stepped(1), np.array([0.001, 0.002, 0.0153]), "position"),
    "World.step of two devices": (stepped(2), np.array([[0.001, 0.002, 0.0153], [0.03, 0.0, 0.031]]), "position"),
    "World.step of six axes": (turned, np.array([0.0, 0.0, 0.004, 1.0, 0.0, 0.0, 0.0]), "position"),
    "World.report_sent": (report_sent_of, np.array([0.1, -0.2, -0.73]), "force"),
    "PointerInWorld.move_to": (led_to, np.array([0.01, -0.023, 0.047]), "target"),
    "PointerInWorld.turn_to": (turned_to, np.array([0.51, 0.23, -0.31, 0.62]), "orientation"),
    "a device's origin": (placed, np.array([0.013, 0.11]), "origin"),
    "tune": (tuned, np.array([0.11, 0.47, 0.93]), "values"),
    "sweep": (swept, np.array([0.11, 0.47, 0.93]), "values"),
    "SimulatedDevice": (engine_device, np.array([0.01, 0.023, -0.031]), "position"),
    "the mass of a SimulatedDevice": (engine_masses, np.array([0.21, 0.33, 0.47]), "mass"),
    "EngineContact": (engine_contact, np.array([0.001, 0.002, 0.0013]), "position"),
}
WHOLE_ALLOWED = {name for name in TAKEN if name not in ("render, times", "tune", "sweep", "World.step of six axes")}


@pytest.mark.parametrize("name", TAKEN)
def test_any_layout_gives_the_numbers_of_the_plain_array(root: Any, name: str) -> None:
    call, plain, _ = TAKEN[name]
    expected = call(plain)
    for layout, make in LAYOUTS.items():
        made = make(plain)
        before = np.array(made, float)
        assert call(made) == expected, layout
        np.testing.assert_array_equal(before, np.array(made, float), layout)


@pytest.mark.parametrize("name", TAKEN)
def test_narrow_numbers_give_those_of_the_same_numbers_in_double_precision(root: Any, name: str) -> None:
    call, plain, _ = TAKEN[name]
    for width, make in NARROW.items():
        made = make(plain)
        if made.dtype.kind in "iu" and name not in WHOLE_ALLOWED:
            continue
        try:
            expected = call(made.astype(np.float64))
        except ValueError as error:
            # Invalid values give the same message for every type.
            with pytest.raises(ValueError) as raised:
                call(made)
            assert str(raised.value) == str(error), width
            continue
        assert call(made) == expected, width


# The test of SimulatedDevice is separate, because its masses are derived from the argument here.
@pytest.mark.parametrize("name", [name for name in TAKEN if name != "SimulatedDevice"])
def test_what_is_no_array_of_numbers_is_refused_by_name(root: Any, name: str) -> None:
    call, plain, argument = TAKEN[name]
    for make, words in WRONG:
        with pytest.raises(ValueError, match=f"^({argument}) {words}"):
            call(make(plain))


def test_masses_of_any_layout_are_those_of_the_plain_array() -> None:
    from palpate.engines._contact import _masses

    for shape in [(), (3,), (2, 3)]:
        plain = np.array(np.arange(1.0, 1.0 + np.prod(shape, dtype=int)).reshape(shape) / 7)
        for layout, make in LAYOUTS.items():
            if shape or layout not in ("of Fortran", "a memoryview"):
                assert _masses(make(plain), 2) == _masses(plain, 2), layout
        single = plain.astype(np.float32)
        assert _masses(single, 2) == _masses(single.astype(float), 2)


def test_the_compiled_part_refuses_what_does_not_lie_as_numbers_do() -> None:
    """Its callers hand over arrays that do; somebody else may call it."""
    world = ball(1)
    row = np.array([[0.001, 0.002, 0.0153]])
    answer = world.tick(row, None).tobytes()
    for make in (strided, backwards, np.asfortranarray, read_only):
        world.reset()
        assert world.tick(make(row), None).tobytes() == answer
    for make in (unaligned, of_records):
        with pytest.raises(ValueError, match=r"positions is not aligned in memory as 64-bit numbers; give numpy.require"):
            world.tick(make(row), None)
    many, worlds = palpate.Renderers(3, **CONTACT), palpate.Worlds(world, 1)
    with pytest.raises(ValueError, match="positions is not aligned in memory"):
        many.tick(unaligned(np.zeros(3)), None, None, np.zeros(3))
    with pytest.raises(ValueError, match="out is not aligned in memory"):
        worlds.tick(row[None], None, np.zeros(25, np.uint8)[1:].view(float).reshape(1, 1, 3))


def numbers_of_numpy() -> Iterator[Any]:
    for kind in (np.float64, np.float32, np.float16, np.longdouble):
        yield kind(0.0015)
    yield np.array(0.0015)
    yield np.array(0.0015, ">f8")
    yield np.array([0.0015, 1.0])[:1].reshape(())


def test_a_number_of_numpy_is_a_number() -> None:
    for number in numbers_of_numpy():
        expected, found = palpate.Renderer(**CONTACT), palpate.Renderer(**CONTACT)
        excited, ours = palpate.Excitation(period=1e-3), palpate.Excitation(period=1e-3)
        for _ in range(3):
            assert found.step(number) == expected.step(float(number))
            assert ours.step(number) == excited.step(float(number))
        pointer = devices.Pointer(position=number)
        assert pointer.target == float(number)
        pointer.move_to(number)
        assert pointer.target == float(number)
        mass = palpate.Renderer(**{**CONTACT, "mass": number})
        assert [mass.step(0.001 * i) for i in range(3)] == [
            other.step(0.001 * i) for other in [palpate.Renderer(**{**CONTACT, "mass": float(number)})] for i in range(3)
        ]


def test_an_argument_of_a_wrong_type_is_named() -> None:
    for name, value in {"stiffness": "400", "mass": np.array([0.1, 0.2]), "period": None}.items():
        with pytest.raises(TypeError, match=f"^{name} is "):
            palpate.Renderer(**{**CONTACT, name: value})
        with pytest.raises(TypeError, match=f"^{name} is "):
            palpate.render([0, 1, 2], [0, 0, 0], **{**CONTACT, name: value})
    with pytest.raises(TypeError, match="^oscillation is 'much': "):
        palpate.Loop(devices.Pointer(), palpate.Renderer(**CONTACT), oscillation="much")  # type: ignore[arg-type]


def test_tables_of_scenes_take_arrays_and_numbers_of_numpy() -> None:
    plain = np.array([0.01, 0.023, -0.031])
    for layout, make in LAYOUTS.items():
        if layout not in ("long double", "a memoryview"):
            assert with_tables(make(plain)) == plain.tolist(), layout
    for make in (NARROW["float32"], NARROW["whole"]):
        assert with_tables(make(plain)) == make(plain).tolist()
    one = palpate.World(loop={"period_s": np.float32(0.125)}, devices=[{"name": "a", "mass_kg": np.int8(1), "tool": {"sphere": {"radius_m": np.array(0.25)}}}])
    assert one.to_dict()["loop"] == {"period_s": 0.125} and one.to_dict()["device"][0]["tool"] == {"sphere": {"radius_m": 0.25}}
    for wrong in (plain * 1j, np.array([None, 0, 0]), np.ma.array(plain, mask=[0, 1, 0])):
        with pytest.raises(TypeError, match=r"^scene\.device\.position_m is .*, but must be a number"):
            with_tables(wrong)


def test_parts_on_many_machines_are_asked_for_by_numbers_of_numpy(root: Any, tmp_path: Any) -> None:
    """`palpate.distributed` takes no array; what it writes of its numbers is what plain numbers would be."""
    pytest.importorskip("pyarrow")
    mine = distributed.map("basic", cells=np.int64(2), parts=np.int32(1), delay_periods=np.float32(0.5))  # type: ignore[arg-type]
    theirs = distributed.map("basic", cells=2, parts=1, delay_periods=0.5)
    for number, study in enumerate((mine, theirs)):
        folder = tmp_path / str(number)
        folder.mkdir()
        study.make(1, folder)
    names = [[path.name for path in sorted((tmp_path / str(number)).iterdir())] for number in range(2)]
    assert names[0] == names[1]
    assert [(tmp_path / "0" / name).read_bytes() for name in names[0]] == [(tmp_path / "1" / name).read_bytes() for name in names[1]]
    assert json.loads(mine.merge(tmp_path / "0").to_json()) == json.loads(theirs.merge(tmp_path / "1").to_json())


def test_a_step_of_an_engine_is_checked() -> None:
    contact, rows = ball_of_an_engine()
    with pytest.raises(ValueError, match=r"there is no sample: call sample\(\) before meet\(\)"):
        contact.meet(1e-3, rows)
    contact.sample([0.0, 0.0, 0.0])
    for h in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"h is \S+ s, but must be finite and greater than 0"):
            contact.meet(h, rows)
    with pytest.raises(ValueError, match="bodies is of type <U"):
        contact.meet(1e-3, ["none"])
    expected = met(rows)
    assert met(rows.tolist()) == met(np.asfortranarray(np.repeat(rows, 2, axis=1))[:, ::2]) == expected
    # A non-finite state of an engine is reported as such.
    contact.meet(1e-3, np.full_like(rows, math.nan))
    assert contact.hold().tolist() == [0.0, 0.0, 0.0] and contact.output.fault is not None


def test_an_argument_of_a_wrong_type_is_said_by_its_name() -> None:
    scene = str(ROOT / "experiments/fig2.toml")
    wrong: list[tuple[Callable[[], Any], str]] = [
        (lambda: palpate.simulate(scene, method=3), "method is 3, but must be the name of a method, a function, or a list"),  # type: ignore[arg-type]
        (lambda: palpate.compare([scene], method=[None]), r"method is \[None\], but must be the name of a method"),  # type: ignore[list-item]
        (lambda: palpate.advise(device_mass="a", period=0.005), "device_mass is 'a': must be real number"),  # type: ignore[arg-type]
        (lambda: palpate.map(["basic"], cells=2.5), "cells is 2.5: "),  # type: ignore[arg-type]
    ]
    for call, said in wrong:
        with pytest.raises(TypeError, match=said):
            call()
