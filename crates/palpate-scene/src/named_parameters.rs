//! Parameters of a method under the names that scene files use.

use std::fmt;

use palpate::{AnyParams, DamperObject, EntryHold, LeakDissipation, Mass, Prediction, SehEstimate};

use crate::method::{MethodName, Predictor};

/// The value of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterValue {
    /// A number, in the unit that the parameter's name ends with.
    Number(f64),
    /// One of several words.
    Word(&'static str),
    /// On or off.
    Switch(bool),
    /// A number that is not derived yet.
    ToBeDerived,
}

impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word) => f.write_str(word),
            Self::Switch(on) => write!(f, "{on}"),
            Self::ToBeDerived => f.write_str("auto"),
        }
    }
}

/// Parameters by name, with the unit in the name; empty for a method without any.
#[must_use]
pub fn named_parameters(params: &AnyParams<f64>) -> Vec<(&'static str, ParameterValue)> {
    use ParameterValue::{Number, Switch, ToBeDerived, Word};
    match params {
        AnyParams::Basic => Vec::new(),
        AnyParams::VirtualDamper(damper) => {
            let mut named = vec![
                ("damping_n_s_per_m", Number(damper.damping)),
                ("damper_object", Word(damper_object_name(damper.object))),
            ];
            named.extend(prediction(&damper.prediction));
            named
        }
        AnyParams::Seh(seh) => vec![(
            "estimate",
            Word(match seh.estimate {
                SehEstimate::Ab2 => "ab2",
                SehEstimate::Differences => "differences",
                SehEstimate::Ab3 => "ab3",
            }),
        )],
        AnyParams::Popc(popc) => vec![
            ("damping_cap_n_s_per_m", Number(popc.damping_cap)),
            ("speed_threshold_m_per_s", Number(popc.speed_threshold)),
            ("initial_energy_j", Number(popc.initial_energy)),
        ],
        AnyParams::PopcRef(popc) => vec![
            ("damping_cap_n_s_per_m", Number(popc.damping_cap)),
            ("speed_threshold_m_per_s", Number(popc.speed_threshold)),
        ],
        AnyParams::Coupled(coupled) => vec![
            (
                "device_mass_kg",
                match coupled.device_mass {
                    Mass::Finite(mass) => Number(mass),
                    Mass::Infinite => Word("inf"),
                },
            ),
            ("encoder_quantum_m", Number(coupled.encoder_quantum)),
            ("placement", Switch(coupled.placement)),
            ("correction", Switch(coupled.correction)),
        ],
        AnyParams::Hfcr(hfcr) => {
            let mut named = vec![
                ("modified_force", Switch(hfcr.modified_force)),
                ("smooth_transition", Switch(hfcr.smooth_transition)),
                (
                    "damping_n_s_per_m",
                    match hfcr.leak_dissipation {
                        LeakDissipation::Off => Number(0.0),
                        LeakDissipation::Damping(damping) => Number(damping),
                        LeakDissipation::Auto { .. } => ToBeDerived,
                    },
                ),
            ];
            named.extend(prediction(&hfcr.prediction));
            if hfcr.smooth_transition {
                named.push(("entry_hold", Word(entry_hold_name(hfcr.entry_hold))));
            }
            named
        }
    }
}

fn prediction(prediction: &Prediction<f64>) -> Vec<(&'static str, ParameterValue)> {
    use ParameterValue::{Number, Word};
    let (predictor, own) = match *prediction {
        Prediction::LastStep => (Predictor::LastStep, Vec::new()),
        Prediction::FirstOrderAdaptiveWindow {
            noise_bound,
            longest_window,
        } => (
            Predictor::FirstOrderAdaptiveWindow,
            vec![
                ("noise_bound_m", Number(noise_bound)),
                ("longest_window_s", Number(longest_window)),
            ],
        ),
        Prediction::Extrapolation => (Predictor::Extrapolation, Vec::new()),
        Prediction::Observer { .. } => (Predictor::Observer, Vec::new()),
    };
    let mut named = vec![("prediction", Word(predictor.name()))];
    named.extend(own);
    named
}

/// What moves the object of a virtual damper, as files and flags spell it.
#[must_use]
pub fn damper_object_name(object: DamperObject) -> &'static str {
    match object {
        DamperObject::SpringAndDamper => "spring-and-damper",
        DamperObject::Spring => "spring",
        DamperObject::HeldForce => "held-force",
    }
}

/// Where HFCR holds the device after an entry, as files and flags spell it.
#[must_use]
pub fn entry_hold_name(hold: EntryHold) -> &'static str {
    match hold {
        EntryHold::Crossing => "crossing",
        EntryHold::Sample => "sample",
        EntryHold::Midpoint => "midpoint",
    }
}

/// The method that has `params`; of the two names for HFCR without dissipation the shorter, `hfcr`.
#[must_use]
pub fn method_of(params: &AnyParams<f64>) -> MethodName {
    match params {
        AnyParams::Basic => MethodName::Basic,
        AnyParams::VirtualDamper(_) => MethodName::VirtualDamper,
        AnyParams::Seh(_) => MethodName::Seh,
        AnyParams::Popc(_) => MethodName::Popc,
        AnyParams::PopcRef(_) => MethodName::PopcRef,
        AnyParams::Hfcr(hfcr) if !hfcr.smooth_transition => MethodName::HfcrMod,
        AnyParams::Hfcr(_) => MethodName::Hfcr,
        AnyParams::Coupled(_) => MethodName::Coupled,
    }
}

/// A method and its parameters: `virtual-damper (damping_n_s_per_m 2.5)`.
#[must_use]
pub fn in_words(params: &AnyParams<f64>) -> String {
    let named: Vec<String> = named_parameters(params)
        .into_iter()
        .map(|(name, value)| format!("{name} {value}"))
        .collect();
    let method = method_of(params);
    if named.is_empty() {
        method.to_string()
    } else {
        format!("{method} ({})", named.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::{Basis, Settings};

    #[test]
    fn every_method_is_said_by_its_name_and_keys_and_never_as_rust_spells_it() {
        let basis = Basis {
            stiffness: 400.0,
            period: 0.01,
            device_mass: Some(0.25),
            encoder_quantum: 1e-6,
            recorded: false,
            stored_energy: 0.5,
        };
        for method in MethodName::ALL {
            let params = method.params(&Settings::default(), &basis).unwrap();
            let said = in_words(&params);
            let expected = match method {
                MethodName::HfcrModSt => MethodName::Hfcr,
                other => other,
            };
            assert!(said.starts_with(expected.name()), "{said}");
            assert!(!said.contains(['{', '}', ':']), "{said}");
            assert!(!said.contains(char::is_uppercase), "{said}");
        }
        let coupled = MethodName::Coupled.params(&Settings::default(), &basis);
        assert_eq!(
            in_words(&coupled.unwrap()),
            "coupled (device_mass_kg 0.25, encoder_quantum_m 0.000001, placement true, correction true)"
        );
    }
}
