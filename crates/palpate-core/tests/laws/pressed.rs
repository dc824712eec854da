//! A hand presses steadily on a wall or an object: effect of a limit or a model deviation at rest.
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // numbers of samples

use palpate_core::{Actuation, Contact, CoupledParams, LoopParams, ObjectState, Renderer, Sample};

/// A device in a hand that pushes steadily, and its contact.
#[derive(Clone, Copy, Debug)]
struct Pressed {
    /// K T^2/m and K T^2/M; the latter is 0 for a wall.
    kappa: f64,
    by_object: f64,
    /// Force of the hand `[N]`, and the force that holds an object against it.
    push: f64,
    force_limit: Option<f64>,
    actuation: Actuation<f64>,
    /// Displacement of the device by a tap, after 1 s `[m]`.
    tap: f64,
    /// Stiffness `[N/m]` and damping `[N s/m]` of the hand.
    hand: (f64, f64),
    seconds: f64,
}

const PERIOD: f64 = 0.001;
const MASS: f64 = 0.2;
const LIMIT: f64 = 20.0;

impl Pressed {
    fn new(kappa: f64, by_object: f64, push: f64) -> Self {
        Self {
            kappa,
            by_object,
            push,
            force_limit: None,
            actuation: Actuation::default(),
            tap: 0.0,
            hand: (0.0, 1.0),
            seconds: 6.0,
        }
    }

    /// Returns the smallest and largest force on the device in the last second `[N]`.
    fn last_second(&self) -> (f64, f64) {
        let stiffness = self.kappa * MASS / (PERIOD * PERIOD);
        let contact = if self.by_object > 0.0 {
            Contact::object(stiffness, stiffness * PERIOD * PERIOD / self.by_object)
        } else {
            Contact::wall(stiffness)
        };
        let loop_params = LoopParams {
            actuation: self.actuation,
            force_limit: self.force_limit,
            speed_limit: None,
            ..LoopParams::new(PERIOD)
        };
        let params = CoupledParams::new(MASS);
        let renderer = Renderer::new(contact, loop_params, params).unwrap();
        let rest = -1.1 * self.push / stiffness;
        let mut state = renderer.start(ObjectState::at_rest(rest)).unwrap();
        let (mut x, mut v) = (0.0, 0.0);
        let delay = self.actuation.delay / PERIOD;
        let parts = 8;
        let mut commands = vec![0.0];
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        let ticks = (self.seconds / PERIOD) as usize;
        let mut felt = 0.0;
        for tick in 0..ticks {
            if tick == 1000 {
                x -= self.tap;
            }
            let sample = Sample::at(x).with_virtual_force(-self.push);
            let o = renderer.step(&mut state, sample);
            commands.push(o.force_on_device);
            if tick + 1000 >= ticks {
                least = least.min(-felt);
                largest = largest.max(-felt);
            }
            let h = PERIOD / f64::from(parts);
            for part in 0..parts {
                // Command that acts in the middle of the part.
                let age = delay - (f64::from(part) + 0.5) / f64::from(parts);
                let place = commands.len() as f64 - 1.0 - age.ceil().max(0.0);
                let command = commands[place.max(0.0) as usize];
                let lag = self.actuation.lag;
                let mut mean = command;
                if lag > 0.0 {
                    let left = (-h / lag).exp();
                    mean += (felt - command) * lag * (1.0 - left) / h;
                    felt = command + (felt - command) * left;
                } else {
                    felt = command;
                }
                let (stiffness, damping) = self.hand;
                let a = (mean + self.push - stiffness * x - damping * v) / MASS;
                let w = v + a * h;
                x += 0.5 * (v + w) * h;
                v = w;
            }
        }
        (least, largest)
    }
}

impl Pressed {
    /// Returns the same for the ideal contact: a spring with a limited force, in continuous time.
    fn ideal(&self) -> (f64, f64) {
        let stiffness = self.kappa * MASS / (PERIOD * PERIOD);
        let mobility = self.by_object / (stiffness * PERIOD * PERIOD);
        let limit = self.force_limit.unwrap_or(f64::INFINITY);
        let (mut x, mut v) = (0.0, 0.0);
        let (mut y, mut w) = (-1.1 * self.push / stiffness, 0.0);
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        let steps = 50;
        let h = PERIOD / f64::from(steps);
        let ticks = (self.seconds / PERIOD) as usize;
        for tick in 0..ticks {
            if tick == 1000 {
                x -= self.tap;
            }
            let mut mean = 0.0;
            for _ in 0..steps {
                let f = (stiffness * (x - y)).clamp(0.0, limit);
                mean += f / f64::from(steps);
                let (k, b) = self.hand;
                v += (self.push - f - k * x - b * v) / MASS * h;
                w += (f - self.push) * mobility * h;
                x += v * h;
                y += w * h;
            }
            if tick + 1000 >= ticks {
                least = least.min(mean);
                largest = largest.max(mean);
            }
        }
        (least, largest)
    }
}

/// A tap lifts the device off; the following impact exceeds the limit many times.
#[test]
fn a_contact_whose_force_was_limited_rests_as_the_ideal_one_does() {
    for by_object in [0.0, 0.5, 2.0] {
        for (kappa, tap) in [
            (0.1, 0.5),
            (0.5, 0.2),
            (1.0, 0.5),
            (2.0, 1.0),
            (3.0, 0.5),
            (4.0, 0.2),
        ] {
            for part in [0.35, 0.5, 0.65, 0.8, 0.95] {
                let pressed = Pressed {
                    tap: 1e-3 * tap,
                    force_limit: Some(LIMIT),
                    ..Pressed::new(kappa, by_object, part * LIMIT)
                };
                let (least, largest) = pressed.last_second();
                let (low, high) = pressed.ideal();
                assert!(
                    largest - least < 1.1 * (high - low) + 0.1,
                    "{least} to {largest} N, ideally {low} to {high} N: {pressed:?}"
                );
            }
        }
    }
}

/// A model deviation is an uncertainty, not an additional delay.
#[test]
fn a_deviation_of_the_model_adds_nothing_to_the_swing_of_a_contact() {
    let late = |by: f64| Actuation {
        delay_deviation: by * PERIOD,
        ..Actuation::after(PERIOD)
    };
    let slow = |by: f64| Actuation {
        lag_deviation: by * PERIOD,
        ..Actuation::after(PERIOD).with_lag(0.3 * PERIOD)
    };
    let soon = |by: f64| Actuation {
        delay_deviation: by * PERIOD,
        ..Actuation::after(0.5 * PERIOD)
    };
    let strong = |by: f64| Actuation {
        gain_deviation: by,
        ..Actuation::after(PERIOD)
    };
    let kinds: [&dyn Fn(f64) -> Actuation<f64>; 4] = [&late, &slow, &soon, &strong];
    for by_object in [0.0, 0.4, 2.0, 8.0] {
        for kappa in [0.01, 0.1, 1.0, 4.0] {
            for actuation in kinds {
                let swing = |actuation| {
                    let pressed = Pressed {
                        hand: (100.0, 1.0),
                        seconds: 8.0,
                        actuation,
                        ..Pressed::new(kappa, by_object, 3.0)
                    };
                    let (least, largest) = pressed.last_second();
                    (largest - least) / 3.0
                };
                let without = swing(actuation(0.0));
                for by in [0.0025, 0.02, 0.1] {
                    let with = swing(actuation(by));
                    assert!(
                        with < without + 0.01,
                        "kappa {kappa}, Kc {by_object}, {:?}: swings by {with}, {without} without",
                        actuation(by)
                    );
                }
            }
        }
    }
}

/// Hands: stiffness `[N/m]` and damping `[N s/m]`.
const HANDS: [(f64, f64); 4] = [(0.0, 1.0), (60.0, 1.5), (100.0, 1.0), (300.0, 3.0)];

/// Returns the number of [`HANDS`] in which a pressed wall swings by more than 5 % of the force after 7 s. `delay`,
/// `lag` and `deviation` are in periods, exactly modelled.
fn swinging(kappa: f64, [delay, lag]: [f64; 2], deviation: f64) -> usize {
    let swings = HANDS.iter().filter(|&&hand| {
        let pressed = Pressed {
            hand,
            seconds: 8.0,
            actuation: Actuation {
                delay_deviation: deviation * PERIOD,
                ..Actuation::after(delay * PERIOD).with_lag(lag * PERIOD)
            },
            ..Pressed::new(kappa, 0.0, 3.0)
        };
        let (least, largest) = pressed.last_second();
        largest - least > 0.05 * 3.0
    });
    swings.count()
}

#[test]
fn a_wall_with_a_fraction_of_a_period_of_delay_rests_up_to_kappa_2() {
    for delay in [0.875, 1.375, 1.5, 1.875] {
        for deviation in [0.0, 0.1] {
            let found = swinging(2.0, [delay, 0.2], deviation);
            assert_eq!(found, 0, "delay {delay}, deviation {deviation}");
        }
    }
}

#[test]
#[ignore = "a table of the documentation: one minute"]
fn stiff_walls_with_a_fraction_of_a_period_of_delay_swing_with_and_without_a_deviation() {
    for lag in [0.0, 0.2] {
        for delay in [0.5, 0.875, 1.0, 1.375, 1.5, 1.875, 2.0] {
            let cells = [0.0, 0.02, 0.1].map(|deviation| {
                let row =
                    [2.0, 2.5, 3.0, 4.0].map(|kappa| swinging(kappa, [delay, lag], deviation));
                row.map(|count| count.to_string()).join("/")
            });
            println!("| {delay}, {lag} | {} |", cells.join(" | "));
        }
    }
}

/// Force on the object after each period, from a wall whose device rests 2 N deep inside from the first sample and whose
/// force ramps up over `soft_start` periods.
fn from_inside(kappa: f64, period: f64, soft_start: u32, delay: f64) -> Vec<f64> {
    let stiffness = kappa * MASS / (period * period);
    let loop_params = LoopParams {
        actuation: Actuation {
            delay: delay * period,
            ..Actuation::default()
        },
        ..LoopParams::new(period)
    };
    let contact = Contact::wall(stiffness);
    let renderer = Renderer::new(contact, loop_params, CoupledParams::new(MASS)).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let ticks = 0..400 + 3 * soft_start;
    let parts = ticks.map(|tick| (f64::from(tick) / f64::from(soft_start)).min(1.0));
    parts
        .map(|part| {
            let output = renderer.step(&mut state, Sample::at(2.0 / stiffness));
            let sent = part * output.force_on_object;
            renderer.report_sent(&mut state, sent);
            sent
        })
        .collect()
}

#[test]
fn a_device_at_rest_inside_a_wall_feels_its_depth_after_a_soft_start() {
    for kappa in [0.1, 2.0, 3.2, 64.0] {
        for delay in [0.0, 0.6, 1.0, 2.5] {
            let forces = from_inside(kappa, PERIOD, 200, delay);
            let (came_in, last) = (forces[200], forces[forces.len() - 1]);
            let case = format!("{kappa} {delay}: {came_in} N, then {last} N");
            assert!((came_in - 2.0).abs() < 0.1, "{case}");
            assert!((last - 2.0).abs() < 0.01, "{case}");
        }
        // A soft start of five long periods.
        let forces = from_inside(kappa, 0.04, 5, 0.0);
        let last = forces[forces.len() - 1];
        assert!((last - 2.0).abs() < 1e-3, "{kappa}: {last} N");
    }
}
