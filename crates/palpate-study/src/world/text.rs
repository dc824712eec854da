//! The report of a world as text for a terminal.

use std::fmt;

use comfy_table::{Cell, CellAlignment, Table};
use palpate_testbed::world::Decisive;

use super::{DecisiveReport, FidelityReport, WorldMethodReport, WorldReport};
use crate::text::{
    E, FRE, counted, digits, legend, lines, number, percent, plain_table, short, wrapped,
};

/// Explanation of the leak column.
const LEAK: &str = "Leak: energy that held forces created: the sum of the gains of hands, bodies, contacts and \
                    dissipation.";

impl fmt::Display for WorldReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.title.is_empty() {
            writeln!(f, "{}", wrapped(&self.title))?;
        }
        writeln!(f, "{}", wrapped(&self.conditions()))?;
        if let Some(motion) = &self.motion {
            writeln!(f, "{}", wrapped(&motion.in_words()))?;
        }
        writeln!(f)?;
        writeln!(f, "{}\n", lines(&self.method_table()))?;
        if self.methods.iter().any(|method| method.sum.is_some()) {
            writeln!(f, "{}", lines(&self.axis_table()))?;
            if let Some(table) = self.torque_table() {
                writeln!(f, "\n{}", lines(&table))?;
            }
            writeln!(f, "\n{}", legend(&[E, FRE, LEAK]))?;
        } else {
            writeln!(f, "The ideal touches no tool in this window.")?;
        }
        for left_out in &self.left_out {
            let line = format!("{} was left out: {}.", left_out.method, left_out.reason);
            writeln!(f, "{}", wrapped(&line))?;
        }
        if !self.left_out.is_empty() {
            let line = "`palpate compare` with the world searches settings for them.";
            writeln!(f, "{line}")?;
        }
        for line in self.remarks() {
            writeln!(f, "{}", wrapped(&line))?;
        }
        if let Some(seeded) = &self.seeded {
            write!(f, "\n{seeded}")?;
        }
        Ok(())
    }
}

impl WorldReport {
    fn conditions(&self) -> String {
        let delay = if self.delay_s > 0.0 {
            format!(", delay {} s", digits(self.delay_s))
        } else {
            String::new()
        };
        let lag = if self.lag_s > 0.0 {
            format!(", lag {} s", digits(self.lag_s))
        } else {
            String::new()
        };
        let hold = self.hold_order.map_or("", |_| ", commands are lines");
        let shortened = self.chaotic_from_s.map_or_else(String::new, |from| {
            format!(
                "; the window ends at {} s, where the ideal's motion begins to depend on its steps",
                digits(from)
            )
        });
        let agrees = self.ideal_error_percent.map_or_else(String::new, |error| {
            format!(", and is converged to {} %", digits(error))
        });
        let imperfect = match &*self.timing_in_words {
            "" => String::new(),
            words => format!(", {words}"),
        };
        format!(
            "period {} s{delay}{lag}{hold}{imperfect}; {} over {} s; the ideal has {} and penetration up to {} m{agrees}{shortened}",
            digits(self.period_s),
            counted(self.samples, "sample"),
            digits(self.window_s),
            counted(self.contacts, "contact"),
            digits(self.deepest_m),
        )
    }

    fn method_table(&self) -> Table {
        let header = ["method", "E %", "FRE %", "FRE/bound", "leak mJ", "limited"];
        let limited = self.methods.iter().any(|method| method.limited_samples > 0);
        let header = &header[..header.len() - usize::from(!limited)];
        let mut table = plain_table(CellAlignment::Left, header);
        for method in &self.methods {
            let mut row = vec![Cell::new(&method.method)];
            row.extend(errors(method.sum.as_ref()));
            row.push(number(Some(1e3 * method.leak_j), |leak| short(leak, 3)));
            if limited {
                let count = method.limited_samples as f64;
                row.push(number(Some(count), |count| count.to_string()));
            }
            table.add_row(row);
        }
        table
    }

    /// Returns the error along each axis, per method and device.
    fn axis_table(&self) -> Table {
        let header = [
            "method",
            "device",
            "E % along x",
            "y",
            "z",
            "peak/ideal",
            "largest impulse error %",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for method in &self.methods {
            for device in &method.devices {
                let mut row = vec![Cell::new(&method.method), Cell::new(&device.name)];
                row.extend(device.axes.iter().map(|axis| {
                    let error = axis.map(|axis| axis.mean_force_error_percent);
                    number(error, percent)
                }));
                row.push(number(device.peak_over_ideal_peak, |ratio| short(ratio, 2)));
                row.push(number(device.largest_impulse_error_percent, percent));
                table.add_row(row);
            }
        }
        table
    }

    /// Returns the torque error about each axis, if a device has a torque.
    fn torque_table(&self) -> Option<Table> {
        let header = [
            "method",
            "device",
            "E % of the force",
            "of the torque",
            "about x",
            "y",
            "z",
            "peak N m",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        let mut turns = false;
        for method in &self.methods {
            for device in &method.devices {
                let Some(torque) = &device.torque else {
                    continue;
                };
                turns = true;
                let error = |it: Option<&FidelityReport>| {
                    number(it.map(|it| it.mean_force_error_percent), percent)
                };
                let mut row = vec![Cell::new(&method.method), Cell::new(&device.name)];
                row.push(error(device.force.as_ref()));
                row.push(error(torque.sum.as_ref()));
                row.extend(torque.axes.iter().map(|axis| error(axis.as_ref())));
                row.push(number(Some(torque.peak_torque_n_m), |peak| short(peak, 4)));
                table.add_row(row);
            }
        }
        turns.then_some(table)
    }

    /// Describes where the sensor or the hand of a device, and not the renderer, dominates its errors.
    fn decided(&self, it: &DecisiveReport) -> Vec<String> {
        let mut decided = Vec::new();
        if let Some(part) = it.quantum_over_force.filter(|it| *it > Decisive::SENSOR) {
            decided.push(format!(
                "\"{}\": a quantum of its sensor is {} N in its stiffest contact, {} % of the ideal's force (rms). \
                 Above {} % the sensor dominates E.",
                it.name,
                short(it.quantum_force_n, 3),
                short(100.0 * part, 0),
                100.0 * Decisive::SENSOR,
            ));
        }
        if self.delay_s > 0.0 && it.hand_over_mass > Decisive::HAND {
            decided.push(format!(
                "\"{}\": the hand's stiffness k and the mass m have k T^2/m {}. Above {}, and with a delay, the hand \
                 dominates E.",
                it.name,
                short(it.hand_over_mass, 2),
                Decisive::HAND,
            ));
        }
        decided
    }

    /// Returns remarks on facts that the tables do not show.
    fn remarks(&self) -> Vec<String> {
        let overlap = |[one, other]: &[String; 2]| {
            format!(
                "\"{one}\" and \"{other}\" overlap at the start; their contact begins with that penetration."
            )
        };
        let mut remarks: Vec<_> = self.overlapping_at_start.iter().map(overlap).collect();
        let devices = self
            .methods
            .first()
            .map_or(&[][..], |method| &method.devices);
        let of_own = devices.iter().filter(|device| device.own_axes.is_some());
        remarks.extend(of_own.map(|device| {
            format!(
                "\"{}\": x, y and z are the device's own axes, in the order of the file.",
                device.name
            )
        }));
        remarks.extend(self.decisive.iter().flat_map(|it| self.decided(it)));
        remarks.extend(self.methods.iter().flat_map(remarks_on));
        remarks
    }
}

/// Returns remarks on the run of a method that the tables do not show.
fn remarks_on(method: &WorldMethodReport) -> Vec<String> {
    let mut remarks = Vec::new();
    if method.refused_samples > 0 {
        let first = method.first_refusal.as_ref();
        let why = first.map_or_else(String::new, |first| {
            format!(
                " The first, at {} s: {}.",
                digits(first.time_s),
                first.reason
            )
        });
        remarks.push(format!(
            "{}: {} refused; the forces were 0 there.{why}",
            method.method,
            counted(method.refused_samples, "sample")
        ));
    }
    if method.guarded_samples > 0 {
        remarks.push(format!(
            "{}: at {} the forces exceeded the guard's bound.",
            method.method,
            counted(method.guarded_samples, "sample")
        ));
    }
    if let Some(count) = method.beyond_guard {
        remarks.push(format!(
            "{}: {} beyond the acceleration of the guard.",
            method.method,
            counted(count, "interval")
        ));
    }
    if let Some(through) = &method.first_through {
        let more = match method.went_through {
            1 => String::new(),
            count => format!(", and {count} times in all"),
        };
        remarks.push(format!(
            "{}: \"{}\" went through \"{}\" and left its far side at {} s{more}. E does not show it if the \
             ideal does the same. A thicker or stiffer solid, or a hull or mesh, which follow their surface, \
             prevents it.",
            method.method,
            through.first,
            through.second,
            digits(through.time_s)
        ));
    }
    let error = method.sum.map(|sum| sum.mean_force_error_percent);
    if method.too_fast_samples > 0 && method.method == "coupled" && error >= Some(1.0) {
        remarks.push(format!(
            "{}: at {} a contact or joint swings within a few periods; a small motion error is a large force \
             error there.",
            method.method,
            counted(method.too_fast_samples, "sample")
        ));
    }
    if method.coarse_samples > 0 {
        remarks.push(format!(
            "{}: at {} contacts changed their mode more often than the finest step of the renderer resolves.",
            method.method,
            counted(method.coarse_samples, "sample")
        ));
    }
    if method.crowded_samples > 0 {
        remarks.push(format!(
            "{}: at {} more triangles or shell points were near than the renderer can hold; it ignored the \
             furthest.",
            method.method,
            counted(method.crowded_samples, "sample")
        ));
    }
    remarks
}

fn errors(fidelity: Option<&FidelityReport>) -> [Cell; 3] {
    let value = |of: fn(&FidelityReport) -> f64| fidelity.map(of);
    [
        number(value(|it| it.mean_force_error_percent), percent),
        number(value(|it| it.force_rendering_error_percent), percent),
        number(fidelity.and_then(|it| it.error_over_bound), |ratio| {
            short(ratio, 2)
        }),
    ]
}
