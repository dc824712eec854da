//! Cylinders on cylinders.

use palpate_testbed::world::{ContactLaw, Member, Shape, WorldBody};

use super::{body, pair, solve};
use crate::world_ideal::cylinders::{
    HALF_LENGTH, LYING, MASS, RADIUS, STIFFNESS, WEIGHT, apart, cylinder, floor, heavy,
    keeps_its_sums, on, thrown,
};

/// One that does not move, with its end or its side up to the height 0.
fn below(radius: f64, half_length: f64, orientation: [f64; 4]) -> WorldBody {
    let shape = Shape::Cylinder {
        radius,
        half_length,
    };
    let reach = if orientation == LYING {
        radius
    } else {
        half_length
    };
    let mut one = body(shape, 1.0, [0.0, 0.0, -reach]);
    one.orientation = orientation;
    one.motion = None;
    one
}

/// One cylinder rests on another one's end, or lies along another one, which is shorter, equal or longer.
#[test]
fn two_cylinders_have_all_of_the_stiffness_on_their_ends_and_half_of_it_along_their_sides() {
    let standing = [1.0, 0.0, 0.0, 0.0];
    for (orientation, reach, stiffness) in [
        (standing, HALF_LENGTH, STIFFNESS),
        (LYING, RADIUS, 0.5 * STIFFNESS),
    ] {
        for (radius, half_length) in [
            (0.025, 0.5 * HALF_LENGTH),
            (RADIUS, HALF_LENGTH),
            (0.03, 2.0 * HALF_LENGTH),
        ] {
            for first in [0, 1] {
                let (rest, swing) = (reach - WEIGHT / stiffness, 0.9 * WEIGHT / stiffness);
                let mut one = heavy(rest + swing);
                one.orientation = orientation;
                let under = below(radius, half_length, orientation);
                let mut scene = on(under, one, ContactLaw::spring(STIFFNESS));
                let law = scene.pairs[0].law;
                scene.pairs = vec![pair(Member::Body(first), Member::Body(1 - first), law)];
                let ideal = solve(&scene, 0.001, 100);
                let rate = (stiffness / MASS).sqrt();
                let apart = apart(
                    &ideal,
                    |body| body.position[2],
                    |t| rest + swing * (rate * t).cos(),
                );
                println!("swings on {stiffness} N/m of a cylinder to {apart:.1e} m");
                assert!(apart < 1e-11, "{apart}");
            }
        }
    }
}

#[test]
fn a_large_cylinder_bears_one_as_a_half_space_does() {
    let law = ContactLaw::spring(5000.0).damped(4.0).rough(0.4, 5000.0);
    let mut hits = 0;
    for case in 0..2 {
        let [on_cylinder, on_floor] = [below(0.5, 0.4, [1.0, 0.0, 0.0, 0.0]), floor()]
            .map(|under| solve(&on(under, thrown(case), law), 0.002, 150));
        let mut apart = 0.0_f64;
        for (one, other) in on_cylinder.states.iter().zip(&on_floor.states) {
            for axis in 0..3 {
                let [one, other] = [one, other].map(|state| state.bodies[0].position[axis]);
                apart = apart.max((one - other).abs());
            }
        }
        hits += on_cylinder.encounters.len();
        println!(
            "a cylinder on a large one and on a half-space: {apart:.1e} m apart, {hits} contacts"
        );
        assert!(apart < 1e-9, "{apart}");
    }
    assert!(hits > 6, "{hits}");
}

/// Two that fly into each other and tumble, the first of the two the shorter one or not.
#[test]
fn two_cylinders_keep_energy_momentum_and_angular_momentum() {
    let of = |radius, half_length| Shape::Cylinder {
        radius,
        half_length,
    };
    for (name, other) in [
        ("cylinder of its size", cylinder()),
        ("disc", of(0.03, 0.005)),
        ("rod", of(0.006, 0.04)),
    ] {
        keeps_its_sums(name, &other);
    }
}

/// The cylinder rests on a point of its rim that is below its centre. The shorter cylinder has one of the four points
/// that share the law; the longer one has the whole law at one point.
#[test]
fn the_shorter_of_two_cylinders_has_the_points_that_share_the_law() {
    let reach = HALF_LENGTH.hypot(RADIUS);
    let (sine, cosine) = (0.5 * RADIUS.atan2(HALF_LENGTH)).sin_cos();
    for (half_length, stiffness) in [
        (2.0 * HALF_LENGTH, 0.25 * STIFFNESS),
        (0.5 * HALF_LENGTH, STIFFNESS),
    ] {
        let (rest, swing) = (reach - WEIGHT / stiffness, 0.9 * WEIGHT / stiffness);
        let mut one = heavy(rest + swing);
        one.orientation = [cosine, 0.0, sine, 0.0];
        let under = below(0.025, half_length, [1.0, 0.0, 0.0, 0.0]);
        let ideal = solve(&on(under, one, ContactLaw::spring(STIFFNESS)), 0.001, 100);
        let rate = (stiffness / MASS).sqrt();
        let apart = apart(
            &ideal,
            |body| body.position[2],
            |t| rest + swing * (rate * t).cos(),
        );
        println!("swings on {stiffness} N/m at its rim to {apart:.1e} m");
        assert!(apart < 1e-11, "{apart}");
    }
}
