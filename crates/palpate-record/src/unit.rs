//! The units of positions and times: what a column or a user says, and whether a motion can be a hand's.

mod time;

pub use time::{Spacing, TimeUnit};

use std::fmt;

/// Unit of a column of positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LengthUnit {
    /// Metres.
    #[default]
    Metre,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// Micrometres.
    Micrometre,
}

impl LengthUnit {
    /// Every unit, the largest first.
    pub const ALL: [Self; 4] = [
        Self::Metre,
        Self::Centimetre,
        Self::Millimetre,
        Self::Micrometre,
    ];

    /// Its symbol, in ASCII: `m`, `cm`, `mm` or `um`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
        }
    }

    /// Name of a column of positions in this unit: `position_m`, `position_mm`, ...
    #[must_use]
    pub fn position_column(self) -> &'static str {
        match self {
            Self::Metre => "position_m",
            Self::Centimetre => "position_cm",
            Self::Millimetre => "position_mm",
            Self::Micrometre => "position_um",
        }
    }

    /// The unit with a symbol, if there is one.
    #[must_use]
    pub fn of_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.symbol() == symbol)
    }

    /// A length in this unit, in metres; metres stay the same to the last bit.
    #[must_use]
    pub fn metres(self, length: f64) -> f64 {
        length / self.per_metre()
    }

    fn per_metre(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e2,
            Self::Millimetre => 1e3,
            Self::Micrometre => 1e6,
        }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// Longest stretch that a hand on a device covers `[m]`: both arms spread. Desktop devices reach 0.1
/// to 0.8 m.
const LONGEST_STRETCH: f64 = 2.0;
/// Fastest that a hand moves on average `[m/s]`: shaking by 0.15 m at 6 Hz is 1.8 m/s.
const FASTEST_MEAN: f64 = 3.0;
/// Distance below which an average says nothing `[m]`: a single throw of an arm is faster.
const SHORTEST_TRAVEL: f64 = 2.0;
/// Time between the positions whose distances add up to the travel `[s]`: at every sample, the
/// sensor's noise would add up, too.
const TRAVEL_STEP: f64 = 0.01;

/// How far a motion went, sample by sample: a hand's motion is short and slow, and one that is not
/// is likely to be in another unit.
///
/// A single wrong sample does not count: each position is the median of three samples.
///
/// ```
/// use palpate_record::unit::{HandMotion, LengthUnit};
///
/// let mut motion = HandMotion::default();
/// for i in 0..1000 {
///     let t = f64::from(i) * 0.001;
///     motion.add(t, 20.0 * (6.0 * t).sin()); // millimetres, taken for metres
/// }
/// let excess = motion.excess().unwrap();
/// assert_eq!(excess.likely_unit(), LengthUnit::Millimetre);
/// assert!(excess.to_string().ends_with("is the unit mm?"));
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct HandMotion {
    /// The last two samples, the older first `[m]`.
    last: Option<(f64, Option<f64>)>,
    /// Lowest and highest position `[m]`.
    bounds: Option<(f64, f64)>,
    /// Time and position that the travel was measured up to.
    measured: Option<(f64, f64)>,
    /// Sum of the distances `[m]`.
    travel: f64,
    /// Times of the first and the last sample `[s]`.
    span: Option<(f64, f64)>,
}

impl HandMotion {
    /// Takes a sample at `time` `[s]`, at `position` `[m]`; times increase.
    pub fn add(&mut self, time: f64, position: f64) {
        let since = self.span.map_or(time, |(first, _)| first);
        self.span = Some((since, time));
        let middle = match self.last {
            None => {
                self.last = Some((position, None));
                return;
            }
            Some((first, None)) => {
                self.last = Some((first, Some(position)));
                return;
            }
            Some((first, Some(second))) => {
                self.last = Some((second, Some(position)));
                let (low, high) = (first.min(second), first.max(second));
                // Unlike `clamp`, this does not panic on NaN, which whoever reads the samples refuses later.
                position.max(low).min(high)
            }
        };
        let (low, high) = self.bounds.unwrap_or((middle, middle));
        self.bounds = Some((low.min(middle), high.max(middle)));
        match self.measured {
            Some((before, _)) if time - before < TRAVEL_STEP => {}
            Some((_, from)) => {
                self.travel += (middle - from).abs();
                self.measured = Some((time, middle));
            }
            None => self.measured = Some((time, middle)),
        }
    }

    /// What no hand does, if the motion so far is such.
    #[must_use]
    pub fn excess(&self) -> Option<Excess> {
        let (low, high) = self.bounds?;
        let (begin, end) = self.span?;
        let found = Excess {
            travel: self.travel.max(high - low),
            stretch: high - low,
            duration: end - begin,
        };
        let too_far = found.stretch > LONGEST_STRETCH;
        let too_fast =
            found.travel > SHORTEST_TRAVEL && found.travel > FASTEST_MEAN * found.duration;
        (too_far || too_fast).then_some(found)
    }
}

/// A motion that is too long or too fast for a hand: over more than 2 m, or at more than 3 m/s on
/// average.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Distance travelled, to and fro `[m]`.
    pub travel: f64,
    /// Distance between the lowest and the highest position `[m]`.
    pub stretch: f64,
    /// How long that took `[s]`.
    pub duration: f64,
}

impl Excess {
    /// The unit in which it would be a hand's motion.
    #[must_use]
    pub fn likely_unit(&self) -> LengthUnit {
        let unit = LengthUnit::Millimetre;
        if unit.metres(self.stretch) <= LONGEST_STRETCH {
            unit
        } else {
            LengthUnit::Micrometre
        }
    }
}

impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} m of hand motion in {} s, over a stretch of {} m; is the unit {}?",
            two_digits(self.travel),
            two_digits(self.duration),
            two_digits(self.stretch),
            self.likely_unit()
        )
    }
}

/// A number that is not negative, with few digits.
fn two_digits(value: f64) -> String {
    if value >= 10.0 {
        return format!("{value:.0}");
    }
    // The shortest motions that are told last milliseconds.
    let decimals = if value < 1.0 { 3 } else { 1 };
    format!("{value:.decimals$}")
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `seconds` of a swing by `amplitude` `[m]` at `hertz`, at 1 kHz, through `change`.
    fn swing(
        amplitude: f64,
        hertz: f64,
        seconds: u32,
        change: impl Fn(u32, f64) -> f64,
    ) -> HandMotion {
        let mut motion = HandMotion::default();
        for i in 0..seconds * 1000 {
            let t = f64::from(i) * 0.001;
            let position = amplitude * (std::f64::consts::TAU * hertz * t).sin();
            motion.add(t, change(i, position));
        }
        motion
    }

    #[test]
    fn what_a_hand_does_passes() {
        // A desktop device, an arm, and shaking as fast as one can.
        for (amplitude, hertz) in [(0.02, 1.0), (0.7, 0.5), (0.075, 6.0)] {
            let motion = swing(amplitude, hertz, 10, |_, x| x);
            assert_eq!(motion.excess(), None, "{amplitude} m at {hertz} Hz");
        }
    }

    #[test]
    fn millimetres_in_metres_are_found_by_their_stretch_or_by_their_speed() {
        let far = swing(2.3, 0.5, 3, |_, x| x).excess().unwrap();
        assert_eq!(
            far.to_string(),
            "14 m of hand motion in 3 s, over a stretch of 4.6 m; is the unit mm?"
        );
        // 1.8 mm to and fro, twice a second.
        let fast = swing(0.9, 2.0, 3, |_, x| x).excess().unwrap();
        assert!(fast.stretch < 2.0 && fast.travel > 20.0, "{fast:?}");
    }

    #[test]
    fn micrometres_are_told_from_millimetres() {
        let motion = swing(20_000.0, 1.0, 1, |_, x| x).excess().unwrap();
        assert_eq!(motion.likely_unit(), LengthUnit::Micrometre);
    }

    #[test]
    fn single_wrong_samples_and_noise_are_no_motion() {
        let glitches = swing(0.02, 1.0, 3, |i, x| if i % 500 == 7 { 1e6 } else { x });
        assert_eq!(glitches.excess(), None);
        // From sample to sample these 6 mm are 6 m/s.
        let noise = swing(0.02, 1.0, 3, |i, x| {
            x + if i % 2 == 0 { 0.006 } else { 0.0 }
        });
        assert_eq!(noise.excess(), None);
    }

    #[test]
    fn two_samples_are_no_motion_yet() {
        let mut motion = HandMotion::default();
        motion.add(0.0, 0.0);
        motion.add(0.01, 100.0);
        assert_eq!(motion.excess(), None);
    }

    #[test]
    fn units_have_symbols_columns_and_lengths() {
        for unit in LengthUnit::ALL {
            assert_eq!(LengthUnit::of_symbol(unit.symbol()), Some(unit));
            assert_eq!(unit.position_column(), format!("position_{unit}"));
        }
        assert_eq!(LengthUnit::of_symbol("inch"), None);
        assert_eq!(LengthUnit::Millimetre.metres(12.0), 0.012);
        assert_eq!(LengthUnit::Centimetre.metres(12.0), 0.12);
        assert_eq!(LengthUnit::Micrometre.metres(12.0), 12e-6);
        assert_eq!(LengthUnit::Metre.metres(0.1), 0.1);
    }
}
