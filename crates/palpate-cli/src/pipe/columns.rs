//! Contents and columns of an output line.

use palpate_record::recording::{self, Flags, Value};
use palpate_scene::method::nearest;

use crate::pipe::number;

/// Column of an output line.
#[derive(Clone, Copy, Debug)]
pub enum AnswerColumn {
    /// A column of a recording, with its short name (without the unit).
    OfRow(&'static recording::Column, &'static str),
    /// Slope of the force on the device, for an actuator that holds lines.
    Slope,
    /// Names of the limits that changed the force.
    Limited,
    /// Fault of the line.
    Fault,
}

/// Columns of a recording that a pipe can print, in their order. The second value is the pipe's short name, if it
/// differs from the column's name without its unit.
const OF_ROW: [(&str, Option<&str>); 15] = [
    ("force_on_device_n", Some("force")),
    ("force_on_object_n", None),
    ("t_s", Some("time")),
    ("device_position_m", None),
    ("object_position_m", None),
    ("object_velocity_m_per_s", None),
    ("penetration_m", None),
    ("proxy_shift_m", None),
    ("phase", None),
    ("stored_energy_j", None),
    ("port_work_j", None),
    ("virtual_force_work_j", None),
    ("outside_work_j", None),
    ("leak_original_j", None),
    ("leak_held_j", None),
];

impl AnswerColumn {
    /// Returns every column.
    pub fn all() -> impl Iterator<Item = Self> {
        let named = |(name, own): (_, Option<_>)| {
            let column = recording::Column::named(name)?;
            Some(Self::OfRow(column, own.unwrap_or(column.short_name())))
        };
        let own = [Self::Slope, Self::Limited, Self::Fault];
        OF_ROW.into_iter().filter_map(named).chain(own)
    }

    /// Returns the name with the unit, as in recordings and run files.
    fn header(self) -> &'static str {
        match self {
            Self::OfRow(column, _) => column.name,
            Self::Slope => "slope_on_device_n_per_s",
            Self::Limited => "limited",
            Self::Fault => "fault",
        }
    }

    /// Returns the short name for selecting the column, without the unit.
    #[must_use]
    pub fn short_name(self) -> &'static str {
        match self {
            Self::OfRow(_, name) => name,
            Self::Slope => "slope",
            own => own.header(),
        }
    }
}

/// Columns in print order.
#[derive(Clone, Debug)]
pub struct Columns(Vec<AnswerColumn>);

/// Parses names separated by commas, with or without their units.
///
/// # Errors
/// A name is unknown or occurs twice.
pub fn columns(text: &str) -> Result<Columns, String> {
    let mut columns: Vec<AnswerColumn> = Vec::new();
    for name in text.split(',').map(str::trim) {
        let found = AnswerColumn::all()
            .find(|column| [column.short_name(), column.header()].contains(&name));
        let Some(column) = found else {
            let all: Vec<_> = AnswerColumn::all().map(AnswerColumn::short_name).collect();
            let nearest = nearest(name, &all)
                .map(|near| format!("did you mean \"{near}\"? "))
                .unwrap_or_default();
            return Err(format!(
                "unknown column \"{name}\"; {nearest}the columns are {}",
                all.join(", ")
            ));
        };
        if columns
            .iter()
            .any(|other| other.header() == column.header())
        {
            return Err(format!("{} is named twice", column.short_name()));
        }
        columns.push(column);
    }
    Ok(Columns(columns))
}

/// Answer to a line.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Rendered values; the force on the device is the one to command.
    pub values: recording::Row,
    /// Slope of the force on the device `[N/s]`: the force is the mean over one period.
    pub slope: f64,
    /// Whether the soft start reduced the force.
    pub softened: bool,
    /// Whether a safety stop holds the force at 0.
    pub stopped: bool,
    /// Name of the line's fault; empty if there is none.
    pub fault: &'static str,
    /// Whether this is the last line, which answers no input line.
    pub ended: bool,
}

impl Answer {
    /// Returns the last line of the output: this answer without a force.
    #[must_use]
    pub fn end(mut self) -> Self {
        self.values.contact.force_on_device = 0.0;
        self.values.contact.force_on_object = 0.0;
        self.values.contact.flags = Flags::default();
        self.slope = 0.0;
        self.softened = false;
        self.stopped = false;
        self.fault = "";
        self.ended = true;
        self
    }

    /// Returns the names of the limits that changed the force, separated by spaces.
    fn limits(&self) -> String {
        let soft_start = self.softened.then_some("soft-start");
        let stop = self.stopped.then_some("safety-stop");
        let limits: Vec<_> = self
            .values
            .contact
            .flags
            .limits()
            .chain(soft_start)
            .chain(stop)
            .collect();
        limits.join(" ")
    }
}

impl Columns {
    /// Returns the header line of the output.
    #[must_use]
    pub fn header(&self) -> String {
        let names: Vec<_> = self.0.iter().map(|column| column.header()).collect();
        names.join(",") + "\n"
    }

    /// Returns whether the slope of the force is one of them.
    #[must_use]
    pub fn have_slope(&self) -> bool {
        let mut columns = self.0.iter();
        columns.any(|column| matches!(column, AnswerColumn::Slope))
    }

    /// Returns whether a world has them: the force, and perhaps its slope.
    #[must_use]
    pub fn are_of_world(&self) -> bool {
        let names: Vec<_> = self.0.iter().map(|column| column.short_name()).collect();
        matches!(names[..], ["force"] | ["force", "slope"])
    }

    /// Replaces the contents of `line` by an answer. An unknown number is `nan`.
    pub fn write(&self, row: &Answer, line: &mut String) {
        line.clear();
        for (at, &column) in self.0.iter().enumerate() {
            if at > 0 {
                line.push(',');
            }
            match column {
                AnswerColumn::OfRow(column, _) => match column.value(&row.values) {
                    Value::Number(number) if number.is_nan() => line.push_str("nan"),
                    Value::Number(number) => number::push(line, number),
                    Value::Phase(_) if row.ended => line.push_str("ended"),
                    other => line.push_str(&other.text()),
                },
                AnswerColumn::Slope => number::push(line, row.slope),
                AnswerColumn::Limited => line.push_str(&row.limits()),
                AnswerColumn::Fault => line.push_str(row.fault),
            }
        }
        line.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_that_a_pipe_names_is_one_of_a_row() {
        assert_eq!(AnswerColumn::all().count(), OF_ROW.len() + 3);
    }
}
