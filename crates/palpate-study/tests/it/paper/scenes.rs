//! Readings of the paper's scenes that the force does not, or hardly, depend on: where the hand's force
//! acts, and the ball's radius.

use palpate_scene::method::MethodName;
use palpate_scene::{HandForceAt, Scene};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;

use crate::common::scene;

fn run(scene: &Scene, method: MethodName) -> Run {
    Bench::new(scene).unwrap().run(method).unwrap()
}

/// Source: the paper applies the hand's force by torques of the joints, too. On this linkage, whose
/// Jacobian hardly changes within a period, that is nearly a force at the end-point.
#[test]
fn a_hand_in_the_motors_is_nearly_one_at_the_end_point() {
    for (name, within) in [("fig4", 0.2), ("fig5", 5.0)] {
        let at_end_point = scene(name);
        let mut in_motors = at_end_point.clone();
        in_motors.device.pantograph_mut().unwrap().force_at = HandForceAt::Motors;
        assert_eq!(in_motors, {
            let mut read = scene(&format!("readings/{name}_motors"));
            read.title.clone_from(&in_motors.title);
            read
        });
        let benches = [&at_end_point, &in_motors].map(|scene| Bench::new(scene).unwrap());
        // The ideal has no motors: it is the same.
        let impulses = benches
            .each_ref()
            .map(|bench| bench.reference().profile.impulses());
        assert_eq!(impulses[0], impulses[1]);
        for method in [
            MethodName::Basic,
            MethodName::VirtualDamper,
            MethodName::PopcRef,
            MethodName::Hfcr,
            MethodName::Coupled,
        ] {
            let [a, b] = benches.each_ref().map(|bench| {
                let fidelity = bench.run(method).unwrap().force.fidelity.unwrap();
                fidelity.force_rendering_error
            });
            eprintln!("{name} {method}: FRE {a:.2} % at the end-point, {b:.2} % in the motors");
            assert!(
                (a - b).abs() < within && a != b,
                "{name} {method}: {a} and {b}"
            );
        }
    }
}

/// Source: the paper plots the ball's centre, y_V = η + r, with r = 0.01 m. No force depends on r.
#[test]
fn the_radius_moves_what_is_drawn_and_nothing_else() {
    let point = scene("experiment1");
    let mut ball = point.clone();
    ball.object_radius = 0.01;
    let (a, b) = (run(&point, MethodName::Hfcr), run(&ball, MethodName::Hfcr));
    assert_eq!(a.ticks, b.ticks);
    assert_eq!((a.centre_offset, b.centre_offset), (0.0, 0.01));
    // On the other side of the device the centre is on the other side of the surface.
    ball.contact.side = palpate_core::Side::Negative;
    assert_eq!(ball.centre_offset(), -0.01);
    ball.object_radius = -0.01;
    assert!(
        ball.check()
            .unwrap_err()
            .to_string()
            .contains("body.centre_m")
    );
}
