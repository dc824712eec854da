//! Opening of a device: its type, its state, its limits and its watchdog.

use std::path::PathBuf;
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Vector};

use super::driver::ForceDimension;
use super::kinds::Kind;
use super::library::{self, LibraryNotFound};
use super::velocity::VelocityCheck;
use crate::plugin::LibraryError;
use crate::plugin::library::dhd::{Dhd, DhdDevice, Forces};

/// Unit of the firmware's watchdog.
const WATCHDOG_UNIT: Duration = Duration::from_micros(125);
/// Longest time of the firmware's watchdog.
pub const LONGEST_WATCHDOG: Duration = Duration::from_micros(125 * 255);
/// Range of masses that is plausible for a device `[kg]`.
const PLAUSIBLE_MASS: std::ops::RangeInclusive<f64> = 0.005..=20.0;

/// Part of a device that a loop uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Part {
    /// The handle: three axes, with orientation and torques if the device has them.
    #[default]
    Handle,
    /// The gripper: one axis, along its opening.
    Gripper,
}

/// Selection and settings of a device.
#[derive(Clone, Debug)]
pub struct Options {
    /// The manufacturer's library; `None`: that of [`find`](super::find).
    pub library: Option<PathBuf>,
    /// Serial number; `None`: the only device.
    pub serial: Option<i32>,
    /// Used part.
    pub part: Part,
    /// Whether the device carries its own weight.
    pub gravity_compensation: bool,
    /// Period of the loop.
    pub period: Duration,
    /// Time without a command after which the firmware takes the force off, at most [`LONGEST_WATCHDOG`].
    pub silence: Duration,
}

impl Options {
    /// Returns the options for the handle of the only device, with gravity compensation.
    #[must_use]
    pub fn new(period: Duration, silence: Duration) -> Self {
        Self {
            library: None,
            serial: None,
            part: Part::Handle,
            gravity_compensation: true,
            period,
            silence,
        }
    }
}

/// Reason why a device cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The manufacturer's library is not found.
    #[error(transparent)]
    NotFound(#[from] LibraryNotFound),
    /// The library cannot be used.
    #[error("the library {}: {error}", .path.display())]
    Library {
        /// Its file.
        path: PathBuf,
        /// Reason.
        error: LibraryError,
    },
    /// No device is plugged in, or another program has it.
    #[error(
        "no device can be opened: plug one in, switch it on, and end other programs that use it"
    )]
    NoDevice,
    /// Several devices are plugged in.
    #[error(
        "{0} devices can be opened: select one by its serial number, since a force on the wrong one can hit a person"
    )]
    Several(i32),
    /// The library does not open the device.
    #[error("the device cannot be opened: {0}")]
    Refused(String),
    /// The type of the device is unknown.
    #[error(
        "the device has type {code}; allowed: {}",
        super::KINDS.map(|kind| format!("{} ({})", kind.code, kind.name)).join(", ")
    )]
    Kind {
        /// Number of its type.
        code: i32,
    },
    /// The device lacks a driven gripper.
    #[error("the {0} has no gripper with a motor")]
    NoGripper(&'static str),
    /// The device is not ready for a force.
    #[error("the {name} {why}")]
    NotReady {
        /// Its type.
        name: &'static str,
        /// Reason, and what to do.
        why: &'static str,
    },
    /// The firmware's watchdog cannot be as long as the loop needs.
    #[error(
        "the period is {} ms; allowed: at most {:.2} ms, since the firmware takes the force off after {} ms without a \
         command",
        .period.as_secs_f64() * 1e3,
        longest_period().as_secs_f64() * 1e3,
        LONGEST_WATCHDOG.as_secs_f64() * 1e3
    )]
    TooSlow {
        /// Period of the loop.
        period: Duration,
    },
    /// A call failed.
    #[error("the {name} {what}: {text}")]
    Call {
        /// Type of the device.
        name: &'static str,
        /// The failure.
        what: &'static str,
        /// The library's words.
        text: String,
    },
}

impl<C: Clock> ForceDimension<C> {
    /// Loads the manufacturer's library and opens a device. `tell` receives messages at the end.
    ///
    /// The limits of the library are set to those of the type, and the firmware's watchdog to
    /// [`Options::silence`]. A device without that watchdog has [`Capabilities::holds_last_force`].
    ///
    /// # Errors
    /// The library is missing or old, none or several devices are there, or the device is of another type, not
    /// calibrated, or not ready.
    pub fn open(
        options: &Options,
        clock: C,
        tell: impl Fn(String) + Send + 'static,
    ) -> Result<Self, OpenError> {
        if options.period > longest_period() {
            return Err(OpenError::TooSlow {
                period: options.period,
            });
        }
        let path = match &options.library {
            Some(path) => path.clone(),
            None => library::find()?,
        };
        let dhd = Dhd::load(&path).map_err(|error| OpenError::Library { path, error })?;
        match (dhd.available(), options.serial) {
            (..=0, _) => return Err(OpenError::NoDevice),
            (several @ 2.., None) => return Err(OpenError::Several(several)),
            _ => {}
        }
        let device = dhd.open(options.serial).map_err(OpenError::Refused)?;
        let code = device.system_type();
        let kind = Kind::of_code(code).ok_or(OpenError::Kind { code })?;
        if options.part == Part::Gripper && kind.largest_grip.is_none() {
            return Err(OpenError::NoGripper(kind.name));
        }
        is_ready(&device, &kind)?;
        let watchdog = prepare(&device, &kind, options)?;
        let mass = PoseMass::of(&device).filter(|_| options.part == Part::Handle);
        let mean = mass.as_ref().map(PoseMass::mean);
        let capabilities = capabilities(&kind, options.part, watchdog.is_none(), mean);
        Ok(Self {
            commanded_at: clock.now(),
            clock,
            capabilities,
            device,
            kind,
            part: options.part,
            watchdog,
            mass,
            has_force: false,
            was_cut: false,
            connection: palpate_device::Connection::default(),
            velocity: VelocityCheck::new(),
            reason: None,
            tell: Box::new(tell),
        })
    }

    /// Returns the type of the device.
    #[must_use]
    pub fn kind(&self) -> &Kind {
        &self.kind
    }

    /// Returns the number of the device in the library.
    #[must_use]
    pub fn id(&self) -> i32 {
        self.device.id()
    }

    /// Returns the mass matrix at the pose of opening; `None`: the library has none, or a loop uses the gripper.
    #[must_use]
    pub fn mass(&self) -> Option<PoseMass> {
        self.mass
    }

    /// Returns the time without a command after which the firmware takes the force off; `None`: it has no watchdog.
    #[must_use]
    pub fn watchdog(&self) -> Option<Duration> {
        self.watchdog
    }
}

/// Returns the longest period of a loop: a tick may be late by half a period.
fn longest_period() -> Duration {
    LONGEST_WATCHDOG * 2 / 3
}

/// Rejects a device that is not ready for a force.
fn is_ready(device: &DhdDevice, kind: &Kind) -> Result<(), OpenError> {
    let name = kind.name;
    let Some(status) = device.status() else {
        return Err(OpenError::Call {
            name,
            what: "does not give its status",
            text: device.error(),
        });
    };
    let [
        power,
        connected,
        started,
        reset,
        _,
        _,
        _,
        _,
        wrist,
        error,
        _,
        _,
        wrist_ready,
        ..,
    ] = status;
    let checks = [
        (connected != 0, "is not connected: check its cable"),
        (power != 0, "has no power: switch it on"),
        (
            error == 0,
            "reports an error: switch it off and on, and see its manual",
        ),
        (
            reset == 0,
            "is not calibrated: bring its handle into the position of its manual, and calibrate it by its button or by \
             the manufacturer's program; palpate does not move a device that is not calibrated",
        ),
        (started != 0, "is not started: switch it off and on"),
        (
            !kind.has_wrist || wrist == 0 || wrist_ready != 0,
            "has a wrist that is not calibrated: calibrate it by the manufacturer's program, which moves it",
        ),
    ];
    match checks.into_iter().find(|(is_fine, _)| !is_fine) {
        Some((_, why)) => Err(OpenError::NotReady { name, why }),
        None => Ok(()),
    }
}

/// Sets limits, watchdog and forces, and returns the time of the watchdog.
fn prepare(
    device: &DhdDevice,
    kind: &Kind,
    options: &Options,
) -> Result<Option<Duration>, OpenError> {
    let name = kind.name;
    let done = |result: i32, what| {
        if result >= 0 {
            return Ok(());
        }
        let text = device.error();
        Err(OpenError::Call { name, what, text })
    };
    let limits = device.set_limits(kind.largest_force, kind.largest_torque);
    done(limits, "refuses its largest force or torque")?;
    let gravity = device.set_gravity_compensation(options.gravity_compensation);
    done(gravity, "refuses to switch its gravity compensation")?;
    // A Falcon has no brakes, so a refusal means nothing.
    let _ = device.set_brakes(false);
    let silence = options.silence.min(LONGEST_WATCHDOG);
    let units = silence.as_nanos().div_ceil(WATCHDOG_UNIT.as_nanos());
    let units = u8::try_from(units.max(1)).unwrap_or(u8::MAX);
    let has_watchdog = device.set_watchdog(units) == Some(units);
    done(device.enable_force(true), "refuses to enable its forces")?;
    let zero = forces_of(kind, Forces::default());
    done(device.command(&zero), "refuses a force of 0")?;
    Ok(has_watchdog.then(|| WATCHDOG_UNIT * u32::from(units)))
}

/// Returns the forces with all axes that the device drives.
pub(super) fn forces_of(kind: &Kind, forces: Forces) -> Forces {
    Forces {
        force: forces.force,
        torque: kind
            .largest_torque
            .map(|_| forces.torque.unwrap_or_default()),
        gripper: kind
            .largest_grip
            .map(|_| forces.gripper.unwrap_or_default()),
    }
}

/// Mass matrix of a device at a position, for a table of masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseMass {
    /// Position of the handle `[m]`.
    pub position: Vector,
    /// The matrix along the device's axes, `[xx, yy, zz, xy, xz, yz]` `[kg]`.
    pub matrix: [f64; 6],
}

impl PoseMass {
    /// Returns the library's matrix at the present pose; `None` if it has none that is plausible.
    fn of(device: &DhdDevice) -> Option<Self> {
        let [[xx, xy, xz, ..], [_, yy, yz, ..], [_, _, zz, ..], ..] = device.inertia()?;
        let (result, position) = device.position();
        let is_plausible = [xx, yy, zz]
            .iter()
            .all(|mass| PLAUSIBLE_MASS.contains(mass));
        // Positive definite, with masses above 0.
        let minors = [
            xx * yy - xy * xy,
            xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz),
        ];
        let is_definite = minors.iter().all(|minor| *minor > 0.0);
        (result >= 0 && is_plausible && is_definite).then_some(Self {
            position,
            matrix: [xx, yy, zz, xy, xz, yz],
        })
    }

    /// Returns the mean mass along the axes `[kg]`.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let [xx, yy, zz, ..] = self.matrix;
        (xx + yy + zz) / 3.0
    }
}

fn capabilities(
    kind: &Kind,
    part: Part,
    holds_last_force: bool,
    effective_mass: Option<f64>,
) -> Capabilities {
    match part {
        Part::Handle => Capabilities {
            torque_axes: if kind.largest_torque.is_some() { 3 } else { 0 },
            measures_orientation: kind.has_wrist,
            largest_force: Some(kind.largest_force),
            largest_torque: kind.largest_torque,
            largest_stiffness: kind.largest_stiffness,
            largest_damping: kind.largest_damping,
            effective_mass,
            holds_last_force,
            ..Capabilities::unknown(kind.name, 3)
        },
        Part::Gripper => Capabilities {
            largest_force: kind.largest_grip,
            holds_last_force,
            ..Capabilities::unknown(&format!("{} gripper", kind.name), 1)
        },
    }
}
