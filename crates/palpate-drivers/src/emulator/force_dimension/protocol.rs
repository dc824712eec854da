//! Questions of the emulated library.

use std::time::Duration;

use super::device::EmulatedDevice;

/// Number of bytes of a question and of an answer.
pub const QUESTION: usize = 8 + 8 * 8;
pub const ANSWER: usize = 8 + 8 * VALUES;
const VALUES: usize = 36;

/// Questions, by the numbers of `libdrd.c`.
const AVAILABLE: i32 = 0;
const OPEN: i32 = 1;
const CLOSE: i32 = 2;
const STOP: i32 = 3;
const TYPE: i32 = 4;
const STATUS: i32 = 5;
const ENABLE: i32 = 6;
const POSITION: i32 = 7;
const VELOCITY: i32 = 8;
const FRAME: i32 = 9;
const COMMAND: i32 = 10;
const GAP: i32 = 11;
const GRAVITY: i32 = 12;
const LIMITS: i32 = 13;
const BRAKES: i32 = 14;
const SET_WATCHDOG: i32 = 15;
const WATCHDOG: i32 = 16;
const JOINTS: i32 = 17;
const INERTIA: i32 = 18;
const BUTTONS: i32 = 19;
const ANGULAR_VELOCITY: i32 = 20;
const EFFECTOR: i32 = 21;

/// Answers a question at the time `now`. `devices` is the number of devices, of which the first can be opened;
/// `serial` is its serial number.
pub fn answer(
    question: &[u8; QUESTION],
    device: &mut EmulatedDevice,
    (devices, serial): (i32, i32),
    now: Duration,
) -> [u8; ANSWER] {
    let word = |at: usize| i32::from_ne_bytes(std::array::from_fn(|byte| question[at + byte]));
    let value = |number: usize| {
        f64::from_ne_bytes(std::array::from_fn(|byte| question[8 + 8 * number + byte]))
    };
    let (what, number) = (word(0), word(4));
    let mut values = [0.0; VALUES];
    device.move_on(now);
    let result = if device.trouble.is_unplugged {
        if what == AVAILABLE { 0 } else { -1 }
    } else {
        match what {
            AVAILABLE => devices - i32::from(device.is_open),
            OPEN => {
                // A negative number is one less than minus the index.
                let is_it = number == -1 || number == serial;
                device.is_open |= is_it;
                if is_it { 0 } else { -1 }
            }
            CLOSE => {
                device.is_open = false;
                0
            }
            STOP => {
                device.disable();
                0
            }
            TYPE => device.kind.code,
            STATUS => {
                for (value, status) in values.iter_mut().zip(device.status) {
                    *value = status.into();
                }
                0
            }
            ENABLE => {
                device.enable(number != 0, now);
                0
            }
            POSITION | FRAME | GAP => sampled(what, device, &mut values),
            VELOCITY => {
                values[..3].copy_from_slice(&device.velocity(now));
                0
            }
            ANGULAR_VELOCITY => {
                values[..3].copy_from_slice(&device.wrist_velocity());
                0
            }
            COMMAND => device.command(std::array::from_fn(value), now),
            GRAVITY => {
                device.has_gravity_compensation = number != 0;
                0
            }
            LIMITS => {
                device.limits[usize::from(number != 0)] = value(0);
                0
            }
            BRAKES | BUTTONS => 0,
            SET_WATCHDOG if device.has_watchdog => {
                device.watchdog = u8::try_from(number).unwrap_or(u8::MAX);
                0
            }
            WATCHDOG if device.has_watchdog => {
                values[0] = device.watchdog.into();
                0
            }
            // The joints of this device are its axes.
            JOINTS => {
                values[..3].copy_from_slice(&device.position());
                values[3..6].copy_from_slice(&device.wrist());
                0
            }
            INERTIA => {
                values = device.inertia();
                0
            }
            EFFECTOR => {
                values[0] = 0.1;
                0
            }
            _ => -1,
        }
    };
    bytes(result, &values)
}

/// Writes a sample, unless there is no new one.
fn sampled(what: i32, device: &mut EmulatedDevice, values: &mut [f64; VALUES]) -> i32 {
    if device.trouble.stale_reads > 0 {
        device.trouble.stale_reads -= 1;
        return 1;
    }
    if what == GAP {
        values[0] = device.gap();
        return 0;
    }
    values[..3].copy_from_slice(&device.position());
    let [about_x, about_y, about_z] = device.wrist().map(f64::sin_cos);
    let ((sx, cx), (sy, cy), (sz, cz)) = (about_x, about_y, about_z);
    let matrix = [
        cy * cz,
        sx * sy * cz - cx * sz,
        cx * sy * cz + sx * sz,
        cy * sz,
        sx * sy * sz + cx * cz,
        cx * sy * sz - sx * cz,
        -sy,
        sx * cy,
        cx * cy,
    ];
    values[3..12].copy_from_slice(&matrix);
    0
}

fn bytes(result: i32, values: &[f64; VALUES]) -> [u8; ANSWER] {
    let mut bytes = [0; ANSWER];
    bytes[..4].copy_from_slice(&result.to_ne_bytes());
    for (place, value) in bytes[8..].chunks_exact_mut(8).zip(values) {
        place.copy_from_slice(&value.to_ne_bytes());
    }
    bytes
}
