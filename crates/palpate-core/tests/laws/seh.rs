//! Sample-estimate-hold: mean of the coming interval, extrapolated from spring forces.

use crate::common::Random;
use palpate_core::{
    Contact, LoopParams, ObjectState, Renderer, Sample, Seh, SehEstimate, SehMemory, SehParams,
    State,
};

const STIFFNESS: f64 = 1000.0;
const PERIOD: f64 = 0.01;

type OnWall = (Renderer<f64, Seh>, State<f64, SehMemory<f64>>);

fn on_wall(estimate: SehEstimate) -> OnWall {
    let contact = Contact::wall(STIFFNESS);
    let params = SehParams { estimate };
    let renderer = Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap();
    let state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    (renderer, state)
}

#[test]
fn even_samples_enter_with_the_coefficients_of_the_family_and_missing_ones_are_zero() {
    let family = [
        (SehEstimate::Ab2, [1.5, -0.5, 0.0]),
        (SehEstimate::Differences, [2.0, -1.5, 0.5]),
        (SehEstimate::Ab3, [23.0 / 12.0, -16.0 / 12.0, 5.0 / 12.0]),
    ];
    for (estimate, coefficients) in family {
        let (renderer, mut state) = on_wall(estimate);
        let mut random = Random(5);
        let mut past = [0.0; 3];
        let mut free = 0;
        for tick in 0..2000 {
            let position = random.between(-0.01, 0.03);
            past = [STIFFNESS * position.max(0.0), past[0], past[1]];
            free += usize::from(position <= 0.0);
            let expected = if position > 0.0 {
                coefficients.iter().zip(&past).map(|(c, f)| c * f).sum()
            } else {
                0.0
            };
            let force = renderer
                .step(&mut state, Sample::at(position))
                .force_on_object;
            assert!(
                (force - expected).abs() <= 1e-12 * STIFFNESS * 0.03,
                "{estimate:?}, tick {tick}: {force} N, not {expected} N"
            );
        }
        assert!(free > 100);
    }
}

/// Samples a force history at uneven instants and returns the largest difference `[N]` between
/// the held force and the history's true mean over the coming period.
fn worst_error(estimate: SehEstimate, history: [f64; 3]) -> f64 {
    let (renderer, mut state) = on_wall(estimate);
    let mut random = Random(6);
    let [c0, c1, c2] = history;
    let (mut t, mut elapsed, mut worst) = (0.0, PERIOD, 0.0_f64);
    for tick in 0..300 {
        let force = c0 + t * (c1 + t * c2);
        assert!(force > 0.0);
        let sample = Sample::at(force / STIFFNESS).after(elapsed);
        let held = renderer.step(&mut state, sample).force_on_object;
        let h = PERIOD;
        let mean = c0 + c1 * (t + h / 2.0) + c2 * (t * t + t * h + h * h / 3.0);
        // Two past samples are needed.
        if tick >= 2 {
            worst = worst.max((held - mean).abs());
        }
        elapsed = PERIOD * random.between(0.3, 1.7);
        t += elapsed;
    }
    worst
}

#[test]
fn two_step_integrates_a_linear_force_exactly_at_uneven_samples() {
    assert!(worst_error(SehEstimate::Ab2, [5.0, 3.0, 0.0]) < 1e-11);
    assert!(worst_error(SehEstimate::Ab2, [5.0, 3.0, 2.0]) > 1e-5);
}

#[test]
fn three_step_integrates_a_quadratic_force_exactly_at_uneven_samples() {
    assert!(worst_error(SehEstimate::Ab3, [5.0, 3.0, 2.0]) < 1e-10);
    assert!(worst_error(SehEstimate::Differences, [5.0, 3.0, 2.0]) > 1e-5);
}
