//! Candidate settings of tunable methods on a world.

use std::f64::consts::TAU;

use palpate_scene::world::{Coupling, WorldScene, WorldSettings};
use palpate_world::{Field, FieldKind};

/// A tunable method of worlds; `basic` and `coupled` have no tunable settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tunable {
    /// Damping.
    VirtualDamper,
    /// Stiffness and damping of the coupling, and the mass of the proxy.
    VirtualCoupling,
    /// Stiffness and damping of the coupling.
    GodObject,
}

/// Units of the candidate settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// K, the largest stiffness among contacts and fields `[N/m]`.
    pub stiffness: f64,
    /// T `[s]`.
    pub period: f64,
    /// m, the geometric mean of the devices' masses along all axes `[kg]`.
    pub mass: f64,
    /// Moment of inertia over mass, mean over the devices with a torque; `None` without such a device `[m^2]`.
    pub gyration: Option<f64>,
}

impl Scale {
    /// Returns the scale of a scene.
    #[must_use]
    pub fn new(scene: &WorldScene) -> Self {
        let laws = scene.world.contacts.iter().map(|contact| contact.law);
        let masses = || scene.devices.iter().flat_map(|device| device.mass);
        let finite = || masses().filter(|mass| mass.is_finite());
        let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
        let mass = mean(finite().map(f64::ln).sum(), finite().count()).exp();
        let moments: Vec<f64> = scene
            .devices
            .iter()
            .filter_map(|device| device.turning.filter(|turning| turning.gives_torque))
            .flat_map(|turning| turning.inertia)
            .collect();
        Self {
            stiffness: laws
                .map(|law| law.stiffness)
                .chain(scene.world.fields.iter().map(stiffness_of))
                .fold(0.0, f64::max),
            period: scene.timing.period,
            mass,
            gyration: (!moments.is_empty())
                .then(|| mean(moments.iter().sum(), moments.len()) / mass),
        }
    }
}

/// Returns the largest stiffness of a field `[N/m]`.
fn stiffness_of(field: &Field) -> f64 {
    match field.kind {
        FieldKind::Point { stiffness, .. }
        | FieldKind::Line { stiffness, .. }
        | FieldKind::Plane { stiffness, .. } => stiffness,
        FieldKind::Detents {
            period,
            amplitude,
            stiffness,
            ..
        } => (0.5 * amplitude * (TAU / period).powi(2)).max(stiffness),
        FieldKind::Constant { .. } => 0.0,
    }
}

impl Scale {
    /// Converts a value along an axis to the value about an axis; `None` if no device has a torque.
    fn turned(self, value: f64) -> Option<f64> {
        self.gyration.map(|gyration| value * gyration)
    }
}

/// Dampings over K T.
const DAMPINGS: [f64; 15] = [
    0.0, 0.02, 0.04, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8, 1.1, 1.6, 2.3, 3.2,
];

/// Stiffnesses over K of softer couplings, tried if no stiffer coupling is usable.
const SOFTER: [f64; 8] = [0.03, 0.01, 0.003, 0.001, 3e-4, 1e-4, 3e-5, 1e-5];

impl Tunable {
    /// All tunable methods, in the order of tables.
    pub const ALL: [Self; 3] = [Self::VirtualDamper, Self::VirtualCoupling, Self::GodObject];

    /// Returns the name of the method.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::VirtualDamper => "virtual-damper",
            Self::VirtualCoupling => "virtual-coupling",
            Self::GodObject => "god-object",
        }
    }

    /// Returns the tunable method of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tunable| tunable.name() == name)
    }

    /// Returns the settings of `all` that the method has.
    #[must_use]
    pub fn of_settings(self, all: &WorldSettings) -> WorldSettings {
        let WorldSettings {
            damping,
            rotational_damping,
            coupling,
            ..
        } = *all;
        match self {
            Self::VirtualCoupling => *all,
            Self::VirtualDamper => WorldSettings {
                damping,
                rotational_damping,
                ..WorldSettings::default()
            },
            Self::GodObject => WorldSettings {
                damping,
                rotational_damping: None,
                coupling: Coupling {
                    stiffness: coupling.stiffness,
                    ..Coupling::default()
                },
                ..WorldSettings::default()
            },
        }
    }

    /// Returns the candidate settings, in the order of tables: every damping with every coupling.
    #[must_use]
    pub fn candidates(self, scale: Scale) -> Vec<WorldSettings> {
        self.with_dampings(scale, |coupling| self.dampings(scale, coupling))
    }

    /// Returns softer couplings, tried if no [candidate](Self::candidates) is usable. Empty for the damper, whose
    /// spring is that of the contact.
    #[must_use]
    pub fn softer(self, scale: Scale) -> Vec<WorldSettings> {
        let couplings = match self {
            Self::VirtualDamper => Vec::new(),
            Self::VirtualCoupling => Self::couplings_of(scale, &SOFTER, &[0.1, 0.5, 2.0]),
            Self::GodObject => Self::god_objects(scale, &SOFTER),
        };
        Self::each(scale, couplings, |coupling| self.dampings(scale, coupling))
    }

    /// Returns each coupling with these dampings `[N s/m]`.
    pub fn with_dampings(
        self,
        scale: Scale,
        dampings: impl Fn(&Coupling) -> Vec<f64>,
    ) -> Vec<WorldSettings> {
        let couplings = match self {
            Self::VirtualDamper => vec![Coupling::default()],
            Self::VirtualCoupling => Self::couplings_of(scale, &[0.1, 0.3, 1.0, 3.0], &[0.1, 0.5]),
            Self::GodObject => Self::god_objects(scale, &[0.1, 0.3, 1.0]),
        };
        Self::each(scale, couplings, dampings)
    }

    fn each(
        scale: Scale,
        couplings: Vec<Coupling>,
        dampings: impl Fn(&Coupling) -> Vec<f64>,
    ) -> Vec<WorldSettings> {
        let mut all = Vec::new();
        for coupling in couplings {
            all.extend(
                dampings(&coupling)
                    .into_iter()
                    .map(|damping| WorldSettings {
                        damping: Some(damping),
                        rotational_damping: scale.turned(damping),
                        coupling,
                        ..WorldSettings::default()
                    }),
            );
        }
        all
    }

    /// Returns the settings of a virtual coupling: stiffnesses over K, each with masses over m.
    fn couplings_of(scale: Scale, stiffnesses: &[f64], masses: &[f64]) -> Vec<Coupling> {
        let parts = stiffnesses.iter();
        let parts = parts.flat_map(|k| masses.iter().map(|m| (*k, *m)));
        parts
            .map(|(k, m)| Coupling {
                stiffness: Some(k * scale.stiffness),
                mass: Some(m * scale.mass),
                rotational_stiffness: scale.turned(k * scale.stiffness),
                inertia: scale.turned(m * scale.mass),
            })
            .collect()
    }

    /// Returns the settings of a god-object: stiffnesses over K.
    fn god_objects(scale: Scale, stiffnesses: &[f64]) -> Vec<Coupling> {
        let proxy = |share: &f64| Coupling {
            stiffness: Some(share * scale.stiffness),
            ..Coupling::default()
        };
        stiffnesses.iter().map(proxy).collect()
    }

    fn dampings(self, scale: Scale, coupling: &Coupling) -> Vec<f64> {
        let stiffness = coupling.stiffness.unwrap_or(scale.stiffness);
        match (self, coupling.mass) {
            (Self::VirtualCoupling, Some(mass)) => [0.2, 0.6, 1.2]
                .map(|ratio| 2.0 * ratio * (stiffness * mass).sqrt())
                .into(),
            (Self::GodObject, _) => [0.0, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2]
                .map(|share| share * stiffness * scale.period)
                .into(),
            _ => DAMPINGS
                .map(|share| share * stiffness * scale.period)
                .into(),
        }
    }
}
