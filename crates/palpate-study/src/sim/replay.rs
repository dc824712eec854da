//! Open-loop replay: a recorded motion, rendered by a method.
//!
//! The recorded device ignores the force, and the renderer sees the recorded motion. The replay therefore shows the
//! force law on real motion and the generated energy. The ideal is the same object in continuous time, position-driven
//! by the recording at its full rate, linear between its samples.

use palpate_core::{
    Actuation, Allowed, AnyParams, AnyRenderer, Contact, Hold, LARGEST_DELAY, LoopParams, Mass,
    Method, MethodParams, ObjectState, Parameter, ParameterError, ParameterValue, Renderer, Sample,
};
use palpate_testbed::InvalidParameter;
use palpate_testbed::driven::{DrivenIdeal, DrivenScene};
use palpate_testbed::grid::Grid;
use palpate_testbed::metrics::ForceEvaluation;
use palpate_testbed::recorded_path::{PathError, RecordedPath, to_nanoseconds};

use crate::sim::delivery::Delivery;
use crate::sim::run::{MAX_PERIODS, Reference, Run, RunMethod, Tick};
use palpate_scene::method::{Basis, MethodName, Settings, SettingsError};
use palpate_scene::named_parameters::named_parameters;
use palpate_scene::{Delay, Scene, SetupError, guard_of_device, stored_energy};

/// Contact, loop and object that are rendered on a recorded motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplaySetup {
    /// The contact.
    pub contact: Contact<f64>,
    /// The loop.
    pub loop_params: LoopParams<f64>,
    /// The object at the start.
    pub object: ObjectState<f64>,
    /// Virtual force on the object `[N]`.
    pub virtual_force: f64,
    /// Renderer's model of the actuator. In a replay it is also the actual actuator.
    pub actuation: Actuation<f64>,
    /// Effective mass of the device, if known `[kg]`.
    pub device_mass: Option<f64>,
    /// Quantum of the device's position sensor `[m]`; 0 if it is not known to have one.
    pub encoder_quantum: f64,
}

impl ReplaySetup {
    /// Returns the parameters of `method` for a device that starts at `device_position` `[m]`. A `recorded` device
    /// ignores the force.
    ///
    /// # Errors
    /// A setting is invalid for the method.
    pub fn params(
        &self,
        method: MethodName,
        settings: &Settings,
        device_position: f64,
        recorded: bool,
    ) -> Result<AnyParams<f64>, SettingsError> {
        let basis = Basis {
            stiffness: self.contact.stiffness,
            period: self.loop_params.period,
            device_mass: self.device_mass,
            encoder_quantum: self.encoder_quantum,
            recorded,
            stored_energy: stored_energy(&self.contact, self.object, device_position),
        };
        method.params(settings, &basis)
    }

    /// Returns contact, loop, object and renderer of a scene; the recording replaces its device and its hand.
    #[must_use]
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            contact: scene.contact,
            loop_params: scene.loop_params,
            object: scene.object,
            virtual_force: scene.virtual_force,
            actuation: if scene.model.delay.is_none() && scene.delay.seconds() == 0.0 {
                // The delay may exceed the longest one that a renderer supports.
                let samples =
                    Actuation::after_samples(scene.delay.whole_samples(), scene.loop_params.period);
                Actuation {
                    delay: samples.delay,
                    ..scene.model_actuation()
                }
            } else {
                scene.model_actuation()
            },
            device_mass: Some(scene.model_device_mass.unwrap_or(scene.device.mass())),
            encoder_quantum: scene.device.encoder_quantum(),
        }
    }

    /// Returns the renderer's model of the loop, with the delay limited to the longest one that it supports.
    #[must_use]
    pub fn known_loop(&self) -> LoopParams<f64> {
        let most = LARGEST_DELAY as f64 * self.loop_params.period;
        LoopParams {
            actuation: Actuation {
                delay: self.actuation.delay.min(most),
                ..self.actuation
            },
            guard: guard_of_device(
                self.loop_params.guard,
                self.device_mass,
                self.encoder_quantum,
            ),
            ..self.loop_params
        }
    }

    /// The delay, in periods.
    #[must_use]
    pub fn delay(&self) -> Delay {
        Delay::of_periods(self.actuation.delay / self.loop_params.period)
    }
}

/// Reason why a recording cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The method cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The bench refuses a value.
    #[error(transparent)]
    Bench(#[from] InvalidParameter),
    /// The recording is not a valid motion.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The ideal force overflows: the recording penetrates the object too deeply.
    #[error("the ideal force on this recording is not a finite number: a position is too large")]
    Overflow,
    /// The recording is too long for the period.
    #[error("the recording has {0} periods; at most {MAX_PERIODS} fit, so cut it")]
    TooLong(usize),
    /// The recording is shorter than a period.
    #[error("the recording lasts {} s, less than one period of {period} s", to_nanoseconds(*recorded))]
    TooShort {
        /// Length of the recording `[s]`.
        recorded: f64,
        /// Period of the loop `[s]`.
        period: f64,
    },
}

/// A recorded motion on the bench: resampled, and its ideal computed, once for every method.
#[derive(Clone, Debug)]
pub struct Replay {
    setup: ReplaySetup,
    sign: f64,
    /// The loop's instants `[s]`.
    times: Vec<f64>,
    /// Whether the renderer receives the measured time between samples; otherwise it uses the nominal period.
    measured: bool,
    /// Recorded positions at these instants, in the user's frame `[m]`.
    positions: Vec<f64>,
    /// Virtual force of each instant in addition to that of the setup `[N]`; empty: 0.
    forces: Vec<f64>,
    delivery: Delivery,
    reference: Reference,
}

impl Replay {
    /// Resamples the recording (`times` `[s]`, `positions` `[m]`) at the loop's period, and moves the ideal object by
    /// the full recording.
    ///
    /// If an instant of the loop coincides with a recorded one, the recorded position is used exactly, so a period that
    /// is a multiple of the recording's step decimates it. Other instants are interpolated linearly.
    ///
    /// # Errors
    /// The recording is not a valid motion or lasts less than one period, or a parameter is out of range.
    pub fn new(setup: ReplaySetup, times: &[f64], positions: &[f64]) -> Result<Self, ReplayError> {
        Self::pushed(setup, times, positions, &[])
    }

    /// Resamples the recording as [`new`](Self::new), with a virtual force from each recorded sample until the next in
    /// addition to that of the setup: `forces` `[N]`, in the user's frame; an empty list: 0. The loop takes the force
    /// at its instants.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); a force is not finite, or their number is not that of the samples.
    pub fn pushed(
        setup: ReplaySetup,
        times: &[f64],
        positions: &[f64],
        forces: &[f64],
    ) -> Result<Self, ReplayError> {
        check(&setup)?;
        let period = setup.loop_params.period;
        let recorded = RecordedPath::new(times, positions)?;
        let periods = recorded.whole_periods(period)?;
        if periods > MAX_PERIODS {
            return Err(ReplayError::TooLong(periods));
        }
        let resampled = recorded.resample(period)?;
        let intervals = resampled.len() - 1;
        if intervals == 0 {
            return Err(ReplayError::TooShort {
                recorded: recorded.end() - recorded.start(),
                period,
            });
        }
        let start = recorded.start();
        let instants = (0..=intervals).map(|i| start + i as f64 * period).collect();
        let grid = Grid::even(start, period, intervals);
        let samples = (instants, resampled, false);
        Self::along(setup, (&recorded, forces), grid, samples)
    }

    /// Creates a loop that samples at the recorded instants `times` `[s]`, with the device at `positions` `[m]`. The
    /// renderer receives the measured time between them.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn at_recorded_instants(
        setup: ReplaySetup,
        times: &[f64],
        positions: &[f64],
    ) -> Result<Self, ReplayError> {
        check(&setup)?;
        let recorded = RecordedPath::new(times, positions)?;
        if times.len() - 1 > MAX_PERIODS {
            return Err(ReplayError::TooLong(times.len() - 1));
        }
        let grid = Grid::cut_at(times.to_vec(), setup.loop_params.period)?;
        let samples = (times.to_vec(), positions.to_vec(), true);
        Self::along(setup, (&recorded, &[]), grid, samples)
    }

    /// Moves the ideal object by a full recording, over the grid of the loop.
    fn along(
        setup: ReplaySetup,
        (recorded, forces): (&RecordedPath, &[f64]),
        grid: Grid,
        (times, positions, measured): (Vec<f64>, Vec<f64>, bool),
    ) -> Result<Self, ReplayError> {
        let period = setup.loop_params.period;
        let delay = (setup.delay().whole_samples(), setup.delay().fraction());
        let delivery = Delivery::new(&times, delay, period, &setup.actuation)?;
        let grid = if delay.1 > 0.0 {
            Grid::cut_at(delivery.edges().to_vec(), period)?
        } else {
            grid
        };
        let sign: f64 = setup.contact.side.sign();
        let path = if sign < 0.0 {
            recorded.mirrored()
        } else {
            recorded.clone()
        };
        let added: Vec<f64> = forces.iter().map(|force| sign * force).collect();
        let ideal = DrivenIdeal::pushed(
            DrivenScene {
                stiffness: setup.contact.stiffness,
                object_mass: match setup.contact.object_mass {
                    Mass::Finite(mass) => mass,
                    Mass::Infinite => f64::INFINITY,
                },
                virtual_force: sign * setup.virtual_force,
                object_position: sign * setup.object.position,
                object_velocity: sign * setup.object.velocity,
            },
            path,
            &added,
        )?;
        let profile = if grid.is_even() {
            ideal.profile(grid.period(), grid.intervals())?
        } else {
            ideal.profile_on(grid)?
        };
        if !profile.squared_forces().iter().sum::<f64>().is_finite() {
            return Err(ReplayError::Overflow);
        }
        Ok(Self {
            setup,
            sign,
            measured,
            positions,
            forces: held_at(&times, recorded.times(), forces),
            times,
            delivery,
            reference: Reference::new(profile, 0.0, sign, |time| ideal.at(time)),
        })
    }

    /// The ideal over the recording.
    #[must_use]
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// Renders the recording by `method`.
    ///
    /// # Errors
    /// Settings that do not make this method, or a parameter out of range.
    pub fn run(&self, method: MethodName, settings: &Settings) -> Result<Run, ReplayError> {
        let setup = &self.setup;
        let params = setup
            .params(method, settings, self.positions[0], true)
            .map_err(SetupError::from)?;
        let renderer: AnyRenderer<f64> =
            Renderer::new(setup.contact, setup.known_loop(), params).map_err(SetupError::from)?;
        let parameters = named_parameters(&params.derived(renderer.method()));
        self.run_with(&renderer, RunMethod::BuiltIn(method), parameters)
    }

    /// Renders the recording by a method of the caller's own.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn run_own(&self, params: impl MethodParams<f64>) -> Result<Run, ReplayError> {
        let mut parameters = Vec::new();
        params.describe(&mut |key, value| parameters.push((key, value)));
        let method = RunMethod::Own(params.name());
        let renderer = Renderer::new(self.setup.contact, self.setup.known_loop(), params)
            .map_err(SetupError::from)?;
        self.run_with(&renderer, method, parameters)
    }

    fn run_with<M: Method<f64>>(
        &self,
        renderer: &Renderer<f64, M>,
        method: RunMethod,
        parameters: Vec<(&'static str, ParameterValue<f64>)>,
    ) -> Result<Run, ReplayError> {
        let setup = &self.setup;
        let mut state = renderer.start(setup.object).map_err(SetupError::from)?;
        let (samples, fraction) = (setup.delay().whole_samples(), setup.delay().fraction());
        // Without a lag and with a delay of whole samples the force is constant over each interval, even if the delay
        // is longer than a renderer supports.
        let is_held = fraction == 0.0 && setup.actuation.lag == 0.0;
        let mut commands: Vec<f64> = Vec::with_capacity(self.positions.len());
        let mut ticks: Vec<Tick> = self
            .positions
            .iter()
            .enumerate()
            .map(|(i, &position)| {
                let sample = Sample {
                    // Nothing was measured before the first sample.
                    elapsed: (self.measured && i > 0).then(|| self.times[i] - self.times[i - 1]),
                    ..Sample::at(position).with_virtual_force(
                        setup.virtual_force + self.forces.get(i).copied().unwrap_or(0.0),
                    )
                };
                let output = renderer.step(&mut state, sample);
                commands.push(output.force_on_object);
                if is_held {
                    let command = i.checked_sub(samples).map_or(0.0, |sent| commands[sent]);
                    renderer.report_held(&mut state, setup.actuation.gain * command);
                }
                Tick {
                    time: self.times[i],
                    command_from: self.delivery.arrival(i),
                    device_position: position,
                    true_device_position: position,
                    output,
                    held_force_on_object: 0.0,
                    ledger: *state.ledger(),
                }
            })
            .collect();
        let delivered = self.delivery.of(&commands);
        for (tick, force) in ticks.iter_mut().zip(delivered.at_samples) {
            tick.held_force_on_object = force;
        }
        let held = delivered.means;
        let forces: Vec<f64> = held
            .iter()
            .map(|held| self.sign * held.force_on_object)
            .collect();
        Ok(Run {
            method,
            parameters,
            force: ForceEvaluation::new(&forces, &self.reference.profile)
                .expect("one force per interval"),
            ticks,
            held,
            jammed_at: None,
            left_box_at: None,
            diverged: None,
            energy: None,
            rebounds: Vec::new(),
            bench_port_work: None,
            centre_offset: 0.0,
        })
    }
}

/// Returns the force of each instant `[s]`: that of the last recorded sample up to it, within a millionth of a step.
fn held_at(instants: &[f64], recorded: &[f64], forces: &[f64]) -> Vec<f64> {
    if forces.is_empty() {
        return Vec::new();
    }
    let at = |&instant: &f64| {
        let next = recorded.partition_point(|time| *time <= instant);
        let last = next.saturating_sub(1);
        let is_next = (recorded.get(next))
            .is_some_and(|time| time - instant <= 1e-6 * (time - recorded[last]));
        forces[if is_next { next } else { last }]
    };
    instants.iter().map(at).collect()
}

/// Checks contact, loop and object, whatever the method.
fn check(setup: &ReplaySetup) -> Result<(), SetupError> {
    if setup.actuation.hold == Hold::Line {
        return Err(SetupError::from(ParameterError {
            parameter: Parameter::HoldOrder,
            value: 1.0,
            allowed: Allowed::Words("0, a constant: a recorded motion is rendered with constants"),
        }));
    }
    Renderer::new(setup.contact, setup.loop_params, palpate_core::BasicParams)
        .and_then(|renderer| renderer.start(setup.object))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_recording_is_said_without_the_rounding_of_its_times() {
        let error = ReplayError::TooShort {
            recorded: 0.501 - 0.5,
            period: 0.01,
        };
        assert_eq!(
            error.to_string(),
            "the recording lasts 0.001 s, less than one period of 0.01 s"
        );
    }
}
