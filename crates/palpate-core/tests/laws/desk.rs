//! A desktop device with a non-ideal actuator, and the error of a rendered force relative to the ideal one. Computed in
//! fine steps, independent of the renderer.

use palpate_core::{AnyParams, Contact, LoopParams, Mass, ObjectState, Renderer, Sample};

/// A plant: true device, hand, contact and actuator.
#[derive(Clone, Copy, Debug)]
pub struct Desk {
    pub device_mass: f64,
    pub stiffness: f64,
    /// Infinite for a wall.
    pub object_mass: f64,
    /// Constant push on the device `[N]`.
    pub push: f64,
    /// Stiffness `[N/m]` and damping `[N s/m]` of a hand whose rest position is the device's initial one.
    pub hand: (f64, f64),
    pub gap: f64,
    pub period: f64,
    pub quantum: f64,
    /// Delay and lag in seconds, and the gain.
    pub delay: f64,
    pub lag: f64,
    pub gain: f64,
    /// Largest addition to the delay, drawn for each command `[s]`.
    pub jitter: f64,
    /// Largest force of the motor `[N]`.
    pub clip: f64,
}

/// Fine steps per period.
const STEPS: usize = 200;
const GRAVITY: f64 = 9.81;

struct Bodies {
    device: [f64; 2],
    object: [f64; 2],
}

impl Desk {
    fn start(&self) -> Bodies {
        Bodies {
            device: [0.0; 2],
            object: [self.gap, 0.0],
        }
    }

    fn object_mobility(&self) -> f64 {
        1.0 / self.object_mass
    }

    fn weight(&self) -> f64 {
        if self.object_mass.is_finite() {
            -GRAVITY * self.object_mass
        } else {
            0.0
        }
    }

    fn hand_force(&self, x: f64, v: f64) -> f64 {
        self.push - self.hand.0 * x - self.hand.1 * v
    }

    /// Returns the ideal force in fine steps: device and object under the contact itself.
    pub fn ideal(&self, periods: usize) -> Vec<f64> {
        let fine = 8;
        let dt = self.period / (STEPS * fine) as f64;
        let mut at = self.start();
        let force = |at: &Bodies| self.stiffness * (at.device[0] - at.object[0]).max(0.0);
        let mut forces = Vec::with_capacity(periods * STEPS);
        let [theta, mu] = [1.0 / self.device_mass, self.object_mobility()];
        let object_acceleration = |f: f64| mu * f + if mu > 0.0 { -GRAVITY } else { 0.0 };
        for _ in 0..periods * STEPS {
            let mut impulse = 0.0;
            for _ in 0..fine {
                let f = force(&at);
                at.device[1] +=
                    0.5 * dt * theta * (self.hand_force(at.device[0], at.device[1]) - f);
                at.object[1] += 0.5 * dt * object_acceleration(f);
                at.device[0] += dt * at.device[1];
                at.object[0] += dt * at.object[1];
                let g = force(&at);
                at.device[1] +=
                    0.5 * dt * theta * (self.hand_force(at.device[0], at.device[1]) - g);
                at.object[1] += 0.5 * dt * object_acceleration(g);
                impulse += 0.5 * (f + g) * dt;
            }
            forces.push(impulse / (dt * fine as f64));
        }
        forces
    }

    /// Returns the force on the object that reaches the device with this method, in fine steps.
    pub fn rendered(
        &self,
        loop_params: LoopParams<f64>,
        params: AnyParams<f64>,
        periods: usize,
        seed: u64,
    ) -> Vec<f64> {
        let contact = Contact {
            object_mass: if self.object_mass.is_finite() {
                Mass::Finite(self.object_mass)
            } else {
                Mass::Infinite
            },
            ..Contact::wall(self.stiffness)
        };
        let renderer = Renderer::new(contact, loop_params, params).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(self.gap)).unwrap();
        let mut random = Random(seed);
        let dt = self.period / STEPS as f64;
        let mut at = self.start();
        let mut commands: Vec<(f64, f64)> = vec![(f64::NEG_INFINITY, 0.0)];
        let (mut acting, mut felt) = (0, 0.0);
        let mut forces = Vec::with_capacity(periods * STEPS);
        for i in 0..periods {
            let position = if self.quantum > 0.0 {
                (at.device[0] / self.quantum).round() * self.quantum
            } else {
                at.device[0]
            };
            let sample = Sample::at(position).with_virtual_force(self.weight());
            let output = renderer.step(&mut state, sample);
            assert_eq!(output.fault, None);
            let sent = output.force_on_object.clamp(-self.clip, self.clip);
            renderer.report_sent(&mut state, sent);
            let begins = i as f64 * self.period + self.delay + self.jitter * random.uniform();
            commands.push((begins, self.gain * sent));
            for j in 0..STEPS {
                let from = i as f64 * self.period + j as f64 * dt;
                // Mean of the commands in the step.
                let (mut mean, mut begin) = (0.0, from);
                while acting + 1 < commands.len() && commands[acting + 1].0 < from + dt {
                    let next = commands[acting + 1].0.max(begin);
                    mean += commands[acting].1 * (next - begin);
                    begin = next;
                    acting += 1;
                }
                mean = (mean + commands[acting].1 * (from + dt - begin)) / dt;
                let given = if self.lag > 0.0 {
                    let decayed = (-dt / self.lag).exp();
                    let given = mean + (felt - mean) * self.lag / dt * (1.0 - decayed);
                    felt = mean + (felt - mean) * decayed;
                    given
                } else {
                    mean
                };
                let theta = 1.0 / self.device_mass;
                let pull =
                    |at: &Bodies| theta * (self.hand_force(at.device[0], at.device[1]) - given);
                at.device[1] += 0.5 * dt * pull(&at);
                at.device[0] += dt * at.device[1];
                at.device[1] += 0.5 * dt * pull(&at);
                forces.push(given);
            }
        }
        forces
    }

    /// Returns the mean-force error E `[%]` over the windows that the commands govern.
    pub fn error(&self, ideal: &[f64], rendered: &[f64]) -> f64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred steps, not below 0"
        )]
        let steps = (self.delay / self.period * STEPS as f64).round() as usize;
        let shift = steps % STEPS;
        let mean = |window: &[f64]| window.iter().sum::<f64>() / window.len() as f64;
        let windows = ideal[shift..].chunks_exact(STEPS);
        let (mut off, mut all) = (0.0, 0.0);
        for (a, b) in windows.zip(rendered[shift..].chunks_exact(STEPS)) {
            off += (mean(a) - mean(b)).powi(2);
            all += a.iter().map(|f| f * f).sum::<f64>() / STEPS as f64;
        }
        100.0 * (off / all).sqrt()
    }

    /// Returns the number of periods until the end of the third ideal collision, at most `most`.
    pub fn window(&self, most: usize) -> usize {
        let ideal = self.ideal(most);
        let mut ends = 0;
        for i in 1..ideal.len() {
            if ideal[i] == 0.0 && ideal[i - 1] > 0.0 {
                ends += 1;
                if ends == 3 {
                    return i / STEPS + 3;
                }
            }
        }
        most
    }
}

/// Reproducible random numbers.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }
    pub fn log(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.uniform())
    }
}

/// Draws a desktop plant with a perfect actuator: 1 kHz, 0.08 to 0.4 kg, 0.5 to 10 kN/m.
pub fn draw(seed: u64) -> Desk {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    for _ in 0..4 {
        random.uniform();
    }
    let device_mass = random.log(0.08, 0.4);
    let in_hand = random.uniform() < 0.7;
    let hand = (random.between(50.0, 400.0), random.between(0.5, 5.0));
    let stiffness = random.log(500.0, 1e4);
    let object_mass = random.log(0.03, 0.5);
    let speed = random.between(0.1, 0.5);
    let acceleration = random.between(2.0, 10.0);
    let hand_mass = if in_hand {
        random.between(0.0, 0.1)
    } else {
        0.0
    };
    Desk {
        device_mass: device_mass + hand_mass,
        stiffness,
        object_mass,
        push: acceleration * device_mass,
        hand: if in_hand { hand } else { (0.0, 0.0) },
        gap: speed * speed / (2.0 * (acceleration + GRAVITY)),
        period: 1e-3,
        quantum: 0.0,
        delay: 0.0,
        lag: 0.0,
        gain: 1.0,
        jitter: 0.0,
        clip: f64::INFINITY,
    }
}
