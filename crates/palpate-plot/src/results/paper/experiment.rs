//! Figs. 4 and 5: the paper's experiments on a virtual pantograph.

use std::fmt::Write;

use crate::figure::Sheet;
use comfy_table::CellAlignment;
use palpate_scene::method::MethodName;
use palpate_scene::{Measure, Scene};
use palpate_study::report::{Report, Subject};
use palpate_study::sim::closed_loop::{Bench, LoopError, error_against};
use palpate_study::sim::run::Run;
use palpate_study::text::{lines, number, percent, plain_table};

use crate::results::method_by_method;

/// FRE in percent measured on the paper's device, or that the method failed.
pub type Measured = [(MethodName, &'static str); 3];
/// Values of the first experiment. Its HFCR has no leak dissipation.
pub const MEASURED_1: Measured = [
    (MethodName::HfcrModSt, "17.1"),
    (MethodName::PopcRef, "51.1"),
    (MethodName::VirtualDamper, "84.9"),
];
/// Values of the second experiment.
pub const MEASURED_2: Measured = [
    (MethodName::Hfcr, "52.2"),
    (MethodName::PopcRef, "failed"),
    (MethodName::VirtualDamper, "failed"),
];

/// Period of the paper's reference loop `[s]`.
const FINE_PERIOD: f64 = 0.001;

/// The report of an experiment, its figure, and the table with the paper's measurements.
pub type Compared = (Report, Sheet, String);

/// Runs the paper's five methods and coupled rendering on one of its experiments. Evaluates them against the ideal
/// and, as in the paper, against the basic model at 1 kHz.
///
/// # Errors
/// The scene cannot be simulated.
pub fn experiment(scene: &Scene, measured: &Measured) -> Result<Compared, LoopError> {
    const METHODS: [(MethodName, &str); 6] = [
        (MethodName::Basic, "basic model"),
        (MethodName::Seh, "SEH"),
        (MethodName::VirtualDamper, "virtual damper"),
        (MethodName::PopcRef, "POPC-REF"),
        (MethodName::Hfcr, "HFCR"),
        (MethodName::Coupled, "coupled (ours)"),
    ];
    let bench = Bench::new(scene)?;
    let runs = bench.run_all(&METHODS.map(|(method, _)| method))?;
    let mut fine = scene.clone();
    fine.loop_params.period = FINE_PERIOD;
    let window = bench.reference().profile.intervals() as f64 * scene.loop_params.period;
    fine.measure = Measure::Duration(window);
    let fine_runs = Bench::new(&fine)?.run_all(&[MethodName::Basic])?;
    let columns: Vec<_> = METHODS
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    // The paper's reference loop deviates from the ideal; its name shows by how much.
    let off = fine_runs[0]
        .force
        .fidelity
        .map_or_else(String::new, |fidelity| {
            format!(
                ", itself {:.0} % off the ideal",
                fidelity.force_rendering_error
            )
        });
    let fine_name = format!("basic at 1 kHz{off}");
    let fine = (&*fine_name, &fine_runs[0]);
    let figure = method_by_method(scene, bench.reference(), &columns, fine);
    let report = Report::new(&Subject::new(scene), bench.reference(), &runs);
    let mut compared = runs;
    // The figure shows HFCR with leak dissipation only.
    if measured
        .iter()
        .any(|(method, _)| *method == MethodName::HfcrModSt)
    {
        compared.push(bench.run(MethodName::HfcrModSt)?);
    }
    let comparison = beside_the_paper(&compared, &fine_runs[0], measured);
    Ok((report, figure, comparison))
}

/// Returns the table of FRE against the ideal and against the basic model at 1 kHz, with the paper's measurements.
fn beside_the_paper(runs: &[Run], fine: &Run, measured: &Measured) -> String {
    let header = [
        "method",
        "FRE % to ideal",
        "to basic at 1 kHz",
        "paper, on its device",
    ];
    let mut table = plain_table(CellAlignment::Left, &header);
    for run in runs {
        let fidelity = run.force.fidelity;
        let found = measured.iter().find(|(method, _)| run.method == *method);
        table.add_row([
            run.method.name().into(),
            number(fidelity.map(|f| f.force_rendering_error), percent),
            number(error_against(run, fine), percent),
            comfy_table::Cell::new(found.map_or("-", |(_, value)| value))
                .set_alignment(CellAlignment::Right),
        ]);
    }
    let mut text = String::new();
    let to_ideal = fine.force.fidelity.map(|f| f.force_rendering_error);
    let _ = write!(
        text,
        "\nComparison with the paper (another device, user and tuning)\n\n{}\n\nThe basic model at 1 kHz is itself {} \
         % off the ideal{}.\n",
        lines(&table),
        to_ideal.map_or_else(|| "-".into(), percent),
        fine.jammed_at
            .map_or_else(String::new, |time| format!(", and jams at {time:.2} s")),
    );
    text
}
