//! Side of a surface on which a tool is.
#![allow(clippy::print_stdout)] // prints the measured values

use palpate_world::{ContactLaw, Mode, Sample};

use super::common::{Hand, block, coupled, fixed, run, world};

/// A wall of 0.5 mm pushes the tool back to the side of entry, even if the tool is nearer to the other side or beyond
/// it.
#[test]
fn a_tool_does_not_pop_through_a_thin_wall() {
    let wall = fixed("wall", block([0.00025, 0.02, 0.02], 12));
    for radius in [0.0, 0.0005, 0.003] {
        let renderer = coupled(&world(
            radius,
            vec![wall.clone()],
            ContactLaw::spring(1000.0),
        ));
        // Pressed in by about 2 mm and moved along the wall.
        let hand = Hand::at([0.01, 0.0, 0.0], |time: f64| {
            [-0.008, 0.01 * (5.0 * time).sin(), 0.01 * (3.0 * time).sin()]
        });
        let mut deepest = 0.0_f64;
        let mut touched = false;
        run(&renderer, hand, 2000, |_, hand, output| {
            let force = output.forces[0][0];
            touched |= force > 1.0;
            assert!(force >= 0.0, "{radius}: {force} N at {:?}", hand.position);
            deepest = deepest.max(0.00025 + radius - hand.position[0]);
            assert!(hand.position[0] > -0.0055, "{radius}: {:?}", hand.position);
        });
        println!("radius {radius}: {:.2} mm deep", 1e3 * deepest);
        assert!(touched && deepest > 0.0015);
    }
}

/// A tool that starts inside a solid is not pushed until it has come out; then the surface is active.
#[test]
fn a_tool_that_begins_inside_is_let_out() {
    let renderer = coupled(&world(
        0.002,
        vec![fixed("block", block([0.02; 3], 8))],
        ContactLaw::spring(1000.0),
    ));
    let mut state = renderer.start();
    let mut height = 0.005;
    while height < 0.03 {
        let output = renderer.step(&mut state, &Sample::at(&[[0.001, 0.0, height]]));
        let is_inside = height < 0.02;
        assert!(
            !is_inside || output.forces[0] == [0.0; 3],
            "{height}: {:?}",
            output.forces
        );
        height += 1e-4;
    }
    while height > 0.0215 {
        height -= 1e-4;
        let _ = renderer.step(&mut state, &Sample::at(&[[0.001, 0.0, height]]));
    }
    assert!(
        state
            .contacts()
            .iter()
            .any(|contact| contact.mode != Mode::Free)
    );
}
