//! Detection of a tool that leaves a solid through its far side.

use std::sync::Arc;

use palpate_world::{
    BasicParams, Body, ContactLaw, Hull, Motion, Sample, Shape, Side, Vector, WorldLoop,
    WorldRenderer,
};

use crate::common::world;

/// Returns the samples at which the tool, on the prescribed `path`, has reached the far side of a fixed solid.
fn gone_through(shape: &Shape, radius: f64, path: impl Iterator<Item = Vector>) -> Vec<usize> {
    let solid = Body::new("solid", shape.clone(), Motion::Fixed);
    let world = world(radius, vec![solid], ContactLaw::spring(1000.0));
    let renderer =
        WorldRenderer::new(&world, WorldLoop::new(0.001), BasicParams::default()).unwrap();
    let mut state = renderer.start();
    let mut found = Vec::new();
    for (number, place) in path.enumerate() {
        assert_eq!(renderer.step(&mut state, &Sample::at(&[place])).fault, None);
        for pair in state.gone_through() {
            assert_eq!(pair, [Side::Tool(0), Side::Body(0)]);
            found.push(number);
        }
    }
    found
}

#[test]
fn a_tool_that_is_pushed_on_past_the_middle_has_gone_through() {
    let shapes = [
        Shape::Box {
            half_extents: [0.01; 3],
        },
        Shape::Sphere { radius: 0.01 },
        Shape::Capsule {
            radius: 0.01,
            half_length: 0.02,
        },
        Shape::Cylinder {
            radius: 0.01,
            half_length: 0.02,
        },
    ];
    // From 3 cm before the solid to 3 cm behind it, 1 mm beside its centre, in steps of 0.1 mm.
    let across = || (0..600).map(|k| [1e-4 * f64::from(k) - 0.03, 0.001, 0.0]);
    // To 0.5 mm before the centre and back.
    let back = || (0..600_i32).map(|k| [-5e-4 - 1e-4 * f64::from((k - 300).abs()), 0.0, 0.0]);
    for shape in &shapes {
        for radius in [0.0, 0.004] {
            let found = gone_through(shape, radius, across());
            assert_eq!(found.len(), 1, "{shape:?}");
            assert!((295..=315).contains(&found[0]), "{shape:?}: {found:?}");
            assert_eq!(gone_through(shape, radius, back()), [], "{shape:?}");
        }
        // Around the solid along its surface, the tool touches all of its sides.
        let around = (0..3000).map(|k| {
            let (sin, cos) = (2.1e-3 * f64::from(k)).sin_cos();
            [0.0135 * cos, 0.0135 * sin, 0.0]
        });
        assert_eq!(gone_through(shape, 0.004, around), [], "{shape:?}");
    }
    // A hull tracks its surface: the force still points to the side of entry.
    let corners =
        (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 0.01 } else { -0.01 }));
    let corners: Vec<Vector> = corners.collect();
    let hull = Shape::Hull(Arc::new(Hull::around(&corners).unwrap()));
    assert_eq!(gone_through(&hull, 0.004, across()), []);
}
