//! Random plants of desktop devices.

use super::PlantParams;

/// Properties of a random plant besides mass, motor, delay and sensor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kind {
    pub friction: bool,
    pub hand: bool,
    pub resonance: bool,
}

/// A random plant: masses of 0.08 to 0.4 kg, delays of 0 to 1.6 periods, lags of 0 to 0.5 ms.
pub fn draw(kind: Kind, period: f64, quantum: f64, seed: u64) -> PlantParams {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut even = |from: f64, to: f64| from + (to - from) * random.f64();
    let mass = even(0.08_f64.ln(), 0.4_f64.ln()).exp();
    let mut plant = PlantParams {
        delay: even(0.0, 1.6),
        jitter: even(0.0, 0.1),
        lag: even(0.0, 5e-4),
        gain: even(0.9, 1.1),
        viscous: even(0.0, 0.5),
        quantum,
        ..PlantParams::bare(period, mass)
    };
    if kind.friction {
        plant.coulomb = even(0.02, 0.2);
        plant.cogging = even(0.0, 0.1);
        plant.pitch = even(0.002, 0.01);
    }
    if kind.hand {
        plant.hand_mass = even(0.0, 0.15);
        plant.hand_stiffness = even(0.0, 300.0);
        plant.hand_damping = even(0.5, 5.0);
        plant.drift = even(0.02, 0.1);
        plant.tremor = even(0.05, 0.2);
        plant.tremor_frequency = even(8.0, 12.0);
        if plant.hand_stiffness < 50.0 {
            plant.drift *= 0.4;
        }
    }
    if kind.resonance {
        let (hertz, damping, fraction) = (even(80.0, 300.0), even(0.02, 0.06), even(0.3, 0.6));
        plant.flexible(hertz, damping, fraction);
    }
    plant
}
