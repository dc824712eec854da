//! Imperfections of a loop, under the names of scene files.

use palpate_core::Hold;
use palpate_scene::{Delay, Dropped, Jitter, Timing};
use serde_json::{Map, Value, json};

use super::Subject;

/// Returns every imperfection, by key; empty for a loop whose only imperfection is a delay of whole samples.
#[must_use]
pub fn of(delay: Delay, timing: &Timing) -> Map<String, Value> {
    let mut named = Map::new();
    if timing.is_perfect() && delay.is_whole() {
        return named;
    }
    let mut put = |key: &str, value: Value| named.insert(key.to_owned(), value);
    if delay.fraction() > 0.0 {
        put("delay_fraction", json!(delay.fraction()));
    }
    if delay.seconds() > 0.0 {
        put("delay_s", json!(delay.seconds()));
    }
    if timing.command_jitter > 0.0 {
        put("command_jitter_s", json!(timing.command_jitter));
    }
    match timing.jitter {
        Jitter::None => {}
        Jitter::Uniform { bound } => {
            put("jitter_s", json!(bound));
        }
        Jitter::Normal { deviation, bound } => {
            put("jitter_s", json!(bound));
            put("jitter_deviation_s", json!(deviation));
        }
    }
    match &timing.dropped {
        Dropped::None => {}
        Dropped::Probability(probability) => {
            put("drop_probability", json!(probability));
        }
        Dropped::Listed(samples) => {
            put("dropped_samples", json!(samples));
        }
    }
    if let Some(collapse) = timing.collapse {
        put(
            "collapse",
            json!({
                "from_s": collapse.from,
                "until_s": collapse.until,
                "period_s": collapse.period,
            }),
        );
    }
    put("seed", json!(timing.seed));
    named
}

/// Describes the imperfections of a subject's loop and the noise of its sensor, without a delay in periods.
pub(super) fn of_subject(subject: &Subject) -> String {
    let is_line = subject.loop_params.actuation.hold == Hold::Line;
    let line = is_line.then(|| "each command is a line".to_owned());
    let words = in_words(subject.delay, &subject.timing, subject.sensor_noise);
    Vec::from_iter(line.into_iter().chain(words)).join(", ")
}

/// Describes the imperfections of a loop and the noise of its sensors `[m]`, without a delay in periods.
pub(crate) fn in_words(delay: Delay, timing: &Timing, sensor_noise: f64) -> Vec<String> {
    let mut words = Vec::new();
    let milliseconds = |seconds: f64| crate::text::digits(1e3 * seconds);
    if delay.seconds() > 0.0 {
        let after = milliseconds(delay.seconds());
        words.push(format!("commands after {after} ms"));
    }
    if timing.command_jitter > 0.0 {
        words.push(format!(
            "commands up to {} ms later",
            milliseconds(timing.command_jitter)
        ));
    }
    match timing.jitter {
        Jitter::None => {}
        Jitter::Uniform { bound } | Jitter::Normal { bound, .. } => {
            words.push(format!("jitter up to {} ms", milliseconds(bound)));
        }
    }
    match &timing.dropped {
        Dropped::None => {}
        Dropped::Probability(probability) => {
            words.push(format!("{} % of samples dropped", 100.0 * probability));
        }
        Dropped::Listed(samples) => {
            words.push(format!(
                "{} dropped",
                crate::text::counted(samples.len(), "sample")
            ));
        }
    }
    if let Some(collapse) = timing.collapse {
        words.push(format!(
            "period {} ms from {} s to {} s",
            milliseconds(collapse.period),
            collapse.from,
            collapse.until
        ));
    }
    if sensor_noise > 0.0 {
        let noise = crate::text::digits(1e6 * sensor_noise);
        words.push(format!("sensor noise {noise} um"));
    }
    words
}
