//! Classical bounds of stability and passivity, drawn beside a map.
//!
//! All bounds are for a wall and a mass m with viscous friction b, in the parameters of the map: kappa = K T²/m, and
//! βb = b T/m, βB = B T/m for the damping of the device and the virtual damping.

/// Returns the bound of Colgate and Schenkel: passive for b > K T/2 + |B|, that is kappa < 2 (βb − βB); 0 if no
/// stiffness is passive.
#[must_use]
pub fn colgate_schenkel(device: f64, virtual_damping: f64) -> f64 {
    (2.0 * (device - virtual_damping.abs())).max(0.0)
}

/// Returns the bound of HFCR without leak dissipation while contact is sustained: the device's damping dissipates
/// every leak if and only if b > K T, that is kappa < βb, at any object mass (the leak identity of the modified
/// force, `docs/theory.md`). The bound does not cover the leaks at the transitions of a bounce, nor a loop with a
/// delay.
#[must_use]
pub fn hfcr_sustained(device: f64) -> f64 {
    device.max(0.0)
}

/// Returns the bound of Gil: stable for K < (b + B)/(T/2 + t_d), that is kappa < (βb + βB)/(1/2 + t_d/T), for a delay
/// of t_d/T periods. It is valid for small damping of a light device.
#[must_use]
pub fn gil(device: f64, virtual_damping: f64, delay: f64) -> f64 {
    (device + virtual_damping) / (0.5 + delay)
}

/// Returns the bound of Abbott and Okamura: passive for K ≤ min(2 b/T, 2 f_c/q) `[N/m]`, with the Coulomb friction
/// f_c `[N]` and the encoder's quantum q `[m]`; without a quantum the second limit does not apply.
#[must_use]
pub fn abbott_okamura(viscous: f64, coulomb: f64, period: f64, quantum: f64) -> f64 {
    let by_sampling = 2.0 * viscous / period;
    if quantum > 0.0 {
        by_sampling.min(2.0 * coulomb / quantum)
    } else {
        by_sampling
    }
}

/// Returns the bound of an undamped mass pressed against a wall with a backward-difference damper: stable for kappa <
/// 2 β (2 − β)/(2 + β), β = B T/m below 2; unstable for B = 0.
#[must_use]
pub fn undamped_wall(virtual_damping: f64) -> f64 {
    let beta = virtual_damping;
    (2.0 * beta * (2.0 - beta) / (2.0 + beta)).max(0.0)
}

/// Returns the damping that maximises [`undamped_wall`], β = 2 (√2 − 1).
#[must_use]
pub fn best_undamped_damping() -> f64 {
    2.0 * (2.0_f64.sqrt() - 1.0)
}

/// Returns the maximum of [`undamped_wall`], 4 (3 − 2√2).
#[must_use]
pub fn stiffest_undamped_wall() -> f64 {
    undamped_wall(best_undamped_damping())
}

/// Returns the least mass of an object that a strictly causal integrator moves, `K T^2/4` `[kg]`, that is Kc = 4, for a
/// `stiffness` `[N/m]` and a `period` `[s]`.
///
/// The admittance of such an integrator, T/(M (z - 1)), has the real part -T/(2M) at every frequency, so it is not
/// passive, and no other strictly causal one is (Brown and Colgate, 1998). Behind a damping B it is passive for M >= B
/// T/2; here B is that of a passive wall, K T/2. The exact motion has no such bound.
#[must_use]
pub fn least_explicit_mass(stiffness: f64, period: f64) -> f64 {
    0.25 * stiffness * period * period
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stiffest_undamped_wall_is_a_maximum() {
        let most = stiffest_undamped_wall();
        assert!((most - 0.686_291_501).abs() < 1e-9);
        let best = (1..2000)
            .map(|i| undamped_wall(f64::from(i) * 1e-3))
            .fold(0.0, f64::max);
        assert!(best <= most && most - best < 1e-6);
        assert_eq!(undamped_wall(0.0), 0.0);
        assert_eq!(undamped_wall(3.0), 0.0);
    }

    #[test]
    fn bounds_agree_with_their_dimensional_forms() {
        let (m, t, b, big_b) = (0.25, 0.02, 3.0, 1.0);
        let kappa = |stiffness: f64| stiffness * t * t / m;
        let of = |damping: f64| damping * t / m;
        assert!((colgate_schenkel(of(b), of(big_b)) - kappa(2.0 * (b - big_b) / t)).abs() < 1e-12);
        assert!((gil(of(b), of(big_b), 1.0) - kappa((b + big_b) / (1.5 * t))).abs() < 1e-12);
        assert!((hfcr_sustained(of(b)) - kappa(b / t)).abs() < 1e-12);
        assert_eq!(colgate_schenkel(0.1, -0.2), 0.0);
        assert_eq!(abbott_okamura(1.0, 0.1, 0.001, 1e-4), 2000.0);
        assert_eq!(abbott_okamura(1.0, 0.01, 0.001, 1e-4), 200.0);
        assert_eq!(abbott_okamura(1.0, 0.0, 0.001, 0.0), 2000.0);
    }
}
