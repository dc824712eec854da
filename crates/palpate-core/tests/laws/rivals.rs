//! Methods of other authors: energy-corrected object, force bounding, midpoint integration, energy tank and virtual
//! coupling.

use crate::common::{PointMass, Random, coupling, tank};
use palpate_core::{
    AnyParams, AnyRenderer, Basis, Contact, EnergyCorrectedParams, EnergyTankParams,
    ForceBoundingParams, HfcrParams, LeakDissipation, LoopParams, MethodName, MidpointDevice,
    ObjectState, Output, ParameterValue, PmiParams, Renderer, Sample, SettingKey, Settings,
    SettingsError, VirtualCouplingParams,
};

const STIFFNESS: f64 = 100.0;
const MASS: f64 = 0.1;
const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;

fn energy_corrected() -> AnyParams<f64> {
    AnyParams::EnergyCorrected(EnergyCorrectedParams {})
}

fn pmi(device: MidpointDevice) -> AnyParams<f64> {
    AnyParams::Pmi(PmiParams { device })
}

fn unlimited(period: f64) -> LoopParams<f64> {
    LoopParams {
        speed_limit: None,
        ..LoopParams::new(period)
    }
}

/// A random contact, loop and motion of the device, with the object's virtual force.
struct Motion {
    contact: Contact<f64>,
    period: f64,
    virtual_force: f64,
    object: ObjectState<f64>,
    device: Vec<f64>,
}

impl Motion {
    fn random(random: &mut Random) -> Self {
        let period = 10f64.powf(random.between(-3.0, -1.7));
        let mass = 10f64.powf(random.between(-1.5, 0.0));
        let object_kappa = 10f64.powf(random.between(-2.0, 0.3));
        let stiffness = object_kappa * mass / (period * period);
        let swing = random.between(0.001, 0.01);
        let rate = random.between(0.02, 0.3);
        Self {
            contact: Contact::object(stiffness, mass),
            period,
            virtual_force: random.between(-2.0, 0.5) * mass * 9.81,
            object: ObjectState {
                position: random.between(-0.5, 2.0) * swing,
                velocity: random.between(-0.2, 0.2),
            },
            device: (0..200)
                .map(|i| swing * (1.0 - (rate * f64::from(i)).cos()))
                .collect(),
        }
    }

    /// Returns the outputs, and the stored energy and the accumulated leak at each sample.
    fn run(&self, method: AnyParams<f64>) -> Vec<(Output<f64>, f64, f64)> {
        let renderer = Renderer::new(self.contact, unlimited(self.period), method).unwrap();
        let mut state = renderer.start(self.object).unwrap();
        let step = |xi: &f64| {
            let sample = Sample::at(*xi).with_virtual_force(self.virtual_force);
            let output = renderer.step(&mut state, sample);
            let ledger = state.ledger();
            (output, ledger.stored, ledger.held_leak.accumulated)
        };
        self.device.iter().map(step).collect()
    }
}

/// Largest difference of the forces of two methods on a wall, relative to the largest force.
fn differ_on_a_wall(one: AnyParams<f64>, other: AnyParams<f64>) -> f64 {
    let mut random = Random(21);
    let mut worst: f64 = 0.0;
    for _ in 0..50 {
        let mut motion = Motion::random(&mut random);
        motion.contact = Contact::wall(motion.contact.stiffness);
        let (one, other) = (motion.run(one), motion.run(other));
        let largest = one.iter().fold(0.0_f64, |most, (output, ..)| {
            most.max(output.force_on_object.abs())
        });
        for ((a, ..), (b, ..)) in one.iter().zip(&other) {
            let off = (a.force_on_object - b.force_on_object).abs();
            worst = worst.max(if off == 0.0 { 0.0 } else { off / largest });
            assert_eq!(a.object_position, b.object_position);
        }
    }
    worst
}

#[test]
fn on_a_wall_the_energy_corrected_object_is_hfcr() {
    let hfcr = AnyParams::Hfcr(HfcrParams::default());
    let off = differ_on_a_wall(energy_corrected(), hfcr);
    assert!(off < 1e-12, "{off}");
}

#[test]
fn on_a_wall_midpoint_integration_is_basic_or_hfcr() {
    let off = differ_on_a_wall(pmi(MidpointDevice::Sample), AnyParams::Basic);
    assert!(off < 1e-12, "{off}");
    let hfcr = AnyParams::Hfcr(HfcrParams::default());
    let off = differ_on_a_wall(pmi(MidpointDevice::Extrapolated), hfcr);
    assert!(off < 1e-12, "{off}");
}

#[test]
fn the_books_of_the_energy_corrected_object_close_but_for_its_debt() {
    let mut random = Random(22);
    let (mut indebted, mut paid) = (0, 0);
    for _ in 0..100 {
        let motion = Motion::random(&mut random);
        let renderer = Renderer::new(
            motion.contact,
            unlimited(motion.period),
            EnergyCorrectedParams {},
        )
        .unwrap();
        let mut state = renderer.start(motion.object).unwrap();
        let mut turned_over = 0.0;
        for xi in &motion.device {
            let sample = Sample::at(*xi).with_virtual_force(motion.virtual_force);
            let output = renderer.step(&mut state, sample);
            let (ledger, debt) = (state.ledger(), state.memory().debt());
            turned_over += ledger.stored + (ledger.held_leak.last).abs();
            let leak = ledger.held_leak.accumulated;
            assert!(debt <= 0.0);
            assert!(
                (leak + debt).abs() <= 1e-12 * turned_over,
                "{leak} J, {debt} J"
            );
            if debt < 0.0 {
                assert_eq!(output.object_velocity, 0.0);
                indebted += 1;
            } else {
                paid += 1;
            }
        }
    }
    println!("{indebted} samples with a debt, {paid} without");
    assert!(indebted > 50 && paid > 10_000);
}

/// The force is the mean spring force of an object and a device at constant velocity: integrated in small steps.
#[test]
fn the_energy_corrected_force_is_the_mean_of_the_spring_force() {
    let mut random = Random(23);
    let mut pressed = 0;
    for _ in 0..40 {
        let motion = Motion::random(&mut random);
        let run = motion.run(energy_corrected());
        let mut last = None;
        for ((output, ..), xi) in run.iter().zip(&motion.device).take(60) {
            let u = (xi - last.unwrap_or(*xi)) / motion.period;
            last = Some(*xi);
            let (mut p, mut w) = (xi - output.object_position, output.object_velocity);
            let palpate_core::Mass::Finite(mass) = motion.contact.object_mass else {
                panic!("no wall")
            };
            let (n, k) = (2000, motion.contact.stiffness);
            let h = motion.period / f64::from(n);
            let mut impulse = 0.0;
            for _ in 0..n {
                // Position Verlet.
                p += 0.5 * h * (u - w);
                let force = k * p.max(0.0);
                impulse += force * h;
                w += h * (motion.virtual_force + force) / mass;
                p += 0.5 * h * (u - w);
            }
            let mean = impulse / motion.period;
            let scale = k * 0.01 + mass * 9.81;
            let off = (output.force_on_object - mean).abs() / scale;
            assert!(off < 2e-5, "{} N, not {mean} N", output.force_on_object);
            pressed += usize::from(mean > 0.0);
        }
    }
    assert!(pressed > 300, "{pressed}");
}

/// The object's energy, with its spring against the device of the midpoint rule, changes by the work on that motion.
#[test]
fn the_books_of_the_midpoint_rule_close() {
    let mut random = Random(24);
    let mut through = [0; 4];
    for device in [MidpointDevice::Sample, MidpointDevice::Extrapolated] {
        for _ in 0..100 {
            let motion = Motion::random(&mut random);
            let palpate_core::Mass::Finite(mass) = motion.contact.object_mass else {
                panic!("no wall")
            };
            let run = motion.run(pmi(device));
            let spring = |p: f64| 0.5 * motion.contact.stiffness * p.max(0.0).powi(2);
            for i in 1..run.len() - 1 {
                let ((now, ..), (next, ..)) = (&run[i], &run[i + 1]);
                let way = match device {
                    MidpointDevice::Sample => 0.0,
                    MidpointDevice::Extrapolated => motion.device[i] - motion.device[i - 1],
                };
                let moved = next.object_position - now.object_position;
                let (p, end) = (now.penetration, now.penetration + way - moved);
                let kinetic = |output: &Output<f64>| 0.5 * mass * output.object_velocity.powi(2);
                let gained = kinetic(next) - kinetic(now) + spring(end) - spring(p);
                let given = motion.virtual_force * moved + now.force_on_object * way;
                let scale = kinetic(next)
                    + kinetic(now)
                    + spring(end)
                    + spring(p)
                    + (motion.virtual_force * moved).abs()
                    + motion.contact.stiffness * 1e-4 * 1e-4;
                assert!(
                    (gained - given).abs() < 1e-11 * scale,
                    "{device:?}: {gained} J for {given} J, {now:?}"
                );
                through[usize::from(p > 0.0) + 2 * usize::from(end > 0.0)] += 1;
            }
        }
    }
    println!("free, leaving, entering, in contact: {through:?}");
    assert!(through.iter().all(|count| *count > 200), "{through:?}");
}

#[test]
fn force_bounding_lets_no_motion_take_more_than_the_device_dissipates() {
    let mut random = Random(25);
    let mut bounded = 0;
    for _ in 0..200 {
        let b = 10f64.powf(random.between(-2.0, 1.0));
        let renderer = Renderer::new(
            Contact::object(STIFFNESS, MASS),
            unlimited(PERIOD),
            ForceBoundingParams { device_damping: b },
        )
        .unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
        let (mut xi, mut before, mut energy) = (0.005, None::<(f64, Output<f64>)>, 0.0);
        for _ in 0..100 {
            let output = renderer.step(&mut state, Sample::at(xi));
            if let Some((last, held)) = &before {
                let way: f64 = xi - last;
                energy += b / PERIOD * way * way + held.force_on_object * way;
                assert!(energy >= -1e-12, "{energy} J");
            }
            if output.penetration <= 0.0 {
                energy = 0.0;
            }
            let spring = STIFFNESS * output.penetration.max(0.0);
            let bound = 2.0 * (b * energy.max(0.0) / PERIOD).sqrt();
            let expected = spring.min(bound);
            assert!(
                (output.force_on_object - expected).abs() < 1e-6 * (1.0 + spring),
                "{} N, not {expected} N",
                output.force_on_object
            );
            bounded += usize::from(bound < spring);
            before = Some((xi, output));
            // The most extracting step, -f T/(2 b), or another one.
            xi += if random.unit() < 0.3 {
                -output.force_on_object * PERIOD / (2.0 * b)
            } else {
                random.between(-0.002, 0.003)
            };
        }
    }
    assert!(bounded > 500, "{bounded}");
}

#[test]
fn the_tank_gives_no_more_than_its_level_and_is_filled_by_the_damper() {
    let EnergyTankParams {
        damping,
        damping_cap,
        initial_energy,
        desired_energy,
    } = tank::<f64>();
    let mut counts = [0; 3];
    for initial_energy in [0.1, 0.3, 1.0].map(|share| share * initial_energy) {
        let params = EnergyTankParams {
            initial_energy,
            ..tank()
        };
        let contact = Contact::object(STIFFNESS, MASS);
        let renderer = Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
        let mut device = PointMass {
            mass: 0.1,
            user_force: 0.981,
            position: 0.0,
            velocity: 0.0,
        };
        let mut last = 0.0;
        for _ in 0..400 {
            let xi = device.position;
            let output = renderer.step(&mut state, Sample::at(xi).with_virtual_force(WEIGHT));
            let v = (xi - last) / PERIOD;
            last = xi;
            device.hold(output.force_on_device, PERIOD);
            if output.penetration <= 0.0 {
                assert_eq!(output.force_on_object, 0.0);
                continue;
            }
            let level = initial_energy - state.ledger().held_leak.accumulated;
            let spring = STIFFNESS * output.penetration;
            let allowed = (level / (v.abs() * PERIOD)).clamp(0.0, spring);
            let extra = (damping * (1.0 - level / desired_energy).max(0.0)).min(damping_cap);
            let expected = allowed + extra * v;
            assert!((output.force_on_object - expected).abs() < 1e-9);
            counts[usize::from(allowed < spring) + usize::from(allowed == 0.0)] += 1;
        }
    }
    println!("spring, limited, empty: {counts:?}");
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
}

/// Proxy and object, integrated in small steps.
#[test]
fn a_virtual_coupling_is_a_proxy_on_a_spring_and_a_damper() {
    let mut random = Random(26);
    let mut touched = 0;
    for _ in 0..20 {
        let motion = Motion::random(&mut random);
        let palpate_core::Mass::Finite(mass) = motion.contact.object_mass else {
            panic!("no wall")
        };
        let k = motion.contact.stiffness;
        let params = coupling(k * random.between(0.3, 3.0), motion.period);
        let VirtualCouplingParams {
            damping: b,
            stiffness,
            mass: of_proxy,
        } = params;
        let run = motion.run(AnyParams::VirtualCoupling(params));
        let (mut x, mut v) = (motion.device[0], 0.0);
        let (mut eta, mut w) = (motion.object.position, motion.object.velocity);
        let mut last = motion.device[0];
        for ((output, ..), xi) in run.iter().zip(&motion.device).take(40) {
            let led = (xi - last) / motion.period;
            last = *xi;
            let force = stiffness * (xi - x) + b * (led - v);
            let scale = 0.01 * (stiffness + k) + force.abs();
            let off = (output.force_on_object - force).abs() / scale;
            assert!(off < 2e-3, "{} N, not {force} N", output.force_on_object);
            let n = 2000;
            let h = motion.period / f64::from(n);
            for _ in 0..n {
                x += 0.5 * h * v;
                eta += 0.5 * h * w;
                let contact = k * (x - eta).max(0.0);
                touched += usize::from(contact > 0.0);
                v += h * (stiffness * (xi - x) + b * (led - v) - contact) / of_proxy;
                w += h * (motion.virtual_force + contact) / mass;
                x += 0.5 * h * v;
                eta += 0.5 * h * w;
            }
        }
    }
    assert!(touched > 100_000, "{touched}");
}

#[test]
fn adaptive_dissipation_grows_with_the_share_of_the_leak() {
    let params = |leak_dissipation| {
        AnyParams::Hfcr(HfcrParams {
            leak_dissipation,
            ..HfcrParams::default()
        })
    };
    let (stiffness, period) = (400.0, 0.02);
    let contact = Contact::object(stiffness, MASS);
    let of = |params| AnyRenderer::new(contact, LoopParams::new(period), params).unwrap();
    let (adaptive, none) = (
        of(params(LeakDissipation::Adaptive)),
        of(params(LeakDissipation::Off)),
    );
    let mut state = adaptive.start(ObjectState::at_rest(0.05)).unwrap();
    let mut device = PointMass {
        mass: 0.25,
        user_force: 1.0,
        position: 0.0,
        velocity: 0.0,
    };
    let (mut last, mut counts) = (0.0, [0; 3]);
    for tick in 0..300 {
        let sample = Sample::at(device.position).with_virtual_force(WEIGHT);
        let plain = none.step(&mut state.clone(), sample).force_on_object;
        let output = adaptive.step(&mut state, sample);
        let v = (device.position - last) / period;
        last = device.position;
        device.hold(output.force_on_device, period);
        if tick == 200 {
            // A hand that extracts energy raises the share of the leak.
            device.velocity = -0.2;
        }
        let (leak, stored) = (state.ledger().held_leak.accumulated, state.ledger().stored);
        let share = match output.phase {
            palpate_core::Phase::Contact => 1.0,
            palpate_core::Phase::Enters => 1.0 - output.transition_after / period,
            palpate_core::Phase::Leaves => output.transition_after / period,
            _ => 0.0,
        };
        let damping = 0.5 * stiffness * period * (leak.max(0.0) / stored).min(1.0);
        let expected = share * damping * (v - output.object_velocity);
        let added = output.force_on_object - plain;
        assert!(
            (added - expected).abs() < 1e-12,
            "{added} N, not {expected} N"
        );
        if share > 0.0 {
            counts[usize::from(leak > 0.0) + usize::from(leak >= stored)] += 1;
        }
    }
    println!("no leak, a share, all: {counts:?}");
    assert!(counts.iter().all(|count| *count > 2), "{counts:?}");
}

/// Returns the ratio of a late to an early deviation of a mass pressed on a wall of this K T^2/m.
fn growth_on_a_wall(kappa: f64, damping: impl Into<ParameterValue<f64>>) -> f64 {
    let (mass, period) = (0.25, 0.001);
    let stiffness = kappa * mass / (period * period);
    let basis = Basis {
        stiffness,
        period,
        device_mass: Some(mass),
        encoder_quantum: 0.0,
        recorded: false,
        stored_energy: 0.0,
    };
    let settings = Settings::default().with(SettingKey::DAMPING, damping);
    let params = MethodName::VirtualDamper
        .params::<f64>(&settings, &basis)
        .unwrap();
    let renderer = Renderer::new(Contact::wall(stiffness), unlimited(period), params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let rest = 0.001;
    let mut device = PointMass {
        mass,
        user_force: stiffness * rest,
        position: rest * (1.0 + 1e-6),
        velocity: 0.0,
    };
    let mut deviations = [0.0_f64; 2];
    for tick in 0..1000 {
        let output = renderer.step(&mut state, Sample::at(device.position));
        device.hold(output.force_on_device, period);
        if tick >= 100 {
            let half = &mut deviations[usize::from(tick >= 550)];
            *half = half.max((device.position - rest).abs());
        }
    }
    deviations[1] / deviations[0]
}

#[test]
fn the_stability_optimal_damper_has_the_stiffest_stable_wall() {
    let optimal = || ParameterValue::Word("stability-optimal");
    let largest = 4.0 * (3.0 - 2.0 * std::f64::consts::SQRT_2);
    assert!(growth_on_a_wall(0.98 * largest, optimal()) < 0.9);
    assert!(growth_on_a_wall(1.02 * largest, optimal()) > 1.1);
    // Other dampings are unstable on a wall that is a little softer.
    let best = 2.0 * (std::f64::consts::SQRT_2 - 1.0) * 0.25 / 0.001;
    assert!(growth_on_a_wall(0.98 * largest, 0.8 * best) > 1.1);
    assert!(growth_on_a_wall(0.98 * largest, 1.2 * best) > 1.1);
}

#[test]
fn a_word_of_another_method_is_refused() {
    let basis = Basis {
        stiffness: 400.0,
        period: 0.001,
        device_mass: Some(0.25),
        encoder_quantum: 0.0,
        recorded: false,
        stored_energy: 0.0,
    };
    let of = |method: MethodName, word: &str| {
        let damping = method.setting(SettingKey::DAMPING).unwrap();
        let given = MethodName::ALL
            .into_iter()
            .find_map(|method| method.setting(SettingKey::DAMPING)?.word(word));
        assert_eq!(damping.key, SettingKey::DAMPING);
        let settings = Settings::default().with(SettingKey::DAMPING, given.unwrap());
        method.params::<f64>(&settings, &basis)
    };
    let words = [
        ("auto", MethodName::Hfcr),
        ("adaptive", MethodName::Hfcr),
        ("stability-optimal", MethodName::VirtualDamper),
    ];
    for (word, accepting) in words {
        for method in MethodName::ALL {
            if !method.uses(SettingKey::DAMPING) {
                continue;
            }
            match of(method, word) {
                Ok(_) => assert_eq!(method, accepting, "{word}"),
                Err(error) => {
                    assert!(matches!(error, SettingsError::NoRule { .. }));
                    let expected = format!(
                        "only {accepting} accepts \"{word}\" for its damping; give {method} a number"
                    );
                    assert_eq!(error.to_string(), expected);
                    assert_ne!(method, accepting);
                }
            }
        }
    }
}
