//! Metadata of runs for a run file.

use crate::sim::run::Run;
use palpate_core::{Guard, GuardParams, HandLimit, Mass, ObjectState, Side};
use palpate_scene::{GUARD_RECOVERY, HandForceAt, Intention, Measure, PantographDevice, Scene};

use super::{Subject, parameters_of, timing_of};

/// Returns the metadata of runs: version, contact, loop, object, and the parameters of each method.
#[must_use]
pub fn metadata(
    subject: &Subject,
    object: ObjectState<f64>,
    virtual_force: f64,
    runs: &[Run],
) -> Vec<(String, String)> {
    let mut lines = subject_metadata(subject, object, virtual_force);
    for (name, value) in timing_of(subject.delay, &subject.timing) {
        lines.push((format!("loop_{name}"), value.to_string()));
    }
    if let Some(seed) = subject.seed
        && lines.iter().all(|(name, _)| name != "loop_seed")
    {
        lines.push(("loop_seed".to_owned(), seed.to_string()));
    }
    for run in runs {
        for (name, value) in parameters_of(&run.parameters) {
            let value = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            lines.push((format!("{}.{name}", run.method), value));
        }
    }
    lines
}

/// Returns version, contact, loop and object, with the force f_V `[N]`.
fn subject_metadata(
    subject: &Subject,
    object: ObjectState<f64>,
    virtual_force: f64,
) -> Vec<(String, String)> {
    let contact = subject.contact;
    let limits = subject.loop_params;
    let optional = |value: Option<f64>| value.map_or_else(|| "none".into(), |v| v.to_string());
    vec![
        (
            "palpate_version".to_owned(),
            env!("CARGO_PKG_VERSION").to_owned(),
        ),
        (
            "stiffness_n_per_m".to_owned(),
            contact.stiffness.to_string(),
        ),
        (
            "object_mass_kg".to_owned(),
            match contact.object_mass {
                Mass::Finite(mass) => mass.to_string(),
                Mass::Infinite => "inf".into(),
            },
        ),
        (
            "side".to_owned(),
            match contact.side {
                Side::Positive => "positive",
                Side::Negative => "negative",
            }
            .to_owned(),
        ),
        ("unilateral".to_owned(), contact.unilateral.to_string()),
        ("period_s".to_owned(), limits.period.to_string()),
        (
            "delay_samples".to_owned(),
            subject.delay.whole_samples().to_string(),
        ),
        ("force_limit_n".to_owned(), optional(limits.force_limit)),
        ("slew_limit_n_per_s".to_owned(), optional(limits.slew_limit)),
        ("largest_gap_s".to_owned(), limits.bridged_gap().to_string()),
        (
            "guard".to_owned(),
            match limits.guard {
                Guard::Off => "off".into(),
                Guard::Report(guard) => format!("report, {}", bounds(&guard)),
                Guard::Limit(guard) => format!("limit, {}", bounds(&guard)),
            },
        ),
        (
            "speed_limit_m_per_s".to_owned(),
            optional(limits.speed_limit),
        ),
        ("device_mass_kg".to_owned(), optional(subject.device_mass)),
        ("object_position_m".to_owned(), object.position.to_string()),
        (
            "object_velocity_m_per_s".to_owned(),
            object.velocity.to_string(),
        ),
        ("virtual_force_n".to_owned(), virtual_force.to_string()),
    ]
}

/// Returns device, hand and window of a scene, under the names of its keys.
#[must_use]
pub fn plant_metadata(scene: &Scene) -> Vec<(String, String)> {
    let device = &scene.device;
    let mut numbers = vec![
        ("device_position_m", device.position()),
        ("device_velocity_m_per_s", device.velocity()),
        ("device_encoder_quantum_m", device.encoder_quantum()),
        ("device_viscous_n_s_per_m", device.viscous_friction()),
        ("device_coulomb_n", device.coulomb_friction()),
        ("hand_force_n", scene.device.hand_force()),
    ];
    // A radius of 0 means that the object has no radius.
    if scene.object_radius != 0.0 {
        numbers.push(("object_radius_m", scene.object_radius));
    }
    if device.noise() > 0.0 {
        numbers.push(("device_noise_m", device.noise()));
    }
    numbers.extend(
        device
            .largest_force()
            .map(|force| ("device_motor_limit_n", force)),
    );
    numbers.extend(
        scene
            .model_device_mass
            .map(|mass| ("renderer_device_mass_kg", mass)),
    );
    if let Some(tremor) = device.tremor() {
        numbers.push(("hand_tremor_n", tremor.amplitude));
        numbers.push(("hand_tremor_hz", tremor.frequency_hz));
    }
    let release = device.hand().and_then(|hand| hand.release);
    numbers.extend(release.map(|release| ("hand_release_s", release)));
    if let Some(grip) = device.grip() {
        numbers.push(("hand_mass_kg", grip.mass));
        numbers.push(("hand_stiffness_n_per_m", grip.stiffness));
        numbers.push(("hand_damping_n_s_per_m", grip.damping));
        // A recorded intention is a file and not a number; the scene file names it.
        if let Intention::Place { position, swing } = grip.intention {
            numbers.push(("hand_position_m", position));
            if let Some(swing) = swing {
                numbers.push(("hand_swing_m", swing.amplitude));
                numbers.push(("hand_swing_hz", swing.frequency_hz));
            }
        }
    }
    let mut lines: Vec<(String, String)> = numbers
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value.to_string()))
        .collect();
    if let Some(PantographDevice {
        linkage, force_at, ..
    }) = device.pantograph()
    {
        if *force_at != HandForceAt::default() {
            lines.push(("hand_force_at".into(), force_at.name().to_owned()));
        }
        lines.push(("device.title".into(), linkage.title.clone()));
        let keys = linkage.keys.iter().cloned();
        lines.extend(
            keys.filter(|(key, _)| key != "title")
                .map(|(key, value)| (format!("device.{key}"), value)),
        );
    }
    lines.push(match scene.measure {
        Measure::Collisions(count) => ("measure_collisions".into(), count.to_string()),
        Measure::Duration(duration) => ("measure_duration_s".into(), duration.to_string()),
    });
    lines
}

/// Returns the bounds of a guard: `1 m/s, 0.02 J, 80 m/s^2 on 0.1 kg` or `..., 8 N on 0.1 kg`.
fn bounds(guard: &GuardParams<f64>) -> String {
    let mut text = format!("{} m/s, {} J", guard.largest_speed, guard.allowance);
    if let Some(hand) = guard.hand {
        text += &match hand.limit {
            HandLimit::Acceleration(most) => format!(", {most} m/s^2 on "),
            HandLimit::Force(most) => format!(", {most} N on "),
        };
        text += &match hand.least_mass {
            mass if mass.is_finite() => format!("{mass} kg"),
            _ => "half the model mass".into(),
        };
        if hand.learns_mass {
            text += " or the mass that the motion shows";
        }
    }
    if guard.recovery != GUARD_RECOVERY {
        text += &format!(", recovery {} W", guard.recovery);
    }
    text
}
