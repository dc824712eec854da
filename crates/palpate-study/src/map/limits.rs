//! How far a method goes on a device: the stiffest contact, the lightest object.

use super::bounce::{Bounce, BounceError, Plant};
use super::cell::Entry;
use super::growth::{Class, classify};
use palpate_scene::method::{MethodName, Settings};

/// The numbers of difficulty, kappa or Kc, between which a limit is looked for.
pub const SEARCHED: (f64, f64) = (1e-4, 100.0);

/// Steps of the search for each factor of ten.
const PER_DECADE: f64 = 8.0;

/// Halvings of the step, in which stability ends, on a logarithmic scale: to half a percent.
const HALVINGS: usize = 6;

/// Where stability ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Not even the easiest that was tried is stable.
    None,
    /// All that is easier is stable, and this is the hardest.
    At(f64),
    /// All that was tried is stable, up to this.
    Beyond(f64),
}

impl Limit {
    fn map(self, of: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::None => Self::None,
            Self::At(value) => Self::At(of(value)),
            Self::Beyond(value) => Self::Beyond(of(value)),
        }
    }
}

impl Bounce {
    /// The largest stiffness `[N/m]` at which this device and object bounce stably from every start
    /// height; all softer contacts that were tried do, too.
    ///
    /// # Errors
    /// A parameter that the bench or the method refuses.
    pub fn stiffest(&self, method: MethodName, settings: Settings) -> Result<Limit, BounceError> {
        let per_kappa = self.device.mass / (self.period * self.period);
        let limit = hardest(|kappa| {
            Self {
                stiffness: kappa * per_kappa,
                ..*self
            }
            .is_stable(method, settings)
        })?;
        Ok(limit.map(|kappa| kappa * per_kappa))
    }

    /// [`Self::stiffest`], and the largest stiffness `[N/m]` at which the mean-force error E is below
    /// `most_error` `[%]` from every start height, too; all softer contacts that were tried are both. What
    /// one search has found stable the other does not run again: the soft contacts, which take longest.
    ///
    /// # Errors
    /// Of each by itself: a parameter that the bench or the method refuses, and a bounce that is too long.
    pub(super) fn stiffest_and_faithful(
        &self,
        method: MethodName,
        settings: Settings,
        most_error: f64,
    ) -> [Result<Limit, BounceError>; 2] {
        let per_kappa = self.device.mass / (self.period * self.period);
        let at = |kappa: f64| Self {
            stiffness: kappa * per_kappa,
            ..*self
        };
        let mut known_stable = Vec::new();
        let faithful = hardest(|kappa| {
            let (entries, _) = at(kappa).judge(Plant::Damped, &[(method, settings)])?;
            let is_stable = |entry: &Entry| entry.class() == Class::Stable;
            if !entries.iter().all(is_stable) {
                return Ok(false);
            }
            known_stable.push(kappa);
            Ok(entries.iter().all(|entry| entry.error.worst < most_error))
        });
        let stable = hardest(|kappa| {
            Ok(known_stable.contains(&kappa) || at(kappa).is_stable(method, settings)?)
        });
        [stable, faithful].map(|limit| limit.map(|limit| limit.map(|kappa| kappa * per_kappa)))
    }

    /// The smallest object mass `[kg]` that bounces stably from every start height at this
    /// stiffness; all heavier objects that were tried do, too.
    ///
    /// # Errors
    /// A parameter that the bench or the method refuses.
    pub fn lightest(&self, method: MethodName, settings: Settings) -> Result<Limit, BounceError> {
        let heaviest = self.stiffness * self.period * self.period;
        let limit = hardest(|object_kappa| {
            Self {
                object_mass: heaviest / object_kappa,
                ..*self
            }
            .is_stable(method, settings)
        })?;
        Ok(limit.map(|object_kappa| heaviest / object_kappa))
    }

    fn is_stable(&self, method: MethodName, settings: Settings) -> Result<bool, BounceError> {
        let worst = self.worst_growth(method, settings)?;
        Ok(classify(worst) == Class::Stable)
    }
}

/// The hardest that is stable, with all that is easier, on a logarithmic scale.
fn hardest(
    mut is_stable: impl FnMut(f64) -> Result<bool, BounceError>,
) -> Result<Limit, BounceError> {
    let step = 10.0_f64.powf(1.0 / PER_DECADE);
    let (mut stable, mut next) = (None, SEARCHED.0);
    loop {
        if !is_stable(next)? {
            break;
        }
        stable = Some(next);
        if next >= SEARCHED.1 {
            return Ok(Limit::Beyond(SEARCHED.1));
        }
        next = (next * step).min(SEARCHED.1);
    }
    let Some(mut stable) = stable else {
        return Ok(Limit::None);
    };
    for _ in 0..HALVINGS {
        let middle = (stable * next).sqrt();
        if is_stable(middle)? {
            stable = middle;
        } else {
            next = middle;
        }
    }
    Ok(Limit::At(stable))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_ends_where_stability_does() {
        for edge in [3e-4, 0.017, 0.6863, 42.0] {
            let Limit::At(found) = hardest(|x| Ok(x <= edge)).unwrap() else {
                panic!("{edge}");
            };
            assert!(found <= edge && edge < 1.01 * found, "{edge}: {found}");
        }
        assert_eq!(hardest(|_| Ok(false)), Ok(Limit::None));
        assert_eq!(hardest(|_| Ok(true)), Ok(Limit::Beyond(100.0)));
        // An island beyond a gap does not count.
        let Limit::At(found) = hardest(|x| Ok(!(0.01..=1.0).contains(&x))).unwrap() else {
            panic!("no limit");
        };
        assert!(found < 0.01);
    }
}
