//! Reports as text for a terminal.

use std::fmt;

use comfy_table::{Cell, CellAlignment, Table};
use palpate_core::Mass;

use super::{CollisionReport, MethodReport, OverSeeds, Report};
use crate::spread::Spread;
use crate::text::{
    E, FRE, WIDTH, counted, digits, hanging, legend, lines, number, percent, plain_table, short,
    whole, width, wrapped,
};

/// Explanation of the leak columns.
const LEAKS: &str = "Leak: energy that the held force created; |leak|: the same with every part counted as \
     positive.";

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", wrapped(&self.title))?;
        if let Some(recording) = &self.recording {
            writeln!(f, "{}", wrapped(&recording.to_string()))?;
        }
        writeln!(f, "{}", wrapped(&self.conditions()))?;
        if let Some(replayed) = &self.replay {
            writeln!(f, "{}", wrapped(&replayed.in_words()))?;
        }
        if let Some(motion) = &self.motion {
            writeln!(f, "{}", wrapped(&motion.in_words()))?;
        }
        if !self.actuator.is_empty() {
            let values = self.actuator.iter();
            let values: Vec<String> = values
                .map(|(key, value)| format!("{key} {value}"))
                .collect();
            writeln!(
                f,
                "{}",
                hanging(&format!("actuator: {}", values.join(", ")), 2)
            )?;
        }
        let imperfect = self.imperfections();
        if !imperfect.is_empty() {
            // The number of samples is that of one draw.
            let line = match self.seeds {
                Some(_) => imperfect,
                None => format!("{imperfect}: {}", counted(self.samples, "sample")),
            };
            writeln!(f, "{}", wrapped(&line))?;
        }
        let [window, floor] = self.window();
        writeln!(f, "{}\n{}\n", wrapped(&window), wrapped(&floor))?;
        if self.seeds.is_some() {
            writeln!(f, "{}\n", lines(&self.spread_table()))?;
            writeln!(f, "A value: median over the seeds (least to largest).\n")?;
            if let Some(seeded) = &self.seeded {
                writeln!(f, "{seeded}")?;
            }
        } else {
            writeln!(f, "{}\n", self.methods_in_words())?;
        }
        if self.says_what_columns_are && self.hold_bound_percent.is_some() {
            writeln!(f, "{}\n", legend(&[E, FRE, LEAKS]))?;
        }
        if self.seed.is_some() && self.seeds.is_none() {
            let draw = "The results are of one random draw; `simulate --seeds 20` shows how they vary from seed to \
                        seed.";
            writeln!(f, "{}\n", wrapped(draw))?;
        }
        if let [method] = self.methods.as_slice()
            && self.seeds.is_none()
            && !method.collisions.is_empty()
        {
            const MAX_COLLISIONS: usize = 12;
            writeln!(f, "Collision by collision\n")?;
            writeln!(f, "{}\n", lines(&collision_table(method, MAX_COLLISIONS)))?;
            let has_energies =
                |collision: &CollisionReport| collision.rebound_energy_error_percent.is_some();
            if method.collisions.iter().any(has_energies) {
                writeln!(f, "Energy: error of the kinetic energy of the rebound.\n")?;
            }
            if method.collisions.len() > MAX_COLLISIONS {
                writeln!(
                    f,
                    "The first {MAX_COLLISIONS} of {}; --json has all.",
                    method.collisions.len()
                )?;
            }
            if let Some(words) = self.out_of_step(method) {
                writeln!(f, "{}", wrapped(&words))?;
            }
        }
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

impl Report {
    /// Returns the delay, after a comma; empty without a delay.
    fn delay(&self) -> String {
        match (self.delay_samples, self.delay_fraction) {
            (0, 0.0) => String::new(),
            (samples, 0.0) => format!(", delay {}", counted(samples, "sample")),
            (samples, fraction) => format!(", delay {} periods", samples as f64 + fraction),
        }
    }

    /// Returns the imperfections of loop and sensor, with the seeds of the random ones.
    fn imperfections(&self) -> String {
        let mut words = self.timing_in_words.clone();
        match (self.seed, self.seeds) {
            (None, _) => {}
            (Some(seed), None) => words += &format!(", one draw of seed {seed}"),
            (Some(first), Some(count)) => {
                let last = first.saturating_add(count as u64 - 1);
                words += &format!(", seeds {first} to {last}");
            }
        }
        words
    }

    /// Returns difficulty, loop and hold bound as one line.
    pub(crate) fn in_short(&self) -> String {
        let kappa = self
            .kappa
            .map_or_else(String::new, |kappa| format!("kappa {}, ", digits(kappa)));
        let delay = self.delay();
        let timing = match self.imperfections().as_str() {
            "" => String::new(),
            words => format!("\n{}", hanging(&format!("  {words}"), 2)),
        };
        let floor = self.hold_bound_percent.map_or_else(
            || "no contact".into(),
            |floor| format!("hold bound {floor:.1} %"),
        );
        format!(
            "{kappa}Kc {}, {} Hz{delay}; {floor}{timing}",
            digits(self.object_kappa),
            (1e3 / self.period_s).round() / 1e3
        )
    }

    fn conditions(&self) -> String {
        let object = match self.object_mass_kg {
            Mass::Finite(mass) => format!("object {mass} kg"),
            Mass::Infinite => "wall".into(),
        };
        let device = match (self.device_mass_kg, self.kappa) {
            (Some(mass), Some(kappa)) => {
                // Rounded: a linkage's effective mass has many digits.
                let mass = (mass * 1e6).round() / 1e6;
                format!(", device {mass} kg (kappa {})", digits(kappa))
            }
            _ => String::new(),
        };
        let delay = self.delay();
        format!(
            "{object}, {} N/m, period {} s (Kc {}){device}{delay}",
            self.stiffness_n_per_m,
            self.period_s,
            digits(self.object_kappa),
        )
    }

    /// Returns the evaluated window and the zero-order-hold bound, in words.
    fn window(&self) -> [String; 2] {
        let nearer = "no held force can be nearer to the ideal than";
        let floor = match (self.hold_bound_percent, self.hold_bound_over_seeds) {
            (_, Some(floors)) => format!("{nearer} {} %", spread(floors, |value| short(value, 2))),
            (Some(floor), None) => format!("{nearer} {floor:.2} %"),
            (None, None) => "the ideal has no contact, so there is no force error".into(),
        };
        let integrated = if self.ideal_error > 0.0 {
            format!(
                " (integrated to {} of the largest)",
                digits(self.ideal_error)
            )
        } else {
            String::new()
        };
        let outside = self.ideal_leaves_box_at_s.map_or_else(String::new, |time| {
            format!(". The ideal itself leaves the safety box at {time:.2} s")
        });
        let window = format!(
            "{}, {}{integrated};",
            counted(self.window_periods, "period"),
            counted(self.ideal_collisions, "ideal collision")
        );
        [window, floor + &outside]
    }

    /// Returns a warning if some rows compare different collisions.
    fn out_of_step(&self, method: &MethodReport) -> Option<String> {
        let evaluated = method.collisions.len();
        // One more collision may begin without an end within the window.
        let most = evaluated + usize::from(self.ideal_collisions > evaluated);
        let rendered = method.rendered_collisions;
        (!(evaluated..=most).contains(&rendered)).then(|| {
            format!(
                "{} rendered for {evaluated} ideal ones: from the first missing or surplus one on, a row compares \
                 different collisions.",
                counted(rendered, "collision")
            )
        })
    }

    /// Returns the numbers of each method with its remarks: beside the numbers if they fit the width, otherwise
    /// below.
    fn methods_in_words(&self) -> String {
        let text = whole(&self.method_table(true));
        if width(&text) <= WIDTH {
            return text;
        }
        let mut text = lines(&self.method_table(false));
        let remarks = self
            .methods
            .iter()
            .map(|method| (method.method, method.remarks()));
        let remarks = remarks.filter(|(_, remarks)| !remarks.is_empty());
        for (place, (method, remarks)) in remarks.enumerate() {
            text += if place == 0 { "\n\n" } else { "\n" };
            text += &hanging(&format!(" {method}: {remarks}"), 3);
        }
        text
    }

    /// Returns the numbers of each method over several seeds.
    fn spread_table(&self) -> Table {
        let lossless = self
            .methods
            .iter()
            .any(|method| method.energy_drift_percent.is_some());
        let mut header = vec![
            "method",
            "E %",
            "FRE %",
            "FRE/bound",
            "peak N",
            "pull N",
            "leak mJ",
            "|leak| mJ",
        ];
        if lossless {
            header.push("drift %");
        }
        let remarks = |method: &MethodReport| {
            let over = method.over_seeds.as_ref();
            over.map_or_else(String::new, OverSeeds::remarks)
        };
        if self
            .methods
            .iter()
            .any(|method| !remarks(method).is_empty())
        {
            header.push("seeds");
        }
        let mut table = plain_table(CellAlignment::Left, &header);
        for method in &self.methods {
            let Some(over) = &method.over_seeds else {
                continue;
            };
            let cell = |it: Option<Spread>, format: &dyn Fn(f64) -> String| {
                let text = it.map_or_else(|| "-".into(), |it| spread(it, format));
                Cell::new(text).set_alignment(CellAlignment::Right)
            };
            let millijoules = |it: Spread| Some(it.times(1e3));
            let mut cells = vec![
                Cell::new(method.method),
                cell(over.mean_force_error_percent, &percent),
                cell(over.force_rendering_error_percent, &percent),
                cell(over.error_over_bound, &|ratio| short(ratio, 2)),
                cell(Some(over.peak_force_n), &digits),
                cell(Some(over.strongest_pull_n), &digits),
                cell(millijoules(over.leak_held_j), &digits),
                cell(millijoules(over.absolute_leak_held_j), &digits),
            ];
            if lossless {
                cells.push(cell(over.energy_drift_percent, &percent));
            }
            if header.last() == Some(&"seeds") {
                cells.push(Cell::new(remarks(method)));
            }
            table.add_row(cells);
        }
        table
    }

    fn method_table(&self, with_remarks: bool) -> Table {
        let lossless = self
            .methods
            .iter()
            .any(|method| method.energy_drift_percent.is_some());
        let mut header = vec![
            "method",
            "E %",
            "FRE %",
            "FRE/bound",
            "peak N",
            "pull N",
            "leak mJ",
            "|leak| mJ",
        ];
        if lossless {
            header.push("drift %");
        }
        let remarkable = with_remarks
            && self
                .methods
                .iter()
                .any(|method| !method.remarks().is_empty());
        if remarkable {
            header.push("");
        }
        let mut table = plain_table(CellAlignment::Left, &header);
        for method in &self.methods {
            let mut cells = vec![
                Cell::new(method.method),
                number(method.mean_force_error_percent, percent),
                number(method.force_rendering_error_percent, percent),
                number(method.error_over_bound, |ratio| short(ratio, 2)),
                number(Some(method.peak_force_n), digits),
                number(Some(method.strongest_pull_n), digits),
                number(Some(1e3 * method.leak_held_j), digits),
                number(Some(1e3 * method.absolute_leak_held_j), digits),
            ];
            if lossless {
                cells.push(number(method.energy_drift_percent, percent));
            }
            if remarkable {
                cells.push(Cell::new(method.remarks()));
            }
            table.add_row(cells);
        }
        table
    }
}

impl MethodReport {
    pub(crate) fn remarks(&self) -> String {
        let mut remarks = Vec::new();
        if self.diverged == Some(true) {
            remarks.push("diverged".into());
        }
        if let Some(time) = self.left_box_at_s {
            remarks.push(format!("left the safety box at {time:.2} s"));
        }
        // Outside the box, a device without motors moves on to the end of its links.
        if let Some(time) = self.jammed_at_s.filter(|_| self.left_box_at_s.is_none()) {
            remarks.push(format!("jammed at {time:.2} s"));
        }
        if self.faults > 0 {
            remarks.push(format!("{} refused", counted(self.faults, "sample")));
        }
        if self.limited > 0 {
            remarks.push(format!("{} limited", counted(self.limited, "force")));
        }
        if let Some(count) = self.beyond_guard {
            let count = counted(count, "interval");
            remarks.push(format!("{count} beyond the acceleration of the guard"));
        }
        remarks.join(", ")
    }
}

/// Returns the median with the range: `4.4 (3.1 to 7.9)`.
fn spread(it: Spread, format: impl Fn(f64) -> String) -> String {
    let [median, least, largest] = [it.median, it.least, it.largest].map(format);
    format!("{median} ({least} to {largest})")
}

fn collision_table(method: &MethodReport, most: usize) -> Table {
    let mut header = vec!["start s", "impulse N s", "error %", "peak N", "error %"];
    // A recorded device does not rebound, and friction takes a part of the rebound energy.
    let has = |value: fn(&CollisionReport) -> Option<f64>| {
        method.collisions.iter().any(|each| value(each).is_some())
    };
    let speeds = has(|collision| collision.ideal_rebound_speed_m_per_s);
    let energies = has(|collision| collision.rebound_energy_error_percent);
    if speeds {
        header.extend(["rebound m/s", "error %"]);
    }
    if energies {
        header.push("energy %");
    }
    let mut table = plain_table(CellAlignment::Right, &header);
    for collision in method.collisions.iter().take(most) {
        let in_percent = |error: Option<f64>| number(error, percent);
        let mut cells = vec![
            number(Some(collision.start_s), |start| format!("{start:.4}")),
            number(Some(collision.ideal_impulse_n_s), digits),
            in_percent(collision.impulse_error_percent),
            number(Some(collision.ideal_peak_force_n), digits),
            in_percent(collision.peak_force_error_percent),
        ];
        if speeds {
            cells.push(number(collision.ideal_rebound_speed_m_per_s, digits));
            cells.push(in_percent(collision.rebound_speed_error_percent));
        }
        if energies {
            cells.push(in_percent(collision.rebound_energy_error_percent));
        }
        table.add_row(cells);
    }
    table
}
