//! Loops that sample late, miss samples, change their rate and act between samples, against what is
//! computed here from the samples alone.
#![allow(clippy::print_stdout)] // what was measured

use crate::common::{Random, scene as experiment};
use palpate_core::Sample;
use palpate_scene::method::MethodName;
use palpate_scene::{Delay, Dropped, Jitter, Measure, RateCollapse, Scene, Timing};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_study::sim::run::Run;
use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::metrics::ForceEvaluation;

/// One of the paper's scenes in a loop with something, or everything, wrong.
fn imperfect(name: &str, seed: u64) -> Scene {
    let mut scene = experiment(name);
    let mut random = Random(seed);
    let period = scene.loop_params.period;
    let bound = random.between(0.05, 0.45) * period;
    scene.delay = Delay::Periods {
        samples: if random.once_in(2) { 0 } else { 1 },
        fraction: if random.once_in(3) {
            0.0
        } else {
            random.between(0.05, 0.95)
        },
    };
    scene.timing = Timing {
        jitter: match seed % 3 {
            0 => Jitter::None,
            1 => Jitter::Uniform { bound },
            _ => Jitter::Normal {
                deviation: 0.5 * bound,
                bound,
            },
        },
        dropped: match seed % 4 {
            0 => Dropped::None,
            1 => Dropped::Listed(vec![3, 11, 12, 30]),
            _ => Dropped::Probability(random.between(0.01, 0.3)),
        },
        collapse: random.once_in(3).then(|| RateCollapse {
            from: 0.1,
            until: 0.4,
            period: random.between(1.0, 3.0) * period,
        }),
        seed,
        ..Timing::default()
    };
    scene
}

fn scenes() -> impl Iterator<Item = Scene> {
    let names = crate::common::PAPER_SCENES.into_iter().cycle();
    names.zip(0..60).map(|(name, seed)| imperfect(name, seed))
}

/// The force on the object that the motor holds at `time` `[s]`: the answer that reached it last.
fn held_at(run: &Run, time: f64) -> f64 {
    let arrived =
        |tick: &&palpate_study::sim::run::Tick| tick.command_from.is_some_and(|from| from <= time);
    let last = run.ticks.iter().rev().find(arrived);
    last.map_or(0.0, |tick| tick.output.force_on_object)
}

fn ideal(scene: &Scene) -> Ideal {
    let palpate_core::Mass::Finite(object_mass) = scene.contact.object_mass else {
        panic!("the paper's scenes have objects");
    };
    Ideal::new(PointMassScene {
        stiffness: scene.contact.stiffness,
        device_mass: scene.device.mass(),
        object_mass,
        user_force: scene.device.hand_force(),
        virtual_force: scene.virtual_force,
        device_position: scene.device.position(),
        device_velocity: scene.device.velocity(),
        object_position: scene.object.position,
        object_velocity: scene.object.velocity,
    })
    .unwrap()
}

#[test]
fn the_error_is_that_of_the_signal_which_the_motor_held() {
    for scene in scenes() {
        let bench = Bench::new(&scene).unwrap();
        let ideal = ideal(&scene);
        let end = bench.reference().profile.grid().end();
        for method in [MethodName::Basic, MethodName::Hfcr] {
            let run = bench.run(method).unwrap();
            let fidelity = run.force.fidelity.unwrap();
            let points = 40_000;
            let (mut error, mut force) = (0.0, 0.0);
            for point in 0..points {
                let time = end * ((f64::from(point) + 0.5) / f64::from(points));
                let ideal = ideal.at(time).force_on_object;
                error += (held_at(&run, time) - ideal).powi(2);
                force += ideal * ideal;
            }
            let expected = 100.0 * (error / force).sqrt();
            let found = fidelity.force_rendering_error;
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{found} {expected} {scene:?}"
            );
        }
    }
}

#[test]
fn the_square_of_the_error_is_that_of_floor_and_mean_force_error_in_any_loop() {
    let mut away = 0.0_f64;
    for scene in scenes() {
        let bench = Bench::new(&scene).unwrap();
        let perfect = Scene {
            timing: Timing::default(),
            ..scene.clone()
        };
        let perfect_floor = Bench::new(&perfect)
            .unwrap()
            .run(MethodName::Basic)
            .unwrap()
            .force
            .fidelity
            .unwrap()
            .hold_bound;
        for method in MethodName::ALL {
            let f = bench.run(method).unwrap().force.fidelity.unwrap();
            let (fre, floor, e) = (f.force_rendering_error, f.hold_bound, f.mean_force_error);
            let sum = floor * floor + e * e;
            assert!((fre * fre / sum - 1.0).abs() < 1e-9, "{method} {scene:?}");
            away = away.max((floor / perfect_floor - 1.0).abs());
        }
        // The best that this loop can hold has no error but the floor.
        let profile = &bench.reference().profile;
        let best: Vec<f64> = profile.mean_forces().collect();
        let best = ForceEvaluation::new(&best, profile)
            .unwrap()
            .fidelity
            .unwrap();
        assert_eq!(best.mean_force_error, 0.0);
        assert!((best.force_rendering_error / best.hold_bound - 1.0).abs() < 1e-9);
    }
    assert!(
        away > 0.2,
        "the floor is that of the loop, not of its period: {away}"
    );
}

#[test]
fn the_device_moves_under_what_was_held_and_the_bench_counts_its_work() {
    for scene in scenes() {
        let run = Bench::new(&scene)
            .unwrap()
            .run(MethodName::HfcrModSt)
            .unwrap();
        let mut device = PointMass::new(scene.device.mass(), scene.device.hand_force()).unwrap();
        let end = run.last().time;
        // Every instant at which something happens.
        let mut instants: Vec<f64> = run.ticks.iter().map(|tick| tick.time).collect();
        instants.extend(run.ticks.iter().filter_map(|tick| tick.command_from));
        instants.sort_by(f64::total_cmp);
        let mut ticks = run.ticks.iter().peekable();
        let (mut work, mut turned_over) = (0.0, 0.0);
        for pair in instants.windows(2) {
            if let Some(tick) = ticks.next_if(|tick| tick.time <= pair[0]) {
                let away = tick.true_device_position - device.position();
                assert!(away.abs() < 1e-11, "{away} m at {} s", tick.time);
            }
            let middle = 0.5 * (pair[0] + pair[1]);
            let done = device.advance(held_at(&run, middle), pair[1] - pair[0]);
            work += done;
            turned_over += done.abs();
        }
        assert!(ticks.count() <= 1, "every sample but the last was compared");
        assert_eq!(instants.last(), Some(&end));
        let bench = run.bench_port_work.unwrap();
        assert!((bench - work).abs() < 1e-9 * turned_over, "{bench} {work}");
        // The held pieces are that same signal.
        assert_eq!(
            run.held.len(),
            Bench::new(&scene).unwrap().reference().profile.intervals()
        );
        for (piece, next) in run.held.iter().zip(&run.held[1..]) {
            let middle = 0.5 * (piece.from + next.from);
            assert_eq!(piece.force_on_object, held_at(&run, middle));
        }
    }
}

#[test]
fn the_renderer_gets_the_measured_time_and_hears_what_was_sent_and_no_more() {
    let (mut uneven, mut clipped) = (0, 0);
    for mut scene in scenes() {
        if scene.timing.seed % 2 == 0 {
            scene.device.point_mass_mut().unwrap().largest_force = Some(2.0);
        }
        let largest = scene.device.largest_force().unwrap_or(f64::INFINITY);
        let bench = Bench::new(&scene).unwrap();
        for method in MethodName::ALL {
            let run = bench.run(method).unwrap();
            let renderer = scene.renderer(method).unwrap();
            let mut state = renderer.start(scene.object).unwrap();
            let period = scene.loop_params.period;
            for (i, tick) in run.ticks.iter().enumerate() {
                let mut sample =
                    Sample::at(tick.device_position).with_virtual_force(scene.virtual_force);
                if i > 0 {
                    let before = run.ticks[i - 1].time;
                    let elapsed = tick.time - before;
                    uneven += usize::from((elapsed / period - 1.0).abs() > 1e-3);
                    sample = sample.after(elapsed);
                }
                let output = renderer.step(&mut state, sample);
                let sent = output.force_on_object.clamp(-largest, largest);
                clipped += usize::from(sent != output.force_on_object);
                renderer.report_sent(&mut state, sent);
                let near = |a: f64, b: f64| (a - b).abs() <= 1e-7 * (1.0 + a.abs());
                assert!(
                    near(output.force_on_object, tick.output.force_on_object)
                        && near(output.object_position, tick.output.object_position)
                        && near(state.ledger().port_work, tick.ledger.port_work)
                        && near(
                            state.ledger().held_leak.absolute,
                            tick.ledger.held_leak.absolute
                        ),
                    "{method} at sample {i} of {scene:?}:\n{output:?}\n{tick:?}"
                );
            }
        }
    }
    assert!(uneven > 1000 && clipped > 1000, "{uneven} {clipped}");
}

#[test]
fn a_dropped_sample_leaves_the_force_held() {
    let mut scene = experiment("fig2");
    scene.timing.dropped = Dropped::Listed(vec![13, 14]);
    let run = Bench::new(&scene).unwrap().run(MethodName::Basic).unwrap();
    assert_eq!(run.ticks.len(), 76 - 2);
    let before = run.ticks.iter().rfind(|tick| tick.time < 0.125).unwrap();
    assert_eq!(before.time, 0.12);
    assert!(before.held_force_on_object > 1.0);
    let piece = run.held.iter().position(|held| held.from == 0.12).unwrap();
    assert_eq!(run.held[piece].force_on_object, before.held_force_on_object);
    assert_eq!(run.held[piece + 1].from, 0.15);
}

#[test]
fn a_rate_collapse_is_longer_intervals_while_it_lasts() {
    let mut scene = experiment("wall");
    scene.measure = Measure::Duration(0.1);
    scene.timing.collapse = Some(RateCollapse {
        from: 0.02,
        until: 0.06,
        period: 0.008,
    });
    let run = Bench::new(&scene).unwrap().run(MethodName::Hfcr).unwrap();
    let slow = run
        .ticks
        .windows(2)
        .filter(|pair| (pair[1].time - pair[0].time - 0.008).abs() < 1e-9)
        .count();
    assert_eq!((slow, run.ticks.len()), (5, 1 + 20 + 5 + 40));
    assert_eq!(run.faults(), 0);
}

#[test]
fn the_same_seed_gives_the_same_run_and_another_another() {
    let scene = |seed| {
        let mut scene = experiment("experiment1");
        scene.timing.jitter = Jitter::Uniform { bound: 0.005 };
        scene.timing.dropped = Dropped::Probability(0.1);
        scene.timing.seed = seed;
        scene
    };
    let run = |seed| {
        Bench::new(&scene(seed))
            .unwrap()
            .run(MethodName::Hfcr)
            .unwrap()
    };
    assert_eq!(run(5).ticks, run(5).ticks);
    assert_ne!(run(5).ticks, run(6).ticks);
}

#[test]
fn an_integrated_ideal_is_cut_where_an_exact_one_is() {
    for seed in 0..12 {
        let free = imperfect("experiment1", seed);
        let mut rough = free.clone();
        rough.device.point_mass_mut().unwrap().viscous_friction = 1e-7;
        let (a, b) = (Bench::new(&free).unwrap(), Bench::new(&rough).unwrap());
        let (a, b) = (&a.reference().profile, &b.reference().profile);
        assert_eq!(a.grid(), b.grid());
        let scale = a.impulses().iter().fold(0.0_f64, |most, j| most.max(*j));
        for (i, (a, b)) in a.impulses().iter().zip(b.impulses()).enumerate() {
            assert!((a - b).abs() < 1e-5 * scale, "interval {i}: {a} and {b}");
        }
        let squares = |profile: &palpate_testbed::profile::ForceProfile| {
            profile.squared_forces().iter().sum::<f64>()
        };
        assert!((squares(a) / squares(b) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_loop_of_too_many_samples_is_refused() {
    let mut scene = experiment("fig2");
    scene.timing.collapse = Some(RateCollapse {
        from: 0.0,
        until: 1.0,
        period: 1e-12,
    });
    assert!(matches!(
        Bench::new(&scene).unwrap_err(),
        LoopError::TooLong(_)
    ));
}

#[test]
fn a_bench_runs_what_has_its_ideal_and_nothing_else() {
    let scene = experiment("fig2");
    let bench = Bench::new(&scene).unwrap();
    let mut delayed = scene.clone();
    delayed.delay = Delay::samples(1);
    let varied = bench.run_varied(&delayed, MethodName::Basic).unwrap();
    let own = Bench::new(&delayed)
        .unwrap()
        .run(MethodName::Basic)
        .unwrap();
    assert_eq!(varied.ticks, own.ticks);
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        assert!(!bench.evaluates(&other));
        let error = bench.run_varied(&other, MethodName::Basic).unwrap_err();
        assert_eq!(error, LoopError::AnotherScene);
    };
    refused(&|scene| scene.contact.stiffness *= 2.0);
    refused(&|scene| *scene.device.mass_mut().unwrap() *= 2.0);
    refused(&|scene| scene.loop_params.period *= 2.0);
    refused(&|scene| {
        scene.delay = Delay::Periods {
            samples: 0,
            fraction: 0.5,
        }
    });
    refused(&|scene| scene.delay = Delay::Seconds(0.25 * scene.loop_params.period));
    // A delay of an imperfect loop changes when its forces change.
    let broken = imperfect("fig2", 1);
    let bench = Bench::new(&broken).unwrap();
    let mut later = broken.clone();
    later.delay = Delay::samples(broken.delay.whole_samples() + 1);
    assert_eq!(
        bench.run_varied(&later, MethodName::Basic).unwrap_err(),
        LoopError::AnotherScene
    );
}
