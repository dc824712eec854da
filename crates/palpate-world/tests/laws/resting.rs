//! Objects that are pressed for a long time, or lie on a tool, stay at rest.

use palpate_world::CoupledParams;

use crate::held::{PRESSED, TRAY, pressed, resting};

#[test]
fn pressed_into_a_groove_for_a_minute_the_offset_does_not_drift() {
    // Largest offset [m] and error of the mean force: at 10 ms the device swings by millimetres in its hand.
    for (period, stiffness, friction, largest, off) in [
        (0.001, 2e4, 0.0, 5e-5, 0.001),
        (0.001, 2e4, 0.4, 5e-5, 0.001),
        (0.01, 1000.0, 0.0, 2e-3, 0.002),
    ] {
        let model = CoupledParams::new(vec![PRESSED.map(|mass| 1.5 * mass)]);
        let model = model.with_encoder_quantum(2e-6);
        let pressed = pressed(model, period, stiffness, friction, 60.0).unwrap();
        let ([early, late], mean) = (pressed.offset, pressed.mean);
        println!(
            "{period} s, {stiffness} N/m, friction {friction}: offset {:.1} um in the second, {:.1} um in the last of \
             60 s; mean force off by {:.4} %",
            early * 1e6,
            late * 1e6,
            mean * 100.0
        );
        assert!(late < 1.5 * early + 2e-5, "{early} {late}");
        assert!(late < largest, "{late}");
        assert!(mean.abs() < off, "{mean}");
    }
}

#[test]
fn a_light_box_on_a_tool_at_rest_presses_with_a_steady_force() {
    for kc in [8.0, 15.0, 30.0] {
        // A quantum of 2 um is K q = 1.6 to 6 % of the weight. At Kc 8 the box oscillates at half the sample rate. An
        // observer that attributes each sensor step to the hand excites this oscillation by 13 %.
        for (quantum, model, most) in [
            (0.0, 1.0, 0.001),
            (0.0, 1.5, 0.001),
            (0.0, 0.67, 0.001),
            (2e-7, 1.5, 0.001),
            (2e-6, 1.0, 0.02),
            (2e-6, 1.5, 0.02),
            (2e-6, 0.67, 0.02),
        ] {
            let params = CoupledParams::new(vec![[model * TRAY; 3]]).with_encoder_quantum(quantum);
            let resting = resting(params, kc, quantum).unwrap();
            assert!((resting.mean - 1.0).abs() < 0.01, "{}", resting.mean);
            let ripple = resting.ripple;
            println!(
                "Kc {kc}, quantum {:.1} um, told {model} times the mass: ripple {:.3} % of the weight",
                1e6 * quantum,
                100.0 * ripple
            );
            assert!(ripple < most, "{ripple}");
        }
    }
}
