//! Limits of methods on a device: the largest stiffness over the object's mass.

use palpate_scene::method::MethodName;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::bounce::{Bounce, BounceError, default_settings};
use super::limits::Limit;

/// Object masses relative to the device's, and their number per decade.
const MASSES: (f64, f64) = (0.01, 100.0);
const PER_DECADE: i32 = 2;

/// The limits of methods over the object's mass.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reach {
    /// Object masses, from light to heavy `[kg]`.
    pub masses: Vec<f64>,
    /// One for each method.
    pub methods: Vec<MethodReach>,
}

/// The limits of one method, with its default settings.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodReach {
    /// The method.
    pub method: MethodName,
    /// Maximum stiffness of a stable bounce, per mass `[N/m]`; `None` if a bounce is too long for a simulation.
    pub stable: Vec<Option<Limit>>,
    /// Maximum stiffness of a stable bounce with a small error, per mass `[N/m]`.
    pub faithful: Vec<Option<Limit>>,
}

impl Bounce {
    /// Returns the limits of `methods` on this device over the object's mass, for stability alone and for a
    /// mean-force error E below `most_error` `[%]`. Calls `done` after each mass and method.
    ///
    /// # Errors
    /// The bench or a method rejects a parameter.
    pub fn reach(
        &self,
        methods: &[MethodName],
        most_error: f64,
        done: impl Fn() + Sync,
    ) -> Result<Reach, BounceError> {
        let decades = (MASSES.1 / MASSES.0).log10();
        #[expect(clippy::cast_possible_truncation, reason = "a few decades")]
        let last = decades.round() as i32 * PER_DECADE;
        let mass = |step: i32| {
            let power = f64::from(step) / f64::from(PER_DECADE);
            self.device.mass * MASSES.0 * 10.0_f64.powf(power)
        };
        let masses: Vec<f64> = (0..=last).map(mass).collect();
        let pairs: Vec<(MethodName, f64)> = methods
            .iter()
            .flat_map(|method| masses.iter().map(|mass| (*method, *mass)))
            .collect();
        let limits: Vec<(Option<Limit>, Option<Limit>)> = pairs
            .into_par_iter()
            .map(|(method, object_mass)| {
                let bounce = Self {
                    object_mass,
                    ..*self
                };
                let settings = default_settings(method);
                let [stable, faithful] = bounce.stiffest_and_faithful(method, settings, most_error);
                done();
                Ok((known(stable)?, known(faithful)?))
            })
            .collect::<Result<_, BounceError>>()?;
        let methods = methods
            .iter()
            .zip(limits.chunks(masses.len()))
            .map(|(method, limits)| MethodReach {
                method: *method,
                stable: limits.iter().map(|limits| limits.0).collect(),
                faithful: limits.iter().map(|limits| limits.1).collect(),
            })
            .collect();
        Ok(Reach { masses, methods })
    }
}

/// Returns the limit; `None` if a bounce is too long for a simulation.
fn known(limit: Result<Limit, BounceError>) -> Result<Option<Limit>, BounceError> {
    match limit {
        Ok(limit) => Ok(Some(limit)),
        Err(BounceError::TooLong(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapParams;
    use palpate_scene::Model;

    #[test]
    fn what_is_faithful_is_stable_and_coupled_reaches_farthest() {
        let params = MapParams::default();
        let bounce = Bounce {
            device: params.device,
            stiffness: 100.0,
            object_mass: 1.0,
            forces: params.forces,
            gap: params.gap,
            period: 0.02,
            model_period: 1.0,
            delay: 0.0,
            lag: 0.0,
            model: Model::default(),
        };
        let methods = [MethodName::Hfcr, MethodName::Coupled];
        let reach = bounce.reach(&methods, 20.0, || {}).unwrap();
        assert_eq!(reach.masses.len(), 9);
        assert!((reach.masses[4] / bounce.device.mass - 1.0).abs() < 1e-9);
        let height = |limit: &Option<Limit>| match limit {
            Some(Limit::At(value) | Limit::Beyond(value)) => *value,
            _ => 0.0,
        };
        for of in &reach.methods {
            for (stable, faithful) in of.stable.iter().zip(&of.faithful) {
                // Both searches halve to half a percent.
                assert!(height(faithful) <= 1.01 * height(stable), "{of:?}");
            }
        }
        let [hfcr, coupled] = &reach.methods[..] else {
            panic!("two methods");
        };
        for (near, far) in hfcr.faithful.iter().zip(&coupled.faithful) {
            assert!(height(far) > height(near), "{near:?} {far:?}");
        }
        // The search equals the search of the limits.
        let heavy = Bounce {
            object_mass: reach.masses[8],
            ..bounce
        };
        let settings = default_settings(MethodName::Hfcr);
        let stiffest = heavy.stiffest(MethodName::Hfcr, settings).unwrap();
        assert_eq!(hfcr.stable[8], Some(stiffest));
    }
}
