//! Energy of the bounce, and classification of a loop by its growth.

/// Largest growth per collision of a stable loop. The tolerance allows for rebounds that are exact only on average:
/// over 20 collisions the energy grows by less than a quarter.
pub const STABLE_UP_TO: f64 = 1.01;

/// Ratio of energy to initial energy above which a loop has diverged.
pub(super) const DIVERGED_ABOVE: f64 = 10.0;

/// Class of a bounce.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Its energy does not grow.
    Stable,
    /// Its energy grows.
    Growing,
    /// Its energy has exceeded ten times its initial energy.
    Diverged,
}

/// Returns the class of a growth per collision; infinite growth is diverged.
#[must_use]
pub fn classify(growth: f64) -> Class {
    if growth <= STABLE_UP_TO {
        Class::Stable
    } else if growth.is_finite() {
        Class::Growing
    } else {
        Class::Diverged
    }
}

/// Energy of the relative motion of device and object, above their state of rest.
///
/// With the reduced mass µ, 1/µ = 1/m + 1/M, and the instantaneous relative acceleration a by all other forces,
/// friction included,
///
/// ```text
/// R = µ p′²/2 + K (p − µa/K)²/2           while p > 0
/// R = µ p′²/2 − µ a p + (µa)²/(2K)        while p ≤ 0
/// ```
///
/// It is the part of the mechanical energy that a contact can change. The energy of the centre of mass is excluded,
/// because constant forces change it and it depends on the frame of reference. R is constant in an ideal bounce
/// without friction, and 0 if the object rests on the device.
#[derive(Clone, Copy, Debug)]
pub(super) struct BounceEnergy {
    pub stiffness: f64,
    pub device_mass: f64,
    pub user_force: f64,
    pub viscous_friction: f64,
    pub coulomb_friction: f64,
    /// f_V/M `[m/s²]`; 0 for a wall.
    pub object_acceleration: f64,
    /// 1/M `[1/kg]`; 0 for a wall.
    pub object_mobility: f64,
}

impl BounceEnergy {
    /// Returns R `[J]` at a penetration `[m]`, its rate and the device's velocity `[m/s]`.
    #[inline]
    pub fn of(&self, penetration: f64, approach: f64, device_velocity: f64) -> f64 {
        let dry = if device_velocity == 0.0 {
            0.0
        } else {
            self.coulomb_friction.copysign(device_velocity)
        };
        let push = self.user_force - self.viscous_friction * device_velocity - dry;
        // Without a pressing force every separation is a state of rest.
        let acceleration = (push / self.device_mass - self.object_acceleration).max(0.0);
        let reduced_mass = 1.0 / (1.0 / self.device_mass + self.object_mobility);
        let weight = reduced_mass * acceleration;
        let kinetic = 0.5 * reduced_mass * approach * approach;
        if penetration > 0.0 {
            let from_rest = penetration - weight / self.stiffness;
            kinetic + 0.5 * self.stiffness * from_rest * from_rest
        } else {
            kinetic - weight * penetration + 0.5 * weight * weight / self.stiffness
        }
    }
}

/// Accumulates the energy growth of a bounce over a window without storing samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct GrowthMeter {
    at_start: f64,
    sum: f64,
    count: f64,
    diverged: bool,
}

impl GrowthMeter {
    /// Creates a meter for a bounce with this initial energy `[J]`.
    pub fn new(at_start: f64) -> Self {
        Self {
            at_start,
            sum: 0.0,
            count: 0.0,
            diverged: false,
        }
    }

    /// Adds the energy `[J]` at a sample; `counts` marks samples of the last cycle.
    #[inline]
    pub fn sample(&mut self, energy: f64, counts: bool) {
        if counts {
            self.sum += energy;
            self.count += 1.0;
        }
        // The comparison is false for NaN, which also counts as diverged.
        let bounded = energy <= DIVERGED_ABOVE * self.at_start;
        self.diverged |= !bounded;
    }

    /// Marks the loop as diverged for a reason other than its energy.
    pub fn give_up(&mut self) {
        self.diverged = true;
    }

    pub fn has_diverged(&self) -> bool {
        self.diverged
    }

    /// Returns the geometric mean of the growth per collision over `collisions`; infinite if the loop diverged.
    pub fn growth(&self, collisions: usize) -> f64 {
        if self.diverged {
            f64::INFINITY
        } else {
            (self.sum / self.count / self.at_start).powf(1.0 / collisions as f64)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENERGY: BounceEnergy = BounceEnergy {
        stiffness: 100.0,
        device_mass: 0.25,
        user_force: 1.0,
        viscous_friction: 0.5,
        coulomb_friction: 0.0,
        object_acceleration: -9.81,
        object_mobility: 10.0,
    };

    #[test]
    fn at_rest_there_is_none() {
        // µ = 1/14 kg, a = 4 + 9.81 m/s²
        let rest = 13.81 / 14.0 / 100.0;
        assert!(ENERGY.of(rest, 0.0, 0.0).abs() < 1e-18);
        assert!(ENERGY.of(rest, 0.1, 0.0) > 0.0);
    }

    #[test]
    fn a_fall_turns_height_into_speed_and_speed_into_spring() {
        let weight = 13.81 / 14.0;
        let high = ENERGY.of(-0.05, 0.0, 0.0);
        let speed = (2.0 * 13.81 * 0.05_f64).sqrt();
        let at_touch = ENERGY.of(0.0, speed, 0.0);
        let amplitude = (speed * speed / 1400.0 + (weight / 100.0_f64).powi(2)).sqrt();
        let deepest = ENERGY.of(weight / 100.0 + amplitude, 0.0, 0.0);
        assert!((high / at_touch - 1.0).abs() < 1e-14);
        assert!((high / deepest - 1.0).abs() < 1e-14);
    }

    #[test]
    fn friction_moves_the_state_of_rest() {
        // At 2 m/s the friction cancels the user's force: only the object's weight presses.
        let rest = 9.81 / 14.0 / 100.0;
        assert!(ENERGY.of(rest, 0.0, 2.0).abs() < 1e-18);
    }

    #[test]
    fn growth_is_a_geometric_mean_and_divergence_is_not_forgotten() {
        let mut meter = GrowthMeter::new(2.0);
        meter.sample(8.0, false);
        meter.sample(3.0, true);
        meter.sample(5.0, true);
        assert!((meter.growth(2) - 2.0_f64.sqrt()).abs() < 1e-15);
        meter.sample(20.1, false);
        meter.sample(2.0, true);
        assert_eq!(meter.growth(2), f64::INFINITY);
        let mut lost = GrowthMeter::new(2.0);
        lost.sample(f64::NAN, false);
        assert!(lost.has_diverged());
    }

    #[test]
    fn classes_meet_at_their_limits() {
        assert_eq!(classify(0.0), Class::Stable);
        assert_eq!(classify(STABLE_UP_TO), Class::Stable);
        assert_eq!(classify(1.0101), Class::Growing);
        assert_eq!(classify(f64::INFINITY), Class::Diverged);
        assert!(Class::Stable < Class::Growing && Class::Growing < Class::Diverged);
    }
}
