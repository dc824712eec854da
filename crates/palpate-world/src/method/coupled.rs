//! Coupled rendering: devices and world are predicted together, and the mean of the contact force is held.

use crate::commands::Acting;
use crate::interval::advance;
use crate::moving::Moving;
use crate::observer::{AxisForce, AxisMotion, AxisObserver, AxisPrior, Prior};
use crate::part::Drive;
use crate::rigid::{Rigid, Vector3};
use crate::state::{Progress, show_contacts};
use crate::{Effort, Limited, Place, Vector, WorldError, WorldRenderer};

/// Parameters of coupled rendering.
///
/// A held force moves a device to another place than the force it stands for would have. So the world never meets the
/// device but its avatar: over each interval avatars and bodies move on together under the continuous contact forces,
/// and each device, by what an observer knows of it, under the force that is held; the difference of the two at the
/// end is the avatar's offset. The held force is the mean of the contact force, with what brings the avatar's velocity
/// back to the device's. With the devices' masses and the forces of the hands known exactly, each held force is the
/// interval mean of the ideal one: no held force can be nearer.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledParams {
    /// Mass of each tool's device along each of the world's axes, within a factor of 2 `[kg]`. The hand's share is
    /// learned. Infinite where no force moves the device: along an axis that it does not have, or in a recording.
    pub device_mass: Vec<Vector>,
    /// Quantum of the position sensors `[m]`, 0 if they are not known to have one.
    pub encoder_quantum: f64,
    /// Largest distance of an avatar from its device `[m]`.
    pub offset_limit: f64,
    /// Speed at which the offset of a tool that touches nothing goes back to zero `[m/s]`.
    pub offset_return: f64,
    /// Time in which the velocity offset of a tool that touches nothing is given up `[s]`.
    pub velocity_return: f64,
    /// What is known of devices and hands before the first sample.
    pub prior: Prior,
}

impl CoupledParams {
    /// Coupled rendering with devices of these masses `[kg]`, by sensors of no known quantum.
    #[must_use]
    pub fn new(device_mass: Vec<Vector>) -> Self {
        Self {
            device_mass,
            encoder_quantum: 0.0,
            offset_limit: 0.01,
            offset_return: 0.001,
            velocity_return: 0.1,
            prior: Prior::default(),
        }
    }

    /// The same with position sensors of `encoder_quantum` `[m]`.
    #[must_use]
    pub fn with_encoder_quantum(self, encoder_quantum: f64) -> Self {
        Self {
            encoder_quantum,
            ..self
        }
    }

    /// The same with another knowledge of devices and hands.
    #[must_use]
    pub fn with_prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    pub(super) fn check(self, tools: usize) -> Result<Coupled, Vec<WorldError>> {
        let mut faults = Vec::new();
        let mut fault = |field: &'static str, message: String| {
            faults.push(WorldError::new(Place::Method, field, "the method", message));
        };
        if self.device_mass.len() != tools {
            fault(
                "device_mass",
                format!(
                    "device_mass has {} entries for {tools} tools; give one for each",
                    self.device_mass.len()
                ),
            );
        }
        for mass in self.device_mass.iter().flatten() {
            let is_mass = *mass > 0.0;
            if !is_mass {
                fault(
                    "device_mass",
                    format!("device_mass is {mass}, and has to be above 0, or infinite"),
                );
            }
        }
        let positive = [
            ("offset_limit", self.offset_limit),
            ("velocity_return", self.velocity_return),
        ];
        for (field, value) in positive {
            let is_positive = value > 0.0;
            if !is_positive {
                fault(field, format!("{field} is {value}, and has to be above 0"));
            }
        }
        let Prior {
            velocity,
            acceleration,
            mobility,
            damping_rate,
            spring_rate,
            jerk,
        } = self.prior;
        let not_negative = [
            ("encoder_quantum", self.encoder_quantum),
            ("offset_return", self.offset_return),
            ("prior.velocity", velocity),
            ("prior.acceleration", acceleration),
            ("prior.mobility", mobility),
            ("prior.damping_rate", damping_rate),
            ("prior.spring_rate", spring_rate),
            ("prior.jerk", jerk),
        ];
        for (field, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                fault(
                    field,
                    format!("{field} is {value}, and has to be at least 0"),
                );
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let of_axis = |mass: f64| AxisPrior::new(mass, self.encoder_quantum, self.prior);
        let priors = self.device_mass.iter().map(|mass| mass.map(of_axis));
        Ok(Coupled {
            priors: priors.collect(),
            offset_limit: self.offset_limit,
            offset_return: self.offset_return,
            velocity_return: self.velocity_return,
        })
    }
}

/// Coupled rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Coupled {
    priors: Vec<[AxisPrior; 3]>,
    offset_limit: f64,
    offset_return: f64,
    velocity_return: f64,
}

/// What coupled rendering remembers.
#[derive(Clone, Debug)]
pub(crate) struct CoupledMemory {
    pub devices: Vec<Device>,
    /// Durations of the last intervals, the newest last `[s]`.
    periods: [f64; 3],
}

/// What is known of a device, and of its avatar.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Device {
    /// Where the last sample has found it `[m]`.
    measured: Vector3,
    observers: [AxisObserver; 3],
    avatar: Avatar,
    /// The device as it is predicted: room.
    ahead: Axes,
    /// Whether something touched it in the interval that has ended.
    touched: bool,
}

/// An avatar against its device.
#[derive(Clone, Copy, Debug)]
struct Avatar {
    /// o: its position less the device's `[m]`.
    offset: Vector3,
    /// w: its velocity less the device's `[m/s]`.
    velocity_offset: Vector3,
}

impl Avatar {
    fn none() -> Self {
        Self {
            offset: Vector3::zeros(),
            velocity_offset: Vector3::zeros(),
        }
    }
}

/// A device as an observer knows it, counted from its measured position.
#[derive(Clone, Copy, Debug)]
struct Axes([AxisMotion; 3]);

impl Axes {
    fn of(&self, quantity: impl Fn(&AxisMotion) -> f64) -> Vector3 {
        Vector3::from(self.0.each_ref().map(quantity))
    }

    fn drive(&self) -> Drive {
        Drive {
            damping_rate: self.of(|axis| axis.damping_rate),
            spring_rate: self.of(|axis| axis.spring_rate),
            ..Drive::constant(self.of(|axis| axis.external))
        }
    }

    /// The device after `h` `[s]` under what a method intended.
    fn under(&self, acting: &Acting, h: f64) -> Self {
        let mut after = *self;
        for (axis, motion) in after.0.iter_mut().enumerate() {
            let force = AxisForce {
                mean: acting.intended[axis],
                lead: acting.lead[axis],
                doubt: 0.0,
            };
            let change = motion.under(&force, h);
            motion.offset += change.travel;
            motion.velocity += change.gained;
            motion.external += change.external;
        }
        after
    }

    /// Sum of `quantity` over the axes that a force can move, each over its mobility.
    fn weighted(&self, quantity: impl Fn(usize) -> f64) -> f64 {
        (0..3)
            .filter(|&axis| self.0[axis].mobility > 0.0)
            .map(|axis| quantity(axis) / self.0[axis].mobility)
            .sum()
    }
}

impl Device {
    fn new(priors: &[AxisPrior; 3]) -> Self {
        let observers = priors.each_ref().map(AxisObserver::new);
        Self {
            measured: Vector3::zeros(),
            observers,
            avatar: Avatar::none(),
            ahead: Axes(observers.each_ref().map(|observer| observer.motion)),
            touched: false,
        }
    }

    fn axes(&self) -> Axes {
        Axes(self.observers.each_ref().map(|observer| observer.motion))
    }
}

/// Puts a tool's avatar into a world, beside its device.
fn place(moving: &mut Moving, tool: usize, measured: &Vector3, device: &Axes, avatar: &Avatar) {
    let part = &mut moving.parts[tool];
    part.rigid.position = measured + device.of(|axis| axis.offset) + avatar.offset;
    part.rigid.velocity = device.of(|axis| axis.velocity) + avatar.velocity_offset;
    part.mobility.linear = device.of(|axis| axis.mobility);
    part.drive = device.drive();
}

/// The avatar in a world against its device.
fn against(avatar: &Rigid, measured: &Vector3, device: &Axes) -> Avatar {
    Avatar {
        offset: avatar.position - measured - device.of(|axis| axis.offset),
        velocity_offset: avatar.velocity - device.of(|axis| axis.velocity),
    }
}

impl CoupledMemory {
    pub fn new(coupled: &Coupled, period: f64) -> Self {
        Self {
            devices: coupled.priors.iter().map(Device::new).collect(),
            periods: [period; 3],
        }
    }

    /// How long the next interval will be `[s]`: the median of the last three.
    fn likely_period(&self) -> f64 {
        let [a, b, c] = self.periods;
        a.min(b).max(a.max(b).min(c))
    }
}

impl Coupled {
    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut CoupledMemory,
        positions: &[Vector],
    ) {
        memory.periods = [renderer.in_loop.period; 3];
        let devices = memory.devices.iter_mut().zip(&self.priors).zip(positions);
        for (tool, ((device, priors), position)) in devices.enumerate() {
            *device = Device {
                measured: Vector3::from(*position),
                ..Device::new(priors)
            };
            let (axes, avatar) = (device.axes(), device.avatar);
            place(&mut state.now, tool, &device.measured, &axes, &avatar);
        }
        state.now.look(&renderer.points);
        state.books.observe(&state.now, &renderer.points);
    }

    pub fn conclude(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut CoupledMemory,
        positions: &[Vector],
        elapsed: f64,
        limited: &mut Limited,
    ) -> Effort {
        let (points, tools) = (&renderer.points, renderer.tools);
        memory.periods = [memory.periods[1], memory.periods[2], elapsed];
        for (tool, (device, priors)) in memory.devices.iter_mut().zip(&self.priors).enumerate() {
            let moved = Vector3::from(positions[tool]) - device.measured;
            let acted = state.commands.passed(tool);
            for axis in 0..3 {
                let force = AxisForce {
                    mean: acted.sent[axis],
                    lead: acted.lead[axis],
                    doubt: acted.doubt[axis],
                };
                device.ahead.0[axis] =
                    device.observers[axis].see(&priors[axis], moved[axis], &force, elapsed);
            }
            place(
                &mut state.now,
                tool,
                &device.measured,
                &device.ahead,
                &device.avatar,
            );
        }
        // The interval anew, from where it began, with what the sample tells of it.
        state.now.look(points);
        state.books.observe(&state.now, points);
        state.now.begin();
        let sub_steps = &renderer.in_loop.sub_steps;
        let effort = advance(&mut state.now, &mut state.room, points, sub_steps, elapsed);
        state.books.pass(&state.now, points, tools);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            let acted = state.commands.passed(tool);
            let (impulse, touched) = impulse_on(&state.now, renderer, tool);
            let start = device.ahead;
            // What a limit took from a force is not owed to anybody: the avatar goes where the whole force would have
            // brought the device.
            let end = start.under(&acted, elapsed);
            let part = &state.now.parts[tool];
            let avatar = against(&part.rigid, &device.measured, &end);

            let way = end.of(|axis| axis.offset) - start.of(|axis| axis.offset);
            let mean = impulse / elapsed;
            let book = &mut state.books.devices[tool];
            for (point, (touch, contact)) in points
                .iter()
                .zip(state.now.touches.iter().zip(&mut state.books.contacts))
            {
                if point.first == tool {
                    let held = touch.past.impulse.dot(&way) / elapsed;
                    contact.held += held;
                    book.held += held;
                }
            }
            let moved = Vector3::from(positions[tool]) - device.measured;
            book.port_work += acted.sent.dot(&moved);
            book.unforeseen = book.port_work - book.held;
            let [before, after] = [&device.avatar, &avatar].map(|avatar| avatar.velocity_offset);
            let kinetic = |device: &Axes, w: &Vector3| {
                device.weighted(|axis| w[axis] * (device.0[axis].velocity + 0.5 * w[axis]))
            };
            let gained = start.weighted(|axis| {
                let [u, v] = [&start, &end].map(|device| device.0[axis].velocity);
                0.5 * (v - u) * (v + u)
            });
            book.offset += part.driven - (gained - acted.intended.dot(&way));
            book.velocity_offset += kinetic(&end, &after) - kinetic(&start, &before);
            book.unpaid += (mean - acted.intended).dot(&way);

            device.avatar = avatar;
            device.measured = Vector3::from(positions[tool]);
            device.touched = touched;
            // What was owed to the device may still be on its way.
            if !touched && !state.commands.is_expected(tool) {
                let external = start.of(|axis| axis.external);
                let back = self.walk_back(device, elapsed);
                let book = &mut state.books.devices[tool];
                book.walked_back += start.weighted(|axis| external[axis] * back[axis]);
            }
            let norm = device.avatar.offset.norm();
            if norm > self.offset_limit {
                device.avatar.offset *= self.offset_limit / norm;
                limited.offset = true;
            }
        }
        effort
    }

    /// The avatar of a tool that touches nothing goes back to its device. Returns the change of its offset.
    fn walk_back(&self, device: &mut Device, elapsed: f64) -> Vector3 {
        let Avatar {
            offset,
            velocity_offset,
        } = &mut device.avatar;
        let norm = offset.norm();
        let most = self.offset_return * elapsed;
        let back = if norm <= most {
            -*offset
        } else {
            *offset * (-most / norm)
        };
        *offset += back;
        *velocity_offset *= 1.0 - (elapsed / self.velocity_return).min(1.0);
        back
    }

    pub fn plan(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut CoupledMemory,
    ) -> Effort {
        let points = &renderer.points;
        let period = memory.likely_period();
        let pieces = state.commands.look_ahead(period);
        let mut effort = Effort::default();
        state.ahead.copy_from(&state.now);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            device.ahead = device.axes();
            place(
                &mut state.ahead,
                tool,
                &device.measured,
                &device.ahead,
                &device.avatar,
            );
        }
        state.ahead.look(points);
        show_contacts(&mut state.contacts, &state.ahead);
        let sub_steps = &renderer.in_loop.sub_steps;
        for piece in 0..pieces {
            let duration = state.commands.duration(piece);
            state.ahead.begin();
            let passed = advance(
                &mut state.ahead,
                &mut state.room,
                points,
                sub_steps,
                duration,
            );
            effort = effort.and(passed);
            for (tool, device) in memory.devices.iter_mut().enumerate() {
                // The avatar goes on from where it is, the device under the force that is on its way.
                device.ahead = device
                    .ahead
                    .under(&state.commands.coming(tool, piece), duration);
                state.ahead.parts[tool].drive = device.ahead.drive();
            }
        }
        state.ahead.begin();
        let passed = advance(&mut state.ahead, &mut state.room, points, sub_steps, period);
        effort = effort.and(passed);
        for (tool, (device, intended)) in memory.devices.iter().zip(&mut state.intended).enumerate()
        {
            let (impulse, touched) = impulse_on(&state.ahead, renderer, tool);
            if !touched {
                // What a lag still carries is taken back, as far as it can be felt.
                let force = state.commands.command(tool, &Vector3::zeros(), period);
                *intended = if force.norm() > LEAST_FORCE {
                    force
                } else {
                    Vector3::zeros()
                };
                continue;
            }
            // What is owed at the beginning of the interval that this force governs.
            let start = state.ahead.parts[tool].drive.velocity;
            let owed = start - device.ahead.of(|axis| axis.velocity);
            let mut mean = impulse / period;
            for axis in 0..3 {
                let mobility = device.ahead.0[axis].mobility;
                if mobility > 0.0 {
                    mean[axis] += owed[axis] / (mobility * period);
                }
            }
            *intended = state.commands.command(tool, &mean, period);
        }
        effort
    }
}

/// Forces below this are none, where nothing touches a tool `[N]`.
const LEAST_FORCE: f64 = 1e-6;

/// Impulse of the contacts on a tool over the interval `[N s]`, and whether anything touched it.
fn impulse_on(moving: &Moving, renderer: &WorldRenderer, tool: usize) -> (Vector3, bool) {
    let mut sum = Vector3::zeros();
    let mut touched = false;
    for (point, touch) in renderer.points.iter().zip(&moving.touches) {
        if point.first == tool {
            sum += touch.past.impulse;
            touched |= !touch.is_apart() || touch.past.impulse != Vector3::zeros();
        }
    }
    (sum, touched)
}

impl CoupledMemory {
    /// Writes what is known of the tools.
    pub fn publish(&self, state: &mut Progress) {
        for (tool, device) in state.tools.iter_mut().zip(&self.devices) {
            let axes = device.axes();
            let position = device.measured + axes.of(|axis| axis.offset);
            let velocity = axes.of(|axis| axis.velocity);
            let Avatar {
                offset,
                velocity_offset,
            } = device.avatar;
            tool.position = position.into();
            tool.velocity = velocity.into();
            tool.offset = offset.into();
            tool.velocity_offset = velocity_offset.into();
            tool.avatar_position = (position + offset).into();
            tool.avatar_velocity = (velocity + velocity_offset).into();
            tool.mass = Some(axes.of(|axis| 1.0 / axis.mobility).into());
        }
    }
}
