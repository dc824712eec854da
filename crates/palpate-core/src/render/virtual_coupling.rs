//! Classic virtual coupling: a spring and a damper between the device and a proxy with mass.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{Allowed, Parameter, ParameterError, ParameterValue, Range, Unit};
use crate::relative_motion::{Drive, Relative};

/// Virtual coupling by name.
pub(super) const VIRTUAL_COUPLING: MethodInfo = MethodInfo {
    name: "virtual-coupling",
    summary: "spring and damper to a proxy with mass",
    colour: 13,
    settings: &[COUPLING_DAMPING, COUPLING_STIFFNESS, COUPLING_MASS],
};

const COUPLING_DAMPING: Setting = Setting {
    key: SettingKey::DAMPING,
    values: SettingValues::Number {
        unit: Unit::NewtonSecondPerMetre,
        range: Range::NotNegative,
    },
    help: "damping of the coupling",
    default: "K T",
};

const COUPLING_STIFFNESS: Setting = Setting {
    key: SettingKey::COUPLING_STIFFNESS,
    values: SettingValues::Number {
        unit: Unit::NewtonPerMetre,
        range: Range::Positive,
    },
    help: "stiffness of the coupling",
    default: "K",
};

const COUPLING_MASS: Setting = Setting {
    key: SettingKey::COUPLING_MASS,
    values: SettingValues::Number {
        unit: Unit::Kilogram,
        range: Range::Positive,
    },
    help: "mass of the proxy, at least T^2/1024 times the stiffness",
    default: "K T^2",
};

impl SettingKey {
    /// Stiffness of a virtual coupling `[N/m]`.
    pub const COUPLING_STIFFNESS: Self = Self::new("coupling_stiffness_n_per_m");
    /// Mass of the proxy of a virtual coupling `[kg]`.
    pub const COUPLING_MASS: Self = Self::new("coupling_mass_kg");
}

/// Largest natural frequency of proxy and coupling, times the period.
const MAX_PHASE: f64 = 32.0;
/// Phase of that frequency in a sub-step. The splitting has a relative error of a 24th of its square.
const PHASE_OF_SUB_STEP: f64 = 0.1;
/// Sub-steps of a nominal period.
const MIN_SUB_STEPS: u32 = 4;
/// Bound on the sub-steps of one interval.
const MAX_SUB_STEPS: u32 = 1024;

impl<S: Scalar> FromSettings<S> for VirtualCouplingParams<S> {
    fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        COUPLING_DAMPING.checked_word(method, given)?;
        let damping = given.number(SettingKey::DAMPING);
        let stiffness = given.number(SettingKey::COUPLING_STIFFNESS);
        let mass = given.number(SettingKey::COUPLING_MASS);
        Ok(Self {
            damping: S::from_f64(damping.unwrap_or(basis.impedance())),
            stiffness: S::from_f64(stiffness.unwrap_or(basis.stiffness)),
            mass: S::from_f64(mass.unwrap_or(basis.impedance() * basis.period)),
        })
    }
}

/// Parameters of virtual coupling.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VirtualCouplingParams<S> {
    /// Damping B_c of the coupling `[N s/m]`, not below 0.
    pub damping: S,
    /// Stiffness K_c of the coupling `[N/m]`, greater than 0.
    pub stiffness: S,
    /// Mass m_p of the proxy `[kg]`, greater than 0 and at least `K_c T^2/1024`.
    pub mass: S,
}

/// Virtual coupling (Colgate, Stanley and Brown, IROS 1995), as `palpate-world` has it: the object meets a proxy x_p
/// that a spring and a damper pull to the sampled device, and their force is held on the device.
///
/// ```text
/// m_p x_p'' = K_c (xi_i - x_p) + B_c (v_i - x_p') - K p_p h(p_p),   p_p = x_p - eta
/// M eta''   = f_V + K p_p h(p_p)
/// f_i       = K_c (xi_i - x_p) + B_c (v_i - x_p')
/// ```
///
/// The motion alternates the exact contact of proxy and object with the exact coupling (Strang splitting). The device
/// feels coupling and contact in series, and the proxy in free motion. The energy ledger knows the device and the
/// object; the energy of proxy and coupling is part of its leak.
#[derive(Clone, Copy, Debug)]
pub struct VirtualCoupling<S> {
    params: VirtualCouplingParams<S>,
    /// Duration of a sub-step `[s]`, at most.
    sub_step: S,
}

/// Proxy at the last sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct VirtualCouplingMemory<S> {
    proxy: Option<Proxy<S>>,
    /// Proxy at the end of a nominal period, with the device held.
    planned: Option<Proxy<S>>,
}

#[derive(Clone, Copy, Debug)]
struct Proxy<S> {
    /// Distance behind the sampled device `[m]`.
    behind: S,
    /// Velocity `[m/s]`.
    velocity: S,
}

impl<S: Scalar> MethodParams<S> for VirtualCouplingParams<S> {
    type Method = VirtualCoupling<S>;

    fn check(
        self,
        _: &Contact<S>,
        loop_params: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError> {
        COUPLING_DAMPING.check(self.damping)?;
        COUPLING_STIFFNESS.check(self.stiffness)?;
        COUPLING_MASS.check(self.mass)?;
        let period = loop_params.period;
        let phase = (self.stiffness / self.mass).sqrt() * period;
        let allowed = Allowed::Words("at least its stiffness times T^2/1024");
        Parameter::Setting(&COUPLING_MASS).unless(
            phase <= S::from_f64(MAX_PHASE),
            self.mass,
            allowed,
        )?;
        let longest = S::from_f64(PHASE_OF_SUB_STEP) / phase;
        let most = S::ONE / S::from_f64(f64::from(MIN_SUB_STEPS));
        Ok(VirtualCoupling {
            params: self,
            sub_step: period * longest.min(most),
        })
    }

    fn name(&self) -> &'static str {
        VIRTUAL_COUPLING.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let number = ParameterValue::Number;
        take(COUPLING_DAMPING.key.as_str(), number(self.damping));
        take(COUPLING_STIFFNESS.key.as_str(), number(self.stiffness));
        take(COUPLING_MASS.key.as_str(), number(self.mass));
    }
}

impl<S: Scalar> Method<S> for VirtualCoupling<S> {
    type Memory = VirtualCouplingMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut VirtualCouplingMemory<S>,
    ) -> Plan<S> {
        // A proxy begins at rest at the device.
        let proxy = *memory.proxy.get_or_insert(Proxy {
            behind: S::ZERO,
            velocity: S::ZERO,
        });
        let course = self.over(motion, &now.start, proxy, motion.period());
        memory.planned = Some(course.proxy);
        let slower = now.start.device_velocity - proxy.velocity;
        Plan {
            force: self.params.stiffness * proxy.behind + self.params.damping * slower,
            rule: course.rule,
            moved: course.moved,
        }
    }

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut VirtualCouplingMemory<S>,
    ) -> Displacement<S> {
        let (moved, end) = match (memory.planned, memory.proxy) {
            (Some(planned), _) if ended.nominal => (ended.planned, Some(planned)),
            (_, Some(proxy)) => {
                let course = self.over(motion, &ended.start, proxy, ended.elapsed);
                (course.moved, Some(course.proxy))
            }
            _ => (ended.as_planned(motion), None),
        };
        *memory = VirtualCouplingMemory {
            proxy: end.map(|proxy| Proxy {
                behind: proxy.behind + ended.device_moved,
                ..proxy
            }),
            planned: None,
        };
        moved
    }
}

/// Motion of proxy and object over an interval.
struct Course<S> {
    proxy: Proxy<S>,
    moved: Displacement<S>,
    rule: Rule<S>,
}

impl<S: Scalar> VirtualCoupling<S> {
    /// Returns the motion of proxy and object from `start` over `duration` `[s]`, with the device held.
    fn over(
        &self,
        motion: &ObjectMotion<S>,
        start: &Start<S>,
        mut proxy: Proxy<S>,
        duration: S,
    ) -> Course<S> {
        let VirtualCouplingParams {
            damping,
            stiffness,
            mass,
        } = self.params;
        let mut steps = 1;
        while steps < MAX_SUB_STEPS && S::from_f64(f64::from(steps)) * self.sub_step < duration {
            steps += 1;
        }
        let h = duration / S::from_f64(f64::from(steps));
        let half = S::HALF * h;
        let rate = damping / mass;
        // Velocity per acceleration over half a sub-step.
        let kick = if rate > S::ZERO {
            -(-rate * half).exp_m1() / rate
        } else {
            half
        };
        let kicked = |proxy: Proxy<S>| {
            let slower = start.device_velocity - proxy.velocity;
            let pull = stiffness / mass * proxy.behind + rate * slower;
            proxy.velocity + pull * kick
        };
        let of_proxy = S::ONE / mass;
        let acceleration = start.virtual_force * motion.mobility();
        let drive = Drive {
            stiffness: motion.stiffness(),
            mobility: of_proxy + motion.mobility(),
            acceleration: S::ZERO - acceleration,
        };
        let share = of_proxy / drive.mobility;
        let began = start.penetration - proxy.behind;
        let mut penetration = began;
        let mut object = Displacement {
            by: S::ZERO,
            velocity: start.object_velocity,
        };
        let (mut transition, mut pressed) = (None, began > S::ZERO);
        let mut passed = S::ZERO;
        for _ in 0..steps {
            proxy.velocity = kicked(proxy);
            let from = Relative {
                penetration,
                speed: proxy.velocity - object.velocity,
            };
            let course = drive.over(from, h);
            let apart = penetration + (from.speed - half * acceleration) * h;
            // Without contact the difference is rounding.
            let yielded = if course.impulse > S::ZERO {
                course.end.penetration - apart
            } else {
                S::ZERO
            };
            proxy.behind -= proxy.velocity * h + share * yielded;
            proxy.velocity -= of_proxy * course.impulse;
            object.by += (object.velocity + half * acceleration) * h - (S::ONE - share) * yielded;
            object.velocity += acceleration * h + motion.mobility() * course.impulse;
            penetration = course.end.penetration;
            pressed |= course.impulse > S::ZERO;
            transition = transition.or(course.first_transition.map(|after| passed + after));
            passed += h;
            proxy.velocity = kicked(proxy);
        }
        // A sum of sub-steps would add rounding to the flight. A wall flies nowhere.
        if motion.is_wall() || !pressed {
            object = motion.fly(start, duration);
        }
        let rule = match transition {
            None if pressed => Rule::Contact,
            None => Rule::Free,
            Some(after) if began > S::ZERO => Rule::Leaves(after),
            Some(after) => Rule::Enters {
                after,
                held_at: S::ZERO,
            },
        };
        Course {
            proxy,
            moved: object,
            rule,
        }
    }
}
