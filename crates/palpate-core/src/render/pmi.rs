//! Passive midpoint integration of the object.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{ParameterError, ParameterValue};

/// Passive midpoint integration by name.
pub(super) const PMI: MethodInfo = MethodInfo {
    name: "pmi",
    summary: "object by passive midpoint integration",
    colour: 11,
    settings: &[MIDPOINT_DEVICE],
};

const MIDPOINT_DEVICE: Setting = Setting {
    key: SettingKey::MIDPOINT_DEVICE,
    values: SettingValues::Words {
        words: &[
            MidpointDevice::Sample.name(),
            MidpointDevice::Extrapolated.name(),
        ],
        earlier: &[],
    },
    help: "position of the device over the period; extrapolated is at the velocity of the last step",
    default: MidpointDevice::Sample.name(),
};

impl SettingKey {
    /// Position of the device in passive midpoint integration, one of [`MidpointDevice`].
    pub const MIDPOINT_DEVICE: Self = Self::new("midpoint_device");
}

impl<S: Scalar> FromSettings<S> for PmiParams {
    fn from_settings(_: MethodName, given: &Settings, _: &Basis) -> Result<Self, SettingsError> {
        let device = given.word(SettingKey::MIDPOINT_DEVICE);
        Ok(Self {
            device: device.and_then(MidpointDevice::named).unwrap_or_default(),
        })
    }
}

/// Position of the device over the period in passive midpoint integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum MidpointDevice {
    /// Sampled position throughout.
    #[default]
    Sample,
    /// Moving at the velocity of the last step.
    Extrapolated,
}

impl MidpointDevice {
    /// Returns the choice's name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sample => "sample",
            Self::Extrapolated => "extrapolated",
        }
    }

    /// Returns the choice with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Sample, Self::Extrapolated];
        all.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<MidpointDevice> for ParameterValue<f64> {
    fn from(choice: MidpointDevice) -> Self {
        Self::Word(choice.name())
    }
}

/// Parameters of passive midpoint integration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct PmiParams {
    /// Position of the device over the period.
    pub device: MidpointDevice,
}

/// Passive midpoint integration, after Lee and Huang (2008) and Kim et al. (Int. J. Robotics Research, 2017). The
/// equations are as derived here:
///
/// ```text
/// eta+ = eta + (eta' + eta'+) T/2
/// M (eta'+ - eta') = (f_V + f) T
/// f = (V(p+) - V(p)) / (p+ - p),   V(p) = K p^2 h(p)/2
/// ```
///
/// with p+ the penetration at the end of the period, against the sampled or the extrapolated device. In sustained
/// contact f is the spring force at the midpoint. The implicit equation has one solution, in closed form. The energy of
/// object and spring changes by the work of f_V and of f on that motion of the device, at any stiffness and through
/// transitions. The remaining leak is that of the hold: the device moves otherwise. On a wall, the method is the basic
/// model, and HFCR without leak dissipation if the device is extrapolated.
#[derive(Clone, Copy, Debug)]
pub struct Pmi {
    device: MidpointDevice,
}

impl<S: Scalar> MethodParams<S> for PmiParams {
    type Method = Pmi;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Pmi, ParameterError> {
        Ok(Pmi {
            device: self.device,
        })
    }

    fn name(&self) -> &'static str {
        PMI.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let device = ParameterValue::Word(self.device.name());
        take(MIDPOINT_DEVICE.key.as_str(), device);
    }
}

impl<S: Scalar> Method<S> for Pmi {
    type Memory = ();

    #[inline]
    fn plan(&self, motion: &ObjectMotion<S>, now: &Situation<'_, S>, (): &mut ()) -> Plan<S> {
        let step = self.step(motion, &now.start, motion.period());
        let pressed = (now.in_contact(), step.end > S::ZERO);
        // The penetration is taken to change at a constant rate.
        let crossing = now.start.penetration / (now.start.penetration - step.end);
        let after = motion.period() * crossing;
        Plan {
            force: step.force,
            rule: match pressed {
                (false, false) => Rule::Free,
                (true, true) => Rule::Contact,
                (true, false) => Rule::Leaves(after),
                (false, true) => Rule::Enters {
                    after,
                    held_at: S::ZERO,
                },
            },
            moved: step.moved,
        }
    }

    #[inline]
    fn conclude(&self, motion: &ObjectMotion<S>, ended: &Ended<S>, (): &mut ()) -> Displacement<S> {
        if ended.nominal {
            ended.planned
        } else {
            self.step(motion, &ended.start, ended.elapsed).moved
        }
    }
}

/// Step of the midpoint rule.
struct Step<S> {
    force: S,
    moved: Displacement<S>,
    /// Penetration at its end `[m]`.
    end: S,
}

impl Pmi {
    /// Returns the step from `start` over `h` `[s]`.
    #[inline]
    fn step<S: Scalar>(self, motion: &ObjectMotion<S>, start: &Start<S>, h: S) -> Step<S> {
        let travel = match self.device {
            MidpointDevice::Sample => S::ZERO,
            MidpointDevice::Extrapolated => start.device_velocity * h,
        };
        // The end without a force is `free`; a force f moves it by -f compliance.
        let compliance = S::HALF * h * h * motion.mobility();
        let p = start.penetration;
        let free = p + travel - motion.fly(start, h).by;
        let (end, force) = midpoint_end(motion.stiffness(), p, free, compliance);
        let pushed = Start {
            virtual_force: start.virtual_force + force,
            ..*start
        };
        Step {
            force,
            moved: motion.fly(&pushed, h),
            end,
        }
    }
}

/// Returns the solution of `end = free - compliance f`, `f = (V(end) - V(p))/(end - p)`: the final penetration `[m]`
/// and the force `[N]`. f increases with `end`, so the solution is unique.
#[inline]
fn midpoint_end<S: Scalar>(stiffness: S, p: S, free: S, compliance: S) -> (S, S) {
    let c = S::HALF * stiffness * compliance;
    let half = S::HALF * stiffness;
    if p <= S::ZERO {
        if free <= S::ZERO {
            return (free, S::ZERO);
        }
        // (1 + c) end^2 - (p + free) end + p free = 0, the root above 0 without cancellation.
        let sum = p + free;
        let four = S::TWO + S::TWO;
        let root = (sum * sum - four * (S::ONE + c) * p * free)
            .max(S::ZERO)
            .sqrt();
        let end = if sum > S::ZERO {
            (sum + root) / (S::TWO * (S::ONE + c))
        } else {
            S::TWO * p * free / (sum - root)
        };
        return (end, half * end * (end / (end - p)));
    }
    if free > c * p {
        let end = (free - c * p) / (S::ONE + c);
        return (end, half * (p + end));
    }
    // (free - end) (p - end) = c p^2, the root not above 0.
    let apart = p - free;
    let four = S::TWO + S::TWO;
    let root = (apart * apart + four * c * p * p).sqrt();
    let end = (S::HALF * (p + free - root)).min(S::ZERO);
    (end, half * p * (p / (p - end)))
}
