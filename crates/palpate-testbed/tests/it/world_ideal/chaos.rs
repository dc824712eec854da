//! Scenes that the ideal can and cannot predict.

use palpate_testbed::grid::Grid;
use palpate_testbed::world::{
    CheckedIdeal, ContactLaw, LARGEST_ERROR, Member, Shape, Tool, WorldScene,
};

use super::{body, device, motion, pair};

/// A tool in a hand among three heavy balls in a ring: every bounce off a ball makes the next one less certain.
fn billiard(damping: f64) -> WorldScene {
    let law = ContactLaw::spring(4000.0).damped(damping);
    let balls: Vec<_> = (0..3)
        .map(|number| {
            let angle = std::f64::consts::TAU * f64::from(number) / 3.0;
            let place = [0.04 * angle.cos(), 0.04 * angle.sin(), 0.0];
            let mut ball = body(Shape::Sphere { radius: 0.03 }, 1e3, place);
            motion(&mut ball).inertia = [1.0; 3];
            ball
        })
        .collect();
    let mut tool = device(0.05, [0.001, 0.002, 0.0]);
    tool.velocity = [1.0, 0.3, 0.0];
    tool.tool = Tool::sphere(0.003);
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        pairs: (0..3)
            .map(|ball| pair(Member::Device(0), Member::Body(ball), law))
            .collect(),
        devices: vec![tool],
        bodies: balls,
    }
}

#[test]
fn a_chaotic_scene_is_shortened_to_what_can_be_predicted() {
    let grid = Grid::even(0.0, 0.001, 1500);
    let checked = CheckedIdeal::new(&billiard(0.0), grid.clone()).unwrap();
    let from = checked.chaotic_from.unwrap();
    println!(
        "chaotic from {from} s, after {} contacts; E {:.4} % up to there",
        checked.ideal.encounters.len(),
        checked.error
    );
    assert!(checked.error < LARGEST_ERROR);
    assert!(from > 0.05 && from < 1.5);
    assert_eq!(checked.ideal.grid.end(), from);
    assert_eq!(
        checked.ideal.devices[0].impulses.len(),
        checked.ideal.grid.intervals()
    );
    assert_eq!(
        checked.ideal.states.len(),
        checked.ideal.grid.intervals() + 1
    );

    // Damping takes the speed that carries the difference on.
    let checked = CheckedIdeal::new(&billiard(5.0), grid).unwrap();
    println!("damped: E {:.1e} %", checked.error);
    assert_eq!(checked.chaotic_from, None);
    assert!(checked.error < LARGEST_ERROR);
}
