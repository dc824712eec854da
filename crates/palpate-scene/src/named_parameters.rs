//! Parameters of a method under the names that scene files use.

use palpate_core::{AnyParams, MethodParams as _, ParameterValue};

/// Parameters by name, with the unit in the name; empty for a method without any.
#[must_use]
pub fn named_parameters(params: &AnyParams<f64>) -> Vec<(&'static str, ParameterValue<f64>)> {
    let mut named = Vec::new();
    params.describe(&mut |key, value| named.push((key, value)));
    named
}

#[cfg(test)]
mod tests {
    use crate::method::{Basis, MethodName, Settings};

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
            let params = method.params::<f64>(&Settings::default(), &basis).unwrap();
            let said = params.to_string();
            let expected = match method {
                MethodName::HfcrModSt => MethodName::Hfcr,
                other => other,
            };
            assert!(said.starts_with(expected.name()), "{said}");
            assert!(!said.contains(['{', '}', ':']), "{said}");
            assert!(!said.contains(char::is_uppercase), "{said}");
        }
        let coupled = MethodName::Coupled.params::<f64>(&Settings::default(), &basis);
        assert_eq!(
            coupled.unwrap().to_string(),
            "coupled (device_mass_kg 0.25, encoder_quantum_m 0.000001, placement true, correction true)"
        );
    }
}
