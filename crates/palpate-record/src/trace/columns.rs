//! Selection of the columns of a table and their units.

use csv::StringRecord;

use super::fault::TraceFault;
use super::layout::Layout;
use crate::unit::{LengthUnit, TimeUnit};

/// Quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Time,
    Length,
    Force,
    /// A component of a quaternion.
    Part,
}

/// A column that a reader requests.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    pub kind: Kind,
    /// Quantities by which a layout can select the column.
    pub keys: Vec<String>,
    /// Names without a unit.
    pub bare: Vec<String>,
    /// Names before a unit, such as `position` in `position_mm`.
    pub stems: Vec<String>,
    /// Index from 0 among columns of the same name, and their number.
    pub nth: (usize, usize),
    /// Name in messages.
    pub shown: String,
    pub is_needed: bool,
}

impl Wanted {
    pub fn time() -> Self {
        Self {
            kind: Kind::Time,
            keys: vec!["t".into()],
            bare: vec!["t".into()],
            stems: vec!["t".into()],
            nth: (0, 1),
            shown: "t_s".into(),
            is_needed: true,
        }
    }

    /// Returns the names to search for if the layout does not select the column, in order of preference.
    fn names(&self, layout: &Layout) -> Vec<String> {
        let with = |symbol: &str| -> Vec<String> {
            let stems = self.stems.iter();
            stems.map(|stem| format!("{stem}_{symbol}")).collect()
        };
        let mut names = Vec::new();
        match (self.kind, layout.time_unit, layout.unit) {
            (Kind::Time, Some(unit), _) => names.extend(with(unit.symbol())),
            (Kind::Length, _, Some(unit)) => names.extend(with(unit.symbol())),
            _ => {}
        }
        match self.kind {
            Kind::Time => {
                names.extend(with(TimeUnit::Second.symbol()));
                names.extend(self.bare.clone());
                if layout.time_unit.is_none() {
                    let others = TimeUnit::ALL.into_iter().skip(1);
                    names.extend(others.flat_map(|unit| with(unit.symbol())));
                }
            }
            Kind::Length => {
                names.extend(self.bare.clone());
                names.extend(with(LengthUnit::Metre.symbol()));
                if layout.unit.is_none() {
                    let others = LengthUnit::ALL.into_iter().skip(1);
                    names.extend(others.flat_map(|unit| with(unit.symbol())));
                }
            }
            Kind::Force | Kind::Part => names.extend(self.bare.clone()),
        }
        names
    }
}

/// A column of a table.
#[derive(Debug, Clone)]
pub(super) struct Column {
    pub kind: Kind,
    /// Its index.
    pub at: usize,
    /// Its name in the header.
    pub name: String,
    /// Unit of its numbers, once known.
    unit: Unit,
}

/// The unit of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Unit {
    Length(LengthUnit),
    Time(TimeUnit),
    /// SI unit, or none.
    Plain,
}

impl Unit {
    fn symbol(self) -> &'static str {
        match self {
            Self::Length(unit) => unit.symbol(),
            Self::Time(unit) => unit.symbol(),
            Self::Plain => "",
        }
    }
}

/// A fault of the header, with the column's index; `None` for the whole header.
pub(super) type HeaderFault = (Option<usize>, TraceFault);

impl Column {
    /// Finds the column of a header; `None` for a missing optional column.
    pub fn find(
        header: &StringRecord,
        wanted: &Wanted,
        layout: &Layout,
        needed: &str,
    ) -> Result<Option<Self>, HeaderFault> {
        let Some((at, name)) = index(header, wanted, layout, needed)? else {
            return Ok(None);
        };
        let mut column = Self {
            kind: wanted.kind,
            at,
            name,
            unit: Unit::Plain,
        };
        column.unit = column
            .unit_of(layout, None)
            .map_err(|fault| (Some(at), fault))?;
        Ok(Some(column))
    }

    /// Returns whether a cell of the time column is a unit, so that its row is a row of units.
    pub fn is_unit_of_time(cell: &str) -> bool {
        time_unit(cell).is_some()
    }

    /// Sets the unit from a cell of the unit row.
    pub fn take_unit(&mut self, cell: &str, layout: &Layout) -> Result<(), TraceFault> {
        let allowed = match self.kind {
            Kind::Time => "s, ms, us and ns",
            Kind::Length => "m, cm, mm and um",
            Kind::Force | Kind::Part => return Ok(()),
        };
        let unit = match self.kind {
            Kind::Time => time_unit(cell).map(Unit::Time),
            _ => length_unit(cell).map(Unit::Length),
        };
        let unit = unit.ok_or_else(|| TraceFault::NotAUnit {
            name: self.name.clone(),
            text: super::shortened(cell),
            allowed,
        })?;
        self.unit = self.unit_of(layout, Some(unit))?;
        Ok(())
    }

    /// Determines the unit from the caller, the unit row or the name.
    fn unit_of(&self, layout: &Layout, row: Option<Unit>) -> Result<Unit, TraceFault> {
        let (given, named, usual) = match self.kind {
            Kind::Time => (
                layout.time_unit.map(Unit::Time),
                in_name(&self.name, time_unit).map(Unit::Time),
                Unit::Time(TimeUnit::Second),
            ),
            Kind::Length => (
                layout.unit.map(Unit::Length),
                in_name(&self.name, length_unit).map(Unit::Length),
                Unit::Length(LengthUnit::Metre),
            ),
            Kind::Force | Kind::Part => return Ok(Unit::Plain),
        };
        // A caller may override the SI unit in a column's name.
        let contradicts = |one: Unit, other: Unit| one != other && other != usual;
        let sides = match (given, row, named) {
            (Some(given), Some(row), _) if given != row => {
                Some((given, "the caller", row, "the unit row"))
            }
            (Some(given), _, Some(named)) if contradicts(given, named) => {
                Some((given, "the caller", named, "its name"))
            }
            (None, Some(row), Some(named)) if row != named => {
                Some((row, "the unit row", named, "its name"))
            }
            _ => None,
        };
        if let Some((one, says_one, other, says_other)) = sides {
            return Err(TraceFault::Units {
                name: self.name.clone(),
                one: one.symbol(),
                says_one,
                other: other.symbol(),
                says_other,
                way: layout.ways.unit(),
            });
        }
        Ok(given.or(row).or(named).unwrap_or(usual))
    }

    /// Converts a number of the column to the SI unit.
    pub fn si(&self, number: f64) -> f64 {
        match self.unit {
            Unit::Length(unit) => unit.metres(number),
            Unit::Time(unit) => unit.seconds(number),
            Unit::Plain => number,
        }
    }
}

/// Returns index and name of a column.
fn index(
    header: &StringRecord,
    wanted: &Wanted,
    layout: &Layout,
    needed: &str,
) -> Result<Option<(usize, String)>, HeaderFault> {
    let places = |name: &str| -> Vec<usize> {
        (0..header.len())
            .filter(|&at| header[at].trim() == name)
            .collect()
    };
    let missing = |name: &str, all: &[String]| {
        let nearest = nearest(header, all);
        let fault = TraceFault::MissingColumn {
            name: name.to_owned(),
            nearest: nearest.map(|at| super::shortened(header[at].trim())),
            needed: needed.to_owned(),
            way: layout.ways.columns(),
        };
        (nearest, fault)
    };
    let wrong_count = |name: &str, found: &[usize], needed: usize| {
        let fault = TraceFault::DuplicateColumn {
            name: name.to_owned(),
            found: found.len(),
            needed,
            way: layout.ways.columns(),
        };
        (found.get(1).or(found.first()).copied(), fault)
    };
    if let Some(name) = layout.column(&wanted.keys) {
        return match places(name).as_slice() {
            [at] => Ok(Some((*at, name.to_owned()))),
            [] => {
                let number = name
                    .strip_prefix('#')
                    .and_then(|number| number.parse().ok());
                let at = number.and_then(|number: usize| number.checked_sub(1));
                let at = at.filter(|&at| at < header.len());
                at.map(|at| Some((at, header[at].trim().to_owned())))
                    .ok_or_else(|| missing(name, &[name.to_owned()]))
            }
            several => Err(wrong_count(name, several, 1)),
        };
    }
    let (nth, of) = wanted.nth;
    let names = wanted.names(layout);
    for name in &names {
        let found = places(name);
        let count = if name.contains('.') { 1 } else { of };
        if found.is_empty() {
            continue;
        }
        if found.len() != count {
            return Err(wrong_count(name, &found, count));
        }
        return Ok(Some((
            found[if count == 1 { 0 } else { nth }],
            name.clone(),
        )));
    }
    if wanted.is_needed {
        return Err(missing(&wanted.shown, &names));
    }
    Ok(None)
}

/// Returns the index of the column whose name is most similar to one of `names`.
fn nearest(header: &StringRecord, names: &[String]) -> Option<usize> {
    let likeness = |at: &usize| {
        let field = header[*at].trim();
        let each = names.iter();
        each.map(|name| strsim::normalized_damerau_levenshtein(name, field))
            .fold(0.0, f64::max)
    };
    (0..header.len())
        .filter(|at| likeness(at) >= 0.25)
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)).then(b.cmp(a)))
}

/// Returns the unit at the end of a column's name: `X_mm`, `X (mm)`, `X [mm]`, `X/mm`.
fn in_name<U>(name: &str, unit: impl Fn(&str) -> Option<U>) -> Option<U> {
    let name = name.trim_end_matches([')', ']']);
    let (_, last) = name.rsplit_once(['_', '(', '[', '/'])?;
    unit(last)
}

/// Parses a unit of time in a cell or a name, with or without brackets.
fn time_unit(text: &str) -> Option<TimeUnit> {
    match bare(text) {
        "sec" | "second" | "seconds" => Some(TimeUnit::Second),
        "msec" | "millisecond" | "milliseconds" => Some(TimeUnit::Millisecond),
        "µs" | "μs" | "usec" | "microsecond" | "microseconds" => Some(TimeUnit::Microsecond),
        "nsec" | "nanosecond" | "nanoseconds" => Some(TimeUnit::Nanosecond),
        symbol => TimeUnit::of_symbol(symbol),
    }
}

/// Parses a unit of length in the same way.
fn length_unit(text: &str) -> Option<LengthUnit> {
    match bare(text) {
        "meter" | "meters" | "metre" | "metres" => Some(LengthUnit::Metre),
        "µm" | "μm" => Some(LengthUnit::Micrometre),
        symbol => LengthUnit::of_symbol(symbol),
    }
}

fn bare(text: &str) -> &str {
    text.trim().trim_matches(['[', ']', '(', ')']).trim()
}
