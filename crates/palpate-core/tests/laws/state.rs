//! State and renderer as values: small, copyable, shareable, reproducible, in either precision.

use crate::common::{entries, methods};
use palpate_core::{
    AnyMemory, AnyParams, AnyRenderer, Contact, Hfcr, HfcrParams, LoopParams, ObjectState,
    Renderer, Sample, Scalar, SehMemory, State,
};

fn is_copy_and_crosses_threads<T: Copy + Send + Sync + 'static>() {}

#[test]
fn state_and_renderer_are_plain_small_values() {
    is_copy_and_crosses_threads::<State<f64, AnyMemory<f64>>>();
    is_copy_and_crosses_threads::<State<f32, ()>>();
    is_copy_and_crosses_threads::<AnyRenderer<f64>>();
    is_copy_and_crosses_threads::<Renderer<f32, Hfcr<f32>>>();
    for (name, size, bound) in [
        ("f64, basic", size_of::<State<f64, ()>>(), 720),
        ("f64, seh", size_of::<State<f64, SehMemory<f64>>>(), 750),
        ("f64, any", size_of::<State<f64, AnyMemory<f64>>>(), 1700),
        ("f32, basic", size_of::<State<f32, ()>>(), 370),
        ("f32, any", size_of::<State<f32, AnyMemory<f32>>>(), 860),
    ] {
        println!("State<{name}>: {size} bytes");
        assert!(size <= bound, "State<{name}>: {size} bytes");
    }
}

fn renderer<S: Scalar>(method: AnyParams<S>) -> AnyRenderer<S> {
    let contact = Contact::object(S::from_f64(100.0), S::from_f64(0.1));
    Renderer::new(contact, LoopParams::new(S::from_f64(0.01)), method).unwrap()
}

/// A motion in and out of contact.
fn motion<S: Scalar>(tick: i32) -> Sample<S> {
    let t = f64::from(tick) * 0.01;
    let position = 0.02 * (11.0 * t).sin() + 0.01 * (4.0 * t).sin();
    Sample::at(S::from_f64(position)).with_virtual_force(S::from_f64(-0.981))
}

#[test]
fn a_saved_state_replays_bit_for_bit() {
    for (name, method) in methods() {
        let renderer = renderer(method);
        let mut state = renderer.start(ObjectState::at_rest(0.01)).unwrap();
        for tick in 0..60 {
            renderer.step(&mut state, motion(tick));
        }
        let mut saved = state;
        for tick in 60..200 {
            let output = renderer.step(&mut state, motion(tick));
            assert_eq!(output, renderer.step(&mut saved, motion(tick)), "{name}");
        }
        assert_eq!(state.ledger(), saved.ledger(), "{name}");
    }
}

#[test]
fn one_renderer_serves_many_lanes_that_do_not_know_of_each_other() {
    for (name, method) in methods() {
        let renderer = renderer(method);
        let lane = |offset: i32| renderer.start(ObjectState::at_rest(0.001 * f64::from(offset)));
        let mut together: Vec<_> = (0..20).map(|offset| lane(offset).unwrap()).collect();
        for tick in 0..100 {
            for state in &mut together {
                renderer.step(state, motion(tick));
            }
        }
        for (offset, state) in (0..20).zip(&together) {
            let mut alone = lane(offset).unwrap();
            for tick in 0..100 {
                renderer.step(&mut alone, motion(tick));
            }
            assert_eq!(alone.ledger(), state.ledger(), "{name}");
        }
    }
}

#[test]
fn single_precision_follows_double_precision() {
    for ((name, double), (_, single)) in methods::<f64>().into_iter().zip(methods::<f32>()) {
        if name.starts_with("popc") {
            // Their action depends on the sign of an energy near 0, which rounding decides.
            continue;
        }
        let (double, single) = (renderer(double), renderer(single));
        let mut state = double.start(ObjectState::at_rest(0.01)).unwrap();
        let mut small = single.start(ObjectState::at_rest(0.01)).unwrap();
        let (mut largest, mut worst) = (0.0_f64, 0.0_f64);
        for tick in 0..150 {
            let exact = double.step(&mut state, motion(tick)).force_on_object;
            let force = single.step(&mut small, motion(tick)).force_on_object;
            largest = largest.max(exact.abs());
            worst = worst.max((f64::from(force) - exact).abs());
        }
        println!("{name}: {worst:.1e} N of {largest:.2} N");
        assert!(largest > 0.5, "{name}");
        assert!(worst < 1e-4 * largest, "{name}: {worst} N");
        for (exact, entry) in entries(state.ledger()).iter().zip(entries(small.ledger())) {
            let scale = state.ledger().original_leak.absolute + exact.abs();
            assert!(
                (f64::from(entry) - exact).abs() < 1e-4 * scale,
                "{name}: {entry} J, not {exact} J"
            );
        }
    }
}

#[test]
fn a_method_chosen_by_value_is_the_method_itself() {
    let contact = Contact::object(100.0, 0.1);
    let itself = Renderer::new(contact, LoopParams::new(0.01), HfcrParams::default()).unwrap();
    let chosen = renderer(AnyParams::Hfcr(HfcrParams::default()));
    let mut state = itself.start(ObjectState::at_rest(0.01)).unwrap();
    let mut other = chosen.start(ObjectState::at_rest(0.01)).unwrap();
    for tick in 0..200 {
        let output = itself.step(&mut state, motion(tick));
        assert_eq!(output, chosen.step(&mut other, motion(tick)));
    }
}
