//! A mesh of a shape pushes like the shape.
#![allow(clippy::print_stdout)] // prints the measured values

use palpate_world::{Body, ContactLaw, Sample, Vector, WorldLoop, WorldRenderer};

use super::common::{Hand, block, both, compare, fixed, patch, plane, world};

fn law() -> ContactLaw {
    ContactLaw::spring(4000.0)
        .with_damping(3.0)
        .with_friction(0.4)
}

/// Returns a hand that presses and moves over hundreds of triangles, along their edges and over their corners.
fn slides_over() -> Hand {
    Hand::at([0.0, 0.0, 0.012], |time| {
        let (x, y) = (0.03 * (3.0 * time).sin(), 0.03 * (2.0 * time).sin());
        // For a while exactly along an edge of the triangles.
        [x, if time < 0.5 { 0.0 } else { y }, -0.003]
    })
}

/// Edges between coplanar triangles are not felt.
#[test]
fn a_floor_of_triangles_is_a_half_space() {
    // Rounding decides in which sub-step sticking becomes sliding.
    for (friction, slack) in [(0.0, 1e-9), (0.4, 1e-5)] {
        for radius in [0.0, 0.005, 0.01] {
            let law = law().with_friction(friction);
            let floor = fixed("floor", patch(0.05, 40, |x, y| [x, y, 0.0]));
            let triangles = world(radius, vec![floor], law);
            let smooth = world(radius, vec![plane("floor", [0.0, 0.0, 1.0], 0.0)], law);
            let (largest, apart) = compare(&smooth, &triangles, slides_over, 2000);
            println!("radius {radius}, friction {friction}: {apart:.1e} of {largest:.2} N apart");
            assert!(
                largest > 1.0 && apart < slack * largest,
                "{radius}: {apart} {largest}"
            );
        }
    }
}

/// Returns the walls of a groove along y with an opening angle and its bottom at the origin: as half-spaces, and as
/// triangles.
fn groove(degrees: f64) -> (Vec<Body>, Body) {
    let (sine, cosine) = (0.5 * degrees.to_radians()).sin_cos();
    let wall = |side: f64| {
        patch(0.05, 25, move |along, y| {
            let up = along + 0.05;
            // Counter-clockwise seen from inside the groove.
            let y = if side > 0.0 { y } else { -y };
            [side * up * sine, y, up * cosine]
        })
    };
    let half_spaces = [("right", 1.0), ("left", -1.0)]
        .map(|(name, side)| plane(name, [-side * cosine, 0.0, sine], 0.0));
    (
        half_spaces.into(),
        fixed("groove", both(&wall(1.0), &wall(-1.0))),
    )
}

/// A sphere pressed into a groove is pushed by both walls, each with the whole law.
#[test]
fn a_groove_of_triangles_is_two_half_spaces() {
    for degrees in [60.0, 90.0, 120.0] {
        let (half_spaces, triangles) = groove(degrees);
        let hand = || {
            Hand::at([0.001, 0.0, 0.02], |time: f64| {
                [
                    0.004 * (5.0 * time).sin(),
                    0.02 * (2.0 * time).sin(),
                    -0.004,
                ]
            })
        };
        let smooth = world(0.004, half_spaces, law());
        let triangles = world(0.004, vec![triangles], law());
        let (largest, apart) = compare(&smooth, &triangles, hand, 1500);
        println!("{degrees} degrees: {apart:.1e} of {largest:.2} N apart");
        assert!(
            largest > 1.0 && apart < 1e-9 * largest,
            "{degrees}: {apart} {largest}"
        );
    }
}

/// A point is behind the surface at any contact, and there is one shortest way out. At 90 degrees it equals the sum
/// of the springs of two half-spaces.
#[test]
fn a_point_in_a_right_angle_is_pushed_as_by_two_half_spaces() {
    let (half_spaces, triangles) = groove(90.0);
    let law = ContactLaw::spring(4000.0);
    let [smooth, triangles] = [half_spaces, vec![triangles]].map(|bodies| {
        let basic = palpate_world::BasicParams::default();
        WorldRenderer::new(&world(0.0, bodies, law), WorldLoop::new(0.001), basic).unwrap()
    });
    let (mut one, mut other) = (smooth.start(), triangles.start());
    let mut largest = 0.0_f64;
    for tick in 0..4000 {
        let time = f64::from(tick) * 1e-3;
        let place = [
            0.002 * (7.0 * time).sin(),
            0.02 * (3.0 * time).sin(),
            0.002 * (2.0 * time).cos(),
        ];
        let sample = [place];
        let sample = Sample::at(&sample);
        let expected = smooth.step(&mut one, &sample).forces[0];
        let given = triangles.step(&mut other, &sample).forces[0];
        for axis in 0..3 {
            largest = largest.max(expected[axis].abs());
            assert!(
                (expected[axis] - given[axis]).abs() < 1e-9,
                "{place:?} {expected:?} {given:?}"
            );
        }
    }
    assert!(largest > 5.0, "{largest}");
}

/// Over faces, convex edges and convex corners.
#[test]
fn a_block_of_triangles_is_a_box() {
    let half: Vector = [0.02, 0.015, 0.01];
    let triangles = fixed("block", block(half, 6));
    let smooth = Body::new(
        "block",
        palpate_world::Shape::Box { half_extents: half },
        palpate_world::Motion::Fixed,
    );
    let turned = [0.8, 0.0, 0.6, 0.0];
    let hand = || {
        Hand::at([0.0, 0.0, 0.05], |time: f64| {
            [0.03 * (4.0 * time).sin(), 0.025 * (2.7 * time).sin(), 0.0]
        })
    };
    for radius in [0.002, 0.006] {
        let of = |body: &palpate_world::Body| {
            world(
                radius,
                vec![body.clone().turned(turned).at([0.001, 0.0, 0.01])],
                law(),
            )
        };
        let (largest, apart) = compare(&of(&smooth), &of(&triangles), hand, 3000);
        println!("radius {radius}: {apart:.1e} of {largest:.2} N apart");
        assert!(
            largest > 1.0 && apart < 1e-7 * largest,
            "{radius}: {apart} {largest}"
        );
    }
}
