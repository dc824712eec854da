//! Rows of a suite as CSV: one per plant, condition and column.

use std::io::Write;
use std::ops::Range;

use super::{COLLISIONS, Column, Evaluated, Set, Trial};
use palpate_core::Mass;
use palpate_record::run::{Cell, RunWriteError, RunWriter};

/// Columns with the properties of a plant, in each of its rows.
const PLANT: [&str; 25] = [
    "seed",
    "plant",
    "redrawn",
    "device_mass_kg",
    "model_device_mass_kg",
    "period_s",
    "kappa",
    "object_kappa",
    "stiffness_n_per_m",
    "object_mass_kg",
    "gap_m",
    "impact_speed_m_per_s",
    "user_force_n",
    "viscous_n_s_per_m",
    "coulomb_n",
    "encoder_quantum_m",
    "hand_mass_kg",
    "hand_stiffness_n_per_m",
    "hand_damping_n_s_per_m",
    "tremor_n",
    "tremor_hz",
    "periods",
    "ideal_error",
    "ideal_peak_force_n",
    "hold_bound_percent",
];

/// Further columns with the properties of a plant in sets with real actuators: the true values, and the model values
/// of the scene.
const ACTUATOR: [&str; 15] = [
    "delay_s",
    "command_jitter_s",
    "lag_s",
    "gain",
    "model_delay_s",
    "model_lag_s",
    "model_gain",
    "resonance_hz",
    "resonance_damping_ratio",
    "motor_mass_share",
    "backlash_m",
    "cogging_n",
    "cogging_pitch_m",
    "noise_m",
    "schedule_seed",
];

/// Columns with the results of a trial, between its condition and its collisions.
const TRIAL: [&str; 10] = [
    "column",
    "method",
    "damping_n_s_per_m",
    "samples",
    "limited",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_bound",
    "peak_force_n",
    "diverged",
];

/// Writes a row per trial, after the metadata of the trials.
pub fn write(
    writer: &mut dyn Write,
    set: Set,
    seeds: &Range<u64>,
    columns: &[Column],
    evaluated: &[Evaluated],
) -> Result<(), RunWriteError> {
    let is_paper = set == Set::Paper;
    let conditions = set.conditions();
    let in_words: Vec<String> = conditions.iter().map(ToString::to_string).collect();
    let mut metadata = vec![
        ("palpate_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("seed", seeds.start.to_string()),
        ("plants", evaluated.len().to_string()),
    ];
    if seeds.end - seeds.start > 1 {
        metadata.push(("seeds", (seeds.end - seeds.start).to_string()));
    }
    if !is_paper {
        metadata.push(("set", set.name().to_owned()));
    }
    let of_collisions: Vec<String> = (1..=COLLISIONS)
        .flat_map(|number| {
            ["impulse", "peak_force"].map(|what| format!("collision_{number}_{what}_error_percent"))
        })
        .collect();
    let mut header = PLANT.to_vec();
    if is_paper {
        header.extend(["delay_samples", "model_delay_samples"]);
    } else {
        header.extend(ACTUATOR);
        header.push("condition");
    }
    header.extend(TRIAL);
    header.extend(of_collisions.iter().map(String::as_str));
    let mut file = RunWriter::new(writer, &metadata, &header)?;
    for one in evaluated {
        let mut plant = plant_cells(one).to_vec();
        if !is_paper {
            plant.extend(actuator_cells(one));
        }
        for trial in &one.trials {
            let mut row: Vec<Cell> = plant.iter().copied().map(Cell::from).collect();
            let condition = conditions[trial.condition];
            match (condition.delay(), condition.model_delay()) {
                (Some(delay), Some(model)) => {
                    row.extend([delay, model].map(|delay| Cell::from(delay as f64)));
                }
                _ => row.push(Cell::from(in_words[trial.condition].as_str())),
            }
            row.extend(trial_cells(trial, columns));
            file.row(&row)?;
        }
    }
    file.finish()?;
    Ok(())
}

/// Returns the values in the order of [`PLANT`]; values of a missing hand or tremor are empty.
fn plant_cells(one: &Evaluated) -> [f64; PLANT.len()] {
    let (plant, scene) = (&one.plant, &one.plant.scene);
    let grip = |value: fn(&palpate_scene::Grip) -> f64| scene.device.grip().map_or(f64::NAN, value);
    let tremor = |value: fn(&palpate_scene::Wave) -> f64| {
        scene.device.tremor().as_ref().map_or(f64::NAN, value)
    };
    [
        plant.seed as f64,
        plant.index as f64,
        f64::from(plant.redrawn),
        scene.device.mass(),
        scene.model_device_mass.unwrap_or(scene.device.mass()),
        scene.loop_params.period,
        plant.kappa,
        plant.object_kappa,
        scene.contact.stiffness,
        match scene.contact.object_mass {
            Mass::Finite(mass) => mass,
            Mass::Infinite => f64::INFINITY,
        },
        scene.object.position,
        plant.impact_speed,
        scene.device.hand_force(),
        scene.device.viscous_friction(),
        scene.device.coulomb_friction(),
        scene.device.encoder_quantum(),
        grip(|grip| grip.mass),
        grip(|grip| grip.stiffness),
        grip(|grip| grip.damping),
        tremor(|tremor| tremor.amplitude),
        tremor(|tremor| tremor.frequency_hz),
        one.periods as f64,
        one.ideal_error,
        one.ideal_peak,
        one.trials
            .first()
            .map_or(f64::NAN, |trial| trial.fidelity.hold_bound),
    ]
}

/// Returns the values in the order of [`ACTUATOR`]; values of a missing transmission or cogging are empty.
fn actuator_cells(one: &Evaluated) -> [f64; ACTUATOR.len()] {
    let scene = &one.plant.scene;
    let model = scene.model_actuation();
    let device = scene.device.point_mass();
    let transmission = device.and_then(|device| device.transmission);
    let cogging = device.and_then(|device| device.cogging);
    let of_transmission =
        |value: fn(palpate_scene::Transmission) -> f64| transmission.map_or(f64::NAN, value);
    [
        scene.delay.seconds(),
        scene.timing.command_jitter,
        scene.actuator.lag,
        scene.actuator.gain,
        model.delay,
        model.lag,
        model.gain,
        of_transmission(|one| one.resonance_hz),
        of_transmission(|one| one.damping_ratio),
        of_transmission(|one| one.motor_share),
        of_transmission(|one| one.backlash),
        cogging.map_or(f64::NAN, |one| one.amplitude),
        cogging.map_or(f64::NAN, |one| one.pitch),
        scene.device.noise(),
        scene.timing.seed as f64,
    ]
}

/// Returns the values in the order of [`TRIAL`], and then the collisions. A collision without a rendered one has no
/// errors.
fn trial_cells<'a>(trial: &Trial, columns: &'a [Column]) -> Vec<Cell<'a>> {
    let column = &columns[trial.column];
    let mut cells = vec![
        Cell::from(column.name.as_str()),
        Cell::from(column.method.name()),
        // Empty without several dampings.
        trial.damping.unwrap_or(f64::NAN).into(),
        Cell::from(trial.samples as f64),
        Cell::from(trial.limited as f64),
        trial.fidelity.mean_force_error.into(),
        trial.fidelity.force_rendering_error.into(),
        trial.fidelity.error_over_bound.unwrap_or(f64::NAN).into(),
        trial.force.peak_force.into(),
        Cell::from(if trial.diverged { "yes" } else { "no" }),
    ];
    for number in 0..COLLISIONS {
        let rendered = trial.force.collisions.get(number);
        let rendered = rendered.and_then(|collision| collision.rendered.as_ref());
        let in_percent =
            |error: Option<f64>| Cell::from(error.map_or(f64::NAN, |error| 100.0 * error));
        cells.push(in_percent(rendered.and_then(|one| one.impulse_error)));
        cells.push(in_percent(rendered.and_then(|one| one.peak_force_error)));
    }
    cells
}
