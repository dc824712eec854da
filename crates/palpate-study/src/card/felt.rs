//! Felt impedance on the device of a report: effective stiffness, damping and mass by frequency, and the stable
//! stiffness over damping (Z-width).

use palpate_core::ParameterValue;
use palpate_scene::Model;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use super::device::DeviceCard;
use super::reach::Properties;
use crate::advise::Reach;
use crate::impedance::{EffectiveImpedance, FeltImpedance, MIN_SAMPLES_PER_CYCLE};
use crate::map::{Bounce, BounceError, PRESSED_WITH, default_settings};

/// Frequencies of the hand's motion `[Hz]`, as far as the period allows.
const FREQUENCIES: [f64; 6] = [1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// Dampings of a virtual damper, over m/T.
const DAMPINGS: [f64; 9] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5];

/// Felt impedance of contacts on a device.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FeltCard {
    /// Stiffness of the contacts `[N/m]`.
    pub stiffness_n_per_m: f64,
    /// Mass of the free object `[kg]`: that of the device.
    pub object_mass_kg: f64,
    /// Force that presses the contacts `[N]`.
    pub pressed_with_n: f64,
    /// One entry for each method.
    pub methods: Vec<MethodFeltCard>,
    /// Dampings of a wall by `virtual-damper` `[N s/m]`.
    pub damping_n_s_per_m: Vec<f64>,
    /// Maximum stiffness of a wall that is stable and steady while it is pressed, per damping `[N/m]`: the Z-width of
    /// the device.
    pub stable_n_per_m: Vec<Reach>,
}

/// Impedances of a method.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodFeltCard {
    /// The method.
    pub method: &'static str,
    /// A wall, one entry per frequency.
    pub wall: Vec<FeltPointCard>,
    /// A free object, one entry per frequency.
    pub object: Vec<FeltPointCard>,
}

/// Impedance of a contact at a frequency.
#[derive(Debug, Clone, Copy, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FeltPointCard {
    /// Frequency of the hand's motion `[Hz]`.
    pub frequency_hz: f64,
    /// Impedance of the ideal contact, without the device; none if there is no steady oscillation.
    pub wanted: Option<EffectiveCard>,
    /// Impedance of the rendered contact, without the device.
    pub rendered: Option<EffectiveCard>,
    /// Impedance of the rendered contact and of the device's mass and viscous friction.
    pub with_device: Option<EffectiveCard>,
}

/// Effective stiffness, damping and mass.
#[derive(Debug, Clone, Copy, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct EffectiveCard {
    /// Real part of force over displacement `[N/m]`; negative where a mass is felt.
    pub stiffness_n_per_m: f64,
    /// Imaginary part of force over displacement, over the angular frequency `[N s/m]`; negative where the contact
    /// gives out energy.
    pub damping_n_s_per_m: f64,
    /// Effective mass `[kg]`: minus the stiffness over the squared angular frequency; 0 where a stiffness is felt.
    pub mass_kg: f64,
}

impl EffectiveCard {
    fn new(impedance: EffectiveImpedance, frequency: f64) -> Self {
        Self {
            stiffness_n_per_m: impedance.stiffness,
            damping_n_s_per_m: impedance.damping,
            mass_kg: impedance.mass(frequency),
        }
    }
}

impl FeltPointCard {
    fn new(frequency: f64, felt: Option<FeltImpedance>) -> Self {
        let part = |of: fn(&FeltImpedance) -> EffectiveImpedance| {
            felt.as_ref()
                .map(|felt| EffectiveCard::new(of(felt), frequency))
        };
        Self {
            frequency_hz: frequency,
            wanted: part(|felt| felt.wanted),
            rendered: part(|felt| felt.rendered),
            with_device: part(|felt| felt.with_device),
        }
    }
}

impl FeltCard {
    /// Computes the impedances of `methods` and the Z-width with the properties of `device`; `None` if its mass or its
    /// period is unknown.
    pub(super) fn new(
        device: &DeviceCard,
        deviations: &Model,
        stiffness: f64,
        methods: &[MethodName],
    ) -> Result<Option<Self>, BounceError> {
        let Some(properties) = Properties::of(device) else {
            return Ok(None);
        };
        let wall = properties.bounce(deviations, stiffness);
        let object = Bounce {
            object_mass: properties.mass,
            ..wall
        };
        let methods: Result<Vec<MethodFeltCard>, BounceError> = methods
            .into_par_iter()
            .map(|&method| {
                Ok(MethodFeltCard {
                    method: method.name(),
                    wall: points(&wall, method)?,
                    object: points(&object, method)?,
                })
            })
            .collect();
        let damping = DAMPINGS.map(|share| share * properties.mass / properties.period);
        let stable: Result<Vec<Reach>, BounceError> = damping
            .into_par_iter()
            .map(|damping| {
                let damped =
                    Settings::default().with(SettingKey::DAMPING, ParameterValue::Number(damping));
                Ok(wall
                    .stiffest_steady(MethodName::VirtualDamper, damped)?
                    .into())
            })
            .collect();
        Ok(Some(Self {
            stiffness_n_per_m: stiffness,
            object_mass_kg: properties.mass,
            pressed_with_n: PRESSED_WITH,
            methods: methods?,
            damping_n_s_per_m: damping.to_vec(),
            stable_n_per_m: stable?,
        }))
    }

    /// Returns the stiffest stable wall and its damping `[N/m]`, `[N s/m]`; `None` if no wall is stable.
    #[must_use]
    pub fn stiffest(&self) -> Option<(f64, f64)> {
        let stable = self.stable_n_per_m.iter().zip(&self.damping_n_s_per_m);
        stable
            .filter_map(|(limit, damping)| Some((limit.value?, *damping)))
            .max_by(|one, other| one.0.total_cmp(&other.0))
    }
}

/// Returns the impedance of `contact` by `method` at each frequency that its period allows.
fn points(contact: &Bounce, method: MethodName) -> Result<Vec<FeltPointCard>, BounceError> {
    let settings = default_settings(method);
    FREQUENCIES
        .into_iter()
        .filter(|frequency| frequency * contact.period * MIN_SAMPLES_PER_CYCLE <= 1.0)
        .map(|frequency| {
            let felt = contact.impedance(method, settings, frequency)?;
            Ok(FeltPointCard::new(frequency, felt))
        })
        .collect()
}
