//! The figure of the docs: the knob's wall beside the plain spring force, and what makes it let go.

use std::error::Error;

use palpate_figure::{Figure, Kind, Limits, Panel, Role, Row, Series, Size, svg};

use crate::qemu::M4F;
use crate::ran::{Entry, Ran, Scene, ran};

fn series(ran: &Ran, name: &str, role: Role, value: impl Fn(&Entry) -> f64) -> Series {
    Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: ran.entries.iter().map(|entry| entry.time).collect(),
        y: ran.entries.iter().map(value).collect(),
    }
}

fn row(label: &str, panels: Vec<Vec<Series>>) -> Row {
    Row {
        y_label: label.into(),
        limits: Limits::Data,
        panels: panels.into_iter().map(|series| Panel { series }).collect(),
        ..Row::default()
    }
}

/// The figure as SVG, from runs on the Cortex-M4F.
///
/// # Errors
/// A run fails.
pub fn figure() -> Result<String, Box<dyn Error>> {
    let (coupled, basic) = (ran(M4F, Scene::Wall)?, ran(M4F, Scene::WallByBasic)?);
    let (stall, glitch) = (ran(M4F, Scene::Stall)?, ran(M4F, Scene::Glitch)?);
    let runs = [
        (&basic, "plain spring", 0),
        (&coupled, "coupled", 1),
        (&stall, "coupled, loop stalls", 1),
        (&glitch, "coupled, sensor jumps", 1),
    ];
    let each = |value: &dyn Fn(&Entry) -> f64| {
        runs.iter()
            .map(|(ran, _, role)| vec![series(ran, "", Role::Compared(*role), value)])
            .collect()
    };
    let figure = Figure {
        title: "A knob's wall at 4 kHz on a Cortex-M4F, and its force when something goes wrong"
            .into(),
        subtitle: "A rim of 50 g, a wall of 5000 N/m, f32; run by QEMU, motor and hand emulated"
            .into(),
        x_label: "time [s]".into(),
        columns: runs
            .iter()
            .map(|(_, name, _)| (*name).to_string())
            .collect(),
        rows: vec![
            row("rim [mm]", each(&|entry| 1e3 * entry.position)),
            row("motor force [N]", each(&|entry| entry.motor)),
            row("motor work [mJ]", each(&|entry| 1e3 * entry.motor_work)),
        ],
        ..Figure::default()
    };
    Ok(svg(&figure, Size::NATURAL)?)
}
