//! One bounce by one method, evaluated while it runs: no recording, no allocation per tick.

use palpate_core::{AnyRenderer, ObjectState};
use palpate_testbed::device::PointMass;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::measure::Sampler;
use palpate_testbed::metrics::{Fidelity, FidelityMeter};
use palpate_testbed::profile::ForceProfile;
use palpate_testbed::reference::{self, ReferenceScene, Stop};
use palpate_testbed::viscous_ideal::ViscousIdeal;
use palpate_testbed::viscous_mass::ViscousMass;

use super::bounce::{Bounce, BounceError};
use super::growth::{BounceEnergy, GrowthMeter};
use super::{ERROR_COLLISIONS, GROWTH_COLLISIONS, PHASE_RANGE, PHASES};
use crate::sim::closed_loop::LoopError;
use crate::sim::run::MAX_PERIODS;
use crate::sim::sampled_loop::device_of;
use crate::sim::ticks::{TickedDevice, TicksParams, Way};

/// Results of a bounce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Growth of the bounce's energy per collision; infinite if the loop diverged.
    pub growth: f64,
    /// Errors of the force over the first collisions.
    pub fidelity: Fidelity,
    /// Number of simulated ticks.
    pub ticks: u64,
}

/// Returns the start height of a phase, relative to the gap: evenly spaced from −5 % to +5 %.
pub(super) fn height(phase: usize) -> f64 {
    PHASE_RANGE * (2.0 * phase as f64 / (PHASES - 1) as f64 - 1.0)
}

/// Purpose of a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Evaluated {
    /// Growth and force.
    Force,
    /// Only growth: the errors are invalid, and no ideal with friction is computed.
    Growth,
}

/// Step of an integrated ideal `[s]`, and minimum number of steps per period: E to a tenth of a percent.
const INTEGRATED_STEP: f64 = 2e-5;
const FEWEST_STEPS: f64 = 5.0;

/// Returns the ideal force with Coulomb friction, which has no closed form.
fn integrated(
    bounce: &Bounce,
    object_position: f64,
    periods: usize,
) -> Result<ForceProfile, BounceError> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "5 to 50"
    )]
    let twenties = (bounce.period / INTEGRATED_STEP / reference::POINTS_PER_PERIOD as f64)
        .clamp(FEWEST_STEPS, 50.0)
        .ceil() as usize;
    let object = ReferenceScene {
        stiffness: bounce.stiffness,
        object_mass: bounce.object_mass,
        virtual_force: bounce.virtual_force(),
        object_position,
        object_velocity: 0.0,
        period: bounce.period,
        steps_per_period: twenties * reference::POINTS_PER_PERIOD,
    };
    let device = device_of(&bounce.scene(0.0, 1), 1.0)?;
    let ideal = reference::integrate(&device, &object, Stop::AfterPeriods(periods))
        .map_err(LoopError::from)?;
    Ok(ideal.profile)
}

/// Data common to all methods in one phase of a bounce: its ideal and its windows.
pub(super) struct Course {
    energy: BounceEnergy,
    object: ObjectState<f64>,
    /// The ideal force over the window of the error.
    profile: ForceProfile,
    /// Samples of the last cycle: after the last counted collision, up to the end of the next one.
    last_cycle: std::ops::RangeInclusive<usize>,
    way: Way,
    sampler: Sampler,
}

impl Course {
    /// Creates a course with the windows of the frictionless bounce. Plants are thus comparable, and a bounce that
    /// friction brings to rest also has windows.
    pub fn new(bounce: &Bounce, phase: usize, evaluated: Evaluated) -> Result<Self, BounceError> {
        let height = height(phase);
        let position = (1.0 + height) * bounce.gap;
        let device = &bounce.device;
        let object_mobility = 1.0 / bounce.object_mass;
        let scene = PointMassScene {
            stiffness: bounce.stiffness,
            device_mass: device.mass,
            object_mass: bounce.object_mass,
            user_force: bounce.user_force(),
            virtual_force: bounce.virtual_force(),
            device_position: 0.0,
            device_velocity: 0.0,
            object_position: position,
            object_velocity: 0.0,
        };
        let lossless = Ideal::new(scene)?;
        let period = bounce.period;
        let end = |n| lossless.end_of_collision(n).ok_or(BounceError::NoBounce);
        let (last, next) = (
            end(GROWTH_COLLISIONS)? / period,
            end(GROWTH_COLLISIONS + 1)? / period,
        );
        if next > MAX_PERIODS as f64 {
            return Err(BounceError::TooLong(next));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to MAX_PERIODS"
        )]
        let (first, next) = (last.floor() as usize + 1, next.floor() as usize);
        let window = lossless
            .window(ERROR_COLLISIONS, period)
            .ok_or(BounceError::NoBounce)?;
        let profile = match evaluated {
            Evaluated::Force if device.coulomb_friction > 0.0 => {
                integrated(bounce, position, window)?
            }
            Evaluated::Force if device.viscous_friction > 0.0 => {
                ViscousIdeal::new(&scene, device.viscous_friction, period, window)?.profile
            }
            _ => lossless.profile(period, window)?,
        };
        Ok(Self {
            energy: BounceEnergy {
                stiffness: bounce.stiffness,
                device_mass: device.mass,
                user_force: bounce.user_force(),
                viscous_friction: device.viscous_friction,
                coulomb_friction: device.coulomb_friction,
                object_acceleration: scene.virtual_force * object_mobility,
                object_mobility,
            },
            object: ObjectState::at_rest(position),
            profile,
            last_cycle: first..=next.max(first),
            way: Way::new(bounce.delay, bounce.lag)?,
            sampler: if device.encoder_quantum > 0.0 {
                Sampler::quantum(device.encoder_quantum)?
            } else {
                Sampler::Ideal
            },
        })
    }

    /// Runs the bounce with `renderer`.
    pub fn run(
        &self,
        bounce: &Bounce,
        renderer: &AnyRenderer<f64>,
    ) -> Result<Outcome, BounceError> {
        let device = &bounce.device;
        if device.coulomb_friction > 0.0 {
            let scene = bounce.scene(0.0, 1);
            self.run_on(TickedDevice::new(&scene)?, bounce, renderer)
        } else if device.viscous_friction > 0.0 {
            let viscous =
                ViscousMass::new(device.mass, device.viscous_friction, bounce.user_force())?;
            self.run_on(viscous.into(), bounce, renderer)
        } else {
            let free = PointMass::new(device.mass, bounce.user_force())?;
            self.run_on(free.into(), bounce, renderer)
        }
    }

    fn run_on(
        &self,
        device: TickedDevice,
        bounce: &Bounce,
        renderer: &AnyRenderer<f64>,
    ) -> Result<Outcome, BounceError> {
        // The renderer uses its model period, even if that is wrong.
        let params = TicksParams {
            renderer,
            object: self.object,
            virtual_force: bounce.virtual_force(),
            sampler: self.sampler,
            way: self.way.clone(),
            period: bounce.period,
        };
        let mut in_progress = params.on(device)?;
        let mut error = FidelityMeter::new(&self.profile);
        let at_start = self.energy.of(-self.object.position, 0.0, 0.0);
        let mut growth = GrowthMeter::new(at_start);
        let mut ticks = 0;
        for i in 0..=(*self.last_cycle.end()).max(self.profile.intervals()) {
            let tick = in_progress.tick();
            let output = tick.output;
            ticks += 1;
            let energy = self.energy.of(
                tick.device_position - output.object_position,
                tick.device_velocity - output.object_velocity,
                tick.device_velocity,
            );
            growth.sample(energy, self.last_cycle.contains(&i));
            if output.fault.is_some() {
                growth.give_up();
            }
            error.hold(tick.held);
            if growth.has_diverged() && error.is_complete() {
                break;
            }
        }
        Ok(Outcome {
            growth: growth.growth(GROWTH_COLLISIONS),
            fidelity: error.fidelity().ok_or(BounceError::NoBounce)?,
            ticks,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Forces, MapParams, Plant};
    use palpate_testbed::profile::Snapshot;

    /// Returns the growth of a motion that is known at every sample.
    fn growth_of(course: &Course, at: impl Fn(usize) -> Snapshot) -> f64 {
        let energy = |state: &Snapshot| {
            course.energy.of(
                state.penetration(),
                state.device_velocity - state.object_velocity,
                state.device_velocity,
            )
        };
        let mut meter = GrowthMeter::new(energy(&at(0)));
        for i in 0..=*course.last_cycle.end() {
            meter.sample(energy(&at(i)), course.last_cycle.contains(&i));
        }
        meter.growth(GROWTH_COLLISIONS)
    }

    fn scene(bounce: &Bounce, height: f64) -> PointMassScene {
        PointMassScene {
            stiffness: bounce.stiffness,
            device_mass: bounce.device.mass,
            object_mass: bounce.object_mass,
            user_force: bounce.user_force(),
            virtual_force: bounce.virtual_force(),
            device_position: 0.0,
            device_velocity: 0.0,
            object_position: (1.0 + height) * bounce.gap,
            object_velocity: 0.0,
        }
    }

    #[test]
    fn the_ideal_grows_by_one_without_friction_whatever_the_scene() {
        let mut params = MapParams {
            cells: 4,
            ..MapParams::default()
        };
        for forces in [
            params.forces,
            Forces::Weight {
                user_force: 1.0,
                gravity: 9.81,
            },
        ] {
            params.forces = forces;
            for index in 0..params.len() {
                let bounce = params.cell(index).bounce.on(Plant::Undamped);
                for phase in [0, 9, 15] {
                    let course = Course::new(&bounce, phase, Evaluated::Force).unwrap();
                    let ideal = Ideal::new(scene(&bounce, height(phase))).unwrap();
                    let growth = growth_of(&course, |i| ideal.at(i as f64 * bounce.period));
                    assert!((growth - 1.0).abs() < 1e-9, "{index}, {phase}: {growth}");
                }
            }
        }
    }

    #[test]
    fn a_landing_loses_its_energy_and_does_not_grow() {
        let params = MapParams {
            cells: 4,
            ..MapParams::default()
        };
        for (friction, most) in [(0.0394, 0.98), (0.5, 0.8), (20.0, 0.4)] {
            // A wall: the friction of a device takes no energy from an object that is much lighter than the device.
            let mut bounce = params.cell(2 * params.columns()).bounce;
            bounce.device.viscous_friction = friction;
            let course = Course::new(&bounce, 3, Evaluated::Force).unwrap();
            let periods = *course.last_cycle.end();
            let ideal =
                ViscousIdeal::new(&scene(&bounce, height(3)), friction, bounce.period, periods)
                    .unwrap();
            let growth = growth_of(&course, |i| ideal.record[i]);
            assert!(growth < most, "{friction}: {growth}");
        }
    }

    #[test]
    fn the_last_cycle_is_the_one_after_the_twentieth_collision() {
        let params = MapParams::default();
        let bounce = params
            .cell(params.columns() + 30)
            .bounce
            .on(Plant::Undamped);
        let course = Course::new(&bounce, 5, Evaluated::Force).unwrap();
        let ideal = Ideal::new(scene(&bounce, height(5))).unwrap();
        let end = |n| ideal.end_of_collision(n).unwrap() / bounce.period;
        let (first, last) = (
            *course.last_cycle.start() as f64,
            *course.last_cycle.end() as f64,
        );
        assert!(first > end(20) && first - 1.0 <= end(20));
        assert!(last <= end(21) && last + 1.0 > end(21));
    }
}
