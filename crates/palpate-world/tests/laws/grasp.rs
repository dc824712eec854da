//! Two devices and friction: two fingers hold a cube in the air.

use palpate_world::{BasicParams, CoupledParams, WorldMethod};

use crate::held::{FINGER, drift, heights};

/// Returns the distance by which the cube sinks in 2 s with sensors of 2 um `[m]`.
fn sinks(method: impl Into<WorldMethod>, friction: f64, period: f64) -> f64 {
    let heights = heights(method, friction, period, 2e-6, 2.0).unwrap();
    -heights.last().unwrap()
}

#[test]
fn a_cube_that_is_pinched_for_ten_seconds_does_not_drift() {
    for (period, quantum, model) in [
        (0.001, 2e-6, 1.5),
        (0.001, 2e-6, 0.67),
        (0.001, 1e-5, 0.67),
        (0.004, 2e-6, 1.5),
    ] {
        let mass = FINGER.map(|mass| model * mass);
        let params = CoupledParams::new(vec![mass; 2]).with_encoder_quantum(quantum);
        let drift = drift(params, period, quantum).unwrap();
        println!(
            "{period} s, quantum {:.0} um, told {model} times the masses: drift {:.2} um from the second to the tenth \
             second",
            1e6 * quantum,
            1e6 * drift
        );
        assert!(drift.abs() < 5e-6, "{drift}");
    }
}

#[test]
fn two_fingers_hold_a_cube_by_friction_and_drop_it_without() {
    for period in [0.001, 0.004] {
        let model = CoupledParams::new(vec![[0.15, 0.24, 0.195]; 2]).with_encoder_quantum(2e-6);
        let coupled = sinks(model.clone(), 0.8, period);
        let slippery = sinks(model, 0.05, period);
        let basic = sinks(BasicParams::default(), 0.8, period);
        println!(
            "{period} s: the cube sinks by {:.3} mm, with a friction of 0.05 by {slippery:.1} m; by the sampled spring {:.3} mm",
            coupled * 1e3,
            basic * 1e3
        );
        // The hands yield to the weight: 0.49 N over 600 N/m is 0.8 mm.
        assert!(coupled.abs() < 0.0002, "{coupled}");
        assert!(slippery > 1.0, "{slippery}");
    }
}
