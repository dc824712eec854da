//! Text protocol of an emulated ODrive 3.x with firmware 0.5.

use std::time::{Duration, Instant};

use super::Firmware;
use super::motor::{Mode, Motor};

/// Errors of the axis: the watchdog has expired, the motor has failed.
const WATCHDOG_EXPIRED: u32 = 0x800;
const MOTOR_FAILED: u32 = 0x40;

pub struct Odrive {
    number: u8,
    watchdog_timeout: f64,
    enable_watchdog: bool,
    torque_lim: f64,
    control_mode: u32,
    input_mode: u32,
}

impl Odrive {
    /// The usual settings: position control, no watchdog.
    pub fn new(number: u8) -> Self {
        Self {
            number,
            watchdog_timeout: 0.0,
            enable_watchdog: false,
            torque_lim: f64::INFINITY,
            control_mode: 3,
            input_mode: 1,
        }
    }

    fn read(&self, name: &str, motor: &Motor) -> Option<String> {
        let name = name.strip_prefix(&format!("axis{}.", self.number))?;
        Some(match name {
            "current_state" => match motor.mode {
                Mode::Running => "8".to_owned(),
                _ => "1".to_owned(),
            },
            "error" => match motor.mode {
                Mode::TimedOut => WATCHDOG_EXPIRED.to_string(),
                Mode::Failed(_) => MOTOR_FAILED.to_string(),
                _ => "0".to_owned(),
            },
            "config.watchdog_timeout" => format!("{:.6}", self.watchdog_timeout),
            "config.enable_watchdog" => u8::from(self.enable_watchdog).to_string(),
            _ => return None,
        })
    }

    fn write(&mut self, name: &str, value: f64, motor: &mut Motor, now: Instant) -> Option<()> {
        let name = name.strip_prefix(&format!("axis{}.", self.number))?;
        match name {
            "requested_state" if value == 8.0 => motor.start(now),
            // Leaving closed-loop control keeps an error.
            "requested_state" => {
                if matches!(motor.mode, Mode::Running | Mode::Starting(_) | Mode::Other) {
                    motor.stop();
                }
            }
            "error" => motor.stop(),
            "config.watchdog_timeout" => self.watchdog_timeout = value,
            "config.enable_watchdog" => self.enable_watchdog = value != 0.0,
            "motor.config.torque_lim" => self.torque_lim = value,
            "controller.config.input_mode" => self.input_mode = whole(value)?,
            "controller.config.control_mode" => self.control_mode = whole(value)?,
            _ => return None,
        }
        motor.watchdog = Duration::try_from_secs_f64(self.watchdog_timeout)
            .ok()
            .filter(|_| self.enable_watchdog);
        Some(())
    }

    fn obey(&mut self, words: &[&str], motor: &mut Motor, now: Instant) -> Option<String> {
        let is_ours = |number: &str| number.parse() == Ok(self.number);
        match words {
            ["c", number, torque] if is_ours(number) => {
                motor.feed(now);
                self.control_mode = 1;
                let torque: f64 = torque.parse().unwrap_or(0.0);
                motor.command(torque.clamp(-self.torque_lim, self.torque_lim));
                None
            }
            ["u", number] if is_ours(number) => {
                motor.feed(now);
                None
            }
            ["f", number] if is_ours(number) => {
                let [position, velocity] = motor.turns();
                Some(format!("{position:.6} {velocity:.6}"))
            }
            ["c" | "u" | "f", ..] => Some("invalid motor".to_owned()),
            ["r", name] => Some(
                self.read(name, motor)
                    .unwrap_or_else(|| "invalid property".to_owned()),
            ),
            ["w", name, value] => {
                let value = value.parse().unwrap_or(f64::NAN);
                let done = self.write(name, value, motor, now);
                done.is_none().then(|| "invalid property".to_owned())
            }
            ["sc"] => {
                if matches!(motor.mode, Mode::TimedOut | Mode::Failed(_)) {
                    motor.stop();
                }
                None
            }
            [] => None,
            _ => Some("unknown command".to_owned()),
        }
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked"
)]
fn whole(value: f64) -> Option<u32> {
    (value.fract() == 0.0 && (0.0..100.0).contains(&value)).then_some(value as u32)
}

fn sum(words: &str) -> u8 {
    words.bytes().fold(0, |sum, byte| sum ^ byte)
}

impl Firmware for Odrive {
    fn line(&mut self, line: &str, motor: &mut Motor, now: Instant) -> Vec<String> {
        let (words, is_checked) = match line.split_once('*') {
            Some((words, given)) if given.trim().parse() == Ok(sum(words)) => (words, true),
            // A line with a wrong checksum is ignored.
            Some(_) => return Vec::new(),
            None => (line, false),
        };
        let words: Vec<&str> = words.split_whitespace().collect();
        let answer = self.obey(&words, motor, now);
        let answer = answer.map(|answer| {
            if is_checked {
                format!("{answer}*{}\r\n", sum(&answer))
            } else {
                format!("{answer}\r\n")
            }
        });
        answer.into_iter().collect()
    }
}
