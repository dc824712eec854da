//! A classical limit, as a check of the whole loop.

use palpate_core::{
    BasicParams, Contact, LoopParams, MethodParams, ObjectState, Renderer, Sample,
    VirtualDamperParams,
};
use palpate_testbed::device::{DevicePlant, PointMass};

const MASS: f64 = 0.25;
const PERIOD: f64 = 1e-3;
const PERIODS: usize = 60_000;

/// Whether an undamped mass, pressed onto a wall of this kappa by a constant force, comes to rest
/// from a disturbance of a thousandth of its penetration; it does not if the disturbance grows
/// tenfold.
fn settles<P: MethodParams<f64>>(kappa: f64, method: P) -> bool {
    let stiffness = kappa * MASS / (PERIOD * PERIOD);
    let pressing = 2.0;
    let rest = pressing / stiffness;
    let renderer =
        Renderer::new(Contact::wall(stiffness), LoopParams::new(PERIOD), method).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    let mut device = PointMass::new(MASS, pressing)
        .and_then(|device| device.starting_at(rest * 1.001, 0.0))
        .unwrap();
    let mut farthest_lately = 0.0_f64;
    for i in 0..PERIODS {
        let output = renderer.step(&mut state, Sample::at(device.position()));
        let away = (output.penetration / rest - 1.0).abs();
        if away > 1e-2 {
            return false;
        }
        if i + 100 > PERIODS {
            farthest_lately = farthest_lately.max(away);
        }
        device.advance(output.force_on_object, PERIOD);
    }
    assert!(farthest_lately < 0.9e-3, "neither grown nor settled");
    true
}

fn damper(beta: f64) -> VirtualDamperParams<f64> {
    VirtualDamperParams::new(beta * MASS / PERIOD)
}

/// Source: Colgate and Schenkel's condition for a backward-difference damper, reduced to an undamped
/// mass; with beta = B T / m: kappa < 2 beta (2 - beta) / (2 + beta), at most 4 (3 - 2 sqrt 2).
///
/// In sustained contact only: collisions are another matter.
#[test]
fn an_undamped_mass_on_a_wall_is_stable_up_to_the_known_stiffness() {
    let best = 2.0 * (2_f64.sqrt() - 1.0);
    for beta in [0.05, 0.2, 0.5, best, 1.2, 1.6, 1.9] {
        let limit = 2.0 * beta * (2.0 - beta) / (2.0 + beta);
        let below = settles(0.99 * limit, damper(beta));
        let above = settles(1.01 * limit, damper(beta));
        eprintln!("beta {beta:.3}: limit {limit:.4}; settles below {below}, above {above}");
        assert!(below && !above);
        assert!(limit <= 4.0 * (3.0 - 2.0 * 2_f64.sqrt()) + 1e-12);
    }
}

/// Source: as above, outside the range of beta.
#[test]
fn without_damping_or_with_too_much_no_stiffness_is_stable() {
    for kappa in [1e-3, 1e-2, 0.1, 0.5, 2.0] {
        assert!(!settles(kappa, BasicParams), "basic, kappa {kappa}");
        assert!(!settles(kappa, damper(0.0)), "B = 0, kappa {kappa}");
        assert!(!settles(kappa, damper(2.1)), "beta 2.1, kappa {kappa}");
    }
}
