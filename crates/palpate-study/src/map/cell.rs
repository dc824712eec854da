//! A cell of the map: every method on both plants, in bounces from all start heights and in sustained contacts.

use palpate_core::AnyRenderer;

use super::PHASES;
use super::bounce::{Bounce, BounceError, Plant, default_settings};
use super::grid::MapParams;
use super::growth::{Class, classify};
use super::stay::Stay;
use super::trial::{Course, Evaluated, Outcome};
use palpate_scene::method::{MethodName, Settings};
use rayon::prelude::*;

/// Median and worst over the start heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// The ninth of 16 in ascending order: half of the heights are not worse.
    pub median: f64,
    /// The largest.
    pub worst: f64,
}

/// Results of the bounces of a method on one plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The plant.
    pub plant: Plant,
    /// The method.
    pub method: MethodName,
    /// Growth of the energy per collision; infinite if the loop diverged.
    pub growth: Summary,
    /// Mean-force error E `[%]`.
    pub error: Summary,
    /// Force rendering error over the zero-order-hold bound; infinite if the bound is 0.
    pub error_over_bound: Summary,
    /// Zero-order-hold bound, which does not depend on the method `[%]`.
    pub hold_bound: Summary,
    /// Numbers of start heights with a stable, growing and diverged loop.
    pub classes: [usize; 3],
}

/// Results of a method on one plant of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodResult {
    /// Its bounces.
    pub bounce: Entry,
    /// Its sustained contacts.
    pub stay: Stay,
}

/// All results of a cell, plant by plant in the order of [`MapParams::methods`].
#[derive(Clone, Debug, PartialEq)]
pub struct CellResult {
    /// Index of the cell.
    pub index: usize,
    /// The results of the methods.
    pub methods: Vec<MethodResult>,
    /// Number of simulated ticks.
    pub ticks: u64,
}

impl MapParams {
    /// Runs the cell of an index.
    ///
    /// # Errors
    /// The bench or a method rejects a parameter.
    pub fn run_cell(&self, index: usize) -> Result<CellResult, BounceError> {
        let bounce = self.cell(index).bounce;
        let mut result = CellResult {
            index,
            methods: Vec::with_capacity(self.entries()),
            ticks: 0,
        };
        let methods: Vec<_> = self
            .methods
            .iter()
            .map(|method| (*method, default_settings(*method)))
            .collect();
        for plant in Plant::ALL {
            let bounce = bounce.on(plant);
            let (entries, ticks) = bounce.evaluate(plant, &methods)?;
            result.ticks += ticks;
            for ((method, settings), entry) in methods.iter().zip(entries) {
                let (stay, ticks) = bounce.stay(*method, *settings)?;
                result.methods.push(MethodResult {
                    bounce: entry,
                    stay,
                });
                result.ticks += ticks;
            }
        }
        Ok(result)
    }
}

impl Bounce {
    /// Runs methods from all start heights. Each ideal is computed once for all methods.
    ///
    /// # Errors
    /// The bench or a method rejects a parameter.
    pub fn evaluate(
        &self,
        plant: Plant,
        methods: &[(MethodName, Settings)],
    ) -> Result<(Vec<Entry>, u64), BounceError> {
        let renderers: Vec<AnyRenderer<f64>> = methods
            .iter()
            .map(|(method, settings)| self.renderer(*method, *settings))
            .collect::<Result<_, _>>()?;
        let from = |phase| -> Result<Vec<Outcome>, BounceError> {
            let course = Course::new(self, phase, Evaluated::Force)?;
            let renderers = renderers.iter();
            renderers
                .map(|renderer| course.run(self, renderer))
                .collect()
        };
        let by_phase: Vec<Vec<Outcome>> = (0..PHASES)
            .into_par_iter()
            .map(from)
            .collect::<Result<_, _>>()?;
        let ticks = by_phase.iter().flatten().map(|outcome| outcome.ticks).sum();
        let entry = |(at, (method, _)): (usize, &(MethodName, Settings))| {
            let outcomes: Vec<Outcome> = by_phase.iter().map(|outcomes| outcomes[at]).collect();
            Entry::new(plant, *method, &outcomes)
        };
        let entries = methods.iter().enumerate().map(entry).collect();
        Ok((entries, ticks))
    }

    /// Returns the largest growth over the start heights; stops at the first height that diverges.
    pub(super) fn worst_growth(
        &self,
        method: MethodName,
        settings: Settings,
    ) -> Result<f64, BounceError> {
        let renderer = self.renderer(method, settings)?;
        let mut worst = 0.0;
        for phase in 0..PHASES {
            let outcome = Course::new(self, phase, Evaluated::Growth)?.run(self, &renderer)?;
            worst = outcome.growth.max(worst);
            if worst.is_infinite() {
                break;
            }
        }
        Ok(worst)
    }
}

impl Entry {
    fn new(plant: Plant, method: MethodName, outcomes: &[Outcome]) -> Self {
        let summary =
            |of: &dyn Fn(&Outcome) -> f64| Summary::new(outcomes.iter().map(of).collect());
        let mut classes = [0; 3];
        for outcome in outcomes {
            classes[classify(outcome.growth) as usize] += 1;
        }
        Self {
            plant,
            method,
            growth: summary(&|outcome| outcome.growth),
            error: summary(&|outcome| outcome.fidelity.mean_force_error),
            error_over_bound: summary(&|outcome| {
                outcome.fidelity.error_over_bound.unwrap_or(f64::INFINITY)
            }),
            hold_bound: summary(&|outcome| outcome.fidelity.hold_bound),
            classes,
        }
    }

    /// Returns the class from the worst start height.
    #[must_use]
    pub fn class(&self) -> Class {
        classify(self.growth.worst)
    }
}

impl Summary {
    fn new(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self {
            median: values[values.len() / 2],
            worst: values[values.len() - 1],
        }
    }
}
