//! Limits of a method on a device: the stiffest contact and the lightest object.

use super::bounce::{Bounce, BounceError, Plant};
use super::cell::Entry;
use super::growth::{Class, classify};
use palpate_scene::method::{MethodName, Settings};

/// Range of kappa or Kc in which a limit is searched.
pub const SEARCHED: (f64, f64) = (1e-4, 100.0);

/// Search steps per decade.
const PER_DECADE: f64 = 8.0;

/// Halvings of the search step that contains the limit, on a logarithmic scale: to half a percent.
const HALVINGS: usize = 6;

/// Limit of stability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Not even the easiest tried contact is stable.
    None,
    /// The hardest stable contact; all easier ones are stable.
    At(f64),
    /// All tried contacts up to this one are stable.
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
    /// Returns the largest stiffness `[N/m]` at which this device and object bounce stably from every start height.
    /// All softer tried contacts are stable, too.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
    pub fn stiffest(&self, method: MethodName, settings: Settings) -> Result<Limit, BounceError> {
        self.stiffest_where(|contact| contact.is_stable(method, settings))
    }

    fn stiffest_where(
        &self,
        mut holds: impl FnMut(&Self) -> Result<bool, BounceError>,
    ) -> Result<Limit, BounceError> {
        let per_kappa = self.device.mass / (self.period * self.period);
        let limit = hardest(|kappa| {
            holds(&Self {
                stiffness: kappa * per_kappa,
                ..*self
            })
        })?;
        Ok(limit.map(|kappa| kappa * per_kappa))
    }

    /// Returns [`Self::stiffest`] of the contacts that are also [steady](super::Stay::is_steady_pressed) while they are
    /// pressed: a strong damper oscillates in a held contact although its bounces lose energy.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
    pub fn stiffest_steady(
        &self,
        method: MethodName,
        settings: Settings,
    ) -> Result<Limit, BounceError> {
        self.stiffest_where(|contact| {
            Ok(contact.stay(method, settings)?.0.is_steady_pressed()
                && contact.is_stable(method, settings)?)
        })
    }

    /// Returns [`Self::stiffest`], and the largest stiffness `[N/m]` at which the mean-force error E is also below
    /// `most_error` `[%]` from every start height. All softer tried contacts satisfy the same condition. The
    /// stability search reuses the contacts found stable by the error search, since soft contacts take longest.
    ///
    /// # Errors
    /// For each limit separately: the bench or the method rejects a parameter, or a bounce is too long.
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
            let (entries, _) = at(kappa).evaluate(Plant::Damped, &[(method, settings)])?;
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

    /// Returns the smallest object mass `[kg]` that bounces stably from every start height at this stiffness. All
    /// heavier tried objects are stable, too.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
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

/// Returns the hardest stable value below which all are stable, on a logarithmic scale.
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
        // A stable region beyond a gap does not count.
        let Limit::At(found) = hardest(|x| Ok(!(0.01..=1.0).contains(&x))).unwrap() else {
            panic!("no limit");
        };
        assert!(found < 0.01);
    }
}
