//! Rows of a world in a comparison.

use palpate_scene::world::WorldScene;

use super::{Figures, MethodRow, Outcome, SceneRows};
use crate::sim::world::{WorldBench, WorldBenchError, WorldRun};
use crate::text::{digits, percent};
use crate::tune::Objective;
use crate::world::candidates::Tunable;
use crate::world::tune::{WorldPointReport, best, none_found, search};
use crate::world::{SettingReport, WorldMethodReport, WorldReport};

impl SceneRows {
    /// Runs the methods of these names on a world. A tunable method without settings in the scene uses the best of
    /// [`Tunable::candidates`]. Calls `begun` with the name of each method before it runs.
    ///
    /// # Errors
    /// The scene has no ideal.
    pub fn of_world(
        name: &str,
        scene: &WorldScene,
        methods: &[&'static str],
        mut begun: impl FnMut(&'static str),
    ) -> Result<Self, WorldBenchError> {
        let bench = WorldBench::new(scene)?;
        let mut rows = Vec::new();
        let mut hold_bound_percent = None;
        for &method in methods {
            begun(method);
            let (result, remarks) = match row(scene, &bench, method) {
                Ok((outcome, floor, remarks)) => {
                    hold_bound_percent = floor.or(hold_bound_percent);
                    (outcome, remarks)
                }
                Err(WorldBenchError::Rendering(faults)) => {
                    let faults = faults.iter().map(|fault| fault.message.as_str());
                    let cannot = faults.collect::<Vec<_>>().join("; ");
                    (Outcome::Cannot { cannot }, String::new())
                }
                Err(other) => return Err(other),
            };
            rows.push(MethodRow {
                method,
                result,
                remarks,
            });
        }
        let report = WorldReport::new(scene, &bench, &[]);
        let floor = hold_bound_percent.map_or_else(String::new, |floor| {
            format!(", hold bound {} %", percent(floor))
        });
        let peaks = bench.ideal().devices.iter().flat_map(|it| it.peaks.iter());
        let peak = peaks.copied().fold(0.0, f64::max);
        Ok(Self {
            scene: name.to_owned(),
            conditions: format!(
                "period {} s, window {} s{floor}",
                digits(report.period_s),
                digits(report.window_s)
            ),
            title: report.title,
            is_world: true,
            period_s: report.period_s,
            window_s: report.window_s,
            kappa: None,
            hold_bound_percent,
            ideal_peak_force_n: (peak > 0.0).then_some(peak),
            ideal_error: None,
            ideal_error_percent: report.ideal_error_percent,
            methods: rows,
            least_explicit_mass_kg: None,
            seeded: None,
        })
    }
}

impl Figures {
    fn of_world(report: &WorldMethodReport, tuned: Option<usize>, settings: SettingReport) -> Self {
        let devices = report.devices.iter();
        let peaks = devices.filter_map(|it| it.peak_over_ideal_peak);
        let error = report.sum.map(|sum| sum.mean_force_error_percent);
        let diverged = error.map(|error| !error.is_finite());
        Self {
            parameters: None,
            tuned,
            settings: Some(settings),
            mean_force_error_percent: error,
            force_rendering_error_percent: report.sum.map(|sum| sum.force_rendering_error_percent),
            error_over_bound: report.sum.and_then(|sum| sum.error_over_bound),
            peak_over_ideal: peaks.reduce(f64::max),
            absolute_leak_held_j: None,
            leak_j: Some(report.leak_j),
            diverged,
            left_box_at_s: None,
            jammed_at_s: None,
            refused_samples: report.refused_samples,
            is_whole: report.refused_samples == 0 && diverged != Some(true),
        }
    }
}

/// Result of a method, or that no setting is usable, with the zero-order-hold bound `[%]` and remarks.
fn row(
    scene: &WorldScene,
    bench: &WorldBench,
    method: &'static str,
) -> Result<(Outcome, Option<f64>, String), WorldBenchError> {
    let figures = |run: &WorldRun, tuned: Option<usize>, settings: SettingReport| {
        let report = WorldReport::new(scene, bench, std::slice::from_ref(run));
        let floor = run.evaluation.sum.as_ref().map(|sum| sum.hold_bound);
        let best = tuned.map_or_else(String::new, |count| format!("best of {count}: "));
        let remarks = best + &settings.in_short();
        let figures = Figures::of_world(&report.methods[0], tuned, settings);
        (Outcome::Ran(Box::new(figures)), floor, remarks)
    };
    if let (Some(tunable), Err(_)) = (Tunable::named(method), scene.method(method)) {
        let tuned = search(scene, bench, tunable, || ())?;
        let best = best(&tuned, Objective::Error).expect("some setting was tried");
        if !best.is_usable() {
            let none_found = none_found(tuned.len(), &WorldPointReport::new(best));
            return Ok((Outcome::NoneFound { none_found }, None, String::new()));
        }
        return Ok(figures(
            &best.run,
            Some(tuned.len()),
            (&best.settings).into(),
        ));
    }
    let renderer = scene.renderer(method)?;
    let run = bench.run(method, &renderer)?;
    let settings = match Tunable::named(method) {
        Some(tunable) => tunable.of_settings(&scene.settings(method)),
        None => Default::default(),
    };
    Ok(figures(&run, None, (&settings).into()))
}
