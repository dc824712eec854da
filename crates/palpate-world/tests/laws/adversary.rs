//! For any samples, a tick returns finite forces within their limit.

use palpate_core::Fault;
use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, HfcrParams, Motion, Party, Sample,
    Shape, Tool, Vector, VirtualCouplingParams, World, WorldLoop, WorldMethod, WorldRenderer,
};
use proptest::prelude::*;

use crate::common::{ball, plane, world};

const LIMIT: f64 = 5.0;

fn crowded() -> World {
    let law = ContactLaw::spring(5000.0)
        .with_damping(1.0)
        .with_friction(0.6);
    let block = Shape::Box {
        half_extents: [0.02, 0.01, 0.015],
    };
    let stick = Shape::Capsule {
        radius: 0.005,
        half_length: 0.02,
    };
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0]),
        ball("ball", 0.02, Free::of_mass(0.05)).at([0.0, 0.0, 0.02]),
        Body::new("block", block, Motion::Free(Free::of_mass(0.1))).at([0.05, 0.0, 0.015]),
        Body::new("stick", stick, Motion::Fixed).at([0.0, 0.05, 0.02]),
    ];
    let mut world = world(0.01, bodies, law);
    // A block and a stick have no mutual contact.
    let named = |name: &str| Party::Named(name.into());
    let pairs = [
        [named("tool"), Party::Any],
        [named("second"), Party::Any],
        [named("ball"), Party::Any],
        [named("block"), named("floor")],
    ];
    world.contacts = pairs.map(|between| Contact { between, law }).into();
    world
        .tools
        .push(Tool::new("second", Shape::Sphere { radius: 0.0 }));
    world
}

fn methods() -> [WorldMethod; 4] {
    let coupled = CoupledParams::new(vec![[0.1, 0.2, 0.3]; 2]).with_encoder_quantum(1e-5);
    [
        BasicParams {
            damping: vec![2.0; 2],
            ..BasicParams::default()
        }
        .into(),
        VirtualCouplingParams {
            stiffness: vec![3000.0; 2],
            damping: vec![1.0; 2],
            mass: vec![0.05; 2],
            ..VirtualCouplingParams::default()
        }
        .into(),
        HfcrParams {
            damping: vec![1.0; 2],
            ..HfcrParams::default()
        }
        .into(),
        coupled.into(),
    ]
}

fn a_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -0.05..0.05,
        2 => -1e3..1e3,
        1 => any::<f64>(),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(1e300),
    ]
}

fn positions() -> impl Strategy<Value = [Vector; 2]> {
    prop_oneof![
        6 => prop::array::uniform2(prop::array::uniform3(-0.05..0.05)),
        1 => prop::array::uniform2(prop::array::uniform3(a_number())),
    ]
}

fn elapsed() -> impl Strategy<Value = Option<f64>> {
    prop_oneof![
        6 => Just(None),
        3 => (0.0005..0.02).prop_map(Some),
        1 => a_number().prop_map(Some),
    ]
}

/// Renders `samples` by every method: no force above its limit or along an axis that a tool `lacks`, no motion that is
/// not a number.
fn is_bounded(
    samples: &[([Vector; 2], Option<f64>)],
    believes_all: bool,
    lacks: [usize; 2],
) -> Result<(), TestCaseError> {
    let mut crowded = crowded();
    for (tool, lacks) in crowded.tools.iter_mut().zip(lacks) {
        tool.axes = [0, 1, 2].map(|axis| axis != lacks);
    }
    for method in methods() {
        let mut loop_params = WorldLoop::new(0.001).with_force_limits(vec![LIMIT; 2]);
        if believes_all {
            loop_params.speed_limit = None;
        }
        let renderer = WorldRenderer::new(&crowded, loop_params, method).unwrap();
        let mut state = renderer.start();
        for (positions, elapsed) in samples {
            let sample = Sample {
                positions,
                orientations: &[],
                elapsed: *elapsed,
            };
            let output = renderer.step(&mut state, &sample);
            for (force, lacks) in output.forces.iter().zip(lacks) {
                prop_assert!(force.get(lacks).is_none_or(|force| *force == 0.0));
                let norm = force.iter().map(|f| f * f).sum::<f64>().sqrt();
                prop_assert!(norm <= LIMIT * (1.0 + 1e-12), "{norm}");
                if output.fault.is_some() {
                    prop_assert_eq!(*force, [0.0; 3]);
                }
            }
            for body in state.bodies() {
                let all = [body.position, body.velocity, body.angular_velocity];
                prop_assert!(all.iter().flatten().all(|x| x.is_finite()), "{body:?}");
            }
        }
    }
    Ok(())
}

/// The velocity of a step within almost no time overflows, and with it the bounds of forces.
#[test]
fn a_sample_after_almost_no_time_is_bounded() {
    let samples = [
        ([[0.0; 3], [0.0, 0.0, -0.0312]], None),
        ([[0.0; 3], [0.0, 0.0, 0.0091]], Some(5.6e-291)),
    ];
    for believes_all in [false, true] {
        is_bounded(&samples, believes_all, [0, 0]).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn no_sample_makes_a_tick_answer_with_more_than_its_limit_or_with_no_number(
        samples in prop::collection::vec((positions(), elapsed()), 1..60),
        believes_all in any::<bool>(),
        lacks in prop::array::uniform2(0..4_usize),
    ) {
        is_bounded(&samples, believes_all, lacks)?;
    }
}

#[test]
fn a_sample_that_is_no_number_gives_no_force_and_says_whose_it_is() {
    for method in methods() {
        let renderer = WorldRenderer::new(&crowded(), WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        // The first tool presses the ball, the second is away from it.
        let apart = [0.0, 0.0, 0.2];
        let pressed = [[0.0, 0.0, 0.0499], apart];
        for _ in 0..3 {
            renderer.step(&mut state, &Sample::at(&pressed));
        }
        let output = renderer.step(&mut state, &Sample::at(&pressed));
        assert!(output.forces[0][2] > 0.0 && output.fault.is_none());
        let lost = [pressed[0], [f64::NAN, 0.0, 0.0]];
        let output = renderer.step(&mut state, &Sample::at(&lost));
        let fault = output.fault.unwrap();
        assert_eq!(
            (fault.fault, fault.tool),
            (Fault::PositionNotFinite, Some(1))
        );
        assert_eq!(output.forces, [[0.0; 3]; 2]);
        // The value is finite, but distances from it overflow.
        let far = [pressed[0], [1e300; 3]];
        let fault = renderer.step(&mut state, &Sample::at(&far)).fault.unwrap();
        assert_eq!((fault.fault, fault.tool), (Fault::Overflow, Some(1)));
        // A jump is rejected until the next sample confirms it.
        renderer.step(&mut state, &Sample::at(&pressed));
        let leapt = [[0.0, 0.0, 5.0], apart];
        let fault = renderer
            .step(&mut state, &Sample::at(&leapt))
            .fault
            .unwrap();
        assert_eq!((fault.fault, fault.tool), (Fault::JumpTooFast, Some(0)));
        assert_eq!(renderer.step(&mut state, &Sample::at(&leapt)).fault, None);
        // Too few positions.
        let fault = renderer
            .step(&mut state, &Sample::at(&leapt[..1]))
            .fault
            .unwrap();
        assert_eq!(
            (fault.fault, fault.tool),
            (Fault::PositionNotFinite, Some(1))
        );
    }
}

/// A light ball on a floor under a tool. If the sub-steps can resolve the contact, the ball is pushed. Otherwise
/// there is no force but a fault, and never a growing force.
#[test]
#[allow(clippy::print_stdout)] // prints the measured values
fn a_damper_that_is_too_strong_for_its_masses_gives_no_force() {
    for (damping, is_followed) in [(10.0, true), (100.0, true), (1e3, false), (1e5, false)] {
        let law = ContactLaw::spring(2000.0).with_damping(damping);
        let light = crate::common::ball("light", 0.01, Free::of_mass(0.005)).at([0.0, 0.0, 0.01]);
        let floor = crate::common::plane("floor", [0.0, 0.0, 1.0]);
        let world = crate::common::world(0.005, vec![floor, light], law);
        let model = CoupledParams::new(vec![[0.2; 3]]);
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), model).unwrap();
        let mut state = renderer.start();
        let (mut z, mut v, mut most, mut faults) = (0.03, -0.2_f64, 0.0_f64, 0);
        for _ in 0..400 {
            let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, z]]));
            let force = output.forces[0][2];
            faults += usize::from(output.fault.is_some());
            assert!(output.fault.is_none() || force == 0.0, "{force}");
            most = most.max(force.abs());
            v += (force - 1.0 - 20.0 * (z - 0.02)) / 0.2 * 0.001;
            z += v * 0.001;
            if z < 0.005 {
                break; // through the ball: the floor is another contact
            }
        }
        println!("{damping} N s/m: at most {most:.2} N, {faults} samples without a force");
        assert_eq!(faults == 0, is_followed, "{damping}: {faults}");
        // At 0.2 m/s a damper of 1000 N s/m alone gives 200 N.
        assert!(most < 80.0, "{damping}: {most}");
    }
}
