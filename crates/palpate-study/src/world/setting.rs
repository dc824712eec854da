//! Settings of a method of worlds in reports, under the keys of scene files.

use palpate_scene::world::WorldSettings;
use serde::Serialize;

use crate::text::digits;

/// The settings of a method of worlds.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SettingReport {
    /// Damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_n_s_per_m: Option<f64>,
    /// Stiffness of the coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling_stiffness_n_per_m: Option<f64>,
    /// Mass of the proxy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling_mass_kg: Option<f64>,
    /// Rotational damping.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotational_damping_n_m_s_per_rad: Option<f64>,
    /// Rotational stiffness of the coupling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling_rotational_stiffness_n_m_per_rad: Option<f64>,
    /// Moment of inertia of the proxy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling_inertia_kg_m2: Option<f64>,
}

impl From<&WorldSettings> for SettingReport {
    fn from(settings: &WorldSettings) -> Self {
        Self {
            damping_n_s_per_m: settings.damping,
            coupling_stiffness_n_per_m: settings.coupling.stiffness,
            coupling_mass_kg: settings.coupling.mass,
            rotational_damping_n_m_s_per_rad: settings.rotational_damping,
            coupling_rotational_stiffness_n_m_per_rad: settings.coupling.rotational_stiffness,
            coupling_inertia_kg_m2: settings.coupling.inertia,
        }
    }
}

impl SettingReport {
    /// Returns the set values with their keys.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
        [
            ("damping_n_s_per_m", self.damping_n_s_per_m),
            (
                "coupling_stiffness_n_per_m",
                self.coupling_stiffness_n_per_m,
            ),
            ("coupling_mass_kg", self.coupling_mass_kg),
            (
                "rotational_damping_n_m_s_per_rad",
                self.rotational_damping_n_m_s_per_rad,
            ),
            (
                "coupling_rotational_stiffness_n_m_per_rad",
                self.coupling_rotational_stiffness_n_m_per_rad,
            ),
            ("coupling_inertia_kg_m2", self.coupling_inertia_kg_m2),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?)))
    }

    /// Returns the values along an axis in short form: `B 4 N s/m, k 4000 N/m, m 0.1 kg`.
    #[must_use]
    pub fn in_short(&self) -> String {
        let parts = [
            ("B", self.damping_n_s_per_m, "N s/m"),
            ("k", self.coupling_stiffness_n_per_m, "N/m"),
            ("m", self.coupling_mass_kg, "kg"),
        ];
        let parts = parts.into_iter().filter_map(|(symbol, value, unit)| {
            Some(format!("{symbol} {} {unit}", digits(value?)))
        });
        parts.collect::<Vec<_>>().join(", ")
    }
}
