//! Conversion between force and duty of a motor driver.

/// A motor driver whose current, and thus force, is proportional to its duty.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Force at the rim at full duty `[N]`.
    pub full_force: f32,
    /// Full duty: the period of the PWM timer, in its counts.
    pub full_duty: i16,
}

impl Drive {
    /// Returns the duty nearest to `force` on the rim `[N]`, at most full; 0 for NaN.
    pub fn duty(&self, force: f32) -> i16 {
        let full = f32::from(self.full_duty);
        let wanted = (force / self.full_force * full).clamp(-full, full);
        let half = if wanted < 0.0 { -0.5 } else { 0.5 };
        #[allow(clippy::cast_possible_truncation)] // within full duty; a NaN becomes 0
        let duty = (wanted + half) as i16;
        duty
    }

    /// Returns the force on the rim at `duty` `[N]`.
    pub fn force(&self, duty: i16) -> f32 {
        f32::from(duty) / f32::from(self.full_duty) * self.full_force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE: Drive = Drive {
        full_force: 20.0,
        full_duty: 1000,
    };

    #[test]
    fn a_duty_is_the_nearest_one_and_never_more_than_full() {
        assert_eq!(DRIVE.duty(1.0), 50);
        assert_eq!(DRIVE.duty(-1.009), -50);
        assert_eq!(DRIVE.duty(-1.011), -51);
        assert_eq!(DRIVE.duty(1e30), 1000);
        assert_eq!(DRIVE.duty(f32::NEG_INFINITY), -1000);
        assert_eq!(DRIVE.duty(f32::NAN), 0);
    }

    #[test]
    fn a_duty_comes_back_from_its_force() {
        for duty in -1000..=1000 {
            assert_eq!(DRIVE.duty(DRIVE.force(duty)), duty);
        }
    }
}
