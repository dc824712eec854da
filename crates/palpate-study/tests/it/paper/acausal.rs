//! Eq. (7): the force whose balance of energy has the device's real motion.

use palpate_scene::method::MethodName;
use palpate_study::sim::acausal::AcausalParams;
use palpate_study::sim::closed_loop::Bench;

use crate::common::{PAPER_SCENES, scene};

/// Source: Eq. (7). The force leaks nothing, and HFCR, which predicts the device, leaks. Its error is what remains for
/// a method without leak.
#[test]
fn the_force_of_the_real_motion_leaks_nothing() {
    for (name, expected) in PAPER_SCENES.into_iter().zip([12.8, 23.4, 62.4]) {
        let scene = scene(name);
        let bench = Bench::new(&scene).unwrap();
        let acausal = bench
            .run_own(AcausalParams {
                device_mass: scene.device.mass(),
                user_force: scene.device.hand_force(),
            })
            .unwrap();
        let hfcr = bench.run(MethodName::HfcrModSt).unwrap();
        let [of, predicted] = [&acausal, &hfcr].map(|run| {
            let error = run.force.fidelity.unwrap().force_rendering_error;
            (error, 1e3 * run.last().ledger.held_leak.absolute)
        });
        eprintln!(
            "{name}: FRE {:.1} %, leak {:.3e} mJ; predicted {:.1} %, {:.2} mJ",
            of.0, of.1, predicted.0, predicted.1
        );
        assert!(of.1 < 1e-6 && predicted.1 > 1.0, "{name}");
        assert!((of.0 - expected).abs() < 0.1, "{name}: {}", of.0);
    }
}
