//! Rate limit for reports of the estimated actuation delay.

use std::time::Duration;

/// Minimum change that is reported, in periods: it is significant for a stiff contact.
const LEAST: f64 = 0.02;
/// Minimum time between reports, because the estimate changes with every sample while it converges.
const SPACING: Duration = Duration::from_secs(1);

/// Last reported estimate.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LatenessWatch {
    said: f64,
    not_before: Duration,
}

impl LatenessWatch {
    /// Returns the estimate `lateness` `[s]` if it must be reported in a loop of `period` `[s]` at `now`.
    pub fn news(&mut self, lateness: f64, period: f64, now: Duration) -> Option<f64> {
        let changed = (lateness - self.said).abs() > LEAST * period;
        if !changed || now < self.not_before {
            return None;
        }
        self.said = lateness;
        self.not_before = now + SPACING;
        Some(lateness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lateness_is_news_when_it_has_changed_and_not_too_often() {
        let mut watch = LatenessWatch::default();
        let at = Duration::from_millis;
        assert_eq!(watch.news(0.0, 1e-3, at(1)), None);
        assert_eq!(watch.news(1.9e-5, 1e-3, at(2)), None);
        assert_eq!(watch.news(3e-4, 1e-3, at(3)), Some(3e-4));
        assert_eq!(watch.news(5e-4, 1e-3, at(900)), None, "too soon");
        assert_eq!(watch.news(3.1e-4, 1e-3, at(1100)), None, "not changed");
        assert_eq!(watch.news(-1e-4, 1e-3, at(1200)), Some(-1e-4));
    }
}
