//! User-defined method: the spring force at the predicted device position in the middle of the interval.

use palpate::{
    Allowed, Contact, LoopParams, Method, MethodParams, ObjectMotion, Parameter, ParameterError,
    ParameterValue, Plan, Situation,
};

/// Parameters of the method.
#[derive(Clone, Copy, Debug)]
pub struct LookAheadParams {
    /// How far to look ahead, in periods; from 0 to 1.
    pub periods: f64,
}

/// The checked method: `f_i = K (p_i + periods T v_i)` while `p_i > 0`, with v_i the device's
/// velocity against the object. A held force acts half a period late on average, so half a
/// period is a guess worth a try.
#[derive(Clone, Copy, Debug)]
pub struct LookAhead {
    periods: f64,
}

impl MethodParams<f64> for LookAheadParams {
    type Method = LookAhead;

    fn check(self, _: &Contact<f64>, _: &LoopParams<f64>) -> Result<LookAhead, ParameterError> {
        if (0.0..=1.0).contains(&self.periods) {
            return Ok(LookAhead {
                periods: self.periods,
            });
        }
        Err(ParameterError {
            parameter: Parameter::Own {
                name: "periods",
                unit: "",
            },
            value: self.periods,
            allowed: Allowed::Words("from 0 to 1"),
        })
    }

    fn name(&self) -> &'static str {
        "look-ahead"
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<f64>)) {
        take("periods", ParameterValue::Number(self.periods));
    }
}

impl Method<f64> for LookAhead {
    /// State between samples: none.
    type Memory = ();

    fn plan(&self, motion: &ObjectMotion<f64>, now: &Situation<'_, f64>, (): &mut ()) -> Plan<f64> {
        now.unswitched(motion, || {
            let start = &now.start;
            let approach = start.device_velocity - start.object_velocity;
            let penetration = start.penetration + self.periods * motion.period() * approach;
            motion.stiffness() * penetration.max(0.0)
        })
    }
}
