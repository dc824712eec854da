//! Parameters of a method under the names that scene files use.

use palpate::{AnyParams, MethodParams as _, ParameterValue};

use crate::method::MethodName;

/// Parameters by name, with the unit in the name; empty for a method without any.
#[must_use]
pub fn named_parameters(params: &AnyParams<f64>) -> Vec<(&'static str, ParameterValue<f64>)> {
    let mut named = Vec::new();
    params.describe(&mut |key, value| named.push((key, value)));
    named
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
            let said = params.to_string();
            let expected = match method {
                MethodName::HfcrModSt => MethodName::Hfcr,
                other => other,
            };
            assert_eq!(method_of(&params), expected);
            assert!(said.starts_with(expected.name()), "{said}");
            assert!(!said.contains(['{', '}', ':']), "{said}");
            assert!(!said.contains(char::is_uppercase), "{said}");
        }
        let coupled = MethodName::Coupled.params(&Settings::default(), &basis);
        assert_eq!(
            coupled.unwrap().to_string(),
            "coupled (device_mass_kg 0.25, encoder_quantum_m 0.000001, placement true, correction true)"
        );
    }
}
