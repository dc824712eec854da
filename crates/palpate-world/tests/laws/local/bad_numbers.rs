//! Non-finite numbers, and motions that overflow.

use palpate_core::Fault;
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{LocalContact, LocalParams};
use palpate_world::{ContactLaw, Sample};

use super::{Led, at_depth, plane, renderer, soft};

/// Invalid numbers cause no force, NaN or infinity; afterwards valid samples and models are processed normally.
#[test]
fn nothing_that_comes_makes_a_force_that_is_no_number() {
    let renderer = renderer(LocalParams::new(2, 4), 0.2);
    let mut state = renderer.start();
    let mut seed = 1_u64;
    let mut random = move || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(u32::MAX >> 1)
    };
    let (mut faults, mut refusals, mut felt) = (0, 0, 0);
    for tick in 0..4000_u64 {
        let wild = [1.0, 1e-3, 1e6, 1e150, -1.0, 0.1, 0.1, 0.1][(random() * 7.99) as usize];
        let normal_at = random() * 6.3;
        let mut bodies = [BodyNow::fixed([0.0; 3]); 2];
        for body in &mut bodies {
            body.position = [random() * 0.01, 0.0, -0.01];
            body.velocity = [random() * wild; 3];
            body.acceleration = [0.0, random() * wild, 0.0];
            for axis in 0..6 {
                body.mobility[axis][axis] = random() * wild.abs();
            }
        }
        let contacts = [0, 1, 2, 3].map(|slot| {
            let normal = [normal_at.cos(), 0.0, normal_at.sin()];
            let law = ContactLaw::spring((1e3 * wild.abs() + 1.0).min(1e12))
                .with_damping(random())
                .with_friction(random());
            let on = [None, Some(0), Some(1), None][slot];
            let contact = if slot == 3 && random() < 0.5 {
                LocalContact::of_body((0, [0.0; 3], random()), Some(1), [0.0; 3], normal, law)
            } else {
                LocalContact::of_tool(0, on, [0.0, 0.0, random() * wild], normal, law)
            };
            let is_there = random() < 0.8;
            is_there.then(|| contact.curved((random() - 0.5) * wild))
        });
        let now = state.progress().tick;
        let of = (now + (random() * 3.0) as u64).saturating_sub((random() * 10.0) as u64);
        let model = (random() < 0.2).then(|| renderer.model(of, &bodies, &contacts).unwrap());
        let position = match (random() * 40.0) as u32 {
            0 => [f64::NAN; 3],
            1 => [1e300; 3],
            _ => [random() * 0.01, 0.0, random() * 0.01],
        };
        let positions = [position];
        let output = renderer.step(&mut state, &Sample::at(&positions), model.as_ref());
        let force = output.forces[0];
        assert!(force.iter().all(|x| x.is_finite()), "{tick}: {output:?}");
        if output.fault.is_some() {
            faults += 1;
            assert_eq!(force, [0.0; 3]);
        }
        refusals += u32::from(output.refusal.is_some());
        felt += u32::from(force != [0.0; 3]);
        let progress = state.progress();
        let model = progress
            .impulses
            .iter()
            .flat_map(|it| it.linear.into_iter().chain(it.angular));
        assert!(
            model.chain(progress.positions[0]).all(f64::is_finite),
            "{tick}: {progress:?}"
        );
    }
    println!("{faults} faults, {refusals} refusals, {felt} forces");
    assert!(faults > 100 && refusals > 50 && felt > 500);
    // A valid host and a valid hand.
    let bodies = [BodyNow::fixed([0.0; 3]); 2];
    let mut last = [0.0; 3];
    for _ in 0..500 {
        let model = renderer.model(state.progress().tick, &bodies, &[plane(0.0, soft())]);
        let sample = at_depth(0.001);
        let output = renderer.step(&mut state, &Sample::at(&sample), Some(&model.unwrap()));
        last = output.forces[0];
    }
    assert!(last[2] > 0.5 && last[2] < 1.5, "{last:?}");
}

#[test]
fn a_sample_that_is_no_number_gives_no_force_and_the_next_good_one_goes_on() {
    let mut led = Led::pressed(LocalParams::new(0, 1), soft());
    let bad = [[f64::NAN; 3]];
    let output = led.renderer.step(&mut led.state, &Sample::at(&bad), None);
    assert_eq!(output.forces[0], [0.0; 3]);
    assert_eq!(
        output.fault.map(|fault| fault.fault),
        Some(Fault::PositionNotFinite)
    );
    assert!((led.step(0.002, None).0[2] - 2.0).abs() < 1e-9);
}

#[test]
fn a_copy_that_overflows_is_a_fault_and_a_good_model_goes_on() {
    let renderer = renderer(LocalParams::new(1, 1), f64::INFINITY);
    let mut state = renderer.start();
    let mut wild = BodyNow::fixed([0.0; 3]);
    wild.angular_velocity = [1e300, 0.0, 0.0];
    let contact = [plane(0.0, soft()).map(|contact| LocalContact {
        on: Some(0),
        ..contact
    })];
    let model = renderer.model(0, &[wild], &contact).unwrap();
    let position = at_depth(0.001);
    let output = renderer.step(&mut state, &Sample::at(&position), Some(&model));
    assert_eq!(output.fault.map(|it| it.fault), Some(Fault::Overflow));
    assert_eq!(output.forces[0], [0.0; 3]);
    let good = BodyNow::fixed([0.0; 3]);
    let mut last = [0.0; 3];
    for _ in 0..300 {
        let tick = state.progress().tick;
        let model = renderer.model(tick, &[good], &contact).unwrap();
        let output = renderer.step(&mut state, &Sample::at(&position), Some(&model));
        assert_eq!(output.fault, None);
        last = output.forces[0];
    }
    assert!((last[2] - 1.0).abs() < 1e-9, "{last:?}");
}

/// A contact that is too fast for its masses is rejected also while it is blended in, before it is felt.
#[test]
fn a_contact_that_is_too_fast_is_never_felt_and_another_one_is() {
    let device = 0.1;
    let renderer = renderer(LocalParams::new(0, 1), device);
    let mut state = renderer.start();
    // For 0.1 kg, 256 sub-steps of 1 ms are stable up to 6.5 GN/m.
    let (mut refused, mut felt) = (0, 0.0_f64);
    for tick in 0..400 {
        let stiff = ContactLaw::spring(if tick < 300 { 7e9 } else { 4e3 });
        let now = state.progress().tick;
        let model = (tick % 20 == 0).then(|| renderer.model(now, &[], &[plane(0.0, stiff)]));
        let model = model.map(Result::unwrap);
        let positions = at_depth(1e-5);
        let output = renderer.step(&mut state, &Sample::at(&positions), model.as_ref());
        if output.effort.unstable {
            refused += 1;
            assert_eq!(output.fault.map(|it| it.fault), Some(Fault::Overflow));
        }
        if tick < 300 {
            felt = felt.max(output.forces[0][2].abs());
        } else if tick == 399 {
            let force = output.forces[0][2];
            assert_eq!(output.fault, None);
            assert!((force - 0.04).abs() < 1e-3, "{force} N");
        }
    }
    assert_eq!((refused, felt), (15, 0.0));
}
