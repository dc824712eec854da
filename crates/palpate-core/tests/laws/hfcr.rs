//! The three steps of HFCR, its damping, and its equivalents on a wall.

use crate::common::{PointMass, Random};
use palpate_core::{
    AnyParams, AnyRenderer, Contact, HfcrParams, LeakDissipation, LoopParams, MethodParams,
    ObjectState, Output, Phase, Renderer, Sample, SehParams, VirtualDamperParams,
};
use proptest::prelude::*;

const STIFFNESS: f64 = 100.0;
const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;
const B: f64 = 0.7;

fn object() -> Contact<f64> {
    Contact::object(STIFFNESS, 0.1)
}

fn renderer(contact: Contact<f64>, method: AnyParams<f64>) -> AnyRenderer<f64> {
    Renderer::new(contact, LoopParams::new(PERIOD), method).unwrap()
}

fn switched(modified_force: bool, smooth_transition: bool, damping: bool) -> AnyParams<f64> {
    AnyParams::Hfcr(HfcrParams {
        modified_force,
        smooth_transition,
        leak_dissipation: if damping {
            LeakDissipation::Damping(B)
        } else {
            LeakDissipation::Off
        },
        ..HfcrParams::default()
    })
}

fn bounce(method: AnyParams<f64>, mut visit: impl FnMut(&Output<f64>)) {
    let renderer = renderer(object(), method);
    let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
    let mut device = PointMass {
        mass: 0.1,
        user_force: 0.981,
        position: 0.0,
        velocity: 0.0,
    };
    for _ in 0..200 {
        let sample = Sample::at(device.position).with_virtual_force(WEIGHT);
        let output = renderer.step(&mut state, sample);
        visit(&output);
        device.hold(output.force_on_device, PERIOD);
    }
}

#[test]
fn with_every_step_off_it_is_the_basic_model_bit_for_bit() {
    let run = |method| {
        let mut outputs = Vec::new();
        bounce(method, |output| outputs.push(*output));
        outputs
    };
    let basic = run(AnyParams::Basic);
    assert!(basic == run(switched(false, false, false)));
    for any_on in [
        (true, false, false),
        (false, true, false),
        (false, false, true),
    ] {
        let (modified, smooth, damping) = any_on;
        assert!(
            basic != run(switched(modified, smooth, damping)),
            "{any_on:?}"
        );
    }
}

#[test]
fn each_step_does_its_own_part_whatever_the_others_do() {
    let all: Vec<_> = (0..8_u8)
        .map(|bits| {
            let on = |bit: u8| bits & bit != 0;
            renderer(object(), switched(on(1), on(2), on(4)))
        })
        .collect();
    let mut random = Random(21);
    let mut seen = [0; 4];
    for _ in 0..20_000 {
        let object = ObjectState {
            position: 0.0,
            velocity: random.between(-1.0, 1.0),
        };
        let first = random.between(-0.01, 0.01);
        let second = first + random.between(-0.005, 0.005);
        let at = |xi: f64| Sample::at(xi).with_virtual_force(WEIGHT);
        let outputs: Vec<_> = all
            .iter()
            .map(|renderer| {
                let mut state = renderer.start(object).unwrap();
                renderer.step(&mut state, at(first));
                renderer.step(&mut state, at(second))
            })
            .collect();
        // The smooth transition may already have changed the motion in the first interval.
        let (unsmooth, smooth): (Vec<usize>, Vec<usize>) = (0..8).partition(|bits| bits & 2 == 0);
        for group in [unsmooth, smooth] {
            let plain = &outputs[group[0]];
            let velocity = (second - first) / PERIOD;
            let (index, share) = match plain.phase {
                Phase::Free => (0, 0.0),
                Phase::Contact => (1, 1.0),
                Phase::Enters => (2, 1.0 - plain.transition_after / PERIOD),
                _ => (3, plain.transition_after / PERIOD),
            };
            seen[index] += 1;
            for bits in group {
                let output = &outputs[bits];
                // Rule and motion depend on the smooth transition alone.
                assert_eq!(output.phase, plain.phase);
                assert_eq!(output.transition_after, plain.transition_after);
                assert_eq!(output.object_position, plain.object_position);
                // Without the modified force it is the spring force.
                if bits & 5 == 0 {
                    let spring = STIFFNESS * output.penetration.max(0.0);
                    assert_eq!(output.force_on_object, spring);
                }
                // The damping adds Eq. (11) to the force without damping.
                if bits & 4 != 0 {
                    let without = outputs[bits & !4].force_on_object;
                    let added = share * B * (velocity - output.object_velocity);
                    assert!((output.force_on_object - without - added).abs() < 1e-13);
                }
            }
        }
    }
    assert!(seen.iter().all(|&count| count > 500), "{seen:?}");
}

fn auto(contact: Contact<f64>, period: f64, device_mass: f64) -> f64 {
    let params = HfcrParams {
        leak_dissipation: LeakDissipation::Auto { device_mass },
        ..HfcrParams::default()
    };
    let method = params.check(&contact, &LoopParams::new(period)).unwrap();
    method.damping()
}

#[test]
fn automatic_damping_is_the_small_kappa_estimate() {
    // The three scenes of the paper, and K^2 T^3 / (4 m) with no factor on a wall.
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value}");
    near(auto(object(), 0.01, 0.1), 0.0125);
    near(
        auto(object(), 0.02, 0.25),
        1e4 * 8e-6 / (4.0 * 0.25) * 0.1 / 0.35,
    );
    near(
        auto(Contact::object(400.0, 0.1), 0.02, 0.25),
        1.6e5 * 8e-6 / (4.0 * 0.25) * 0.1 / 0.35,
    );
    near(auto(Contact::wall(100.0), 0.02, 0.25), 1e4 * 8e-6);
    // A heavy object is a wall in the limit.
    near(
        auto(Contact::object(100.0, 1e15), 0.02, 0.25),
        auto(Contact::wall(100.0), 0.02, 0.25),
    );
}

#[test]
fn automatic_damping_is_the_fixed_damping_of_its_value() {
    let run = |leak_dissipation| {
        let mut forces = Vec::new();
        let method = AnyParams::Hfcr(HfcrParams {
            leak_dissipation,
            ..HfcrParams::default()
        });
        bounce(method, |output| forces.push(output.force_on_object));
        forces
    };
    let auto_value = auto(object(), PERIOD, 0.1);
    let automatic = run(LeakDissipation::Auto { device_mass: 0.1 });
    assert_eq!(automatic, run(LeakDissipation::Damping(auto_value)));
    assert_ne!(automatic, run(LeakDissipation::Off));
}

#[test]
fn the_three_steps_together_can_pull_and_a_pushing_contact_does_not() {
    let pulls = |contact: Contact<f64>| {
        let method = AnyParams::Hfcr(HfcrParams::with_damping(5.0));
        let renderer = renderer(contact, method);
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let mut random = Random(22);
        let mut device = 0.0;
        let mut pulls = 0;
        for _ in 0..2000 {
            device = 0.5 * device + random.between(-0.004, 0.006);
            let output = renderer.step(&mut state, Sample::at(device));
            pulls += usize::from(output.force_on_object < 0.0);
        }
        pulls
    };
    let wall = Contact::wall(STIFFNESS);
    assert!(pulls(wall) > 10, "sticky, as in the paper");
    assert_eq!(pulls(wall.pushing_only()), 0);
}

proptest! {
    #[test]
    fn on_a_wall_sustained_contact_is_seh_and_a_damper_of_half_k_t(
        stiffness in (1.0..4.5_f64).prop_map(|e| 10f64.powf(e)),
        period in (-3.5..-1.5_f64).prop_map(|e| 10f64.powf(e)),
        positions in prop::collection::vec(1e-4..0.02_f64, 3..20),
    ) {
        let wall = Contact::wall(stiffness);
        let l = LoopParams { speed_limit: None, ..LoopParams::new(period) };
        let damper = VirtualDamperParams::new(0.5 * stiffness * period);
        let methods = [
            AnyParams::Hfcr(HfcrParams::default()),
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
            AnyParams::Seh(SehParams::default()),
            AnyParams::VirtualDamper(damper),
        ];
        let mut loops = methods.map(|method| {
            let renderer = AnyRenderer::new(wall, l, method).unwrap();
            let state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
            (renderer, state)
        });
        let mut previous = None;
        for &position in &positions {
            let forces = loops.each_mut().map(|(renderer, state)| {
                renderer.step(state, Sample::at(position)).force_on_object
            });
            // Contact is predicted to continue, and SEH has a past from the second sample on.
            if previous.is_some_and(|previous| 2.0 * position - previous > 0.0) {
                for force in forces {
                    prop_assert!((force - forces[0]).abs() <= 1e-12 * stiffness * 0.02, "{forces:?}");
                }
                let spring = stiffness * position;
                prop_assert!(previous == Some(position) || (forces[0] - spring).abs() > 0.0);
            }
            previous = Some(position);
        }
    }
}
