//! Parameters of the contact and of its loop, checked once.

use crate::Scalar;
use crate::actuation::{Actuation, Hold};
use crate::guard::Guard;
use crate::parameter::{Allowed, Parameter, ParameterError};

/// Mass of the virtual object.
///
/// As a serde value it is a number in kilograms, or the string `"inf"` (or an infinite number
/// where the format has one) for a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass<S> {
    /// A movable object with this mass `[kg]`.
    Finite(S),
    /// A wall: neither contact force nor virtual force moves it.
    Infinite,
}

/// Side of the device on which the object lies.
///
/// All positions, velocities and forces are along one axis. The side determines the direction in which the device
/// presses into the object and nothing else, so a mirrored scene gives the mirrored forces.
///
/// ```text
///  Side::Positive                              Side::Negative
///   device --> | object        + axis -->       object | <-- device
///   penetration = device - object               penetration = object - device
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Side {
    /// The object lies in the direction of increasing device position.
    #[default]
    Positive,
    /// The object lies in the direction of decreasing device position.
    Negative,
}

impl Side {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::Positive, Self::Negative];

    /// Returns the name in files, flags and arguments.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Positive => "positive",
            Self::Negative => "negative",
        }
    }

    /// Returns the side with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|side| side.name() == name)
    }

    /// Returns +1 for [`Side::Positive`], -1 for [`Side::Negative`].
    #[inline]
    #[must_use]
    pub fn sign<S: Scalar>(self) -> S {
        match self {
            Self::Positive => S::ONE,
            Self::Negative => -S::ONE,
        }
    }
}

/// One contact between the device's end-point and a virtual object.
///
/// The interaction force is an undamped spring of the given stiffness, active while the
/// penetration is positive (paper, Eq. 6b).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Contact<S> {
    /// Contact stiffness K `[N/m]`, greater than 0.
    pub stiffness: S,
    /// Mass M of the object `[kg]`, greater than 0.
    pub object_mass: Mass<S>,
    /// Side of the device on which the object lies.
    #[cfg_attr(feature = "serde", serde(default))]
    pub side: Side,
    /// Whether the contact may only push. The paper's methods can pull for part of an interval; this option clamps the
    /// held force to prevent that. Default `false`, as in the paper.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unilateral: bool,
}

impl<S: Scalar> Contact<S> {
    /// Creates a contact of `stiffness` `[N/m]` with an object of `mass` `[kg]` on the positive side. An infinite mass
    /// is a wall.
    pub fn object(stiffness: S, mass: S) -> Self {
        let object_mass = if mass == S::INFINITY {
            Mass::Infinite
        } else {
            Mass::Finite(mass)
        };
        Self {
            stiffness,
            object_mass,
            side: Side::Positive,
            unilateral: false,
        }
    }

    /// Creates a contact of `stiffness` `[N/m]` with a wall on the positive side.
    pub fn wall(stiffness: S) -> Self {
        Self::object(stiffness, S::INFINITY)
    }

    /// Returns the contact on another side.
    #[must_use]
    pub fn on(self, side: Side) -> Self {
        Self { side, ..self }
    }

    /// Returns the contact restricted to pushing forces.
    #[must_use]
    pub fn pushing_only(self) -> Self {
        Self {
            unilateral: true,
            ..self
        }
    }

    /// Returns every parameter outside its range.
    pub fn faults(&self) -> impl Iterator<Item = ParameterError> {
        let mass = match self.object_mass {
            Mass::Finite(mass) => Parameter::ObjectMass.positive(mass).err(),
            Mass::Infinite => None,
        };
        let stiffness = Parameter::Stiffness.positive(self.stiffness).err();
        [stiffness, mass].into_iter().flatten()
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        self.faults().next().map_or(Ok(()), Err)
    }
}

/// Parameters and limits of the sampled loop of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct LoopParams<S> {
    /// Nominal period T between samples `[s]`, greater than 0.
    pub period: S,
    /// Longest time between two samples that is bridged `[s]`, at least one period. A longer gap is a fault. `None`: 20
    /// periods.
    #[cfg_attr(feature = "serde", serde(default))]
    pub largest_gap: Option<S>,
    /// Largest accepted device speed `[m/s]`; a faster jump is a fault. `None`, also the default of a serialised value,
    /// accepts any speed. [`LoopParams::new`] sets 100 m/s, ten times the speed of a hand.
    #[cfg_attr(feature = "serde", serde(default))]
    pub speed_limit: Option<S>,
    /// Largest force `[N]`, greater than 0: of the command, and of the command times the gain of
    /// [`actuation`](Self::actuation). `None`: no limit. Set one before a motor is attached: without a limit, a device
    /// that starts 5 m inside a wall of 1000 N/m, or a position in the wrong unit, gets 5000 N. The ledger records the
    /// force after the limit. [`with_force_limit`](Self::with_force_limit) sets it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub force_limit: Option<S>,
    /// Largest rate of change of these forces `[N/s]`, up and down; a fault still sets the force to 0 immediately.
    /// `None`: no limit.
    #[cfg_attr(feature = "serde", serde(default))]
    pub slew_limit: Option<S>,
    /// Model of the actuation from a sample to the force on the device. The ledger records a force when it acts,
    /// predicting methods look ahead by the delay, and commands are divided by the gain. Default: a perfect actuator.
    #[cfg_attr(feature = "serde", serde(default))]
    pub actuation: Actuation<S>,
    /// Bound on the energy that held forces give out. Default: none.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guard: Guard<S>,
}

impl<S: Scalar> LoopParams<S> {
    /// Creates a loop of nominal `period` `[s]` that accepts device speeds up to 100 m/s and does not limit the force:
    /// a simulation needs no limit. A loop with a motor needs one: [`with_force_limit`](Self::with_force_limit).
    pub fn new(period: S) -> Self {
        Self {
            period,
            largest_gap: None,
            speed_limit: Some(S::from_f64(100.0)),
            force_limit: None,
            slew_limit: None,
            actuation: Actuation::default(),
            guard: Guard::Off,
        }
    }

    /// Returns the loop with a largest held force of `force` `[N]`: the largest force of the motor, or the largest
    /// acceptable force on a hand.
    ///
    /// ```
    /// use palpate_core::{BasicParams, Contact, LoopParams, ObjectState, Renderer, Sample};
    ///
    /// let loop_params = LoopParams::new(0.001).with_force_limit(5.0); // [s], [N]
    /// let renderer = Renderer::new(Contact::wall(1000.0), loop_params, BasicParams)?;
    /// let mut state = renderer.start(ObjectState::at_rest(0.0))?;
    /// let output = renderer.step(&mut state, Sample::at(0.01)); // 10 N of spring force
    /// assert_eq!(output.force_on_device, -5.0);
    /// assert!(output.limited.force);
    /// # Ok::<(), palpate_core::ParameterError>(())
    /// ```
    #[must_use]
    pub fn with_force_limit(self, force: S) -> Self {
        Self {
            force_limit: Some(force),
            ..self
        }
    }

    /// Returns the longest gap that is bridged `[s]`: as set, or 20 periods.
    pub fn bridged_gap(&self) -> S {
        self.largest_gap.unwrap_or(self.period * S::from_f64(20.0))
    }

    /// Returns every parameter outside its range.
    pub fn faults(&self) -> impl Iterator<Item = ParameterError> {
        let limit = |parameter: Parameter, limit: Option<S>| parameter.positive(limit?).err();
        let bridges = |gap: S| gap.is_finite() && gap >= self.period;
        let gap = self.largest_gap.and_then(|gap| {
            let allowed = Allowed::AtLeastOnePeriod;
            Parameter::LargestGap
                .unless(bridges(gap), gap, allowed)
                .err()
        });
        [
            Parameter::Period.positive(self.period).err(),
            gap,
            limit(Parameter::SpeedLimit, self.speed_limit),
            limit(Parameter::ForceLimit, self.force_limit),
            limit(Parameter::SlewLimit, self.slew_limit),
        ]
        .into_iter()
        .flatten()
        .chain(self.guard.faults())
        .chain(self.actuation.faults(self.period))
        .chain(self.line_faults())
    }

    /// Returns the limits that a line hold excludes.
    fn line_faults(&self) -> impl Iterator<Item = ParameterError> {
        let is_line = self.actuation.hold == Hold::Line;
        let slew = self.slew_limit.filter(|_| is_line).and_then(|limit| {
            let allowed = Allowed::Words("absent with a line hold");
            Parameter::SlewLimit.unless(false, limit, allowed).err()
        });
        let guard = self.guard.params().filter(|_| is_line).and_then(|guard| {
            let allowed =
                Allowed::Words("absent with a line hold: the guard bounds constant forces");
            Parameter::GuardSpeed
                .unless(false, guard.largest_speed, allowed)
                .err()
        });
        [slew, guard].into_iter().flatten()
    }

    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        self.faults().next().map_or(Ok(()), Err)
    }
}

#[cfg(feature = "serde")]
mod mass_as_number {
    //! A mass is a number, or "inf": JSON has no infinity, and a tagged enum would be noise.
    use core::fmt;
    use core::marker::PhantomData;

    use serde::de::{Error, Unexpected, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Mass, Scalar};

    impl<S: Scalar> Serialize for Mass<S> {
        fn serialize<Z: Serializer>(&self, serializer: Z) -> Result<Z::Ok, Z::Error> {
            match self {
                Mass::Finite(mass) => serializer.serialize_f64(mass.to_f64()),
                Mass::Infinite => serializer.serialize_str("inf"),
            }
        }
    }

    struct MassVisitor<S>(PhantomData<S>);

    impl<S: Scalar> Visitor<'_> for MassVisitor<S> {
        type Value = Mass<S>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a mass in kilograms or \"inf\"")
        }
        fn visit_f64<E: Error>(self, value: f64) -> Result<Mass<S>, E> {
            Ok(if value == f64::INFINITY {
                Mass::Infinite
            } else {
                Mass::Finite(S::from_f64(value))
            })
        }
        fn visit_i64<E: Error>(self, value: i64) -> Result<Mass<S>, E> {
            self.visit_f64(value as f64)
        }
        fn visit_u64<E: Error>(self, value: u64) -> Result<Mass<S>, E> {
            self.visit_f64(value as f64)
        }
        fn visit_str<E: Error>(self, value: &str) -> Result<Mass<S>, E> {
            match value {
                "inf" => Ok(Mass::Infinite),
                other => Err(E::invalid_value(Unexpected::Str(other), &self)),
            }
        }
    }

    impl<'de, S: Scalar> Deserialize<'de> for Mass<S> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(MassVisitor(PhantomData))
        }
    }
}
