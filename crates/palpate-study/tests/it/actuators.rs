//! Actuators with a gain, a lag and late commands, and flexible devices. Compares the testbed's motion and evaluation
//! with independent computations, and tests the renderer's model values.
#![allow(clippy::print_stdout)] // what was measured

use crate::common::scene as experiment;
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Cogging, ContactFile, Delay, Model, Scene, Transmission};
use palpate_study::sim::VirtualDevice;
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;
use palpate_testbed::device::{DevicePlant, PointMass};

/// One of the paper's scenes with an actuator that is far from perfect.
fn real(name: &str, delay: f64, lag: f64, gain: f64, jitter: f64) -> Scene {
    let mut scene = experiment(name);
    let period = scene.loop_params.period;
    scene.delay = Delay::Seconds(delay * period);
    scene.timing.command_jitter = jitter * period;
    scene.timing.seed = 3;
    scene.actuator = ActuatorParams {
        gain,
        lag: lag * period,
    };
    scene
}

fn run(scene: &Scene, method: MethodName) -> Run {
    Bench::new(scene).unwrap().run(method).unwrap()
}

fn error(scene: &Scene, method: MethodName) -> f64 {
    let fidelity = run(scene, method).force.fidelity.unwrap();
    fidelity.mean_force_error
}

#[test]
fn a_perfect_actuator_that_is_stated_changes_no_bit() {
    for name in crate::common::PAPER_SCENES {
        let plain = experiment(name);
        let mut stated = plain.clone();
        stated.model = Model {
            delay: Some(0.0),
            lag: Some(0.0),
            gain: Some(1.0),
            delay_deviation: Some(0.0),
            ..Model::default()
        };
        for method in [MethodName::Coupled, MethodName::Hfcr] {
            let (a, b) = (run(&plain, method), run(&stated, method));
            assert_eq!(a.ticks, b.ticks);
            assert_eq!(a.force, b.force);
        }
    }
}

/// The force that acts is integrated here in 20 000 steps a period, from the commands alone.
#[test]
fn device_moves_under_delivered_force_and_its_means_are_evaluated() {
    for (name, delay, lag, gain, jitter) in [
        ("fig2", 0.0, 0.3, 1.0, 0.0),
        ("fig2", 1.37, 0.0, 0.93, 0.0),
        ("experiment1", 0.5, 0.4, 1.05, 0.0),
        ("experiment2", 0.2, 0.15, 1.0, 0.4),
    ] {
        let scene = real(name, delay, lag, gain, jitter);
        let bench = Bench::new(&scene).unwrap();
        let run = bench.run(MethodName::Hfcr).unwrap();
        let period = scene.loop_params.period;
        let steps = 20_000_u32;
        let step = period / f64::from(steps);
        let mut device = PointMass::new(scene.device.mass(), scene.device.hand_force()).unwrap();
        let grid = bench.reference().profile.grid();
        let mut impulses = vec![0.0; grid.intervals()];
        let (mut interval, mut force, mut work) = (0, 0.0, 0.0);
        let mut arrivals = run
            .ticks
            .iter()
            .filter_map(|tick| Some((tick.command_from?, tick.output.force_on_object)))
            .peekable();
        let mut command = 0.0;
        let mut samples = run.ticks.iter().peekable();
        let total = (grid.end() / step).round();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        for number in 0..total as u64 {
            let time = number as f64 * step;
            if let Some(tick) = samples.next_if(|tick| tick.time <= time + 1e-3 * step) {
                let away = (tick.true_device_position - device.position()).abs();
                assert!(away < 1e-5, "{name}: {away} m at {time} s");
            }
            while let Some((_, sent)) = arrivals.next_if(|(from, _)| *from <= time + 0.5 * step) {
                command = sent;
            }
            let aim = gain * command;
            let time_constant = lag * period;
            let mean = if time_constant > 0.0 {
                let kept = (-step / time_constant).exp();
                let before = force;
                force = aim + (force - aim) * kept;
                0.5 * (before + force)
            } else {
                force = aim;
                aim
            };
            work += device.advance(mean, step);
            while time + 0.5 * step > grid.edge(interval + 1) {
                interval += 1;
            }
            impulses[interval] += mean * step;
        }
        let peak = run.force.peak_force;
        for (interval, held) in run.held.iter().enumerate() {
            let mean = impulses[interval] / grid.duration(interval);
            let away = (held.force_on_object - mean).abs();
            // An edge lies within a step.
            let allowed = 4.0 * peak * step / grid.duration(interval);
            assert!(
                away <= allowed,
                "{name}, interval {interval}: {mean} {held:?}"
            );
        }
        let bench_work = run.bench_port_work.unwrap();
        assert!((bench_work - work).abs() < 1e-3 * (1.0 + work.abs()));
        let f = run.force.fidelity.unwrap();
        let sum = f.hold_bound.powi(2) + f.mean_force_error.powi(2);
        assert!((f.force_rendering_error.powi(2) / sum - 1.0).abs() < 1e-9);
    }
}

#[test]
fn unmodelled_gain_causes_force_error() {
    let mut scene = real("fig2", 0.0, 0.0, 0.9, 0.0);
    let model = error(&scene, MethodName::Coupled);
    scene.model.gain = Some(1.0);
    let unmodelled = error(&scene, MethodName::Coupled);
    println!("gain .9 told {model:.2} %, untold {unmodelled:.2} %");
    assert!(model < 1.0 && unmodelled > 5.0);
}

#[test]
fn true_model_delay_and_lag_cut_coupled_error_tenfold() {
    for name in ["fig2", "experiment1"] {
        let mut scene = real(name, 0.5, 0.3, 1.0, 0.0);
        let truth = error(&scene, MethodName::Coupled);
        scene.model = Model {
            delay: Some(0.0),
            lag: Some(0.0),
            ..Model::default()
        };
        let nothing = error(&scene, MethodName::Coupled);
        println!("{name}: told the truth {truth:.2} %, nothing {nothing:.2} %");
        assert!(truth < 0.1 * nothing);
        // A delay in fractions of a period is unmodelled.
        let mut fraction = real(name, 0.0, 0.0, 1.0, 0.0);
        fraction.delay = Delay::Periods {
            samples: 0,
            fraction: 0.5,
        };
        let seconds = real(name, 0.5, 0.0, 1.0, 0.0);
        let (fraction, seconds) = (
            error(&fraction, MethodName::Coupled),
            error(&seconds, MethodName::Coupled),
        );
        println!("{name}: half a period as a fraction {fraction:.2} %, in seconds {seconds:.2} %");
        assert!(seconds < 0.1 * fraction);
    }
}

/// Model values do not affect the loop of a method that ignores the actuator.
#[test]
fn model_delay_and_lag_leave_delivered_force_of_basic_unchanged() {
    let mut scene = real("experiment1", 0.5, 0.3, 0.95, 0.1);
    let bench = Bench::new(&scene).unwrap();
    let before = bench.run(MethodName::Basic).unwrap();
    let mut model = scene.clone();
    model.model = Model {
        delay: Some(0.01),
        lag: Some(0.0),
        ..Model::default()
    };
    let varied = bench.run_varied(&model, MethodName::Basic).unwrap();
    assert_eq!(varied.held, before.held);
    scene.model = model.model;
    assert_eq!(run(&scene, MethodName::Basic).held, before.held);
}

/// A motor's limit cuts what is sent; its gain comes after.
#[test]
fn a_limit_is_of_the_command_and_the_gain_of_what_is_given() {
    let mut scene = real("fig2", 0.0, 0.0, 1.2, 0.0);
    scene.device.point_mass_mut().unwrap().largest_force = Some(2.0);
    let run = run(&scene, MethodName::Hfcr);
    println!("peak {}", run.force.peak_force);
    assert!((run.force.peak_force - 2.4).abs() < 1e-12);
    let mut device = VirtualDevice::new(&scene).unwrap();
    assert_eq!(device.given_force(5.0), 2.0);
    let work = device.hold(5.0, 0.01);
    assert!((work - 2.4 * (device.position() - scene.device.position())).abs() < 1e-15);
}

fn flexible() -> Scene {
    let mut scene = experiment("experiment1");
    scene.device.point_mass_mut().unwrap().transmission = Some(Transmission {
        resonance_hz: 150.0,
        damping_ratio: 0.03,
        motor_share: 0.6,
        backlash: 0.0,
    });
    scene.device.point_mass_mut().unwrap().cogging = Some(Cogging {
        amplitude: 0.05,
        pitch: 0.005,
    });
    scene
}

#[test]
fn a_flexible_device_has_an_ideal_of_its_own_and_a_stiff_one_that_of_the_point_mass() {
    let plain = experiment("experiment1");
    let mut stiff = flexible();
    stiff.device.point_mass_mut().unwrap().cogging = None;
    if let Some(transmission) = &mut stiff.device.point_mass_mut().unwrap().transmission {
        transmission.resonance_hz = 4000.0;
    }
    let (a, b) = (Bench::new(&plain).unwrap(), Bench::new(&stiff).unwrap());
    let (a, b) = (&a.reference().profile, b.reference());
    println!("ideal of the stiff transmission: error {:.1e}", b.error);
    assert!(b.error < 1e-3);
    let peak = a.impulses().iter().fold(0.0_f64, |most, j| most.max(*j));
    for (one, other) in a.impulses().iter().zip(b.profile.impulses()) {
        assert!((one - other).abs() < 0.02 * peak, "{one} {other}");
    }
    let scene = flexible();
    let bench = Bench::new(&scene).unwrap();
    println!("at 150 Hz: error {:.1e}", bench.reference().error);
    assert!(bench.reference().error < 1e-3);
    let coupled = bench.run(MethodName::Coupled).unwrap();
    let e = coupled.force.fidelity.unwrap().mean_force_error;
    println!("coupled on it: E {e:.2} %");
    assert!(e > 0.1 && e < 100.0);
}

/// The wall on half of a device, with a resonance of 100 Hz, without and with a model of it.
fn model_flexible(stiffness: f64, period: f64) -> [Scene; 2] {
    let mut unmodelled = experiment("coupled/flexible");
    unmodelled.contact.stiffness = stiffness;
    unmodelled.loop_params.period = period;
    let mut model = unmodelled.clone();
    model.model.transmission = Some(palpate_core::Transmission {
        resonance: 100.0,
        damping_ratio: 0.03,
        flexible_mass_fraction: 0.5,
    });
    [unmodelled, model]
}

/// The contact is at 0.7 of the resonance: beyond what the resonance allows a renderer that knows no transmission.
#[test]
fn transmission_model_enables_stiff_wall_on_flexible_device() {
    let [unmodelled, model] =
        model_flexible(19_344.0, 1e-3).map(|scene| error(&scene, MethodName::Coupled));
    println!("E: untold {unmodelled:.2} %, told {model:.2} %");
    assert!(model < 2.0 && unmodelled > 10.0);
}

/// With twenty samples in a period of the resonance or more, one mass does better, so that is what is taken.
#[test]
fn transmission_model_with_slow_resonance_changes_nothing() {
    for period in [5e-4, 2.5e-4] {
        let [unmodelled, model] =
            model_flexible(9870.0, period).map(|scene| run(&scene, MethodName::Coupled));
        assert_eq!(unmodelled.ticks, model.ticks);
    }
}

#[test]
fn noise_is_what_the_sensor_adds_and_follows_from_the_seed() {
    let mut scene = experiment("fig2");
    scene.device.point_mass_mut().unwrap().noise = 2e-5;
    let first = run(&scene, MethodName::Hfcr);
    assert_eq!(first.ticks, run(&scene, MethodName::Hfcr).ticks);
    scene.timing.seed = 1;
    assert_ne!(first.ticks, run(&scene, MethodName::Hfcr).ticks);
    let squares: f64 = (first.ticks.iter())
        .map(|tick| (tick.device_position - tick.true_device_position).powi(2))
        .sum();
    let deviation = (squares / first.ticks.len() as f64).sqrt();
    println!("deviation {deviation} m");
    assert!((deviation / 2e-5 - 1.0).abs() < 0.3);
}

#[test]
fn a_scene_of_all_of_it_reads_back_from_its_file_to_the_same_run() {
    let mut scene = flexible();
    scene.delay = Delay::Seconds(0.0123);
    scene.timing.command_jitter = 1e-3;
    scene.timing.seed = 11;
    scene.actuator = ActuatorParams {
        gain: 0.97,
        lag: 0.002,
    };
    scene.model = Model {
        delay: Some(0.013),
        delay_deviation: Some(1e-4),
        lag: Some(0.0021),
        lag_deviation: Some(2e-4),
        gain: Some(1.01),
        gain_deviation: Some(0.02),
        sensor_quantum: Some(2e-6),
        sensor_noise: Some(5e-6),
        transmission: None,
    };
    scene.device.point_mass_mut().unwrap().noise = 1e-6;
    if let Some(transmission) = &mut scene.device.point_mass_mut().unwrap().transmission {
        transmission.backlash = 2e-5;
    }
    let text = scene.to_toml().unwrap();
    let read = ContactFile::parse("real.toml", &text).unwrap().scene;
    assert_eq!(read, scene, "{text}");
    let (a, b) = (
        run(&read, MethodName::Coupled),
        run(&scene, MethodName::Coupled),
    );
    assert_eq!(a.ticks, b.ticks);
}
