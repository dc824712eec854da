//! Delay, lag and gain of a loop: exact model, wrong model, or no model.

use palpate_core::{Actuation, AnyParams, CoupledParams, LoopParams};

use crate::desk::{Desk, draw};

const PERIOD: f64 = 1e-3;
const PLANTS: u64 = 30;
/// Half a period of delay, and a lag of 0.3 ms.
const LATE: (f64, f64) = (0.5, 3e-4);

fn coupled(desk: &Desk) -> CoupledParams<f64> {
    // The model mass is 1.5 times the true mass.
    CoupledParams::new(1.5 * desk.device_mass).with_encoder_quantum(desk.quantum)
}

/// Delay in periods, lag in seconds.
fn actuation((delay, lag): (f64, f64)) -> Actuation<f64> {
    Actuation::after(delay * PERIOD).with_lag(lag)
}

/// Returns E of desktop plants `[%]`: median, 90 % and largest. `real` creates the actuator of each.
fn spread(
    name: &str,
    real: impl Fn(&mut Desk),
    model: Actuation<f64>,
    params: impl Fn(&Desk) -> CoupledParams<f64>,
) -> [f64; 3] {
    let mut all: Vec<f64> = (0..PLANTS)
        .map(|seed| {
            let mut desk = draw(seed);
            real(&mut desk);
            let periods = desk.window(600);
            let loop_params = LoopParams {
                actuation: model,
                ..LoopParams::new(desk.period)
            };
            let params = AnyParams::Coupled(params(&desk));
            let rendered = desk.rendered(loop_params, params, periods, 5);
            desk.error(&desk.ideal(periods), &rendered)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    let found = [
        all[all.len() / 2],
        all[all.len() * 9 / 10],
        all[all.len() - 1],
    ];
    println!(
        "{name:40} {:6.2} {:6.2} {:6.2}",
        found[0], found[1], found[2]
    );
    found
}

fn delayed((delay, lag): (f64, f64)) -> impl Fn(&mut Desk) {
    move |desk| {
        desk.delay = delay * PERIOD;
        desk.lag = lag;
    }
}

#[track_caller]
fn is_within(found: [f64; 3], most: [f64; 3]) {
    for (found, most) in found.into_iter().zip(most) {
        assert!(found <= most, "{found} %, more than {most} %");
    }
}

#[test]
fn modelled_timing_restores_hold_bound() {
    for (name, late, most) in [
        ("no delay", (0.0, 0.0), [0.1, 0.5, 1.0]),
        ("one period", (1.0, 0.0), [0.1, 0.5, 1.0]),
        ("0.3 T", (0.3, 0.0), [0.2, 1.0, 2.0]),
        ("1.4 T", (1.4, 0.0), [0.2, 1.0, 3.0]),
        ("0.5 T and 0.3 ms", LATE, [0.5, 2.0, 3.0]),
        ("0.3 ms", (0.0, 3e-4), [0.5, 2.0, 3.0]),
        ("1.4 T and 0.3 ms", (1.4, 3e-4), [0.5, 2.0, 4.0]),
    ] {
        let found = spread(name, delayed(late), actuation(late), coupled);
        is_within(found, most);
    }
    let gain = actuation((0.0, 0.0)).with_gain(0.9);
    let found = spread("gain 0.9", |desk| desk.gain = 0.9, gain, coupled);
    is_within(found, [0.1, 0.5, 1.0]);
}

#[test]
fn small_timing_model_error_keeps_force_error_small() {
    let coarse = |desk: &mut Desk| {
        delayed(LATE)(desk);
        desk.quantum = 1e-5;
    };
    let off = (0.52, 3e-4);
    let found = spread(
        "told 0.02 T too long",
        delayed(LATE),
        actuation(off),
        coupled,
    );
    is_within(found, [5.0, 10.0, 15.0]);
    let uncertain = Actuation {
        delay_deviation: 0.02 * PERIOD,
        ..actuation(off)
    };
    let found = spread("the same, +- 0.02 T", delayed(LATE), uncertain, coupled);
    is_within(found, [3.0, 5.0, 8.0]);
    let found = spread("10 um", coarse, actuation(LATE), coupled);
    is_within(found, [1.5, 4.0, 8.0]);
    let found = spread("10 um, +- 0.02 T", coarse, uncertain, coupled);
    is_within(found, [3.0, 8.0, 12.0]);
    let jitter = |desk: &mut Desk| desk.jitter = 0.1 * PERIOD;
    let found = spread(
        "jitter of 0.1 T, mean told",
        jitter,
        actuation((0.05, 0.0)),
        coupled,
    );
    is_within(found, [2.0, 10.0, 25.0]);
    let uncertain = Actuation {
        delay_deviation: 0.03 * PERIOD,
        ..actuation((0.05, 0.0))
    };
    let found = spread("the same, +- 0.03 T", jitter, uncertain, coupled);
    is_within(found, [4.0, 20.0, 50.0]);
}

/// The delay of 0.1 T is unmodelled, but its standard deviation is modelled.
#[test]
fn delay_with_modelled_deviation_is_estimated_from_contact() {
    let unmodelled = actuation((0.0, 0.0));
    let uncertain = |deviation: f64| Actuation {
        delay_deviation: deviation * PERIOD,
        ..unmodelled
    };
    let late = delayed((0.1, 0.0));
    let [without, ..] = spread("0.1 T untold", &late, unmodelled, coupled);
    let [with, ..] = spread("0.1 T untold, +- 0.1 T", &late, uncertain(0.1), coupled);
    assert!(with < 0.4 * without, "{with} %, {without} % without");
    let late = delayed((0.3, 0.0));
    let [without, ..] = spread("0.3 T untold", &late, unmodelled, coupled);
    let [with, ..] = spread("0.3 T untold, +- 0.3 T", &late, uncertain(0.3), coupled);
    assert!(with < 0.6 * without, "{with} %, {without} % without");
}

/// A device of 0.2 kg that a hand of 300 N/m and 3 N s/m presses into a wall of this kappa. Returns the standard
/// deviation of the force after five seconds relative to its mean, and the mean.
fn left(kappa: f64, hand: (f64, f64), real: (f64, f64), model: Actuation<f64>) -> (f64, f64) {
    let device_mass = 0.2;
    let desk = Desk {
        device_mass,
        stiffness: kappa * device_mass / (PERIOD * PERIOD),
        object_mass: f64::INFINITY,
        push: 2.0,
        hand,
        gap: 2e-4,
        delay: real.0 * PERIOD,
        lag: real.1,
        clip: 10.0,
        quantum: 1e-7,
        ..draw(3)
    };
    let loop_params = LoopParams {
        actuation: model,
        ..LoopParams::new(PERIOD)
    };
    let params = AnyParams::Coupled(coupled(&desk));
    let forces = desk.rendered(loop_params, params, 6000, 5);
    let last = &forces[forces.len() * 5 / 6..];
    let mean = last.iter().sum::<f64>() / last.len() as f64;
    let square = last.iter().map(|force| (force - mean).powi(2)).sum::<f64>();
    ((square / last.len() as f64).sqrt() / mean, mean)
}

/// Coupled rendering gives at most the mean of the contact force, and a hand without a damper keeps the energy that the
/// mean force gives out.
#[test]
fn a_spring_without_a_damper_is_driven_and_one_with_a_damper_is_not() {
    let largest = |damping: f64, delay: f64| {
        let desk = Desk {
            device_mass: 0.265,
            stiffness: 16_300.0,
            object_mass: f64::INFINITY,
            push: 2.0,
            hand: (1000.0, damping),
            gap: 1e-3,
            delay: delay * PERIOD,
            lag: 0.0,
            clip: f64::INFINITY,
            quantum: 0.0,
            ..draw(3)
        };
        let loop_params = LoopParams {
            actuation: actuation((delay, 0.0)),
            ..LoopParams::new(PERIOD)
        };
        let params = AnyParams::Coupled(coupled(&desk));
        let seconds = 60;
        let forces = desk.rendered(loop_params, params, seconds * 1000, 5);
        let each = forces.chunks(forces.len() / seconds);
        let largest: Vec<f64> = each
            .map(|second| second.iter().copied().fold(0.0, f64::max))
            .collect();
        println!(
            "{damping} N s/m, {delay} T: {:.1} N in the first second, {:.1} in the last",
            largest[0],
            largest[seconds - 1]
        );
        (largest[0], largest[seconds - 1])
    };
    let (first, last) = largest(0.0, 4.0);
    assert!(last > 3.0 * first, "{first} N, {last} N");
    for (damping, delay) in [(0.2, 4.0), (1.0, 4.0), (0.0, 0.0)] {
        let (first, last) = largest(damping, delay);
        assert!(last < 1.1 * first, "{first} N, {last} N");
    }
}

/// A table of docs/results/coupled.md.
#[test]
fn how_stiff_a_wall_may_be_that_rests_with_half_a_period_of_delay() {
    for (hand, rests) in [
        ((0.0, 0.5), 1.0),
        ((0.0, 2.0), 2.0),
        ((60.0, 1.5), 2.0),
        ((300.0, 3.0), 2.0),
    ] {
        for late in [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)] {
            let swings = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0].map(|kappa| {
                let (swing, _) = left(kappa, hand, late, actuation(late));
                assert!(
                    kappa > rests || swing < 0.05,
                    "{hand:?}, {late:?}: {swing} at {kappa}"
                );
                format!("{:.1}", 100.0 * swing)
            });
            println!("hand {hand:?}, late {late:?}: {} %", swings.join(" "));
        }
    }
}

#[test]
fn pressed_wall_rests_with_modelled_delay() {
    for late in [(0.5, 0.0), (1.0, 0.0), LATE] {
        for (kappa, deviation) in [(0.1, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.01), (2.0, 0.01)] {
            let model = Actuation {
                delay_deviation: deviation * PERIOD,
                ..actuation(late)
            };
            let (swing, mean) = left(kappa, (0.0, 1.0), late, model);
            println!(
                "kappa {kappa}, late {late:?} +- {deviation} T: swings by {:.2} %",
                100.0 * swing
            );
            assert!(
                swing < 0.05 && (mean - 2.0).abs() < 0.01,
                "{swing}, {mean} N"
            );
        }
    }
}

#[test]
fn pressed_wall_rests_once_unmodelled_delay_is_estimated() {
    for (kappa, late) in [
        (0.1, 0.1),
        (0.1, 0.3),
        (0.1, 0.5),
        (0.3, 0.1),
        (0.3, 0.3),
        (1.0, 0.3),
        (1.0, 0.5),
    ] {
        let real = (late, 0.0);
        let model = Actuation {
            delay_deviation: 0.3 * PERIOD,
            ..Actuation::default()
        };
        let (unmodelled, _) = left(kappa, (300.0, 3.0), real, Actuation::default());
        let (swing, mean) = left(kappa, (300.0, 3.0), real, model);
        println!(
            "kappa {kappa}, {late} T: swings by {:.0} % untold, by {:.2} % of {mean:.2} N told +- 0.3 T",
            100.0 * unmodelled,
            100.0 * swing
        );
        // The soft wall with a tenth of a period rests in any case.
        assert!(
            unmodelled > 1.0 || (kappa, late) == (0.1, 0.1),
            "{unmodelled}"
        );
        assert!(swing < 0.05, "{swing}");
    }
}
