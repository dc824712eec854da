//! Figs. 4 and 5: the paper's experiments on a virtual pantograph.

use std::fmt::Write;

use comfy_table::CellAlignment;
use palpate_scene::method::MethodName;
use palpate_scene::{Measure, SceneFile};
use palpate_sim::closed_loop::error_against;
use palpate_sim::run::Run;

use super::super::simulate::simulate;
use crate::failure::Failure;
use crate::plots;
use palpate_figure::Sheet;
use palpate_study::report::{Report, Subject};
use palpate_study::text::{lines, number, percent, plain_table};

const FIG4: &str = include_str!("../../../experiments/fig4.toml");
const FIG5: &str = include_str!("../../../experiments/fig5.toml");
const FIG5_BOX: &str = include_str!("../../../experiments/fig5_box.toml");

/// What the paper measured on its device: FRE in percent, or that the method failed.
type Measured = [(MethodName, &'static str); 3];
const MEASURED_1: Measured = [
    (MethodName::Hfcr, "17.1"),
    (MethodName::PopcRef, "51.1"),
    (MethodName::VirtualDamper, "84.9"),
];
const MEASURED_2: Measured = [
    (MethodName::Hfcr, "52.2"),
    (MethodName::PopcRef, "failed"),
    (MethodName::VirtualDamper, "failed"),
];

/// Period of the loop that the paper takes for the truth `[s]`.
const FINE_PERIOD: f64 = 0.001;

/// Fig. 4.
pub fn fig4() -> Result<Compared, Failure> {
    experiment(FIG4, &MEASURED_1)
}

/// Fig. 5.
pub fn fig5() -> Result<Compared, Failure> {
    experiment(FIG5, &MEASURED_2)
}

/// Fig. 5 in the safety box that the paper's text fits best.
pub fn fig5_box() -> Result<Compared, Failure> {
    experiment(FIG5_BOX, &MEASURED_2)
}

/// The report of an experiment, its figure, and the table beside what the paper measured.
pub type Compared = (Report, Sheet, String);

/// The paper's five methods and coupled rendering on one of its experiments, against the ideal and, as
/// the paper does, against the basic model at 1 kHz.
fn experiment(scene: &str, measured: &Measured) -> Result<Compared, Failure> {
    const METHODS: [(MethodName, &str); 6] = [
        (MethodName::Basic, "basic model"),
        (MethodName::Seh, "SEH"),
        (MethodName::VirtualDamper, "virtual damper"),
        (MethodName::PopcRef, "POPC-REF"),
        (MethodName::Hfcr, "HFCR"),
        (MethodName::Coupled, "coupled (ours)"),
    ];
    let file = SceneFile::parse("experiment", scene).map_err(Failure::input)?;
    let (bench, runs) = simulate(&file.scene, &METHODS.map(|(method, _)| method))?;
    let mut fine = file.scene.clone();
    fine.loop_params.period = FINE_PERIOD;
    let window = bench.reference().profile.intervals() as f64 * file.scene.loop_params.period;
    fine.measure = Measure::Duration(window);
    let (_, fine_runs) = simulate(&fine, &[MethodName::Basic])?;
    let columns: Vec<_> = METHODS
        .iter()
        .zip(&runs)
        .map(|((_, name), run)| (*name, run))
        .collect();
    // The paper takes this loop for the truth: how far it is off the ideal belongs beside its name.
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
    let figure = plots::method_by_method(&file.scene, bench.reference(), &columns, fine);
    let report = Report::new(&Subject::of(&file.scene), bench.reference(), &runs);
    let comparison = beside_the_paper(&runs, &fine_runs[0], measured);
    Ok((report, figure, comparison))
}

/// FRE against the ideal and against the basic model at 1 kHz, beside what the paper measured.
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
        "\nBeside the paper (its device, user and tuning were others)\n\n{}\n\nThe basic model at 1 kHz \
         is itself {} % off the ideal{}.\n",
        lines(&table),
        to_ideal.map_or_else(|| "-".into(), percent),
        fine.jammed_at
            .map_or_else(String::new, |time| format!(", and jams at {time:.2} s")),
    );
    text
}
