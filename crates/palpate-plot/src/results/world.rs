//! Methods in a world over time.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_study::sim::world::{WorldBench, WorldRun};
use palpate_study::world::forces::Periods;

/// Share of the largest mean force of the ideal on a device below which an axis is not drawn.
const MIN_SHARE: f64 = 0.01;

/// Returns the mean force of each period on each device and axis with a force of the ideal, how far the device is from
/// the ideal's along it, and the contacts of the ideal.
#[must_use]
pub fn world(scene: &WorldScene, bench: &WorldBench, runs: &[WorldRun]) -> Figure {
    let periods = Periods::new(scene, bench);
    let x: Vec<f64> = bench.samples().iter().map(|sample| sample.time).collect();
    let samples = x.len();
    let series = |name: &str, role, y: Vec<f64>| Series {
        name: name.into(),
        kind: Kind::Step,
        role,
        x: x.clone(),
        y,
    };
    let over_time = |of: &dyn Fn(usize) -> Option<f64>| -> Vec<f64> {
        (0..samples)
            .map(|sample| of(sample).unwrap_or(f64::NAN))
            .collect()
    };
    let row = |y_label: String, limits, series| Row {
        y_label,
        limits,
        panels: vec![Panel { series }],
        ..Row::default()
    };
    let mut rows = Vec::new();
    let is_one = scene.world.tools.len() == 1;
    for (device, tool) in scene.world.tools.iter().enumerate() {
        let ideal: Vec<Option<[f64; 3]>> = (0..samples)
            .map(|sample| periods.ideal_force(sample, device))
            .collect();
        let peak = |axis: usize| {
            let forces = ideal.iter().flatten().map(|force| force[axis].abs());
            forces.fold(0.0, f64::max)
        };
        let peaks = [0, 1, 2].map(peak);
        let largest = peaks.into_iter().fold(0.0, f64::max);
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            if peaks[axis] <= MIN_SHARE * largest {
                continue;
            }
            let of = if is_one {
                name.to_owned()
            } else {
                format!("{} {name}", tool.name)
            };
            let ideal = over_time(&|sample| Some(ideal[sample]?[axis]));
            let mut forces = vec![series("ideal", Role::Reference, ideal)];
            let mut away = Vec::new();
            for (number, run) in runs.iter().enumerate() {
                let role =
                    MethodName::named(&run.method).map_or(Role::Compared(10 + number), super::role);
                let held = over_time(&|sample| Some(periods.force(run, sample, device)?[axis]));
                forces.push(series(&run.method, role, held));
                let from_ideal = over_time(&|sample| {
                    let ideal = periods.ideal_position(sample, device)?;
                    Some(1e3 * (run.positions[sample][device][axis] - ideal[axis]))
                });
                away.push(series(&run.method, role, from_ideal));
            }
            rows.push(row(format!("force {of} [N]"), Limits::default(), forces));
            rows.push(row(format!("off ideal {of} [mm]"), Limits::Data, away));
        }
    }
    let contacts = over_time(&|sample| Some(periods.ideal_contacts(sample)? as f64));
    let contacts = vec![series("ideal", Role::Reference, contacts)];
    rows.push(row("contacts".into(), Limits::Data, contacts));
    let depth = over_time(&|sample| Some(1e3 * periods.ideal_penetration(sample)?));
    let depth = vec![series("ideal", Role::Reference, depth)];
    rows.push(row("penetration [mm]".into(), Limits::Data, depth));
    Figure {
        title: scene.title.clone(),
        subtitle: String::new(),
        footnote: Some(
            "Force: mean over each period, of the actuator and of the ideal. Off ideal: position of the device less \
             that of the ideal's. Contacts and their deepest penetration: those of the ideal."
                .into(),
        ),
        x_label: "time [s]".into(),
        x_decades: false,
        columns: Vec::new(),
        rows,
    }
}
