//! Methods in a world over time.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_study::sim::world::{Touched, WorldBench, WorldRun};
use palpate_study::world::forces::Periods;

/// Share of the largest mean force of the ideal on a device, or of its deepest penetration, below which an axis is not
/// drawn.
const MIN_SHARE: f64 = 0.01;

/// Returns the mean force of each period on each device and axis with a force of the ideal, how far the device is from
/// the ideal's along it and its penetration, then the contacts, their deepest penetration and the generated energy.
#[must_use]
pub fn world(scene: &WorldScene, bench: &WorldBench, runs: &[WorldRun]) -> Figure {
    let roles = runs.iter().enumerate().map(|(number, run)| {
        MethodName::named(&run.method).map_or(Role::Compared(10 + number), super::role)
    });
    let drawn = Drawn {
        periods: Periods::new(scene, bench),
        times: bench.samples().iter().map(|sample| sample.time).collect(),
        runs,
        roles: roles.collect(),
    };
    let mut rows = Vec::new();
    let is_one = scene.world.tools.len() == 1;
    for (device, tool) in scene.world.tools.iter().enumerate() {
        let of = |axis: &str| match is_one {
            true => axis.to_owned(),
            false => format!("{} {axis}", tool.name),
        };
        rows.extend(drawn.of_device(device, of));
    }
    rows.extend(drawn.of_contacts());
    Figure {
        title: scene.title.clone(),
        subtitle: String::new(),
        footnote: Some(
            "Force: mean over each period, of the actuator and of the ideal. Off ideal: position of the device less \
             that of the ideal's. Penetration: that of the device's deepest contact, along its push. Generated energy: of \
             the held forces, since the start."
                .into(),
        ),
        x_label: "time [s]".into(),
        x_decades: false,
        columns: Vec::new(),
        rows,
    }
}

/// Runs of a world over the samples of its ideal.
struct Drawn<'a> {
    periods: Periods<'a>,
    /// Times of the samples `[s]`.
    times: Vec<f64>,
    runs: &'a [WorldRun],
    /// Role of each run.
    roles: Vec<Role>,
}

impl Drawn<'_> {
    /// Returns the rows of a device, whose axes are called by `of`.
    fn of_device(&self, device: usize, of: impl Fn(&str) -> String) -> Vec<Row> {
        let forces: Vec<Option<[f64; 3]>> = (0..self.times.len())
            .map(|sample| self.periods.ideal_force(sample, device))
            .collect();
        let peaks = largest(forces.iter().flatten());
        let samples = self.runs.iter().flat_map(|run| &run.touched);
        let depths = largest(samples.map(|touched| &touched.devices[device]));
        let is_small = |sizes: [f64; 3], axis: usize| {
            let most = sizes.into_iter().fold(0.0, f64::max);
            sizes[axis] <= MIN_SHARE * most
        };
        let mut rows = Vec::new();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            if is_small(peaks, axis) {
                continue;
            }
            let name = of(name);
            let mut series = vec![self.ideal(|sample| Some(forces[sample]?[axis]))];
            series.extend(
                self.of_runs(|run, sample| Some(self.periods.force(run, sample, device)?[axis])),
            );
            rows.push(row(format!("force {name} [N]"), Limits::default(), series));
            let away = self.of_runs(|run, sample| {
                let ideal = self.periods.ideal_position(sample, device)?;
                Some(1e3 * (run.positions[sample][device][axis] - ideal[axis]))
            });
            rows.push(row(format!("off ideal {name} [mm]"), Limits::Data, away));
            // Friction alone has no penetration along its axis.
            if !is_small(depths, axis) {
                let depths = self.touched(|touched| 1e3 * touched.devices[device][axis]);
                let label = format!("penetration {name} [mm]");
                rows.push(row(label, Limits::default(), depths));
            }
        }
        rows
    }

    /// Returns the rows of all contacts.
    fn of_contacts(&self) -> [Row; 3] {
        let mut contacts =
            vec![self.ideal(|sample| Some(self.periods.ideal_contacts(sample)? as f64))];
        contacts.extend(self.touched(|touched| touched.contacts as f64));
        let mut depth =
            vec![self.ideal(|sample| Some(1e3 * self.periods.ideal_penetration(sample)?))];
        depth.extend(self.touched(|touched| 1e3 * touched.penetration));
        let energy = self.touched(|touched| 1e3 * touched.created);
        [
            row("contacts".into(), Limits::Data, contacts),
            row("deepest penetration [mm]".into(), Limits::default(), depth),
            row("generated energy [mJ]".into(), Limits::default(), energy),
        ]
    }

    fn ideal(&self, value: impl Fn(usize) -> Option<f64>) -> Series {
        self.series("ideal", Role::Reference, value)
    }

    fn of_runs(&self, value: impl Fn(&WorldRun, usize) -> Option<f64>) -> Vec<Series> {
        let runs = self.runs.iter().zip(&self.roles);
        let series =
            runs.map(|(run, &role)| self.series(&run.method, role, |sample| value(run, sample)));
        series.collect()
    }

    fn touched(&self, value: impl Fn(&Touched) -> f64) -> Vec<Series> {
        self.of_runs(|run, sample| run.touched.get(sample).map(&value))
    }

    fn series(&self, name: &str, role: Role, value: impl Fn(usize) -> Option<f64>) -> Series {
        let values = (0..self.times.len()).map(|sample| value(sample).unwrap_or(f64::NAN));
        Series {
            name: name.into(),
            kind: Kind::Step,
            role,
            x: self.times.clone(),
            y: values.collect(),
        }
    }
}

/// Returns the largest magnitude along each axis.
fn largest<'a>(vectors: impl Iterator<Item = &'a [f64; 3]>) -> [f64; 3] {
    vectors.fold([0.0; 3], |most, vector| {
        std::array::from_fn(|axis| vector[axis].abs().max(most[axis]))
    })
}

fn row(y_label: String, limits: Limits, series: Vec<Series>) -> Row {
    Row {
        y_label,
        limits,
        panels: vec![Panel { series }],
        ..Row::default()
    }
}
