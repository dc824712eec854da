//! One tick of a world, common to all methods.

mod sent;

use nalgebra::UnitQuaternion;
use palpate_core::Fault;

use crate::contact::broad_phase::List;
use crate::contact::convex_pairs::Blocks;
use crate::contact::nearby::Nearby;
use crate::contact::pairs::{Point, Side, points};
use crate::contact::point::Touch;
use crate::device::commands::Commands;
use crate::device::guard::Account;
use crate::device::tracking::Tracking;
use crate::dynamics::joint_springs::Link;
use crate::dynamics::ledger::{
    BodyLedger, ContactLedger, CreatedAtPorts, Departed, DeviceLedger, EnergyLedger, FieldLedger,
    JointLedger,
};
use crate::dynamics::moving_body::{Drive, Part};
use crate::dynamics::potentials::Potential;
use crate::geometry::axes::Axes;
use crate::geometry::mesh::Surface;
use crate::geometry::rigid::{Mobility, Rigid, Vector3};
use crate::integration::interval::would_grow;
use crate::integration::moving::{Moving, Room};
use crate::integration::yielding::ForceLimit;
use crate::method::far_side::Entry;
use crate::method::initial::{fields, links, part_of};
use crate::method::lines::{self, Slopes};
use crate::method::state::{ContactState, Progress, Shown, ToolState, WorldState, body_state};
use crate::method::{Checked, Memory, WorldMethod};
use crate::{
    Effort, Limited, Output, Sample, Vector, World, WorldErrors, WorldFault, WorldGuard, WorldLoop,
};

/// Renderer of a world by one method in one loop. It is immutable: a tick cannot change a parameter, and one renderer
/// serves any number of [`WorldState`]s.
#[derive(Clone, Debug)]
pub struct WorldRenderer {
    pub(crate) loop_params: WorldLoop,
    pub(crate) points: Vec<Point>,
    /// Number of points of tools, which come first.
    pub(crate) tool_points: usize,
    pub(crate) nearby: Nearby,
    pub(crate) tools: usize,
    /// World from which the renderer was created; `described` is the method.
    pub(crate) world: World,
    pub(crate) described: WorldMethod,
    /// Whether each tool turns.
    pub(crate) turns: Vec<bool>,
    /// Axes along which each device moves its tool.
    pub(crate) axes: Vec<Axes>,
    /// Initial tools, then bodies.
    pub(crate) parts: Vec<Part>,
    pub(crate) surfaces: Vec<Surface>,
    pub(crate) blocks: Vec<Blocks>,
    pub(crate) links: Vec<Link>,
    joints: usize,
    fields: Vec<Potential>,
    method: Checked,
}

impl WorldRenderer {
    /// Checks world, loop and method, and computes all quantities that depend only on them.
    ///
    /// # Errors
    ///
    /// Returns all faults of the world, or otherwise those of its pairs, the loop and the method (at least one).
    pub fn new(
        world: &World,
        loop_params: WorldLoop,
        method: impl Into<WorldMethod>,
    ) -> Result<Self, WorldErrors> {
        world.check()?;
        let tools = world.tools.len();
        let mut faults = Vec::new();
        let mut parts: Vec<_> = world
            .tools
            .iter()
            .map(|tool| {
                let mobility = Mobility {
                    linear_axes: Axes::new(tool.axes, tool.own_axes).own_axes(),
                    ..Mobility::none()
                };
                let nowhere = Rigid {
                    position: Vector3::zeros(),
                    orientation: UnitQuaternion::identity(),
                    velocity: Vector3::zeros(),
                    spin: Vector3::zeros(),
                };
                Part {
                    is_tool: true,
                    has_torque: tool.turns,
                    led: tool.is_led(),
                    ..Part::new(nowhere, mobility, Drive::constant(Vector3::zeros()))
                }
            })
            .collect();
        parts.extend(world.bodies.iter().map(part_of));
        let mut mobilities: Vec<_> = parts.iter().map(|part| part.mobility).collect();
        faults.extend(loop_params.faults(tools));
        let described = method.into();
        faults.extend(lines::faults(&world.tools, &loop_params, &described));
        let method = described.clone().check(&world.tools, &world.fields);
        if let Ok(method) = &method {
            for (tool, mobility) in mobilities[..tools].iter_mut().enumerate() {
                mobility.angular = method.angular_mobility(tool);
            }
        }
        let links = links(world, &parts);
        let points = points(world, &mobilities);
        let (mut found, method) = match (points, method) {
            (Ok(found), Ok(method)) if faults.is_empty() => (found, method),
            (points, method) => {
                faults.extend(points.err().into_iter().flatten());
                faults.extend(method.err().into_iter().flatten());
                return Err(WorldErrors::all(faults));
            }
        };
        for point in &mut found.points {
            point.is_held = method.holds_contacts() && point.tool(tools).is_some();
        }
        let surfaces = found.surfaces.iter().map(Surface::parts).collect();
        // A joint to the world has its body on both sides.
        let sides = links
            .iter()
            .map(|link| [link.first, link.second.unwrap_or(link.first)]);
        let sides = [surfaces, sides.collect()];
        let tool_shapes = world.tools.iter().map(|tool| &tool.shape);
        let shapes = tool_shapes.chain(world.bodies.iter().map(|body| &body.shape));
        let halves = shapes.map(crate::Shape::half_extents);
        let bodies = parts[tools..].iter();
        let free_bodies = bodies.filter(|part| !part.is_fixed).count();
        Ok(Self {
            loop_params,
            tool_points: found
                .points
                .iter()
                .filter(|point| point.tool(tools).is_some())
                .count(),
            nearby: Nearby::new(
                &found.points,
                &found.blocks,
                found.patches,
                sides,
                halves.collect(),
                free_bodies,
            ),
            points: found.points,
            tools,
            world: world.clone(),
            described,
            turns: world.tools.iter().map(|tool| tool.turns).collect(),
            axes: world
                .tools
                .iter()
                .map(|tool| Axes::new(tool.axes, tool.own_axes))
                .collect(),
            parts,
            surfaces: found.surfaces,
            blocks: found.blocks,
            links,
            joints: world.joints.len(),
            fields: fields(world),
            method,
        })
    }

    /// Returns the loop parameters.
    #[must_use]
    pub fn loop_params(&self) -> &WorldLoop {
        &self.loop_params
    }

    /// Returns the name of a tool or body.
    #[must_use]
    pub fn name_of(&self, side: Side) -> &str {
        match side {
            Side::Tool(number) => &self.world.tools[number].name,
            Side::Body(number) => &self.world.bodies[number].name,
        }
    }

    /// Creates a state before the first sample, with the bodies in their initial states and an empty energy ledger.
    /// At the first sample the devices are assumed to be at rest.
    #[must_use]
    pub fn start(&self) -> WorldState {
        let now = Moving {
            parts: self.parts.clone(),
            tools: self.tools,
            touches: vec![Touch::apart(); self.points.len()],
            nearby: self.nearby.clone(),
            surfaces: self.surfaces.clone(),
            blocks: self.blocks.clone(),
            links: self.links.clone(),
            fields: self.fields.clone(),
            carried: vec![None; self.carried()],
            keeps_books: true,
            expects_the_missed: false,
            held: self.method.held_tools(self),
            limits: self.limits_in_motion(),
            rates: vec![(0.0, 0.0); self.parts.len()],
            within_reach: List::new(self.points.len()),
            elapsed: 0.0,
        };
        let side = |number: usize| Side::new(number, self.tools);
        let contacts = self.points.iter();
        let contacts =
            contacts.map(|point| ContactState::apart([point.first, point.second].map(side)));
        let bodies = &self.parts[self.tools..];
        // If no tool turns, no torque is tracked.
        let turning = if self.turns.contains(&true) {
            self.tools
        } else {
            0
        };
        let mut progress = Progress {
            ahead: now.clone(),
            room: Room {
                before: now.clone(),
                start: now.clone(),
            },
            tracking: Tracking::new(&self.turns),
            commands: Commands::new(
                self.tools,
                &self.loop_params.actuation,
                self.loop_params.period,
            ),
            torque_commands: Commands::new(
                turning,
                &self.loop_params.actuation,
                self.loop_params.period,
            ),
            intended: vec![Vector3::zeros(); self.tools],
            intended_torques: vec![Vector3::zeros(); self.tools],
            slopes: Slopes::new(self.tools, &self.loop_params),
            forces: vec![[0.0; 3]; self.tools],
            torques: vec![[0.0; 3]; self.tools],
            tools: vec![ToolState::default(); self.tools],
            bodies: bodies.iter().map(body_state).collect(),
            contacts: contacts.collect(),
            shown: Shown {
                numbers: List::new(self.points.len()),
                sides: vec![Entry::default(); self.points.len()],
            },
            at_ports: CreatedAtPorts::none(self.points.len() + self.fields.len()),
            ledger: EnergyLedger {
                contacts: vec![ContactLedger::default(); self.points.len()],
                bodies: bodies
                    .iter()
                    .map(|part| BodyLedger {
                        kinetic: part.mobility.kinetic_energy(&part.rigid),
                        ..BodyLedger::default()
                    })
                    .collect(),
                joints: self.joints_at_start(),
                fields: vec![FieldLedger::default(); self.fields.len()],
                devices: vec![DeviceLedger::default(); self.tools],
                gone: Departed::default(),
            },
            guard: Account::new(&self.loop_params, self.tools),
            now,
        };
        let ledger = &progress.ledger;
        let bodies: f64 = ledger.bodies.iter().map(|entry| entry.kinetic).sum();
        let joints: f64 = ledger.joints.iter().map(|entry| entry.stored).sum();
        progress.guard.appeared(bodies + joints);
        let memory = self.method.memory(self);
        self.publish(&mut progress, &memory);
        WorldState { progress, memory }
    }

    /// Returns the force limits that the motion of proxies includes. A tool that is fixed between samples has none.
    fn limits_in_motion(&self) -> Vec<ForceLimit> {
        if self.method.yields_to_limits() {
            let WorldLoop {
                force_limits,
                actuation,
                ..
            } = &self.loop_params;
            ForceLimit::each(force_limits, actuation, &self.axes)
        } else {
            Vec::new()
        }
    }

    /// Returns the number of tools for which a proxy with position-dependent mass must be provided.
    fn carried(&self) -> usize {
        let mut tools = self.world.tools.iter();
        if tools.any(|tool| tool.mass_table.is_some()) {
            self.tools
        } else {
            0
        }
    }

    /// Returns the initial ledgers of the joints, whose springs may be stretched.
    fn joints_at_start(&self) -> Vec<JointLedger> {
        let mut ledger = vec![JointLedger::default(); self.joints];
        let mut parts = self.parts.clone();
        for mut link in self.links.iter().copied() {
            link.meet(&mut parts);
            ledger[link.joint].stored += link.stored;
        }
        ledger
    }

    /// Performs one tick: takes a sample of all devices and returns the forces and torques to hold until the next
    /// one.
    ///
    /// `state` must have been started by this renderer; with the state of another renderer a tick may panic.
    /// Otherwise a tick never panics, allocates, blocks or loops without bound, and its forces and torques are finite
    /// for any input.
    ///
    /// An unusable sample gives zero forces and torques and a fault. The bodies then pause, and keep their positions
    /// and momentum from the last used sample.
    pub fn step<'s>(&self, state: &'s mut WorldState, sample: &Sample<'_>) -> Output<'s> {
        let WorldState { progress, memory } = state;
        let elapsed = progress.tracking.believe(sample, &self.loop_params);
        let duration = *elapsed.as_ref().unwrap_or(&self.loop_params.period);
        if self.loop_params.guard != WorldGuard::Off {
            let commands = (&progress.commands, &progress.torque_commands);
            progress.guard.foresee(commands, duration);
        }
        progress.commands.pass(duration);
        progress.torque_commands.pass(duration);
        self.account(progress, elapsed.is_ok(), duration);
        let mut effort = Effort::default();
        let answer = elapsed
            .and_then(|elapsed| self.try_step(progress, memory, sample, (elapsed, &mut effort)));
        let (limited, fault) = match answer {
            Ok(limited) => (limited, None),
            Err(fault) => {
                progress.tracking.in_progress = false;
                progress.intended.fill(Vector3::zeros());
                progress.slopes.clear();
                progress.intended_torques.fill(Vector3::zeros());
                progress.forces.fill([0.0; 3]);
                progress.torques.fill([0.0; 3]);
                (Limited::default(), Some(fault))
            }
        };
        progress.close_ports();
        progress.send();
        self.publish(progress, memory);
        progress.now.end_tick();
        Output {
            forces: &progress.forces,
            slopes: &progress.slopes.sent,
            torques: &progress.torques,
            limited,
            effort,
            fault,
        }
    }

    /// Performs the tick. `effort` is set for a rejected sample too.
    fn try_step(
        &self,
        state: &mut Progress,
        memory: &mut Memory,
        sample: &Sample<'_>,
        (elapsed, effort): (f64, &mut Effort),
    ) -> Result<Limited, WorldFault> {
        let overflow = WorldFault {
            fault: Fault::Overflow,
            tool: None,
        };
        let mut limited = Limited::default();
        let positions = sample.positions;
        let begins = !state.tracking.in_progress;
        if !begins {
            *effort = self
                .method
                .conclude(self, state, memory, positions, elapsed, &mut limited);
            if !state.now.is_finite() {
                self.put_back(state);
                return Err(overflow);
            }
        } else {
            state.now.forget_sides();
            let before = state.ledger.observed();
            self.method.begin(self, state, memory, positions);
            state.guard.appeared(state.ledger.observed() - before);
        }
        state.tracking.trust();
        *effort = effort.and(self.plan(state, memory));
        // Otherwise the next sample would be rejected, and this force would return after it.
        if begins && !effort.unstable {
            let WorldLoop {
                sub_steps, period, ..
            } = &self.loop_params;
            let Progress { now, room, .. } = state;
            effort.unstable = would_grow(now, room, &self.points, sub_steps, *period);
            effort.too_fast |= effort.unstable;
        }
        let intended = state.intended.iter().chain(&state.intended_torques);
        let intended = intended.chain(&state.slopes.intended);
        if effort.unstable || !intended.flatten().all(|x| x.is_finite()) {
            self.put_back(state);
            return Err(overflow);
        }
        let limits = (
            &self.loop_params.force_limits,
            &self.loop_params.torque_limits,
        );
        let gain = self.loop_params.actuation.limit_gain();
        limited.force = limit(&state.intended, &mut state.forces, limits.0, gain);
        limited.force |= state.slopes.limit(&state.forces, &self.loop_params);
        limited.force |= (0..self.tools).any(|tool| state.ahead.has_yielded(tool));
        limited.torque = limit(&state.intended_torques, &mut state.torques, limits.1, gain);
        limited.guard = self.guard(state);
        limited.beyond_guard = state.guard.is_exceeded();
        Ok(limited)
    }

    /// Starts the method with the devices at these positions `[m]`, at rest, and plans the next interval.
    pub(crate) fn begin_and_plan(
        &self,
        state: &mut Progress,
        memory: &mut Memory,
        positions: &[Vector],
    ) {
        self.method.begin(self, state, memory, positions);
        let _ = self.plan(state, memory);
    }

    /// Computes the method's forces and torques, restricted to the axes that the devices have.
    fn plan(&self, state: &mut Progress, memory: &mut Memory) -> Effort {
        state.slopes.clear();
        let effort = self.method.plan(self, state, memory);
        let slopes = state.slopes.intended.iter_mut();
        for ((intended, slope), axes) in state.intended.iter_mut().zip(slopes).zip(&self.axes) {
            *intended = axes.along(intended);
            *slope = axes.along(slope);
        }
        effort
    }

    /// Updates the guard for an interval of `duration` `[s]` that has ended, with an accepted or rejected sample.
    fn account(&self, state: &mut Progress, is_believed: bool, duration: f64) {
        let Some(params) = self.loop_params.guard.params() else {
            return;
        };
        let is_known = is_believed && state.tracking.in_progress;
        let tracking = &state.tracking;
        let moved = is_known.then_some(|tool| tracking.moved(tool));
        let commands = (&state.commands, &state.torque_commands);
        state.guard.pass(params, commands, moved, duration);
    }

    /// Limits forces and torques to the guard's bound, if it is set to limit. Returns whether they exceeded it.
    fn guard(&self, state: &mut Progress) -> bool {
        let Some(params) = self.loop_params.guard.params() else {
            return false;
        };
        let commands = (&state.commands, &state.torque_commands);
        let period = self.loop_params.period;
        state.guard.count(params, &state.ledger, commands, period);
        let wrenches = state.forces.iter().zip(&state.torques);
        let kept = self.kept(state, wrenches.map(|(force, torque)| [*force, *torque]));
        if let Some(kept) = kept.filter(|_| self.loop_params.guard.limits()) {
            for vector in state.forces.iter_mut().chain(&mut state.torques) {
                *vector = vector.map(|x| x * kept + 0.0);
            }
        }
        kept.is_some()
    }

    /// Returns the part of these forces `[N]` and torques `[N m]` that the guard allows, if they exceed its bound.
    fn kept(&self, state: &Progress, wrenches: impl Iterator<Item = [Vector; 2]>) -> Option<f64> {
        let params = self.loop_params.guard.params()?;
        let gain = state.commands.gain();
        let delivered = wrenches.map(|wrench| wrench.map(|part| Vector3::from(part) * gain));
        state.guard.kept(params, delivered, self.loop_params.period)
    }

    /// Limits other forces and torques, to be held instead of the last output, to the limits of the loop and its
    /// guard. Returns which limits acted. `held` has one entry per tool; `parts` gives its force `[N]` and torque `[N
    /// m]`. A guard that only reports in a tick only reports here. [`keep_slope_within`](Self::keep_slope_within) bounds
    /// the slopes of lines.
    pub fn keep_within<T>(
        &self,
        state: &WorldState,
        held: &mut [T],
        parts: impl Fn(&mut T) -> [&mut Vector; 2],
    ) -> Limited {
        let state = &state.progress;
        let mut limited = Limited::default();
        let gain = self.loop_params.actuation.limit_gain();
        for (tool, held) in held.iter_mut().enumerate() {
            let [force, torque] = parts(held);
            limited.force |= shorten(force, self.loop_params.force_limits.get(tool), gain);
            limited.torque |= shorten(torque, self.loop_params.torque_limits.get(tool), gain);
        }
        let wrenches = held.iter_mut().map(|held| parts(held).map(|part| *part));
        let kept = self.kept(state, wrenches);
        limited.guard = kept.is_some();
        if let Some(kept) = kept.filter(|_| self.loop_params.guard.limits()) {
            for vector in held.iter_mut().flat_map(parts) {
                *vector = vector.map(|x| x * kept + 0.0);
            }
        }
        limited
    }

    /// Bounds the slope `[N/s]` of a line with this `mean` `[N]`, kept within the limits of the loop, such that both
    /// ends are within the force limit of the tool. Returns whether it was bounded.
    pub fn keep_slope_within(&self, tool: usize, mean: &Vector, slope: &mut Vector) -> bool {
        lines::bound_slope(tool, mean, slope, &self.loop_params)
    }
}

/// Scales the command of each tool to its limit, if there are limits. Returns whether one acted.
fn limit(intended: &[Vector3], sent: &mut [Vector], limits: &[f64], gain: f64) -> bool {
    let mut acted = false;
    for (tool, (intended, sent)) in intended.iter().zip(sent).enumerate() {
        *sent = (*intended).into();
        acted |= shorten(sent, limits.get(tool), gain);
    }
    acted
}

/// Scales down a vector that exceeds `most` after a `gain`. Returns whether it did.
fn shorten(vector: &mut Vector, most: Option<&f64>, gain: f64) -> bool {
    let long = Vector3::from(*vector);
    let norm = long.norm();
    let most = most.map(|most| most / gain).filter(|most| norm > *most);
    if let Some(most) = most {
        *vector = (long * (most / norm)).into();
    }
    most.is_some()
}

impl WorldRenderer {
    /// Resets the bodies to their initial states after a non-finite motion.
    fn put_back(&self, state: &mut Progress) {
        let Moving { parts, links, .. } = &mut state.now;
        parts.copy_from_slice(&self.parts);
        for link in links {
            link.meet(parts);
        }
        // Discard the loads of the joints.
        parts.copy_from_slice(&self.parts);
        for &number in state.now.nearby.recent() {
            state.now.touches[number] = Touch::apart();
        }
        state.now.forget_sides();
        for (part, entry) in self.parts[self.tools..]
            .iter()
            .zip(&mut state.ledger.bodies)
        {
            let kinetic = part.mobility.kinetic_energy(&part.rigid);
            entry.outside += kinetic - entry.kinetic;
            entry.kinetic = kinetic;
        }
        for entry in &mut state.ledger.contacts {
            entry.observed -= entry.stored;
            state.guard.appeared(-entry.stored);
            entry.stored = 0.0;
        }
        for entry in &mut state.ledger.fields {
            entry.observed -= entry.stored;
            state.guard.appeared(-entry.stored);
            entry.stored = 0.0;
        }
        state.now.fields.copy_from_slice(&self.fields);
        for (number, entry) in state.ledger.joints.iter_mut().enumerate() {
            let links = state.now.links.iter().filter(|link| link.joint == number);
            let stored: f64 = links.map(|link| link.stored).sum();
            entry.outside += stored - entry.stored;
            state.guard.appeared(stored - entry.stored);
            entry.stored = stored;
        }
    }

    /// Copies the body states.
    pub(crate) fn show_bodies(&self, state: &mut Progress) {
        for (part, body) in state.now.parts[self.tools..].iter().zip(&mut state.bodies) {
            *body = body_state(part);
        }
    }

    /// Copies the readable part of a state.
    pub(crate) fn publish(&self, state: &mut Progress, memory: &Memory) {
        self.show_bodies(state);
        memory.publish(state);
        self.watch_sides(state);
        let sent = state.forces.iter().zip(&state.torques);
        for (tool, (force, torque)) in state.tools.iter_mut().zip(sent) {
            tool.force = *force;
            tool.torque = *torque;
        }
    }
}
