//! Force fields on tools.

use std::f64::consts::PI;

use palpate_world::{
    BasicParams, CoupledParams, Field, FieldKind, Free, GodObjectParams, HfcrParams, PopcParams,
    Sample, SehParams, Shape, Tool, Vector, VirtualCouplingParams, World, WorldField, WorldGuard,
    WorldGuardParams, WorldLoop, WorldMethod, WorldPart, WorldRenderer, WorldState,
};

use crate::common::ball;

/// Mass of the device `[kg]`.
const MASS: f64 = 0.1;
const POINT: FieldKind = FieldKind::Point {
    at: [0.01, 0.0, -0.02],
    stiffness: 200.0,
    range: 0.05,
};
const DETENTS: FieldKind = FieldKind::Detents {
    at: [0.0; 3],
    axis: [1.0, 0.0, 0.0],
    positions: 5,
    period: 0.005,
    amplitude: 0.002,
    stiffness: 2000.0,
};

fn world(kinds: &[FieldKind]) -> World {
    let fields = kinds.iter().map(|&kind| Field {
        tool: "tool".into(),
        kind,
    });
    World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
        fields: fields.collect(),
        ..World::default()
    }
}

/// Returns coupled rendering that assumes 1.5 times the mass of the device.
fn with_a_heavy_model() -> WorldMethod {
    CoupledParams::new(vec![[1.5 * MASS; 3]]).into()
}

/// Energy of the fields, by their documented formulas.
fn energy(kind: &FieldKind, place: &Vector) -> f64 {
    let of_spring = |square: f64, stiffness: f64, range: f64| {
        let distance = square.sqrt();
        if distance < range {
            0.5 * stiffness * square
        } else {
            stiffness * range * (distance - 0.5 * range)
        }
    };
    let dot = |one: &Vector, other: &Vector| (0..3).map(|i| one[i] * other[i]).sum::<f64>();
    let from = |at: &Vector| [0, 1, 2].map(|i| place[i] - at[i]);
    match kind {
        FieldKind::Point {
            at,
            stiffness,
            range,
        } => of_spring(dot(&from(at), &from(at)), *stiffness, *range),
        FieldKind::Line {
            at,
            axis,
            stiffness,
            range,
        } => {
            let off = from(at);
            let square = dot(&off, &off) - dot(&off, axis).powi(2);
            of_spring(square.max(0.0), *stiffness, *range)
        }
        FieldKind::Plane {
            at,
            normal,
            stiffness,
            range,
        } => of_spring(dot(&from(at), normal).powi(2), *stiffness, *range),
        FieldKind::Detents {
            at,
            axis,
            positions,
            period,
            amplitude,
            stiffness,
        } => {
            let q = dot(&from(at), axis);
            let last = f64::from(*positions - 1) * period;
            if q < 0.0 {
                0.5 * stiffness * q * q
            } else if q > last {
                0.5 * stiffness * (q - last).powi(2)
            } else {
                0.5 * amplitude * (1.0 - (2.0 * PI * q / period).cos())
            }
        }
        FieldKind::Constant { force } => -dot(force, place),
    }
}

/// A device without a hand under held forces.
struct Device {
    position: Vector,
    velocity: Vector,
    /// Work of the held forces `[J]`.
    work: f64,
}

impl Device {
    fn at(position: Vector) -> Self {
        Self {
            position,
            velocity: [0.0; 3],
            work: 0.0,
        }
    }

    fn hold(&mut self, force: &Vector, period: f64) {
        for (axis, force) in force.iter().enumerate() {
            let acceleration = force / MASS;
            let way = self.velocity[axis] * period + 0.5 * acceleration * period * period;
            self.position[axis] += way;
            self.velocity[axis] += acceleration * period;
            self.work += force * way;
        }
    }

    fn kinetic(&self) -> f64 {
        0.5 * MASS * self.velocity.iter().map(|v| v * v).sum::<f64>()
    }
}

/// Runs a device from rest in `kinds` for `duration` `[s]`. Returns the energy of device and fields, the force and
/// the position at each sample, and the final states.
fn run(
    kinds: &[FieldKind],
    method: WorldMethod,
    start: Vector,
    (rate, duration): (f64, f64),
) -> (Vec<f64>, Vec<Vector>, Vec<Vector>, (WorldState, Device)) {
    let loop_params = WorldLoop::new(1.0 / rate);
    let (energies, forces, places, end, _) = run_in(loop_params, kinds, method, start, duration);
    (energies, forces, places, end)
}

/// Energies, forces, positions, final states, and the number of samples at which a guard acted.
type GuardedRun = (
    Vec<f64>,
    Vec<Vector>,
    Vec<Vector>,
    (WorldState, Device),
    usize,
);

/// Runs a device as [`run`] does, in another loop. Returns in addition the number of samples at which a guard acted.
fn run_in(
    loop_params: WorldLoop,
    kinds: &[FieldKind],
    method: WorldMethod,
    start: Vector,
    duration: f64,
) -> GuardedRun {
    let (period, mut guarded) = (loop_params.period, 0);
    let renderer = WorldRenderer::new(&world(kinds), loop_params, method).unwrap();
    let mut state = renderer.start();
    let mut device = Device::at(start);
    let (mut energies, mut forces, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..(duration / period).round() as usize {
        let output = renderer.step(&mut state, &Sample::at(&[device.position]));
        assert_eq!(output.fault, None);
        let force = output.forces[0];
        guarded += usize::from(output.limited.guard);
        let there: f64 = kinds
            .iter()
            .map(|kind| energy(kind, &device.position))
            .sum();
        energies.push(device.kinetic() + there);
        forces.push(force);
        places.push(device.position);
        device.hold(&force, period);
    }
    // The last sample concludes the last interval.
    let _ = renderer.step(&mut state, &Sample::at(&[device.position]));
    (energies, forces, places, (state, device), guarded)
}

#[test]
fn a_tool_in_a_field_keeps_its_energy_with_another_model_mass() {
    for (name, kind, start) in [
        ("point", POINT, [0.02, 0.005, -0.02]),
        ("detent", DETENTS, [0.0112, 0.0, 0.0]),
    ] {
        let (energies, ..) = run(&[kind], with_a_heavy_model(), start, (1000.0, 3.0));
        let last = &energies[energies.len() - 1000..];
        let mean = last.iter().sum::<f64>() / last.len() as f64;
        let (basic, ..) = run(&[kind], BasicParams::default().into(), start, (1000.0, 1.0));
        let ratio = mean / energies[0];
        println!(
            "{name}: {ratio} of the energy after 3 s, basic {}",
            basic.last().unwrap() / basic[0]
        );
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
        assert!(basic.last().unwrap() / basic[0] > 1.05);
    }
}

/// Returns the mean force of the ideal motion from rest over each period, along x `[N]`, and the integral of its square
/// over time. The motion is along x.
fn ideal(kind: &FieldKind, start: Vector, (rate, duration): (f64, f64)) -> (Vec<f64>, f64) {
    const STEPS: usize = 64;
    let (near, step) = (1e-7, 1.0 / (rate * STEPS as f64));
    let force = |x: f64| {
        let at = |x: f64| energy(kind, &[x, start[1], start[2]]);
        (at(x - near) - at(x + near)) / (2.0 * near)
    };
    let (mut x, mut v, mut squares) = (start[0], 0.0, 0.0);
    let means = (0..(duration * rate) as usize).map(|_| {
        let before = v;
        for _ in 0..STEPS {
            // Fourth order, by Runge, Kutta and Nystrom.
            let first = force(x) / MASS;
            let middle = force(x + 0.5 * step * v + step * step * first / 8.0) / MASS;
            let last = force(x + step * v + 0.5 * step * step * middle) / MASS;
            x += step * (v + step * (first + 2.0 * middle) / 6.0);
            v += step * (first + 4.0 * middle + last) / 6.0;
            squares +=
                step * (MASS * MASS) * (first.powi(2) + 4.0 * middle.powi(2) + last.powi(2)) / 6.0;
        }
        MASS * (v - before) * rate
    });
    (means.collect(), squares)
}

/// Returns the error E of the mean force.
fn mean_force_error(
    kind: FieldKind,
    method: WorldMethod,
    start: Vector,
    (rate, duration): (f64, f64),
) -> f64 {
    let (means, squares) = ideal(&kind, start, (rate, duration));
    let (_, forces, ..) = run(&[kind], method, start, (rate, duration));
    let errors = forces
        .iter()
        .zip(&means)
        .map(|(force, mean)| (force[0] - mean).powi(2));
    (errors.sum::<f64>() / rate / squares).sqrt()
}

#[test]
fn the_mean_force_of_a_field_is_within_1_percent_with_another_model_mass() {
    for (name, kind, start) in [
        ("point", POINT, [0.03, 0.0, -0.02]),
        ("detent", DETENTS, [0.0112, 0.0, 0.0]),
        ("past detents to both stops", DETENTS, [-0.002, 0.0, 0.0]),
    ] {
        let of = |method| mean_force_error(kind, method, start, (1000.0, 0.5));
        let error = of(with_a_heavy_model());
        let known = of(CoupledParams::new(vec![[MASS; 3]]).into());
        let basic = of(BasicParams::default().into());
        println!(
            "{name}: E {:.3} %, of the known mass {:.3} %, basic {:.1} %",
            100.0 * error,
            100.0 * known,
            100.0 * basic
        );
        assert!(error < 0.01, "{name}: {error}");
    }
}

#[test]
fn an_oscillation_around_a_detent_never_grows_at_any_rate() {
    // At 50 Hz the soft detent has 7 samples per oscillation, as the other one at 140 Hz.
    let soft = FieldKind::Detents {
        at: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        positions: 5,
        period: 0.01,
        amplitude: 0.001,
        stiffness: 200.0,
    };
    for (kind, least, from) in [(soft, 50.0, 0.012), (DETENTS, 200.0, 0.0062)] {
        let FieldKind::Detents { period: apart, .. } = kind else {
            unreachable!()
        };
        for rate in [50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 4000.0] {
            for factor in [1.0, 1.5] {
                if rate < least {
                    continue;
                }
                let method = CoupledParams::new(vec![[factor * MASS; 3]]);
                let (_, _, places, ..) = run(&[kind], method.into(), [from, 0.0, 0.0], (rate, 2.0));
                let mut amplitudes = places.chunks((rate / 2.0) as usize).map(|window| {
                    let off = window.iter().map(|place| (place[0] - apart).abs());
                    off.fold(0.0, f64::max) / (from - apart)
                });
                let most = amplitudes.clone().fold(0.0, f64::max);
                // Until the mass is learned, the amplitude may exceed the first one by parts per million.
                assert!(most < 1.0 + 1e-5, "{rate} Hz, told {factor}: {most}");
                let last = amplitudes.next_back().unwrap();
                assert!(last > 0.9, "{rate} Hz, told {factor}: {last}");
            }
        }
    }
}

#[test]
fn the_books_of_fields_close() {
    let kinds = [
        POINT,
        DETENTS,
        FieldKind::Line {
            at: [0.0, 0.002, 0.0],
            axis: [0.0, 0.6, 0.8],
            stiffness: 100.0,
            range: 0.004,
        },
        FieldKind::Plane {
            at: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            stiffness: 300.0,
            range: 0.003,
        },
        FieldKind::Constant {
            force: [0.1, -0.2, 0.05],
        },
    ];
    for method in [with_a_heavy_model(), BasicParams::default().into()] {
        let start = [0.013, 0.004, 0.006];
        let name = method.name();
        let (.., (state, device)) = run(&kinds, method, start, (500.0, 0.4));
        let ledger = state.ledger();
        let port = ledger.devices[0];
        let mut turnover = 0.0;
        for entry in &ledger.fields {
            turnover += entry.work.abs() + entry.held.abs() + entry.observed.abs();
            let sum =
                entry.observed + entry.outside + entry.supplied - entry.work + entry.step_error;
            assert!(
                (entry.stored - sum).abs() < 1e-9 * (1e-3 + entry.stored),
                "{name}: {entry:?}"
            );
        }
        let held: f64 = ledger.fields.iter().map(|entry| entry.held).sum();
        let work: f64 = ledger.fields.iter().map(|entry| entry.work).sum();
        let close = |one: f64, other: f64, what: &str| {
            assert!(
                (one - other).abs() < 1e-9 * turnover,
                "{name}, {what}: {one} {other}"
            );
        };
        // Nothing but the port moves the device.
        close(port.port_work, device.work, "port");
        close(port.port_work, device.kinetic(), "kinetic");
        close(port.held, held, "held");
        close(
            port.port_work + port.carried,
            port.held + port.unforeseen,
            "unforeseen",
        );
        if name == "coupled" {
            let gained = port.offset - port.velocity_offset + port.unpaid;
            close(port.held - work, gained, "offset");
        } else {
            let there: f64 = kinds[..4]
                .iter()
                .map(|kind| energy(kind, &device.position))
                .sum();
            let stored: f64 = ledger.fields.iter().map(|entry| entry.stored).sum();
            close(stored, there, "stored");
        }
        let created = ledger.created();
        let each = ledger
            .fields
            .iter()
            .map(|entry| entry.observed + entry.step_error);
        close(
            created,
            port.port_work - work + each.sum::<f64>(),
            "created",
        );
    }
}

#[test]
fn methods_without_fields_refuse_them_by_name() {
    let methods: [WorldMethod; 5] = [
        VirtualCouplingParams::default().into(),
        GodObjectParams::default().into(),
        SehParams.into(),
        PopcParams::new(vec![10.0]).into(),
        HfcrParams::default().into(),
    ];
    for method in methods {
        let name = method.name();
        let refused = WorldRenderer::new(&world(&[POINT]), WorldLoop::new(0.001), method);
        let faults = refused.err().unwrap();
        let fault = faults.first();
        assert_eq!(
            (fault.part, fault.field),
            (WorldPart::Method, WorldField::Method)
        );
        let expected = format!("{name} renders no force fields, and the world has 1");
        assert!(fault.message.starts_with(&expected), "{fault}");
    }
}

#[test]
fn a_wrong_field_is_refused_with_all_its_faults() {
    let bad = FieldKind::Detents {
        at: [f64::NAN, 0.0, 0.0],
        axis: [1.0, 1.0, 0.0],
        positions: 0,
        period: 0.0,
        amplitude: -1.0,
        stiffness: -1.0,
    };
    let mut wrong = world(&[bad, POINT, POINT]);
    wrong.fields[1].tool = "nobody".into();
    wrong.fields[2].tool = "ball".into();
    wrong.bodies.push(ball("ball", 0.01, Free::of_mass(0.1)));
    let faults = wrong.check().err().unwrap();
    let found: Vec<_> = faults
        .iter()
        .map(|fault| (fault.part, fault.field))
        .collect();
    let first = [
        WorldField::At,
        WorldField::Axis,
        WorldField::Positions,
        WorldField::Period,
        WorldField::Amplitude,
        WorldField::Stiffness,
    ];
    let mut expected: Vec<_> = first.map(|field| (WorldPart::Field(0), field)).into();
    expected.push((WorldPart::Field(1), WorldField::Tool));
    expected.push((WorldPart::Field(2), WorldField::Tool));
    assert_eq!(found, expected);
    let last = faults.iter().last().unwrap().to_string();
    assert_eq!(
        last,
        "field 2 on \"ball\": \"ball\" is a body; a field acts on a tool"
    );
}

#[test]
fn a_force_limit_on_a_field_is_reported() {
    let renderer = WorldRenderer::new(
        &world(&[POINT]),
        WorldLoop::new(0.001).with_force_limits(vec![1.0]),
        with_a_heavy_model(),
    )
    .unwrap();
    let mut state = renderer.start();
    let mut limited = false;
    for _ in 0..10 {
        let output = renderer.step(&mut state, &Sample::at(&[[0.03, 0.0, -0.02]]));
        let force = output.forces[0].iter().map(|f| f * f).sum::<f64>().sqrt();
        assert!(force <= 1.0 + 1e-12, "{force}");
        limited = output.limited.force;
    }
    assert!(limited);
}

#[test]
fn a_changed_field_goes_on_and_its_energy_comes_from_outside() {
    let renderer = WorldRenderer::new(
        &world(&[POINT, DETENTS]),
        WorldLoop::new(0.001),
        with_a_heavy_model(),
    )
    .unwrap();
    let mut state = renderer.start();
    let place = [0.02, 0.0, -0.02];
    let _ = renderer.step(&mut state, &Sample::at(&[place]));
    let _ = renderer.step(&mut state, &Sample::at(&[place]));
    let before = state.ledger().clone();
    let stiffer = FieldKind::Point {
        at: [0.01, 0.0, -0.02],
        stiffness: 300.0,
        range: 0.05,
    };
    let (_, changed) = renderer.changed(&state, &world(&[stiffer])).unwrap();
    let after = changed.ledger();
    let (one, other) = (&before.fields[0], &after.fields[0]);
    assert!((one.stored - 0.01).abs() < 1e-4 && (other.stored / one.stored - 1.5).abs() < 1e-9);
    assert_eq!(other.outside, other.stored - one.stored);
    assert_eq!((one.work, one.held), (other.work, other.held));
    assert_eq!(after.gone.fields.outside, -before.fields[1].stored);
    assert_eq!(after.gone.fields.work, before.fields[1].work);
}

#[test]
fn a_fast_pass_over_detents_is_sub_stepped() {
    let detents = FieldKind::Detents {
        at: [-1.0, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        positions: 1001,
        period: 0.002,
        amplitude: 1e-5,
        stiffness: 0.0,
    };
    let renderer = WorldRenderer::new(
        &world(&[detents]),
        WorldLoop::new(0.001),
        with_a_heavy_model(),
    )
    .unwrap();
    let mut state = renderer.start();
    let mut passed = |speed: f64| {
        let mut most = 0;
        for sample in 0..100 {
            let place = speed * 0.001 * f64::from(sample);
            let output = renderer.step(&mut state, &Sample::at(&[[place, 0.0, 0.0]]));
            assert_eq!(output.fault, None);
            most = most.max(output.effort.sub_steps);
        }
        most
    };
    // A tick has two intervals of at least 16 sub-steps. At 0.5 m/s the phase of a period is 1.6 rad.
    let (slow, fast) = (passed(0.005), passed(0.5));
    assert!(slow < 40 && fast > 90, "{slow} {fast}");
}

#[test]
fn the_guard_allows_the_energy_of_fields_and_no_more() {
    let allowance = 0.003;
    let push = FieldKind::Constant {
        force: [0.5, 0.0, -0.2],
    };
    // How often the guard acts, and the energy given to the hand beyond that stored at the start.
    let of = |kind, method, duration| {
        let guard = WorldGuardParams::by_speed(1.0, 1.0, allowance);
        let guarded = WorldLoop::new(0.001).with_guard(WorldGuard::Limit(guard));
        let (energies, .., (_, device), acted) =
            run_in(guarded, &[kind], method, [0.02, 0.005, -0.02], duration);
        (acted, device.work - energies[0])
    };
    for kind in [POINT, push] {
        let (acted, _) = of(kind, with_a_heavy_model(), 0.15);
        assert_eq!(acted, 0, "{kind:?}");
    }
    let (acted, gained) = of(POINT, BasicParams::default().into(), 2.0);
    assert!(acted > 0 && gained < allowance, "{acted} {gained}");
}
