//! A report over several seeds of the random numbers of a scene.

use serde::Serialize;

use super::{MethodReport, Report};
use crate::seeded::{SeedScore, Seeded};
use crate::spread::Spread;

/// Values of a method over the seeds of the random numbers.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OverSeeds {
    /// Mean-force error E `[%]`; none if a seed has no contact.
    pub mean_force_error_percent: Option<Spread>,
    /// FRE `[%]`; none if a seed has no contact.
    pub force_rendering_error_percent: Option<Spread>,
    /// FRE over the zero-order-hold bound; `None` if the bound of a seed is 0.
    pub error_over_bound: Option<Spread>,
    /// Strongest held force `[N]`.
    pub peak_force_n: Spread,
    /// Strongest pull on the object `[N]`.
    pub strongest_pull_n: Spread,
    /// Sum of the leaks of the held force `[J]`.
    pub leak_held_j: Spread,
    /// Sum of the absolute leaks of the held force `[J]`.
    pub absolute_leak_held_j: Spread,
    /// Drift of the energy of device and object, relative to that of the ideal `[%]`; lossless scenes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_drift_percent: Option<Spread>,
    /// Number of seeds.
    pub seeds: usize,
    /// Number of seeds with which the loop diverged.
    pub diverged_seeds: usize,
    /// Seeds with which a linkage jammed or the device left its safety box.
    pub out_of_reach_seeds: usize,
    /// Number of seeds with which the renderer rejected a sample.
    pub refused_seeds: usize,
    /// Seeds with which a limit changed a force.
    pub limited_seeds: usize,
}

impl OverSeeds {
    /// The values of one method in the reports of all seeds; none without a seed.
    fn new(reports: &[&MethodReport]) -> Option<Self> {
        let all = |value: &dyn Fn(&MethodReport) -> f64| {
            Spread::new(reports.iter().map(|report| value(report)))
        };
        let some = |value: &dyn Fn(&MethodReport) -> Option<f64>| {
            let values: Option<Vec<f64>> = reports.iter().map(|report| value(report)).collect();
            Spread::new(values?)
        };
        let count = |is: &dyn Fn(&MethodReport) -> bool| {
            let counted = reports.iter().filter(|report| is(report));
            counted.count()
        };
        Some(Self {
            mean_force_error_percent: some(&|of| of.mean_force_error_percent),
            force_rendering_error_percent: some(&|of| of.force_rendering_error_percent),
            error_over_bound: some(&|of| of.error_over_bound),
            peak_force_n: all(&|of| of.peak_force_n)?,
            strongest_pull_n: all(&|of| of.strongest_pull_n)?,
            leak_held_j: all(&|of| of.leak_held_j)?,
            absolute_leak_held_j: all(&|of| of.absolute_leak_held_j)?,
            energy_drift_percent: some(&|of| of.energy_drift_percent),
            seeds: reports.len(),
            diverged_seeds: count(&|of| of.diverged == Some(true)),
            out_of_reach_seeds: count(&|of| of.jammed_at_s.or(of.left_box_at_s).is_some()),
            refused_seeds: count(&|of| of.faults > 0),
            limited_seeds: count(&|of| of.limited > 0),
        })
    }

    /// Remarks, with the number of seeds.
    pub(super) fn remarks(&self) -> String {
        let remarks = [
            ("diverged", self.diverged_seeds),
            ("left the box or jammed", self.out_of_reach_seeds),
            ("samples refused", self.refused_seeds),
            ("forces limited", self.limited_seeds),
        ];
        let remarks = remarks.into_iter().filter(|(_, seeds)| *seeds > 0);
        let remarks: Vec<String> = remarks
            .map(|(what, seeds)| format!("{what}: {seeds} of {}", self.seeds))
            .collect();
        remarks.join(", ")
    }
}

impl Report {
    /// Returns the errors of each method; `None` without contact.
    fn scores(&self) -> Vec<Option<SeedScore>> {
        let of = |method: &MethodReport| {
            Some(SeedScore {
                mean_force_error: method.mean_force_error_percent?,
                force_rendering_error: method.force_rendering_error_percent?,
                broken: method.diverged == Some(true) || method.faults > 0,
            })
        };
        self.methods.iter().map(of).collect()
    }

    /// The report of the first seed, with the spread over the reports of all `further` ones.
    ///
    /// `start_range` `[m]` is the largest change of the start of a device.
    pub fn spread_over(&mut self, further: &[Self], start_range: Option<f64>) {
        let all = || std::iter::once(&*self).chain(further);
        let floors: Option<Vec<f64>> = all().map(|report| report.hold_bound_percent).collect();
        let floors = floors.and_then(Spread::new);
        let of_methods: Vec<_> = (0..self.methods.len())
            .map(|index| {
                let reports: Vec<_> = all()
                    .filter_map(|report| report.methods.get(index))
                    .collect();
                OverSeeds::new(&reports)
            })
            .collect();
        let names: Vec<&str> = self.methods.iter().map(|of| of.method).collect();
        let scores: Vec<Vec<_>> = all().map(Self::scores).collect();
        let first = self.seed.unwrap_or_default();
        let seeded = Seeded::new(first, start_range, &names, &scores);
        self.hold_bound_over_seeds = floors;
        for (method, over_seeds) in self.methods.iter_mut().zip(of_methods) {
            method.over_seeds = over_seeds;
        }
        self.seeded = Some(Box::new(seeded));
        self.seeds = Some(1 + further.len());
    }
}
