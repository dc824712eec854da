"""Contacts with the bodies of Drake: `pip install palpate[drake]`.

    from pydrake.systems.analysis import Simulator
    from palpate.engines.drake import Contact

    simulator = Simulator(diagram)
    contact = Contact(simulator, plant, tool=0.01, bodies=["ball"], stiffness=400.0, device_mass=0.25, period=0.01)
    while True:
        force = contact.step(position)  # reads your device, steps the plant, and gives the force to command

The plant simulates the bodies, with its other contacts, joints and robots. palpate renders only the contacts of the
tool. It adds their wrenches to the values of the plant's input port `applied_spatial_force` and removes them after the
plant's step.
"""

from __future__ import annotations

from copy import copy
from typing import Any, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._contact import BODY_COLUMNS, EngineBody, EngineContact, PlacedShape, radius
try:
    from pydrake.geometry import (
        Box,
        Capsule,
        CollisionFilterDeclaration,
        Convex,
        Cylinder,
        GeometryId,
        GeometrySet,
        HalfSpace,
        Mesh,
        SceneGraph,
        SceneGraphInspector,
        Sphere,
    )
    from pydrake.multibody.math import SpatialForce
    from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
    from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable, RigidBody
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import Context, Diagram, InputPort, InputPortIndex, System
except ImportError as _missing:
    raise ImportError("palpate.engines.drake needs Drake: pip install 'palpate[drake]'") from _missing

__all__ = ["Contact"]

_FORCE_FIRST = [3, 4, 5, 0, 1, 2]
"""Order of a body row: Drake has rotation before translation."""


class Contact(EngineContact):
    """Contacts of a tool with bodies of a discrete `MultibodyPlant`.

    The contact advances the simulator: a period is one or more of the plant's steps. First the simulator is advanced
    with the wrenches between proxies and bodies. This yields the force that the device holds during the same time. The
    other accelerations of a body within a step come from the plant, which therefore solves each step twice: with the
    last wrenches and with the new ones.

    Args:
        simulator: Simulator of the diagram that contains the plant.
        plant: Finalized, discrete plant with a scene graph. It can use any contact approximation.
        tool: Radius of the tool [m], a sphere unknown to Drake; 0 for a point. Or a body of the plant, or its name,
            with one sphere as collision shape. Drake then excludes contacts of this sphere with `bodies`, but no
            others; the plant moves the body. For several devices a sequence of these.
        bodies: Names of the bodies that the tool touches, or the bodies; `"world"` for fixed geometry. All spheres,
            boxes, capsules, cylinders, half-spaces and meshes for collisions are used.
        stiffness: K of the contacts [N/m].
        device_mass: Effective mass of the device [kg], accurate within a factor of 2: one number, or one per axis; for
            several devices a row of three for each.
        period: Time from sample to sample [s], a whole number of the plant's time steps. `None`: one step.
        port: Input port for the wrenches. `None`: the plant's `applied_spatial_force`, which must not be connected. If
            it is, connect it to an `ExternallyAppliedSpatialForceMultiplexer` and pass one of the multiplexer's ports.
        others: Arguments of `palpate.engines.EngineContact`: `damping`, `friction`, `friction_stiffness`,
            `friction_damping`, `encoder_quantum`, `delay`, `lag`, `gain`, `force_limit`, `soft_start`.

    Raises:
        ValueError: An argument is not allowed; the message has the names of the plant.
    """

    simulator: Simulator
    plant: MultibodyPlant
    steps: int
    """Steps of the plant in a period."""

    def __new__(
        cls,
        simulator: Simulator,
        plant: MultibodyPlant,
        *,
        tool: Any,
        bodies: Sequence[Any],
        stiffness: float,
        device_mass: ArrayLike,
        period: float | None = None,
        port: InputPort | None = None,
        **others: float,
    ) -> Contact:
        h = _time_step(plant)
        steps = 1 if period is None else round(period / h) if np.isfinite(period) else 0
        if steps < 1 or (period is not None and abs(period / h - steps) > 1e-6 * steps):
            raise ValueError(
                f"period is {period} s, but must be a whole number of the plant's time steps of {h} s: see MultibodyPlant(time_step)"
            )
        root = simulator.get_system()
        if not any(system is plant for system in _systems(root)):
            raise ValueError(f"the simulator's diagram {root.get_name()!r} has no plant {plant.get_name()!r}")
        if port is None:
            port = plant.get_applied_spatial_force_input_port()
        _unconnected(root, port)
        if isinstance(bodies, (str, RigidBody)):
            raise ValueError(f"bodies is {bodies!r}, but must be a list, such as [{bodies!r}]")
        touched = [_body(plant, body) for body in bodies]
        for body in touched:
            if touched.count(body) > 1:
                raise ValueError(f"bodies names body {body.name()!r} twice")
        if not plant.geometry_source_is_registered():
            raise ValueError(
                f"plant {plant.get_name()!r} has no scene graph, so its bodies have no shapes: see AddMultibodyPlant"
            )
        own = plant.GetMyContextFromRoot(simulator.get_context())
        inspector = plant.EvalSceneGraphInspector(own)
        centres = [_centre(body, own) for body in touched]
        several: list[Any] = [tool] if isinstance(tool, (str, RigidBody)) or np.ndim(tool) == 0 else [*tool]
        tools: dict[str, float] = {}
        spheres = []
        for number, given in enumerate(several):
            if isinstance(given, (str, RigidBody)):
                carrier = _body(plant, given)
                if carrier in touched:
                    raise ValueError(f"bodies names body {carrier.name()!r}, which is the tool")
                sphere, size = _sphere(plant, inspector, carrier)
                spheres.append(sphere)
                name = carrier.name()
            else:
                size = radius(given, ", or a body of the plant or its name")
                name = "tool" if len(several) == 1 else f"tool {number}"
            if name in tools:
                raise ValueError(f"tool names {name!r} twice")
            tools[name] = size
        made = super().__new__(
            cls,
            tools=tools,
            bodies=[_described(plant, inspector, body, centre) for body, centre in zip(touched, centres)],
            period=steps * h,
            device_mass=device_mass,
            stiffness=stiffness,
            # A discrete plant integrates positions with the velocity at the end of a step.
            end_velocity=True,
            **others,
        )
        assert isinstance(made, Contact)
        made.simulator, made.plant, made.steps = simulator, plant, steps
        made._port, made._touched, made._centres, made._spheres = port, touched, centres, spheres
        made._joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
        made._actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
        made._start()
        return made

    _port: InputPort
    _touched: list[RigidBody]
    _centres: list[NDArray[np.float64]]
    """Reference point of the wrenches of each body, in the body frame [m]."""
    _spheres: list[GeometryId]
    """Spheres of the tools that are bodies of the plant."""
    _joints: list[Any]
    _actuators: list[Any]
    _excluded: tuple[Any, Any] | None = None
    """Collision filter manager with the exclusion of the tool spheres, and the number of that exclusion."""
    _is_closed: bool = False
    _applied: list[ExternallyAppliedSpatialForce]
    """Last applied force of each body."""
    _wrenches: NDArray[np.float64]
    """Last applied wrenches, a row for each body: force [N], torque about the centre of mass [N m]."""
    _pushes: bool
    _root: Context
    """Context of the simulator at the lookup of the contexts of plant and port. They are stored because Drake records
    an entry for each lookup."""
    _time: float
    """End of the step of the last push, or simulator time after the last pull [s]."""

    def _start(self) -> None:
        count = len(self._touched)
        root = self.simulator.get_mutable_context()
        self._rows = np.zeros((count, BODY_COLUMNS))
        self._wrenches = np.zeros((count, 6))
        self._applied = [ExternallyAppliedSpatialForce() for _ in self._touched]
        for force, body, centre in zip(self._applied, self._touched, self._centres):
            force.body_index = body.index()
            force.p_BoBq_B = centre
        self._own = self.plant.GetMyMutableContextFromRoot(root)
        self._values = self._port.get_system().GetMyMutableContextFromRoot(root)
        # Scratch context for evaluations, so that the plant's own state does not change.
        self._asked = root.Clone()
        self._after = self.plant.GetMyMutableContextFromRoot(self._asked)
        self._root = root
        self._pushes = False
        self._time = float(root.get_time())
        if self._spheres:
            [scene_graph] = [
                system
                for system in _systems(self.simulator.get_system())
                if isinstance(system, SceneGraph) and system.model_inspector().SourceIsRegistered(self.plant.get_source_id())
            ]
            shapes = [shape for body in self._touched for shape in self.plant.GetCollisionGeometriesForBody(body)]
            excluded = CollisionFilterDeclaration().ExcludeBetween(GeometrySet(self._spheres), GeometrySet(shapes))
            self._let_collide()
            manager = scene_graph.collision_filter_manager(scene_graph.GetMyMutableContextFromRoot(root))
            self._excluded = (manager, manager.ApplyTransient(excluded))

    def step(self, position: ArrayLike, elapsed: float | None = None) -> NDArray[np.float64]:
        """Computes one period: takes a sample of the devices, advances the simulator by the period, and returns the
        force on the device [N] to hold over it.

        Args:
            position: Position of the device in the world frame [m], three numbers; for several devices a row for each.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Returns:
            Three numbers; for several devices a row for each. After an invalid sample they are 0, and `output.fault`
            has the reason; the simulator is still advanced.

        Raises:
            ValueError: The position is not three numbers for each device, or the simulator's time is not at the end of
                a step.
        """
        self.sample(position, elapsed)
        for _ in range(self.steps):
            until = self.push()
            try:
                self.simulator.AdvanceTo(until)
            except BaseException:
                # An error of Drake's solver, or Ctrl-C: remove the pushed forces.
                self._take_out()
                raise
            self.pull()
        return self.hold()

    def sample(self, position: ArrayLike, elapsed: float | None = None) -> None:
        """Begins a period: takes a sample of all devices, as `step` does. Calls `reset` if the simulator's time has
        decreased since the last step or if it has another context."""
        if self._is_closed:
            raise ValueError("this Contact is closed: make another one")
        root = self.simulator.get_mutable_context()
        if root is not self._root or (root.get_time() < self._time and not self._pushes):
            self.reset()
        super().sample(position, elapsed)

    def push(self) -> float:
        """Adds the wrenches of the contacts to the values of the input port, before a step of the plant. For a program
        that advances the simulator itself, between `sample` and `hold`:

            contact.sample(position)
            for _ in range(contact.steps):
                simulator.AdvanceTo(contact.push())
                contact.pull()
            force = contact.hold()

        Several contacts, each with its own device, may push before a step.

        Returns:
            Time at the end of the step [s]; advance the simulator to it.
        """
        if self._pushes:
            raise ValueError("call push() once before each step of the plant, and pull() after it")
        self._same_context()
        h = _time_step(self.plant)
        time = float(self._root.get_time())
        number = round(time / h)
        if abs(time - number * h) > 1e-6 * h:
            raise ValueError(
                f"the simulator's time is {time} s, but must be a whole number of the plant's time steps of {h} s"
            )
        theirs = self._given()
        try:
            # Apply the last wrenches, so that the plant's other contacts are loaded.
            self._write(theirs)
            self._look(h)
            self._wrenches[:] = self.meet(h, self._rows)
            self._write(theirs)
        except BaseException:
            self._give(theirs)
            raise
        self._pushes = True
        self._time = (number + 1) * h
        return self._time

    def pull(self) -> None:
        """Removes the wrenches of the contacts from the input port, after a step of the plant."""
        if not self._pushes:
            raise ValueError("call pull() after push() and a step of the plant")
        self._same_context()
        self._take_out()
        due, self._time = self._time, float(self._root.get_time())
        if abs(self._time - due) > 1e-6 * _time_step(self.plant):
            raise ValueError(f"advance the simulator to {due} s after push(); its time is {self._time} s")

    def reset(self) -> None:
        """Resets samples, contacts and energy ledger. Call it after a body was moved or the simulator got another
        context."""
        super().reset()
        if self._pushes and self.simulator.get_mutable_context() is self._root:
            self._take_out()
        self._start()

    def _let_collide(self) -> None:
        if self._excluded is not None:
            manager, number = self._excluded
            self._excluded = None
            manager.RemoveDeclaration(number)

    def close(self) -> None:
        """Ends the contacts: removes their wrenches from the plant and enables Drake's own contacts of the tools again.
        The end of a `with` block does this too. `sample` then raises an error."""
        if self._pushes and self.simulator.get_mutable_context() is self._root:
            self._take_out()
        self._pushes = False
        self._is_closed = True
        self._let_collide()

    def __enter__(self) -> Contact:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _same_context(self) -> None:
        if self.simulator.get_mutable_context() is not self._root:
            raise ValueError("the simulator got another context within a period: call reset(), then sample()")

    def _given(self) -> list[ExternallyAppliedSpatialForce]:
        """Returns copies of the values of the port."""
        return [copy(force) for force in self._port.Eval(self._values)] if self._port.HasValue(self._values) else []

    def _give(self, forces: list[ExternallyAppliedSpatialForce]) -> None:
        value = self._port.Allocate()
        value.set_value(forces)
        self._port.FixValue(self._values, value)

    def _take_out(self) -> None:
        """Removes the pushed forces from the port."""
        self._pushes = False
        left = self._given()
        for mine in self._applied:
            # The port returns copies, and another contact may have pushed since.
            same = [place for place, force in enumerate(left) if _same(force, mine)]
            if same:
                del left[same[0]]
        self._give(left)

    def _write(self, theirs: list[ExternallyAppliedSpatialForce]) -> None:
        for force, wrench in zip(self._applied, self._wrenches):
            force.F_Bq_W = SpatialForce(tau=wrench[3:], f=wrench[:3])
        self._give(theirs + self._applied)

    def _look(self, h: float) -> None:
        """Writes state and mobility of each body to its row."""
        plant, own, after = self.plant, self._own, self._after
        self._rows[:, 7:] = 0.0
        velocity = plant.GetVelocities(own)
        if plant.has_sampled_output_ports():
            plant.CalcForcedUnrestrictedUpdate(own, after.get_mutable_state())
        else:
            plant.CalcForcedDiscreteVariableUpdate(own, after.get_mutable_discrete_state())
        gained = (plant.GetVelocities(after) - velocity) / h
        inertia = plant.CalcMassMatrix(own)
        goes = np.ones(len(velocity), dtype=bool)
        for joint in self._joints:
            if count := joint.num_velocities():
                first = joint.velocity_start()
                goes[first : first + count] = not joint.is_locked(own)
                # A discrete plant integrates joint damping implicitly.
                along = np.arange(first, first + count)
                inertia[along, along] += h * joint.GetDampingVector(own)
        for actuator in self._actuators:
            if actuator.has_controller():
                # It also integrates the gains of its own controllers implicitly.
                gains = actuator.get_controller_gains()
                at = actuator.joint().velocity_start()
                inertia[at, at] += h * (gains.d + h * gains.p)
        inertia = inertia[np.ix_(goes, goes)]
        world = plant.world_frame()
        for body, centre, row, wrench in zip(self._touched, self._centres, self._rows, self._wrenches):
            pose = plant.EvalBodyPoseInWorld(own, body)
            row[0:3] = pose.multiply(centre)
            row[3:7] = pose.rotation().ToQuaternion().wxyz()
            if plant.IsAnchored(body):
                continue
            asked = (own, JacobianWrtVariable.kV, body.body_frame(), centre, world, world)
            jacobian = plant.CalcJacobianSpatialVelocity(*asked)[_FORCE_FIRST]
            rate = plant.CalcBiasSpatialAcceleration(*asked)
            free = jacobian[:, goes]
            mobility = free @ np.linalg.solve(inertia, free.T)
            row[7:13] = jacobian @ velocity
            row[13:19] = jacobian @ gained + rate.get_coeffs()[_FORCE_FIRST] - mobility @ wrench
            row[19:55] = mobility.ravel()


def _same(one: ExternallyAppliedSpatialForce, other: ExternallyAppliedSpatialForce) -> bool:
    return bool(
        one.body_index == other.body_index
        and np.array_equal(one.p_BoBq_B, other.p_BoBq_B)
        and np.array_equal(one.F_Bq_W.get_coeffs(), other.F_Bq_W.get_coeffs(), equal_nan=True)
    )


def _time_step(plant: MultibodyPlant) -> float:
    if not plant.is_finalized():
        raise ValueError(f"plant {plant.get_name()!r} is not finalized: call Finalize() first")
    h = float(plant.time_step())
    if h == 0:
        raise ValueError(f"plant {plant.get_name()!r} is continuous, but must be discrete: see MultibodyPlant(time_step)")
    return h


def _systems(system: System) -> Iterator[System]:
    """Yields a system and all its subsystems."""
    yield system
    if isinstance(system, Diagram):
        for part in system.GetSystems():
            yield from _systems(part)


def _unconnected(root: System, port: InputPort) -> None:
    """Rejects a port with another source: a fixed value would replace that source permanently."""
    where = (port.get_system(), port.get_index())
    named = f"input port {port.get_name()!r} of {port.get_system().get_name()!r}"
    way = "connect the plant's port to an ExternallyAppliedSpatialForceMultiplexer, and pass a free port of it as port"
    for diagram in _systems(root):
        if not isinstance(diagram, Diagram):
            continue
        if where in diagram.connection_map():
            raise ValueError(f"the {named} is connected, so wrenches cannot be set: {way}")
        for number in range(diagram.num_input_ports()):
            if where in diagram.GetInputPortLocators(InputPortIndex(number)):
                outer = diagram.get_input_port(number).get_name()
                raise ValueError(
                    f"the {named} is exported as {outer!r} of {diagram.get_name()!r}: pass the exported port, or {way}"
                )


def _centre(body: RigidBody, own: Context) -> NDArray[np.float64]:
    """Returns the centre of mass in the body frame [m]; the origin for a body without mass, such as the world."""
    if body.index() == 0 or body.get_mass(own) == 0:
        return np.zeros(3)
    place: NDArray[np.float64] = body.CalcCenterOfMassInBodyFrame(own)
    return place


def _body(plant: MultibodyPlant, given: Any) -> RigidBody:
    if isinstance(given, RigidBody):
        if given.GetParentPlant() is not plant:
            raise ValueError(f"body {given.name()!r} belongs to another plant")
        return given
    if not isinstance(given, str):
        raise ValueError(f"{given!r} is not a body: give a name, or a RigidBody of the plant")
    count = plant.NumBodiesWithName(given)
    if count == 0:
        names = [plant.get_body(BodyIndex(number)).name() for number in range(plant.num_bodies())]
        raise ValueError(f"the plant has no body {given!r}; it has {', '.join(map(repr, names))}")
    if count > 1:
        raise ValueError(f"the plant has {count} bodies {given!r}, in several models: give the RigidBody itself")
    return plant.GetBodyByName(given)


def _sphere(plant: MultibodyPlant, inspector: SceneGraphInspector, carrier: RigidBody) -> tuple[GeometryId, float]:
    """Returns the sphere of a tool body and its radius [m]."""
    shapes = plant.GetCollisionGeometriesForBody(carrier)
    if len(shapes) != 1 or not isinstance(inspector.GetShape(shapes[0]), Sphere):
        kinds = ", ".join(type(inspector.GetShape(shape)).__name__ for shape in shapes) or "none"
        raise ValueError(f"tool: body {carrier.name()!r} must have one sphere as collision shape, but has {kinds}")
    return shapes[0], float(inspector.GetShape(shapes[0]).radius())


def _described(
    plant: MultibodyPlant, inspector: SceneGraphInspector, body: RigidBody, centre: NDArray[np.float64]
) -> EngineBody:
    name = f"body {body.name()!r}"
    shapes = []
    for number in plant.GetCollisionGeometriesForBody(body):
        shape = inspector.GetShape(number)
        word, lengths = _shape(name, inspector.GetName(number), shape)
        points = _corners(shape) if word == "hull" else []
        pose = inspector.GetPoseInFrame(number)
        place = pose.translation() - centre
        shapes.append(PlacedShape(word, lengths, place.tolist(), pose.rotation().ToQuaternion().wxyz().tolist(), points))
    if not shapes:
        raise ValueError(f"{name} has no collision shape, so a tool cannot touch it")
    return EngineBody(name, shapes)


def _shape(name: str, called: str, shape: Any) -> tuple[str, tuple[float, ...]]:
    """Returns the kind and the lengths of a shape, for `PlacedShape`."""
    if isinstance(shape, Sphere):
        return "sphere", (shape.radius(),)
    if isinstance(shape, Box):
        return "box", tuple(0.5 * float(length) for length in shape.size())
    if isinstance(shape, (Capsule, Cylinder)):
        return "capsule" if isinstance(shape, Capsule) else "cylinder", (shape.radius(), 0.5 * shape.length())
    if isinstance(shape, HalfSpace):
        return "half-space", ()
    if isinstance(shape, (Convex, Mesh)):
        # The engine's own point contacts use the hull of a mesh, too.
        return "hull", ()
    raise ValueError(
        f"{name}: its shape {called!r} is of type {type(shape).__name__}; a tool can touch half-spaces, spheres, capsules, "
        "cylinders, boxes and meshes"
    )


def _corners(shape: Convex | Mesh) -> list[list[float]]:
    """Returns the corners of the convex hull of a mesh [m]."""
    hull = shape.GetConvexHull()
    return [hull.vertex(number).tolist() for number in range(hull.num_vertices())]
