//! An actuator that holds a line: its model, the line of coupled rendering, and the limits.

use palpate_core::{
    Actuation, Actuator, AnyParams, AnyRenderer, Command, Contact, CoupledParams, Guard,
    GuardParams, Hold, LoopParams, ObjectState, Parameter, Renderer, Sample, Scalar, UnderWay,
};

use crate::common::{PointMass, Random, every_number_is_finite, methods};

const PERIOD: f64 = 0.01;
const PUSH: f64 = 1.0;
const WEIGHT: f64 = -0.981;

fn line(period: f64) -> LoopParams<f64> {
    LoopParams {
        actuation: Actuation::default().with_line(),
        ..LoopParams::new(period)
    }
}

/// A command in time: its begin, its mean and its slope.
#[derive(Clone, Copy)]
struct Sent {
    begins: f64,
    mean: f64,
    slope: f64,
}

impl Sent {
    fn at(&self, time: f64) -> f64 {
        let age = (time - self.begins).clamp(0.0, PERIOD);
        self.mean + self.slope * (age - 0.5 * PERIOD)
    }
}

#[test]
fn the_model_of_the_actuator_has_the_moments_of_its_lines() {
    let mut random = Random(5);
    for delay in [0.0, 0.003, 0.01, 0.0234] {
        let actuation = Actuation::after(delay).with_gain(0.9).with_line();
        let actuator = Actuator::new(&actuation, PERIOD);
        let mut under_way = UnderWay::nothing();
        let (mut time, mut sent) = (0.0, Vec::<Sent>::new());
        for tick in 0..60 {
            // A late sample leaves the line at its last value.
            let h = random.pick(&[PERIOD, PERIOD, 0.7 * PERIOD, 1.6 * PERIOD]);
            let command = Command {
                intended: random.between(-2.0, 2.0),
                sent: random.between(-2.0, 2.0),
                slope: if tick % 7 == 0 {
                    0.0
                } else {
                    random.between(-300.0, 300.0)
                },
            };
            under_way.send(command);
            sent.push(Sent {
                begins: time + delay,
                mean: command.sent,
                slope: command.slope,
            });
            let piece = under_way.pass(&actuator, h);
            let force = |at: f64| {
                let acting = sent.iter().rev().find(|sent| sent.begins <= at);
                0.9 * acting.map_or(0.0, |sent| sent.at(at))
            };
            let steps = 20_000;
            let dt = h / f64::from(steps);
            let (mut impulse, mut moment) = (0.0, 0.0);
            for step in 0..steps {
                let t = (f64::from(step) + 0.5) * dt;
                impulse += force(time + t) * dt;
                moment += force(time + t) * (h - t) * dt;
            }
            let mean = impulse / h;
            assert!((piece.held.mean - mean).abs() < 3e-4, "{piece:?} {mean}");
            let lead = moment - 0.5 * mean * h * h;
            assert!(
                (piece.held.lead - lead).abs() < 3e-4 * h * h,
                "{piece:?} {lead}"
            );
            // All changes of the force in the interval, also that at its beginning.
            let change = force(time + h - 1e-9) - force(time - 1e-9);
            assert!(
                (piece.held.step - change).abs() < 1e-4,
                "{piece:?} {change}"
            );
            time += h;
        }
    }
}

/// A contact in continuous time: positions of the device at each of `count` samples, in steps of `PERIOD/2000`.
fn continuous(contact: [f64; 2], mut device: PointMass, mut object: f64, count: usize) -> Vec<f64> {
    let [stiffness, mass] = contact;
    let steps = 2000;
    let dt = PERIOD / f64::from(steps);
    let mut object_velocity = 0.0;
    let mut positions = Vec::new();
    for _ in 0..count {
        positions.push(device.position);
        for _ in 0..steps {
            // Leapfrog.
            device.position += 0.5 * dt * device.velocity;
            object += 0.5 * dt * object_velocity;
            let force = stiffness * (device.position - object).max(0.0);
            device.velocity += dt * (device.user_force - force) / device.mass;
            if mass.is_finite() {
                object_velocity += dt * (force + WEIGHT) / mass;
            }
            device.position += 0.5 * dt * device.velocity;
            object += 0.5 * dt * object_velocity;
        }
    }
    positions
}

#[test]
fn a_line_moves_the_device_as_the_contact_does_and_shifts_nothing() {
    let mass = 0.25;
    for (stiffness, object_mass) in [(400.0, 0.1), (1600.0, 0.1), (400.0, f64::INFINITY)] {
        let device = PointMass {
            mass,
            user_force: PUSH,
            position: 0.0,
            velocity: 0.0,
        };
        let expected = continuous([stiffness, object_mass], device, 0.05, 60);
        let [constant, with_line] = [LoopParams::new(PERIOD), line(PERIOD)].map(|loop_params| {
            let contact = Contact::object(stiffness, object_mass);
            let params = CoupledParams::new(mass);
            let renderer = Renderer::new(contact, loop_params, params).unwrap();
            let mut state = renderer.start(ObjectState::at_rest(0.05)).unwrap();
            let mut device = device;
            let (mut off, mut shift, mut work) = (0.0_f64, 0.0_f64, 0.0);
            for expected in &expected {
                off = off.max((device.position - expected).abs());
                let sample = Sample::at(device.position).with_virtual_force(WEIGHT);
                let output = renderer.step(&mut state, sample);
                shift = shift.max(output.proxy_shift.abs());
                let (force, slope) = (output.force_on_device, output.slope_on_device);
                work += device.hold_line(force, slope, PERIOD);
            }
            renderer.step(&mut state, Sample::at(device.position));
            (off, shift, work - state.ledger().port_work)
        });
        println!("{stiffness} N/m on {object_mass} kg: {constant:?} {with_line:?}");
        assert!(constant.1 > 5e-5 && with_line.1 < 1e-7);
        assert!(constant.0 > 2e-4 && with_line.0 < 2e-7);
        // The ledger has the exact work.
        assert!(constant.2.abs() < 1e-12 && with_line.2.abs() < 1e-8);
    }
}

#[test]
fn the_ends_of_a_line_stay_within_the_limits_whatever_the_device_does() {
    let mut random = Random(17);
    let (mut sloped, mut bounded) = (0, [0; 2]);
    for i in 0..300 {
        let stiffness = 10f64.powf(random.between(1.0, 5.0));
        let contact = Contact {
            unilateral: i % 2 == 0,
            ..Contact::object(stiffness, random.pick(&[0.02, 0.3, f64::INFINITY]))
        };
        let limit = random.between(0.5, 5.0);
        let loop_params = line(PERIOD).with_force_limit(limit);
        let renderer = Renderer::new(contact, loop_params, CoupledParams::new(0.25)).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.01)).unwrap();
        let mut position = 0.0;
        for _ in 0..200 {
            position = (position + random.between(-0.004, 0.004)).clamp(-0.02, 0.04);
            let mut sample = Sample::at(position).with_virtual_force(WEIGHT);
            if random.unit() < 0.1 {
                sample = sample.after(PERIOD * random.between(0.1, 3.0));
            }
            let output = renderer.step(&mut state, sample);
            assert!(every_number_is_finite(&output));
            let half = 0.5 * PERIOD * output.slope_on_device.abs();
            let force = output.force_on_object;
            assert!(force.abs() + half <= limit * (1.0 + 1e-12), "{output:?}");
            if contact.unilateral {
                assert!(force - half >= -1e-12 * limit, "{output:?}");
            }
            sloped += u32::from(half > 0.01 * limit);
            bounded[0] += u32::from(output.limited.pull);
            bounded[1] += u32::from(output.limited.force && half > 0.0);
        }
    }
    assert!(
        sloped > 1000 && bounded.iter().all(|count| *count > 100),
        "{sloped} {bounded:?}"
    );
}

/// Means and slopes of a bounce, the same motion in both precisions.
fn bounce<S: Scalar>(period: f64, stiffness: f64) -> Vec<[f64; 2]> {
    let of = S::from_f64;
    let loop_params = LoopParams {
        actuation: Actuation::default().with_line(),
        ..LoopParams::new(of(period))
    };
    let contact = Contact::object(of(stiffness), of(0.1));
    let renderer = Renderer::new(contact, loop_params, CoupledParams::new(of(0.25))).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(of(0.002))).unwrap();
    let ticks = (0..100).map(|tick| {
        let t = f64::from(tick) * period;
        let sample = Sample::at(of(0.004 * (30.0 * t).sin())).with_virtual_force(of(WEIGHT));
        let output = renderer.step(&mut state, sample);
        [
            output.force_on_device.to_f64(),
            output.slope_on_device.to_f64() * period,
        ]
    });
    ticks.collect()
}

#[test]
fn single_precision_has_the_slopes_of_double_precision() {
    for (period, stiffness) in [(1e-3, 400.0), (1e-3, 4e3), (5e-3, 400.0)] {
        let (double, single) = (
            bounce::<f64>(period, stiffness),
            bounce::<f32>(period, stiffness),
        );
        let largest = double
            .iter()
            .fold(0.0_f64, |most, tick| most.max(tick[1].abs()));
        let pairs = double.iter().zip(&single);
        let off = pairs.fold(0.0_f64, |most, (a, b)| most.max((a[1] - b[1]).abs()));
        println!("{period} s, {stiffness} N/m: {off} N of {largest} N");
        assert!(largest > 0.05 && off < 0.01 * largest);
    }
}

#[test]
fn what_a_line_excludes_is_refused_by_name() {
    let refused = |loop_params: LoopParams<f64>, params: AnyParams<f64>| {
        let error = AnyRenderer::new(Contact::wall(400.0), loop_params, params).unwrap_err();
        (error.parameter, error.to_string())
    };
    let coupled = AnyParams::Coupled(CoupledParams::new(0.25));
    for (name, method) in methods() {
        if !matches!(method, AnyParams::Coupled(_)) {
            let (parameter, message) = refused(line(PERIOD), method);
            assert_eq!(parameter, Parameter::HoldOrder, "{name}");
            let expected = "order of the hold is 1, but must be 0, a constant: of the methods, only coupled plans a line";
            assert_eq!(message, expected);
        }
    }
    let lag = LoopParams {
        actuation: Actuation::default().with_lag(1e-3).with_line(),
        ..LoopParams::new(PERIOD)
    };
    let slew = LoopParams {
        slew_limit: Some(100.0),
        ..line(PERIOD)
    };
    let guard = LoopParams {
        guard: Guard::Report(GuardParams::by_speed(1.0, 1e-3)),
        ..line(PERIOD)
    };
    for (loop_params, parameter) in [
        (lag, Parameter::Lag),
        (slew, Parameter::SlewLimit),
        (guard, Parameter::GuardSpeed),
    ] {
        let (found, message) = refused(loop_params, coupled);
        assert_eq!(found, parameter);
        assert!(message.contains("with a line hold"), "{message}");
    }
    assert!(AnyRenderer::new(Contact::wall(400.0), line(PERIOD), coupled).is_ok());
    assert_eq!(Hold::named("line"), Some(Hold::Line));
}
