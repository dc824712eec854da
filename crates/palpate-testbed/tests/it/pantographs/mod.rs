//! Pantographs to test with: one of our own, and those of `devices/`.
//!
//! The device files are read key by key, without the reader that the simulator has for them: this
//! crate depends on none of ours.

use std::path::Path;

use palpate_testbed::pantograph::kinematics::{Assembly, Origin};
use palpate_testbed::pantograph::{Actuation, Geometry, Link, PantographParams};
use toml::{Table, Value};

/// A desktop pantograph of about 0.25 kg along y at home, symmetric about x = 0, with little
/// friction.
pub fn desktop() -> PantographParams {
    let (proximal, distal) = (0.12, 0.16);
    PantographParams {
        geometry: Geometry {
            proximal,
            distal,
            base: 0.05,
            assembly: Assembly::Far,
            origin: Origin::Centre,
        },
        home: [130.0_f64, 50.0].map(f64::to_radians),
        proximal: [Link::rod(0.060, proximal); 2],
        distal: [Link::rod(0.050, distal); 2],
        rotor_inertia: 3e-5,
        end_point_mass: 0.1525,
        viscous_friction: 5e-4,
        coulomb_friction: 1e-3,
        max_torque: 1.0,
        counts_per_rev: Some(20_000.0),
        actuation: Actuation::MotorsAtMeasuredPose,
        gravity: [0.0, 0.0],
    }
}

/// The Haply 2DIY of a generation from 1 to 3.
pub fn haply(generation: u8) -> PantographParams {
    committed(&format!("haply-2diy-gen{generation}"))
}

/// A device of `devices/` whose links are uniform rods.
pub fn committed(name: &str) -> PantographParams {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../devices")
        .join(name)
        .with_extension("toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let file: Table = text.parse().unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let number = |section: &str, key: &str| as_number(&file[section][key]);
    let (proximal, distal) = (
        number("geometry", "proximal_m"),
        number("geometry", "distal_m"),
    );
    let angles = file["home"]["angles_deg"].as_array().unwrap();
    PantographParams {
        geometry: Geometry {
            proximal,
            distal,
            base: number("geometry", "base_m"),
            assembly: Assembly::Far,
            origin: match file["geometry"]["origin"].as_str() {
                Some("centre") => Origin::Centre,
                _ => Origin::Motor1,
            },
        },
        home: [0, 1].map(|motor| as_number(&angles[motor]).to_radians()),
        proximal: [Link::rod(number("proximal", "mass_kg"), proximal); 2],
        distal: [Link::rod(number("distal", "mass_kg"), distal); 2],
        rotor_inertia: number("motors", "rotor_inertia_kg_m2"),
        end_point_mass: number("end_point", "mass_kg"),
        viscous_friction: number("friction", "viscous_n_m_s_per_rad"),
        coulomb_friction: number("friction", "coulomb_n_m"),
        max_torque: number("motors", "torque_limit_n_m"),
        counts_per_rev: Some(number("motors", "counts_per_rev")),
        actuation: Actuation::MotorsAtMeasuredPose,
        gravity: [0.0, 0.0],
    }
}

fn as_number(value: &Value) -> f64 {
    match value {
        Value::Integer(whole) => *whole as f64,
        other => other.as_float().unwrap(),
    }
}
