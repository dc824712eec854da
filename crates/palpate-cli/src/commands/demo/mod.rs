//! `palpate demo`: the main results without any input.

mod made;

use std::fmt::Write;
use std::path::Path;

use palpate_core::{Actuation, Contact, LoopParams, ObjectState};
use palpate_record::trace::Trace;
use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::replay::ReplaySetup;

use super::paper::figure;
use super::render::render;
use crate::arguments::DemoArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print;
use made::Made;
use palpate_plot::figure::{Picture, Size};
use palpate_plot::{Devices, RunsFigure, paper};
use palpate_study::report::{DemoReport, Report, Subject};

const SCENE_PLOT: &str = "fig2.svg";
const HAND: &str = "hand.csv";
const HAND_PLOT: &str = "hand.svg";

/// Simulates the paper's scene and renders a synthetic hand, with a figure for each.
pub fn run(arguments: &DemoArguments) -> Result<(), Failure> {
    let folder = &arguments.out_dir;
    let made = Made::plan(
        folder,
        &[SCENE_PLOT, HAND, HAND_PLOT],
        arguments.overwriting.outputs(),
    )?;

    let (mut scene_report, scene_figure) = {
        let scene = figure::scene("fig2.toml")?;
        paper::fig2(&scene, &[(MethodName::Coupled, "coupled rendering")])
            .map_err(Failure::input)?
    };
    scene_report.wrote(&made.path(SCENE_PLOT));

    let (t_s, position_m) = palpate_testbed::taps();
    let trace = Trace { t_s, position_m };
    let setup = ReplaySetup {
        contact: Contact::object(200.0, 0.5),
        loop_params: LoopParams::new(0.01),
        object: ObjectState::at_rest(0.0),
        virtual_force: -4.905,
        actuation: Actuation::default(),
        device_mass: None,
        encoder_quantum: 0.0,
    };
    let methods = [
        MethodName::Basic,
        MethodName::Seh,
        MethodName::VirtualDamper,
        MethodName::PopcRef,
        MethodName::Hfcr,
        MethodName::Coupled,
    ];
    let progress = Progress::new(methods.len());
    let (replay, runs) = render(
        setup,
        (&trace, &[]),
        &methods,
        &Settings::default(),
        &progress,
    )
    .map_err(Failure::input)?;
    drop(progress);
    let title = "A hand juggles a block of 0.5 kg, 200 N/m at 100 Hz";
    let subject = Subject::of_replay(title.into(), &setup);
    let mut hand_report = Report::new(&subject, replay.reference(), &runs);
    hand_report.after_another();
    hand_report.wrote(&made.path(HAND));
    hand_report.wrote(&made.path(HAND_PLOT));
    let hand_figure = RunsFigure {
        of: title.into(),
        reference: replay.reference(),
        runs: &runs,
        devices: Devices::Recorded,
        recorded: None,
    };
    made.write(&[
        (SCENE_PLOT, svg(&scene_figure)),
        (HAND, trace_text(&trace).into_bytes()),
        (HAND_PLOT, svg(&hand_figure.sheet())),
    ])?;

    if arguments.json {
        let report = DemoReport::new(hand_report, scene_report);
        let sorted = serde_json::to_value(&report).expect("a report has string keys only");
        return print(&format!("{sorted:#}\n"));
    }
    print(&story(folder, &scene_report, &hand_report))
}

/// Draws a figure in its natural size.
fn svg(figure: &impl Picture) -> Vec<u8> {
    let text = palpate_plot::figure::svg(figure, Size::NATURAL);
    text.expect("a figure fits its own size").into_bytes()
}

fn story(folder: &Path, scene: &Report, hand: &Report) -> String {
    let folder = folder.display();
    let leak = |method: MethodName| {
        let mut all = scene.methods.iter();
        let found = all.find(|one| one.method == method.name());
        found.map_or(f64::NAN, |one| one.absolute_leak_held_j)
    };
    let less = leak(MethodName::Basic) / leak(MethodName::Hfcr);
    let mut text = String::new();
    let _ = write!(
        text,
        "\
A haptic device samples its position and holds a force between samples. A stiff
or light object then generates energy: the leak below. HFCR, the paper's method,
shown step by step, has {less:.0} times less of it (sum of absolute values). Coupled
rendering, the default, reaches the hold bound: the smallest error of any held
force.

1. The paper's Fig. 2, in closed loop with a light device

{scene}
   Coupled rendering has a model value of the device's mass; HFCR needs none.

2. The same force laws on a hand motion that forces do not change

{hand}
Next steps
(without installation: cargo run --release -- instead of palpate)

Your own recording instead of hand.csv:
  palpate render {folder}/hand.csv --stiffness 200 --mass 0.5 \\
    --period 0.01 --force -4.905 --out run.csv --plot run.svg
A scene to copy and change:
  palpate simulate experiments/experiment2.toml --method all
Any program as the device, live:
  palpate pipe --help

The next demo replaces the files above, except for changed ones.
"
    );
    text
}

fn trace_text(trace: &Trace) -> String {
    let mut text = String::from("t_s,position_m\n");
    for (t, x) in trace.t_s.iter().zip(&trace.position_m) {
        let _ = writeln!(text, "{t:.4},{x:.6}");
    }
    text
}
