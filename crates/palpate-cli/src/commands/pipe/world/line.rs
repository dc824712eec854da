//! What a line of the input of a world is: the positions of all devices, a header, or neither.

use palpate_record::unit::LengthUnit;
use palpate_world::Vector;

use super::super::line::Refusal;

/// What the lines hold, as the flags say it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Format {
    /// Whether a time stands before the positions.
    pub time: bool,
    /// Unit of the positions.
    pub unit: LengthUnit,
    /// Whether the unit was said by a flag.
    pub is_unit_given: bool,
    /// Names of the devices, in the order in which their positions stand in a line.
    pub devices: Vec<String>,
}

/// A line that was understood.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// Time `[s]`, if the lines have one.
    pub time: Option<f64>,
    /// Position of each device `[m]`.
    pub positions: Vec<Vector>,
}

impl Format {
    /// The columns of the input.
    pub fn columns(&self) -> Vec<String> {
        let unit = self.unit.position_column().trim_start_matches("position_");
        let time = self.time.then(|| "t_s".to_owned());
        let positions = named(&self.devices, |axis| format!("{axis}_{unit}"));
        time.into_iter().chain(positions).collect()
    }

    /// The columns of the output.
    pub fn forces(&self) -> Vec<String> {
        named(&self.devices, |axis| format!("f{axis}_n"))
    }

    /// Whether a line is the header of these columns.
    pub fn is_header(&self, text: &str) -> bool {
        text.split(',').map(str::trim).eq(self.columns())
    }

    /// What a line says.
    ///
    /// # Errors
    /// It is no sample.
    pub fn parse(&self, text: &str) -> Result<Sample, Refusal> {
        let shape = format!("`{}`", self.columns().join(","));
        if text.is_empty() {
            let why = format!("the line is empty; a line is {shape}");
            return Err(Refusal::Line(why));
        }
        if text.split_whitespace().next() == Some("set") {
            let why = "a world takes no changes while it runs";
            return Err(Refusal::Line(why.into()));
        }
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let mut numbers = Vec::with_capacity(fields.len());
        for field in &fields {
            let number: f64 = field.parse().map_err(|_| {
                let field = field.escape_debug();
                Refusal::Line(format!("\"{field}\" is not a number; a line is {shape}"))
            })?;
            numbers.push(number);
        }
        let (time, positions) = match (self.time, numbers.split_first()) {
            (true, Some((&time, positions))) => (Some(time), positions),
            _ => (None, numbers.as_slice()),
        };
        let (positions, rest) = positions.as_chunks::<3>();
        if positions.len() != self.devices.len() || !rest.is_empty() {
            return Err(Refusal::Stream(format!(
                "`{text}` has {} columns, and a line is {shape}: write decimals with a point, as in \
                 0.001{}",
                fields.len(),
                if self.time {
                    ""
                } else {
                    ", and add --time if a time stands before the positions"
                }
            )));
        }
        if time.is_some_and(|time| !time.is_finite()) {
            return Err(Refusal::Line("the time is not a finite number".into()));
        }
        let metres = |position: &Vector| position.map(|part| self.unit.metres(part));
        Ok(Sample {
            time,
            positions: positions.iter().map(metres).collect(),
        })
    }
}

/// A column for each axis of each device; of several devices with the device's name.
fn named(devices: &[String], column: impl Fn(char) -> String) -> Vec<String> {
    let columns = devices.iter().flat_map(|device| {
        let column = &column;
        ['x', 'y', 'z'].map(|axis| match devices {
            [_] => column(axis),
            _ => format!("{device}.{}", column(axis)),
        })
    });
    columns.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(devices: &[&str], time: bool) -> Format {
        Format {
            time,
            unit: LengthUnit::Metre,
            is_unit_given: false,
            devices: devices.iter().map(|&name| name.to_owned()).collect(),
        }
    }

    #[test]
    fn a_line_has_a_position_for_each_device() {
        let sample = of(&["tool"], false).parse("0, 0.001, -2e-3").unwrap();
        assert_eq!(sample.positions, [[0.0, 0.001, -0.002]]);
        let two = of(&["thumb", "finger"], true).parse("0.5,1,2,3,4,5,6");
        let two = two.unwrap();
        assert_eq!(two.time, Some(0.5));
        assert_eq!(two.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let millimetres = Format {
            unit: LengthUnit::Millimetre,
            ..of(&["tool"], false)
        };
        let sample = millimetres.parse("1,2,3").unwrap();
        assert_eq!(sample.positions, [[0.001, 0.002, 0.003]]);
    }

    #[test]
    fn the_columns_are_named_by_their_device_where_there_are_several() {
        let one = of(&["tool"], true);
        assert_eq!(one.columns(), ["t_s", "x_m", "y_m", "z_m"]);
        assert_eq!(one.forces(), ["fx_n", "fy_n", "fz_n"]);
        assert!(one.is_header("t_s, x_m, y_m, z_m"));
        assert!(!one.is_header("0,1,2,3"));
        let two = of(&["thumb", "finger"], false);
        assert_eq!(two.forces()[3], "finger.fx_n");
    }

    #[test]
    fn lines_of_other_columns_end_the_stream_and_unreadable_ones_are_refused_alone() {
        let tool = of(&["tool"], false);
        for text in ["1,2", "1,2,3,4", "0.001", "0,1,0,2,0,3"] {
            let Err(Refusal::Stream(why)) = tool.parse(text) else {
                panic!("{text}")
            };
            assert!(
                why.contains("a point") && why.contains("x_m,y_m,z_m"),
                "{why}"
            );
        }
        for text in ["", "a,b,c", "1,2,", "set stiffness_n_per_m=5"] {
            assert!(matches!(tool.parse(text), Err(Refusal::Line(_))), "{text}");
        }
    }
}
