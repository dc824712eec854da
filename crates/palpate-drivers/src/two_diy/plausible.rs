//! Plausibility check of joint angles against earlier ones.

use std::time::Instant;

/// Limit of plausible angles `[degrees]`: a joint cannot make a full turn.
const LARGEST_ANGLE: f32 = 720.0;
/// Limit of the joint rate `[degrees/s]`: 1.8 m/s at the elbow.
const LARGEST_RATE: f64 = 1_500.0;
/// Additional tolerance for samples that are close in time `[degrees]`.
const SLACK: f64 = 2.0;

/// Implausible angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Implausible {
    /// A single implausible sample; the next sample may be good.
    Once(&'static str),
    /// Two implausible samples that agree: the earlier angles are no longer valid.
    Stays(&'static str),
}

const LOST: Implausible = Implausible::Stays(
    "the angles have jumped for good: the encoders have lost counts; reopen the device with the arm in its start \
     pose",
);

/// Last accepted angles, and last rejected ones.
#[derive(Clone, Copy, Debug)]
pub struct Plausible {
    angles: [f32; 2],
    since: Instant,
    doubted: Option<Doubted>,
    /// Whether the encoder count is lost; then all angles are rejected.
    lost: bool,
}

/// Rejected angles.
#[derive(Clone, Copy, Debug)]
struct Doubted {
    angles: [f32; 2],
    asked: Instant,
    /// Largest plausible distance from the accepted angles when the doubt began `[degrees]`. It stays constant during
    /// the doubt; otherwise any wrong angle would become plausible after some time.
    reach: f64,
}

impl Plausible {
    pub fn starting_at(angles: [f32; 2], asked: Instant) -> Self {
        Self {
            angles,
            since: asked,
            doubted: None,
            lost: false,
        }
    }

    /// Rejects all further angles.
    pub fn lose_count(&mut self) -> Implausible {
        self.lost = true;
        LOST
    }

    /// Returns the last accepted angles `[degrees]`.
    pub fn angles(&self) -> [f32; 2] {
        self.angles
    }

    /// Accepts angles that were requested at `asked` and received at `now`, or returns the reason for rejecting them.
    /// After a persistent jump it rejects all angles. The assumed time between two samples is therefore its upper
    /// bound, even if this program stalled.
    pub fn take(
        &mut self,
        angles: [f32; 2],
        asked: Instant,
        now: Instant,
    ) -> Result<(), Implausible> {
        if self.lost {
            return Err(LOST);
        }
        if angles.iter().any(|angle| angle.is_nan()) {
            return Err(Implausible::Once("an angle is not a number"));
        }
        if angles.iter().any(|angle| angle.abs() > LARGEST_ANGLE) {
            return Err(Implausible::Once("an angle is beyond two turns"));
        }
        let by = distance(self.angles, angles);
        let (reach, from_doubted) = match self.doubted {
            None => (reach(self.since, now), None),
            Some(doubted) => {
                let by = distance(doubted.angles, angles);
                (
                    doubted.reach,
                    Some((by, by <= self::reach(doubted.asked, now))),
                )
            }
        };
        match from_doubted {
            Some((from_doubted, true)) if by > reach || from_doubted < by => {
                return Err(self.lose_count());
            }
            _ if by > reach => {
                self.doubted = Some(Doubted {
                    angles,
                    asked,
                    reach,
                });
                return Err(Implausible::Once(
                    "an angle jumped farther than an arm can turn",
                ));
            }
            _ => {}
        }
        *self = Self::starting_at(angles, asked);
        Ok(())
    }
}

/// Returns the largest rotation of a joint between two times `[degrees]`. The time is limited to 0.1 s, which is enough
/// to reach any angle.
fn reach(then: Instant, now: Instant) -> f64 {
    let seconds = now.saturating_duration_since(then).as_secs_f64().min(0.1);
    LARGEST_RATE * seconds + SLACK
}

/// Returns the larger rotation of the two joints `[degrees]`.
fn distance(from: [f32; 2], to: [f32; 2]) -> f64 {
    from.iter()
        .zip(to)
        .map(|(from, to)| (f64::from(to) - f64::from(*from)).abs())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_lost_count_stays_lost() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let slipped = [40.0, 50.0];
        let mut plausible = Plausible::starting_at([130.0, 50.0], start);
        let taken = plausible.take(slipped, at(1), at(1));
        assert!(matches!(taken, Err(Implausible::Once(_))), "{taken:?}");
        assert_eq!(plausible.take(slipped, at(2), at(2)), Err(LOST));
        for ms in 3..2000 {
            assert_eq!(
                plausible.take(slipped, at(ms), at(ms)),
                Err(LOST),
                "after {ms} ms"
            );
        }
        // The old angles are rejected too: lost counts do not come back.
        assert_eq!(plausible.take([130.0, 50.0], at(2000), at(2000)), Err(LOST));
    }

    #[test]
    fn what_is_doubted_is_not_believed_because_time_passes() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut plausible = Plausible::starting_at([130.0, 50.0], start);
        // Never near the previous sample or the accepted angles; 40 degrees would be within reach after 26 ms.
        for ms in 1..2000 {
            let side = if ms % 2 == 0 { 40.0 } else { -40.0 };
            let taken = plausible.take([130.0 + side, 50.0], at(ms), at(ms));
            assert!(
                matches!(taken, Err(Implausible::Once(_))),
                "{taken:?} after {ms} ms"
            );
        }
        assert_eq!(plausible.take([131.0, 50.0], at(2000), at(2000)), Ok(()));
    }

    #[test]
    fn a_slip_is_noticed_if_no_arm_turns_as_far_in_a_period() {
        let start = Instant::now();
        for (period, slip, is_noticed) in [
            (1_u64, 4.0, true),
            (1, 3.0, false),
            (10, 18.0, true),
            (10, 16.0, false),
        ] {
            let at = |periods: u64| start + Duration::from_millis(periods * period);
            let mut plausible = Plausible::starting_at([130.0, 50.0], start);
            let slipped = [130.0 - slip, 50.0];
            assert_eq!(
                plausible.take(slipped, at(1), at(1)).is_err(),
                is_noticed,
                "{slip}"
            );
            let expected = if is_noticed { Err(LOST) } else { Ok(()) };
            assert_eq!(plausible.take(slipped, at(2), at(2)), expected, "{slip}");
        }
    }

    #[test]
    fn one_glitch_passes_and_a_jump_that_stays_is_said() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut plausible = Plausible::starting_at([168.0, 12.0], start);
        assert_eq!(plausible.take([167.0, 12.5], at(1), at(1)), Ok(()));
        for bad in [
            [f32::NAN, 12.0],
            [167.0, f32::INFINITY],
            [1e30, 0.0],
            [150.0, 12.0],
        ] {
            let taken = plausible.take(bad, at(2), at(2));
            assert!(matches!(taken, Err(Implausible::Once(_))), "{bad:?}");
            assert_eq!(
                plausible.take([166.0, 12.5], at(3), at(3)),
                Ok(()),
                "{bad:?}"
            );
        }
        assert!(plausible.take([100.0, 12.0], at(4), at(4)).is_err());
        let again = plausible.take([100.5, 12.0], at(5), at(5));
        assert!(matches!(again, Err(Implausible::Stays(_))), "{again:?}");
        assert_eq!(plausible.angles(), [166.0, 12.5]);
    }
}
