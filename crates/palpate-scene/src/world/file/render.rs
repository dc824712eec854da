//! The table `[render]` of a world.

use palpate_core::Range;
use palpate_world::{Vector, WorldField as Field, WorldGuard, WorldPart};
use serde::Deserialize;
use toml::Spanned;

use super::{RawModel, Reading};
use crate::world::guard::RawGuard;
use crate::world::per_axis::PerAxis;
use crate::world::{Coupling, WorldActuator, WorldDevice, WorldRender};

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRender {
    method: Option<Spanned<String>>,
    device_mass_kg: Option<Spanned<PerAxis>>,
    device_mass_factor: Option<Spanned<f64>>,
    damping_n_s_per_m: Option<Spanned<f64>>,
    coupling_stiffness_n_per_m: Option<Spanned<f64>>,
    coupling_mass_kg: Option<Spanned<f64>>,
    force_limit_n: Option<Spanned<f64>>,
    device_inertia_kg_m2: Option<Spanned<Vector>>,
    rotational_damping_n_m_s_per_rad: Option<Spanned<f64>>,
    coupling_rotational_stiffness_n_m_per_rad: Option<Spanned<f64>>,
    coupling_inertia_kg_m2: Option<Spanned<f64>>,
    torque_limit_n_m: Option<Spanned<f64>>,
    guard: Option<RawGuard>,
}

impl Reading {
    /// Returns the renderer's method, settings and model values, those of `devices` and `actuator` by default.
    pub(super) fn render(
        &mut self,
        raw: RawRender,
        model: RawModel,
        devices: &[WorldDevice],
        actuator: WorldActuator,
    ) -> WorldRender {
        if let Some(mass) = &raw.device_mass_kg {
            self.places
                .take(WorldPart::Method, Field::DeviceMass, mass.clone());
        }
        if let Some(damping) = &raw.damping_n_s_per_m {
            self.places
                .take(WorldPart::Method, Field::Damping, damping.clone());
        }
        let model_mass = raw.device_mass_kg.as_ref();
        let masses = self.device_masses(model_mass, raw.device_mass_factor, devices);
        let model_inertia = raw.device_inertia_kg_m2.map(|inertia| {
            self.places
                .take(WorldPart::Method, Field::DeviceInertia, inertia.clone());
            let key = "device_inertia_kg_m2";
            self.numbers(key, inertia.span(), inertia.get_ref(), Range::Positive);
            inertia.into_inner()
        });
        let inertia = devices.iter().map(|device| {
            let turning = device.turning.as_ref();
            turning.map(|turning| model_inertia.unwrap_or(turning.inertia))
        });
        WorldRender {
            method: raw.method.map_or_else(
                || "coupled".into(),
                |method| self.places.take(WorldPart::Method, Field::Method, method),
            ),
            device_mass: masses,
            damping: raw
                .damping_n_s_per_m
                .map(|damping| self.number("damping_n_s_per_m", damping, Range::NotNegative)),
            device_inertia: inertia.collect(),
            rotational_damping: raw.rotational_damping_n_m_s_per_rad.map(|damping| {
                self.number(
                    "rotational_damping_n_m_s_per_rad",
                    damping,
                    Range::NotNegative,
                )
            }),
            torque_limit: raw
                .torque_limit_n_m
                .map(|limit| self.number("torque_limit_n_m", limit, Range::Positive)),
            force_limit: raw
                .force_limit_n
                .map(|limit| self.number("force_limit_n", limit, Range::Positive)),
            coupling: self.coupling([
                raw.coupling_stiffness_n_per_m,
                raw.coupling_mass_kg,
                raw.coupling_rotational_stiffness_n_m_per_rad,
                raw.coupling_inertia_kg_m2,
            ]),
            actuator: self.actuator([model.delay_s, model.lag_s, model.gain], actuator),
            guard: raw.guard.map_or(WorldGuard::Off, |guard| self.guard(guard)),
        }
    }

    /// Returns the mass of each device in the model, along each axis `[kg]`: the device's own or `model_mass`, times the
    /// factor.
    fn device_masses(
        &mut self,
        model_mass: Option<&Spanned<PerAxis>>,
        factor: Option<Spanned<f64>>,
        devices: &[WorldDevice],
    ) -> Vec<Vector> {
        // Values along the axes of each device.
        let mut masses: Vec<_> = devices.iter().map(|device| device.mass).collect();
        for (number, mass) in masses.iter_mut().enumerate() {
            if let Some(model) = model_mass {
                let axes = self
                    .has_its_axes(number)
                    .then_some(mass.map(f64::is_finite));
                *mass = self.per_axis(
                    "device_mass_kg",
                    model,
                    Range::Positive,
                    (axes, f64::INFINITY),
                );
            }
        }
        if let Some(factor) = factor {
            if model_mass.is_some() {
                let message = "give either device_mass_kg or device_mass_factor, not both";
                self.fault(factor.span(), message);
            }
            let factor = self.number("device_mass_factor", factor, Range::Positive);
            for mass in masses.iter_mut().flatten() {
                *mass *= factor;
            }
        }
        masses
    }

    /// Returns the given stiffness, mass, rotational stiffness and inertia of the coupling.
    fn coupling(
        &mut self,
        [stiffness, mass, rotational_stiffness, inertia]: [Option<Spanned<f64>>; 4],
    ) -> Coupling {
        Coupling {
            stiffness: stiffness
                .map(|value| self.number("coupling_stiffness_n_per_m", value, Range::Positive)),
            mass: mass.map(|value| self.number("coupling_mass_kg", value, Range::Positive)),
            rotational_stiffness: rotational_stiffness.map(|value| {
                let key = "coupling_rotational_stiffness_n_m_per_rad";
                self.number(key, value, Range::Positive)
            }),
            inertia: inertia
                .map(|value| self.number("coupling_inertia_kg_m2", value, Range::Positive)),
        }
    }
}
