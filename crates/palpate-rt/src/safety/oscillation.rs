//! A contact that is rendered too stiff gives out energy that nobody put in, period after period.

/// When created energy counts as an oscillation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OscillationParams {
    /// Energy created within about [`window`](Self::window), net, that trips `[J]`; infinite: never.
    pub energy: f64,
    /// Time over which created energy is remembered; it fades by 1/e in it `[s]`.
    pub window: f64,
}

impl Default for OscillationParams {
    /// 50 mJ within a fifth of a second: a contact of 1 N that buzzes by half a millimetre at
    /// 100 Hz creates as much, and the paper's scenes rendered well do not.
    fn default() -> Self {
        Self {
            energy: 0.05,
            window: 0.2,
        }
    }
}

/// Sum of what was created, fading.
#[derive(Clone, Debug)]
pub(super) struct Oscillation {
    params: OscillationParams,
    /// Created by the method that renders now.
    recent: f64,
    /// Created by methods that rendered before it.
    before: f64,
    seen: Option<f64>,
}

impl Oscillation {
    pub fn new(params: OscillationParams) -> Self {
        Self {
            params,
            recent: 0.0,
            before: 0.0,
            seen: None,
        }
    }

    /// Takes note of the energy created so far `[J]` without counting what is new of it.
    pub fn pass_over(&mut self, created: f64) {
        self.seen = Some(created).filter(|created| created.is_finite());
    }

    /// Takes the energy created so far `[J]`, `elapsed` `[s]` after the last time. Whether it is
    /// too much.
    pub fn watch(&mut self, created: f64, elapsed: f64) -> bool {
        if !created.is_finite() {
            return true;
        }
        let new = created - self.seen.unwrap_or(created);
        self.seen = Some(created);
        let kept = (1.0 - elapsed / self.params.window).max(0.0);
        self.recent = self.recent * kept + new;
        self.before *= kept;
        self.recent + self.before > self.params.energy
    }

    /// Another method renders from now on. What was created stays in the sum, else frequent changes
    /// would hide an oscillation.
    pub fn another_method(&mut self) {
        self.before += self.recent;
        self.recent = 0.0;
    }

    /// Whether most of the sum was created before the method that renders now began.
    pub fn is_from_before(&self) -> bool {
        self.before > self.recent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 mJ by the first method, then so much by the second: whether that is too much, and whether
    /// most of it is from before.
    fn after_a_change(second: f64) -> (bool, bool) {
        let mut oscillation = Oscillation::new(OscillationParams::default());
        assert!(!oscillation.watch(0.0, 0.001));
        assert!(!oscillation.watch(0.04, 0.001));
        oscillation.another_method();
        let trips = oscillation.watch(0.04 + second, 0.001);
        (trips, oscillation.is_from_before())
    }

    #[test]
    fn what_was_created_before_a_change_counts_and_is_not_the_new_methods() {
        assert_eq!(after_a_change(0.0), (false, true));
        assert_eq!(after_a_change(0.012), (true, true));
        assert_eq!(after_a_change(0.045), (true, false));
        // A method that changes with every tick hides nothing.
        let mut oscillation = Oscillation::new(OscillationParams::default());
        let trips = (0..20).any(|i| {
            oscillation.another_method();
            oscillation.watch(0.004 * f64::from(i), 0.001)
        });
        assert!(trips);
    }
}
