//! Cogging: a motor force that is periodic in position, of unknown pitch.

use std::f64::consts::TAU;

use crate::calibrate::filter::{self, Samples, Steady};
use crate::calibrate::model::{Kind, LENGTH, Sampled};

/// Range of the searched pitches `[m]`.
const PITCHES: [f64; 2] = [1e-3, 12e-3];
/// Ratio from one pitch to the next.
const RATIO: f64 = 1.04;
/// Gain in log-likelihood that cogging requires.
const PRICE: f64 = 20.0;

/// Returns cosine and sine of the cogging phase for a pitch `[m]`, at the middle of each period.
pub fn phases(samples: &Samples, pitch: f64) -> Vec<[f64; 2]> {
    let x = &samples.positions;
    (0..x.len())
        .map(|i| 0.5 * (x[i] + x[(i + 1).min(x.len() - 1)]))
        .map(|x| {
            let (sin, cos) = (TAU * x * LENGTH / pitch).sin_cos();
            [cos, sin]
        })
        .collect()
}

/// Returns the pitch `[m]` that explains most of the innovations of `model` without cogging. Returns `None` if the gain
/// in likelihood does not justify the additional parameters.
pub fn pitch(
    kind: Kind,
    model: &Sampled,
    steady: &Steady,
    samples: &Samples,
    counted: &std::ops::Range<usize>,
) -> Option<f64> {
    let without = Sampled {
        cogging: [0.0; 2],
        ..model.clone()
    };
    let innovations = filter::innovations(kind, &without, steady, samples);
    let left = &innovations[counted.clone()];
    let whole: f64 = left.iter().map(|e| e * e).sum();
    // Response of the innovations to a force of this shape, from rest.
    let response = |shape: Vec<f64>| {
        let alone = Sampled {
            friction: -1.0,
            ..without.clone()
        };
        let pushed = Samples {
            positions: vec![0.0; shape.len()],
            commands: vec![0.0; shape.len()],
            phases: vec![[0.0; 2]; shape.len()],
            signs: shape,
        };
        let mut all = filter::innovations(kind, &alone, steady, &pushed);
        all.truncate(counted.end);
        all.drain(..counted.start);
        all
    };
    let explained = |pitch: f64| {
        let phases = phases(samples, pitch);
        let [c, s] = [0, 1].map(|part| response(phases.iter().map(|phase| phase[part]).collect()));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (cc, cs, ss) = (dot(&c, &c), dot(&c, &s), dot(&s, &s));
        let (ce, se) = (dot(&c, left), dot(&s, left));
        let determinant = cc * ss - cs * cs;
        if determinant <= 1e-9 * cc * ss {
            return 0.0;
        }
        (ce * ce * ss - 2.0 * ce * se * cs + se * se * cc) / determinant
    };
    let [mut pitch, longest] = PITCHES;
    let mut best = (0.0, pitch);
    while pitch <= longest {
        let here = explained(pitch);
        if here > best.0 {
            best = (here, pitch);
        }
        pitch *= RATIO;
    }
    for ratio in [1.02, 1.01, 1.005, 1.0025] {
        for near in [best.1 / ratio, best.1 * ratio] {
            let here = explained(near);
            if here > best.0 {
                best = (here, near);
            }
        }
    }
    let gain = -0.5 * left.len() as f64 * (1.0 - best.0 / whole).ln();
    (gain > PRICE).then_some(best.1)
}
