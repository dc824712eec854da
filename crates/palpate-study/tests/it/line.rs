//! Loops whose actuator holds a line.
#![allow(clippy::print_stdout)] // what was measured

use crate::common::{PAPER_SCENES, Random, scene as experiment};
use palpate_core::{
    Actuation, Contact, CoupledParams, Hold, LoopParams, ObjectState, Renderer, Sample,
};
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Delay, Scene, SetupError};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::metrics::{Fidelity, ForceEvaluation};

/// One of the paper's scenes, with `factor` times the mass in the model and a sensor of `quantum` `[m]`.
fn scene(name: &str, hold: Hold, factor: f64, quantum: f64) -> Scene {
    let mut scene = experiment(name);
    scene.loop_params.actuation.hold = hold;
    scene.method = MethodName::Coupled;
    scene.model_device_mass = Some(factor * scene.device.mass());
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
    for (factor, quantum, required) in cases {
        for (name, required) in PAPER_SCENES.into_iter().zip(required) {
            let [line, constant] = [Hold::Line, Hold::Constant].map(|hold| {
                let (fidelity, _) = rendered(&scene(name, hold, factor, quantum));
                fidelity.force_rendering_error
            });
            println!("{name}, factor {factor}, {quantum} m: {line} %, constant {constant} %");
            assert!(line < required && line < constant);
        }
    }
}

#[test]
fn a_line_passes_delays_gains_and_hands() {
    for (delay, gain) in [(1.0, 1.0), (0.4, 1.0), (1.7, 0.9)] {
        for name in PAPER_SCENES {
            let [line, constant] = [Hold::Line, Hold::Constant].map(|hold| {
                let mut scene = scene(name, hold, 1.0, 0.0);
                let period = scene.loop_params.period;
                scene.delay = Delay::Seconds(delay * period);
                scene.actuator = ActuatorParams { gain, lag: 0.0 };
                rendered(&scene).0
            });
            println!("{name}, {delay} periods, gain {gain}: {line:?}, constant {constant:?}");
            assert!(line.mean_force_error < 2.0);
            assert!(line.force_rendering_error < 0.45 * constant.force_rendering_error);
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

/// A plant and its model.
struct Plant {
    scene: PointMassScene,
    period: f64,
    collisions: usize,
    model_mass: f64,
    quantum: f64,
    /// Delay of whole samples, known.
    delay: usize,
}

impl Plant {
    /// Returns FRE `[%]` with each hold; none if the ideal has too few collisions.
    fn errors(&self) -> Option<[f64; 2]> {
        let ideal = Ideal::new(self.scene).unwrap();
        let count = ideal.window(self.collisions, self.period)?;
        let profile = ideal.profile(self.period, count).unwrap();
        let scene = &self.scene;
        Some([Hold::Constant, Hold::Line].map(|hold| {
            let contact = Contact::object(scene.stiffness, scene.object_mass);
            let loop_params = LoopParams {
                actuation: Actuation {
                    hold,
                    ..Actuation::after_samples(self.delay, self.period)
                },
                ..LoopParams::new(self.period)
            };
            let params = CoupledParams::new(self.model_mass).with_encoder_quantum(self.quantum);
            let renderer = Renderer::new(contact, loop_params, params).unwrap();
            let object = ObjectState::at_rest(scene.object_position);
            let mut state = renderer.start(object).unwrap();
            let mut device = PointMass::new(scene.device_mass, scene.user_force)
                .and_then(|device| device.starting_at(0.0, scene.device_velocity))
                .unwrap();
            let mut actuator = Actuator::default();
            let mut sent = vec![(0.0, 0.0); self.delay];
            for tick in 0..count {
                let mut position = device.position();
                if self.quantum > 0.0 {
                    position = (position / self.quantum).round() * self.quantum;
                }
                let sample = Sample::at(position).with_virtual_force(scene.virtual_force);
                let output = renderer.step(&mut state, sample);
                sent.push((output.force_on_object, -output.slope_on_device));
                let (force, slope) = sent[tick];
                actuator.drive_line(&mut device, force, slope, self.period);
            }
            let (means, slopes): (Vec<f64>, Vec<f64>) = sent[..count].iter().copied().unzip();
            let evaluated = match hold {
                Hold::Constant => ForceEvaluation::new(&means, &profile),
                Hold::Line => ForceEvaluation::of_lines(&means, &slopes, &profile),
            };
            let fidelity = evaluated.unwrap().fidelity.unwrap();
            fidelity.force_rendering_error
        }))
    }
}

/// Median, 90 % and largest.
fn spread(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    [values[last / 2], values[last * 9 / 10], values[last]]
}

#[test]
fn lines_are_nearer_than_constants_on_random_plants() {
    // Factor of the model mass, quantum, delay: largest median ratio, and largest fraction of worse plants.
    for (factor, quantum, delay, limits) in [
        (1.0, 0.0, 0, (0.25, 0.01)),
        (2.0, 0.0, 0, (0.25, 0.02)),
        (2.0, 1e-5, 0, (0.3, 0.05)),
        (2.0, 0.0, 1, (0.3, 0.07)),
        (2.0, 1e-5, 1, (0.4, 0.12)),
    ] {
        let mut random = Random(1);
        let mut log = |low: f64, high: f64| random.decades(low, high);
        let mut errors = Vec::new();
        while errors.len() < 400 {
            let (mass, period) = (log(0.05, 0.5), log(1e-3, 0.02));
            let stiffness = log(0.01, 2.0) * mass / (period * period);
            let is_wall = log(1.0, 10.0) < 2.0;
            let object_mass = stiffness * period * period / log(0.01, 3.0);
            let plant = Plant {
                scene: PointMassScene {
                    stiffness,
                    device_mass: mass,
                    object_mass: if is_wall { f64::INFINITY } else { object_mass },
                    user_force: log(0.3, 2.0),
                    virtual_force: if is_wall { 0.0 } else { -log(0.3, 1.5) },
                    device_position: 0.0,
                    device_velocity: log(0.01, 0.2),
                    object_position: log(0.002, 0.05),
                    object_velocity: 0.0,
                },
                period,
                collisions: 4,
                model_mass: mass * log(1.0 / factor, factor),
                quantum: if quantum > 0.0 {
                    log(1e-6, quantum)
                } else {
                    0.0
                },
                delay,
            };
            errors.extend(plant.errors());
        }
        let constant = spread(errors.iter().map(|[constant, _]| *constant));
        let line = spread(errors.iter().map(|[_, line]| *line));
        let ratio = spread(errors.iter().map(|[constant, line]| line / constant));
        let worse = errors.iter().filter(|[constant, line]| line > constant);
        let worse = worse.count() as f64 / errors.len() as f64;
        println!(
            "mass within {factor}, quantum to {quantum} m, delay {delay}: FRE constant {constant:.1?}, line {line:.1?}, \
             ratio {ratio:.2?}, worse on {:.1} %",
            100.0 * worse
        );
        assert!(ratio[0] < limits.0 && worse <= limits.1);
    }
}
