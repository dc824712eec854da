//! A device report as text for a terminal.

use std::fmt;

use comfy_table::{Cell, CellAlignment};

use super::{Card, EffectiveCard, FeltPointCard, MethodFeltCard, Outcome};
use crate::advise::Reach;
use crate::text::{counted, digits, lines, number, percent, plain_table, wrapped};

/// Highest frequency of the table of felt contacts `[Hz]`.
const MAX_GUIDED_HZ: f64 = 10.0;

impl fmt::Display for Card {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", wrapped(&format!("Device: {}", self.device.name)))?;
        for said in &self.obtained {
            writeln!(f, "{}", wrapped(said))?;
        }
        if !self.timing.is_empty() {
            writeln!(f, "\n{}", lines(&self.timing_table()))?;
        }
        if let Some(reach) = &self.reach {
            let header = [
                "method",
                "stiffest wall\nstable N/m",
                "good",
                "lightest object\nstable kg",
                "good",
            ];
            let mut table = plain_table(CellAlignment::Left, &header);
            for of in &reach.methods {
                table.add_row([
                    Cell::new(of.method),
                    limit(&of.stable_wall_n_per_m, "≥ "),
                    limit(&of.good_wall_n_per_m, "≥ "),
                    limit(&of.stable_object_kg, "≤ "),
                    limit(&of.good_object_kg, "≤ "),
                ]);
            }
            writeln!(f, "\n{}\n", lines(&table))?;
            writeln!(f, "{}", wrapped(&reach.in_words()))?;
        }
        if let Some(felt) = &self.felt {
            writeln!(f, "\n{}\n", lines(&felt.table()))?;
            writeln!(f, "{}", wrapped(&felt.in_words()))?;
        }
        if let Some(contact) = &self.contact {
            let percent = |value: Option<f64>| value.map_or_else(|| "-".into(), percent);
            let words = format!(
                "Contact, {}: FRE {} %, E {} %, hold bound {} %; the held force created {} mJ.",
                contact.source,
                percent(contact.force_rendering_error_percent),
                percent(contact.mean_force_error_percent),
                percent(contact.hold_bound_percent),
                digits(1e3 * contact.leak_held_j)
            );
            writeln!(f, "\n{}", wrapped(&words))?;
        }
        writeln!(f)?;
        for check in self.warnings() {
            let remedy = check.remedy.as_deref().unwrap_or_default();
            let words = format!(
                "warning: {}: {}. Remedy: {remedy}.",
                check.name, check.finding
            );
            writeln!(f, "{}", wrapped(&words))?;
        }
        let named = |outcome: Outcome| {
            let checks = self.checks.iter().filter(|check| check.outcome == outcome);
            let mut names: Vec<&str> = checks.map(|check| check.name).collect();
            names.dedup();
            names.join(", ")
        };
        for (outcome, words) in [
            (Outcome::InOrder, "in order"),
            (Outcome::NotChecked, "not checked"),
        ] {
            let names = named(outcome);
            if !names.is_empty() {
                writeln!(f, "{}", wrapped(&format!("{words}: {names}")))?;
            }
        }
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

impl Card {
    fn timing_table(&self) -> comfy_table::Table {
        let header = ["", "ticks", "median [us]", "99 %", "longest"];
        let mut table = plain_table(CellAlignment::Left, &header);
        for of in &self.timing {
            for (name, durations) in [
                ("period", &of.period_s),
                ("lateness", &of.lateness_s),
                ("tick", &of.tick_s),
                ("device response", &of.round_trip_s),
            ] {
                if let Some(durations) = durations {
                    let name = if self.timing.len() > 1 {
                        format!("{name}, {}", of.recording)
                    } else {
                        name.to_owned()
                    };
                    let mut row = vec![
                        Cell::new(name),
                        Cell::new(durations.count).set_alignment(CellAlignment::Right),
                    ];
                    let values = [durations.median, durations.p99, durations.largest];
                    row.extend(values.map(|value| number(Some(1e6 * value), digits)));
                    table.add_row(row);
                }
            }
        }
        table
    }
}

impl super::FeltCard {
    fn table(&self) -> comfy_table::Table {
        let header = [
            "felt by a hand",
            "wall at\nHz",
            "stiffness\nN/m",
            "damping\nN s/m",
            "object at\nHz",
            "mass\nkg",
            "damping\nN s/m",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        type Part = fn(&FeltPointCard) -> Option<EffectiveCard>;
        let mut add_row = |name: &str, part: Part, from: &MethodFeltCard| {
            // A wall at the highest frequency at which a hand still guides a device, an object where it is felt as a
            // mass.
            let guided = |point: &&FeltPointCard| point.frequency_hz <= MAX_GUIDED_HZ;
            let wall = from.wall.iter().rev().find(guided);
            let object = from.object.first();
            let (of_wall, of_object) = (wall.and_then(part), object.and_then(part));
            table.add_row([
                Cell::new(name),
                number(wall.map(|point| point.frequency_hz), digits),
                number(of_wall.map(|part| part.stiffness_n_per_m), digits),
                number(of_wall.map(|part| part.damping_n_s_per_m), digits),
                number(object.map(|point| point.frequency_hz), digits),
                number(of_object.map(|part| part.mass_kg), digits),
                number(of_object.map(|part| part.damping_n_s_per_m), digits),
            ]);
        };
        if let Some(first) = self.methods.first() {
            add_row("wanted", |point| point.wanted, first);
        }
        for method in &self.methods {
            add_row(method.method, |point| point.rendered, method);
        }
        table
    }

    /// Returns the conditions of the computation, and the Z-width, in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let width = match self.stiffest() {
            Some((stiffness, damping)) => format!(
                "Z-width, the stiffest stable wall of virtual-damper: {} N/m at {} N s/m",
                digits(stiffness),
                digits(damping)
            ),
            None => "Z-width: no wall of virtual-damper is stable".to_owned(),
        };
        format!(
            "Force over displacement of a hand that oscillates in a contact of {} N/m, pressed with {} N, without the \
             device; the object has its mass, {} kg. Negative damping gives out energy. {width}.",
            digits(self.stiffness_n_per_m),
            digits(self.pressed_with_n),
            digits(self.object_mass_kg)
        )
    }
}

impl super::ReachCard {
    /// Returns the conditions of the computation in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let known_to = |deviation: f64| match deviation {
            0.0 => String::new(),
            _ => format!(" ± {} ms", digits(1e3 * deviation)),
        };
        let known = format!(
            "Computed for a device of {} kg at a period of {} ms, with a delay of {} ms{}, a lag of {} ms{}, {} N s/m \
             of friction and sensor steps of {} um, by a renderer whose model has these values",
            digits(self.device_mass_kg),
            digits(1e3 * self.period_s),
            digits(1e3 * self.delay_s),
            known_to(self.delay_deviation_s),
            digits(1e3 * self.lag_s),
            known_to(self.lag_deviation_s),
            digits(self.viscous_friction_n_s_per_m),
            digits(1e6 * self.sensor_quantum_m)
        );
        let assumed = if self.assumed.is_empty() {
            String::new()
        } else {
            format!(" (unknown, taken as 0: {})", self.assumed.join(", "))
        };
        format!(
            "{known}{assumed}. Dry friction is ignored. {} contacts bounced from {} start heights each, in {} s; \
             kappa and Kc from {} to {}. The resolution is a factor of {:.2} over the object's mass, and of {:.2} for \
             wall and object. Stable: no bounce gains more than 1 % of energy. Good: stable, E and hold bound below \
             {} %, and steady at rest and pressed in a hand. The lightest object is at {} N/m.",
            self.contacts,
            self.start_heights,
            digits(self.computed_in_s),
            self.searched[0],
            self.searched[1],
            self.step,
            self.finest_step,
            self.good_below_percent,
            digits(self.stiffness_n_per_m)
        )
    }
}

impl super::TimingCard {
    /// Returns length, period and losses of the recording in words.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = counted(self.ticks, "tick");
        if let Some(lasted) = self.lasted_s {
            words.push_str(&format!(" over {} s", digits(lasted)));
        }
        if let Some(period) = self.period_asked_s {
            words.push_str(&format!(", requested every {} ms", digits(1e3 * period)));
        }
        words.push_str(&format!(
            "; {} missed, {} lost",
            counted(self.missed_deadlines, "deadline"),
            counted(self.ticks_lost, "tick")
        ));
        words
    }
}

fn limit(limit: &Reach, beyond: &str) -> Cell {
    number(limit.value, |value| {
        let sign = if limit.or_beyond { beyond } else { "" };
        format!("{sign}{}", digits(value))
    })
}
