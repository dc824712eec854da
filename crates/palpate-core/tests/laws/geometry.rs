//! Contacts in the plane and in space, and the two numbers of difficulty.

use palpate_core::{
    AlongAxis, Contact, Difficulty, HfcrParams, LoopParams, ObjectState, Parameter, Renderer,
    Sample, Scalar,
};
use proptest::prelude::*;

fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(&b).map(|(x, y)| x * y).sum()
}

fn unit<const N: usize>(direction: [f64; N]) -> [f64; N] {
    let length = dot(direction, direction).sqrt();
    direction.map(|x| x / length)
}

proptest! {
    #[test]
    fn a_placed_force_does_the_work_of_the_contact_along_its_axis(
        origin in prop::array::uniform3(-1.0..1.0_f64),
        direction in prop::array::uniform3(-1.0..1.0_f64),
        from in prop::array::uniform3(-1.0..1.0_f64),
        to in prop::array::uniform3(-1.0..1.0_f64),
        force in -10.0..10.0_f64,
    ) {
        prop_assume!(dot(direction, direction) > 1e-2);
        let axis = AlongAxis::new(origin, unit(direction)).unwrap();
        let moved = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
        let along = axis.coordinate(to) - axis.coordinate(from);
        prop_assert!((dot(axis.vector(force), moved) - force * along).abs() < 1e-13);
        prop_assert!(axis.coordinate(origin).abs() < 1e-15);
    }

    #[test]
    fn a_plane_contact_feels_only_the_motion_along_its_normal(
        origin in prop::array::uniform2(-1.0..1.0_f64),
        angle in 0.0..6.3_f64,
        slide in -1.0..1.0_f64,
        depth in -0.01..0.01_f64,
    ) {
        let normal = [angle.cos(), angle.sin()];
        let axis = AlongAxis::new(origin, normal).unwrap();
        let point = [
            origin[0] + depth * normal[0] - slide * normal[1],
            origin[1] + depth * normal[1] + slide * normal[0],
        ];
        prop_assert!((axis.coordinate(point) - depth).abs() < 1e-15);
        let wall = Contact::wall(400.0);
        let l = LoopParams::new(0.001);
        let renderer = Renderer::new(wall, l, HfcrParams::default()).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let output = renderer.step(&mut state, Sample::at(axis.coordinate(point)));
        let force = axis.vector(output.force_on_device);
        let expected = -400.0 * depth.max(0.0);
        prop_assert!((dot(force, normal) - expected).abs() < 1e-12);
        prop_assert!(dot(force, [-normal[1], normal[0]]).abs() < 1e-15);
    }

    #[test]
    fn difficulty_and_the_scene_it_describes_give_each_other_back(
        kappa in (-4.0..1.0_f64).prop_map(|e| 10f64.powf(e)),
        object_kappa in (-4.0..1.0_f64).prop_map(|e| 10f64.powf(e)),
        device_mass in 0.01..2.0_f64,
        period in 1e-4..0.05_f64,
    ) {
        let pair = Difficulty { kappa, object_kappa };
        let stiffness = pair.stiffness(device_mass, period).unwrap();
        let object_mass = pair.object_mass(device_mass).unwrap();
        let again = Difficulty::new(stiffness, device_mass, object_mass, period).unwrap();
        prop_assert!((again.kappa / kappa - 1.0).abs() < 1e-14);
        prop_assert!((again.object_kappa / object_kappa - 1.0).abs() < 1e-14);
    }
}

#[test]
fn a_wall_has_no_object_kappa_and_a_clamped_device_no_kappa() {
    let wall = Difficulty::new(400.0, 0.25, f64::INFINITY, 0.02).unwrap();
    assert_eq!(wall.object_kappa, 0.0);
    assert_eq!(wall.object_mass(0.25).unwrap(), f64::INFINITY);
    let clamped = Difficulty::new(400.0, f64::INFINITY, 0.1, 0.02).unwrap();
    assert_eq!(clamped.kappa, 0.0);
}

fn a_rough_normal_is_scaled_to_length_one<S: Scalar>(tolerance: f64) {
    let of = S::from_f64;
    let rough = [of(0.707), of(0.707), S::ZERO];
    let axis = AlongAxis::new([S::ZERO; 3], rough).unwrap();
    let length = axis
        .vector(S::ONE)
        .iter()
        .map(|x| x.to_f64().powi(2))
        .sum::<f64>()
        .sqrt();
    assert!((length - 1.0).abs() < tolerance, "{length}");
}

#[test]
fn a_normal_with_few_digits_is_made_exact() {
    a_rough_normal_is_scaled_to_length_one::<f64>(1e-15);
    a_rough_normal_is_scaled_to_length_one::<f32>(1e-6);
}

#[test]
fn a_normal_of_another_length_or_a_place_that_is_nowhere_is_refused() {
    let at_origin = |normal| AlongAxis::<f64, 2>::new([0.0; 2], normal);
    for (normal, length) in [([0.0, 0.0], 0.0), ([0.0, 2.0], 2.0), ([0.0, 0.998], 0.998)] {
        let error = at_origin(normal).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("length of normal is {length}, but must be 1")
        );
    }
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(
            at_origin([bad, 0.0]).unwrap_err().parameter,
            Parameter::AxisNormal
        );
        let nowhere = AlongAxis::new([0.0, bad], [0.0, 1.0]);
        assert_eq!(nowhere.unwrap_err().parameter, Parameter::AxisOrigin);
    }
}
