//! The guard by acceleration against an adversary who accelerates a device of unknown mass within its bounds.

use palpate_core::{
    Actuation, AnyRenderer, BasicParams, Contact, CoupledParams, Guard, GuardParams, HandBound,
    HandLimit, LoopParams, Mass, ObjectState, Renderer, Sample,
};

use crate::common::{Random, methods};

const ALLOWANCE: f64 = 1e-3;
const SPEED: f64 = 1.0;
const ACCELERATION: f64 = 80.0;
const LEAST_MASS: f64 = 0.125;
/// Samples of an attack, and accelerations per sample.
const LENGTH: usize = 60;
const PARTS: usize = 4;

/// Motion of the hand on a device.
#[derive(Clone)]
struct Attack {
    /// Acceleration in each part of a period `[m/s^2]`.
    accelerations: [f64; LENGTH * PARTS],
    mass: f64,
    velocity: f64,
    /// Distance to the object `[m]`.
    gap: f64,
    /// Place of the quanta, as a fraction of one.
    phase: f64,
}

/// A loop that is attacked.
struct Target {
    renderer: AnyRenderer<f64>,
    period: f64,
    actuation: Actuation<f64>,
    quantum: f64,
    weight: f64,
}

/// Device as a point mass under a first-order actuator, integrated exactly.
struct Device {
    position: f64,
    velocity: f64,
    felt: f64,
    given_out: f64,
}

impl Device {
    /// Moves for `h` `[s]` under the delivered force `aim` `[N]`, behind the `lag` `[s]`.
    fn moves(&mut self, mass: f64, acceleration: f64, aim: f64, lag: f64, h: f64) {
        let v = self.velocity;
        let gained = acceleration - aim / mass;
        let mut work = aim * (v * h + 0.5 * gained * h * h);
        self.position += v * h + 0.5 * gained * h * h;
        self.velocity += gained * h;
        if lag > 0.0 {
            let off = self.felt - aim;
            let left = (-h / lag).exp();
            let (once, timed) = (lag * (1.0 - left), lag * (lag * (1.0 - left) - h * left));
            let slowed = off * lag / mass;
            work += aim * slowed * (once - h);
            work += off * ((v - slowed) * once + gained * timed);
            work += off * slowed * 0.5 * lag * (1.0 - left * left);
            self.position -= slowed * (h - once);
            self.velocity -= slowed * (1.0 - left);
            self.felt = aim + off * left;
        } else {
            self.felt = aim;
        }
        self.given_out -= work;
    }
}

impl Target {
    /// Creates a random target of a method; `recovery` `[W]`.
    fn random(
        random: &mut Random,
        method: palpate_core::AnyParams<f64>,
        (kind, recovery): (usize, f64),
        hand: HandBound<f64>,
    ) -> Self {
        let period = 1.0 / (50.0 * 80f64.powf(random.between(0.0, 1.0)));
        let stiffness = 1e3 * 100f64.powf(random.between(0.0, 1.0));
        let contact = if random.between(0.0, 1.0) < 0.5 {
            Contact::wall(stiffness)
        } else {
            // Within the stability limit of the object's own motion.
            let least = 0.1 * stiffness * period * period;
            Contact::object(stiffness, least.max(random.between(0.02, 0.3)))
        };
        let whole = f64::from(u32::try_from(random.bits() >> 61).unwrap());
        let delay = [
            0.0,
            whole,
            random.between(0.0, 8.0),
            0.0,
            random.between(0.0, 2.0),
        ][kind % 5];
        let lag = [0.0, 0.0, 0.0, 3.0, 1.0][kind % 5] * random.between(0.0, 1.0);
        let quantum = if kind / 5 % 2 == 1 {
            1e-6 * 100f64.powf(random.between(0.0, 1.0))
        } else {
            0.0
        };
        let gain = if kind % 3 == 2 {
            random.between(0.5, 2.0)
        } else {
            1.0
        };
        let actuation = Actuation::after(delay * period)
            .with_lag(lag * period)
            .with_gain(gain);
        let guard = Guard::Limit(GuardParams {
            largest_speed: SPEED,
            allowance: ALLOWANCE,
            quantum,
            recovery,
            hand: Some(hand),
        });
        let loop_params = LoopParams {
            actuation,
            guard,
            ..LoopParams::new(period)
        };
        let renderer = Renderer::new(contact, loop_params, method).unwrap();
        // A lag mixes the commands, whose balances then differ.
        let moves = matches!(contact.object_mass, Mass::Finite(_)) && lag == 0.0;
        Self {
            renderer,
            period,
            actuation,
            quantum,
            weight: if moves { -0.5 } else { 0.0 },
        }
    }

    /// Returns the largest energy that the attack extracts beyond the energy put in `[J]`, and the number of intervals
    /// beyond the bound that the guard saw.
    fn taken_by(&self, attack: &Attack) -> (f64, u32) {
        let Actuation {
            delay, lag, gain, ..
        } = self.actuation;
        let start = ObjectState::at_rest(attack.gap);
        let mut state = self.renderer.start(start).unwrap();
        let mut device = Device {
            position: 0.0,
            velocity: attack.velocity,
            felt: 0.0,
            given_out: 0.0,
        };
        let (mut commands, mut begun) = ([(0.0, 0.0); LENGTH], 0);
        let (mut aim, mut available, mut put_in) = (0.0, 0.0f64, 0.0);
        let (mut worst, mut object, mut beyond) = (f64::NEG_INFINITY, attack.gap, 0);
        let (recovery, is_force) = match self.renderer.loop_params().guard {
            Guard::Limit(params) => {
                let limit = params.hand.map(|hand| hand.limit);
                (params.recovery, matches!(limit, Some(HandLimit::Force(_))))
            }
            _ => (0.0, false),
        };
        for i in 0..LENGTH {
            let seen = if self.quantum > 0.0 {
                (device.position / self.quantum + attack.phase).round() * self.quantum
            } else {
                device.position
            };
            let sample = Sample::at(seen).with_virtual_force(self.weight);
            let output = self.renderer.step(&mut state, sample);
            assert_eq!(output.fault, None);
            beyond += u32::from(output.limited.beyond_guard);
            put_in += self.weight * (output.object_position - object);
            object = output.object_position;
            commands[i] = (gain * output.force_on_object, put_in);
            for part in 0..PARTS {
                let at = |n: usize| (i as f64 + n as f64 / PARTS as f64) * self.period;
                let (mut now, end) = (at(part), at(part + 1));
                while now < end - 1e-9 * self.period {
                    let begins = |k: usize| k as f64 * self.period + delay;
                    while begun <= i && begins(begun) <= now + 1e-9 * self.period {
                        // Energy put in up to the sample of the force, or already given out.
                        aim = commands[begun].0;
                        available = commands[begun].1.max(device.given_out - ALLOWANCE);
                        begun += 1;
                    }
                    let mut until = end;
                    if begun <= i && begins(begun) < end - 1e-9 * self.period {
                        until = begins(begun);
                    }
                    let mut acceleration = attack.accelerations[i * PARTS + part];
                    if is_force {
                        acceleration *= LEAST_MASS / attack.mass;
                    }
                    device.moves(attack.mass, acceleration, aim, lag, until - now);
                    now = until;
                    if device.velocity.abs() > SPEED {
                        return (worst, beyond);
                    }
                    if device.felt != 0.0 {
                        worst = worst.max(device.given_out - available - recovery * now);
                    }
                }
            }
        }
        (worst, beyond)
    }

    /// Returns the best of attacks that are improved in `tries` steps, and the intervals beyond the bound.
    fn attacked(&self, random: &mut Random, begin: usize, tries: usize) -> (f64, u32) {
        let mut attack = Attack::begun(random, begin, self.period);
        let (mut taken, mut beyond) = self.taken_by(&attack);
        for _ in 0..tries {
            let other = attack.changed(random);
            let (by_other, seen) = self.taken_by(&other);
            beyond += seen;
            if by_other >= taken {
                (attack, taken) = (other, by_other);
            }
        }
        (taken, beyond)
    }
}

impl Attack {
    fn begun(random: &mut Random, begin: usize, period: f64) -> Self {
        let turn = [PARTS, 2 * PARTS, 4 * PARTS, 8 * PARTS, 16 * PARTS, 2][begin % 6];
        let velocity = random.between(0.0, SPEED);
        let mut accelerations = [0.0; LENGTH * PARTS];
        for (i, acceleration) in accelerations.iter_mut().enumerate() {
            let alternates = if (i / turn).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            *acceleration = ACCELERATION
                * if begin % 12 < 6 {
                    alternates
                } else {
                    random.between(-1.0, 1.0)
                };
        }
        Self {
            accelerations,
            mass: LEAST_MASS * 4f64.powf(random.between(0.0, 1.0)),
            velocity,
            gap: random.between(0.1, 5.0) * velocity * period,
            phase: random.between(0.0, 1.0),
        }
    }

    fn changed(&self, random: &mut Random) -> Self {
        let mut other = self.clone();
        match random.bits() >> 32 & 15 {
            0 => other.mass = LEAST_MASS,
            1 => other.mass = LEAST_MASS * 16f64.powf(random.between(0.0, 1.0)),
            2 => other.velocity = (other.velocity + random.between(-0.2, 0.2)).clamp(-SPEED, SPEED),
            3 => other.gap = (other.gap * random.between(0.7, 1.4)).max(1e-9),
            4 => other.phase = random.between(0.0, 1.0),
            _ => {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                // not negative and small
                let place = |random: &mut Random, most: f64| random.between(0.0, most) as usize;
                let from = place(random, (LENGTH * PARTS) as f64);
                let span = [2.0, 5.0, 20.0, 60.0][place(random, 4.0)];
                let many = 1 + place(random, span);
                let any = random.between(-1.0, 1.0);
                let to = ACCELERATION * [-1.0, 0.0, 1.0, any][place(random, 4.0)];
                for each in other.accelerations.iter_mut().skip(from).take(many) {
                    *each = to;
                }
            }
        }
        other
    }
}

/// Number of attacks on each kind of loop: 1, or `PALPATE_ATTACKS` for a campaign.
fn attacks() -> usize {
    std::env::var("PALPATE_ATTACKS").map_or(1, |count| count.parse().unwrap())
}

const HAND: HandBound<f64> = HandBound::from_acceleration(ACCELERATION, LEAST_MASS);

/// Attacks every method under a hand's bound; returns the largest energy `[J]`, and fails if it exceeds the allowance.
fn attacked_by_all(hand: HandBound<f64>) -> f64 {
    let mut random = Random(5);
    let mut most = f64::NEG_INFINITY;
    let mut over = Vec::new();
    for (name, method) in methods() {
        let mut by_method = f64::NEG_INFINITY;
        for number in 0..10 * attacks() {
            let recovery = if number % 20 < 10 { 0.0 } else { 0.01 };
            let target = Target::random(&mut random, method, (number, recovery), hand);
            let (taken, beyond) = target.attacked(&mut random, number / 10, 60);
            if taken > ALLOWANCE * (1.0 + 1e-9) || beyond > 0 {
                over.push(format!(
                    "{name}, {:?} at {} s, {:?}, quantum {}: {taken} J, {beyond} beyond",
                    target.renderer.contact(),
                    target.period,
                    target.actuation,
                    target.quantum
                ));
            }
            by_method = by_method.max(taken);
        }
        println!("{name}: {by_method} J");
        most = most.max(by_method);
    }
    assert!(over.is_empty(), "{} over:\n{}", over.len(), over.join("\n"));
    most
}

#[test]
fn hand_within_acceleration_bound_takes_no_more_than_allowance() {
    let most = attacked_by_all(HAND);
    // The bound is reached, so the guard is not too strict.
    assert!(most > 0.8 * ALLOWANCE, "{most} J");
}

#[test]
fn hand_takes_no_more_from_a_guard_that_learns_its_mass() {
    let most = attacked_by_all(HAND.learning_mass());
    assert!(most > 0.8 * ALLOWANCE, "{most} J");
}

/// The force of the adversary is within the bound for every mass from the least one up.
#[test]
fn hand_of_a_largest_force_takes_no_more_than_allowance() {
    let hand = HandBound::from_force(ACCELERATION * LEAST_MASS, LEAST_MASS);
    let most = attacked_by_all(hand.learning_mass());
    assert!(most > 0.8 * ALLOWANCE, "{most} J");
}

/// A device of four times the least mass strikes a wall: its motion shows the mass, so the guard acts less often.
#[test]
fn a_mass_that_the_motion_shows_raises_the_forces() {
    let limited = |hand: HandBound<f64>| {
        let guard = Guard::Limit(GuardParams {
            hand: Some(hand),
            ..GuardParams::by_speed(SPEED, ALLOWANCE)
        });
        let (period, mass) = (1e-3, 4.0 * LEAST_MASS);
        let loop_params = LoopParams {
            guard,
            ..LoopParams::new(period)
        };
        let contact = Contact::wall(100_000.0);
        let renderer = Renderer::new(contact, loop_params, CoupledParams::new(mass)).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let (mut x, mut v, mut limited) = (-0.002, 0.3, 0);
        for _ in 0..400 {
            let output = renderer.step(&mut state, Sample::at(x));
            assert!(!output.limited.beyond_guard);
            limited += u32::from(output.limited.guard);
            // 5 N return it to the wall.
            let gained = (5.0 - output.force_on_object) / mass;
            x += v * period + 0.5 * gained * period * period;
            v += gained * period;
        }
        limited
    };
    for hand in [HAND, HandBound::from_force(10.0, LEAST_MASS)] {
        let [told, shown] = [hand, hand.learning_mass()].map(limited);
        println!("{told} limited, {shown} with the mass that the motion shows");
        assert!(shown < told, "{shown} of {told}");
    }
}

/// Pressed wall at 1 kHz: a device of this mass, a push, and a hand without more damping than stated.
struct Pressed {
    stiffness: f64,
    mass: f64,
    push: f64,
    /// Stiffness `[N/m]` and damping `[N s/m]` of the hand.
    hand: (f64, f64),
    delay: usize,
    force_limit: Option<f64>,
    quantum: f64,
    guard: Guard<f64>,
    /// Sample at which the device is displaced, and by how much `[m]`.
    tap: (usize, f64),
}

impl Pressed {
    /// Returns the command of each sample, as a force on the object `[N]`, the intervals beyond the bound, and the
    /// device's mean position in the last second `[m]`.
    fn rendered(&self, samples: usize) -> (Vec<f64>, u32, f64) {
        const PERIOD: f64 = 1e-3;
        const STEPS: usize = 16;
        let loop_params = LoopParams {
            actuation: Actuation::after_samples(self.delay, PERIOD),
            force_limit: self.force_limit,
            guard: self.guard,
            ..LoopParams::new(PERIOD)
        };
        let params = CoupledParams::new(self.mass).with_encoder_quantum(self.quantum);
        let renderer = Renderer::new(Contact::wall(self.stiffness), loop_params, params).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let (mut x, mut v, mut beyond, mut sum) = (0.0, 0.0, 0, 0.0);
        let mut forces = Vec::with_capacity(samples);
        for i in 0..samples {
            if i == self.tap.0 {
                x += self.tap.1;
            }
            if i + 1000 >= samples {
                sum += x;
            }
            let seen = if self.quantum > 0.0 {
                (x / self.quantum).round() * self.quantum
            } else {
                x
            };
            let output = renderer.step(&mut state, Sample::at(seen));
            assert_eq!(output.fault, None);
            beyond += u32::from(output.limited.beyond_guard);
            forces.push(output.force_on_object);
            let held = i.checked_sub(self.delay).map_or(0.0, |sent| forces[sent]);
            let h = PERIOD / STEPS as f64;
            for _ in 0..STEPS {
                // Symplectic: the hand's spring neither gains nor loses energy.
                x += 0.5 * v * h;
                let hand = self.push - self.hand.0 * x - self.hand.1 * v;
                v += (hand - held) / self.mass * h;
                x += 0.5 * v * h;
            }
        }
        (forces, beyond, sum / 1000.0)
    }
}

fn limits(allowance: f64, quantum: f64) -> Guard<f64> {
    Guard::Limit(GuardParams {
        largest_speed: SPEED,
        allowance,
        quantum,
        recovery: if quantum > 0.0 { 0.02 } else { 0.0 },
        hand: Some(HandBound::from_acceleration(ACCELERATION, LEAST_MASS)),
    })
}

fn largest(forces: &[f64]) -> f64 {
    forces.iter().fold(0.0, |most, force| most.max(force.abs()))
}

#[test]
fn undamped_springy_hands_with_delay_stay_bounded() {
    for stiffness in [300.0, 1000.0] {
        for delay in [2, 3, 4, 6] {
            let pressed = |guard| Pressed {
                stiffness: 16_300.0,
                mass: 0.265,
                push: 2.0,
                hand: (stiffness, 0.0),
                delay,
                force_limit: None,
                quantum: 0.0,
                guard,
                tap: (0, -1e-3),
            };
            let seconds = |guard, count: usize| {
                let (forces, ..) = pressed(guard).rendered(count * 1000);
                [
                    largest(&forces[..1000]),
                    largest(&forces[(count - 1) * 1000..]),
                ]
            };
            let open = seconds(Guard::Off, 30);
            let guarded = seconds(limits(1e-3, 0.0), 60);
            println!("{stiffness} N/m, {delay} samples: {open:.1?} N, guarded {guarded:.1?} N");
            assert!(open[1] > 1.5 * guarded[1], "{open:?} N, {guarded:?} N");
        }
    }
}

#[test]
fn clipped_wall_comes_to_rest_under_guard() {
    let swing = |guard| {
        let pressed = Pressed {
            stiffness: 200_000.0,
            mass: 0.2,
            push: 13.0,
            hand: (0.0, 1.0),
            delay: 0,
            force_limit: Some(20.0),
            quantum: 0.0,
            guard,
            tap: (3000, -0.0005),
        };
        let (forces, beyond, _) = pressed.rendered(10_000);
        let last = &forces[9_000..];
        let least = last.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{least:.2} to {:.2} N, {beyond} beyond", largest(last));
        (least, largest(last))
    };
    for allowance in [1e-3, 2e-2] {
        let (least, most) = swing(limits(allowance, 0.0));
        assert!(12.99 < least && most < 13.01, "{least} to {most} N");
    }
}

/// A table of docs/results/coupled-limits.md.
#[test]
fn pressed_wall_hardly_sinks_under_guard() {
    for stiffness in [2e3, 1e4, 4e4, 1.6e5] {
        let sink = |guard, quantum| {
            let pressed = Pressed {
                stiffness,
                mass: 0.25,
                push: 3.0,
                hand: (0.0, 2.0),
                delay: 0,
                force_limit: None,
                quantum,
                guard,
                tap: (0, -1e-3),
            };
            let (.., position) = pressed.rendered(20_000);
            1e3 * (position - 3.0 / stiffness)
        };
        let sinks = [0.0, 1e-5].map(|quantum| {
            let [least, usual] = [1e-3, 2e-2].map(|j| sink(limits(j, quantum), quantum));
            let open = sink(Guard::Off, quantum);
            println!(
                "{stiffness} N/m, {quantum} m: off {open:.3}, 1 mJ {least:.3}, 20 mJ {usual:.3} mm"
            );
            usual
        });
        assert!(
            sinks.iter().all(|sink| sink.abs() < 0.3),
            "{stiffness} N/m: {sinks:?} mm"
        );
    }
}

#[test]
fn lost_sample_gives_no_energy_for_free() {
    // The device enters the wall, and leaves it during a lost sample.
    let guard = Guard::Limit(GuardParams::by_speed(SPEED, ALLOWANCE));
    let loop_params = LoopParams {
        guard,
        ..LoopParams::new(1e-3)
    };
    let renderer = Renderer::new(Contact::wall(1000.0), loop_params, BasicParams).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let mut given_out = 0.0;
    for _ in 0..50 {
        renderer.step(&mut state, Sample::at(-4e-4));
        let output = renderer.step(&mut state, Sample::at(5e-4));
        let lost = renderer.step(&mut state, Sample::at(f64::NAN));
        assert!(lost.fault.is_some() && lost.force_on_object == 0.0);
        given_out += output.force_on_object * 9e-4;
    }
    println!("{given_out} J");
    assert!(given_out <= ALLOWANCE * (1.0 + 1e-9), "{given_out} J");
}
