//! The recorded motion of the devices of a world: a table with a time and three numbers for each device.

use std::io::Read;

use palpate_files::bounded::TABLE;

use thiserror::Error;

/// A recorded motion of so many devices in space.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldTrace {
    /// Time of each sample, from 0, strictly increasing \[s\].
    pub t_s: Vec<f64>,
    /// Position of each device at each sample: `[sample][device]` \[m\].
    pub positions_m: Vec<Vec<[f64; 3]>>,
}

/// Why the motion of a world's devices cannot be read.
#[derive(Debug, Error)]
#[error("{file}{}: {fault}", line.map_or_else(String::new, |line| format!(":{line}")))]
pub struct WorldTraceError {
    /// The name the caller gave.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// What is wrong, and what is allowed.
    pub fault: String,
}

/// Reads a table whose first column is `t` or `t_s` \[s\] and whose others are x, y and z \[m\] of each device, in the order
/// of the scene. Times count from the first one.
///
/// # Errors
/// What cannot be read, another number of columns, a field that is no finite number, times that do not increase, fewer than
/// two samples.
pub fn read_world(
    reader: impl Read,
    file: &str,
    devices: usize,
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
    let asked = 1 + 3 * devices;
    let first = header.get(0).unwrap_or_default();
    if !["t", "t_s"].contains(&first) || header.len() != asked {
        let given: Vec<_> = header.iter().collect();
        return Err(fault(
            Some(1),
            format!(
                "the columns are \"{}\"; allowed are t [s] and x,y,z [m] of {devices} device(s), {asked} columns in all",
                given.join(",")
            ),
        ));
    }
    let mut trace = WorldTrace {
        t_s: Vec::new(),
        positions_m: Vec::new(),
    };
    let mut start = 0.0;
    for record in csv.records() {
        let record = record.map_err(unread)?;
        let line = record.position().map(csv::Position::line);
        let mut numbers = Vec::with_capacity(asked);
        for (field, column) in record.iter().zip(&header) {
            let number = field.parse().ok().filter(|number: &f64| number.is_finite());
            numbers.push(number.ok_or_else(|| {
                fault(
                    line,
                    format!("{column} is \"{field}\", and has to be a finite number"),
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
        let places = numbers[1..].chunks_exact(3);
        let places = places.map(|place| [place[0], place[1], place[2]]);
        trace.positions_m.push(places.collect());
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
        read_world(text.as_bytes(), "m.csv", devices).map_err(|error| error.to_string())
    }

    #[test]
    fn the_places_of_all_devices_are_read_and_times_count_from_the_first() {
        let trace = read("t,x,y,z,x,y,z\n1.5,1,2,3,4,5,6\n1.75,1,2,3,4,5,7\n", 2).unwrap();
        assert_eq!(trace.t_s, [0.0, 0.25]);
        assert_eq!(trace.positions_m[1], [[1.0, 2.0, 3.0], [4.0, 5.0, 7.0]]);
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
            ("t,x,y,z\n0,0,0,0\n0,0,0,0\n", 1, "m.csv:3: t is 0"),
            ("t,x,y,z\n0,0,0,0\n", 1, "there are 1 samples"),
            ("t,x,y,z\n0,0,0\n", 1, "m.csv:2"),
        ] {
            let error = read(text, devices).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
