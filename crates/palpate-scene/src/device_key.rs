//! `[[device]]` of a scene file.

use palpate_world::{Quaternion, Vector};
use serde::Deserialize;
use toml::Spanned;

use super::device_file::RawBox;
use super::drivetrain_key::RawDrivetrain;
use super::hand_key::RawHand;
use crate::fault::Span;
use crate::world::mass_table::RawMassTable;
use crate::world::per_axis::{DeviceAxes, PerAxis};
use crate::world::shape::RawShape;

/// A device with its drivetrain and its hand.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawDevice {
    pub name: Spanned<String>,
    pub axes: Option<Spanned<DeviceAxes>>,
    pub mass_kg: Option<Spanned<PerAxis>>,
    pub mass_table: Option<Spanned<RawMassTable>>,
    pub linkage: Option<Spanned<RawLinkage>>,
    pub safety_box: Option<Spanned<RawBox>>,
    pub position_m: Option<Spanned<Vector>>,
    pub velocity_m_per_s: Option<Spanned<Vector>>,
    pub quantum_m: Option<Spanned<PerAxis>>,
    pub noise_m: Option<Spanned<f64>>,
    pub inertia_kg_m2: Option<Spanned<Vector>>,
    pub gives_torque: Option<Spanned<bool>>,
    pub orientation: Option<Spanned<Quaternion>>,
    pub angular_velocity_rad_per_s: Option<Spanned<Vector>>,
    pub quantum_rad: Option<Spanned<f64>>,
    pub tool: Option<Spanned<RawShape>>,
    #[serde(default)]
    pub drivetrain: RawDrivetrain,
    #[serde(default)]
    pub hand: RawHand,
}

/// A linkage by its name, or by the file that describes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLinkage {
    pub preset: Option<Spanned<String>>,
    pub file: Option<Spanned<String>>,
}

/// Keys of a device's rotation, without its inertia.
pub(crate) struct TurningKeys {
    /// Rotational stiffness of the hand `[N m/rad]`.
    pub stiffness: Option<Spanned<f64>>,
    /// Rotational damping of the hand `[N m s/rad]`.
    pub damping: Option<Spanned<f64>>,
    /// Quantum of the angle sensor `[rad]`.
    pub quantum: Option<Spanned<f64>>,
    /// Amplitude of the tremor's torque `[N m]`.
    pub tremor: Option<Spanned<f64>>,
    /// Orientation at the start.
    pub orientation: Option<Spanned<Quaternion>>,
    /// Orientation at which the hand is at rest.
    pub rest: Option<Spanned<Quaternion>>,
    /// Torque of the hand `[N m]`.
    pub torque: Option<Spanned<Vector>>,
    /// Angular velocity at the start `[rad/s]`.
    pub angular_velocity: Option<Spanned<Vector>>,
    /// Whether the motors give torques.
    pub gives_torque: Option<Spanned<bool>>,
}

impl TurningKeys {
    /// Takes the keys out of a device.
    pub fn take(raw: &mut RawDevice) -> Self {
        Self {
            stiffness: raw.hand.rotational_stiffness_n_m_per_rad.take(),
            damping: raw.hand.rotational_damping_n_m_s_per_rad.take(),
            quantum: raw.quantum_rad.take(),
            tremor: raw.hand.tremor_n_m.take(),
            orientation: raw.orientation.take(),
            rest: raw.hand.rest_orientation.take(),
            torque: raw.hand.torque_n_m.take(),
            angular_velocity: raw.angular_velocity_rad_per_s.take(),
            gives_torque: raw.gives_torque.take(),
        }
    }

    /// Returns the error of each key that is given for a device without an inertia.
    pub fn refused(&self) -> Vec<(Span, String)> {
        let keys = [
            (
                "hand.rotational_stiffness_n_m_per_rad",
                span(&self.stiffness),
            ),
            ("hand.rotational_damping_n_m_s_per_rad", span(&self.damping)),
            ("quantum_rad", span(&self.quantum)),
            ("hand.tremor_n_m", span(&self.tremor)),
            ("orientation", span(&self.orientation)),
            ("hand.rest_orientation", span(&self.rest)),
            ("hand.torque_n_m", span(&self.torque)),
            ("angular_velocity_rad_per_s", span(&self.angular_velocity)),
            ("gives_torque", span(&self.gives_torque)),
        ];
        let refused = keys.into_iter().filter_map(|(key, span)| {
            let message =
                format!("{key} needs a device of six axes, with inertia_kg_m2 (three moments)");
            Some((span?, message))
        });
        refused.collect()
    }
}

/// Returns the span of a value, if it is given.
pub(crate) fn span<T>(value: &Option<Spanned<T>>) -> Option<Span> {
    value.as_ref().map(Spanned::span)
}
