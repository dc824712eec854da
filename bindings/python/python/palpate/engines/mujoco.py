"""Contacts with the bodies of MuJoCo: `pip install palpate[mujoco]`.

    import mujoco
    from palpate.engines.mujoco import Contact

    contact = Contact(model, data, tool=0.01, bodies=["ball"], stiffness=400.0, device_mass=0.25, period=0.01)
    while True:
        force = contact.step(position)  # reads your device, steps the engine, and gives the force to command

The engine simulates the bodies, with its other contacts, joints and robots. palpate renders only the contacts of the
tool. It adds their wrenches to `data.xfrc_applied` and removes them after the engine's step. `close()`, or the end of a
`with` block, enables the engine's own contacts of a tool again.
"""

from __future__ import annotations

import warnings
import weakref
from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._contact import BODY_COLUMNS, EngineBody, EngineContact, PlacedShape, radius
try:
    import mujoco
except ImportError as _missing:
    raise ImportError("palpate.engines.mujoco needs MuJoCo: pip install 'palpate[mujoco]'") from _missing

__all__ = ["Contact"]

_GEOM = mujoco.mjtGeom
_KINDS = {
    int(_GEOM.mjGEOM_PLANE): ("half-space", 0),
    int(_GEOM.mjGEOM_SPHERE): ("sphere", 1),
    int(_GEOM.mjGEOM_CAPSULE): ("capsule", 2),
    int(_GEOM.mjGEOM_CYLINDER): ("cylinder", 2),
    int(_GEOM.mjGEOM_BOX): ("box", 3),
}


class Contact(EngineContact):
    """Contacts of a tool with bodies of a MuJoCo model.

    The contact steps the engine: a period is one or more of its steps. First the engine is stepped with the wrenches
    between proxies and bodies. This yields the force that the device holds during the same time.

    The tool is a sphere unknown to MuJoCo, or a sphere geom of a mocap body. Collisions of such a geom are disabled in
    the engine until `close()`, and its mocap body follows the proxy, for display in a viewer. Other geoms of that body
    are unchanged. If one of them can collide, a warning is issued, because its contacts exert no force on the device.

    The velocity change by a force depends on the integrator. Implicit integrators, and Euler with damped joints, use
    the damping of joints, tendons and servos at the end of the step. The mobility of the bodies includes this damping.

    Args:
        model: A compiled model, with lengths in metres and masses in kilograms.
        data: Its state.
        tool: Radius of the tool [m], at most 1, 0 for a point; or a sphere geom of a mocap body, by its name or as
            `model.geom(name)`. A whole number is rejected as a radius. For several devices a sequence of these.
        bodies: Names or numbers of the bodies that the tool touches, `"world"` for fixed geometry. Every geom that can
            collide is used: spheres, boxes, capsules, cylinders, planes and meshes.
        stiffness: K of the contacts [N/m].
        device_mass: Effective mass of the device [kg], accurate within a factor of 2: one number, or one per axis; for
            several devices a row of three for each.
        period: Time from sample to sample [s], a whole number of the model's time steps. `None`: one step.
        damping: Material damping B [N s/m].
        friction: Coefficient of friction.
        friction_stiffness: Stiffness of the bristle of friction [N/m]; `None`: that of the contact.
        friction_damping: Damping of the bristle of friction [N s/m]; `None`: `damping` times `friction_stiffness` over
            `stiffness`.
        encoder_quantum: Quantum of the position sensors [m]; 0: unknown or none.
        delay: Time from a sample to the beginning of its force [s]. The engine is ahead of the sample by this time.
        lag: Time constant of the actuators [s].
        gain: Ratio of delivered to commanded force.
        force_limit: Largest magnitude of the force on the device [N]; `math.inf`: no limit.
        soft_start: Duration of the force ramp if a start or a recovery begins in contact [s], at most 60.

    Raises:
        ValueError: Arguments are not allowed; the message has the names of the model.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    steps: int
    """Steps of the engine in a period."""

    def __new__(
        cls,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        tool: Any,
        bodies: Sequence[str | int],
        stiffness: float,
        device_mass: ArrayLike,
        period: float | None = None,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_stiffness: float | None = None,
        friction_damping: float | None = None,
        encoder_quantum: float = 0.0,
        delay: float = 0.0,
        lag: float = 0.0,
        gain: float = 1.0,
        force_limit: float = 20.0,
        soft_start: float = 0.2,
    ) -> Contact:
        if data.signature != model.signature:
            raise ValueError("data belongs to another model: give mujoco.MjData(model) of this model")
        h = float(model.opt.timestep)
        steps = 1 if period is None else _whole(period, h)
        several: list[Any] = [tool] if isinstance(tool, str) or _is_view(tool) or np.ndim(tool) == 0 else [*tool]
        several = [_geom_name(given) if _is_view(given) else given for given in several]
        geoms = [_tool_geom(model, name) if isinstance(name, str) else None for name in several]
        tools: dict[str, float] = {}
        for number, (given, geom) in enumerate(zip(several, geoms)):
            name = given if isinstance(given, str) else "tool" if len(several) == 1 else f"tool {number}"
            if name in tools:
                raise ValueError(f"tool names {name!r} twice")
            way = ", or a sphere geom of a mocap body by its name"
            tools[name] = radius(float(model.geom_size[geom][0]) if geom is not None else given, way)
        if isinstance(bodies, (str, int)):
            raise ValueError(f"bodies is {bodies!r}, but must be a list, such as [{bodies!r}]")
        numbers = [_body(model, body) for body in bodies]
        for number in numbers:
            if numbers.count(number) > 1:
                raise ValueError(f"bodies names {_name(model, 'body', number)} twice")
        excluded = {int(model.geom_bodyid[geom]) for geom in geoms if geom is not None}
        if excluded & set(numbers):
            raise ValueError(f"bodies names {_name(model, 'body', (excluded & set(numbers)).pop())}, which carries the tool")
        made = super().__new__(
            cls,
            tools=tools,
            bodies=[_described(model, number) for number in numbers],
            period=steps * h,
            device_mass=device_mass,
            stiffness=stiffness,
            damping=damping,
            friction=friction,
            friction_stiffness=friction_stiffness,
            friction_damping=friction_damping,
            # Only the Runge-Kutta integrator moves bodies by the mean velocity.
            end_velocity=int(model.opt.integrator) != int(mujoco.mjtIntegrator.mjINT_RK4),
            encoder_quantum=encoder_quantum,
            delay=delay,
            lag=lag,
            gain=gain,
            force_limit=force_limit,
            soft_start=soft_start,
        )
        assert isinstance(made, Contact)
        made.model, made.data, made.steps = model, data, steps
        made._numbers = numbers
        made._geoms = [geom for number in numbers for geom in _geoms(model, number)]
        made._geoms += [geom for geom in geoms if geom is not None]
        made._made_of = made._now_made_of()
        made._mocap = [None if geom is None else int(model.body_mocapid[model.geom_bodyid[geom]]) for geom in geoms]
        made._room(model)
        taken = [geom for geom in geoms if geom is not None]
        _warn_of_others(model, taken)
        for geom in taken:
            _take(model, geom)
        made._give_back = weakref.finalize(made, _give_back, model, taken)
        return made

    _give_back: weakref.finalize[Any, Any]
    """Enables the collisions of the tools in the engine again."""
    _numbers: list[int]
    _moving: list[int]
    """Places of the bodies that can move."""
    _geoms: list[int]
    """Geoms of tools and bodies."""
    _made_of: list[NDArray[np.float64]]
    """Values of the model that must not change: time step, integrator and shapes."""
    _mocap: list[int | None]
    _applied: NDArray[np.float64]
    """Last applied wrenches, a row for each body [N], [N m]."""
    _theirs: NDArray[np.float64]
    _pushes: bool
    _time: float
    """Time of the engine after the last step [s]."""

    def _room(self, model: mujoco.MjModel) -> None:
        count = len(self._numbers)
        self._applied = np.zeros((count, 6))
        self._theirs = np.zeros((count, 6))
        self._pushes = False
        self._time = float(self.data.time)
        self._rows = np.zeros((count, BODY_COLUMNS))
        bodies = enumerate(self._numbers)
        self._moving = [place for place, number in bodies if model.nv > 0 and model.body_weldid[number] != 0]
        self._jacobians, self._rates, self._answers = np.zeros((3, len(self._moving), 6, model.nv))
        self._implicit = _Implicit(model, self.data)

    def _now_made_of(self) -> list[NDArray[np.float64]]:
        model, geoms = self.model, self._geoms
        stepping = np.array([float(model.opt.timestep), float(model.opt.integrator)])
        return [stepping, model.geom_size[geoms], model.geom_pos[geoms], model.geom_quat[geoms], model.body_ipos[self._numbers]]

    def step(self, position: ArrayLike, elapsed: float | None = None) -> NDArray[np.float64]:
        """Computes one period: takes a sample of the devices, steps the engine through the period, and returns the
        force on the device [N] to hold over it.

        Args:
            position: Position of the device in the world frame [m], three numbers; for several devices a row for each.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Returns:
            Three numbers; for several devices a row for each. After an invalid sample they are 0, and `output.fault`
            has the reason; the engine is still stepped.

        Raises:
            ValueError: As for `sample`.
        """
        self.sample(position, elapsed)
        for _ in range(self.steps):
            self.push()
            mujoco.mj_step(self.model, self.data)
            self.pull()
        return self.hold()

    def sample(self, position: ArrayLike, elapsed: float | None = None) -> None:
        """Begins a period: takes a sample of all devices, as `step` does. Calls `reset` if the engine's time has
        decreased since the last step, for example after `mj_resetData`.

        Raises:
            ValueError: The position is not three numbers for each device, or the time step, the integrator or the
                shapes of the model have changed.
        """
        if not self._give_back.alive:
            raise ValueError("this Contact is closed: make another one")
        if not all(map(np.array_equal, self._made_of, self._now_made_of())):
            raise ValueError(
                "the model's time step, its integrator, or the size or position of a touched geom has changed since "
                "this Contact was made: make another Contact"
            )
        if self.data.time < self._time:
            self.reset()
        super().sample(position, elapsed)

    def push(self) -> None:
        """Adds the wrenches of the contacts to `data.xfrc_applied`, before a step of the engine. For a program that
        steps the engine itself, between `sample` and `hold`:

            contact.sample(position)
            for _ in range(contact.steps):
                contact.push()
                mujoco.mj_step(model, data)
                contact.pull()
            force = contact.hold()

        Several contacts, each with its own device, may push before a step.
        """
        if self._pushes:
            raise ValueError("call push() once before each step of the engine, and pull() after it")
        self._theirs[:] = self.data.xfrc_applied[self._numbers]
        # Apply the last wrenches, so that the engine's other contacts are loaded.
        self.data.xfrc_applied[self._numbers] = self._theirs + self._applied
        mujoco.mj_forward(self.model, self.data)
        self._look()
        if self.data.time < self._time:
            # The engine reset itself within the period, as it does after a non-finite state.
            self._rows[:] = np.nan
        self._applied[:] = self.meet(float(self.model.opt.timestep), self._rows)
        self.data.xfrc_applied[self._numbers] = self._theirs + self._applied
        self._pushes = True

    def pull(self) -> None:
        """Removes the wrenches of the contacts from `data.xfrc_applied`, after a step of the engine, and moves the
        mocap bodies of the tools to the proxies."""
        if not self._pushes:
            raise ValueError("call pull() after push() and a step of the engine")
        self.data.xfrc_applied[self._numbers] = self._theirs
        self._pushes = False
        self._time = max(self._time, float(self.data.time))
        if any(mocap is not None for mocap in self._mocap):
            for mocap, place in zip(self._mocap, self.proxies()):
                if mocap is not None and np.isfinite(place).all():
                    self.data.mocap_pos[mocap] = place

    def reset(self) -> None:
        """Resets samples, contacts and energy ledger. Call it after `mj_resetData`, or after a body was moved."""
        super().reset()
        self._applied[:] = 0.0
        self._pushes = False
        self._time = float(self.data.time)

    def close(self) -> None:
        """Ends the contacts: removes their wrenches from `data.xfrc_applied` and enables the engine's own contacts of
        the tool geoms again. The end of a `with` block does this too. `sample` then raises an error."""
        if self._pushes:
            self.data.xfrc_applied[self._numbers] = self._theirs
            self._pushes = False
        self._give_back()

    def __enter__(self) -> Contact:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _look(self) -> None:
        """Writes states and mobilities of the bodies to their rows."""
        model, data, rows = self.model, self.data, self._rows
        rows[:, 0:3] = data.xipos[self._numbers]
        rows[:, 3:7] = data.xquat[self._numbers]
        rows[:, 7:] = 0.0
        moving, jacobians, rates, answers = self._moving, self._jacobians, self._rates, self._answers
        if not moving:
            return
        for place, jacobian, rate in zip(moving, jacobians, rates):
            number = self._numbers[place]
            mujoco.mj_jacBodyCom(model, data, jacobian[:3], jacobian[3:], number)
            mujoco.mj_jacDot(model, data, rate[:3], rate[3:], data.xipos[number], number)
        self._implicit.look()
        self._implicit.solve(answers.reshape(-1, model.nv), jacobians.reshape(-1, model.nv))
        mobilities = jacobians @ answers.transpose(0, 2, 1)
        accelerations = jacobians @ self._implicit.gained + rates @ data.qvel
        rows[moving, 7:13] = jacobians @ data.qvel
        rows[moving, 13:19] = accelerations - np.einsum("bij,bj->bi", mobilities, self._applied[moving])
        rows[moving, 19:55] = mobilities.reshape(-1, 36)


class _Implicit:
    """Response of velocities to forces over a step: the inverse of M, or of M - h dF/dv if the integrator evaluates
    velocity-dependent forces at the end of the step."""

    gained: NDArray[np.float64]
    """Change of the velocities by the step with the forces of `data`, divided by the length of the step."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self.gained = data.qacc
        self._after: Any = None
        self._rates: NDArray[np.float64] | None = None
        self._matrix = np.zeros((model.nv, model.nv))

    def look(self) -> None:
        """Predicts the effect of the step, after `mj_forward`."""
        model, data = self._model, self._data
        self.gained, self._rates = data.qacc, None
        kind = int(model.opt.integrator)
        is_implicit = kind in (_INTEGRATOR.mjINT_IMPLICIT, _INTEGRATOR.mjINT_IMPLICITFAST)
        damps = any(one.any() for one in self._dampings) and not model.opt.disableflags & _EULERDAMP
        if model.nv == 0 or not (is_implicit or (kind == _INTEGRATOR.mjINT_EULER and damps)):
            return
        if self._after is None:
            self._after = mujoco.MjData(model)
        # Execute the step on a copy of the data: it gives the change of the velocities and, for implicit
        # integrators, the derivative of the forces by the velocities.
        after = self._after
        mujoco.mj_copyData(after, model, data)
        if is_implicit:
            mujoco.mj_implicit(model, after)
            self._rates = self._dense(after)
            if kind == _INTEGRATOR.mjINT_IMPLICITFAST:
                # The engine uses the lower triangle only.
                self._rates = np.tril(self._rates) + np.tril(self._rates, -1).T
        else:
            mujoco.mj_Euler(model, after)
            linear, further = self._dampings
            speeds = np.abs(data.qvel)
            rates = linear.copy()
            for power in range(further.shape[1]):
                rates += (power + 2) * further[:, power] * speeds ** (power + 1)
            self._rates = np.diag(-rates)
        self.gained = (after.qvel - data.qvel) / model.opt.timestep

    @property
    def _dampings(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Damping coefficients of the joints: of the speed, and, for each joint, of its higher powers."""
        linear = self._model.dof_damping
        # Damping is linear before MuJoCo 4.
        return linear, getattr(self._model, "dof_dampingpoly", np.zeros((len(linear), 0)))

    def solve(self, answers: NDArray[np.float64], forces: NDArray[np.float64]) -> None:
        """Computes the accelerations over the step for generalised forces, a row for each."""
        model, data = self._model, self._data
        if self._rates is None:
            mujoco.mj_solveM(model, data, answers, forces)
            return
        try:
            mujoco.mj_fullM(model, data, self._matrix)
        except TypeError:
            # Signature before MuJoCo 4.
            mujoco.mj_fullM(model, self._matrix, data.qM)
        answers[:] = np.linalg.solve(self._matrix - model.opt.timestep * self._rates, forces.T).T

    def _dense(self, data: mujoco.MjData) -> NDArray[np.float64]:
        """Returns the derivative of forces by velocities as a dense matrix."""
        sparse = self._model if hasattr(self._model, "D_rownnz") else data
        dense = np.zeros_like(self._matrix)
        dense[np.repeat(np.arange(len(dense)), sparse.D_rownnz), sparse.D_colind] = data.qDeriv
        return dense


_INTEGRATOR = mujoco.mjtIntegrator
_EULERDAMP = int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)

_taken: dict[tuple[int, int], list[int]] = {}
"""Geoms with disabled collisions, by address of the model: number of contacts that use the geom, and its original
contype and conaffinity."""


def _take(model: mujoco.MjModel, geom: int) -> None:
    now = [0, int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])]
    _taken.setdefault((model._address, geom), now)[0] += 1
    model.geom_contype[geom] = model.geom_conaffinity[geom] = 0


def _give_back(model: mujoco.MjModel, geoms: list[int]) -> None:
    for geom in geoms:
        before = _taken[model._address, geom]
        before[0] -= 1
        if before[0] == 0:
            model.geom_contype[geom], model.geom_conaffinity[geom] = before[1:]
            del _taken[model._address, geom]


def _warn_of_others(model: mujoco.MjModel, tools: list[int]) -> None:
    """Warns about other geoms of a tool's mocap body that push bodies without a force on the device."""
    carriers = {int(model.geom_bodyid[tool]) for tool in tools}
    mine = [geom for geom in range(model.ngeom) if int(model.body_rootid[model.geom_bodyid[geom]]) in carriers and geom not in tools]
    others = [geom for geom in range(model.ngeom) if model.body_weldid[model.geom_bodyid[geom]] != 0 and geom not in mine]
    pushing = [
        geom
        for geom in mine
        if any(
            model.geom_contype[geom] & model.geom_conaffinity[other] or model.geom_contype[other] & model.geom_conaffinity[geom]
            for other in others
        )
    ]
    if pushing:
        names = ", ".join(_name(model, "geom", geom) for geom in pushing)
        warnings.warn(
            f"{names}: on the tool's mocap body, but not the tool; the engine pushes bodies with it without a force on "
            'the device. Set contype="0" conaffinity="0"',
            stacklevel=3,
        )


def _is_view(given: Any) -> bool:
    """Whether the value is a view such as `model.geom(name)`."""
    return hasattr(given, "id") and hasattr(given, "name")


def _geom_name(view: Any) -> str:
    if not hasattr(view, "contype"):
        raise ValueError(f"tool is {view!r}, but must be a radius or a geom: model.geom(name)")
    if not view.name:
        raise ValueError(f"tool is geom {view.id}, which has no name: give it one in the model")
    return str(view.name)


def _whole(period: float, h: float) -> int:
    steps = round(period / h) if period > 0 and np.isfinite(period) else 0
    if steps < 1 or abs(period / h - steps) > 1e-6 * steps:
        raise ValueError(
            f"period is {period} s, but must be a whole number of the model's time steps of {h} s: set model.opt.timestep"
        )
    return steps


def _name(model: mujoco.MjModel, of: str, number: int) -> str:
    name = mujoco.mj_id2name(model, _OBJECTS[of], number)
    return f"{of} {name!r}" if name else f"{of} {number}"


_OBJECTS = {"body": mujoco.mjtObj.mjOBJ_BODY, "geom": mujoco.mjtObj.mjOBJ_GEOM}


def _number(model: mujoco.MjModel, of: str, name: str) -> int:
    number = int(mujoco.mj_name2id(model, _OBJECTS[of], name))
    if number < 0:
        count = model.nbody if of == "body" else model.ngeom
        names = [mujoco.mj_id2name(model, _OBJECTS[of], number) for number in range(count)]
        raise ValueError(f"the model has no {of} {name!r}; it has {', '.join(repr(name) for name in names if name)}")
    return number


def _body(model: mujoco.MjModel, body: str | int) -> int:
    if isinstance(body, str):
        return _number(model, "body", body)
    if not isinstance(body, (int, np.integer)):
        raise ValueError(f"bodies has {body!r}, but must have names or whole numbers")
    if not 0 <= body < model.nbody:
        raise ValueError(f"bodies has {body}, but the model's bodies are 0 to {model.nbody - 1}")
    return int(body)


def _tool_geom(model: mujoco.MjModel, name: str) -> int:
    geom = _number(model, "geom", name)
    if int(model.geom_type[geom]) != int(_GEOM.mjGEOM_SPHERE):
        raise ValueError(f"tool: geom {name!r} is not a sphere, but a tool must be a sphere")
    if int(model.body_mocapid[model.geom_bodyid[geom]]) < 0:
        raise ValueError(f"tool: geom {name!r} must belong to a mocap body, which follows the device")
    if any(geom in pair for pair in zip(model.pair_geom1, model.pair_geom2)):
        raise ValueError(f"tool: geom {name!r} is in a <pair>, so the engine would render its contact too")
    return geom


def _geoms(model: mujoco.MjModel, number: int) -> list[int]:
    """Returns the geoms of a body that can collide."""
    first = int(model.body_geomadr[number])
    geoms = range(first, first + int(model.body_geomnum[number])) if first >= 0 else range(0)
    return [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]


def _described(model: mujoco.MjModel, number: int) -> EngineBody:
    name = _name(model, "body", number)
    shapes = [_shape(model, number, geom) for geom in _geoms(model, number)]
    if not shapes:
        raise ValueError(f"{name} has no geom that can collide, so a tool cannot touch it")
    return EngineBody(name, shapes)


def _shape(model: mujoco.MjModel, number: int, geom: int) -> PlacedShape:
    kind = int(model.geom_type[geom])
    lengths: tuple[float, ...] = ()
    points: list[list[float]] = []
    if kind in _KINDS:
        word, count = _KINDS[kind]
        lengths = tuple(float(x) for x in model.geom_size[geom][:count])
    elif kind == int(_GEOM.mjGEOM_MESH):
        # The engine's own contacts use the hull of a mesh, too.
        word = "hull"
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        points = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])].tolist()
    else:
        is_called = _GEOM(kind).name.removeprefix("mjGEOM_").lower()
        raise ValueError(
            f"{_name(model, 'body', number)}: {_name(model, 'geom', geom)} is of type {is_called}; a tool can touch planes, "
            "spheres, capsules, cylinders, boxes and meshes. Give the geom contype=0 and conaffinity=0, and one of these "
            "beside it"
        )
    # The reference point is the centre of mass: the torques of xfrc_applied are about it.
    place = model.geom_pos[geom] - model.body_ipos[number]
    return PlacedShape(word, lengths, place.tolist(), model.geom_quat[geom].tolist(), points)
