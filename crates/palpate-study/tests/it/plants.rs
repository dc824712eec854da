//! Scenes whose device has friction or is held by a hand of its own.
#![allow(clippy::print_stdout)] // what was measured

use std::sync::Arc;

use crate::common::scene as experiment;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::{Delay, Grip, Hand, Intention, Measure, Scene, Wave};
use palpate_study::sim::closed_loop::{Bench, error_against};
use palpate_study::sim::run::Run;
use palpate_testbed::recorded_path::RecordedPath;

fn run(scene: &Scene, method: MethodName) -> Run {
    Bench::new(scene).unwrap().run(method).unwrap()
}

fn error(run: &Run) -> f64 {
    run.force.fidelity.unwrap().mean_force_error
}

fn hand_of(scene: &mut Scene) -> &mut Hand {
    &mut scene.device.point_mass_mut().unwrap().hand
}

fn in_a_hand() -> Scene {
    let mut scene = experiment("experiment1");
    let device = scene.device.point_mass_mut().unwrap();
    device.viscous_friction = 0.2;
    device.coulomb_friction = 0.02;
    device.hand = Hand {
        force: 0.0,
        tremor: Some(Wave {
            amplitude: 0.1,
            frequency_hz: 8.0,
        }),
        grip: Some(Grip {
            mass: 0.1,
            stiffness: 60.0,
            damping: 1.0,
            intention: Intention::Place {
                position: 0.03,
                swing: Some(Wave {
                    amplitude: 0.02,
                    frequency_hz: 1.0,
                }),
            },
        }),
        release: None,
    };
    scene
}

#[test]
fn tiny_friction_changes_the_evaluation_slightly() {
    // The exact ideal and the integrated one meet where friction vanishes.
    for name in ["fig2", "experiment1"] {
        let free = experiment(name);
        let mut rough = free.clone();
        rough.device.point_mass_mut().unwrap().viscous_friction = 1e-7;
        for method in [MethodName::Hfcr, MethodName::VirtualDamper] {
            let (a, b) = (run(&free, method), run(&rough, method));
            let (floor_a, floor_b) = (
                a.force.fidelity.unwrap().hold_bound,
                b.force.fidelity.unwrap().hold_bound,
            );
            println!("{name} {method}: E {} and {}", error(&a), error(&b));
            assert!((error(&a) - error(&b)).abs() < 2e-3, "{name} {method}");
            assert!((floor_a - floor_b).abs() < 1e-3, "{floor_a} {floor_b}");
            assert!(a.energy.is_some() && b.energy.is_none());
            assert_eq!((a.diverged, b.diverged), (Some(false), Some(false)));
        }
    }
}

#[test]
fn the_integrated_ideal_says_how_exact_it_is() {
    let scene = in_a_hand();
    let bench = Bench::new(&scene).unwrap();
    let reported = bench.reference().error;
    println!("integrated to {reported:.1e} of the largest impulse");
    assert!(reported > 0.0 && reported < 1e-6, "{reported}");
    assert_eq!(
        Bench::new(&experiment("fig2")).unwrap().reference().error,
        0.0
    );
}

#[test]
fn friction_keeps_a_loop_together_that_diverges_without_it() {
    let mut scene = experiment("experiment2");
    scene.measure = Measure::Duration(1.24);
    let wild = run(&scene, MethodName::Basic);
    scene.device.point_mass_mut().unwrap().viscous_friction = 8.0;
    let tamed = run(&scene, MethodName::Basic);
    println!(
        "E {} without, {} with friction",
        error(&wild),
        error(&tamed)
    );
    assert_eq!((wild.diverged, tamed.diverged), (Some(true), Some(false)));
    assert!(tamed.force.peak_force < wild.force.peak_force);
}

#[test]
fn a_loop_with_friction_that_runs_away_is_seen_to() {
    let mut scene = experiment("experiment2");
    scene.device.point_mass_mut().unwrap().viscous_friction = 0.01;
    assert_eq!(run(&scene, MethodName::HfcrMod).diverged, Some(true));
}

#[test]
fn ledger_matches_bench_with_friction_tremor_and_force_limit() {
    let mut scene = in_a_hand();
    scene.device.point_mass_mut().unwrap().largest_force = Some(2.0);
    for method in MethodName::ALL {
        let run = run(&scene, method);
        let ledger = run.last().ledger;
        let bench = run.bench_port_work.unwrap();
        let turned_over = ledger.held_leak.absolute + ledger.original_leak.absolute + 1.0;
        assert!(
            (ledger.port_work - bench).abs() < 1e-10 * turned_over,
            "{method}: {} and {bench}",
            ledger.port_work
        );
        let held = run.ticks.iter().map(|tick| tick.held_force_on_object.abs());
        let strongest = held.fold(0.0, f64::max);
        assert!(strongest <= 2.0, "{method}: {strongest} N");
        // These keep their force below the limit, by the available energy or by a soft coupling.
        let is_weak = matches!(
            method,
            MethodName::ForceBounding | MethodName::EnergyTank | MethodName::VirtualCoupling
        );
        assert!(strongest == 2.0 || is_weak, "{method}: {strongest} N");
    }
}

#[test]
fn a_mirrored_hand_mirrors_the_run() {
    let mut scene = in_a_hand();
    mirrored(&scene);
    let hand = hand_of(&mut scene);
    hand.grip.as_mut().unwrap().intention = Intention::Recorded(recorded_swing(0.02));
    hand.release = Some(0.3);
    mirrored(&scene);
}

fn mirrored(scene: &Scene) {
    let mut mirrored = scene.clone();
    mirrored.contact.side = palpate_core::Side::Negative;
    let device = mirrored.device.point_mass_mut().unwrap();
    for value in [
        &mut mirrored.object.position,
        &mut mirrored.object.velocity,
        &mut mirrored.virtual_force,
        &mut device.position,
        &mut device.velocity,
        &mut device.hand.force,
    ] {
        *value = -*value;
    }
    let mirror = |wave: Wave| Wave {
        amplitude: -wave.amplitude,
        ..wave
    };
    if let Some(grip) = &mut device.hand.grip {
        grip.intention = match &grip.intention {
            Intention::Place { position, swing } => Intention::Place {
                position: -position,
                swing: swing.map(mirror),
            },
            Intention::Recorded(path) => Intention::Recorded(Arc::new(path.mirrored())),
        };
    }
    device.hand.tremor = device.hand.tremor.map(mirror);
    let (a, b) = (
        run(scene, MethodName::Hfcr),
        run(&mirrored, MethodName::Hfcr),
    );
    assert!(a.ticks.len() > 20);
    for (a, b) in a.ticks.iter().zip(&b.ticks) {
        assert_eq!(a.device_position, -b.device_position);
        assert_eq!(a.held_force_on_object, -b.held_force_on_object);
    }
    assert_eq!(error(&a), error(&b));
}

/// The recording of a swing about 0.03 m, 1 s at 1 kHz.
fn recorded_swing(amplitude: f64) -> Arc<RecordedPath> {
    let times: Vec<f64> = (0..=1000).map(|i| f64::from(i) * 1e-3).collect();
    let turn = std::f64::consts::TAU;
    let positions: Vec<f64> = times
        .iter()
        .map(|time| 0.03 + amplitude * (turn * time).sin())
        .collect();
    Arc::new(RecordedPath::new(&times, &positions).unwrap())
}

#[test]
fn a_recorded_intention_moves_the_hand_as_the_swing_that_was_recorded() {
    let swung = in_a_hand();
    let mut recorded = swung.clone();
    let intention = Intention::Recorded(recorded_swing(0.02));
    hand_of(&mut recorded).grip.as_mut().unwrap().intention = intention;
    for method in [MethodName::Basic, MethodName::Hfcr] {
        let (a, b) = (run(&swung, method), run(&recorded, method));
        println!("{method}: E {} swung, {} recorded", error(&a), error(&b));
        assert!((error(&a) / error(&b) - 1.0).abs() < 1e-3, "{method}");
        let far = |a: &Run, b: &Run| {
            let pairs = a.ticks.iter().zip(&b.ticks);
            pairs
                .map(|(a, b)| (a.true_device_position - b.true_device_position).abs())
                .fold(0.0, f64::max)
        };
        assert!(far(&a, &b) < 1e-5, "{method}: {}", far(&a, &b));
    }
    // Another recording is another hand.
    let intention = Intention::Recorded(recorded_swing(0.01));
    hand_of(&mut recorded).grip.as_mut().unwrap().intention = intention;
    assert!(
        (error(&run(&recorded, MethodName::Hfcr)) / error(&run(&swung, MethodName::Hfcr)) - 1.0)
            .abs()
            > 1e-3
    );
}

#[test]
fn hand_release_acts_on_loop_and_on_reference() {
    // The hand presses the device against a wall and releases it: the spring accelerates the free device away.
    let mut scene = experiment("wall");
    scene.measure = Measure::Duration(0.2);
    *hand_of(&mut scene) = Hand {
        grip: Some(Grip {
            mass: 0.05,
            stiffness: 100.0,
            damping: 4.0,
            intention: Intention::at(0.02),
        }),
        release: Some(0.1),
        ..Hand::default()
    };
    let bench = Bench::new(&scene).unwrap();
    let held = bench.run(MethodName::HfcrModSt).unwrap();
    let position = |time: f64| {
        let tick = held.ticks.iter().find(|tick| tick.time >= time - 1e-9);
        tick.unwrap().true_device_position
    };
    assert!(position(0.099) > 0.0, "pressed before");
    // Without a hand or friction the device flies straight on.
    let (a, b, c) = (position(0.15), position(0.17), position(0.19));
    assert!(b < a && (a - 2.0 * b + c).abs() < 1e-12, "{a} {b} {c}");
    let curve = &bench.reference().curve;
    let speed = |point: usize| {
        let (a, b) = (curve[point], curve[point + 1]);
        (b.device_position - a.device_position) / (b.time - a.time)
    };
    let (some, last) = (speed(curve.len() / 2 + 1000), speed(curve.len() - 2));
    assert!(
        (some / last - 1.0).abs() < 1e-9 && last < -0.05,
        "{some} {last}"
    );
    // The release of a constant-force hand also makes the ideal an integrated one.
    let mut scene = experiment("wall");
    scene.measure = Measure::Duration(0.1);
    hand_of(&mut scene).release = Some(0.0);
    let run = run(&scene, MethodName::Basic);
    assert_eq!(run.last().true_device_position, scene.device.position());
}

#[test]
fn every_method_is_better_than_no_force_in_a_damped_hand() {
    let scene = in_a_hand();
    for method in MethodName::ALL {
        let run = run(&scene, method);
        let fidelity = run.force.fidelity.unwrap();
        println!(
            "{method:16} E {:6.1} %, FRE/floor {:5.2}",
            fidelity.mean_force_error,
            fidelity.error_over_bound.unwrap()
        );
        assert_eq!(run.diverged, Some(false), "{method}");
    }
    assert!(error(&run(&scene, MethodName::Hfcr)) < 40.0);
}

#[test]
fn error_against_finer_loop_is_near_force_rendering_error() {
    let scene = experiment("experiment1");
    let run_of = |period: f64, method| {
        let mut scene = scene.clone();
        scene.loop_params.period = period;
        scene.measure = Measure::Duration(0.74);
        run(&scene, method)
    };
    let coarse = run_of(0.02, MethodName::HfcrModSt);
    assert_eq!(error_against(&coarse, &coarse), Some(0.0));
    // A loop at 20 kHz is near the ideal, so the error against it is near the FRE.
    let fine = run_of(0.000_05, MethodName::HfcrModSt);
    let against = error_against(&coarse, &fine).unwrap();
    let ideal = coarse.force.fidelity.unwrap().force_rendering_error;
    println!("{against} against 20 kHz, {ideal} against the ideal");
    assert!((against - ideal).abs() < 0.5, "{against} {ideal}");
    // A run that ends too early cannot be the reference.
    let mut short = scene.clone();
    short.measure = Measure::Duration(0.3);
    assert_eq!(
        error_against(&coarse, &run(&short, MethodName::Basic)),
        None
    );
}

#[test]
fn the_paper_s_experiments_run_on_the_virtual_pantograph() {
    // The paper's methods, and HFCR without leak dissipation.
    const METHODS: [MethodName; 6] = [
        MethodName::Basic,
        MethodName::Seh,
        MethodName::VirtualDamper,
        MethodName::PopcRef,
        MethodName::HfcrModSt,
        MethodName::Hfcr,
    ];
    for (name, point_mass, floor) in [
        ("fig4", "experiment1", 17.42),
        ("fig5", "experiment2", 34.92),
    ] {
        let scene = experiment(name);
        assert!((scene.device.mass() - 0.25).abs() < 1e-4, "effective mass");
        let bench = Bench::new(&scene).unwrap();
        let reference = bench.reference();
        assert!(reference.error < 1e-6, "{}", reference.error);
        assert_eq!(reference.leaves_box_at, None);
        let runs = METHODS.map(|method| bench.run(method).unwrap());
        for run in &runs {
            let fidelity = run.force.fidelity.unwrap();
            assert!((fidelity.hold_bound - floor).abs() < 0.02, "{fidelity:?}");
            println!(
                "{name} {:16} FRE {:6.1} %, left the box at {:?}",
                run.method, fidelity.force_rendering_error, run.left_box_at
            );
            // Who fails leaves the box, before the links come to their end.
            assert!(run.jammed_at.is_none() || run.left_box_at < run.jammed_at);
        }
        let least = runs.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
        assert_eq!(least.unwrap().method, MethodName::Hfcr, "{name}");
        let left: Vec<_> = runs
            .iter()
            .filter(|run| run.left_box_at.is_some())
            .map(|run| run.method)
            .collect();
        let failed: &[MethodName] = match name {
            "fig4" => &[],
            _ => &[MethodName::Seh, MethodName::VirtualDamper],
        };
        assert_eq!(left, failed, "{name}");
        if name == "fig5" {
            // It runs away only after the box has switched the motors off, which is not its doing.
            let run = bench.run(MethodName::HfcrMod).unwrap();
            assert!(run.left_box_at.is_some());
            assert_eq!(run.diverged, Some(false));
        }
        // The mechanism is near its point mass: the ideal collides within 2 ms of it.
        let free = experiment(point_mass);
        let free = Bench::new(&free).unwrap();
        let first = |bench: &Bench| bench.reference().profile.collisions()[0].start;
        assert!((first(&bench) - first(&free)).abs() < 2e-3);
    }
}

#[test]
fn in_the_second_experiment_the_timing_is_lost_after_three_collisions() {
    // The paper's 52.2 % for HFCR lies between the errors over three and over four collisions.
    let over = |collisions| {
        let mut scene = experiment("fig5");
        scene.measure = Measure::Collisions(collisions);
        let run = run(&scene, MethodName::Hfcr);
        run.force.fidelity.unwrap().force_rendering_error
    };
    let errors = [1, 3, 4, 6].map(over);
    println!("FRE of HFCR over the first 1, 3, 4 and 6 collisions: {errors:.1?} %");
    assert!(errors[0] < 46.0 && errors[1] < 46.0, "{errors:?}");
    assert!(errors[2] > 52.2 && errors[3] > 80.0, "{errors:?}");
}

#[test]
fn in_the_first_experiment_a_damper_is_good_in_a_narrow_valley_only() {
    let at = |damping: f64| {
        let mut scene = experiment("fig4");
        let settings = Settings::default().with(SettingKey::DAMPING, damping);
        scene.settings.insert(MethodName::VirtualDamper, settings);
        let run = run(&scene, MethodName::VirtualDamper);
        run.force.fidelity.unwrap().force_rendering_error
    };
    let (best, paper) = (at(0.56), 84.9);
    assert!(best < 25.0, "{best}");
    // Elsewhere it is about what the paper measured.
    for damping in [0.4, 0.8, 1.5, 3.0] {
        let error = at(damping);
        println!("B = {damping}: FRE {error:.1} %");
        assert!((error - paper).abs() < 9.0, "{damping}: {error}");
    }
}

#[test]
fn rebound_speeds_are_known_with_friction_and_a_hand() {
    // At a high rate every method parts as fast as the ideal, whatever the plant.
    for name in ["experiment1_in_a_hand", "fig4"] {
        let mut scene = experiment(name);
        scene.loop_params.period = 0.000_5;
        let run = run(&scene, MethodName::HfcrModSt);
        assert_eq!(run.rebounds.len(), 3, "{name}");
        assert!(run.energy.is_none(), "friction takes its share");
        for rebound in &run.rebounds {
            println!("{name}: {rebound:?}");
            assert!(rebound.error.unwrap().abs() < 0.01, "{name}: {rebound:?}");
        }
        // Friction and the hand show in the ideal itself.
        let (first, last) = (run.rebounds[0].ideal, run.rebounds[2].ideal);
        assert!((first / last - 1.0).abs() > 0.01, "{name}: {first} {last}");
    }
    // At 50 Hz the spring force throws the object back half as fast again.
    let rebounds = run(&experiment("fig4"), MethodName::Basic).rebounds;
    assert!(rebounds[0].error.unwrap() > 0.3, "{rebounds:?}");
}

/// A scene with a delay whose device is a point mass without friction, with the object on `side`.
fn point_mass(side: palpate_core::Side) -> Scene {
    let mut scene = experiment("experiment1");
    let sign: f64 = side.sign();
    scene.contact.side = side;
    scene.object.position *= sign;
    hand_of(&mut scene).force *= sign;
    scene.virtual_force *= sign;
    scene.delay = Delay::samples(1);
    scene.measure = Measure::Duration(1.0);
    scene
}

#[test]
fn a_device_of_the_callers_own_moves_as_the_scene_s_on_both_sides() {
    for side in [palpate_core::Side::Positive, palpate_core::Side::Negative] {
        let scene = point_mass(side);
        let own =
            palpate_testbed::device::PointMass::new(scene.device.mass(), scene.device.hand_force())
                .and_then(|device| {
                    device.starting_at(scene.device.position(), scene.device.velocity())
                })
                .unwrap();
        let bench = Bench::with_device(&scene, own).unwrap();
        assert!(bench.reference().error > 0.0, "its ideal is integrated");
        for method in [MethodName::Basic, MethodName::Coupled] {
            let (own, scenes) = (bench.run(method).unwrap(), run(&scene, method));
            assert_eq!(own.ticks, scenes.ticks);
            assert!(
                own.ticks
                    .iter()
                    .any(|tick| tick.held_force_on_object != 0.0)
            );
            assert!((error(&own) - error(&scenes)).abs() < 0.01);
        }
    }
}

#[test]
fn custom_method_gives_same_run_as_built_in_method() {
    let scene = point_mass(palpate_core::Side::Positive);
    let bench = Bench::new(&scene).unwrap();
    let params = palpate_core::CoupledParams::new(scene.device.mass());
    let own = bench.run_own(params).unwrap();
    let built_in = bench.run(MethodName::Coupled).unwrap();
    assert_eq!(own.ticks, built_in.ticks);
    assert_eq!(own.parameters, built_in.parameters);
    assert_eq!(
        own.method,
        palpate_study::sim::run::RunMethod::Own("coupled")
    );
}
