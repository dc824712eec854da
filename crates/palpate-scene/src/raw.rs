//! The tables of a scene file, as the reader fills them.

use std::collections::HashMap;

use palpate_world::{Quaternion, Vector};
use serde::Deserialize;
use toml::Spanned;

use crate::device_key::RawDevice;
use crate::model::RawModel;
use crate::raw_settings::RawSettings;
use crate::render_key::RawRender;
use crate::timing::RawLoop;
use crate::world::field::RawField;
use crate::world::joint::RawJoint;
use crate::world::pair::Pair;
use crate::world::per_axis::DeviceAxes;
use crate::world::shape::RawShape;

/// A scene file. Every key is here, whichever renderer uses it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawScene {
    #[serde(rename = "format")]
    _format: i64,
    #[serde(default)]
    pub title: String,
    pub r#loop: RawLoop,
    #[serde(default)]
    pub device: Vec<Spanned<RawDevice>>,
    #[serde(default)]
    pub body: Vec<Spanned<RawBody>>,
    #[serde(default)]
    pub contact: Vec<Spanned<RawContact>>,
    #[serde(default)]
    pub joint: Vec<Spanned<RawJoint>>,
    #[serde(default)]
    pub field: Vec<Spanned<RawField>>,
    #[serde(default)]
    pub model: RawModel,
    #[serde(default)]
    pub render: RawRender,
    #[serde(default)]
    pub methods: HashMap<Spanned<String>, RawSettings>,
    #[serde(default)]
    pub measure: RawMeasure,
}

/// `[[body]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawBody {
    pub name: Spanned<String>,
    #[serde(default)]
    pub fixed: bool,
    pub axes: Option<Spanned<DeviceAxes>>,
    pub mass_kg: Option<Spanned<f64>>,
    pub inertia_kg_m2: Option<Spanned<Vector>>,
    pub position_m: Option<Spanned<Vector>>,
    pub centre_m: Option<Spanned<Vector>>,
    pub orientation: Option<Spanned<Quaternion>>,
    pub velocity_m_per_s: Option<Spanned<Vector>>,
    pub angular_velocity_rad_per_s: Option<Spanned<Vector>>,
    pub force_n: Option<Spanned<Vector>>,
    pub shape: Spanned<RawShape>,
}

impl RawBody {
    /// Returns the keys that a fixed body lacks, each with its span if it is given.
    pub fn keys_of_motion(&self) -> [(&'static str, Option<crate::fault::Span>); 6] {
        let span = |vector: &Option<Spanned<Vector>>| vector.as_ref().map(Spanned::span);
        [
            ("mass_kg", self.mass_kg.as_ref().map(Spanned::span)),
            ("axes", self.axes.as_ref().map(Spanned::span)),
            ("inertia_kg_m2", span(&self.inertia_kg_m2)),
            ("velocity_m_per_s", span(&self.velocity_m_per_s)),
            (
                "angular_velocity_rad_per_s",
                span(&self.angular_velocity_rad_per_s),
            ),
            ("force_n", span(&self.force_n)),
        ]
    }
}

/// `[[contact]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawContact {
    pub between: Spanned<Pair>,
    pub stiffness_n_per_m: Spanned<f64>,
    pub damping_n_s_per_m: Option<Spanned<f64>>,
    pub friction: Option<Spanned<f64>>,
    pub friction_stiffness_n_per_m: Option<Spanned<f64>>,
    pub friction_damping_n_s_per_m: Option<Spanned<f64>>,
}

/// `[measure]`.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMeasure {
    pub collisions: Option<Spanned<usize>>,
    pub duration_s: Option<Spanned<f64>>,
}
