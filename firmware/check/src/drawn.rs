//! The figure of the docs: the knob's wall beside the plain spring force, and what makes it let go.

use std::error::Error;

use palpate_figure::{Grid, Kind, Limits, Panel, Role, Row, Series, Sheet, Size, svg};

use crate::qemu::M4F;
use crate::ran::{Entry, Phases, Ran, Scene, ran};

/// What is shown of each run `[s]`.
const UNTIL: f64 = 0.6;

/// What is shown of an entry.
type Value = fn(&Entry) -> f64;

fn panel(ran: &Ran, value: Value) -> Panel {
    let shown = || ran.between(0.0, UNTIL);
    Panel {
        series: vec![Series {
            name: String::new(),
            kind: Kind::Line,
            role: Role::Recorded,
            x: shown().map(|entry| entry.time).collect(),
            y: shown().map(value).collect(),
        }],
    }
}

fn grid(runs: [(&Ran, String); 2], rows: [(&str, Value); 2]) -> Grid {
    Grid {
        rows: rows
            .into_iter()
            .map(|(label, value)| Row {
                y_label: label.into(),
                limits: Limits::Data,
                panels: runs.iter().map(|(ran, _)| panel(ran, value)).collect(),
                ..Row::default()
            })
            .collect(),
        columns: runs.map(|(_, name)| name).into(),
        ..Grid::default()
    }
}

/// Most work of the motor on the free rim: energy that rendering has created `[mJ]`.
fn created(ran: &Ran) -> f64 {
    let free = ran.between(0.0, UNTIL).filter(|entry| entry.position < 0.0);
    free.map(|entry| 1e3 * entry.motor_work).fold(0.0, f64::max)
}

/// The figure as SVG, from runs on the Cortex-M4F.
///
/// # Errors
/// A run fails.
pub fn figure() -> Result<String, Box<dyn Error>> {
    let in_phase = |scene| ran(M4F, scene, Phases::default());
    let (coupled, basic) = (in_phase(Scene::Wall)?, in_phase(Scene::WallByBasic)?);
    let (stall, glitch) = (in_phase(Scene::Stall)?, in_phase(Scene::Glitch)?);
    let at = |ran: &Ran| ran.event.ok_or("nothing has happened in a run");
    let force: (&str, Value) = ("motor force [N]", |entry| entry.motor);
    let sheet = Sheet {
        title: format!(
            "A wall at 4 kHz on a Cortex-M4F: the plain spring creates {:.0} mJ in {UNTIL} s, coupled rendering {:.2} mJ",
            created(&basic),
            created(&coupled)
        ),
        subtitle: "A rim of 50 g and a wall of 5000 N/m at 0, in f32, run by QEMU with emulated motor and \
                   hand. Above a constant force, below a hand that goes in and out"
            .into(),
        x_label: "time [s]".into(),
        lines: vec![
            vec![grid(
                [(&basic, "plain spring".into()), (&coupled, "coupled".into())],
                [force, ("motor work [mJ]", |entry| 1e3 * entry.motor_work)],
            )],
            vec![grid(
                [
                    (&stall, format!("coupled; the loop stalls at {:.3} s", at(&stall)?)),
                    (&glitch, format!("coupled; the sensor jumps at {:.3} s", at(&glitch)?)),
                ],
                [force, ("rim [mm]", |entry| 1e3 * entry.position)],
            )],
        ],
        ..Sheet::default()
    };
    Ok(svg(&sheet, Size::NATURAL)?)
}
