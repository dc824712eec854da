//! The sampled spring with an object that a usual integrator moves, for comparison in simulation.

use palpate_core::{
    Contact, Displacement, LoopParams, Method, MethodParams, ObjectMotion, ParameterError, Plan,
    Rule, Situation,
};

/// Integrator of the object over one period, on the spring against the device held at its sample.
///
/// An integrator whose position does not depend on the force of the same sample is strictly causal. With the object of
/// mass M alone, its admittance has the real part -T/(2M) at every frequency, so it is not passive (Brown and Colgate,
/// 1998). Behind a coupling of damping B it is passive for `M >= B T/2`; with the `B = K T/2` of a passive wall, for
/// `M >= K T^2/4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// Exact motion, Eqs. (4) and (6a).
    Exact,
    /// Implicit midpoint: conserves the energy of object and spring.
    Midpoint,
    /// Explicit Euler: adds energy.
    Explicit,
    /// Semi-implicit Euler, velocity first: the usual integrator of engines.
    SemiImplicit,
    /// Implicit Euler: takes energy.
    Implicit,
}

impl Integrator {
    /// All integrators, in the order of tables.
    pub const ALL: [Self; 5] = [
        Self::Exact,
        Self::Midpoint,
        Self::Explicit,
        Self::SemiImplicit,
        Self::Implicit,
    ];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Midpoint => "midpoint",
            Self::Explicit => "explicit",
            Self::SemiImplicit => "semi-implicit",
            Self::Implicit => "implicit",
        }
    }
}

impl MethodParams<f64> for Integrator {
    type Method = Self;

    fn check(self, _: &Contact<f64>, _: &LoopParams<f64>) -> Result<Self, ParameterError> {
        Ok(self)
    }

    fn name(&self) -> &'static str {
        (*self).name()
    }
}

impl Method<f64> for Integrator {
    type Memory = ();

    fn plan(&self, motion: &ObjectMotion<f64>, now: &Situation<'_, f64>, (): &mut ()) -> Plan<f64> {
        let force = now.spring_force(motion);
        let start = &now.start;
        let (t, v) = (motion.period(), start.object_velocity);
        // Acceleration at the sample, and its decrease with the displacement of the object.
        let acceleration = (start.virtual_force + force) * motion.mobility();
        let stiffness = if now.in_contact() {
            motion.stiffness() * motion.mobility()
        } else {
            0.0
        };
        let rule = if now.in_contact() {
            Rule::Contact
        } else {
            Rule::Free
        };
        let displacement = |by: f64, velocity: f64| Displacement { by, velocity };
        let moved = match self {
            Self::Exact => motion.advance(rule, start, t),
            Self::Midpoint => {
                let by = t * (v + 0.5 * t * acceleration) / (1.0 + 0.25 * stiffness * t * t);
                displacement(by, 2.0 * by / t - v)
            }
            Self::Explicit => displacement(t * v, v + t * acceleration),
            Self::SemiImplicit => {
                let after = v + t * acceleration;
                displacement(t * after, after)
            }
            Self::Implicit => {
                let by = t * (v + t * acceleration) / (1.0 + stiffness * t * t);
                displacement(by, by / t)
            }
        };
        Plan { force, rule, moved }
    }
}
