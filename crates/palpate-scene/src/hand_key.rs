//! `[device.hand]` of a scene file.

use std::ops::Range;
use std::sync::Arc;

use palpate_testbed::recorded_path::RecordedPath;
use palpate_world::{Quaternion, Vector};
use serde::Deserialize;
use toml::Spanned;

use super::HandForceAt;
use super::beside::Files;
use super::device_key::span;
use super::recover::Fault;

/// Keys of a hand.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawHand {
    pub force_n: Option<Spanned<Vector>>,
    pub stiffness_n_per_m: Option<Spanned<f64>>,
    pub damping_n_s_per_m: Option<Spanned<f64>>,
    pub rest_m: Option<Spanned<Vector>>,
    pub rest_file: Option<Spanned<String>>,
    pub swing_m: Option<Spanned<Vector>>,
    pub swing_hz: Option<Spanned<f64>>,
    pub mass_kg: Option<Spanned<f64>>,
    pub release_s: Option<Spanned<f64>>,
    pub force_at: Option<Spanned<HandForceAt>>,
    pub tremor_n: Option<Spanned<f64>>,
    pub tremor_hz: Option<Spanned<f64>>,
    pub torque_n_m: Option<Spanned<Vector>>,
    pub rotational_stiffness_n_m_per_rad: Option<Spanned<f64>>,
    pub rotational_damping_n_m_s_per_rad: Option<Spanned<f64>>,
    pub rest_orientation: Option<Spanned<Quaternion>>,
    pub tremor_n_m: Option<Spanned<f64>>,
}

impl RawHand {
    /// Whether a key of the hand's mass, spring or damper is given, even as 0.
    pub fn has_grip(&self) -> bool {
        self.spans_of_grip().iter().any(|(_, span)| span.is_some())
    }

    /// Returns the name of each key of the hand's mass, spring or damper, and its span if it is given.
    pub fn spans_of_grip(&self) -> [(&'static str, Option<Range<usize>>); 7] {
        [
            ("device.hand.mass_kg", span(&self.mass_kg)),
            (
                "device.hand.stiffness_n_per_m",
                span(&self.stiffness_n_per_m),
            ),
            (
                "device.hand.damping_n_s_per_m",
                span(&self.damping_n_s_per_m),
            ),
            ("device.hand.rest_m", span(&self.rest_m)),
            ("device.hand.rest_file", span(&self.rest_file)),
            ("device.hand.swing_m", span(&self.swing_m)),
            ("device.hand.swing_hz", span(&self.swing_hz)),
        ]
    }
}

/// Returns the motion in a file that the scene names, its times counted from its first sample.
pub(crate) fn recorded_rest(
    name: &Spanned<String>,
    files: Files<'_>,
) -> Result<Arc<RecordedPath>, Fault> {
    let fault = |message: String| (name.span(), message);
    let file = name.get_ref();
    let text = files(file).map_err(|error| fault(format!("{file} cannot be read: {error}")))?;
    let trace = palpate_record::trace::read(text.as_bytes(), file)
        .map_err(|error| fault(error.to_string()))?;
    let start = trace.t_s.first().copied().unwrap_or(0.0);
    let times: Vec<f64> = trace.t_s.iter().map(|time| time - start).collect();
    RecordedPath::new(&times, &trace.position_m)
        .map(Arc::new)
        .map_err(|error| fault(format!("{file}: {error}")))
}
