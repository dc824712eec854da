//! Contact in a device report: recorded and evaluated against the ideal on its motion, or simulated.

use super::file_name;
use crate::sim::closed_loop::Bench;
use crate::sim::replay::{Replay, ReplayError, ReplaySetup};
use crate::sim::run::{Reference, Run};
use palpate_record::recording::{Flags, Recording};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Model, Scene};
use serde::Serialize;

use super::device::DeviceCard;
use super::ticks::{OneContact, Ticks, is_seen};
use crate::recording::scene_of;
use crate::text::digits;

/// Maximum duration of an evaluated and drawn contact `[s]`.
const LONGEST: f64 = 1.0;
/// Drawn time before and after a contact: share of its duration, and minimum number of periods.
const MARGIN: f64 = 0.1;
const MIN_MARGIN: f64 = 5.0;
/// Maximum number of points of a curve.
const POINTS: usize = 800;
/// Force of the hand that presses a simulated wall `[N]`, and its initial distance from the wall `[m]`.
const HAND: f64 = 2.0;
const FROM: f64 = 0.002;

/// A contact, and the error of its force against the ideal.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ContactCard {
    /// Source of the contact, and the reference of its evaluation.
    pub source: String,
    /// Whether the motion was recorded; otherwise device and hand are simulated.
    pub is_recorded: bool,
    /// The method.
    pub method: &'static str,
    /// Stiffness of the contact `[N/m]`.
    pub stiffness_n_per_m: f64,
    /// Mass of the object `[kg]`; none for a wall.
    pub object_mass_kg: Option<f64>,
    /// Start in the recording or in the simulation `[s]`.
    pub begins_s: f64,
    /// Duration, including the drawn time before and after the contact `[s]`.
    pub lasts_s: f64,
    /// FRE `[%]`.
    pub force_rendering_error_percent: Option<f64>,
    /// E, the avoidable part of the error `[%]`.
    pub mean_force_error_percent: Option<f64>,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    pub hold_bound_percent: Option<f64>,
    /// Strongest held force `[N]`.
    pub peak_force_n: f64,
    /// Deepest penetration `[m]`.
    pub deepest_penetration_m: f64,
    /// Generated energy of the held force at the end `[J]`.
    pub leak_held_j: f64,
    /// Generated energy in the ledger of the recorded loop over the contact `[J]`.
    pub recorded_leak_held_j: Option<f64>,
    /// Strongest force sent by the recorded loop over the contact `[N]`.
    pub recorded_peak_force_n: Option<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A curve of a contact.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Curve {
    /// `device_m`, `object_m`, `ideal_object_m`, `force_n`, `ideal_force_n` or `created_j`; forces are those on the
    /// object, positive away from the device.
    pub quantity: &'static str,
    /// Times `[s]`.
    pub t_s: Vec<f64>,
    /// Values, in the unit of the quantity.
    pub values: Vec<f64>,
}

impl ContactCard {
    /// Returns the strongest contact of a recording.
    ///
    /// # Errors
    /// The reason as text: no contact, no scene, or a motion on which nothing can be rendered.
    pub(super) fn recorded(recording: &Recording, ticks: &Ticks) -> Result<Self, String> {
        let file = scene_of(recording).map_err(|error| error.to_string())?;
        let name = file_name(recording.path());
        if !recording.has_one_contact_each {
            return Err(format!(
                "{name} has several contacts in a tick; the page supports one"
            ));
        }
        let period = file.scene.loop_params.period;
        let part = strongest(&ticks.all, period)
            .ok_or_else(|| format!("{name} has no contact under its initial parameters"))?;
        Self::on_motion(recording, &file, part).map_err(|error| format!("{name}: {error}"))
    }

    /// Renders a recorded motion again by the method of its scene and evaluates it against the ideal on that motion.
    fn on_motion(
        recording: &Recording,
        file: &ContactFile,
        part: &[OneContact],
    ) -> Result<Self, ReplayError> {
        let scene = &file.scene;
        let mut setup = ReplaySetup::of_scene(scene);
        let (first, last) = (&part[0], &part[part.len() - 1]);
        if first.contact.object_position.is_finite() && first.contact.object_velocity.is_finite() {
            setup.object.position = first.contact.object_position;
            setup.object.velocity = first.contact.object_velocity;
        }
        let times: Vec<f64> = part.iter().map(|row| row.tick.time).collect();
        let positions: Vec<f64> = part.iter().map(|row| row.contact.device_position).collect();
        let replay = Replay::at_recorded_instants(setup, &times, &positions)?;
        let settings = scene.settings.get(&scene.method).copied();
        let run = replay.run(scene.method, &settings.unwrap_or_default())?;
        let leak = last.contact.held_leak - first.contact.held_leak;
        let peak = part
            .iter()
            .map(|row| row.contact.force_on_device.abs())
            .filter(|force| force.is_finite())
            .fold(0.0, f64::max);
        let source = format!(
            "the strongest contact of {}: its motion, rendered again by {} at the recorded instants, against the \
             ideal on that motion",
            file_name(recording.path()),
            scene.method
        );
        Ok(Self {
            recorded_leak_held_j: Some(leak).filter(|leak| leak.is_finite()),
            recorded_peak_force_n: Some(peak),
            is_recorded: true,
            begins_s: times[0],
            ..Self::evaluated(source, scene, scene.method, (&run, replay.reference()))
        })
    }

    /// Simulates a hand that presses the device of `device` into a wall, with coupled rendering.
    ///
    /// # Errors
    /// The reason as text.
    pub(super) fn simulated(
        device: &DeviceCard,
        deviations: &Model,
        stiffness: f64,
    ) -> Result<Self, String> {
        let value = |key| device.value(key);
        let number = |key, otherwise: f64| value(key).unwrap_or(otherwise);
        let (Some(mass), Some(period)) = (value("device_mass_kg"), value("period_s")) else {
            return Err("the mass of the device or the period of its loop is not known".into());
        };
        let delay = number("delay_s", 0.0);
        let friction = number("coulomb_friction_n", 0.0);
        let hand = HAND.max(3.0 * friction);
        let text = format!(
            r#"
format = 2
title = "A wall, pressed"
[[device]]
name = "device"
axes = ["x"]
mass_kg = {mass:e}
position_m = [-{FROM:e}, 0, 0]
drivetrain.viscous_friction_n_s_per_m = {:e}
drivetrain.coulomb_friction_n = {:e}
quantum_m = {:e}
hand.force_n = [{hand:e}, 0, 0]
[[body]]
name = "wall"
fixed = true
shape = {{ half_space = {{ normal = [-1, 0, 0] }} }}
[[contact]]
between = ["device", "wall"]
stiffness_n_per_m = {stiffness:e}
[loop]
period_s = {period:e}
delay_s = {delay:e}
lag_s = {:e}
gain = {:e}
[measure]
duration_s = {:e}
[render]
method = "coupled"
"#,
            number("viscous_friction_n_s_per_m", 0.0),
            friction,
            number("sensor_quantum_m", 0.0),
            number("lag_s", 0.0),
            number("gain", 1.0),
            duration(mass, stiffness, hand, period),
        );
        let file = ContactFile::parse("the simulated contact", &text);
        let mut scene = file.map_err(|error| error.to_string())?.scene;
        scene.model = *deviations;
        let method = MethodName::Coupled;
        let bench = Bench::new(&scene).map_err(|error| error.to_string())?;
        let run = bench.run(method).map_err(|error| error.to_string())?;
        let source = format!(
            "a simulation with the values of this page: a hand of {} N presses the device into a wall from {} mm \
             away, by {method}, whose model has these values",
            digits(hand),
            1e3 * FROM
        );
        Ok(Self::evaluated(
            source,
            &scene,
            method,
            (&run, bench.reference()),
        ))
    }

    fn evaluated(
        source: String,
        scene: &Scene,
        method: MethodName,
        (run, reference): (&Run, &Reference),
    ) -> Self {
        let times: Vec<f64> = run.ticks.iter().map(|tick| tick.time).collect();
        let of_ticks = |quantity, of: &dyn Fn(&crate::sim::run::Tick) -> f64| Curve {
            quantity,
            t_s: times.clone(),
            values: run.ticks.iter().map(of).collect(),
        };
        let ideal_times: Vec<f64> = reference.curve.iter().map(|point| point.time).collect();
        let of_ideal = |quantity, of: &dyn Fn(&crate::sim::run::IdealPoint) -> f64| Curve {
            quantity,
            t_s: ideal_times.clone(),
            values: reference.curve.iter().map(of).collect(),
        };
        let curves = [
            of_ticks("device_m", &|tick| tick.true_device_position),
            of_ticks("object_m", &|tick| tick.output.object_position),
            of_ideal("ideal_object_m", &|point| point.object_position),
            of_ticks("force_n", &|tick| tick.held_force_on_object),
            of_ideal("ideal_force_n", &|point| point.force_on_object),
            of_ticks("created_j", &|tick| tick.ledger.held_leak.accumulated),
        ];
        let deepest = run.ticks.iter().map(|tick| tick.output.penetration);
        let fidelity = run.force.fidelity;
        let mass = crate::sim::closed_loop::object_mass(scene);
        Self {
            source,
            is_recorded: false,
            method: method.name(),
            stiffness_n_per_m: scene.contact.stiffness,
            object_mass_kg: Some(mass).filter(|mass| mass.is_finite()),
            begins_s: times.first().copied().unwrap_or(0.0),
            lasts_s: run.last().time - times.first().copied().unwrap_or(0.0),
            force_rendering_error_percent: fidelity.map(|f| f.force_rendering_error),
            mean_force_error_percent: fidelity.map(|f| f.mean_force_error),
            hold_bound_percent: fidelity.map(|f| f.hold_bound),
            peak_force_n: run.force.peak_force,
            deepest_penetration_m: deepest.fold(0.0, f64::max),
            leak_held_j: run.last().ledger.held_leak.accumulated,
            recorded_leak_held_j: None,
            recorded_peak_force_n: None,
            curves: curves.map(Curve::thinned).into(),
        }
    }

    /// Returns the curve of a quantity.
    #[must_use]
    pub fn curve(&self, quantity: &str) -> Option<&Curve> {
        self.curves.iter().find(|curve| curve.quantity == quantity)
    }
}

impl Curve {
    /// Returns every n-th point, and the last.
    fn thinned(self) -> Self {
        let step = self.t_s.len().div_ceil(POINTS).max(1);
        let last = self.t_s.len().saturating_sub(1);
        let keep = |all: &[f64]| -> Vec<f64> {
            all.iter()
                .enumerate()
                .filter(|(index, _)| index % step == 0 || *index == last)
                .map(|(_, value)| *value)
                .collect()
        };
        Self {
            quantity: self.quantity,
            t_s: keep(&self.t_s),
            values: keep(&self.values),
        }
    }
}

/// Returns the time in which the hand presses the device into the wall and the device oscillates twice `[s]`.
fn duration(mass: f64, stiffness: f64, hand: f64, period: f64) -> f64 {
    let approach = (2.0 * FROM * mass / hand).sqrt();
    let swing = std::f64::consts::TAU * (mass / stiffness).sqrt();
    (approach + 2.0 * swing).max(50.0 * period)
}

/// Returns the contact with the strongest sent force, with a margin before and after it. It only contains ticks with
/// a device position and with the parameters of the metadata.
fn strongest(ticks: &[OneContact], period: f64) -> Option<&[OneContact]> {
    let whole = |row: &OneContact| is_seen(row) && row.tick.generation == 0;
    let mut best: Option<(f64, usize, usize)> = None;
    let mut at = 0;
    while at < ticks.len() {
        if !ticks[at].tick.flags.has(Flags::CONTACT) || !whole(&ticks[at]) {
            at += 1;
            continue;
        }
        let from = at;
        let mut peak = 0.0_f64;
        while at < ticks.len()
            && ticks[at].tick.flags.has(Flags::CONTACT)
            && whole(&ticks[at])
            && ticks[at].tick.time - ticks[from].tick.time <= LONGEST
        {
            peak = peak.max(ticks[at].contact.force_on_device.abs());
            at += 1;
        }
        if best.is_none_or(|(strongest, ..)| peak > strongest) {
            best = Some((peak, from, at));
        }
    }
    let (_, from, to) = best?;
    let lasts = ticks[to - 1].tick.time - ticks[from].tick.time;
    let margin = (MARGIN * lasts).max(MIN_MARGIN * period);
    let (earliest, latest) = (
        ticks[from].tick.time - margin,
        ticks[to - 1].tick.time + margin,
    );
    let before = ticks[..from]
        .iter()
        .rev()
        .take_while(|row| whole(row) && row.tick.time >= earliest)
        .count();
    let after = ticks[to..]
        .iter()
        .take_while(|row| whole(row) && row.tick.time <= latest)
        .count();
    let part = &ticks[from - before..to + after];
    (part.len() > 2).then_some(part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_record::recording::{ContactTick, Tick};

    #[test]
    fn the_strongest_contact_is_taken_with_its_margins_and_nothing_unseen() {
        let tick = |i: u32, force: f64| OneContact {
            tick: Tick {
                time: 1e-3 * f64::from(i),
                generation: 0,
                flags: Flags::default().with(Flags::CONTACT, force != 0.0),
                ..Tick::UNKNOWN
            },
            contact: ContactTick {
                device_position: 0.0,
                force_on_device: force,
                ..ContactTick::UNKNOWN
            },
        };
        let force = |i| match i {
            10..20 => -1.0,
            40..60 => -3.0,
            _ => 0.0,
        };
        let mut ticks: Vec<OneContact> = (0..100).map(|i| tick(i, force(i))).collect();
        let span = |ticks: &[OneContact]| {
            let part = strongest(ticks, 1e-3).unwrap();
            let at = |row: &OneContact| (1e3 * row.tick.time).round();
            (at(&part[0]), at(&part[part.len() - 1]))
        };
        assert_eq!(span(&ticks), (35.0, 64.0));
        // A tick without a position ends the part.
        ticks[62].contact.device_position = f64::NAN;
        assert_eq!(span(&ticks), (35.0, 61.0));
        // After a change of parameters the contact is unknown.
        ticks[40..]
            .iter_mut()
            .for_each(|row| row.tick.generation = 1);
        assert_eq!(span(&ticks), (5.0, 24.0));
        assert!(strongest(&[], 1e-3).is_none());
    }
}
