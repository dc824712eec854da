//! Lines of the protocol: their text, without state. Reading and writing a line does not allocate.

use std::io::Write;
use std::str::{FromStr, SplitAsciiWhitespace};
use std::time::Duration;

use palpate_device::{Capabilities, Vector, Wrench};

/// Version of the protocol.
pub const VERSION: u32 = 1;
/// Longest line `[byte]`, with its end.
pub const LONGEST: usize = 512;

/// Removes the force.
pub const ZERO: &[u8] = b"zero\n";
/// Removes the force in a stream: the first newline ends a line that was not sent completely.
pub const ZERO_IN_A_STREAM: &[u8] = b"\nzero\n";
/// Requests a sample after the loop has ended.
pub const PROBE: &[u8] = b"read 0\n";
/// Shortest answer to a request `[byte]`.
pub const SHORTEST_ANSWER: usize = 8;
/// The last line of a session.
pub const END: &[u8] = b"end\n";

/// Smallest and largest length of an orientation that is accepted.
const UNIT: std::ops::RangeInclusive<f64> = 0.99..=1.01;

/// A line in a buffer of its own.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Text {
    fn new(write: impl FnOnce(&mut &mut [u8]) -> std::io::Result<()>) -> Self {
        let mut bytes = [0; LONGEST];
        let mut rest = &mut bytes[..];
        // The lines below have at most eight numbers of at most 25 bytes.
        let _ = write(&mut rest);
        let left = rest.len();
        Self {
            bytes,
            length: LONGEST.saturating_sub(left),
        }
    }

    /// Returns the bytes of the line with its newline.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// Returns the first line of a session.
pub fn hello(period: Duration, silence: Duration) -> Text {
    let (period, silence) = (period.as_secs_f64(), silence.as_secs_f64());
    Text::new(|to| writeln!(to, "hello {VERSION} period_s={period} silence_s={silence}"))
}

/// Returns the request for a sample.
pub fn read(number: u64) -> Text {
    Text::new(|to| writeln!(to, "read {number}"))
}

/// Returns the command of `wrench` on the axes of the device.
pub fn wrench(number: u64, wrench: &Wrench, device: &Capabilities) -> Text {
    let force = wrench.force.iter().take(device.axes);
    let torque = wrench.torque.iter().take(device.torque_axes);
    Text::new(|to| {
        write!(to, "wrench {number}")?;
        // In full: the device holds what the loop accounts for.
        for part in force.chain(torque) {
            write!(to, " {part:e}")?;
        }
        writeln!(to)
    })
}

/// A sample of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Number of the sample, which increases by 1.
    pub number: u64,
    /// Number of the answered message.
    pub answers: u64,
    /// Sampling time on the clock of the device `[s]`; `None`: it has no clock.
    pub time: Option<f64>,
    /// Position `[m]`; 0 on axes that the device lacks.
    pub position: Vector,
    /// Orientation, if the device measures it.
    pub orientation: Option<[f64; 4]>,
}

/// A line of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard<'a> {
    /// An empty line, or the answer to a repeated `hello`.
    Nothing,
    /// A sample.
    Sample(Sample),
    /// The device refuses to continue, for this reason.
    Error(&'a str),
    /// Anything else.
    Unreadable,
}

/// Reads a line of `device` during a session.
pub fn heard<'a>(line: &'a [u8], device: &Capabilities) -> Heard<'a> {
    let Ok(line) = std::str::from_utf8(line) else {
        return Heard::Unreadable;
    };
    let mut words = line.split_ascii_whitespace();
    match words.next() {
        None | Some("device") => Heard::Nothing,
        Some("error") => Heard::Error(line.trim_start().trim_start_matches("error").trim()),
        Some("sample") => sample(words, device).map_or(Heard::Unreadable, Heard::Sample),
        Some(_) => Heard::Unreadable,
    }
}

/// Returns the form of a sample of `device`, for messages.
pub fn needed(device: &Capabilities) -> String {
    let axes = ["X", "Y", "Z"].into_iter().take(device.axes);
    let orientation = ["QW", "QX", "QY", "QZ"].into_iter();
    let orientation = orientation.filter(|_| device.measures_orientation);
    let numbers: Vec<&str> = axes.chain(orientation).collect();
    format!(
        "sample NUMBER N TIME {}, with finite numbers and \".\" as decimal separator",
        numbers.join(" ")
    )
}

/// Returns the begin of a received line for a message; `None`: it is too long.
pub fn quoted(line: Option<&[u8]>) -> String {
    let text = String::from_utf8_lossy(line.unwrap_or(b"(a line that is too long)"));
    text.trim().chars().take(LONGEST_QUOTE).collect()
}

fn sample(mut words: SplitAsciiWhitespace<'_>, device: &Capabilities) -> Option<Sample> {
    let number = next(&mut words)?;
    let answers = next(&mut words)?;
    let time = match words.next()? {
        "-" => None,
        time => Some(time.parse::<f64>().ok().filter(|time| time.is_finite())?),
    };
    let mut position = [0.0; 3];
    for place in position.iter_mut().take(device.axes) {
        *place = finite(&mut words)?;
    }
    let orientation = if device.measures_orientation {
        let mut found = [0.0; 4];
        for place in &mut found {
            *place = finite(&mut words)?;
        }
        Some(unit(found)?)
    } else {
        None
    };
    words.next().is_none().then_some(Sample {
        number,
        answers,
        time,
        position,
        orientation,
    })
}

fn next<T: FromStr>(words: &mut SplitAsciiWhitespace<'_>) -> Option<T> {
    words.next()?.parse().ok()
}

fn finite(words: &mut SplitAsciiWhitespace<'_>) -> Option<f64> {
    next(words).filter(|number: &f64| number.is_finite())
}

/// Returns the quaternion with the length 1, if its length is about 1.
fn unit(quaternion: [f64; 4]) -> Option<[f64; 4]> {
    let length = quaternion.iter().map(|part| part * part).sum::<f64>();
    let length = length.sqrt();
    UNIT.contains(&length)
        .then(|| quaternion.map(|part| part / length))
}

/// Answer of a device to `hello`.
#[derive(Clone, Debug, PartialEq)]
pub struct Introduction {
    /// Capabilities of the device.
    pub capabilities: Capabilities,
    /// Interval at which the device sends samples by itself; `None`: it answers requests.
    pub sends_every: Option<Duration>,
}

/// Longest quotation of a line `[character]`.
const LONGEST_QUOTE: usize = 100;

/// Keys of the line `device`, for messages.
const KEYS: &str = "axes, torque_axes, orientation, largest_force_n, largest_torque_n_m, largest_stiffness_n_per_m, \
                    largest_damping_n_s_per_m, mass_kg, quantum_m, lower_m, upper_m, rate_hz, and at the end name";

/// Highest rate at which a device may send samples `[Hz]`.
const HIGHEST_RATE: f64 = 1e5;

impl Introduction {
    /// Parses the answer to `hello`: `device 1 axes=2 largest_force_n=5 name=My device`.
    ///
    /// # Errors
    /// The first wrong word, with the allowed values.
    pub fn parse(line: &str) -> Result<Self, String> {
        let line = line.trim();
        // The name is the rest of the line, with its spaces.
        let (facts, name) = line.split_once(" name=").unwrap_or((line, "own device"));
        let mut words = facts.split_ascii_whitespace();
        match (words.next(), words.next()) {
            (Some("error"), _) => {
                let why = line.trim_start_matches("error").trim();
                return Err(format!("the device refuses: {why}"));
            }
            (Some("device"), Some(version)) if version == VERSION.to_string() => {}
            (Some("device"), Some(version)) => {
                return Err(format!(
                    "the device speaks version {version} of the protocol; allowed: {VERSION}"
                ));
            }
            _ => {
                return Err(format!(
                    "the device answers \"{line}\"; needed: device {VERSION} axes=1, and more keys if it has them"
                ));
            }
        }
        let mut axes = None;
        // Reports and recordings contain the name.
        let name = name.trim().replace(char::is_control, "\u{fffd}");
        let mut made = Capabilities::unknown(&name, 1);
        let mut keys: Vec<&str> = Vec::new();
        let (mut rate, mut lower, mut upper) = (None, None, None);
        for word in words {
            let Some((key, value)) = word.split_once('=') else {
                return Err(format!("the device says \"{word}\"; needed: KEY=VALUE"));
            };
            if keys.contains(&key) {
                return Err(format!("the device has the key {key} twice; allowed: once"));
            }
            keys.push(key);
            match key {
                "axes" => axes = Some(whole(key, value, 1)?),
                "torque_axes" => made.torque_axes = whole(key, value, 0)?,
                "orientation" => made.measures_orientation = switch(key, value)?,
                "largest_force_n" => made.largest_force = Some(above_0(key, value)?),
                "largest_torque_n_m" => made.largest_torque = Some(above_0(key, value)?),
                "largest_stiffness_n_per_m" => made.largest_stiffness = Some(above_0(key, value)?),
                "largest_damping_n_s_per_m" => made.largest_damping = Some(above_0(key, value)?),
                "mass_kg" => made.effective_mass = Some(above_0(key, value)?),
                "quantum_m" => made.encoder_quantum = Some(above_0(key, value)?),
                "lower_m" => lower = Some(corner(key, value)?),
                "upper_m" => upper = Some(corner(key, value)?),
                "rate_hz" => rate = Some(above_0(key, value)?),
                _ => {
                    return Err(format!("the device has the key {key}; allowed: {KEYS}"));
                }
            }
        }
        made.axes =
            axes.ok_or("the device does not say its number of axes; needed: axes=1, 2 or 3")?;
        made.workspace = lower.zip(upper).map(<[Vector; 2]>::from);
        if made.torque_axes > 0 && !made.measures_orientation {
            return Err("the device has torque_axes; needed with them: orientation=1".to_owned());
        }
        if let Some(rate) = rate.filter(|rate| *rate > HIGHEST_RATE) {
            return Err(format!(
                "rate_hz is {rate}; allowed: above 0, up to {HIGHEST_RATE}"
            ));
        }
        Ok(Self {
            capabilities: made,
            sends_every: rate.map(|rate| Duration::from_secs_f64(1.0 / rate)),
        })
    }
}

fn whole(key: &str, value: &str, least: usize) -> Result<usize, String> {
    let number = value
        .parse()
        .ok()
        .filter(|number| (least..=3).contains(number));
    number.ok_or_else(|| format!("{key} is {value}; allowed: {least} to 3"))
}

fn switch(key: &str, value: &str) -> Result<bool, String> {
    match value {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(format!("{key} is {value}; allowed: 0 and 1")),
    }
}

fn above_0(key: &str, value: &str) -> Result<f64, String> {
    let number = value.parse::<f64>().ok();
    let number = number.filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| format!("{key} is {value}; allowed: finite numbers above 0"))
}

fn corner(key: &str, value: &str) -> Result<Vector, String> {
    let mut corner = [0.0; 3];
    let mut parts = value.split(',');
    for (place, part) in corner.iter_mut().zip(&mut parts) {
        let number = part.parse::<f64>().ok().filter(|number| number.is_finite());
        *place = number.ok_or_else(|| {
            format!("{key} is {value}; allowed: up to three finite numbers, X,Y,Z")
        })?;
    }
    match parts.next() {
        None => Ok(corner),
        Some(_) => Err(format!(
            "{key} is {value}; allowed: up to three numbers, X,Y,Z"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> Capabilities {
        Introduction::parse("device 1 axes=2 name=plane")
            .unwrap()
            .capabilities
    }

    #[test]
    fn a_command_has_the_axes_of_the_device_and_is_exact() {
        let force = [0.1 + 0.2, -1e-300, 7.0];
        let text = wrench(12, &Wrench::of_force(force), &plane());
        let text = std::str::from_utf8(text.bytes()).unwrap();
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        assert_eq!(words[..2], ["wrench", "12"]);
        let parts: Vec<f64> = words[2..]
            .iter()
            .map(|word| word.parse().unwrap())
            .collect();
        assert_eq!(parts, force[..2]);
        assert!(text.ends_with('\n'));
    }

    #[test]
    fn the_longest_line_fits() {
        let six = Introduction::parse("device 1 axes=3 torque_axes=3 orientation=1").unwrap();
        let part = -1.234_567_890_123_456_7e-300;
        let all = Wrench {
            force: [part; 3],
            torque: [part; 3],
        };
        let text = wrench(u64::MAX, &all, &six.capabilities);
        assert!(text.bytes().ends_with(b"\n") && text.bytes().len() < LONGEST / 2);
    }

    #[test]
    fn samples_are_read_or_rejected() {
        let device = plane();
        let Heard::Sample(sample) = heard(b"sample 3 2 0.25 0.01 -2e-3\r", &device) else {
            panic!("no sample")
        };
        assert_eq!(
            (sample.number, sample.answers, sample.time),
            (3, 2, Some(0.25))
        );
        assert_eq!(sample.position, [0.01, -0.002, 0.0]);
        for (line, expected) in [
            (&b""[..], Heard::Nothing),
            (b"device 1 axes=2", Heard::Nothing),
            (b"error motor is hot", Heard::Error("motor is hot")),
            (b"hello", Heard::Unreadable),
            (b"sample 3 2 0.25 0.01", Heard::Unreadable),
            (b"sample 3 2 0.25 0.01 0.02 0.03", Heard::Unreadable),
            (b"sample 3 2 0.25 NaN 0.02", Heard::Unreadable),
            (b"sample 3 2 inf 0.01 0.02", Heard::Unreadable),
            (b"sample -3 2 0.25 0.01 0.02", Heard::Unreadable),
            (b"sample 3 2 0.25 0.01 \xff", Heard::Unreadable),
        ] {
            assert_eq!(
                heard(line, &device),
                expected,
                "{}",
                String::from_utf8_lossy(line)
            );
        }
    }

    #[test]
    fn an_orientation_has_the_length_1() {
        let device = Introduction::parse("device 1 axes=1 orientation=1")
            .unwrap()
            .capabilities;
        let Heard::Sample(sample) = heard(b"sample 1 1 - 0 0 0 0 1.001", &device) else {
            panic!("no sample")
        };
        assert_eq!(
            (sample.time, sample.orientation),
            (None, Some([0.0, 0.0, 0.0, 1.0]))
        );
        assert_eq!(heard(b"sample 1 1 - 0 0 0 0 2", &device), Heard::Unreadable);
        assert_eq!(heard(b"sample 1 1 - 0", &device), Heard::Unreadable);
    }

    #[test]
    fn an_introduction_has_every_key() {
        let made = Introduction::parse(
            "device 1 axes=3 torque_axes=3 orientation=1 largest_force_n=5 largest_torque_n_m=0.1 \
             largest_stiffness_n_per_m=1000 largest_damping_n_s_per_m=5 mass_kg=0.2 quantum_m=1e-5 lower_m=-0.1,0,0 \
             upper_m=0.1,0.2,0.3 rate_hz=500 name=My own device",
        )
        .unwrap();
        assert_eq!(made.sends_every, Some(Duration::from_millis(2)));
        assert_eq!(made.capabilities.name, "My own device");
        assert_eq!(
            made.capabilities.workspace,
            Some([[-0.1, 0.0, 0.0], [0.1, 0.2, 0.3]])
        );
        assert_eq!(made.capabilities.effective_mass, Some(0.2));
    }

    #[test]
    fn a_name_does_not_control_a_terminal() {
        let made = Introduction::parse("device 1 axes=1 name=\u{1b}[31mred\u{7}").unwrap();
        assert_eq!(made.capabilities.name, "\u{fffd}[31mred\u{fffd}");
    }

    #[test]
    fn a_wrong_introduction_says_what_is_allowed() {
        for (line, part) in [
            ("", "needed: device 1"),
            ("Traceback (most recent call last):", "needed: device 1"),
            ("device 2 axes=1", "version 2 of the protocol; allowed: 1"),
            ("device 1 name=x", "number of axes"),
            ("device 1 axes=4", "axes is 4; allowed: 1 to 3"),
            (
                "device 1 axes=1 axes=2",
                "the key axes twice; allowed: once",
            ),
            ("device 1 axes=1 weight=3", "the key weight; allowed: axes,"),
            (
                "device 1 axes=1 mass_kg=-1",
                "mass_kg is -1; allowed: finite numbers above 0",
            ),
            (
                "device 1 axes=1 largest_force_n=nan",
                "largest_force_n is nan",
            ),
            ("device 1 axes=1 upper_m=1,2,3,4", "upper_m is 1,2,3,4"),
            ("device 1 axes=1 rate_hz=1e9", "rate_hz is"),
            ("device 1 axes=1 fast", "needed: KEY=VALUE"),
            ("device 1 axes=1 torque_axes=1", "orientation=1"),
            ("error no motor", "the device refuses: no motor"),
        ] {
            let error = Introduction::parse(line).unwrap_err();
            assert!(error.contains(part), "{line}: {error}");
        }
    }
}
