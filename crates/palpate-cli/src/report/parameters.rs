//! Parameters of a method under the names that scene files use.

use palpate::{AnyParams, LeakDissipation, Mass, Prediction};
use serde_json::{Map, Value, json};

/// Parameters by name, with the unit in the name; empty for a method without any.
pub fn of(params: &AnyParams<f64>) -> Map<String, Value> {
    let named = match params {
        AnyParams::Basic => json!({}),
        AnyParams::VirtualDamper(damper) => json!({ "damping_n_s_per_m": damper.damping }),
        AnyParams::Seh(seh) => json!({ "estimate": seh.estimate }),
        AnyParams::Popc(popc) => json!({
            "damping_cap_n_s_per_m": popc.damping_cap,
            "speed_threshold_m_per_s": popc.speed_threshold,
            "initial_energy_j": popc.initial_energy,
        }),
        AnyParams::PopcRef(popc) => json!({
            "damping_cap_n_s_per_m": popc.damping_cap,
            "speed_threshold_m_per_s": popc.speed_threshold,
        }),
        AnyParams::Coupled(coupled) => json!({
            "device_mass_kg": match coupled.device_mass {
                Mass::Finite(mass) => json!(mass),
                Mass::Infinite => json!("inf"),
            },
            "encoder_quantum_m": coupled.encoder_quantum,
            "placement": coupled.placement,
            "correction": coupled.correction,
        }),
        AnyParams::Hfcr(hfcr) => json!({
            "modified_force": hfcr.modified_force,
            "smooth_transition": hfcr.smooth_transition,
            "damping_n_s_per_m": match hfcr.leak_dissipation {
                LeakDissipation::Off => Some(0.0),
                LeakDissipation::Damping(damping) => Some(damping),
                // Not from a run, where it has been derived.
                LeakDissipation::Auto { .. } => None,
            },
            "prediction": match hfcr.prediction {
                Prediction::ConstantVelocity => "constant-velocity",
                Prediction::Observer { .. } => "observer",
            },
        }),
    };
    match named {
        Value::Object(named) => named,
        _ => Map::new(),
    }
}
