//! Hand on a device: its intention, stiffness and tremor.
//!
//! ```text
//! u = F + k_h (x_int − x) + b_h (x_int′ − x′) + tremor force,    and m_h moves with the device
//! ```
//!
//! With a constant intention, and without F and tremor force, this hand is passive: its energy output is at most the
//! energy stored in its spring, k_h (x_int − x)²/2, and in its mass, m_h x′²/2. A moving intention and the forces add
//! energy.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::InvalidParameter;
use crate::error::{finite, positive};
use crate::recorded_path::RecordedPath;

/// A · sin(2π f t + φ), in the unit of its amplitude.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// Amplitude A.
    pub amplitude: f64,
    /// Frequency f `[Hz]`; that of physiological tremor is 4 Hz to 12 Hz.
    pub frequency_hz: f64,
    /// Phase φ `[rad]` at t = 0.
    pub phase: f64,
}

impl Sinusoid {
    /// ω = 2π f `[rad/s]`.
    fn rate(&self) -> f64 {
        TAU * self.frequency_hz
    }

    /// Value at a time `[s]`.
    #[must_use]
    pub fn value(&self, time: f64) -> f64 {
        self.amplitude * (self.rate() * time + self.phase).sin()
    }

    /// Rate of change `[unit of the amplitude per s]` at a time `[s]`.
    #[must_use]
    pub fn slope(&self, time: f64) -> f64 {
        self.amplitude * self.rate() * (self.rate() * time + self.phase).cos()
    }

    /// Adds the power series in (t − `time`)/`span` of the value to `series`.
    fn add_value(&self, time: f64, span: f64, series: &mut [f64]) {
        let (sine, cosine) = (self.rate() * time + self.phase).sin_cos();
        let cycle = [sine, cosine, -sine, -cosine];
        self.add(self.amplitude, span, cycle, series);
    }

    /// Adds the power series in (t − `time`)/`span` of the slope to `series`.
    fn add_slope(&self, time: f64, span: f64, series: &mut [f64]) {
        let (sine, cosine) = (self.rate() * time + self.phase).sin_cos();
        let cycle = [cosine, -sine, -cosine, sine];
        self.add(self.amplitude * self.rate(), span, cycle, series);
    }

    fn add(&self, amplitude: f64, span: f64, cycle: [f64; 4], series: &mut [f64]) {
        let mut factor = amplitude;
        for (n, coefficient) in series.iter_mut().enumerate() {
            *coefficient += factor * cycle[n % 4];
            factor *= self.rate() * span / (n + 1) as f64;
        }
    }

    fn check(&self, amplitude_name: &'static str) -> Result<(), InvalidParameter> {
        finite(amplitude_name, self.amplitude, "finite [m] or [N]")?;
        positive("frequency_hz", self.frequency_hz, "finite and above 0 Hz")?;
        finite("phase", self.phase, "finite [rad]")?;
        Ok(())
    }
}

/// Intended path of a hand, without its tremor.
#[derive(Debug, Clone, PartialEq)]
pub enum IntendedPath {
    /// One place `[m]`.
    Constant(f64),
    /// To and fro about a place.
    Sinusoid {
        /// The place `[m]`.
        centre: f64,
        /// The motion about it, its amplitude in `[m]`.
        swing: Sinusoid,
    },
    /// A recorded motion on the hand's clock: straight between its samples, at rest before and
    /// after. Shared, so that a clone of the device does not copy the recording.
    Recorded(Arc<RecordedPath>),
}

/// Intended motion x_int(t) of a hand, with the tremor of its aim.
#[derive(Debug, Clone, PartialEq)]
pub struct Intention {
    /// The path.
    pub path: IntendedPath,
    /// Tremor of the intended position, its amplitude in `[m]`, on top of the path.
    pub tremor: Option<Sinusoid>,
}

impl Intention {
    /// To stay in one place `[m]`, without tremor.
    #[must_use]
    pub fn constant(position: f64) -> Self {
        Self {
            path: IntendedPath::Constant(position),
            tremor: None,
        }
    }

    /// x_int `[m]` at a time `[s]`.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        let path = match &self.path {
            IntendedPath::Constant(position) => *position,
            IntendedPath::Sinusoid { centre, swing } => centre + swing.value(time),
            IntendedPath::Recorded(path) => path.position(time),
        };
        path + self.tremor.map_or(0.0, |tremor| tremor.value(time))
    }

    /// x_int′ `[m/s]` at a time `[s]`; at a sample of a recording that of the line which begins.
    #[must_use]
    pub fn velocity(&self, time: f64) -> f64 {
        let path = match &self.path {
            IntendedPath::Constant(_) => 0.0,
            IntendedPath::Sinusoid { swing, .. } => swing.slope(time),
            IntendedPath::Recorded(path) => velocity_after(path, time),
        };
        path + self.tremor.map_or(0.0, |tremor| tremor.slope(time))
    }

    /// Adds the power series in (t − `time`)/`span` of x_int′ to `series`.
    fn add_velocity(&self, time: f64, span: f64, series: &mut [f64]) {
        match &self.path {
            IntendedPath::Constant(_) => {}
            IntendedPath::Sinusoid { swing, .. } => swing.add_slope(time, span, series),
            IntendedPath::Recorded(path) => series[0] += velocity_after(path, time),
        }
        if let Some(tremor) = self.tremor {
            tremor.add_slope(time, span, series);
        }
    }

    fn sinusoids(&self) -> impl Iterator<Item = &Sinusoid> {
        let swing = match &self.path {
            IntendedPath::Sinusoid { swing, .. } => Some(swing),
            IntendedPath::Constant(_) | IntendedPath::Recorded(_) => None,
        };
        swing.into_iter().chain(&self.tremor)
    }

    fn check(&self) -> Result<(), InvalidParameter> {
        match &self.path {
            IntendedPath::Constant(position) => {
                finite("intention", *position, "finite [m]")?;
            }
            IntendedPath::Sinusoid { centre, swing } => {
                finite("centre", *centre, "finite [m]")?;
                swing.check("swing.amplitude")?;
            }
            IntendedPath::Recorded(_) => {} // checked when it was made
        }
        self.tremor
            .map_or(Ok(()), |tremor| tremor.check("intention.tremor.amplitude"))
    }
}

/// Slope `[m/s]` of a recording just after a time `[s]`; unlike [`RecordedPath::velocity`] 0 from
/// the end on, because the hand rests there.
fn velocity_after(path: &RecordedPath, time: f64) -> f64 {
    if time < path.end() {
        path.velocity(time)
    } else {
        0.0
    }
}

/// A hand that holds a device.
#[derive(Debug, Clone, PartialEq)]
pub enum Hand {
    /// A force that knows nothing of the motion.
    ConstantForce {
        /// F `[N]`
        force: f64,
        /// Tremor force, its amplitude in `[N]`.
        tremor: Option<Sinusoid>,
    },
    /// A spring and a damper towards an intention, and a mass that moves with the device.
    Impedance {
        /// m_h `[kg]`
        mass: f64,
        /// k_h `[N/m]`
        stiffness: f64,
        /// b_h `[N s/m]`
        damping: f64,
        /// x_int
        intention: Intention,
        /// Constant force F `[N]` on top.
        force: f64,
        /// Tremor force on top, its amplitude in `[N]`.
        tremor: Option<Sinusoid>,
    },
}

impl Hand {
    /// Creates a constant force F `[N]`; 0 N means that the device is free.
    #[must_use]
    pub fn pushing(force: f64) -> Self {
        Self::ConstantForce {
            force,
            tremor: None,
        }
    }

    /// Mass m_h `[kg]` that moves with the device.
    #[must_use]
    pub fn mass(&self) -> f64 {
        match self {
            Self::ConstantForce { .. } => 0.0,
            Self::Impedance { mass, .. } => *mass,
        }
    }

    /// Stiffness k_h `[N/m]`.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        match self {
            Self::ConstantForce { .. } => 0.0,
            Self::Impedance { stiffness, .. } => *stiffness,
        }
    }

    /// Damping b_h `[N s/m]`.
    #[must_use]
    pub fn damping(&self) -> f64 {
        match self {
            Self::ConstantForce { .. } => 0.0,
            Self::Impedance { damping, .. } => *damping,
        }
    }

    /// Constant force F `[N]`.
    #[must_use]
    pub fn constant_force(&self) -> f64 {
        match self {
            Self::ConstantForce { force, .. } | Self::Impedance { force, .. } => *force,
        }
    }

    /// Returns the intended motion of this hand, or `None` if it has none.
    #[must_use]
    pub fn intention(&self) -> Option<&Intention> {
        match self {
            Self::ConstantForce { .. } => None,
            Self::Impedance { intention, .. } => Some(intention),
        }
    }

    fn tremor(&self) -> Option<&Sinusoid> {
        match self {
            Self::ConstantForce { tremor, .. } | Self::Impedance { tremor, .. } => tremor.as_ref(),
        }
    }

    /// u `[N]` on a device at `position` `[m]` with `velocity` `[m/s]` at a `time` `[s]`; without
    /// the inertia of m_h.
    #[must_use]
    pub fn force(&self, time: f64, position: f64, velocity: f64) -> f64 {
        let held = self.intention().map_or(0.0, |intention| {
            self.stiffness() * (intention.position(time) - position)
                + self.damping() * (intention.velocity(time) - velocity)
        });
        let tremor = self.tremor().map_or(0.0, |tremor| tremor.value(time));
        self.constant_force() + held + tremor
    }

    /// Intended position `[m]` at a time `[s]`, 0 for a hand without intention.
    pub(crate) fn intended_position(&self, time: f64) -> f64 {
        self.intention()
            .map_or(0.0, |intention| intention.position(time))
    }

    /// Writes the power series in (t − `time`)/`span` of x_int′ and of the force without spring and
    /// damper.
    pub(crate) fn write_series(
        &self,
        time: f64,
        span: f64,
        intended_velocity: &mut [f64],
        force: &mut [f64],
    ) {
        intended_velocity.fill(0.0);
        force.fill(0.0);
        force[0] = self.constant_force();
        if let Some(intention) = self.intention() {
            intention.add_velocity(time, span, intended_velocity);
        }
        if let Some(tremor) = self.tremor() {
            tremor.add_value(time, span, force);
        }
    }

    /// Returns the fastest rate `[rad/s]` of the hand's voluntary motion and tremor.
    pub(crate) fn fastest_rate(&self) -> f64 {
        self.intention()
            .into_iter()
            .flat_map(Intention::sinusoids)
            .chain(self.tremor())
            .map(Sinusoid::rate)
            .fold(0.0, f64::max)
    }

    /// The next instant `[s]` after `time` at which a recorded intention bends; infinite if none.
    pub(crate) fn next_bend(&self, time: f64) -> f64 {
        match self.intention().map(|intention| &intention.path) {
            Some(IntendedPath::Recorded(path)) => {
                let after = path.times().partition_point(|&bend| bend <= time);
                path.times().get(after).copied().unwrap_or(f64::INFINITY)
            }
            _ => f64::INFINITY,
        }
    }

    pub(crate) fn check(&self) -> Result<(), InvalidParameter> {
        for (name, value, allowed) in [
            ("hand.mass", self.mass(), "finite and at least 0 kg"),
            (
                "hand.stiffness",
                self.stiffness(),
                "finite and at least 0 N/m",
            ),
            (
                "hand.damping",
                self.damping(),
                "finite and at least 0 N s/m",
            ),
        ] {
            InvalidParameter::unless(value.is_finite() && value >= 0.0, name, value, allowed)?;
        }
        finite("hand.force", self.constant_force(), "finite [N]")?;
        self.intention().map_or(Ok(()), Intention::check)?;
        self.tremor()
            .map_or(Ok(()), |tremor| tremor.check("hand.tremor.amplitude"))
    }
}
