//! A line of a map.

use super::Format;

/// One method on one plant in one cell. Pairs are `[median, worst]` over the start heights.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Index of the cell, counted from 0.
    pub cell: u64,
    /// K T²/m
    pub kappa: f64,
    /// K T²/M; 0 for a wall.
    pub object_kappa: f64,
    /// K `[N/m]`
    pub stiffness: f64,
    /// M `[kg]`; infinite for a wall.
    pub object_mass: f64,
    /// `undamped` or `damped`.
    pub plant: String,
    /// Name of the method.
    pub method: String,
    /// Growth of the energy per collision; infinite if the loop diverged.
    pub growth: [f64; 2],
    /// Mean-force error E `[%]`.
    pub error: [f64; 2],
    /// Ratio of the force rendering error to the zero-order-hold bound.
    pub error_over_bound: [f64; 2],
    /// Zero-order-hold bound `[%]`.
    pub hold_bound: [f64; 2],
    /// Number of start heights with a stable, growing and diverging loop.
    pub classes: [u64; 3],
    /// Sustained contacts; `None` in a file of [`Format::Bounces`], which does not contain them.
    pub stay: Option<StaySwing>,
}

/// Ratio of the standard deviation of the force of a sustained contact to the pressing force; infinite if the contact
/// was lost or diverged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaySwing {
    /// Ratio for an object that rests on the device by its weight; `None` for a wall.
    pub resting: Option<f64>,
    /// Ratio for a pressed object or wall.
    pub pressed: f64,
}

/// Columns of a line, in order.
pub(super) const COLUMNS: [&str; 20] = [
    "cell",
    "kappa",
    "object_kappa",
    "stiffness_n_per_m",
    "object_mass_kg",
    "plant",
    "method",
    "growth_median",
    "growth_worst",
    "error_percent_median",
    "error_percent_worst",
    "error_over_floor_median",
    "error_over_floor_worst",
    "hold_bound_percent_median",
    "hold_bound_percent_worst",
    "stable",
    "growing",
    "diverged",
    "resting_swing",
    "pressed_swing",
];

/// Splits a line into the fields of the columns and the rest.
pub(super) fn split(line: &str, format: Format) -> Option<(&str, &str)> {
    let (at, _) = line.match_indices(',').nth(format.columns().len() - 1)?;
    Some((&line[..at], &line[at + 1..]))
}

impl Row {
    /// Returns the format of a file with this row.
    pub(super) fn format(&self) -> Format {
        if self.stay.is_some() {
            Format::BouncesAndStays
        } else {
            Format::Bounces
        }
    }

    /// Returns the numeric columns after the names, in order.
    pub(super) fn numbers(&self) -> [f64; 8] {
        let ([a, b], [c, d]) = (self.growth, self.error);
        let ([e, f], [g, h]) = (self.error_over_bound, self.hold_bound);
        [a, b, c, d, e, f, g, h]
    }

    /// Returns the row as text with comma-separated fields.
    #[must_use]
    pub fn to_line(&self) -> String {
        let mut line = self.cell.to_string();
        let mut add = |field: &str| {
            line.push(',');
            line.push_str(field);
        };
        for number in [
            self.kappa,
            self.object_kappa,
            self.stiffness,
            self.object_mass,
        ] {
            add(&text(number));
        }
        add(&self.plant);
        add(&self.method);
        for number in self.numbers() {
            add(&text(number));
        }
        for count in self.classes {
            add(&count.to_string());
        }
        if let Some(stay) = self.stay {
            add(&stay.resting.map(text).unwrap_or_default());
            add(&text(stay.pressed));
        }
        line
    }

    /// Parses the output of [`to_line`](Self::to_line) in this format.
    ///
    /// # Errors
    /// The column with an invalid value.
    pub fn from_line(line: &str, format: Format) -> Result<Self, String> {
        let fields: Vec<&str> = line.split(',').collect();
        let columns = format.columns().len();
        if fields.len() != columns {
            return Err(format!("{} fields, but must have {columns}", fields.len()));
        }
        let wrong = |at: usize, needed: &str| {
            format!("{} is `{}`, but must be {needed}", COLUMNS[at], fields[at])
        };
        let number = |at: usize| match fields[at].parse::<f64>() {
            Ok(number) if !number.is_nan() => Ok(number),
            _ => Err(wrong(at, "a number")),
        };
        let count = |at: usize| fields[at].parse().map_err(|_| wrong(at, "a count"));
        let pair = |at: usize| Ok::<_, String>([number(at)?, number(at + 1)?]);
        let stay = || {
            let is_wall = fields[18].is_empty();
            Ok::<_, String>(StaySwing {
                resting: if is_wall { None } else { Some(number(18)?) },
                pressed: number(19)?,
            })
        };
        Ok(Self {
            cell: count(0)?,
            kappa: number(1)?,
            object_kappa: number(2)?,
            stiffness: number(3)?,
            object_mass: number(4)?,
            plant: fields[5].to_owned(),
            method: fields[6].to_owned(),
            growth: pair(7)?,
            error: pair(9)?,
            error_over_bound: pair(11)?,
            hold_bound: pair(13)?,
            classes: [count(15)?, count(16)?, count(17)?],
            stay: match format {
                Format::Bounces => None,
                Format::BouncesAndStays => Some(stay()?),
            },
        })
    }
}

/// Returns the shortest text that parses to the same bits.
fn text(number: f64) -> String {
    let size = number.abs();
    if size == 0.0 || (1e-5..1e15).contains(&size) || !size.is_finite() {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn row(cell: u64, plant: &str) -> Row {
        Row {
            cell,
            kappa: 0.125,
            object_kappa: 0.0,
            stiffness: 1.0 / 3.0,
            object_mass: f64::INFINITY,
            plant: plant.to_owned(),
            method: "hfcr".to_owned(),
            growth: [0.999, f64::INFINITY],
            error: [1e-9, 1.7e300],
            error_over_bound: [1.0, 2.5],
            hold_bound: [11.0, 12.0],
            classes: [14, 1, 1],
            stay: Some(StaySwing {
                resting: None,
                pressed: 0.0625,
            }),
        }
    }

    #[test]
    fn every_bit_comes_back() {
        let row = row(17, "damped");
        let line = row.to_line();
        let read = |line: &str| Row::from_line(line, Format::BouncesAndStays);
        assert_eq!(read(&line).unwrap(), row);
        let bounces = "17,0.125,0,0.3333333333333333,inf,damped,hfcr,0.999,inf,1e-9,1.7e300,1,2.5,11,12,14,1,1";
        assert_eq!(line, format!("{bounces},,0.0625"));
        let object = Row {
            stay: Some(StaySwing {
                resting: Some(1.0 / 3.0),
                pressed: f64::INFINITY,
            }),
            ..row.clone()
        };
        let line = object.to_line();
        assert_eq!(line, format!("{bounces},0.3333333333333333,inf"));
        assert_eq!(read(&line).unwrap(), object);
    }

    #[test]
    fn a_row_without_contacts_that_stay_is_of_the_older_format() {
        let old = Row {
            stay: None,
            ..row(17, "damped")
        };
        assert_eq!(old.format(), Format::Bounces);
        let line = old.to_line();
        assert_eq!(Row::from_line(&line, Format::Bounces).unwrap(), old);
        assert_eq!(
            Row::from_line(&line, Format::BouncesAndStays).unwrap_err(),
            "18 fields, but must have 20"
        );
    }

    #[test]
    fn a_wrong_field_is_named() {
        let line = row(1, "damped").to_line();
        let fault = |from: &str, to: &str| {
            Row::from_line(&line.replace(from, to), Format::BouncesAndStays).unwrap_err()
        };
        assert_eq!(
            fault("0.999", "fast"),
            "growth_median is `fast`, but must be a number"
        );
        assert_eq!(
            fault("0.999", "NaN"),
            "growth_median is `NaN`, but must be a number"
        );
        assert_eq!(fault(",14", ",-1"), "stable is `-1`, but must be a count");
        assert_eq!(fault(",14", ""), "19 fields, but must have 20");
        assert_eq!(
            fault(",,0.0625", ",,"),
            "pressed_swing is ``, but must be a number"
        );
        assert_eq!(
            fault(",,0.0625", ",NaN,0.0625"),
            "resting_swing is `NaN`, but must be a number"
        );
    }
}
