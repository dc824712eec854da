//! Loops whose actuator holds a line.
#![allow(clippy::print_stdout)] // what was measured

use crate::common::{PAPER_SCENES, scene as experiment};
use palpate_core::Hold;
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Delay, Scene, SetupError};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_testbed::metrics::Fidelity;

/// One of the paper's scenes, told `told` times the mass, with a sensor of `quantum` `[m]`.
fn scene(name: &str, hold: Hold, told: f64, quantum: f64) -> Scene {
    let mut scene = experiment(name);
    scene.loop_params.actuation.hold = hold;
    scene.method = MethodName::Coupled;
    scene.model_device_mass = Some(told * scene.device.mass());
    scene.device.point_mass_mut().unwrap().encoder_quantum = quantum;
    scene
}

fn rendered(scene: &Scene) -> (Fidelity, f64) {
    let run = Bench::new(scene).unwrap().run(MethodName::Coupled).unwrap();
    let off = run.bench_port_work.unwrap() - run.last().ledger.port_work;
    (run.force.fidelity.unwrap(), off)
}

#[test]
fn a_known_device_gets_the_best_lines_on_the_papers_scenes() {
    for (name, floor) in PAPER_SCENES.into_iter().zip([1.49, 2.93, 10.45]) {
        let (fidelity, off) = rendered(&scene(name, Hold::Line, 1.0, 0.0));
        println!("{name}: {fidelity:?}, work off by {off} J");
        assert!((fidelity.hold_bound - floor).abs() < 0.005);
        assert!(fidelity.mean_force_error < 0.03);
        assert!((fidelity.force_rendering_error - floor).abs() < 0.005);
        // The ledger has the work that the bench integrates.
        assert!(off.abs() < 1e-6);
    }
}

#[test]
fn a_wrong_mass_or_a_coarse_sensor_costs_little_and_never_more_than_a_constant_hold() {
    let cases = [
        (1.5, 0.0, [1.6, 3.2, 25.0]),
        (0.6, 0.0, [1.6, 3.2, 25.0]),
        (1.0, 1e-5, [1.55, 2.95, 10.65]),
        (1.5, 1e-5, [1.6, 3.2, 25.0]),
    ];
    for (told, quantum, required) in cases {
        for (name, required) in PAPER_SCENES.into_iter().zip(required) {
            let [line, constant] = [Hold::Line, Hold::Constant].map(|hold| {
                let (fidelity, _) = rendered(&scene(name, hold, told, quantum));
                fidelity.force_rendering_error
            });
            println!("{name}, told {told}, {quantum} m: {line} %, constant {constant} %");
            assert!(line < required && line < constant);
        }
    }
}

#[test]
fn a_line_passes_delays_gains_and_hands() {
    for (delay, gain) in [(1.0, 1.0), (0.4, 1.0), (1.7, 0.9)] {
        for (name, floor) in PAPER_SCENES.into_iter().zip([1.6, 3.2, 12.0]) {
            let mut scene = scene(name, Hold::Line, 1.0, 0.0);
            let period = scene.loop_params.period;
            scene.delay = Delay::Seconds(delay * period);
            scene.actuator = ActuatorParams { gain, lag: 0.0 };
            let (fidelity, _) = rendered(&scene);
            println!("{name}, {delay} periods, gain {gain}: {fidelity:?}");
            assert!(fidelity.hold_bound < floor && fidelity.mean_force_error < 2.0);
        }
    }
    let mut held = scene("experiment1", Hold::Line, 1.5, 0.0);
    let device = held.device.point_mass_mut().unwrap();
    device.viscous_friction = 0.2;
    device.coulomb_friction = 0.02;
    let mut constant = held.clone();
    constant.loop_params.actuation.hold = Hold::Constant;
    let [line, constant] = [&held, &constant].map(rendered);
    println!("friction: {line:?}, constant {constant:?}");
    assert!(line.0.force_rendering_error < 0.4 * constant.0.force_rendering_error);
}

#[test]
fn a_motor_limit_bounds_the_ends_of_a_line() {
    let mut scene = scene("experiment2", Hold::Line, 1.0, 0.0);
    scene.device.point_mass_mut().unwrap().largest_force = Some(4.0);
    let run = Bench::new(&scene)
        .unwrap()
        .run(MethodName::Coupled)
        .unwrap();
    let mut sloped = 0;
    for held in &run.held {
        let end = held.force_on_object.abs()
            + 0.5 * scene.loop_params.period * held.slope_on_object.abs();
        assert!(end <= 4.0 * (1.0 + 1e-12), "{held:?}");
        sloped += u32::from(held.slope_on_object != 0.0);
    }
    assert!(sloped > 10 && run.force.peak_force <= 4.0 * (1.0 + 1e-12));
}

#[test]
fn what_a_line_excludes_is_refused() {
    let line = scene("fig2", Hold::Line, 1.0, 0.0);
    let bench = Bench::new(&line).unwrap();
    for method in MethodName::ALL {
        if method != MethodName::Coupled {
            let error = bench.run(method).unwrap_err();
            assert_eq!(error, LoopError::Setup(SetupError::HoldsConstant(method)));
        }
    }
    let refused = |scene: &Scene| Bench::new(scene).unwrap_err().to_string();
    let mut lag = line.clone();
    lag.actuator.lag = 1e-3;
    assert_eq!(
        refused(&lag),
        "loop.lag_s is 0.001 s, but must be 0 with loop.hold = \"line\""
    );
    let mut jitter = line.clone();
    jitter.timing.command_jitter = 1e-3;
    assert!(refused(&jitter).starts_with("loop.command_jitter_s is 0.001 s"));
    let mut slew = line;
    slew.loop_params.slew_limit = Some(100.0);
    assert!(refused(&slew).contains("absent with a line hold"));
}
