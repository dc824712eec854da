//! A virtual device in a sampled loop, integrated in steps far below the period. It is the reference for calibration
//! tests and shares no code with the fit.

pub mod draws;

use std::f64::consts::TAU;

/// Parameters of the plant.
#[derive(Clone, Copy, Debug)]
pub struct PlantParams {
    /// Period `[s]`.
    pub period: f64,
    /// Mass at the motor `[kg]`; the whole mass if `second_mass` is 0.
    pub mass: f64,
    /// Mass beyond the transmission `[kg]`.
    pub second_mass: f64,
    /// Stiffness of the transmission `[N/m]`.
    pub transmission_stiffness: f64,
    /// Damping of the transmission `[N s/m]`.
    pub transmission_damping: f64,
    /// Shortest delay of a command `[periods]`.
    pub delay: f64,
    /// Largest additional delay of a command, uniformly distributed `[periods]`.
    pub jitter: f64,
    /// Time constant of the motor `[s]`.
    pub lag: f64,
    /// Force over command.
    pub gain: f64,
    /// Viscous friction `[N s/m]`.
    pub viscous: f64,
    /// Coulomb friction `[N]`.
    pub coulomb: f64,
    /// Amplitude of the cogging `[N]`.
    pub cogging: f64,
    /// Period of the cogging `[m]`.
    pub pitch: f64,
    /// Mass of the hand `[kg]`.
    pub hand_mass: f64,
    /// Stiffness of the hand `[N/m]`.
    pub hand_stiffness: f64,
    /// Damping of the hand `[N s/m]`.
    pub hand_damping: f64,
    /// Slow force of the hand, root mean square `[N]`.
    pub drift: f64,
    /// Amplitude of the tremor `[N]`.
    pub tremor: f64,
    /// Frequency of the tremor `[Hz]`.
    pub tremor_frequency: f64,
    /// Step of the sensor `[m]`.
    pub quantum: f64,
    /// Noise of the sensor before it is rounded, standard deviation `[m]`.
    pub noise: f64,
    /// Largest force of the amplifier `[N]`.
    pub saturation: f64,
    /// Time `[s]` at which the delay of commands increases, and the increase `[periods]`.
    pub jump: [f64; 2],
}

impl PlantParams {
    /// Creates a mass on a motor without further effects.
    pub fn bare(period: f64, mass: f64) -> Self {
        Self {
            period,
            mass,
            second_mass: 0.0,
            transmission_stiffness: 0.0,
            transmission_damping: 0.0,
            delay: 0.5,
            jitter: 0.0,
            lag: 0.0,
            gain: 1.0,
            viscous: 0.0,
            coulomb: 0.0,
            cogging: 0.0,
            pitch: 0.005,
            hand_mass: 0.0,
            hand_stiffness: 0.0,
            hand_damping: 0.0,
            drift: 0.0,
            tremor: 0.0,
            tremor_frequency: 10.0,
            quantum: 1e-5,
            noise: 0.0,
            saturation: f64::INFINITY,
            jump: [f64::INFINITY, 0.0],
        }
    }

    /// Splits the mass: `fraction` of it is beyond a transmission with a free-free resonance at `hertz`.
    pub fn flexible(&mut self, hertz: f64, damping_ratio: f64, fraction: f64) {
        let whole = self.mass;
        self.second_mass = fraction * whole;
        self.mass = whole - self.second_mass;
        let reduced = self.mass * self.second_mass / whole;
        let w = TAU * hertz;
        self.transmission_stiffness = reduced * w * w;
        self.transmission_damping = 2.0 * damping_ratio * w * reduced;
    }

    /// Returns the total moving mass `[kg]`.
    pub fn moved_mass(&self) -> f64 {
        self.mass + self.second_mass + self.hand_mass
    }

    /// Returns the resonance with the hand attached `[Hz]`.
    pub fn resonance(&self) -> Option<f64> {
        let second = self.second_mass + self.hand_mass;
        (self.second_mass > 0.0).then(|| {
            let reduced = self.mass * second / (self.mass + second);
            (self.transmission_stiffness / reduced).sqrt() / TAU
        })
    }

    /// Returns the mean delay plus lag `[periods]`.
    pub fn delay_plus_lag(&self) -> f64 {
        self.delay + self.jitter / 2.0 + self.lag / self.period
    }
}

/// A virtual device.
pub struct Plant {
    params: PlantParams,
    random: fastrand::Rng,
    sines: Vec<[f64; 3]>,
    x: [f64; 2],
    v: [f64; 2],
    motor: f64,
    /// Acting command, and pending commands: instant `[s]` and force `[N]`.
    acting: f64,
    waiting: std::collections::VecDeque<(f64, f64)>,
    latest: f64,
    ticks: usize,
    /// Largest excursion so far `[m]`.
    pub excursion: f64,
}

impl Plant {
    pub fn new(params: PlantParams, seed: u64) -> Self {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut sines = Vec::new();
        for _ in 0..8 {
            let frequency = 0.05 + 1.15 * random.f64();
            sines.push([
                params.drift * (2.0_f64 / 8.0).sqrt(),
                frequency,
                random.f64(),
            ]);
        }
        for _ in 0..6 {
            let frequency = params.tremor_frequency - 1.0 + 2.0 * random.f64();
            sines.push([
                params.tremor * (1.0_f64 / 6.0).sqrt(),
                frequency,
                random.f64(),
            ]);
        }
        sines.retain(|sine| sine[0] != 0.0);
        Self {
            params,
            random,
            sines,
            x: [0.0; 2],
            v: [0.0; 2],
            motor: 0.0,
            acting: 0.0,
            waiting: std::collections::VecDeque::new(),
            latest: f64::NEG_INFINITY,
            ticks: 0,
            excursion: 0.0,
        }
    }

    /// Returns the sensor's reading `[m]`.
    pub fn measured(&mut self) -> f64 {
        let PlantParams { noise, quantum, .. } = self.params;
        // The sum of twelve uniform numbers approximates a normal distribution.
        let normal = (0..12).map(|_| self.random.f64()).sum::<f64>() - 6.0;
        let x = self.x[0] + noise * normal;
        if quantum > 0.0 {
            (x / quantum).round() * quantum
        } else {
            x
        }
    }

    fn disturbance(&self, t: f64) -> f64 {
        self.sines
            .iter()
            .map(|[amplitude, frequency, phase]| amplitude * (TAU * (frequency * t + phase)).sin())
            .sum()
    }

    /// Issues a command `[N]` and advances by one period.
    pub fn advance(&mut self, command: f64) {
        let p = self.params;
        let [at, later] = p.jump;
        let is_later = self.ticks as f64 * p.period >= at;
        let later = if is_later { later } else { 0.0 };
        let begins = self.ticks as f64 + p.delay + later + p.jitter * self.random.f64();
        self.latest = (begins * p.period).max(self.latest);
        self.waiting.push_back((
            self.latest,
            (p.gain * command).clamp(-p.saturation, p.saturation),
        ));
        let steps = (p.period / 1e-5).ceil();
        let dt = p.period / steps;
        let kept = if p.lag > 0.0 {
            (-dt / p.lag).exp()
        } else {
            0.0
        };
        let from = self.ticks as f64 * p.period;
        let (old, new) = (self.disturbance(from), self.disturbance(from + p.period));
        let mut step = 0.0;
        while step < steps {
            let t = from + step * dt;
            let force = self.motor_force(t, dt, kept);
            let outside = old + (new - old) * (t - from) / p.period;
            self.kick(force, outside, dt / 2.0);
            self.x[0] += self.v[0] * dt;
            self.x[1] += self.v[1] * dt;
            self.kick(force, outside, dt / 2.0);
            step += 1.0;
        }
        self.excursion = self.excursion.max(self.x[0].abs());
        self.ticks += 1;
    }

    /// Returns the mean force of the motor over a step.
    fn motor_force(&mut self, t: f64, dt: f64, kept: f64) -> f64 {
        let (mut from, mut sum) = (t, 0.0);
        while let Some(&(begins, force)) = self.waiting.front().filter(|next| next.0 < t + dt) {
            if begins > from {
                sum += self.acting * (begins - from);
                from = begins;
            }
            self.acting = force;
            self.waiting.pop_front();
        }
        let commanded = (sum + self.acting * (t + dt - from)) / dt;
        let lag = self.params.lag;
        if lag == 0.0 {
            return commanded;
        }
        let mean = commanded + (self.motor - commanded) * lag / dt * (1.0 - kept);
        self.motor = commanded + (self.motor - commanded) * kept;
        mean
    }

    fn kick(&mut self, motor: f64, outside: f64, dt: f64) {
        let p = self.params;
        let [x1, x2] = self.x;
        let [v1, v2] = self.v;
        let mut force = motor - p.viscous * v1;
        if p.cogging > 0.0 {
            force += p.cogging * (TAU * x1 / p.pitch).sin();
        }
        let mut mass = p.mass;
        if p.second_mass > 0.0 {
            let between = p.transmission_stiffness * (x2 - x1) + p.transmission_damping * (v2 - v1);
            force += between;
            let on_second = outside - between - p.hand_stiffness * x2 - p.hand_damping * v2;
            self.v[1] += dt * on_second / (p.second_mass + p.hand_mass);
        } else {
            force += outside - p.hand_stiffness * x1 - p.hand_damping * v1;
            mass += p.hand_mass;
        }
        let v = v1 + dt * force / mass;
        let stopped = dt * p.coulomb / mass;
        self.v[0] = v - v.clamp(-stopped, stopped);
    }
}
