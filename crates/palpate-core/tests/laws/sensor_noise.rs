//! Coupled rendering with sensor errors beyond the model quantum.

use palpate_core::{
    Contact, CoupledMemory, CoupledParams, LoopParams, ObjectState, Renderer, Sample, State,
};

use crate::common::{PointMass, Random};

const PERIOD: f64 = 0.001;

/// Returns an approximately normal number of deviation 1.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0
}

/// Returns the forces on a block that a device meets after `free` samples of free motion, and the renderer's estimate.
/// The sensor has noise of this standard deviation `[m]` and the model value `quantum` `[m]`.
fn met(
    free: u32,
    noise: f64,
    quantum: f64,
    seed: u64,
) -> (Vec<f64>, State<f64, CoupledMemory<f64>>) {
    let params = CoupledParams::new(0.2).with_encoder_quantum(quantum);
    let contact = Contact::object(20_000.0, 0.3);
    let renderer = Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let mut random = Random(seed);
    let time = f64::from(free) * PERIOD;
    let mut device = PointMass {
        mass: 0.2,
        user_force: 0.1,
        velocity: 0.3,
        position: -0.3 * time - 0.25 * time * time,
    };
    let mut forces = Vec::new();
    for _ in 0..free + 30 {
        let position = device.position + noise * normal(&mut random);
        let output = renderer.step(&mut state, Sample::at(position));
        assert_eq!(output.fault, None);
        forces.push(output.force_on_object);
        device.hold(output.force_on_device, PERIOD);
    }
    (forces, state)
}

fn off(a: &[f64], b: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    let all: f64 = b.iter().map(|b| b * b).sum();
    (square / all).sqrt()
}

#[test]
fn noise_estimated_in_free_motion_acts_like_its_model_value() {
    let noise = 5e-6;
    let model = noise * 12_f64.sqrt();
    for seed in 1..=5 {
        let (exact, _) = met(500, 0.0, 0.0, seed);
        let (knows, _) = met(500, noise, model, seed);
        let (finds, state) = met(500, noise, 0.0, seed);
        let found = state.memory().sensor_noise();
        assert!((0.8..1.1).contains(&(found / noise)), "{found:e}");
        println!(
            "{seed}: told {:.4}, found {:.4}, apart {:.4}",
            off(&knows, &exact),
            off(&finds, &exact),
            off(&finds, &knows)
        );
        assert!(off(&finds, &knows) < 0.01, "{}", off(&finds, &knows));
    }
}

#[test]
fn sensor_noise_estimate_matches_absent_and_modelled_noise() {
    let (_, state) = met(500, 0.0, 0.0, 1);
    let found = state.memory().sensor_noise();
    assert!(found < 1e-12, "{found:e}");
    let noise = 5e-6;
    let (_, state) = met(500, noise, 12_f64.sqrt() * noise, 1);
    let found = state.memory().sensor_noise();
    assert!((0.8..1.1).contains(&(found / noise)), "{found:e}");
}
