//! Recorded motion of the devices of a world: a table with a time, and three numbers per device, or seven for one
//! that rotates.

use std::io::Read;

use super::columns::{Kind, Wanted};
use super::fault::{TraceError, TraceFault};
use super::layout::Layout;
use super::table::{Request, Text};
use super::{Part, ReadNotes};

/// A recorded motion of several devices in space.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldTrace {
    /// Time of each sample, from 0, strictly increasing `[s]`.
    pub t_s: Vec<f64>,
    /// Position of each device at each sample: `[sample][device]` `[m]`.
    pub positions_m: Vec<Vec<[f64; 3]>>,
    /// Orientation of each device at each sample, a unit quaternion `[w, x, y, z]`, the identity for a device that
    /// does not rotate; empty if no device rotates.
    pub orientations: Vec<Vec<[f64; 4]>>,
    /// Notes on the text.
    pub notes: ReadNotes,
}

/// A device of a world whose motion is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LedDevice {
    /// Its name.
    pub name: String,
    /// Whether it rotates.
    pub turns: bool,
}

/// Largest magnitude of a number of a motion, as in scene files: differences and squares are finite.
const LARGEST: f64 = 1e12;
/// Allowed deviation of a quaternion's norm from 1, because tables have few digits.
const LENGTH_SLACK: f64 = 1e-3;
const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
const AXES: [&str; 3] = ["x", "y", "z"];
const PARTS: [&str; 4] = ["qw", "qx", "qy", "qz"];

/// Reads a part of a table. Its columns are a time, `t` or `t_s` `[s]`, and x, y and z `[m]` of each device. The
/// columns of several devices are in the order of the scene or have the device's name, such as `left.x`. A device
/// that rotates also has qw, qx, qy and qz, a quaternion of norm 1 within rounding. Names may have units, such as
/// `x_mm`; a layout overrides these rules. Times count from the first one.
///
/// # Errors
/// The text cannot be read, a column is missing or duplicate, a field is not a finite number, times do not increase,
/// a quaternion does not have norm 1, or there are fewer than two samples.
pub fn read_world(
    reader: impl Read,
    file: &str,
    part: &Part,
    layout: &Layout,
    devices: &[LedDevice],
) -> Result<WorldTrace, TraceError> {
    let wanted = wanted(devices);
    let names: Vec<String> = wanted.iter().map(|wanted| wanted.keys[0].clone()).collect();
    let needed = format!("t [s] and {} [positions in m]", names.join(", "));
    let check = |numbers: &[f64]| wrong(numbers, &wanted, devices);
    let request = Request {
        part,
        layout,
        wanted: &wanted,
        needed: &needed,
        check: &check,
    };
    let samples = Text::new(reader, file, layout).samples(&request)?;
    let start = samples.t_s[0];
    let mut trace = WorldTrace {
        t_s: samples.t_s.iter().map(|time| time - start).collect(),
        positions_m: Vec::with_capacity(samples.t_s.len()),
        orientations: Vec::new(),
        notes: samples.notes,
    };
    let does_turn = devices.iter().any(|device| device.turns);
    for numbers in samples.numbers.chunks_exact(wanted.len()) {
        let (mut places, mut orientations) = (Vec::new(), Vec::new());
        let mut rest = numbers;
        for device in devices {
            let (place, after) = rest.split_at(AXES.len());
            places.push([place[0], place[1], place[2]]);
            rest = after;
            let mut orientation = IDENTITY;
            if device.turns {
                let (turned, after) = rest.split_at(PARTS.len());
                let length = length(turned);
                orientation =
                    [turned[0], turned[1], turned[2], turned[3]].map(|part| part / length);
                rest = after;
            }
            orientations.push(orientation);
        }
        trace.positions_m.push(places);
        if does_turn {
            trace.orientations.push(orientations);
        }
    }
    Ok(trace)
}

/// Returns the columns of all devices.
fn wanted(devices: &[LedDevice]) -> Vec<Wanted> {
    let turning = devices.iter().filter(|device| device.turns).count();
    let mut turned = 0;
    let mut wanted = Vec::new();
    for (number, device) in devices.iter().enumerate() {
        let column = |kind, name: &str, nth| {
            let called = format!("{}.{name}", device.name);
            let names = vec![called.clone(), name.to_owned()];
            let keys = if devices.len() == 1 {
                vec![name.to_owned(), called]
            } else {
                vec![called]
            };
            Wanted {
                kind,
                keys,
                bare: names.clone(),
                stems: names,
                nth,
                shown: name.to_owned(),
                is_needed: true,
            }
        };
        let places = AXES.map(|axis| column(Kind::Length, axis, (number, devices.len())));
        wanted.extend(places);
        if device.turns {
            wanted.extend(PARTS.map(|part| column(Kind::Part, part, (turned, turning))));
            turned += 1;
        }
    }
    wanted
}

/// Returns a fault in the numbers of a sample, with its column.
fn wrong(numbers: &[f64], wanted: &[Wanted], devices: &[LedDevice]) -> Option<(usize, TraceFault)> {
    if let Some(at) = numbers.iter().position(|number| number.abs() > LARGEST) {
        let fault = TraceFault::TooLarge {
            name: wanted[at].shown.clone(),
            text: numbers[at].to_string(),
        };
        return Some((at, fault));
    }
    let mut at = 0;
    for device in devices {
        at += AXES.len();
        if device.turns {
            let length = length(&numbers[at..at + PARTS.len()]);
            if (length - 1.0).abs().is_nan() || (length - 1.0).abs() > LENGTH_SLACK {
                return Some((at, TraceFault::Quaternion { length }));
            }
            at += PARTS.len();
        }
    }
    None
}

fn length(parts: &[f64]) -> f64 {
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn devices(turns: &[bool]) -> Vec<LedDevice> {
        let devices = turns.iter().zip(["left", "right"]);
        devices
            .map(|(&turns, name)| LedDevice {
                name: name.into(),
                turns,
            })
            .collect()
    }

    fn read_laid_out(text: &str, turns: &[bool], layout: &Layout) -> Result<WorldTrace, String> {
        let devices = devices(turns);
        read_world(text.as_bytes(), "m.csv", &Part::WHOLE, layout, &devices)
            .map_err(|error| error.to_string())
    }

    fn read(text: &str, count: usize) -> Result<WorldTrace, String> {
        read_laid_out(text, &[false, false][..count], &Layout::default())
    }

    #[test]
    fn the_places_of_all_devices_are_read_and_times_count_from_the_first() {
        let trace = read("t,x,y,z,x,y,z\n1.5,1,2,3,4,5,6\n1.75,1,2,3,4,5,7\n", 2).unwrap();
        assert_eq!(trace.t_s, [0.0, 0.25]);
        assert_eq!(trace.positions_m[1], [[1.0, 2.0, 3.0], [4.0, 5.0, 7.0]]);
        assert!(trace.orientations.is_empty());
    }

    #[test]
    fn columns_are_found_by_name_unit_and_device() {
        // In any order, with units, with other columns, and with the device's name.
        let trace = read("z_mm,force,t_ms,y_mm,x_mm\n3,9,0,2,1\n3,9,1,2,1\n", 1).unwrap();
        assert_eq!(trace.t_s, [0.0, 0.001]);
        assert_eq!(trace.positions_m[0], [[0.001, 0.002, 0.003]]);
        let rows = "0,4,5,6,1,2,3\n1,4,5,6,1,2,3\n";
        let named = format!("t,right.x,right.y,right.z,left.x,left.y,left.z\n{rows}");
        assert_eq!(
            read(&named, 2).unwrap().positions_m[0],
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        );
        let mapped = Layout {
            columns: Layout::parse_columns(
                "t=#1,left.x=A,left.y=B,left.z=C,right.x=a,right.y=b,right.z=c",
            )
            .unwrap(),
            ..Layout::default()
        };
        let trace = read_laid_out(
            &format!("time,a,b,c,A,B,C\n{rows}"),
            &[false, false],
            &mapped,
        );
        assert_eq!(
            trace.unwrap().positions_m[0],
            [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
        );
        // The columns of a single device are ambiguous in a table of two.
        let twice = read(&format!("t,x,y,z,x,y,z\n{rows}"), 1).unwrap_err();
        assert!(
            twice.contains("m.csv:1:9: the header names the column `x` twice"),
            "{twice}"
        );
        let shared = Layout {
            columns: Layout::parse_columns("x=a,y=a,z=c").unwrap(),
            ..Layout::default()
        };
        let error = read_laid_out("t,a,c\n0,0,0\n", &[false], &shared).unwrap_err();
        let said = "m.csv:1:3: the column `a` is selected as `x` and as `y`; select another column";
        assert!(error.contains(said), "{error}");
        let unknown = Layout {
            columns: vec![("w".into(), "a".into())],
            ..Layout::default()
        };
        let error = read_laid_out("t,x,y,z\n0,0,0,0\n", &[false], &unknown).unwrap_err();
        assert!(
            error.contains("given as `w`") && error.contains("allowed: t, x, y, z"),
            "{error}"
        );
    }

    #[test]
    fn a_device_that_turns_has_a_quaternion() {
        let read = |text: &str| read_laid_out(text, &[false, true], &Layout::default());
        let header = "t,x,y,z,x,y,z,qw,qx,qy,qz\n";
        let rows = "0,1,2,3,4,5,6,0.6,0,0.8003,0\n1,1,2,3,4,5,7,1,0,0,0\n";
        let trace = read(&format!("{header}{rows}")).unwrap();
        assert_eq!(trace.positions_m[1], [[1.0, 2.0, 3.0], [4.0, 5.0, 7.0]]);
        let [first, second] = [0, 1].map(|device| trace.orientations[0][device]);
        assert_eq!(first, IDENTITY);
        let length: f64 = second.iter().map(|part| part * part).sum();
        assert!((length - 1.0).abs() < 1e-15 && (second[2] - 0.8).abs() < 2e-4);
        let short = read(&format!("{header}0,1,2,3,4,5,6,0.5,0,0,0\n")).unwrap_err();
        assert!(
            short.contains("m.csv:2:15: qw,qx,qy,qz is a quaternion of length 0.5"),
            "{short}"
        );
        let few = read("t,x,y,z,x,y,z\n0,1,2,3,4,5,6\n").unwrap_err();
        assert!(few.contains("the header has no column `qw`"), "{few}");
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, devices, said) in [
            (
                "time,x,y,z\n0,0,0,0\n",
                1,
                "m.csv:1:1: the header has no column `t_s`",
            ),
            (
                "t,x,y,z\n0,0,0,0\n",
                2,
                "names the column `x` 1 times; 2 are needed",
            ),
            ("t,a,b,c\n0,0,0,0\n", 1, "no column `x`"),
            (
                "t,x,y,z\n0,0,0,0\n1,0,nan,0\n",
                1,
                "m.csv:3:5: `nan` in column `y`",
            ),
            (
                "t,x,y,z\n0,0,0,-2e12\n",
                1,
                "m.csv:2:7: `-2000000000000` in column `z`",
            ),
            (
                "t,x,y,z\n0,0,0,0\n0,0,0,0\n",
                1,
                "m.csv:3:1: the time 0 s does not come",
            ),
            ("t,x,y,z\n0,0,0,0\n", 1, "this one has 1"),
            ("t,x,y,z\n0,0,0\n", 1, "m.csv:2"),
        ] {
            let error = read(text, devices).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
