//! Coupled rendering: predicts devices and world together, and holds the mean contact force.

use super::coupled_impulse::Impulse;
use super::coupled_ledger::{Moved, ToolInterval, Turned};
use super::coupled_motions::Motions;
use super::coupled_proxy::ProxyState;
use super::coupled_turning::Turning;
use crate::contact::pairs::Point;
use crate::device::observer::{AxisObserver, AxisPrior};
use crate::device::turning_observer::TurningPrior;
use crate::dynamics::linkage::Linkage;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::{Mobility, Rigid, Rotation, Vector3, quaternion};
use crate::integration::interval::{Reach, advance};
use crate::integration::moving::Moving;
use crate::method::state::{Progress, show_contacts};
use crate::{Effort, Limited, Vector, WorldRenderer};

/// Coupled rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Coupled {
    pub(crate) priors: Vec<[AxisPrior; 3]>,
    /// Axes along which each device moves.
    pub(crate) axes: Vec<Axes>,
    /// Linkage of each device with a position-dependent mass.
    pub(super) linkages: Vec<Option<Linkage>>,
    /// Rotational prior of each tool that turns.
    pub(super) turning_priors: Vec<Option<TurningPrior>>,
    pub(super) turn_limit: f64,
    pub(super) turn_return: f64,
    pub(crate) offset_limit: f64,
    pub(crate) offset_return: f64,
    pub(crate) velocity_return: f64,
}

/// State of coupled rendering.
#[derive(Clone, Debug)]
pub(crate) struct CoupledMemory {
    pub devices: Vec<TrackedDevice>,
    /// Durations of the last intervals, the newest last `[s]`.
    periods: [f64; 3],
}

/// Estimated state of a device, and its proxy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrackedDevice {
    /// Position at the last sample `[m]`.
    measured: Vector3,
    observers: [AxisObserver; 3],
    proxy: ProxyState,
    /// Rotational state and model values of a tool that turns.
    turning: Option<(Turning, TurningPrior)>,
    /// Predicted device (scratch buffer).
    ahead: Motions,
    /// Whether the tool was touched in the last interval.
    touched: bool,
}

impl TrackedDevice {
    fn new(
        priors: &[AxisPrior; 3],
        axes: Axes,
        turning: Option<&TurningPrior>,
        measured: Rotation,
    ) -> Self {
        let observers = priors.each_ref().map(AxisObserver::new);
        Self {
            measured: Vector3::zeros(),
            observers,
            proxy: ProxyState::none(),
            turning: turning.map(|prior| (Turning::new(prior, measured), *prior)),
            ahead: Motions::seen_by(&observers, axes),
            touched: false,
        }
    }

    fn seen(&self) -> Motions {
        Motions::seen_by(&self.observers, self.ahead.axes)
    }
}

/// Places a tool's proxy in a world, relative to its device.
fn place(
    moving: &mut Moving,
    tool: usize,
    measured: &Vector3,
    device: &Motions,
    proxy: &ProxyState,
) {
    let part = &mut moving.parts[tool];
    part.rigid.position = measured + device.of(|axis| axis.offset) + proxy.offset;
    part.rigid.velocity = device.of(|axis| axis.velocity) + proxy.velocity_offset;
    part.mobility = Mobility {
        angular: part.mobility.angular,
        is_round: part.mobility.is_round,
        ..device.mobility()
    };
    part.drive = device.drive();
}

/// Returns the state of a world's proxy relative to its device.
fn against(proxy: &Rigid, measured: &Vector3, device: &Motions) -> ProxyState {
    ProxyState {
        offset: proxy.position - measured - device.of(|axis| axis.offset),
        velocity_offset: proxy.velocity - device.of(|axis| axis.velocity),
        ..ProxyState::none()
    }
}

impl CoupledMemory {
    /// Copies the state of `other`, which has the same number of tools.
    pub fn copy_from(&mut self, other: &Self) {
        self.devices.copy_from_slice(&other.devices);
        self.periods = other.periods;
    }

    pub fn new(coupled: &Coupled, period: f64) -> Self {
        Self {
            devices: coupled.devices().collect(),
            periods: [period; 3],
        }
    }

    /// Returns the predicted duration of the next interval: the median of the last three `[s]`.
    fn likely_period(&self) -> f64 {
        let [a, b, c] = self.periods;
        a.min(b).max(a.max(b).min(c))
    }
}

impl Coupled {
    /// Returns the device states before the first sample.
    fn devices(&self) -> impl Iterator<Item = TrackedDevice> {
        let priors = self.priors.iter().zip(&self.turning_priors);
        let devices = priors.zip(&self.axes);
        devices.map(|((priors, turning), axes)| {
            TrackedDevice::new(priors, *axes, turning.as_ref(), Rotation::identity())
        })
    }

    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut CoupledMemory,
        positions: &[Vector],
    ) {
        memory.periods = [renderer.loop_params.period; 3];
        let devices = memory.devices.iter_mut().zip(&self.priors).zip(positions);
        for (tool, ((device, priors), position)) in devices.enumerate() {
            let turned = state.tracking.seen_turn[tool];
            *device = TrackedDevice {
                measured: Vector3::from(*position),
                ..TrackedDevice::new(
                    priors,
                    self.axes[tool],
                    self.turning_priors[tool].as_ref(),
                    turned,
                )
            };
            let (seen, proxy) = (device.seen(), device.proxy);
            place(&mut state.now, tool, &device.measured, &seen, &proxy);
            if let Some((turning, prior)) = &device.turning {
                turning.place(&mut state.now.parts[tool], prior);
            }
        }
        state.now.look(&renderer.points);
        state.ledger.observe(&state.now, &renderer.points);
        let starts = !state.tracking.in_progress;
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            device.proxy.comes_in = starts && Impulse::on(&state.now, renderer, tool).touched;
        }
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
        self.observe(state, memory, positions, elapsed);
        // Integrate the interval again from its start, with the updated device estimates.
        state.now.exchange_gathered(&mut state.ahead);
        state.now.look(points);
        self.carry(&mut state.now, &memory.devices, elapsed);
        state.ledger.observe(&state.now, points);
        state.now.begin();
        let sub_steps = &renderer.loop_params.sub_steps;
        let effort = advance(
            &mut state.now,
            &mut state.room,
            points,
            sub_steps,
            Reach::All,
            elapsed,
        );
        state.ledger.pass(&state.now, points, tools);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            let position = Vector3::from(positions[tool]);
            self.conclude_tool(renderer, state, device, (tool, position), elapsed);
            self.return_proxy(state, device, tool, elapsed);
            limited.offset |= self.limit_offset(&mut device.proxy);
            if let Some((turning, _)) = &mut device.turning {
                limited.offset |= turning.limit_offset(self.turn_limit);
            }
        }
        effort
    }

    /// Updates the estimates of the devices with a sample, and places the proxies at the start of its interval.
    #[inline]
    fn observe(
        &self,
        state: &mut Progress,
        memory: &mut CoupledMemory,
        positions: &[Vector],
        elapsed: f64,
    ) {
        for (tool, (device, priors)) in memory.devices.iter_mut().zip(&self.priors).enumerate() {
            let axes = &self.axes[tool];
            let moved = axes.own(&(Vector3::from(positions[tool]) - device.measured));
            let acted = state.commands.passed(tool);
            let mut before = device.seen();
            if let Some(linkage) = &self.linkages[tool] {
                let way = Vector3::from(positions[tool]) - device.measured;
                before.pass_by(linkage, &device.measured, &way, &acted.sent, elapsed);
            }
            let felt = before.felt([&acted.sent, &acted.lead, &acted.impulse_deviation]);
            for axis in 0..3 {
                device.ahead.along[axis] =
                    device.observers[axis].see(&priors[axis], moved[axis], &felt[axis], elapsed);
            }
            if let Some(linkage) = &self.linkages[tool] {
                // Recompute with the velocity estimate from the new sample.
                let (measured, force) = (device.measured, &acted.intended);
                device.ahead.pass(linkage, &measured, force, elapsed);
            }
            place(
                &mut state.now,
                tool,
                &device.measured,
                &device.ahead,
                &device.proxy,
            );
            if let Some((turning, prior)) = &mut device.turning {
                let acted = state.torque_commands.passed(tool);
                turning.see(prior, &state.tracking.seen_turn[tool], &acted, elapsed);
                turning.place(&mut state.now.parts[tool], prior);
            }
        }
    }

    /// Updates a tool's proxy and energy ledger after an interval that ended with its device at `position` `[m]`.
    #[inline]
    fn conclude_tool(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        device: &mut TrackedDevice,
        (tool, position): (usize, Vector3),
        elapsed: f64,
    ) {
        let acted = state.commands.passed(tool);
        let contacts = Impulse::on(&state.now, renderer, tool);
        let Impulse {
            linear: impulse,
            angular: angular_impulse,
            work,
            touched,
            ..
        } = contacts;
        let start = device.ahead;
        // The force removed by a limit is not compensated: the proxy is computed relative to the device under the
        // unlimited force.
        let end = start.under(&acted, elapsed);
        let part = &state.now.parts[tool];
        let axes = self.axes[tool];
        let mut proxy = against(&part.rigid, &device.measured, &end);
        // Along constrained axes the two differ only by rounding.
        proxy.offset = axes.along(&proxy.offset);
        proxy.velocity_offset = axes.along(&proxy.velocity_offset);

        let way = end.of(|axis| axis.offset) - start.of(|axis| axis.offset);
        let mean = impulse / elapsed;
        let mean_torque = angular_impulse / elapsed;
        let turned = device.turning.as_mut().map(|(turning, prior)| {
            let acted = state.torque_commands.passed(tool);
            let measured = state.tracking.seen_turn[tool];
            let by = (measured * turning.measured.inverse()).scaled_axis();
            let work = turning.conclude(prior, part, &acted, &measured, elapsed);
            Turned { work, acted, by }
        });
        let interval = ToolInterval {
            tool,
            axes,
            part,
            acted,
            way,
            moved: position - device.measured,
            bend: if renderer.loop_params.actuation.hold == palpate_core::Hold::Line {
                (end.of(|axis| axis.velocity) - start.of(|axis| axis.velocity)) / elapsed
            } else {
                Vector3::zeros()
            },
            mean,
            lead: contacts.lead(elapsed),
            mean_torque,
            turned,
            elapsed,
        };
        let to_turn = interval.hold(&renderer.points, &state.now, &mut state.ledger);
        let motion = Moved {
            device: [&start, &end],
            proxy: [&device.proxy, &proxy],
            measured: &device.measured,
        };
        let linkage = self.linkages[tool].as_ref();
        let entry = &mut state.ledger.devices[tool];
        interval.account(entry, &motion, linkage, work - to_turn);

        proxy.was_limited = device.proxy.was_limited || state.now.has_yielded(tool);
        proxy.samples_apart = device.proxy.samples_apart;
        proxy.comes_in = device.proxy.comes_in && touched && !interval.acted.is_whole();
        device.proxy = proxy;
        device.measured = position;
        device.touched = touched;
    }

    /// Decays the offsets of a tool's proxy over an interval of `elapsed` `[s]`.
    #[inline]
    fn return_proxy(
        &self,
        state: &mut Progress,
        device: &mut TrackedDevice,
        tool: usize,
        elapsed: f64,
    ) {
        // A residual impulse may still be in the actuation delay.
        let is_expected =
            state.commands.is_expected(tool) || state.torque_commands.is_expected(tool);
        let is_free = !device.touched && !is_expected;
        let start = &device.ahead;
        let external = start.of(|axis| axis.external);
        let back = if is_free {
            self.walk_back(&mut device.proxy, elapsed)
        } else {
            self.walk_back_in_contact(&mut device.proxy, elapsed)
        };
        let entry = &mut state.ledger.devices[tool];
        entry.walked_back += start.weighted(&external, &back);
        let turns_back = is_free || device.proxy.comes_in;
        if turns_back && let Some((turning, _)) = &mut device.turning {
            let torque = turning.now().external / turning.now().mobility;
            let (most, kept) = self.turns_back(&device.proxy, elapsed);
            let back = turning.walk_back(most, kept);
            entry.walked_back += torque.dot(&back);
        }
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
        state.torque_commands.look_ahead(period);
        let mut effort = Effort::default();
        begin_prediction(points, state, memory);
        state.ahead.look(points);
        show_contacts(&mut state.contacts, &mut state.shown, &state.ahead);
        let sub_steps = &renderer.loop_params.sub_steps;
        for piece in 0..pieces {
            let duration = state.commands.duration(piece);
            self.carry(&mut state.ahead, &memory.devices, duration);
            state.ahead.begin();
            let passed = advance(
                &mut state.ahead,
                &mut state.room,
                points,
                sub_steps,
                Reach::All,
                duration,
            );
            effort = effort.and(passed);
            self.pass_piece(points, state, memory, piece, duration);
        }
        self.carry(&mut state.ahead, &memory.devices, period);
        state.ahead.begin();
        let reach = Reach::OfTools;
        let passed = advance(
            &mut state.ahead,
            &mut state.room,
            points,
            sub_steps,
            reach,
            period,
        );
        effort = effort.and(passed);
        self.command(renderer, state, memory, period);
        effort
    }

    /// Advances the predicted devices over a piece of `duration` `[s]` under the forces in the actuation delay.
    #[inline]
    fn pass_piece(
        &self,
        points: &[Point],
        state: &mut Progress,
        memory: &mut CoupledMemory,
        piece: usize,
        duration: f64,
    ) {
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            // The proxy continues from its state, while it comes in from the device. The device moves under the forces
            // in the actuation delay.
            let coming = state.commands.coming(tool, piece);
            if let Some(linkage) = &self.linkages[tool] {
                let (measured, force) = (device.measured, &coming.intended);
                device.ahead.pass(linkage, &measured, force, duration);
            }
            device.ahead = device.ahead.under(&coming, duration);
            state.ahead.parts[tool].drive = device.ahead.drive();
            if device.proxy.comes_in {
                let (at, seen) = (&device.measured, &device.ahead);
                place(&mut state.ahead, tool, at, seen, &ProxyState::none());
                state.ahead.look(points);
            }
            if let Some((turning, prior)) = &mut device.turning {
                let coming = state.torque_commands.coming(tool, piece);
                turning.resume(prior, &coming, duration);
                turning.drive(&mut state.ahead.parts[tool]);
            }
        }
    }

    /// Commands the forces and torques for the mean contact forces predicted over the next interval of `period` `[s]`.
    #[inline]
    fn command(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &CoupledMemory,
        period: f64,
    ) {
        for (tool, (device, intended)) in memory.devices.iter().zip(&mut state.intended).enumerate()
        {
            let contacts = Impulse::on(&state.ahead, renderer, tool);
            let Impulse {
                linear: impulse,
                angular,
                touched,
                ..
            } = contacts;
            if let Some((turning, prior)) = &device.turning
                && !prior.led
            {
                let mut mean = Vector3::zeros();
                if touched {
                    mean = (angular + turning.residual(prior, &state.ahead, tool)) / period;
                }
                let torque = state.torque_commands.command(tool, &mean, period);
                state.intended_torques[tool] = if touched || torque.norm() > MIN_TORQUE {
                    torque
                } else {
                    Vector3::zeros()
                };
            }
            if !touched {
                // Cancel the remaining force of the actuator lag, if it can be felt.
                let force = state.commands.command(tool, &Vector3::zeros(), period);
                *intended = if force.norm() > MIN_FORCE {
                    force
                } else {
                    Vector3::zeros()
                };
                continue;
            }
            // Impulse correction at the start of the interval that this force governs.
            let start = &state.ahead.parts[tool].drive;
            let residual = self.residual(tool, device, [start.position, start.velocity], period);
            let mean = impulse / period + device.ahead.axes.out(&residual);
            *intended = state.commands.command(tool, &mean, period);
            let gain = state.commands.gain();
            state.slopes.plan(tool, &contacts, gain, period);
        }
    }
}

/// Begins the prediction from the estimated devices at the sample.
#[inline]
fn begin_prediction(points: &[Point], state: &mut Progress, memory: &mut CoupledMemory) {
    // A force needs impulses only.
    state.ahead.keeps_books = false;
    state.ahead.continue_from(&state.now, points);
    state.ahead.exchange_gathered(&mut state.now);
    for (tool, device) in memory.devices.iter_mut().enumerate() {
        device.ahead = device.seen();
        let (at, seen) = (&device.measured, &device.ahead);
        place(&mut state.ahead, tool, at, seen, &device.proxy);
        if let Some((turning, prior)) = &mut device.turning {
            turning.ahead = *turning.now();
            turning.place(&mut state.ahead.parts[tool], prior);
        }
    }
}

impl Coupled {
    /// Sets the motion of the linkage proxies for an interval of `h` `[s]`, after their contacts have been evaluated.
    fn carry(&self, moving: &mut Moving, devices: &[TrackedDevice], h: f64) {
        let parts = moving.parts.iter_mut().zip(&mut moving.carried);
        let of = self.linkages.iter().zip(devices);
        for ((part, carried), (linkage, device)) in parts.zip(of) {
            if let Some(linkage) = linkage {
                let of_interval = linkage.carried(part, &device.ahead.theta(), h);
                // The stability bounds depend on the result.
                of_interval.carry(part, h);
                *carried = Some(of_interval);
            }
        }
    }

    /// Returns the force along a device's axes that brings its velocity to that of its proxy within a `period` `[s]`.
    /// The proxy is at `position` with `velocity`. For a linkage the momenta are made equal, because the proxy is at
    /// a different position.
    fn residual(
        &self,
        tool: usize,
        device: &TrackedDevice,
        [position, velocity]: [Vector3; 2],
        period: f64,
    ) -> Vector3 {
        let ahead = &device.ahead;
        let (theta, own) = (ahead.theta(), ahead.of(|axis| axis.velocity));
        if let Some(linkage) = &self.linkages[tool] {
            let place = device.measured + ahead.of(|axis| axis.offset);
            let [proxy, own] = [[&position, &velocity], [&place, &own]]
                .map(|motion| linkage.momentum(&theta, motion));
            return (proxy - own) / period;
        }
        ahead
            .axes
            .own(&(velocity - own))
            .zip_map(&theta, |residual, mobility| {
                if mobility > 0.0 {
                    residual / (mobility * period)
                } else {
                    0.0
                }
            })
    }
}

/// Force below which the command of an untouched tool is set to zero `[N]`.
pub(crate) const MIN_FORCE: f64 = 1e-6;

/// Torque below which the command of an untouched tool is set to zero `[N m]`.
const MIN_TORQUE: f64 = 1e-8;

impl CoupledMemory {
    /// Writes the estimated state of the tools.
    pub fn publish(&self, state: &mut Progress) {
        for (tool, device) in state.tools.iter_mut().zip(&self.devices) {
            let seen = device.seen();
            let position = device.measured + seen.of(|axis| axis.offset);
            let velocity = seen.of(|axis| axis.velocity);
            let ProxyState {
                offset,
                velocity_offset,
                ..
            } = device.proxy;
            tool.position = position.into();
            tool.velocity = velocity.into();
            tool.offset = offset.into();
            tool.velocity_offset = velocity_offset.into();
            tool.proxy_position = (position + offset).into();
            tool.proxy_velocity = (velocity + velocity_offset).into();
            tool.mass = Some(seen.own(|axis| 1.0 / axis.mobility).into());
            if let Some((turning, prior)) = &device.turning {
                let motion = turning.now();
                let proxy = turning.proxy();
                tool.orientation = quaternion(&motion.orientation);
                tool.angular_velocity = motion.turning(&prior.moments).into();
                tool.proxy_orientation = quaternion(&proxy);
                tool.turn_offset = turning.offset.scaled_axis().into();
                tool.momentum_offset = (turning.momentum_offset / motion.mobility).into();
                tool.inertia = prior.known(motion.mobility).map(Into::into);
            }
        }
    }
}
