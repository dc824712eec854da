//! Scenes whose device has friction or is held by a hand of its own.
#![allow(clippy::print_stdout)] // what was measured

mod common;

use std::sync::Arc;

use common::scene as experiment;
use palpate_sim::closed_loop::{Bench, error_against};
use palpate_sim::method::MethodName;
use palpate_sim::run::Run;
use palpate_sim::scene::{Grip, Measure, Scene, Wave};
use palpate_testbed::recorded_path::RecordedPath;

fn run(scene: &Scene, method: MethodName) -> Run {
    Bench::new(scene).unwrap().run(method).unwrap()
}

fn error(run: &Run) -> f64 {
    run.force.fidelity.unwrap().mean_force_error
}

fn in_a_hand() -> Scene {
    let mut scene = experiment("experiment1");
    scene.device.viscous_friction = 0.2;
    scene.device.coulomb_friction = 0.02;
    scene.user_force = 0.0;
    scene.grip = Some(Grip {
        mass: 0.1,
        stiffness: 60.0,
        damping: 1.0,
        position: 0.03,
        swing: Some(Wave {
            amplitude: 0.02,
            frequency_hz: 1.0,
        }),
        intention: None,
    });
    scene.tremor = Some(Wave {
        amplitude: 0.1,
        frequency_hz: 8.0,
    });
    scene
}

#[test]
fn a_trace_of_friction_changes_the_judgement_by_a_trace() {
    // The exact ideal and the integrated one meet where friction vanishes.
    for name in ["fig2", "experiment1"] {
        let free = experiment(name);
        let mut rough = free.clone();
        rough.device.viscous_friction = 1e-7;
        for method in [MethodName::Hfcr, MethodName::VirtualDamper] {
            let (a, b) = (run(&free, method), run(&rough, method));
            let (floor_a, floor_b) = (
                a.force.fidelity.unwrap().hold_floor,
                b.force.fidelity.unwrap().hold_floor,
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
    scene.device.viscous_friction = 8.0;
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
    scene.device.viscous_friction = 0.01;
    assert_eq!(run(&scene, MethodName::HfcrMod).diverged, Some(true));
}

#[test]
fn books_balance_against_the_bench_with_friction_hand_tremor_and_a_weak_motor() {
    let mut scene = in_a_hand();
    scene.device.largest_force = Some(2.0);
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
        assert_eq!(strongest, 2.0, "{method}: the motor's limit acts");
    }
}

#[test]
fn a_mirrored_hand_mirrors_the_run() {
    let mut scene = in_a_hand();
    mirrored(&scene);
    let grip = scene.grip.as_mut().unwrap();
    grip.swing = None;
    grip.intention = Some(recorded_swing(0.02));
    scene.release = Some(0.3);
    mirrored(&scene);
}

fn mirrored(scene: &Scene) {
    let mut mirrored = scene.clone();
    mirrored.contact.side = palpate::Side::Negative;
    for value in [
        &mut mirrored.object.position,
        &mut mirrored.object.velocity,
        &mut mirrored.virtual_force,
        &mut mirrored.device.position,
        &mut mirrored.device.velocity,
    ] {
        *value = -*value;
    }
    if let Some(grip) = &mut mirrored.grip {
        grip.position = -grip.position;
        grip.swing = grip.swing.map(|wave| Wave {
            amplitude: -wave.amplitude,
            ..wave
        });
        grip.intention = grip
            .intention
            .as_ref()
            .map(|path| Arc::new(path.mirrored()));
    }
    mirrored.tremor = mirrored.tremor.map(|wave| Wave {
        amplitude: -wave.amplitude,
        ..wave
    });
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
    let grip = recorded.grip.as_mut().unwrap();
    grip.swing = None;
    grip.intention = Some(recorded_swing(0.02));
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
    recorded.grip.as_mut().unwrap().intention = Some(recorded_swing(0.01));
    assert!(
        (error(&run(&recorded, MethodName::Hfcr)) / error(&run(&swung, MethodName::Hfcr)) - 1.0)
            .abs()
            > 1e-3
    );
}

#[test]
fn a_hand_lets_go_of_the_loop_and_of_its_ideal() {
    // Pressed to a wall, then let go: the spring throws the device off, and nothing holds it.
    let mut scene = experiment("wall");
    scene.measure = Measure::Duration(0.2);
    scene.grip = Some(Grip {
        mass: 0.05,
        stiffness: 100.0,
        damping: 4.0,
        position: 0.02,
        ..Grip::default()
    });
    scene.user_force = 0.0;
    scene.release = Some(0.1);
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
    // A hand of a constant force lets go, too, and then the ideal is integrated.
    let mut scene = experiment("wall");
    scene.measure = Measure::Duration(0.1);
    scene.release = Some(0.0);
    let run = run(&scene, MethodName::Basic);
    assert_eq!(run.last().true_device_position, scene.device.position);
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
            fidelity.error_over_floor.unwrap()
        );
        assert_eq!(run.diverged, Some(false), "{method}");
    }
    assert!(error(&run(&scene, MethodName::Hfcr)) < 40.0);
}

#[test]
fn a_loop_is_judged_against_another_by_the_forces_both_held() {
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
    // One that ends too early cannot judge.
    let mut short = scene.clone();
    short.measure = Measure::Duration(0.3);
    assert_eq!(
        error_against(&coarse, &run(&short, MethodName::Basic)),
        None
    );
}

#[test]
fn the_paper_s_experiments_run_on_the_virtual_pantograph() {
    for (name, point_mass, best, floor) in [
        ("fig4", "experiment1", MethodName::HfcrModSt, 17.0),
        ("fig5", "experiment2", MethodName::Hfcr, 34.0),
    ] {
        let scene = experiment(name);
        assert!((scene.device.mass - 0.25).abs() < 0.005, "effective mass");
        let bench = Bench::new(&scene).unwrap();
        assert!(
            bench.reference().error < 1e-6,
            "{}",
            bench.reference().error
        );
        // In the second experiment most methods drive the linkage to the end of its reach.
        let jammed = |method| bench.run(method).unwrap().jammed_at;
        assert_eq!(jammed(MethodName::Hfcr), None, "{name}");
        assert_eq!(jammed(MethodName::HfcrModSt), None, "{name}");
        assert_eq!(jammed(MethodName::Basic).is_some(), name == "fig5");
        let errors: Vec<_> = MethodName::ALL
            .into_iter()
            .map(|method| {
                let run = bench.run(method).unwrap();
                let fidelity = run.force.fidelity.unwrap();
                assert!((fidelity.hold_floor - floor).abs() < 0.1, "{fidelity:?}");
                println!(
                    "{name} {method:16} FRE {:6.1} %",
                    fidelity.force_rendering_error
                );
                (fidelity.mean_force_error, method)
            })
            .collect();
        let least = errors.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        // hfcr with b = 0 is the same method on the first of them.
        let with = |wanted| {
            errors
                .iter()
                .find(|(_, method)| *method == wanted)
                .unwrap()
                .0
        };
        assert_eq!(least.0, with(best), "{name}: {least:?}");
        // The mechanism is near its point mass: the ideal collides within 2 ms of it.
        let free = experiment(point_mass);
        let free = Bench::new(&free).unwrap();
        let first = |bench: &Bench| bench.reference().profile.collisions()[0].start;
        assert!((first(&bench) - first(&free)).abs() < 2e-3);
    }
}
