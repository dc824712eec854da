//! Tick-by-tick rendering of a changeable contact.

use core::mem::discriminant;

use super::blend::Blend;
use super::{Change, ChangeError, Rendering};
use crate::Scalar;
use crate::contact::Side;
use crate::energy::Ledger;
use crate::motion::ObjectState;
use crate::parameter::ParameterError;
use crate::render::{AnyMemory, AnyRenderer, State};
use crate::sample::{Output, Sample};

/// An active rendering: a renderer with its state, and the transition from the previous rendering to the current one.
///
/// ```
/// use palpate_core::{AnyParams, Contact, LoopParams, ObjectState, Rendering, Running, Sample};
///
/// let rendering = Rendering {
///     contact: Contact::wall(1000.0), // [N/m]
///     loop_params: LoopParams::new(0.001).with_force_limit(20.0), // [s], [N]
///     params: AnyParams::Basic,
///     virtual_force: 0.0,
///     object: ObjectState::at_rest(0.0),
/// };
/// let mut running = Running::new(rendering)?;
/// assert_eq!(running.step(Sample::at(0.001)).force_on_device, -1.0);
/// let softer = Rendering { contact: Contact::wall(500.0), ..rendering };
/// running.change(softer)?;
/// let next = running.step(Sample::at(0.001)).force_on_device;
/// assert!(-1.0 < next && next < -0.99); // no step in the force
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Running<S> {
    rendering: Rendering<S>,
    renderer: AnyRenderer<S>,
    state: State<S, AnyMemory<S>>,
    virtual_force: S,
    blend: Option<Blend<S>>,
    /// Parameters of the active renderer.
    running: Rendering<S>,
    /// State of a wall.
    wall: ObjectState<S>,
    power: fn(S, S) -> S,
}

impl<S: Scalar> Running<S> {
    /// Starts with `rendering`: the object has its initial state, and there are no samples yet.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn new(rendering: Rendering<S>) -> Result<Self, ParameterError> {
        let renderer = rendering.renderer()?;
        Ok(Self {
            state: renderer.start(rendering.object)?,
            virtual_force: rendering.virtual_force,
            rendering,
            renderer,
            blend: None,
            running: rendering,
            wall: rendering.object,
            power: S::powf,
        })
    }

    /// Returns the rendering with another power function, which interpolates stiffness and mass. The default, that of
    /// `libm`, gives the same bits on every target.
    #[must_use]
    pub fn with_power(self, power: fn(S, S) -> S) -> Self {
        Self { power, ..self }
    }

    /// Returns the rendering after the current transition.
    pub fn rendering(&self) -> &Rendering<S> {
        &self.rendering
    }

    pub(super) fn as_change(&self) -> Change<S> {
        Change {
            rendering: self.rendering,
            renderer: self.renderer,
        }
    }

    /// Returns the energy ledger up to the last sample.
    pub fn ledger(&self) -> &Ledger<S> {
        self.state.ledger()
    }

    /// Returns the estimated actuation delay minus its model value `[s]`; 0 if the method does not estimate it.
    pub fn learned_lateness(&self) -> S {
        self.renderer.learned_lateness(&self.state)
    }

    /// Renders `rendering` from the next tick on, without a step in the force. Stiffness, mass and virtual force change
    /// to the new values over [`CHANGE_DURATION`](super::CHANGE_DURATION), and the force difference of another method
    /// fades over the same time. The change of energy is recorded in the ledger as outside work.
    ///
    /// The new limits and the new guard apply from the next tick on, also to the fading force. An object in contact
    /// that becomes a wall keeps its position. A free object moves to the position of `rendering`, or to the device if
    /// the device is beyond it.
    ///
    /// # Errors
    /// A parameter is outside its range, or the period or the side of the device differs.
    pub fn change(&mut self, rendering: Rendering<S>) -> Result<(), ChangeError> {
        self.take(Change::new(&self.rendering, rendering)?);
        Ok(())
    }

    /// Applies a change as [`change`](Self::change) does, after it has been checked elsewhere.
    pub fn take(&mut self, change: Change<S>) {
        let from = self.blend.map_or(self.rendering, |blend| blend.now());
        // An unfinished fade continues.
        let remainder = self.blend.map_or(S::ZERO, |blend| blend.remainder());
        self.blend = Some(Blend::new(from, change, remainder, self.power));
        self.rendering = change.rendering;
    }

    /// Reports the force on the object that was sent for the last output `[N]`.
    pub fn report_sent(&mut self, force_on_object: S) {
        self.renderer.report_sent(&mut self.state, force_on_object);
    }

    /// Reports the line on the object that was sent for the last output: its mean `[N]` and its slope `[N/s]`.
    pub fn report_sent_line(&mut self, mean: S, slope: S) {
        self.renderer.report_sent_line(&mut self.state, mean, slope);
    }

    /// Reports the mean force on the object since the last sample `[N]`.
    pub fn report_held(&mut self, force_on_object: S) {
        self.renderer.report_held(&mut self.state, force_on_object);
    }

    /// Moves the object to `object` at the next sample; the change of energy is recorded as outside work. A wall stays
    /// there.
    ///
    /// # Errors
    /// A position or velocity is not finite; the state is then unchanged.
    pub fn teleport(&mut self, object: ObjectState<S>) -> Result<(), ParameterError> {
        self.renderer.teleport(&mut self.state, object)?;
        self.wall = object;
        Ok(())
    }

    /// Computes one tick, as [`Renderer::step`](crate::Renderer::step); the force on the device changes continuously
    /// from the previous rendering. The virtual force of the sample is added to that of the rendering.
    #[inline]
    pub fn step(&mut self, sample: Sample<S>) -> Output<S> {
        if self.blend.is_some() {
            return self.step_between(sample);
        }
        let sample = sample.with_virtual_force(self.virtual_force + sample.virtual_force);
        self.renderer.step(&mut self.state, sample)
    }

    /// Computes a tick during a transition.
    #[cold]
    fn step_between(&mut self, sample: Sample<S>) -> Output<S> {
        let sample =
            |virtual_force| sample.with_virtual_force(virtual_force + sample.virtual_force);
        let mut remainder = S::ZERO;
        if let Some(mut blend) = self.blend {
            let (old, new) = (self.running, self.rendering);
            let other_method = discriminant(&old.params) != discriminant(&new.params)
                || old.is_wall() != new.is_wall();
            // Output of the previous parameters for this sample, computed on a copy.
            let before = (other_method || old.params != new.params).then(|| {
                let mut state = self.state;
                self.renderer.step(&mut state, sample(self.virtual_force))
            });
            self.running = self.rendering;
            let carried = blend.remainder();
            let between = blend.advance();
            if other_method && let Some(before) = &before {
                self.state.forget_past();
                if !old.is_wall() {
                    self.wall = where_it_stands(&self.rendering, before, sample(S::ZERO));
                }
                if self.rendering.is_wall() {
                    if before.object_position != self.wall.position {
                        // Another method shifted the wall. Teleporting an unshifted wall would discard the estimate of
                        // the device, and with it a damper's velocity.
                        let _ = self.renderer.teleport(&mut self.state, self.wall);
                    } else if !old.is_wall() {
                        self.renderer.stand(&mut self.state, self.wall.position);
                    }
                }
            }
            self.renderer = between.renderer;
            self.virtual_force = between.virtual_force;
            self.renderer.adopt(&mut self.state);
            remainder = between.remainder;
            self.blend = (!between.is_over).then_some(blend);
            if let Some(before) = before {
                let blend = &mut self.blend;
                let wanted = before.force_on_object - carried;
                return self.renderer.step_adding(
                    &mut self.state,
                    sample(self.virtual_force),
                    |own| {
                        let blend = blend.as_mut()?;
                        blend.step = own - wanted;
                        Some(wanted - own)
                    },
                );
            }
        }
        self.renderer
            .step_adding(&mut self.state, sample(self.virtual_force), |own| {
                // No remainder acts on a free device.
                (own != S::ZERO).then_some(-remainder)
            })
    }
}

/// Returns the state of an object that becomes a wall with a `sample`; `before` is the output of the previous method.
/// An object in contact, or waiting for a good sample, keeps its position. A free object moves to its position, or to a
/// device beyond it: otherwise the device would strike, and no spring that fades in would soften the impact.
fn where_it_stands<S: Scalar>(
    rendering: &Rendering<S>,
    before: &Output<S>,
    sample: Sample<S>,
) -> ObjectState<S> {
    let touches = before.penetration > S::ZERO || before.force_on_object != S::ZERO;
    if touches || before.fault.is_some() {
        return ObjectState::at_rest(before.object_position);
    }
    let (object, device) = (rendering.object, sample.device_position);
    ObjectState {
        position: match rendering.contact.side {
            Side::Positive => object.position.max(device),
            Side::Negative => object.position.min(device),
        },
        ..object
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Contact, LoopParams};
    use crate::render::{AnyParams, VirtualDamperParams};

    const LIMIT: f64 = 5.0;

    fn damped(damping: f64) -> Rendering<f64> {
        Rendering {
            contact: Contact::wall(1000.0),
            loop_params: LoopParams::new(0.001).with_force_limit(LIMIT),
            params: AnyParams::VirtualDamper(VirtualDamperParams::new(damping)),
            virtual_force: 0.0,
            object: ObjectState::at_rest(0.0),
        }
    }

    fn basic() -> Rendering<f64> {
        Rendering {
            params: AnyParams::Basic,
            ..damped(0.0)
        }
    }

    /// A damper at its limit, then the plain spring, whose force is far below the limit.
    fn fading() -> Running<f64> {
        let mut running = Running::new(damped(100.0)).unwrap();
        running.step(Sample::at(0.001));
        running.step(Sample::at(0.0015));
        running.change(basic()).unwrap();
        let output = running.step(Sample::at(0.002));
        assert_eq!(output.force_on_device, -LIMIT);
        running
    }

    #[test]
    fn fading_force_is_limited_and_recorded_in_the_ledger() {
        let mut running = fading();
        let before = running.ledger().port_work;
        let output = running.step(Sample::at(0.004));
        // 4 N of the spring and almost 3 N of fading force.
        assert!(output.limited.force);
        assert_eq!(output.force_on_device, -LIMIT);
        let model = running.ledger().port_work;
        running.step(Sample::at(0.003));
        let work = running.ledger().port_work - model;
        assert!((work - LIMIT * -0.001).abs() < 1e-12, "{before} {work}");
    }

    #[test]
    fn a_refused_sample_gets_nothing_of_what_fades() {
        let mut running = fading();
        running.change(damped(50.0)).unwrap();
        let output = running.step(Sample::at(f64::NAN));
        assert!(output.fault.is_some());
        assert_eq!(output.force_on_device, 0.0);
    }

    #[test]
    fn the_virtual_force_of_a_sample_adds_to_that_of_the_rendering() {
        let light = Rendering {
            contact: Contact::object(1000.0, 0.1),
            virtual_force: -0.5,
            ..basic()
        };
        let mut running = Running::new(light).unwrap();
        running.step(Sample::at(-1.0).with_virtual_force(-0.25));
        let output = running.step(Sample::at(-1.0));
        assert!((output.object_velocity - -0.75 / 0.1 * 0.001).abs() < 1e-15);
    }
}
