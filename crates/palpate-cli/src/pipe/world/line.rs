//! Parser of an input line of a world: the positions of all devices, or a header.

use palpate_record::unit::LengthUnit;
use palpate_world::{IDENTITY, Quaternion, Vector};

use crate::pipe::line::{Refusal, check_size, is_named, is_word};

/// Format of the lines, from the flags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorldFormat {
    /// Whether a time precedes the positions.
    pub time: bool,
    /// Unit of the positions.
    pub unit: LengthUnit,
    /// Whether a flag set the unit.
    pub is_unit_given: bool,
    /// Whether the slope of the force follows each force.
    pub slopes: bool,
    /// The devices, in the order of their positions in a line.
    pub devices: Vec<DeviceColumns>,
}

/// Columns of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceColumns {
    /// Name of the device.
    pub name: String,
    /// Whether the device measures six axes: an orientation follows the position.
    pub turns: bool,
    /// Whether the device outputs a torque, which follows the force.
    pub gives_torque: bool,
}

/// A valid line.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSample {
    /// Time `[s]`, if the lines have one.
    pub time: Option<f64>,
    /// Position of each device `[m]`.
    pub positions: Vec<Vector>,
    /// Orientation of each device, `[w, x, y, z]`.
    pub orientations: Vec<Quaternion>,
}

impl WorldFormat {
    /// Returns the columns of the input.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let unit = self.unit.position_column().trim_start_matches("position_");
        let time = self.time.then(|| "t_s".to_owned());
        let positions = named(
            &self.devices,
            |axis| format!("{axis}_{unit}"),
            |device| device.turns.then_some(&["qw", "qx", "qy", "qz"][..]),
        );
        time.into_iter().chain(positions).collect()
    }

    /// Returns the columns of the output.
    #[must_use]
    pub fn forces(&self) -> Vec<String> {
        let torques = ["tx_n_m", "ty_n_m", "tz_n_m"];
        let slopes = ["sx_n_per_s", "sy_n_per_s", "sz_n_per_s"];
        named(
            &self.devices,
            |axis| format!("f{axis}_n"),
            |device| match (self.slopes, device.gives_torque) {
                // A line excludes torques.
                (true, _) => Some(&slopes[..]),
                (false, gives_torque) => gives_torque.then_some(&torques[..]),
            },
        )
    }

    /// Whether the first line is the header of these columns.
    ///
    /// # Errors
    /// The header has other columns, another order or another unit.
    pub fn is_header(&self, text: &str) -> Result<bool, String> {
        let names: Vec<&str> = text.split(',').map(str::trim).collect();
        let columns = self.columns();
        if names == columns || (is_word(text) && text != "set") {
            return Ok(true);
        }
        if names.len() > 1 && names.iter().all(|name| is_named(name)) {
            return Err(format!(
                "the header has the columns `{}`; expected `{}`, in this order: --unit sets the unit, --time adds \
                 a time before the positions",
                text.escape_debug(),
                columns.join(",")
            ));
        }
        Ok(false)
    }

    /// Parses a line.
    ///
    /// # Errors
    /// The line is not a sample.
    pub fn parse(&self, text: &str) -> Result<WorldSample, Refusal> {
        let shape = format!("`{}`", self.columns().join(","));
        if text.is_empty() {
            let why = format!("the line is empty; expected {shape}");
            return Err(Refusal::Line(why));
        }
        if text.split_whitespace().next() == Some("set") {
            let why = "`set` is not available for a world";
            return Err(Refusal::Line(why.into()));
        }
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let mut numbers = Vec::with_capacity(fields.len());
        for field in &fields {
            let number: f64 = field.parse().map_err(|_| {
                let field = field.escape_debug();
                Refusal::Line(format!("\"{field}\" is not a number; expected {shape}"))
            })?;
            numbers.push(number);
        }
        let (time, positions) = match (self.time, numbers.split_first()) {
            (true, Some((&time, positions))) => (Some(time), positions),
            _ => (None, numbers.as_slice()),
        };
        let of = |device: &DeviceColumns| if device.turns { 7 } else { 3 };
        let asked: usize = self.devices.iter().map(of).sum();
        if positions.len() != asked {
            return Err(Refusal::Stream(format!(
                "`{text}` has {} columns; expected {shape}: write decimals with a point, as in \
                 0.001{}",
                fields.len(),
                if self.time {
                    ""
                } else {
                    ", and add --time if a time precedes the positions"
                }
            )));
        }
        if time.is_some_and(|time| !time.is_finite()) {
            return Err(Refusal::Line("the time is not a finite number".into()));
        }
        let mut sample = WorldSample {
            time,
            positions: Vec::with_capacity(self.devices.len()),
            orientations: Vec::with_capacity(self.devices.len()),
        };
        let mut numbers = positions.iter().copied();
        // The count has been checked above.
        let mut next = || numbers.next().unwrap_or(f64::NAN);
        for device in &self.devices {
            let position: Vector = std::array::from_fn(|_| next());
            let metres = position.map(|part| self.unit.metres(part));
            for part in metres {
                check_size(&format!("a position of {}", device.name), part, "m")?;
            }
            sample.positions.push(metres);
            sample.orientations.push(if device.turns {
                std::array::from_fn(|_| next())
            } else {
                IDENTITY
            });
        }
        Ok(sample)
    }
}

/// Returns a column for each axis of each device, and its columns `more`. With several devices, the names of the
/// columns contain the device's name.
fn named<'m>(
    devices: &[DeviceColumns],
    column: impl Fn(char) -> String,
    more: impl Fn(&DeviceColumns) -> Option<&'m [&'m str]>,
) -> Vec<String> {
    let columns = devices.iter().flat_map(|device| {
        let more = more(device).unwrap_or_default();
        let more = more.iter().map(ToString::to_string);
        let own = ['x', 'y', 'z'].map(&column).into_iter().chain(more);
        own.map(|column| match devices {
            [_] => column,
            _ => format!("{}.{column}", device.name),
        })
    });
    columns.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(devices: &[&str], time: bool) -> WorldFormat {
        WorldFormat {
            time,
            unit: LengthUnit::Metre,
            is_unit_given: false,
            slopes: false,
            devices: devices
                .iter()
                .map(|&name| DeviceColumns {
                    name: name.to_owned(),
                    turns: false,
                    gives_torque: false,
                })
                .collect(),
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
        let millimetres = WorldFormat {
            unit: LengthUnit::Millimetre,
            ..of(&["tool"], false)
        };
        let sample = millimetres.parse("1,2,3").unwrap();
        assert_eq!(sample.positions, [[0.001, 0.002, 0.003]]);
    }

    #[test]
    fn a_device_of_six_axes_has_an_orientation_and_a_torque() {
        let mut format = of(&["tool", "finger"], false);
        format.devices[0].turns = true;
        format.devices[0].gives_torque = true;
        let sample = format.parse("1,2,3,0.8,0.6,0,0,4,5,6").unwrap();
        assert_eq!(sample.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!(sample.orientations, [[0.8, 0.6, 0.0, 0.0], IDENTITY]);
        let columns = "tool.x_m,tool.y_m,tool.z_m,tool.qw,tool.qx,tool.qy,tool.qz,finger.x_m,finger.y_m,finger.z_m";
        assert_eq!(format.columns().join(","), columns);
        assert_eq!(
            format.forces()[3..7],
            ["tool.tx_n_m", "tool.ty_n_m", "tool.tz_n_m", "finger.fx_n"]
        );
        assert!(matches!(
            format.parse("1,2,3,4,5,6"),
            Err(Refusal::Stream(_))
        ));
        // A tool that is turned by the hand has no torque.
        format.devices[0].gives_torque = false;
        assert_eq!(format.columns().join(","), columns);
        assert_eq!(format.forces()[2..4], ["tool.fz_n", "finger.fx_n"]);
    }

    #[test]
    fn the_columns_are_named_by_their_device_where_there_are_several() {
        let one = of(&["tool"], true);
        assert_eq!(one.columns(), ["t_s", "x_m", "y_m", "z_m"]);
        assert_eq!(one.forces(), ["fx_n", "fy_n", "fz_n"]);
        assert_eq!(one.is_header("t_s, x_m, y_m, z_m"), Ok(true));
        assert_eq!(one.is_header("ready"), Ok(true));
        for text in ["0,1,2,3", "nan,nan,nan", "set", "", "x_m,1,2,3"] {
            assert_eq!(one.is_header(text), Ok(false), "{text}");
        }
        let two = of(&["thumb", "finger"], false);
        assert_eq!(two.forces()[3], "finger.fx_n");
        let lines = WorldFormat {
            slopes: true,
            ..two
        };
        assert_eq!(lines.forces()[2..4], ["thumb.fz_n", "thumb.sx_n_per_s"]);
    }

    #[test]
    fn a_header_of_another_order_or_unit_is_refused_for_every_line_after_it_would_be_wrong() {
        let two = of(&["left", "right"], false);
        let [left, right] = ["left", "right"].map(|name| {
            ["x", "y", "z"]
                .map(|axis| format!("{name}.{axis}_m"))
                .join(",")
        });
        assert_eq!(two.is_header(&format!("{left},{right}")), Ok(true));
        for text in [
            format!("{right},{left}"),
            format!("{left},{right}").replace("_m", "_mm"),
            format!("t_s,{left},{right}"),
            left.clone(),
            "x,y,z,x,y,z".to_owned(),
        ] {
            let why = two.is_header(&text).expect_err(&text);
            assert!(
                why.contains(&text) && why.contains("in this order"),
                "{why}"
            );
        }
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
