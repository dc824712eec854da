//! Protocol of an emulated moteus behind a CAN adapter.

use std::time::{Duration, Instant};

use super::Firmware;
use super::motor::{Mode, Motor};

/// Highest register that a frame writes.
const REGISTERS: usize = 0x30;

pub struct Moteus {
    id: u8,
    /// `servo.timeout_mode`, of which the default damps.
    timeout_mode: u8,
    /// Answers of the console that were not fetched.
    console: Vec<u8>,
}

impl Moteus {
    pub fn new(id: u8) -> Self {
        Self {
            id,
            timeout_mode: 12,
            console: Vec::new(),
        }
    }

    fn console(&mut self, line: &str, motor: &mut Motor) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = match words[..] {
            ["conf", "get", "servo.timeout_mode"] => self.timeout_mode.to_string(),
            ["conf", "set", "servo.timeout_mode", value] => {
                match value.parse() {
                    Ok(value) if motor.mode == Mode::Stopped => {
                        self.timeout_mode = value;
                        motor.damps = value != 0;
                    }
                    // A configuration that changes while the motor is on.
                    Ok(_) => motor.fail(41),
                    Err(_) => {}
                }
                "OK".to_owned()
            }
            _ => "ERR unknown command".to_owned(),
        };
        self.console.extend(answer.bytes().chain(*b"\r\n"));
    }

    /// Takes the bytes of a frame, and returns the bytes of the answer.
    fn frame(&mut self, bytes: &[u8], motor: &mut Motor, now: Instant) -> Option<Vec<u8>> {
        let mut bytes = bytes.iter().copied();
        // Written registers; a command without one of them has its default.
        let mut written = [None; REGISTERS];
        let mut answer = Vec::new();
        while let Some(kind) = bytes.next() {
            match kind {
                0x00..=0x0f => {
                    let (count, first) = registers(kind, &mut bytes)?;
                    for register in first..first.checked_add(count)? {
                        let value = match kind & 0x0c {
                            0x00 => f32::from(bytes.next()?.cast_signed()),
                            0x0c => {
                                let [a, b, c, d] =
                                    [bytes.next()?, bytes.next()?, bytes.next()?, bytes.next()?];
                                f32::from_le_bytes([a, b, c, d])
                            }
                            _ => return None,
                        };
                        *written.get_mut(usize::from(register))? = Some(value);
                    }
                }
                0x10..=0x1f => {
                    self.obey(&mut written, motor, now);
                    let (count, first) = registers(kind, &mut bytes)?;
                    answer.extend([(kind & 0x0c) | 0x20, count, first]);
                    if count <= 3 {
                        let at = answer.len() - 3;
                        answer[at] |= count;
                        answer.remove(at + 1);
                    }
                    for register in first..first.checked_add(count)? {
                        let value = self.register(register, motor);
                        #[allow(clippy::cast_possible_truncation, reason = "small numbers")]
                        match kind & 0x0c {
                            0x00 => answer.push((value as i8).cast_unsigned()),
                            0x0c => answer.extend((value as f32).to_le_bytes()),
                            _ => return None,
                        }
                    }
                }
                0x40 => {
                    let (_channel, length) = (bytes.next()?, bytes.next()?);
                    let words: Vec<u8> = bytes.by_ref().take(length.into()).collect();
                    for line in String::from_utf8_lossy(&words).lines() {
                        self.console(line, motor);
                    }
                }
                0x42 => {
                    let (channel, most) = (bytes.next()?, bytes.next()?);
                    let length = self.console.len().min(most.into());
                    answer.extend([0x41, channel, u8::try_from(length).ok()?]);
                    answer.extend(self.console.drain(..length));
                }
                0x50 => {}
                _ => return None,
            }
        }
        self.obey(&mut written, motor, now);
        Some(answer)
    }

    /// Obeys what was written, once.
    fn obey(&self, written: &mut [Option<f32>; REGISTERS], motor: &mut Motor, now: Instant) {
        let Some(mode) = written[0].take() else {
            return;
        };
        if mode == 0.0 {
            motor.stop();
        }
        if mode != 10.0 {
            return;
        }
        let get = |register: usize, usual: f32| written[register].unwrap_or(usual);
        // This emulator has no stiffness and damping: a command with them is a fault of the driver.
        if get(0x23, 1.0) != 0.0 || get(0x24, 1.0) != 0.0 {
            motor.fail(99);
            return;
        }
        motor.damps = self.timeout_mode != 0;
        motor.feed(now);
        motor.move_on(now);
        let seconds = match get(0x27, 0.0) {
            0.0 => 0.1,
            seconds => seconds,
        };
        motor.watchdog = Duration::try_from_secs_f32(seconds).ok();
        motor.start(now);
        let most = get(0x25, f32::NAN);
        let torque = get(0x22, 0.0);
        let torque = if most.is_nan() {
            torque
        } else {
            torque.clamp(-most.abs(), most.abs())
        };
        motor.command(f64::from(torque));
    }

    fn register(&self, register: u8, motor: &Motor) -> f64 {
        let [position, velocity] = motor.turns();
        match register {
            0x00 => match motor.mode {
                Mode::Stopped => 0.0,
                Mode::Failed(_) => 1.0,
                Mode::Starting(_) => 2.0,
                Mode::Running => 10.0,
                Mode::TimedOut => 11.0,
                Mode::Other => 9.0,
            },
            0x01 => position,
            0x02 => velocity,
            0x03 => motor.torque(),
            0x0d => 24.0,
            0x0e => 25.0,
            0x0f => match motor.mode {
                Mode::Failed(code) => code.into(),
                _ => 0.0,
            },
            _ => 0.0,
        }
    }
}

/// Returns number and first of the registers of a subframe.
fn registers(kind: u8, bytes: &mut impl Iterator<Item = u8>) -> Option<(u8, u8)> {
    let count = match kind & 0x03 {
        0 => bytes.next()?,
        count => count,
    };
    Some((count, bytes.next()?))
}

impl Firmware for Moteus {
    fn line(&mut self, line: &str, motor: &mut Motor, now: Instant) -> Vec<String> {
        let mut words = line.split_whitespace();
        let understood = (words.next() == Some("can") && words.next() == Some("send"))
            .then(|| {
                let id = u16::from_str_radix(words.next()?, 16).ok()?;
                let hex = words.next()?;
                let bytes: Option<Vec<u8>> = hex
                    .as_bytes()
                    .chunks(2)
                    .map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok())
                    .collect();
                Some((id.to_be_bytes(), bytes?))
            })
            .flatten();
        let Some(([source, destination], bytes)) = understood else {
            return vec!["ERR unknown command\r\n".to_owned()];
        };
        let mut answers = vec!["OK\r\n".to_owned()];
        if destination != self.id {
            return answers;
        }
        if let Some(answer) = self.frame(&bytes, motor, now)
            && source & 0x80 != 0
        {
            let hex: String = answer.iter().map(|byte| format!("{byte:02X}")).collect();
            answers.push(format!(
                "rcv {:X}{:02X} {hex} E B F\r\n",
                self.id,
                source & 0x7f
            ));
        }
        answers
    }
}
