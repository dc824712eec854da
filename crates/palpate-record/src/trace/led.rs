//! The recorded motion of the devices of a world: a table with a time, and three numbers for each device or seven for one that
//! turns.

use std::io::Read;

use palpate_files::bounded::TABLE;

use thiserror::Error;

/// A recorded motion of so many devices in space.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldTrace {
    /// Time of each sample, from 0, strictly increasing `[s]`.
    pub t_s: Vec<f64>,
    /// Position of each device at each sample: `[sample][device]` `[m]`.
    pub positions_m: Vec<Vec<[f64; 3]>>,
    /// How each device is turned at each sample, a unit quaternion `[w, x, y, z]`, not turned where it does not turn; empty if
    /// none does.
    pub orientations: Vec<Vec<[f64; 4]>>,
}

/// Largest number of a motion, on either side of 0, as in scene files: differences and squares are finite.
const LARGEST: f64 = 1e12;
/// A quaternion in a table may be so much longer or shorter than 1: it has few digits.
const LENGTH_SLACK: f64 = 1e-3;
const NOT_TURNED: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// Why the motion of a world's devices cannot be read.
#[derive(Debug, Error)]
#[error("{file}{}: {fault}", line.map_or_else(String::new, |line| format!(":{line}")))]
#[non_exhaustive]
pub struct WorldTraceError {
    /// The name the caller gave.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// What is wrong, and what is allowed.
    pub fault: String,
}

/// Reads a table whose first column is `t` or `t_s` `[s]` and whose others are x, y and z `[m]` of each device, in the order
/// of the scene; of a device that turns also qw, qx, qy and qz, a quaternion of about length 1. `turns` says for each device whether
/// it turns. Times count from the first one.
///
/// # Errors
/// What cannot be read, another number of columns, a field that is no finite number, times that do not increase, a quaternion of
/// another length, fewer than two samples.
pub fn read_world(
    reader: impl Read,
    file: &str,
    turns: &[bool],
) -> Result<WorldTrace, WorldTraceError> {
    let fault = |line: Option<u64>, fault: String| WorldTraceError {
        file: file.to_owned(),
        line,
        fault,
    };
    let mut csv = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(TABLE.reader(reader));
    let unread = |error: csv::Error| {
        let line = error.position().map(csv::Position::line);
        fault(line, error.to_string())
    };
    let header = csv.headers().map_err(unread)?.clone();
    let columns = |turns: &bool| if *turns { 7 } else { 3 };
    let asked = 1 + turns.iter().map(columns).sum::<usize>();
    let first = header.get(0).unwrap_or_default();
    if !["t", "t_s"].contains(&first) || header.len() != asked {
        let given: Vec<_> = header.iter().collect();
        return Err(fault(
            Some(1),
            format!(
                "the columns are \"{}\"; allowed are t [s] and, of each device, {}, {asked} columns in all",
                given.join(","),
                turns
                    .iter()
                    .map(|turns| if *turns {
                        "x,y,z [m] and qw,qx,qy,qz"
                    } else {
                        "x,y,z [m]"
                    })
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        ));
    }
    let mut trace = WorldTrace {
        t_s: Vec::new(),
        positions_m: Vec::new(),
        orientations: Vec::new(),
    };
    let mut start = 0.0;
    for record in csv.records() {
        let record = record.map_err(unread)?;
        let line = record.position().map(csv::Position::line);
        let mut numbers = Vec::with_capacity(asked);
        for (field, column) in record.iter().zip(&header) {
            let is_allowed = |number: &f64| number.abs() <= LARGEST;
            let number = field.parse().ok().filter(is_allowed);
            numbers.push(number.ok_or_else(|| {
                fault(
                    line,
                    format!(
                        "{column} is \"{field}\", and has to be a number between -1e12 and 1e12"
                    ),
                )
            })?);
        }
        let time = numbers[0];
        if trace.t_s.is_empty() {
            start = time;
        }
        let time = time - start;
        if let Some(last) = trace.t_s.last()
            && time <= *last
        {
            let before = last + start;
            return Err(fault(
                line,
                format!(
                    "{first} is {}, and has to be above that before, {before}",
                    numbers[0]
                ),
            ));
        }
        trace.t_s.push(time);
        let (mut places, mut orientations) = (Vec::new(), Vec::new());
        let mut rest = &numbers[1..];
        for does_turn in turns {
            let of_device;
            (of_device, rest) = rest.split_at(columns(does_turn));
            places.push([of_device[0], of_device[1], of_device[2]]);
            let Some(&[w, x, y, z]) = of_device.get(3..7) else {
                orientations.push(NOT_TURNED);
                continue;
            };
            let length = (w * w + x * x + y * y + z * z).sqrt();
            if (length - 1.0).abs().is_nan() || (length - 1.0).abs() > LENGTH_SLACK {
                return Err(fault(
                    line,
                    format!(
                        "qw,qx,qy,qz is a quaternion of length {length}, and needs one of length 1"
                    ),
                ));
            }
            orientations.push([w, x, y, z].map(|part| part / length));
        }
        trace.positions_m.push(places);
        if turns.contains(&true) {
            trace.orientations.push(orientations);
        }
    }
    if trace.t_s.len() < 2 {
        let count = trace.t_s.len();
        return Err(fault(
            None,
            format!("there are {count} samples, and at least 2 are needed"),
        ));
    }
    Ok(trace)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, devices: usize) -> Result<WorldTrace, String> {
        let turns = vec![false; devices];
        read_world(text.as_bytes(), "m.csv", &turns).map_err(|error| error.to_string())
    }

    #[test]
    fn the_places_of_all_devices_are_read_and_times_count_from_the_first() {
        let trace = read("t,x,y,z,x,y,z\n1.5,1,2,3,4,5,6\n1.75,1,2,3,4,5,7\n", 2).unwrap();
        assert_eq!(trace.t_s, [0.0, 0.25]);
        assert_eq!(trace.positions_m[1], [[1.0, 2.0, 3.0], [4.0, 5.0, 7.0]]);
        assert!(trace.orientations.is_empty());
    }

    #[test]
    fn a_device_that_turns_has_a_quaternion() {
        let read = |text: &str| {
            read_world(text.as_bytes(), "m.csv", &[false, true]).map_err(|error| error.to_string())
        };
        let header = "t,x,y,z,x,y,z,qw,qx,qy,qz\n";
        let rows = "0,1,2,3,4,5,6,0.6,0,0.8003,0\n1,1,2,3,4,5,7,1,0,0,0\n";
        let trace = read(&format!("{header}{rows}")).unwrap();
        assert_eq!(trace.positions_m[1], [[1.0, 2.0, 3.0], [4.0, 5.0, 7.0]]);
        let [first, second] = [0, 1].map(|device| trace.orientations[0][device]);
        assert_eq!(first, NOT_TURNED);
        let length: f64 = second.iter().map(|part| part * part).sum();
        assert!((length - 1.0).abs() < 1e-15 && (second[2] - 0.8).abs() < 2e-4);
        let short = read(&format!("{header}0,1,2,3,4,5,6,0.5,0,0,0\n"));
        assert!(
            short
                .unwrap_err()
                .contains("m.csv:2: qw,qx,qy,qz is a quaternion of length 0.5")
        );
        let few = read("t,x,y,z,x,y,z\n0,1,2,3,4,5,6\n").unwrap_err();
        assert!(
            few.contains("of each device, x,y,z [m], x,y,z [m] and qw,qx,qy,qz, 11 columns in all"),
            "{few}"
        );
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, devices, said) in [
            (
                "time,x,y,z\n0,0,0,0\n",
                1,
                "m.csv:1: the columns are \"time,x,y,z\"",
            ),
            ("t,x,y,z\n0,0,0,0\n", 2, "7 columns in all"),
            ("t,x,y,z\n0,0,0,0\n1,0,nan,0\n", 1, "m.csv:3: y is \"nan\""),
            ("t,x,y,z\n0,0,0,-2e12\n", 1, "m.csv:2: z is \"-2e12\""),
            ("t,x,y,z\n0,0,0,0\n0,0,0,0\n", 1, "m.csv:3: t is 0"),
            ("t,x,y,z\n0,0,0,0\n", 1, "there are 1 samples"),
            ("t,x,y,z\n0,0,0\n", 1, "m.csv:2"),
        ] {
            let error = read(text, devices).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
