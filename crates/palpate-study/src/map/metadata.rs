//! Metadata of a map file.

use super::{
    ERROR_COLLISIONS, Forces, GROWTH_COLLISIONS, MapParams, PHASE_RANGE, PHASES, STABLE_UP_TO, Stay,
};
use palpate_record::map::{CELLS, LINES_PER_CELL, Map, SHARD};

/// The metadata of a map lacks a number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the metadata of the map has no number {0}")]
pub struct NoNumber(pub String);

/// Returns the metadata that determine a map, and the part of the map in the file.
#[must_use]
pub fn of(params: &MapParams, (number, of): (usize, usize)) -> Vec<(String, String)> {
    let methods: Vec<_> = params.methods.iter().map(|method| method.name()).collect();
    let device = &params.device;
    let forces = match params.forces {
        Forces::Balanced(acceleration) => [
            ("forces", "balanced".to_owned()),
            ("approach_m_per_s2", acceleration.to_string()),
            ("user_force_n", "balanced".to_owned()),
        ],
        Forces::Weight {
            user_force,
            gravity,
        } => [
            ("forces", "weight".to_owned()),
            ("gravity_m_per_s2", gravity.to_string()),
            ("user_force_n", user_force.to_string()),
        ],
    };
    let mut metadata = vec![
        ("palpate_version", env!("CARGO_PKG_VERSION").to_owned()),
        (SHARD, format!("{number}/{of}")),
        ("cells_per_axis", params.cells.to_string()),
        (CELLS, params.len().to_string()),
        (LINES_PER_CELL, params.entries().to_string()),
        ("methods", methods.join(" ")),
        ("start_heights", PHASES.to_string()),
        ("height_range", PHASE_RANGE.to_string()),
        ("growth_collisions", GROWTH_COLLISIONS.to_string()),
        ("error_collisions", ERROR_COLLISIONS.to_string()),
        ("stable_up_to_growth", STABLE_UP_TO.to_string()),
        ("device_mass_kg", device.mass.to_string()),
        ("period_s", params.period.to_string()),
        ("gap_m", params.gap.to_string()),
        (
            "viscous_friction_n_s_per_m",
            device.viscous_friction.to_string(),
        ),
        ("encoder_quantum_m", device.encoder_quantum.to_string()),
        ("delay_samples", params.delay.to_string()),
        ("model_mass_factor", device.model_mass.to_string()),
        ("model_period_factor", params.model_period.to_string()),
    ];
    // Without a lag the metadata equal those of versions before the lag was added.
    if params.lag != 0.0 {
        metadata.push(("lag_periods", params.lag.to_string()));
    }
    for (key, deviation) in [
        ("delay_deviation_periods", params.delay_deviation),
        ("lag_deviation_periods", params.lag_deviation),
    ] {
        if deviation != 0.0 {
            metadata.push((key, deviation.to_string()));
        }
    }
    metadata.extend(forces);
    metadata.extend(Stay::criterion());
    metadata
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}

/// Formats the metadata as one line.
#[must_use]
pub fn line(metadata: &[(String, String)]) -> String {
    let entries: Vec<String> = metadata
        .iter()
        .map(|(key, value)| format!("{key}={value}"))
        .collect();
    entries.join(";")
}

/// Returns a number of a map's metadata.
pub fn number(map: &Map, key: &str) -> Result<f64, NoNumber> {
    parsed(map, key)
}

/// Returns an integer of a map's metadata.
pub fn count(map: &Map, key: &str) -> Result<usize, NoNumber> {
    parsed(map, key)
}

fn parsed<T: std::str::FromStr>(map: &Map, key: &str) -> Result<T, NoNumber> {
    map.value(key)
        .and_then(|value| value.parse().ok())
        .ok_or_else(|| NoNumber(key.to_owned()))
}
