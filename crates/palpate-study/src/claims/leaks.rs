//! Claims about the leaks.

use super::{Claim, ClaimError, FINE_PERIOD, Found, PaperScenes, claim};
use crate::sim::closed_loop::Bench;
use crate::sim::run::{Run, Tick};
use palpate_scene::method::MethodName;

/// Compares the leak of each interval with that of the spring force on the same motion, as the paper does. The sums
/// over a run are for information: in a sum, leaks of opposite sign cancel.
pub(super) fn remaining_leak(scenes: &PaperScenes<'_>) -> Result<Claim, ClaimError> {
    /// Half an order of magnitude above 1/10: 10^-0.5.
    const AT_MOST: f64 = 0.316;
    let [first, second] = scenes.point_mass;
    let mut found = Vec::new();
    for (name, scene) in [
        ("Fig. 2", scenes.fig2),
        ("experiment 1", first),
        ("experiment 2", second),
    ] {
        let bench = Bench::new(scene)?;
        for method in [MethodName::HfcrMod, MethodName::HfcrModSt, MethodName::Hfcr] {
            let run = bench.run(method)?;
            let ratio = median_remaining(&run);
            let what = format!("{name}, {method}: median remaining over original leak");
            found.push(Found::of(what, ratio, "").decides(ratio <= AT_MOST));
            let ledger = run.last().ledger;
            let (original, held) = (ledger.original_leak, ledger.held_leak);
            for (sum, ratio) in [
                ("leaks", held.accumulated / original.accumulated),
                ("absolute leaks", held.absolute / original.absolute),
            ] {
                let what = format!("{name}, {method}: the same of the sums of the {sum}");
                found.push(Found::of(what, ratio, ""));
            }
        }
    }
    Ok(claim(
        "remaining leak",
        "the remaining leak of an interval is one order of magnitude smaller than its original leak",
        format!("on the same motion, a median ratio of at most {AT_MOST}"),
        found,
    ))
}

/// Returns the median of |remaining leak / original leak| over the intervals that begin or end in contact.
fn median_remaining(run: &Run) -> f64 {
    let touching = |tick: &Tick| tick.output.penetration > 0.0;
    let contacts = run.ticks.windows(2);
    let mut ratios: Vec<f64> = contacts
        .filter(|ends| ends.iter().any(touching))
        .map(|ends| ends[1].ledger)
        .map(|ledger| (ledger.held_leak.last / ledger.original_leak.last).abs())
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN)
}

pub(super) fn leak_at_1_khz(scenes: &PaperScenes<'_>) -> Result<Claim, ClaimError> {
    const FROM_TO: (f64, f64) = (200.0, 800.0);
    let mut found = Vec::new();
    for (number, scene) in (1..).zip(scenes.point_mass) {
        // Each over the collisions of the scene.
        let coarse = Bench::new(scene)?.run(MethodName::Basic)?;
        let mut often = scene.clone();
        often.loop_params.period = FINE_PERIOD;
        let fine = Bench::new(&often)?.run(MethodName::Basic)?;
        let diverged = if coarse.diverged == Some(true) {
            " (which diverged)"
        } else {
            ""
        };
        let leak = |run: &Run| run.last().ledger.held_leak.absolute;
        let mean = |run: &Run| leak(run) / run.held.len() as f64;
        for (what, ratio) in [
            ("mean of an interval", mean(&coarse) / mean(&fine)),
            ("sum over the run", leak(&coarse) / leak(&fine)),
        ] {
            let what =
                format!("experiment {number}, absolute leak, {what}: 50 Hz{diverged} over 1 kHz");
            let fits = (FROM_TO.0..=FROM_TO.1).contains(&ratio);
            found.push(Found::of(what, ratio, "").decides(fits));
        }
    }
    Ok(claim(
        "leak at 1 kHz",
        "at 1 kHz the basic model's leaks are about 400 times smaller than at 50 Hz",
        format!("a ratio from {} to {}", FROM_TO.0, FROM_TO.1),
        found,
    ))
}
