//! The virtual damper, also known as the classic virtual coupling.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion, Start};
use crate::parameter::{ParameterError, ParameterValue, Range, Unit};
use crate::render::predict::{
    LONGEST_WINDOW_SETTING, PREDICTION, Prediction, PredictionMemory, Predictor,
};

/// The virtual damper by name.
pub(super) const VIRTUAL_DAMPER: MethodInfo = MethodInfo {
    name: "virtual-damper",
    summary: "spring and damper, the classic virtual coupling",
    colour: 2,
    settings: &[DAMPING, PREDICTION, DAMPER_OBJECT, LONGEST_WINDOW_SETTING],
};

const DAMPING: Setting = Setting {
    key: SettingKey::DAMPING,
    values: SettingValues::NumberOrWord {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::NotNegative,
        words: &[STABILITY_OPTIMAL],
    },
    help: "damping B of the contact; stability-optimal is that of the stiffest stable wall, 0.828 m/T",
    // It makes up for the half period that the hold lags on a wall.
    default: "K T/2",
};

/// Word for the damping at which a wall may be stiffest.
const STABILITY_OPTIMAL: &str = "stability-optimal";

/// B T/m at which an undamped mass on a sampled wall is stable up to the largest K T^2/m, 0.686: 2 (sqrt 2 - 1). It is
/// the maximum of `K T^2/m < 2 beta (2 - beta)/(2 + beta)`, beta = B T/m, for a backward difference without delay, as
/// derived here (Hulin, Gil and Albu-Schaeffer, 2014, have the optimum).
const OPTIMAL_DAMPING_RATIO: f64 = 2.0 * (core::f64::consts::SQRT_2 - 1.0);

const DAMPER_OBJECT: Setting = Setting {
    key: SettingKey::DAMPER_OBJECT,
    values: SettingValues::Words {
        words: &[
            DamperObject::SpringAndDamper.name(),
            DamperObject::Spring.name(),
            DamperObject::HeldForce.name(),
        ],
        earlier: &[],
    },
    help: "forces on the object in contact; held-force is the force on the device",
    default: DamperObject::SpringAndDamper.name(),
};

impl SettingKey {
    /// Forces on the object of the virtual damper, one of [`DamperObject`].
    pub const DAMPER_OBJECT: Self = Self::new("damper_object");
}

impl<S: Scalar> FromSettings<S> for VirtualDamperParams<S> {
    fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let damping = match DAMPING.checked_word(method, given)? {
            Some(_) => {
                let mass = basis
                    .device_mass
                    .ok_or(SettingsError::NoDeviceMass(&DAMPING))?;
                Some(OPTIMAL_DAMPING_RATIO * mass / basis.period)
            }
            None => given.number(SettingKey::DAMPING),
        };
        let object = given.word(SettingKey::DAMPER_OBJECT);
        Ok(Self {
            damping: S::from_f64(damping.unwrap_or(0.5 * basis.impedance())),
            object: object.and_then(DamperObject::named).unwrap_or_default(),
            prediction: Prediction::from_settings(method, given, basis)?,
        })
    }
}

/// Forces on the object of a virtual damper in contact.
///
/// Eq. (3) gives the held force. The paper does not specify whether its damper is also in the object's equation of
/// motion, Eq. (6a).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DamperObject {
    /// Spring and damper between the object and the sampled device position; for the damper, the device moves at its
    /// last step's velocity v_i: `M eta'' = f_V + K (xi_i - eta) + B (v_i - eta')`.
    #[default]
    SpringAndDamper,
    /// The spring alone, Eq. (6a); only the held force contains the damper.
    Spring,
    /// The force that the device feels, held: `M eta'' = f_V + f_i`. Device and object then exchange
    /// the same impulse, limits and delays included.
    HeldForce,
}

impl DamperObject {
    /// Returns the choice's name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SpringAndDamper => "spring-and-damper",
            Self::Spring => "spring",
            Self::HeldForce => "held-force",
        }
    }

    /// Returns the choice with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::SpringAndDamper, Self::Spring, Self::HeldForce];
        all.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<DamperObject> for ParameterValue<f64> {
    fn from(choice: DamperObject) -> Self {
        Self::Word(choice.name())
    }
}

/// Parameters of the virtual damper.
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
pub struct VirtualDamperParams<S> {
    /// Damping B of the contact `[N s/m]`, not below 0.
    pub damping: S,
    /// Forces on the object in contact.
    #[cfg_attr(feature = "serde", serde(default))]
    pub object: DamperObject,
    /// Estimator of the velocity of the penetration in the force. It uses the sampled penetration; an observer
    /// estimates the device's velocity, from which that of the object is subtracted.
    #[cfg_attr(feature = "serde", serde(default))]
    pub prediction: Prediction<S>,
}

impl<S> VirtualDamperParams<S> {
    /// Creates a virtual damper of `damping` `[N s/m]`.
    pub fn new(damping: S) -> Self {
        Self {
            damping,
            object: DamperObject::SpringAndDamper,
            prediction: Prediction::LastStep,
        }
    }
}

/// A spring and a damper in parallel, Eq. (3): `f_i = K p_i + B (p_i - p_{i-1}) / T` while
/// `p_i > 0`.
///
/// By default the damper also acts on the object, in closed form; [`DamperObject`] has other interpretations. The two
/// damping terms then use different velocities: the force that of the penetration, the object's motion that of the
/// device.
#[derive(Clone, Copy, Debug)]
pub struct VirtualDamper<S> {
    damping: S,
    object: DamperObject,
    predictor: Predictor<S>,
}

impl<S: Scalar> MethodParams<S> for VirtualDamperParams<S> {
    type Method = VirtualDamper<S>;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Self::Method, ParameterError> {
        Ok(VirtualDamper {
            damping: DAMPING.check(self.damping)?,
            object: self.object,
            predictor: self.prediction.check()?,
        })
    }

    fn name(&self) -> &'static str {
        VIRTUAL_DAMPER.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let (damping, object) = (self.damping, self.object.name());
        take(DAMPING.key.as_str(), ParameterValue::Number(damping));
        take(DAMPER_OBJECT.key.as_str(), ParameterValue::Word(object));
        self.prediction.describe(take);
    }
}

impl<S: Scalar> Method<S> for VirtualDamper<S> {
    type Memory = PredictionMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut PredictionMemory<S>,
    ) -> Plan<S> {
        let mut plan = now.unswitched(motion, || {
            let predicted = self.predictor.velocity(memory, now.start.object_velocity);
            let penetration_velocity = predicted.unwrap_or_else(|| {
                (now.start.penetration - now.previous_penetration) / now.elapsed
            });
            now.spring_force(motion) + self.damping * penetration_velocity
        });
        if self.object == DamperObject::HeldForce {
            plan.moved = under(motion, &now.start, plan.force, motion.period());
        }
        plan
    }

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut PredictionMemory<S>,
    ) -> Displacement<S> {
        let moved = if self.object == DamperObject::HeldForce {
            // The force that was actually held, after limits and delay.
            under(motion, &ended.start, ended.held.mean, ended.elapsed)
        } else {
            ended.as_planned(motion)
        };
        self.predictor
            .update(memory, &ended.measurement(), moved.by);
        moved
    }

    #[inline]
    fn contact_damping(&self) -> S {
        match self.object {
            DamperObject::SpringAndDamper => self.damping,
            DamperObject::Spring | DamperObject::HeldForce => S::ZERO,
        }
    }
}

/// Returns the object's motion under f_V and a held `force` `[N]` over `h` `[s]`.
fn under<S: Scalar>(motion: &ObjectMotion<S>, start: &Start<S>, force: S, h: S) -> Displacement<S> {
    let pushed = Start {
        virtual_force: start.virtual_force + force,
        ..*start
    };
    motion.fly(&pushed, h)
}
