//! Motor drives: their setup from the text of `--device`, and their messages.

use std::path::PathBuf;

use palpate_device::Device;
use palpate_device::clock::Clock;

use super::reconnecting;
use crate::failure::{Failure, tell};
use crate::reports::Guarding;

/// Usual largest torque `[N m]`.
const USUAL_TORQUE: f64 = 0.1;

/// Makers of drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maker {
    /// moteus.
    Moteus,
    /// ODrive.
    Odrive,
}

/// A drive on a port, with its mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorDrive {
    /// Maker.
    pub maker: Maker,
    /// Serial port.
    pub port: PathBuf,
    /// Number of the drive, or of its axis.
    pub number: u8,
    /// Travel of the handle for a turn `[m]`.
    pub travel: f64,
    /// Position of the drive at which the coordinate is 0 `[turns]`.
    pub zero: f64,
    /// Largest torque `[N m]`.
    pub largest_torque: f64,
}

impl MotorDrive {
    /// Parses `PORT,radius_m=R` with further settings, after the name of the maker.
    ///
    /// # Errors
    /// A setting is missing, unknown, given twice or not a number.
    pub fn parse(maker: Maker, text: &str) -> Result<Self, String> {
        let (name, number_key, usual_number) = match maker {
            Maker::Moteus => ("moteus", "id", 1),
            Maker::Odrive => ("odrive", "axis", 0),
        };
        let needed = format!(
            "needed: {name}:PORT,radius_m=R, such as {name}:/dev/ttyACM0,radius_m=0.02; allowed: radius_m or travel_m, \
             torque_nm, zero_turns, {number_key}"
        );
        let mut parts = text.split(',');
        let port = parts.next().filter(|port| !port.is_empty());
        let port = PathBuf::from(port.ok_or_else(|| needed.clone())?);
        let [mut travel, mut torque, mut zero, mut number] = [None; 4];
        for part in parts {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| format!("{part:?}: {needed}"))?;
            let value = value.parse::<f64>();
            let value = value.map_err(|_| format!("{part:?} has no number"))?;
            let (place, value) = match key {
                "radius_m" => (&mut travel, std::f64::consts::TAU * value),
                "travel_m" => (&mut travel, value),
                "torque_nm" => (&mut torque, value),
                "zero_turns" => (&mut zero, value),
                key if key == number_key => (&mut number, value),
                _ => return Err(format!("{key}: {needed}")),
            };
            if place.replace(value).is_some() {
                return Err(format!("{key} is given twice: {needed}"));
            }
        }
        let wanted = number.unwrap_or(f64::from(usual_number));
        let most = if maker == Maker::Moteus { 111 } else { 1 };
        let number = (usual_number..=most).find(|number| f64::from(*number) == wanted);
        Ok(Self {
            maker,
            port,
            number: number.ok_or_else(|| {
                format!("{number_key} is {wanted}; allowed: {usual_number} to {most}")
            })?,
            travel: travel.ok_or(needed)?,
            zero: zero.unwrap_or(0.0),
            largest_torque: torque.unwrap_or(USUAL_TORQUE),
        })
    }
}

/// Opens the drive for a loop of `period` `[s]`; `reconnect` waits for a lost one. Returns it with its identity.
#[cfg(unix)]
pub fn open<C: Clock>(
    drive: &MotorDrive,
    reconnect: bool,
    period: f64,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, String), Failure> {
    use palpate_drivers::drive::{OpenError, Options, SHORTEST_WATCHDOG};
    use palpate_drivers::prepared::Reopen;

    use crate::values::duration;

    let options = Options {
        travel: drive.travel,
        zero: drive.zero,
        silence: guarding.limit.max(SHORTEST_WATCHDOG),
        ..Options::new(
            &drive.port,
            0.0,
            drive.largest_torque,
            duration("--period", period)?,
        )
    };
    let device = opened(drive, &options, clock).map_err(|error| match error {
        OpenError::Setting { .. } => Failure::Arguments(format!("--device: {error}")),
        _ => Failure::System(error.to_string()),
    })?;
    let name = device.capabilities().name.clone();
    tell(format_args!(
        "{name}: its watchdog takes the torque off {} ms after the last command",
        options.silence.as_secs_f64() * 1e3
    ));
    let identity = std::fs::canonicalize(&drive.port);
    let identity = format!(
        "{name} on {}",
        identity.unwrap_or_else(|_| drive.port.clone()).display()
    );
    if !reconnect {
        return Ok((device, identity));
    }
    let (drive, clock) = (drive.clone(), clock.clone());
    let reopen: Reopen =
        Box::new(move || opened(&drive, &options, &clock).map_err(|error| error.to_string()));
    Ok((reconnecting(device, reopen)?, identity))
}

#[cfg(unix)]
fn opened<C: Clock>(
    drive: &MotorDrive,
    options: &palpate_drivers::drive::Options,
    clock: &C,
) -> Result<Box<dyn Device>, palpate_drivers::drive::OpenError> {
    use palpate_drivers::drive::{Drive, Moteus, Odrive, OpenError};

    // `parse` has checked the number.
    let silent = || OpenError::Silent(format!("drive {}", drive.number));
    let (period, clock) = (options.patience * 2, clock.clone());
    let report = |turns: f64, round_trip: std::time::Duration| {
        tell(format_args!(
            "the drive is at {turns:.4} turns, so the handle at {:.4} m",
            (turns - drive.zero) * drive.travel
        ));
        if round_trip > options.patience {
            tell(format_args!(
                "warning: an answer of the drive takes {:.2} ms, more than half the period of {:.2} ms: ticks will have \
                 no sample in time",
                round_trip.as_secs_f64() * 1e3,
                period.as_secs_f64() * 1e3
            ));
        }
    };
    Ok(match drive.maker {
        Maker::Moteus => {
            let axis = Moteus::new(drive.number).ok_or_else(silent)?;
            let device = Drive::open(axis, options, clock, tell)?;
            report(device.turns(), device.round_trip());
            Box::new(device)
        }
        Maker::Odrive => {
            let axis = Odrive::new(drive.number).ok_or_else(silent)?;
            let device = Drive::open(axis, options, clock, tell)?;
            report(device.turns(), device.round_trip());
            Box::new(device)
        }
    })
}

/// Fails, because serial ports need Unix.
#[cfg(not(unix))]
pub fn open<C: Clock>(
    _: &MotorDrive,
    _: bool,
    _: f64,
    _: &C,
    _: &Guarding,
) -> Result<(Box<dyn Device>, String), Failure> {
    Err(Failure::System(
        "the drivers of moteus and ODrive need Linux or macOS".into(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_has_a_port_and_a_mechanism() {
        let parse = MotorDrive::parse;
        let found = parse(Maker::Moteus, "/dev/ttyACM0,radius_m=-0.02,id=3").unwrap();
        assert_eq!((found.number, found.largest_torque), (3, USUAL_TORQUE));
        assert_eq!(found.port, PathBuf::from("/dev/ttyACM0"));
        assert!((found.travel + 0.04 * std::f64::consts::PI).abs() < 1e-12);
        let found = parse(
            Maker::Odrive,
            "p,travel_m=0.005,torque_nm=2,axis=1,zero_turns=-0.5",
        )
        .unwrap();
        assert_eq!(
            (
                found.number,
                found.largest_torque,
                found.travel + found.zero
            ),
            (1, 2.0, 0.005 - 0.5)
        );
        for (text, words) in [
            ("", "needed: moteus:PORT"),
            ("p", "needed: moteus:PORT"),
            ("p,radius_m", "needed"),
            ("p,radius_m=x", "has no number"),
            ("p,radius_m=1,travel_m=1", "given twice"),
            ("p,radius_m=1,axis=1", "axis: needed"),
            ("p,radius_m=1,id=1.5", "allowed: 1 to 111"),
        ] {
            let why = parse(Maker::Moteus, text).unwrap_err();
            assert!(why.contains(words), "{text}: {why}");
        }
    }
}
