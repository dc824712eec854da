//! The device side of a period: device estimates, proxy states and held forces.

use palpate_core::{Fault, Hold};

use super::contact_point::Touch;
use super::image::{Image, ImageOffset};
use super::integration::Meeting;
use super::pairs::Pair;
use super::state::{
    BodyPortLedger, EngineContact, EngineLedger, EngineState, Period, PortLedger, TrackedDevice,
};
use crate::device::commands::Commands;
use crate::device::observer::{AxisForce, AxisMotion};
use crate::device::tracking::Tracking;
use crate::dynamics::ledger::CreatedAtPorts;
use crate::dynamics::moving_body::{Drive, Part};
use crate::geometry::rigid::{Mobility, Rigid, Rotation, Vector3};
use crate::integration::interval::MAX_TIMES;
use crate::integration::yielding::ForceLimit;
use crate::method::coupled::{Coupled, MIN_FORCE};
use crate::method::coupled_proxy::SLOWLY_BACK;
use crate::{
    ContactLedger, CoupledParams, Effort, Limited, Mode, Sample, Tool, ToolState, Vector,
    WorldError, WorldErrors, WorldField, WorldGuard, WorldLoop, WorldPart,
};

/// Devices coupled to images of bodies, in one loop.
#[derive(Clone, Debug)]
pub(super) struct Coupling {
    pub loop_params: WorldLoop,
    pub coupled: Coupled,
}

impl Coupling {
    /// Checks tools, loop and parameters. `faults` are the faults of the bodies; `bodies` names their owner in
    /// messages.
    pub fn checked(
        tools: &[Tool],
        loop_params: WorldLoop,
        params: CoupledParams,
        bodies: &str,
        mut faults: Vec<WorldError>,
    ) -> Result<Self, WorldErrors> {
        faults.extend(loop_params.faults(tools.len()));
        if loop_params.actuation.hold == Hold::Line {
            let message = format!(
                "the actuation holds a line, but devices beside {bodies} bodies hold a constant"
            );
            faults.push(WorldError::new(
                WorldPart::Loop,
                WorldField::Actuation,
                "the loop",
                message,
            ));
        }
        if loop_params.guard != WorldGuard::Off {
            let message = format!(
                "guard is on, but {bodies} bodies have no energy ledger for it; turn it off"
            );
            faults.push(WorldError::new(
                WorldPart::Loop,
                WorldField::Guard,
                "the loop",
                message,
            ));
        }
        match params.check(tools) {
            Ok(coupled) if faults.is_empty() => Ok(Self {
                loop_params,
                coupled,
            }),
            checked => {
                faults.extend(checked.err().into_iter().flatten());
                Err(WorldErrors::all(faults))
            }
        }
    }

    /// Creates a state before the first sample: no contact, empty energy ledger.
    pub fn start(&self, pairs: &[Pair], bodies: usize) -> EngineState {
        let tools = self.coupled.priors.len();
        let WorldLoop {
            force_limits,
            actuation,
            ..
        } = &self.loop_params;
        let nowhere = Rigid {
            position: Vector3::zeros(),
            orientation: Rotation::identity(),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        let tool = Part::new(nowhere, Mobility::none(), Drive::constant(Vector3::zeros()));
        let meeting = Meeting {
            tools: vec![tool; tools],
            leads: vec![Vector3::zeros(); tools],
            impulses: vec![Vector3::zeros(); tools],
            images: vec![Image::nowhere(); bodies],
            touches: vec![Touch::apart(); pairs.len()],
            limits: ForceLimit::each(force_limits, actuation, &self.coupled.axes),
            expects_the_missed: false,
        };
        let devices = self.coupled.priors.iter();
        let contacts = pairs.iter().map(|pair| EngineContact {
            tool: pair.toucher.tool().unwrap_or(usize::MAX),
            body: pair.body,
            mode: Mode::Free,
            point: [0.0; 3],
            normal: [0.0; 3],
            penetration: 0.0,
            force: [0.0; 3],
        });
        EngineState {
            before: meeting.clone(),
            meeting,
            offsets: vec![ImageOffset::none(); bodies],
            is_body_touched: vec![false; bodies],
            pushed: vec![None; bodies],
            devices: devices
                .map(|priors| TrackedDevice::new(priors, Vector3::zeros()))
                .collect(),
            tracking: Tracking::new(&vec![false; tools]),
            commands: Commands::new(tools, &self.loop_params.actuation, self.loop_params.period),
            intended: vec![Vector3::zeros(); tools],
            forces: vec![[0.0; 3]; tools],
            advanced: 0.0,
            fault: None,
            limited: Limited::default(),
            effort: Effort::default(),
            tools: vec![ToolState::default(); tools],
            contacts: contacts.collect(),
            ledger: EngineLedger {
                contacts: vec![ContactLedger::default(); pairs.len()],
                devices: vec![PortLedger::default(); tools],
                bodies: vec![BodyPortLedger::default(); bodies],
            },
            at_ports: CreatedAtPorts::none(pairs.len()),
        }
    }

    /// Takes a sample of all devices and begins a period. After an unusable sample the period has no contact, and
    /// [`hold`](Self::hold) reports the fault. Returns the time since the previous sample `[s]` if the sample ends a
    /// period.
    pub fn sample(
        &self,
        pairs: &[Pair],
        state: &mut EngineState,
        sample: &Sample<'_>,
    ) -> Option<f64> {
        state.effort = Effort::default();
        state.limited = Limited::default();
        state.advanced = 0.0;
        state.fault = None;
        let is_in_progress = state.tracking.in_progress;
        let elapsed = state.tracking.believe(sample, &self.loop_params);
        let period = self.loop_params.period;
        state.commands.pass(*elapsed.as_ref().unwrap_or(&period));
        match elapsed {
            Ok(elapsed) => {
                self.observe(pairs, state, sample, elapsed);
                state.tracking.trust();
                self.place(state);
                is_in_progress.then_some(elapsed)
            }
            Err(fault) => {
                state.fault = Some(fault);
                self.disable_output(state);
                None
            }
        }
    }

    /// Replaces the force of the last [`hold`](Self::hold) on a tool by the force that was actually sent `[N]`.
    pub fn report_sent(&self, state: &mut EngineState, tool: usize, mut force: Vector) {
        if let Some(axes) = self.coupled.axes.get(tool) {
            axes.keep(&mut force);
        }
        if force.iter().all(|x| x.is_finite()) {
            let slope = Vector3::zeros();
            state.commands.correct(tool, force.into(), slope);
        }
    }

    /// Advances proxies and images by `h` `[s]`, starting from evaluated contacts. Returns `false` and leaves no
    /// contact if the result is not finite or if a contact is too fast for the integration to be stable.
    pub fn meet(&self, pairs: &[Pair], state: &mut EngineState, h: f64) -> bool {
        let EngineState {
            meeting, before, ..
        } = state;
        let (sub_steps, period) = (&self.loop_params.sub_steps, self.loop_params.period);
        let worked: f64 = meeting.touches.iter().map(|touch| touch.work).sum();
        let effort = meeting.advance(before, pairs, sub_steps, MAX_TIMES, h, period);
        state.effort = state.effort.and(effort);
        let after: f64 = meeting.touches.iter().map(|touch| touch.work).sum();
        let parts = meeting.tools.iter();
        let places: f64 = parts.map(|part| part.rigid.position.sum()).sum();
        let moved: f64 = meeting.images.iter().map(Image::sum).sum();
        if effort.unstable || !(after + places + moved - worked).is_finite() {
            state.fail(Fault::Overflow);
            self.disable_output(state);
            return false;
        }
        // `hold` records work and dissipation when the period ends.
        state.record_stored(pairs, |entry| &mut entry.step_error);
        state.advanced += h;
        true
    }

    /// Ends the period and sets the forces to hold until the next one. `with_bodies` is the energy generated at the
    /// ports of the bodies `[J]`.
    pub fn hold(&self, pairs: &[Pair], state: &mut EngineState, with_bodies: f64) {
        // Close the ports before the work of the newly planned period is recorded.
        state.close_ports(pairs, with_bodies);
        if state.fault.is_none() && state.advanced > 0.0 {
            self.plan(pairs, state);
        } else {
            state.intended.fill(Vector3::zeros());
            state.forces.fill([0.0; 3]);
        }
        if !state.intended.iter().flatten().all(|x| x.is_finite()) {
            state.fail(Fault::Overflow);
            state.intended.fill(Vector3::zeros());
            state.forces.fill([0.0; 3]);
            self.disable_output(state);
        }
        state.commands.send(&state.intended, &state.forces, &[]);
        self.publish(state);
    }

    /// Updates the device estimates, proxies and energy ledger for the interval that ended with this sample.
    fn observe(&self, pairs: &[Pair], state: &mut EngineState, sample: &Sample<'_>, elapsed: f64) {
        let is_in_progress = state.tracking.in_progress;
        for (tool, (device, priors)) in state
            .devices
            .iter_mut()
            .zip(&self.coupled.priors)
            .enumerate()
        {
            let position = Vector3::from(sample.positions[tool]);
            if !is_in_progress {
                *device = TrackedDevice::new(priors, position);
                device.proxy.comes_in = true;
                continue;
            }
            let moved = position - device.measured;
            let acted = state.commands.passed(tool);
            for axis in 0..3 {
                let force = AxisForce {
                    mean: acted.sent[axis],
                    lead: acted.lead[axis],
                    impulse_deviation: acted.impulse_deviation[axis],
                    bias: 0.0,
                    bias_lead: 0.0,
                    share: 1.0,
                };
                device.observers[axis].see(&priors[axis], moved[axis], &force, elapsed);
            }
            device.measured = position;
            let entry = &mut state.ledger.devices[tool];
            entry.port_work += acted.sent.dot(&moved);
            let Some(period) = device.period.take() else {
                continue;
            };
            entry.held += period.mean.dot(&moved);
            entry.carried += self.coupled.axes[tool].across(&period.mean).dot(&moved);
            device.conclude(&period, elapsed);
            device.proxy.comes_in &= period.touched && !acted.is_whole();
            if period.touched || state.commands.is_expected(tool) {
                self.coupled
                    .walk_back_in_contact(&mut device.proxy, elapsed);
            } else {
                self.coupled.walk_back(&mut device.proxy, elapsed);
            }
            state.limited.offset |= self.coupled.limit_offset(&mut device.proxy);
            for (touch, (pair, entry)) in state
                .meeting
                .touches
                .iter()
                .zip(pairs.iter().zip(&mut state.ledger.contacts))
            {
                if pair.toucher.is_tool(tool) {
                    entry.held += touch.impulse.dot(&moved) / period.duration;
                }
            }
        }
        for (offset, touched) in state.offsets.iter_mut().zip(&mut state.is_body_touched) {
            if !*touched {
                let turned = 1.0 - (elapsed / self.coupled.velocity_return).min(1.0);
                let kept = 1.0 - (elapsed / SLOWLY_BACK).min(1.0);
                offset.decay(self.coupled.offset_return * elapsed, kept, turned);
            }
            state.limited.offset |= offset.limit(self.coupled.offset_limit);
            *touched = false;
        }
    }

    /// Places the proxies at the start of the next command's period.
    fn place(&self, state: &mut EngineState) {
        let pieces = state.commands.look_ahead(self.loop_params.period);
        for (tool, device) in state.devices.iter_mut().enumerate() {
            let observers = &device.observers;
            device.ahead = observers.each_ref().map(|observer| observer.motion);
            for piece in 0..pieces {
                let duration = state.commands.duration(piece);
                let acting = state.commands.coming(tool, piece);
                for (axis, motion) in device.ahead.iter_mut().enumerate() {
                    let force = AxisForce {
                        mean: acting.intended[axis],
                        lead: acting.lead[axis],
                        impulse_deviation: 0.0,
                        bias: 0.0,
                        bias_lead: 0.0,
                        share: 1.0,
                    };
                    let change = motion.under(&force, duration);
                    motion.offset += change.travel;
                    motion.velocity += change.gained;
                    motion.external += change.external;
                }
            }
            let part = &mut state.meeting.tools[tool];
            part.rigid.position =
                device.measured + device.of(|axis| axis.offset) + device.proxy.offset;
            part.rigid.velocity = device.of(|axis| axis.velocity) + device.proxy.velocity_offset;
            part.mobility.linear = device.of(|axis| axis.mobility);
            part.drive = Drive {
                damping_rate: device.of(|axis| axis.damping_rate),
                spring_rate: device.of(|axis| axis.spring_rate),
                ..Drive::constant(device.of(|axis| axis.external))
            };
        }
        state.meeting.begin();
    }

    /// Ends all contacts and discards the energy stored in them.
    pub fn disable_output(&self, state: &mut EngineState) {
        state.tracking.in_progress = false;
        for (touch, entry) in state
            .meeting
            .touches
            .iter_mut()
            .zip(&mut state.ledger.contacts)
        {
            *touch = Touch::apart();
            entry.observed -= entry.stored;
            entry.stored = 0.0;
        }
        for offset in &mut state.offsets {
            *offset = ImageOffset::none();
        }
        state.pushed.fill(None);
        for device in &mut state.devices {
            device.period = None;
        }
    }

    /// Sets the forces to hold, after the proxies have been advanced through the period.
    fn plan(&self, pairs: &[Pair], state: &mut EngineState) {
        let duration = state.advanced;
        for (tool, device) in state.devices.iter_mut().enumerate() {
            let mut touched = false;
            for (touch, (pair, entry)) in state
                .meeting
                .touches
                .iter()
                .zip(pairs.iter().zip(&mut state.ledger.contacts))
            {
                if pair.toucher.is_tool(tool) {
                    touched |= !touch.is_apart() || touch.impulse != Vector3::zeros();
                    entry.work += touch.work;
                    entry.work_on_proxy += touch.work_on_proxy;
                    entry.dissipated += touch.dissipated;
                    entry.step_error += touch.work + touch.dissipated;
                }
            }
            let mean = state.meeting.impulses[tool] / duration;
            let lead = state.meeting.leads[tool] - mean * (0.5 * duration * duration);
            let mut held = mean;
            for axis in 0..3 {
                let mobility = device.ahead[axis].mobility;
                if touched && mobility > 0.0 {
                    // Impulse correction: removes the velocity offset at the start of the period that this force
                    // governs.
                    held[axis] += device.proxy.velocity_offset[axis] / (mobility * duration);
                }
            }
            let intended = state.commands.command(tool, &held, duration);
            let mut intended = self.coupled.axes[tool].along(&intended);
            if !touched && intended.norm() <= MIN_FORCE {
                intended = Vector3::zeros();
            }
            device.period = Some(Period {
                duration,
                mean,
                lead,
                held,
                touched,
                has_yielded: state.meeting.has_yielded(tool),
            });
            state.limited.force |= state.meeting.has_yielded(tool);
            state.intended[tool] = intended;
            let mut sent = intended;
            let norm = intended.norm();
            let most = self.loop_params.force_limits.get(tool);
            let most = most.map(|most| most / self.loop_params.actuation.limit_gain());
            if let Some(most) = most
                && norm > most
            {
                sent *= most / norm;
                state.limited.force = true;
            }
            state.forces[tool] = sent.into();
        }
    }

    /// Copies the readable part of the state.
    fn publish(&self, state: &mut EngineState) {
        for (touch, contact) in state.meeting.touches.iter().zip(&mut state.contacts) {
            contact.mode = touch.mode;
            contact.point = touch.place.into();
            contact.normal = touch.normal.into();
            contact.penetration = touch.penetration;
            contact.force = touch.force.into();
        }
        for (tool, (shown, device)) in state.tools.iter_mut().zip(&state.devices).enumerate() {
            let motions = device.observers.each_ref().map(|observer| observer.motion);
            let of =
                |quantity: fn(&AxisMotion) -> f64| Vector3::from(motions.each_ref().map(quantity));
            let position = device.measured + of(|axis| axis.offset);
            let velocity = of(|axis| axis.velocity);
            shown.position = position.into();
            shown.velocity = velocity.into();
            shown.offset = device.proxy.offset.into();
            shown.velocity_offset = device.proxy.velocity_offset.into();
            shown.proxy_position = (position + device.proxy.offset).into();
            shown.proxy_velocity = (velocity + device.proxy.velocity_offset).into();
            shown.force = state.forces[tool];
            shown.mass = Some(of(|axis| 1.0 / axis.mobility).into());
        }
    }
}

impl TrackedDevice {
    /// Updates the proxy offset over the `elapsed` time between samples `[s]`: the proxy moves under the contact
    /// forces, the device under the held force, both with the updated device estimate. If `elapsed` differs from the
    /// planned period, the mean contact force is extended or shortened with the held force. Otherwise a late tick
    /// would leave the proxy with a part of the hand's impulse that no contact has absorbed.
    fn conclude(&mut self, period: &Period, elapsed: f64) {
        self.proxy.was_limited |= period.has_yielded;
        for axis in 0..3 {
            let known = self.observers[axis].motion;
            let apart = AxisMotion {
                offset: 0.0,
                velocity: self.proxy.velocity_offset[axis],
                external: 0.0,
                ..known
            };
            let force = AxisForce {
                mean: period.mean[axis] - period.held[axis],
                lead: period.lead[axis],
                impulse_deviation: 0.0,
                bias: 0.0,
                bias_lead: 0.0,
                share: 1.0,
            };
            let change = apart.under(&force, elapsed);
            self.proxy.offset[axis] += change.travel;
            self.proxy.velocity_offset[axis] += change.gained;
        }
    }
}
