//! What a line of the output says, and what its columns are called.

use std::fmt::Write;

use palpate::{Ledger, Limited, Output};
use palpate_scene::method::nearest;

/// A quantity that a line can say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    Force,
    ForceOnObject,
    Time,
    DevicePosition,
    ObjectPosition,
    ObjectVelocity,
    Penetration,
    PlacementShift,
    Phase,
    StoredEnergy,
    PortWork,
    VirtualForceWork,
    OutsideWork,
    LeakOriginal,
    LeakHeld,
    Limited,
    Fault,
}

impl Column {
    /// Every column: what `--columns` calls it, and its name with the unit, which is that of
    /// recordings and run files.
    pub const ALL: [(Self, &'static str, &'static str); 17] = [
        (Self::Force, "force", "force_on_device_n"),
        (Self::ForceOnObject, "force_on_object", "force_on_object_n"),
        (Self::Time, "time", "t_s"),
        (Self::DevicePosition, "device_position", "device_position_m"),
        (Self::ObjectPosition, "object_position", "object_position_m"),
        (
            Self::ObjectVelocity,
            "object_velocity",
            "object_velocity_m_per_s",
        ),
        (Self::Penetration, "penetration", "penetration_m"),
        (Self::PlacementShift, "placement_shift", "placement_shift_m"),
        (Self::Phase, "phase", "phase"),
        (Self::StoredEnergy, "stored_energy", "stored_energy_j"),
        (Self::PortWork, "port_work", "port_work_j"),
        (
            Self::VirtualForceWork,
            "virtual_force_work",
            "virtual_force_work_j",
        ),
        (Self::OutsideWork, "outside_work", "outside_work_j"),
        (Self::LeakOriginal, "leak_original", "leak_original_j"),
        (Self::LeakHeld, "leak_held", "leak_held_j"),
        (Self::Limited, "limited", "limited"),
        (Self::Fault, "fault", "fault"),
    ];

    /// Its name with the unit.
    fn header(self) -> &'static str {
        Self::ALL
            .into_iter()
            .find(|(column, ..)| *column == self)
            .map_or("", |(_, _, header)| header)
    }
}

/// Columns in the order in which they are printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns(Vec<Column>);

/// Names separated by commas, with or without their units.
pub fn columns(text: &str) -> Result<Columns, String> {
    let mut columns = Vec::new();
    for name in text.split(',').map(str::trim) {
        let found = Column::ALL
            .into_iter()
            .find(|(_, short, header)| [*short, *header].contains(&name));
        let Some((column, short, _)) = found else {
            let all = Column::ALL.map(|(_, short, _)| short);
            let nearest = nearest(name, &all)
                .map(|near| format!("did you mean \"{near}\"? "))
                .unwrap_or_default();
            return Err(format!(
                "no column is called \"{name}\"; {nearest}the columns are {}",
                all.join(", ")
            ));
        };
        if columns.contains(&column) {
            return Err(format!("{short} is named twice"));
        }
        columns.push(column);
    }
    Ok(Columns(columns))
}

/// What there is to say of a line that was answered.
#[derive(Clone, Debug)]
pub struct Row {
    /// Time of the sample `[s]`.
    pub time: f64,
    /// Position of the device `[m]`; NaN if the line had none.
    pub device_position: f64,
    /// Force on the device that is to be commanded `[N]`.
    pub force: f64,
    /// Whether the force was still coming in.
    pub softened: bool,
    /// What the renderer made of it.
    pub output: Output<f64>,
    /// The books up to the sample.
    pub ledger: Ledger<f64>,
    /// Name of what was wrong with the line, if anything was.
    pub fault: &'static str,
    /// Whether this is the end, which answers no line.
    pub ended: bool,
}

impl Row {
    /// The last line of the output: the same without a force.
    pub fn end(mut self) -> Self {
        self.force = 0.0;
        self.softened = false;
        self.output.force_on_object = 0.0;
        self.output.limited = Limited::default();
        self.fault = "";
        self.ended = true;
        self
    }

    fn number(&self, column: Column) -> Option<f64> {
        let (output, ledger) = (&self.output, &self.ledger);
        Some(match column {
            Column::Force => self.force,
            Column::ForceOnObject => output.force_on_object,
            Column::Time => self.time,
            Column::DevicePosition => self.device_position,
            Column::ObjectPosition => output.object_position,
            Column::ObjectVelocity => output.object_velocity,
            Column::Penetration => output.penetration,
            Column::PlacementShift => output.placement_shift,
            Column::StoredEnergy => ledger.stored,
            Column::PortWork => ledger.port_work,
            Column::VirtualForceWork => ledger.virtual_force_work,
            Column::OutsideWork => ledger.outside_work,
            Column::LeakOriginal => ledger.original_leak.accumulated,
            Column::LeakHeld => ledger.held_leak.accumulated,
            Column::Phase | Column::Limited | Column::Fault => return None,
        })
    }

    fn text(&self, column: Column) -> String {
        match column {
            Column::Phase if self.ended => "ended".into(),
            Column::Phase => self.output.phase.name().into(),
            Column::Limited => self.limits(),
            _ => self.fault.into(),
        }
    }

    /// Limits that changed the force, separated by spaces.
    fn limits(&self) -> String {
        let limited = self.output.limited;
        [
            (limited.pull, "pull"),
            (limited.force, "force"),
            (limited.slew, "slew"),
            (limited.guard, "guard"),
            (self.softened, "soft-start"),
        ]
        .into_iter()
        .filter_map(|(acted, name)| acted.then_some(name))
        .collect::<Vec<_>>()
        .join(" ")
    }
}

impl Columns {
    /// The first line of the output, if it is asked for.
    pub fn header(&self) -> String {
        let names: Vec<_> = self.0.iter().map(|column| column.header()).collect();
        names.join(",") + "\n"
    }

    /// Puts a line in place of what `line` holds. A number that is not known is `nan`.
    pub fn write(&self, row: &Row, line: &mut String) {
        line.clear();
        for (at, &column) in self.0.iter().enumerate() {
            if at > 0 {
                line.push(',');
            }
            match row.number(column) {
                Some(number) if number.is_nan() => line.push_str("nan"),
                // Adding 0 turns -0 into 0. A string takes whatever is written into it.
                Some(number) => drop(write!(line, "{}", number + 0.0)),
                None => line.push_str(&row.text(column)),
            }
        }
        line.push('\n');
    }
}
