//! Quantities of a sampled loop: one list with key, unit, range and meaning.

/// Range of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Above 0, and finite.
    Positive,
    /// 0 or above, and finite.
    NotNegative,
    /// Above 0 and below 1.
    Fraction,
}

impl Range {
    /// Whether `value` is in the range.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive => value > 0.0 && value.is_finite(),
            Self::NotNegative => value >= 0.0 && value.is_finite(),
            Self::Fraction => value > 0.0 && value < 1.0,
        }
    }

    /// The range in words, after "must be".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Positive => "a finite number above 0",
            Self::NotNegative => "a finite number of 0 or above",
            Self::Fraction => "a number above 0 and below 1",
        }
    }
}

macro_rules! quantities {
    ($($(#[doc = $meaning:literal])+ $name:ident = $key:literal, $range:ident;)+) => {
        /// A quantity of a loop. The key contains the unit.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Quantity {
            $($(#[doc = $meaning])+ $name,)+
        }

        impl Quantity {
            /// Every quantity, in the order of a file.
            pub const ALL: [Self; [$($key),+].len()] = [$(Self::$name),+];

            /// The key of a file, with the unit.
            pub fn key(self) -> &'static str {
                match self {
                    $(Self::$name => $key,)+
                }
            }

            /// The range of its values.
            pub fn range(self) -> Range {
                match self {
                    $(Self::$name => Range::$range,)+
                }
            }

            /// The meaning, in words.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$name => concat!($($meaning),+).trim_ascii(),)+
                }
            }
        }
    };
}

quantities! {
    /// Period of the loop for which the other quantities were found `[s]`.
    Period = "period_s", Positive;
    /// Effective mass at the end-point `[kg]`: the renderer's model value of the device mass. It includes the part
    /// of the hand that moves with the device.
    DeviceMass = "device_mass_kg", Positive;
    /// Delivered over commanded force of the motor.
    Gain = "gain", Positive;
    /// Mean time from a sample to the moment at which its force begins `[s]`, including the mean jitter.
    Delay = "delay_s", NotNegative;
    /// Time constant of the motor's force after its beginning, a first-order lag `[s]`.
    Lag = "lag_s", NotNegative;
    /// Delay and lag together `[s]`: known better than each of them.
    DelayPlusLag = "delay_plus_lag_s", NotNegative;
    /// Friction of the device and damping of the hand, in proportion to the velocity `[N s/m]`. The
    /// excitation cannot distinguish them.
    ViscousFriction = "viscous_friction_n_s_per_m", NotNegative;
    /// Coulomb friction at the end-point `[N]`.
    CoulombFriction = "coulomb_friction_n", NotNegative;
    /// Stiffness that pulls the device back to where it was held `[N/m]`.
    HandStiffness = "hand_stiffness_n_per_m", NotNegative;
    /// Damping of the hand `[N s/m]`, where it is known apart from the device's friction.
    HandDamping = "hand_damping_n_s_per_m", NotNegative;
    /// Mass of the hand that moves with the device `[kg]`, where it is known apart from the device's mass.
    HandMass = "hand_mass_kg", NotNegative;
    /// First resonance between motor and end-point, both free `[Hz]`.
    Resonance = "resonance_hz", Positive;
    /// Damping ratio of the first resonance.
    ResonanceDampingRatio = "resonance_damping_ratio", NotNegative;
    /// Part of the mass that is beyond the flexible transmission, seen from motor and sensor.
    FlexibleMassFraction = "flexible_mass_fraction", Fraction;
    /// Step of the position sensor `[m]`.
    SensorQuantum = "sensor_quantum_m", NotNegative;
    /// Standard deviation of the sensor's error, that of its steps included `[m]`.
    SensorNoise = "sensor_noise_m", NotNegative;
    /// Standard deviation of the time between samples `[s]`.
    SampleJitter = "sample_jitter_s", NotNegative;
    /// Standard deviation of the delay from command to command `[s]`.
    CommandJitter = "command_jitter_s", NotNegative;
}

impl Quantity {
    /// Returns the quantity of a key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.key() == key)
    }
}
