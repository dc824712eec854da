//! Devices of shared libraries with a C interface (`bindings/c/include/palpate_device.h`), loaded at run time.

pub(crate) mod library;

use std::path::Path;
use std::sync::Arc;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};

use crate::device_time::{DeviceTime, Stamp};
use crate::prepared::on_axes;
pub use library::LibraryError;
use library::{DISCONNECTED, NOTHING_NEW, Opened, RawCapabilities, RawSample, RawWrench, u32_size};

/// Reason why the device of a library could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PluginError {
    /// The library cannot be used.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The library returned this code for its capabilities.
    #[error("it has no capabilities (code {0}){1}")]
    NoCapabilities(i32, String),
    /// A value of the capabilities.
    #[error("{key} is {value}; allowed: {allowed}")]
    Capability {
        /// Name of the value.
        key: &'static str,
        /// The value.
        value: f64,
        /// Range.
        allowed: &'static str,
    },
}

/// The device of a shared library.
///
/// Calls of the library run in the tick: the loop has the guarantees of the library's code. When this is dropped, the
/// last command is zero force. No watchdog process can reach the device: if this program is killed, only the device's own
/// timeout removes the force.
pub struct Plugin<C: Clock> {
    clock: C,
    capabilities: Capabilities,
    opened: Arc<Opened>,
    time: DeviceTime,
    has_failed: bool,
    tell: Option<Box<dyn FnOnce(String) + Send>>,
}

impl<C: Clock> std::fmt::Debug for Plugin<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Plugin")
            .field("capabilities", &self.capabilities)
            .finish_non_exhaustive()
    }
}

impl<C: Clock> Plugin<C> {
    /// Loads the library at `path` and opens its device with `argument`, which only the library interprets. `tell`
    /// receives its last error at the end, if a call failed.
    ///
    /// # Errors
    /// The library is missing, has another version or other structures, lacks a function, or refuses.
    pub fn open(
        path: &Path,
        argument: &str,
        clock: C,
        tell: impl FnOnce(String) + Send + 'static,
    ) -> Result<Self, PluginError> {
        let opened = Opened::open(path, argument)?;
        let can = opened.capabilities().map_err(|code| {
            let why = opened
                .error()
                .map_or_else(String::new, |text| format!(": {text}"));
            PluginError::NoCapabilities(code, why)
        })?;
        let name = opened.name().unwrap_or_else(|| "plug-in".to_owned());
        Ok(Self {
            clock,
            capabilities: checked(&can, &name)?,
            opened: Arc::new(opened),
            time: DeviceTime::default(),
            has_failed: false,
            tell: Some(Box::new(tell)),
        })
    }

    fn failed(&mut self, code: i32) -> DeviceError {
        let (kind, what) = match code {
            NOTHING_NEW => {
                return DeviceError::new(
                    DeviceErrorKind::NothingNew,
                    "no new sample from the plug-in",
                );
            }
            DISCONNECTED => (
                DeviceErrorKind::Disconnected,
                "the device of the plug-in is gone",
            ),
            _ => (
                DeviceErrorKind::Interrupted,
                "the device of the plug-in reports an error",
            ),
        };
        self.has_failed = true;
        DeviceError::new(kind, what)
    }
}

/// Checks the capabilities of a library.
fn checked(raw: &RawCapabilities, name: &str) -> Result<Capabilities, PluginError> {
    let count = |key, value: u32, least: usize| {
        let number = usize::try_from(value).ok();
        number
            .filter(|number| (least..=3).contains(number))
            .ok_or(PluginError::Capability {
                key,
                value: value.into(),
                allowed: if least == 0 { "0 to 3" } else { "1 to 3" },
            })
    };
    // 0 means unknown.
    let known = |key, value: f64| match value {
        0.0 => Ok(None),
        value if value.is_finite() && value > 0.0 => Ok(Some(value)),
        value => Err(PluginError::Capability {
            key,
            value,
            allowed: "0 for unknown, else finite numbers above 0",
        }),
    };
    let axes = count("axes", raw.axes, 1)?;
    let torque_axes = count("torque_axes", raw.torque_axes, 0)?;
    if torque_axes > 0 && raw.has_orientation == 0 {
        return Err(PluginError::Capability {
            key: "torque_axes",
            value: raw.torque_axes.into(),
            allowed: "0 without has_orientation",
        });
    }
    Ok(Capabilities {
        torque_axes,
        measures_orientation: raw.has_orientation != 0,
        largest_force: known("largest_force_n", raw.largest_force_n)?,
        largest_torque: known("largest_torque_n_m", raw.largest_torque_n_m)?,
        largest_stiffness: known("largest_stiffness_n_per_m", raw.largest_stiffness_n_per_m)?,
        largest_damping: known("largest_damping_n_s_per_m", raw.largest_damping_n_s_per_m)?,
        effective_mass: known("mass_kg", raw.mass_kg)?,
        encoder_quantum: known("quantum_m", raw.quantum_m)?,
        holds_last_force: raw.holds_last_force != 0,
        ..Capabilities::unknown(name, axes)
    })
}

/// Returns position and orientation of a sample on the device's axes, if they are numbers.
fn placed(raw: &RawSample, can: &Capabilities) -> Option<([f64; 3], Option<[f64; 4]>)> {
    let mut position = [0.0; 3];
    for (place, value) in position.iter_mut().zip(raw.position_m).take(can.axes) {
        *place = Some(value).filter(|value| value.is_finite())?;
    }
    if !can.measures_orientation {
        return Some((position, None));
    }
    let length = raw
        .orientation
        .iter()
        .map(|part| part * part)
        .sum::<f64>()
        .sqrt();
    let is_unit = (0.99..=1.01).contains(&length);
    is_unit.then(|| (position, Some(raw.orientation.map(|part| part / length))))
}

impl<C: Clock> Device for Plugin<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let refused = |what| DeviceError::new(DeviceErrorKind::Refused, what);
        let interrupted = |what| DeviceError::new(DeviceErrorKind::Interrupted, what);
        let raw = self.opened.read().map_err(|code| self.failed(code))?;
        let now = self.clock.now();
        let (position, orientation) = placed(&raw, &self.capabilities).ok_or(interrupted(
            "the plug-in returns a position or an orientation that is no number",
        ))?;
        let time = if raw.has_time == 0 {
            now
        } else {
            if !raw.time_s.is_finite() {
                return Err(interrupted("the plug-in returns a time that is no number"));
            }
            match self.time.of(raw.time_s, now) {
                Stamp::At(time) => time,
                Stamp::NotLater => return Err(self.failed(NOTHING_NEW)),
                Stamp::NotSeconds => {
                    return Err(refused(
                        "the plug-in's clock does not run in seconds; without such a clock has_time is 0",
                    ));
                }
            }
        };
        Ok(Pose {
            position,
            orientation,
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let given = on_axes(&self.capabilities, wrench);
        let raw = RawWrench {
            size: u32_size::<RawWrench>(),
            force_n: given.force,
            torque_n_m: given.torque,
            ..RawWrench::default()
        };
        let held = self.opened.write(&raw).map_err(|code| self.failed(code))?;
        let held = Wrench {
            force: held.force_n,
            torque: held.torque_n_m,
        };
        if !held.is_finite() || !wrench.is_finite() {
            let what = "the force of the command, or the one that the plug-in holds, is no number";
            return Err(DeviceError::new(DeviceErrorKind::Interrupted, what));
        }
        Ok(held)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Arc<Opened>);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                self.0.zero();
            }
        }
        self.opened
            .has_zero()
            .then(|| Box::new(Zero(Arc::clone(&self.opened))) as Box<dyn ZeroWriter>)
    }
}

impl<C: Clock> Drop for Plugin<C> {
    fn drop(&mut self) {
        let written = self.write(Wrench::NONE);
        if let Some(tell) = self
            .tell
            .take()
            .filter(|_| self.has_failed || written.is_err())
        {
            let why = self
                .opened
                .error()
                .unwrap_or_else(|| "it gives no reason".to_owned());
            tell(format!("the plug-in reported an error: {why}"));
        }
    }
}
