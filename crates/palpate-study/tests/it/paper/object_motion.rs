//! A(T) and b(T) of Eqs. (4) and (6a), as the object of a renderer shows them, against a step by
//! step integration.

use palpate_core::{AnyParams, HfcrParams, ObjectState, Phase, VirtualDamperParams};

use crate::common::Random;
use crate::paper::trial::{Case, Trial};

/// `M eta'' = f_V + K (xi - eta) + B (v - eta')` by classical Runge-Kutta from `state` over
/// `duration`, with everything but the object held; without `spring`, only f_V acts.
fn integrate(
    case: &Case,
    spring: Option<(f64, f64, f64)>,
    state: ObjectState<f64>,
    duration: f64,
) -> ObjectState<f64> {
    if case.mass.is_infinite() {
        return state;
    }
    let acceleration = |position: f64, velocity: f64| {
        let spring = spring.map_or(0.0, |(device, device_velocity, damping)| {
            case.stiffness * (device - position) + damping * (device_velocity - velocity)
        });
        (case.virtual_force + spring) / case.mass
    };
    let steps = 4000;
    let h = duration / f64::from(steps);
    let (mut x, mut v) = (state.position, state.velocity);
    for _ in 0..steps {
        let (x1, v1) = (v, acceleration(x, v));
        let (x2, v2) = (
            v + 0.5 * h * v1,
            acceleration(x + 0.5 * h * x1, v + 0.5 * h * v1),
        );
        let (x3, v3) = (
            v + 0.5 * h * v2,
            acceleration(x + 0.5 * h * x2, v + 0.5 * h * v2),
        );
        let (x4, v4) = (v + h * v3, acceleration(x + h * x3, v + h * v3));
        x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4);
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    }
    ObjectState {
        position: x,
        velocity: v,
    }
}

/// Source: Eqs. (4) and (6a), and the transition rule.
#[test]
fn the_object_moves_as_its_equation_of_motion_says() {
    let mut random = Random(6);
    let mut met = std::collections::BTreeMap::<String, (usize, f64)>::new();
    for _ in 0..3000 {
        let case = Case::random(&mut random);
        let mut trial = Trial::new(&case, AnyParams::Hfcr(HfcrParams::default()));
        let before = random.between(-1e-3, 1e-3);
        let now = before + random.between(-1e-3, 1e-3);
        trial.at(before);
        let output = trial.at(now);
        let velocity = (now - before) / case.period;
        let start = crate::paper::trial::object(&output);
        let tau = output.transition_after;
        let held = Some((now, 0.0, 0.0));
        let (row, expected) = match output.phase {
            Phase::Free => ("free", integrate(&case, None, start, case.period)),
            Phase::Contact => ("contact", integrate(&case, held, start, case.period)),
            Phase::Enters => {
                let touch = integrate(&case, None, start, tau);
                let device = now + velocity * tau;
                assert!(
                    (device - touch.position).abs() < 1e-12,
                    "not at the surface"
                );
                let spring = Some((device, 0.0, 0.0));
                ("enters", integrate(&case, spring, touch, case.period - tau))
            }
            Phase::Leaves => {
                let apart = integrate(&case, held, start, tau);
                assert!(
                    (now + velocity * tau - apart.position).abs() < 1e-9,
                    "not at the surface"
                );
                ("leaves", integrate(&case, None, apart, case.period - tau))
            }
            Phase::Waiting => unreachable!("no sample is refused"),
        };
        let next = crate::paper::trial::object(&trial.peek(now).0);
        let speed = start.velocity.abs().max(1e-3 / case.period);
        let error = ((next.position - expected.position).abs() / 1e-3)
            .max((next.velocity - expected.velocity).abs() / speed);
        assert!(
            error < 1e-8,
            "{row}: {next:?} instead of {expected:?}, {case:?}"
        );
        let (count, worst) = met.entry(row.to_owned()).or_default();
        *count += 1;
        *worst = worst.max(error);
    }
    for (row, (count, worst)) in &met {
        eprintln!("{row}: {count} intervals, largest error {worst:.1e}");
        assert!(*count >= 50, "{row} was met only {count} times");
    }
    assert_eq!(met.len(), 4);
}

/// Source: Eq. (3) with the object's motion in closed form; derived here. The damping ratio
/// `B / (2 sqrt(K M))` goes from under-damped over critical to far over-damped.
#[test]
fn a_damped_contact_moves_as_its_equation_of_motion_says() {
    let mut random = Random(7);
    for ratio in [0.0, 1e-3, 0.3, 0.999_999, 1.0, 1.000_001, 3.0, 30.0] {
        let mut worst = 0.0_f64;
        for _ in 0..100 {
            let mut case = Case::random(&mut random);
            // Slow enough for the integration: the fastest rate is 2 ratio Omega.
            case.mass = case.stiffness * case.period * case.period / random.decades(1e-4, 1.0);
            case.virtual_force *= 1e-3 * case.stiffness / case.virtual_force.abs();
            case.object = ObjectState::at_rest(random.between(-2e-3, -1e-3));
            let damping = 2.0 * ratio * (case.stiffness * case.mass).sqrt();
            let params = AnyParams::VirtualDamper(VirtualDamperParams::new(damping));
            let mut trial = Trial::new(&case, params);
            let before = random.between(0.0, 1e-3);
            let now = before + random.between(-1e-3, 1e-3);
            trial.at(before);
            let output = trial.at(now);
            if output.phase != Phase::Contact {
                continue;
            }
            let velocity = (now - before) / case.period;
            let spring = Some((now, velocity, damping));
            let expected = integrate(
                &case,
                spring,
                crate::paper::trial::object(&output),
                case.period,
            );
            let next = crate::paper::trial::object(&trial.peek(now).0);
            let error = ((next.position - expected.position).abs() / 1e-3)
                .max((next.velocity - expected.velocity).abs() * case.period / 1e-3);
            assert!(
                error < 1e-8,
                "ratio {ratio}: {next:?} for {expected:?}, {case:?}"
            );
            worst = worst.max(error);
        }
        eprintln!("damping ratio {ratio}: largest error {worst:.1e}");
    }
}
