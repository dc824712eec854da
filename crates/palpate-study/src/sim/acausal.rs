//! The force of the paper's Eq. (7): the balance of energy with the device's real motion, for comparison in simulation.

use palpate_core::{
    Contact, Displacement, Ended, Hfcr, HfcrParams, LoopParams, Method, MethodParams, ObjectMotion,
    ParameterError, Plan, Situation, Start,
};

/// Halvings of the bracket of the force.
const HALVINGS: usize = 100;

/// A force without a leak, which depends on the device's motion under that force: no renderer has it. HFCR replaces the
/// motion by a prediction.
///
/// For an undamped point mass under a constant force, in a loop without delay. All vectors are positive into the
/// object.
#[derive(Clone, Copy, Debug)]
pub struct AcausalParams {
    /// Mass m of the device `[kg]`, greater than 0.
    pub device_mass: f64,
    /// User's force f_u on the device `[N]`.
    pub user_force: f64,
}

/// The checked method.
#[derive(Clone, Copy, Debug)]
pub struct Acausal {
    params: AcausalParams,
    balance: Hfcr<f64>,
}

impl MethodParams<f64> for AcausalParams {
    type Method = Acausal;

    fn check(
        self,
        contact: &Contact<f64>,
        loop_params: &LoopParams<f64>,
    ) -> Result<Acausal, ParameterError> {
        Ok(Acausal {
            params: self,
            balance: HfcrParams::default().check(contact, loop_params)?,
        })
    }

    fn name(&self) -> &'static str {
        "acausal"
    }
}

impl Acausal {
    /// Returns the displacement of the device `[m]` in a period `[s]` under a held `force` on the object `[N]`.
    fn moved(&self, velocity: f64, force: f64, period: f64) -> f64 {
        let acceleration = (self.params.user_force - force) / self.params.device_mass;
        (velocity + 0.5 * acceleration * period) * period
    }
}

impl Method<f64> for Acausal {
    /// Velocity of the device at the sample `[m/s]`, once a sample has measured it.
    type Memory = Option<f64>;

    fn conclude(
        &self,
        motion: &ObjectMotion<f64>,
        ended: &Ended<f64>,
        velocity: &mut Option<f64>,
    ) -> Displacement<f64> {
        let acceleration =
            (self.params.user_force - ended.intended_force) / self.params.device_mass;
        *velocity = Some(ended.device_moved / ended.elapsed + 0.5 * acceleration * ended.elapsed);
        ended.as_planned(motion)
    }

    fn plan(
        &self,
        motion: &ObjectMotion<f64>,
        now: &Situation<'_, f64>,
        velocity: &mut Option<f64>,
    ) -> Plan<f64> {
        let period = motion.period();
        let velocity = velocity.unwrap_or(now.start.device_velocity);
        let planned = |force: f64| {
            let start = Start {
                device_velocity: self.moved(velocity, force, period) / period,
                ..now.start
            };
            let now = Situation { start, ..*now };
            self.balance.plan(motion, &now, &mut Default::default())
        };
        // A larger force moves the device less deep, and the balance then needs less force: the difference is monotone
        // but for jumps at transitions.
        let largest = planned(0.0).force.abs() + 1.0;
        let (mut low, mut high) = (-largest, largest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if planned(middle).force > middle {
                low = middle;
            } else {
                high = middle;
            }
        }
        planned(0.5 * (low + high))
    }
}
