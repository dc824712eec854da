//! Units of positions and times, given by a column or a user, and plausibility of a hand's motion.

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
    /// All units, the largest first.
    pub const ALL: [Self; 4] = [
        Self::Metre,
        Self::Centimetre,
        Self::Millimetre,
        Self::Micrometre,
    ];

    /// Returns its symbol, in ASCII: `m`, `cm`, `mm` or `um`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "m",
            Self::Centimetre => "cm",
            Self::Millimetre => "mm",
            Self::Micrometre => "um",
        }
    }

    /// Returns the name of a column of positions in this unit: `position_m`, `position_mm`, ...
    #[must_use]
    pub fn position_column(self) -> &'static str {
        match self {
            Self::Metre => "position_m",
            Self::Centimetre => "position_cm",
            Self::Millimetre => "position_mm",
            Self::Micrometre => "position_um",
        }
    }

    /// Returns the unit with a symbol, if there is one.
    #[must_use]
    pub fn of_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.symbol() == symbol)
    }

    /// Converts a length in this unit to metres; metres are unchanged to the last bit.
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

/// Largest plausible range of a hand on a device `[m]`: both arms spread. Desktop devices reach 0.1 to 0.8 m.
const LONGEST_STRETCH: f64 = 2.0;
/// Largest plausible mean speed of a hand `[m/s]`: shaking by 0.15 m at 6 Hz is 1.8 m/s.
const FASTEST_MEAN: f64 = 3.0;
/// Path below which the mean speed is not checked `[m]`: a single throw of an arm is faster.
const SHORTEST_TRAVEL: f64 = 2.0;
/// Time between the positions whose distances add up to the path `[s]`: at every sample, the sensor's noise would add
/// up too.
const TRAVEL_STEP: f64 = 0.01;

/// Accumulated range and path of a motion. A hand's motion is short and slow; another one is probably in
/// another unit.
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
    /// Last two samples, the older first `[m]`.
    last: Option<(f64, Option<f64>)>,
    /// Lowest and highest position `[m]`.
    bounds: Option<(f64, f64)>,
    /// Time and position of the end of the measured path.
    measured: Option<(f64, f64)>,
    /// Path `[m]`.
    travel: f64,
    /// Times of the first and the last sample `[s]`.
    span: Option<(f64, f64)>,
}

impl HandMotion {
    /// Adds a sample at `time` `[s]`, at `position` `[m]`; times must increase.
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
                // Unlike `clamp`, this does not panic on NaN, which the caller rejects later.
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

    /// Returns the implausible quantities, if the motion so far is implausible for a hand.
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

/// An implausible motion for a hand: a range of more than 2 m, or a mean speed above 3 m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Path length `[m]`.
    pub travel: f64,
    /// Range: distance between the lowest and the highest position `[m]`.
    pub stretch: f64,
    /// Duration `[s]`.
    pub duration: f64,
}

impl Excess {
    /// Returns the unit in which the motion would be plausible for a hand.
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
            "implausible motion: {} m path in {} s, range {} m; is the unit {}?",
            two_digits(self.travel),
            two_digits(self.duration),
            two_digits(self.stretch),
            self.likely_unit()
        )
    }
}

/// Formats a number that is not negative, with few digits.
fn two_digits(value: f64) -> String {
    if value >= 10.0 {
        return format!("{value:.0}");
    }
    // The shortest reported motions last milliseconds.
    let decimals = if value < 1.0 { 3 } else { 1 };
    format!("{value:.decimals$}")
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a swing of `seconds` with `amplitude` `[m]` at `hertz`, sampled at 1 kHz and modified by `change`.
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
        // A desktop device, an arm, and the fastest shaking.
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
            "implausible motion: 14 m path in 3 s, range 4.6 m; is the unit mm?"
        );
        // 1.8 mm to and fro, twice per second, taken for metres.
        let fast = swing(0.9, 2.0, 3, |_, x| x).excess().unwrap();
        assert!(fast.stretch < 2.0 && fast.travel > 20.0, "{fast:?}");
    }

    #[test]
    fn micrometres_are_distinguished_from_millimetres() {
        let motion = swing(20_000.0, 1.0, 1, |_, x| x).excess().unwrap();
        assert_eq!(motion.likely_unit(), LengthUnit::Micrometre);
    }

    #[test]
    fn single_wrong_samples_and_noise_are_no_motion() {
        let glitches = swing(0.02, 1.0, 3, |i, x| if i % 500 == 7 { 1e6 } else { x });
        assert_eq!(glitches.excess(), None);
        // The sample-to-sample speed of these 6 mm is 6 m/s.
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
