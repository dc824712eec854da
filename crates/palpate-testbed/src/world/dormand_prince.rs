//! One step of the Runge-Kutta pair of orders 5 and 4 by Dormand and Prince, *A family of embedded
//! Runge-Kutta formulae* (1980), with the continuous solution of order 4 by Hairer, Nørsett and Wanner,
//! *Solving Ordinary Differential Equations I*, section II.6.

const STAGES: usize = 7;

const NODES: [f64; STAGES] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// Row s gives stage s + 1; the last one is the solution of order 5.
const WEIGHTS: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19_372.0 / 6561.0,
        -25_360.0 / 2187.0,
        64_448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46_732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18_656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Solution of order 5 less that of order 4.
const ERROR: [f64; STAGES] = [
    71.0 / 57_600.0,
    0.0,
    -71.0 / 16_695.0,
    71.0 / 1920.0,
    -17_253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

const CONTINUOUS: [f64; STAGES] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// A step from a state, with all of its stages.
#[derive(Debug, Clone)]
pub(super) struct Step {
    stages: [Vec<f64>; STAGES],
    start: Vec<f64>,
    end: Vec<f64>,
    length: f64,
}

impl Step {
    /// Creates a step with memory for states of `size` numbers.
    pub fn of_size(size: usize) -> Self {
        Self {
            stages: std::array::from_fn(|_| vec![0.0; size]),
            start: vec![0.0; size],
            end: vec![0.0; size],
            length: 0.0,
        }
    }

    /// Takes a step of a given length from `start` at `time`; `rates(time, state, rates)` is the right-hand side. With
    /// `first_is_known`, the first stage is already available, see [`hand_on`](Self::hand_on).
    pub fn take(
        &mut self,
        time: f64,
        start: &[f64],
        length: f64,
        first_is_known: bool,
        mut rates: impl FnMut(f64, &[f64], &mut [f64]),
    ) {
        self.start.copy_from_slice(start);
        self.length = length;
        if !first_is_known {
            rates(time, &self.start, &mut self.stages[0]);
        }
        for stage in 1..STAGES {
            let weights = &WEIGHTS[stage - 1];
            for i in 0..self.start.len() {
                let mut sum = 0.0;
                for (weight, before) in weights[..stage].iter().zip(&self.stages) {
                    sum += weight * before[i];
                }
                self.end[i] = self.start[i] + length * sum;
            }
            rates(
                time + NODES[stage] * length,
                &self.end,
                &mut self.stages[stage],
            );
        }
    }

    /// Makes the last stage, at the end of this step, the first of the next one.
    pub fn hand_on(&mut self) {
        self.stages.swap(0, STAGES - 1);
    }

    /// The state at the end.
    pub fn end(&self) -> &[f64] {
        &self.end
    }

    /// Estimate of the step's error in one number of the state.
    pub fn error(&self, i: usize) -> f64 {
        let sum: f64 = ERROR
            .iter()
            .zip(&self.stages)
            .map(|(weight, stage)| weight * stage[i])
            .sum();
        self.length * sum
    }

    /// Writes the first numbers of the state at a fraction of the step to `state`, to order 4.
    pub fn at(&self, fraction: f64, state: &mut [f64]) {
        let rest = 1.0 - fraction;
        for (i, value) in state.iter_mut().enumerate() {
            let change = self.end[i] - self.start[i];
            let bend = self.length * self.stages[0][i] - change;
            let twist = change - self.length * self.stages[STAGES - 1][i] - bend;
            let sum: f64 = CONTINUOUS
                .iter()
                .zip(&self.stages)
                .map(|(weight, stage)| weight * stage[i])
                .sum();
            *value = self.start[i]
                + fraction
                    * (change + rest * (bend + fraction * (twist + rest * self.length * sum)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x″ = −x with a force of time: all stages and nodes matter.
    fn rates(time: f64, state: &[f64], rates: &mut [f64]) {
        rates[0] = state[1];
        rates[1] = -state[0] + (2.0 * time).sin();
    }

    /// Of x(0) = 1, x′(0) = 0: x = cos t + (2/3) sin t − sin(2 t)/3.
    fn exact(time: f64) -> f64 {
        time.cos() + 2.0 / 3.0 * time.sin() - (2.0 * time).sin() / 3.0
    }

    fn step(length: f64) -> Step {
        let mut step = Step::of_size(2);
        step.take(0.0, &[1.0, 0.0], length, false, rates);
        step
    }

    fn order(errors: [f64; 2]) -> f64 {
        (errors[0] / errors[1]).abs().log2()
    }

    #[test]
    fn a_step_is_of_order_5_and_its_inside_of_order_4() {
        let ends = [0.1, 0.05].map(|h| step(h).end()[0] - exact(h));
        assert!((order(ends) - 6.0).abs() < 0.3, "{ends:?}");
        let inside = [0.2, 0.1].map(|h| {
            let mut state = [0.0; 2];
            step(h).at(0.4, &mut state);
            state[0] - exact(0.4 * h)
        });
        assert!((order(inside) - 5.0).abs() < 0.4, "{inside:?}");
        let estimates = [0.2, 0.1].map(|h| step(h).error(0));
        assert!((order(estimates) - 5.0).abs() < 0.6, "{estimates:?}");
    }

    #[test]
    fn a_step_that_goes_on_is_the_same_as_one_that_begins_anew() {
        let mut on = step(0.1);
        let middle = on.end().to_vec();
        let mut anew = Step::of_size(2);
        anew.take(0.1, &middle, 0.1, false, rates);
        on.hand_on();
        on.take(0.1, &middle, 0.1, true, rates);
        assert_eq!(on.end(), anew.end());
    }
}
