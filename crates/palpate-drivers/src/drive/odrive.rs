//! ODrive 3.x (firmware 0.5) by its text protocol, with checksums.
//!
//! A request has three answers: the state of the axis, its errors, and position and velocity. Answers do not state their
//! request. Source: the page on the ASCII protocol of odriverobotics/ODrive.

use std::time::Duration;

use super::axis::{Axis, AxisState, Condition, Heard};
use super::open::OpenError;
use super::text::Text;
use super::wire::Wire;

/// States of an axis.
const IDLE: u32 = 1;
const CLOSED_LOOP: u32 = 8;
/// Bit of the axis' errors for the end of its watchdog.
const WATCHDOG_EXPIRED: u32 = 0x800;
/// Control mode: torque; input mode: passed through.
const TORQUE_CONTROL: u32 = 1;
const PASSTHROUGH: u32 = 1;

/// Number of answers after a start in which an axis without an error may be idle.
const STARTS: u8 = 50;

const ANSWER_WITHIN: Duration = Duration::from_millis(500);

/// An axis of an ODrive.
#[derive(Debug)]
pub struct Odrive {
    number: u8,
    watchdog: Duration,
    /// Answers to the request so far: state and errors.
    state: Option<u32>,
    errors: Option<u32>,
    /// Number of answers after a start in which the axis may still be idle.
    starts: u8,
}

/// Writes a line with its checksum.
fn line(text: &mut Text, words: std::fmt::Arguments<'_>) {
    let start = text.length();
    text.put(words);
    let sum = checksum(text.since(start));
    text.put(format_args!("*{sum}\n"));
}

fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}

/// Returns the words of a line whose checksum is right.
fn checked(line: &[u8]) -> Option<&str> {
    let (words, sum) = std::str::from_utf8(line).ok()?.rsplit_once('*')?;
    let sum: u8 = sum.trim_end().parse().ok()?;
    (sum == checksum(words.as_bytes())).then_some(words)
}

impl Odrive {
    /// Creates the protocol of the axis `number`; `None` if it is not 0 or 1.
    #[must_use]
    pub fn new(number: u8) -> Option<Self> {
        (number < 2).then_some(Self {
            number,
            watchdog: Duration::ZERO,
            state: None,
            errors: None,
            starts: 0,
        })
    }

    /// Returns the value of a property.
    fn property(&self, wire: &mut Wire, name: &str) -> Result<f64, OpenError> {
        let number = self.number;
        let question = |text: &mut Text| line(text, format_args!("r axis{number}.{name}"));
        let answer = wire.exchange(question, ANSWER_WITHIN, |line| {
            Some(checked(line)?.trim().parse::<f64>().map_err(|_| ()))
        })?;
        match answer {
            Some(Ok(value)) => Ok(value),
            Some(Err(())) => Err(OpenError::NotReady {
                name: self.name(),
                why: format!("has no axis{number}.{name}: its firmware has to be 0.5"),
            }),
            None => Err(OpenError::Silent(self.name())),
        }
    }

    fn clear_errors(&mut self, text: &mut Text) {
        self.starts = STARTS;
        let number = self.number;
        line(text, format_args!("c {number} 0"));
        line(text, format_args!("sc"));
        line(text, format_args!("w axis{number}.error 0"));
        line(
            text,
            format_args!("w axis{number}.requested_state {CLOSED_LOOP}"),
        );
    }
}

impl Axis for Odrive {
    const MOST_UNANSWERED: u32 = 1;

    fn name(&self) -> String {
        format!("ODrive axis {}", self.number)
    }

    fn prepare(
        &mut self,
        wire: &mut Wire,
        largest: f32,
        watchdog: Duration,
    ) -> Result<(), OpenError> {
        self.watchdog = watchdog;
        let number = self.number;
        // A line that a program before began.
        wire.exchange(
            |text| text.put(format_args!("\n")),
            Duration::ZERO,
            |_| Some(()),
        )?;
        self.property(wire, "current_state")?;
        let seconds = watchdog.as_secs_f32();
        wire.exchange(
            |text| {
                line(text, format_args!("w axis{number}.requested_state {IDLE}"));
                line(text, format_args!("c {number} 0"));
                line(
                    text,
                    format_args!("w axis{number}.controller.config.input_mode {PASSTHROUGH}"),
                );
                line(
                    text,
                    format_args!("w axis{number}.controller.config.control_mode {TORQUE_CONTROL}"),
                );
                line(
                    text,
                    format_args!("w axis{number}.motor.config.torque_lim {largest}"),
                );
                line(
                    text,
                    format_args!("w axis{number}.config.watchdog_timeout {seconds}"),
                );
                line(text, format_args!("u {number}"));
                line(
                    text,
                    format_args!("w axis{number}.config.enable_watchdog 1"),
                );
                line(text, format_args!("u {number}"));
            },
            Duration::ZERO,
            |_| Some(()),
        )?;
        let set = self.property(wire, "config.watchdog_timeout")?;
        let enabled = self.property(wire, "config.enable_watchdog")?;
        // The drive answers with a few digits.
        if enabled != 1.0 || (set / f64::from(seconds) - 1.0).abs() > 0.01 {
            return Err(OpenError::NotReady {
                name: self.name(),
                why: format!(
                    "does not take a watchdog of {seconds} s: it has {set} s, enabled: {enabled}"
                ),
            });
        }
        wire.exchange(|text| self.clear_errors(text), Duration::ZERO, |_| Some(()))?;
        Ok(())
    }

    fn watchdog(&self) -> Duration {
        self.watchdog
    }

    fn ask(&mut self, torque: f32, text: &mut Text) {
        let number = self.number;
        (self.state, self.errors) = (None, None);
        self.command(torque, text);
        line(text, format_args!("r axis{number}.current_state"));
        line(text, format_args!("r axis{number}.error"));
        line(text, format_args!("f {number}"));
    }

    fn command(&mut self, torque: f32, text: &mut Text) {
        line(text, format_args!("c {} {torque}", self.number));
    }

    fn resume(&mut self, text: &mut Text) {
        self.clear_errors(text);
    }

    fn stop(&mut self, text: &mut Text) {
        let number = self.number;
        line(text, format_args!("c {number} 0"));
        line(text, format_args!("w axis{number}.requested_state {IDLE}"));
        // Without commands it would report an error later.
        line(
            text,
            format_args!("w axis{number}.config.enable_watchdog 0"),
        );
    }

    fn hear(&mut self, line: &[u8]) -> Heard {
        let Some(words) = checked(line) else {
            return Heard::Unreadable;
        };
        let mut words = words.split_ascii_whitespace();
        let (Some(first), second) = (words.next(), words.next()) else {
            return Heard::Unreadable;
        };
        let Some(_velocity) = second else {
            let Ok(value) = first.parse() else {
                return Heard::Unreadable;
            };
            if self.state.is_none() {
                self.state = Some(value);
            } else {
                self.errors = Some(value);
            }
            return Heard::Part;
        };
        let (Ok(position), Some(state), Some(errors)) =
            (first.parse(), self.state.take(), self.errors.take())
        else {
            return Heard::Unreadable;
        };
        let may_start = self.starts > 0;
        self.starts = self.starts.saturating_sub(1);
        let condition = match (state, errors) {
            (CLOSED_LOOP, 0) => Condition::Ready,
            (_, WATCHDOG_EXPIRED) => Condition::TimedOut,
            (_, 0) if may_start => Condition::Starting,
            (_, 0) => Condition::Failed(
                "the axis is not in closed-loop control: end the other program that commands it, or calibrate it by odrivetool",
            ),
            _ => Condition::Failed("the axis has an error: odrivetool names it (dump_errors)"),
        };
        Heard::State(AxisState {
            position,
            condition,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sealed(words: &str) -> String {
        format!("{words}*{}", checksum(words.as_bytes()))
    }

    #[test]
    fn lines_have_the_checksum_of_the_manual() {
        // Its example: `r vbus_voltage *93`.
        assert_eq!(checksum(b"r vbus_voltage "), 93);
        let mut axis = Odrive::new(1).unwrap();
        let mut text = Text::default();
        axis.command(-0.125, &mut text);
        assert_eq!(
            text.bytes(),
            format!("{}\n", sealed("c 1 -0.125")).as_bytes()
        );
        assert!(Odrive::new(2).is_none());
    }

    #[test]
    fn an_answer_is_complete_or_it_is_none() {
        let mut axis = Odrive::new(0).unwrap();
        let mut heard = |lines: [&str; 3]| {
            axis.ask(0.0, &mut Text::default());
            let [first, second, last] = lines.map(|words| axis.hear(sealed(words).as_bytes()));
            assert_eq!((first, second), (Heard::Part, Heard::Part));
            last
        };
        let state = |condition| {
            Heard::State(AxisState {
                position: 0.25,
                condition,
            })
        };
        assert_eq!(
            heard(["8", "0", "0.250000 -1.000000"]),
            state(Condition::Ready)
        );
        assert_eq!(heard(["1", "2048", "0.25 0"]), state(Condition::TimedOut));
        assert!(matches!(
            heard(["1", "64", "0.25 0"]),
            Heard::State(AxisState {
                condition: Condition::Failed(_),
                ..
            })
        ));
        assert!(matches!(
            heard(["1", "0", "0.25 0"]),
            Heard::State(AxisState {
                condition: Condition::Failed(_),
                ..
            })
        ));
        // The first answer is lost.
        assert_eq!(axis.hear(sealed("0.25 0").as_bytes()), Heard::Unreadable);
        for torn in ["0.25 0*", "0.25 0", "5 0*17", "", "unknown command*3"] {
            assert_eq!(axis.hear(torn.as_bytes()), Heard::Unreadable, "{torn}");
        }
    }
}
