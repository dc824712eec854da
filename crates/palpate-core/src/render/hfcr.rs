//! HFCR, the paper's method: energy-consistent rendering of contact forces.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{AUTO, Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams, Mass};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{Parameter, ParameterError, ParameterValue, Range, Unit};
use crate::render::predict::{
    LONGEST_WINDOW_SETTING, PREDICTION, Prediction, PredictionMemory, Predictor,
};

/// Shorter device displacements `[m]` count as 0 in divisions of the force.
const STANDSTILL: f64 = 1e-9;

/// The modified force alone, by name: a step of the method for comparison. Its force is not bounded if the object
/// leaves while the device reverses its motion.
pub(super) const HFCR_MOD: MethodInfo = MethodInfo {
    name: "hfcr-mod",
    summary: "energy-consistent force",
    colour: 6,
    settings: &[BALANCE],
};

/// The modified force with smooth transitions, by name.
pub(super) const HFCR_MOD_ST: MethodInfo = MethodInfo {
    name: "hfcr-mod-st",
    summary: "energy-consistent force, smooth transitions",
    colour: 5,
    settings: &[ENTRY_HOLD, BALANCE],
};

/// HFCR by name.
pub(super) const HFCR: MethodInfo = MethodInfo {
    name: "hfcr",
    summary: "energy-consistent force, smooth transitions, leak dissipation",
    colour: 0,
    settings: &[
        DAMPING,
        PREDICTION,
        ENTRY_HOLD,
        LONGEST_WINDOW_SETTING,
        BALANCE,
    ],
};

const DAMPING: Setting = Setting {
    key: SettingKey::DAMPING,
    values: SettingValues::NumberOrWord {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::NotNegative,
        words: &[AUTO, ADAPTIVE],
    },
    help: "damping b of the leak dissipation; auto derives it, adaptive varies it with the remaining leak",
    default: "0",
};

/// Word for a damping that varies with the remaining leak.
const ADAPTIVE: &str = "adaptive";

const ENTRY_HOLD: Setting = Setting {
    key: SettingKey::ENTRY_HOLD,
    values: SettingValues::Words {
        words: &[
            EntryHold::Crossing.name(),
            EntryHold::Sample.name(),
            EntryHold::Midpoint.name(),
        ],
        earlier: &[],
    },
    help: "held position of the device if contact begins within a period; midpoint is between the crossing and the \
           predicted end",
    default: EntryHold::Crossing.name(),
};

const BALANCE: Setting = Setting {
    key: SettingKey::BALANCE,
    values: SettingValues::Words {
        words: &[
            EnergyBalance::WithVirtualForce.name(),
            EnergyBalance::AsPrinted.name(),
        ],
        earlier: &[],
    },
    help: "energy balance of the modified force; as-printed, Eq. (8), lacks the work of the virtual force and has \
           unbounded forces",
    default: EnergyBalance::WithVirtualForce.name(),
};

impl SettingKey {
    /// Energy balance of HFCR's modified force, one of [`EnergyBalance`].
    pub const BALANCE: Self = Self::new("balance");
    /// Position at which HFCR holds the device after an entry, one of [`EntryHold`].
    pub const ENTRY_HOLD: Self = Self::new("entry_hold");
}

impl<S: Scalar> FromSettings<S> for HfcrParams<S> {
    fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let hold = given.word(SettingKey::ENTRY_HOLD);
        let balance = given.word(SettingKey::BALANCE);
        Ok(Self {
            modified_force: true,
            smooth_transition: method != MethodName::HfcrMod,
            leak_dissipation: match DAMPING.checked_word(method, given)? {
                Some(ADAPTIVE) => LeakDissipation::Adaptive,
                Some(_) => LeakDissipation::Auto {
                    device_mass: basis
                        .device_mass
                        .map(S::from_f64)
                        .ok_or(SettingsError::NoDeviceMass(&DAMPING))?,
                },
                None => match given.number(SettingKey::DAMPING) {
                    Some(damping) => LeakDissipation::Damping(S::from_f64(damping)),
                    None => LeakDissipation::Off,
                },
            },
            prediction: Prediction::from_settings(method, given, basis)?,
            entry_hold: hold.and_then(EntryHold::named).unwrap_or_default(),
            balance: balance.and_then(EnergyBalance::named).unwrap_or_default(),
        })
    }
}

/// Damping b of the leak dissipation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum LeakDissipation<S> {
    /// No damping.
    #[default]
    Off,
    /// A fixed b `[N s/m]`, not below 0.
    Damping(S),
    /// The least b that cancels the leak while (kappa) is small,
    /// `K^2 T^3 / (4 m) * M / (m + M)` with m the device's effective mass.
    ///
    /// It cancels leak, which is not the same as force error: on an undamped point mass it takes
    /// the mean-force error of the paper's first experiment from 14.7 % to 14.9 %, and that of
    /// the second from 102 % to 85 %.
    Auto {
        /// Effective mass m of the device `[kg]`, greater than 0.
        device_mass: S,
    },
    /// A b_i that varies from sample to sample with the accumulated remaining leak L_i, as a share of the energy that
    /// object and spring store: all of K T/2, the damping that a held spring lacks on a wall, if it is all leak. As
    /// derived here; the paper does not specify its b_i.
    ///
    /// `b_i = K T/2 min(1, max(0, L_i)/(M eta'_i^2/2 + K p_i^2 h(p_i)/2))`
    Adaptive,
}

/// Position at which the device is held from the instant tau at which contact begins within an interval.
///
/// Eq. (6a) requires a device at rest, and the paper does not specify its position after an entry. For each choice, the
/// force follows from the energy balance, Eq. (9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum EntryHold {
    /// Position at which the device is predicted to touch the object, `xi_c = xi_i + d tau/T`: the spring is relaxed at
    /// that instant.
    #[default]
    Crossing,
    /// Sampled position xi_i: only quantities of t_i are used. The spring is initially stretched if the device moves
    /// towards the object.
    Sample,
    /// Mean of the crossing and the predicted position at the interval's end, `(xi_c + xi~)/2`: the mean position in
    /// contact.
    Midpoint,
}

impl EntryHold {
    /// Returns the choice's name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Crossing => "crossing",
            Self::Sample => "sample",
            Self::Midpoint => "midpoint",
        }
    }

    /// Returns the choice with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Crossing, Self::Sample, Self::Midpoint];
        all.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<EntryHold> for ParameterValue<f64> {
    fn from(choice: EntryHold) -> Self {
        Self::Word(choice.name())
    }
}

/// Energy balance from which the modified force follows, Eq. (9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum EnergyBalance {
    /// Stored energy with the work of the virtual force, `-f_V eta`.
    #[default]
    WithVirtualForce,
    /// Eq. (8) as printed, without that work: the force is larger by `f_V (eta_{i+1} - eta_i) / d`, which is unbounded
    /// as the device reverses its motion. For comparison with the paper, not for a motor.
    AsPrinted,
}

impl EnergyBalance {
    /// Returns the choice's name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::WithVirtualForce => "with-virtual-force",
            Self::AsPrinted => "as-printed",
        }
    }

    /// Returns the choice with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::WithVirtualForce, Self::AsPrinted];
        all.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<EnergyBalance> for ParameterValue<f64> {
    fn from(choice: EnergyBalance) -> Self {
        Self::Word(choice.name())
    }
}

/// Parameters of HFCR with its three independent steps. By default the first two are on, and dissipation is off.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct HfcrParams<S> {
    /// Modified contact force, Eq. (9), in place of the spring force K p_i.
    pub modified_force: bool,
    /// Whether contact begins and ends at the predicted instants within the interval, instead of at samples.
    pub smooth_transition: bool,
    /// Damping that removes the remaining leak, Eq. (11).
    pub leak_dissipation: LeakDissipation<S>,
    /// Prediction of the device position at the next sample.
    pub prediction: Prediction<S>,
    /// Position at which the device is held after contact has begun within an interval. For smooth transitions only.
    pub entry_hold: EntryHold,
    /// Energy balance of the modified force.
    pub balance: EnergyBalance,
}

impl<S> Default for HfcrParams<S> {
    fn default() -> Self {
        Self {
            modified_force: true,
            smooth_transition: true,
            leak_dissipation: LeakDissipation::Off,
            prediction: Prediction::LastStep,
            entry_hold: EntryHold::Crossing,
            balance: EnergyBalance::WithVirtualForce,
        }
    }
}

impl<S> HfcrParams<S> {
    /// Returns the parameters of the modified force alone: `hfcr-mod` of the program.
    #[must_use]
    pub fn modified_force_only() -> Self {
        Self {
            smooth_transition: false,
            ..Self::default()
        }
    }

    /// Returns the parameters of all three steps, with damping `b` `[N s/m]`.
    pub fn with_damping(b: S) -> Self {
        Self {
            leak_dissipation: LeakDissipation::Damping(b),
            ..Self::default()
        }
    }
}

/// HFCR: a held force whose work equals the change of the object's stored energy, if the device moves at its predicted
/// velocity.
///
/// The stored energy includes the work of the virtual force, which the paper's Eq. (8) omits. With it Eq. (9) has
/// closed forms without division by the device's displacement.
#[derive(Clone, Copy, Debug)]
pub struct Hfcr<S> {
    modified_force: bool,
    smooth_transition: bool,
    damping: S,
    /// Whether b_i varies with the remaining leak, up to `damping`.
    is_adaptive: bool,
    predictor: Predictor<S>,
    entry_hold: EntryHold,
    balance: EnergyBalance,
}

impl<S: Scalar> Hfcr<S> {
    /// Returns the damping b of the leak dissipation `[N s/m]`: as given, as computed from the device's mass, or the
    /// largest b_i.
    pub fn damping(&self) -> S {
        self.damping
    }
}

impl<S: Scalar> MethodParams<S> for HfcrParams<S> {
    type Method = Hfcr<S>;

    fn check(
        self,
        contact: &Contact<S>,
        loop_params: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError> {
        let damping = match self.leak_dissipation {
            LeakDissipation::Off => S::ZERO,
            LeakDissipation::Damping(b) => DAMPING.check(b)?,
            LeakDissipation::Auto { device_mass } => {
                Parameter::DeviceMass.positive(device_mass)?;
                let (k, t) = (contact.stiffness, loop_params.period);
                let wall = k * k * t * t * t / (S::from_f64(4.0) * device_mass);
                let damping = match contact.object_mass {
                    Mass::Infinite => wall,
                    Mass::Finite(mass) => wall * mass / (device_mass + mass),
                };
                Parameter::DerivedDamping.not_negative(damping)?
            }
            LeakDissipation::Adaptive => {
                let most = S::HALF * contact.stiffness * loop_params.period;
                Parameter::DerivedDamping.not_negative(most)?
            }
        };
        Ok(Hfcr {
            modified_force: self.modified_force,
            smooth_transition: self.smooth_transition,
            damping,
            is_adaptive: matches!(self.leak_dissipation, LeakDissipation::Adaptive),
            predictor: self.prediction.check()?,
            entry_hold: self.entry_hold,
            balance: self.balance,
        })
    }

    /// Without smooth transitions the method is a step of HFCR with its own name. HFCR without dissipation is `hfcr`.
    fn name(&self) -> &'static str {
        if self.smooth_transition {
            HFCR.name
        } else {
            HFCR_MOD.name
        }
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let switch = ParameterValue::Switch;
        take("modified_force", switch(self.modified_force));
        take("smooth_transition", switch(self.smooth_transition));
        let damping = match self.leak_dissipation {
            LeakDissipation::Off => ParameterValue::Number(S::ZERO),
            LeakDissipation::Damping(damping) => ParameterValue::Number(damping),
            LeakDissipation::Auto { .. } => ParameterValue::ToBeDerived,
            LeakDissipation::Adaptive => ParameterValue::Word(ADAPTIVE),
        };
        take(DAMPING.key.as_str(), damping);
        self.prediction.describe(take);
        if self.smooth_transition {
            let hold = ParameterValue::Word(self.entry_hold.name());
            take(ENTRY_HOLD.key.as_str(), hold);
        }
        let balance = ParameterValue::Word(self.balance.name());
        take(BALANCE.key.as_str(), balance);
    }

    fn derived(self, method: &Hfcr<S>) -> Self {
        let leak_dissipation = match self.leak_dissipation {
            LeakDissipation::Off => LeakDissipation::Off,
            LeakDissipation::Adaptive => LeakDissipation::Adaptive,
            LeakDissipation::Damping(_) | LeakDissipation::Auto { .. } => {
                LeakDissipation::Damping(method.damping)
            }
        };
        Self {
            leak_dissipation,
            ..self
        }
    }
}

impl<S: Scalar> Method<S> for Hfcr<S> {
    type Memory = PredictionMemory<S>;

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut PredictionMemory<S>,
    ) -> Displacement<S> {
        self.predictor.update(memory, &ended.measurement(), S::ZERO);
        ended.as_planned(motion)
    }

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut PredictionMemory<S>,
    ) -> Plan<S> {
        let predicted = self.predictor.mean_velocity(memory, motion.period());
        // Field by field: a copy of the whole waits until the last field is written.
        let start = &Start {
            penetration: now.start.penetration,
            object_velocity: now.start.object_velocity,
            device_velocity: predicted.unwrap_or(now.start.device_velocity),
            virtual_force: now.start.virtual_force,
        };
        let period = motion.period();

        let Modified {
            force: modified,
            rule,
            moved,
            share,
        } = if now.in_contact() {
            self.modified_in_contact(motion, start)
        } else {
            match motion.entry(start).filter(|_| self.smooth_transition) {
                None => Modified {
                    force: S::ZERO,
                    rule: Rule::Free,
                    moved: motion.fly(start, period),
                    share: S::ZERO,
                },
                Some(after) => self.modified_on_entry(motion, start, after),
            }
        };
        let elastic = if self.modified_force {
            match self.balance {
                EnergyBalance::WithVirtualForce => modified,
                EnergyBalance::AsPrinted => modified + unpaid_force(start, &moved, share, period),
            }
        } else {
            now.spring_force(motion)
        };
        // Eq. (11).
        let approach = start.device_velocity - start.object_velocity;
        let mut damping = self.damping;
        if self.is_adaptive {
            let leak = now.held_leak.max(S::ZERO);
            let stored = motion.stored_energy(start.penetration, start.object_velocity);
            if leak < stored {
                damping = damping * (leak / stored);
            }
        }
        let dissipating = share * damping * approach;
        Plan {
            force: elastic + dissipating,
            rule,
            moved,
        }
    }
}

/// Returns the force `[N]` whose work along the predicted step of the device is that of the virtual force on the
/// object, which Eq. (8) as printed lacks; 0 for a free interval, and for a device at rest, where it has no value.
fn unpaid_force<S: Scalar>(start: &Start<S>, moved: &Displacement<S>, share: S, period: S) -> S {
    let d = start.device_velocity * period;
    if share > S::ZERO && d.abs() >= S::from_f64(STANDSTILL) {
        start.virtual_force * (moved.by / d)
    } else {
        S::ZERO
    }
}

/// Modified force and the motion of the object that belongs to it.
struct Modified<S> {
    /// Modified contact force, Eq. (9) `[N]`.
    force: S,
    /// Motion of the object.
    rule: Rule<S>,
    /// Displacement of the object over one period.
    moved: Displacement<S>,
    /// Part of the interval spent in contact.
    share: S,
}

impl<S: Scalar> Hfcr<S> {
    /// Returns the modified force for an interval that begins in contact.
    #[inline(always)]
    fn modified_in_contact(&self, motion: &ObjectMotion<S>, start: &Start<S>) -> Modified<S> {
        let period = motion.period();
        let k = motion.stiffness();
        let p = start.penetration;
        // d = xi~ - xi_i; the paper's prediction is xi~ = 2 xi_i - xi_{i-1}.
        let d = start.device_velocity * period;
        let pressed = motion.press(start);
        let (force, rule, moved, share) = if p + d - pressed.by > S::ZERO {
            let force = k * (p + S::HALF * d - pressed.by);
            (force, Rule::Contact, pressed, S::ONE)
        } else if self.smooth_transition {
            let after = motion.release(start);
            let rule = Rule::Leaves(after);
            let share = after / period;
            let force = -S::HALF * k * d * share * share;
            (force, rule, motion.advance(rule, start, period), share)
        } else {
            // Contact is predicted to end: the device receives all energy that the held spring still stores.
            let left = p - pressed.by;
            let force = if d.abs() < S::from_f64(STANDSTILL) {
                k * left.max(S::ZERO)
            } else {
                -S::HALF * k * left * (left / d)
            };
            (force, Rule::Contact, pressed, S::ONE)
        };
        Modified {
            force,
            rule,
            moved,
            share,
        }
    }

    /// Returns the modified force for an interval in which contact begins `after` `[s]`.
    #[inline(always)]
    fn modified_on_entry(
        &self,
        motion: &ObjectMotion<S>,
        start: &Start<S>,
        after: S,
    ) -> Modified<S> {
        let period = motion.period();
        let k = motion.stiffness();
        // The predicted displacement of the device, as in contact.
        let d = start.device_velocity * period;
        let waiting = after / period;
        // Position at which the device touches, and at which it is held, as fractions of d.
        let touched_at = start.device_velocity * after;
        let (hold, held_at) = match self.entry_hold {
            EntryHold::Crossing => (waiting, touched_at),
            EntryHold::Sample => (S::ZERO, S::ZERO),
            EntryHold::Midpoint => (S::HALF * (S::ONE + waiting), S::HALF * (touched_at + d)),
        };
        let rule = Rule::Enters { after, held_at };
        let moved = motion.advance(rule, start, period);
        // Mean of the held position and the predicted end position of the device.
        let device = S::HALF * d * (S::ONE + hold);
        let mut force = (S::ONE - hold) * k * (start.penetration + device - moved.by);
        if self.entry_hold != EntryHold::Crossing {
            // The spring is not relaxed initially; its initial energy is supplied as well.
            let stretched = hold - waiting;
            force += S::HALF * k * d * stretched * stretched;
        }
        Modified {
            force,
            rule,
            moved,
            share: S::ONE - waiting,
        }
    }
}
