//! A device whose driver is a Python object. Its calls take the lock of the interpreter in the tick.

use palpate_device::clock::{Clock, MonotonicClock};
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench, ZeroWriter,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::names::refused;

/// Arguments of the device `own`.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct OwnGiven {
    driver: Py<PyAny>,
    has_zero: bool,
    name: String,
    axes: usize,
    torque_axes: usize,
    orientation: bool,
    largest_force: Option<f64>,
    largest_torque: Option<f64>,
    effective_mass: Option<f64>,
    encoder_quantum: Option<f64>,
}

/// A device whose `read` and `write` are methods of a Python object.
pub struct OwnDevice {
    clock: MonotonicClock,
    capabilities: Capabilities,
    driver: Py<PyAny>,
    has_zero: bool,
    has_failed: bool,
}

impl OwnDevice {
    /// Creates the device that `given` describes.
    pub fn new(given: &Bound<'_, PyAny>, clock: MonotonicClock) -> PyResult<Self> {
        let given: OwnGiven = given.extract()?;
        if !(1..=3).contains(&given.axes) {
            return Err(refused(format!(
                "axes is {}, but must be 1, 2 or 3",
                given.axes
            )));
        }
        if given.torque_axes > 3 || (given.torque_axes > 0 && !given.orientation) {
            return Err(refused(format!(
                "torque_axes is {}, but must be 0 to 3, and 0 without orientation",
                given.torque_axes
            )));
        }
        for (name, value) in [
            ("largest_force", given.largest_force),
            ("largest_torque", given.largest_torque),
            ("effective_mass", given.effective_mass),
            ("encoder_quantum", given.encoder_quantum),
        ] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(refused(format!(
                    "{name} is {value}, but must be finite and above 0, or None"
                )));
            }
        }
        Ok(Self {
            clock,
            capabilities: Capabilities {
                torque_axes: given.torque_axes,
                measures_orientation: given.orientation,
                largest_force: given.largest_force,
                largest_torque: given.largest_torque,
                effective_mass: given.effective_mass,
                encoder_quantum: given.encoder_quantum,
                // Nothing is known of its amplifier.
                holds_last_force: true,
                ..Capabilities::unknown(&given.name, given.axes)
            },
            driver: given.driver,
            has_zero: given.has_zero,
            has_failed: false,
        })
    }

    /// Calls the driver. The first exception is kept for `Loop.stop` and ends the loop.
    fn call<T>(
        &mut self,
        call: impl FnOnce(&Capabilities, &Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, DeviceError> {
        Python::attach(|py| {
            let driver = self.driver.bind(py);
            call(&self.capabilities, driver).map_err(|error| {
                if !std::mem::replace(&mut self.has_failed, true) {
                    let _ = driver.setattr("_raised", error.into_value(py));
                }
                raised()
            })
        })
    }
}

fn raised() -> DeviceError {
    DeviceError::new(
        DeviceErrorKind::Disconnected,
        "the device's Python code has raised an exception",
    )
}

/// Returns position and orientation, if `read` has returned a sample.
fn sample(
    can: &Capabilities,
    read: &Bound<'_, PyAny>,
) -> PyResult<Option<(Vector, Option<[f64; 4]>)>> {
    if read.is_none() {
        return Ok(None);
    }
    let (position, orientation) = if can.measures_orientation {
        let (position, orientation): (Bound<'_, PyAny>, [f64; 4]) =
            read.extract().map_err(|_| {
                PyTypeError::new_err(
                    "read must return a position and an orientation w, x, y, z, or None",
                )
            })?;
        (position, Some(orientation))
    } else {
        (read.clone(), None)
    };
    let values = match position.extract::<f64>() {
        Ok(value) => vec![value],
        Err(_) => position.extract::<Vec<f64>>()?,
    };
    if values.len() != can.axes {
        return Err(PyValueError::new_err(format!(
            "read returned {} coordinates, but the device has {} axes",
            values.len(),
            can.axes
        )));
    }
    let mut numbers = values.iter().chain(orientation.iter().flatten());
    if let Some(wrong) = numbers.find(|number| !number.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "read returned {wrong}, but all must be finite"
        )));
    }
    let mut place = [0.0; 3];
    for (place, value) in place.iter_mut().zip(values) {
        *place = value;
    }
    let orientation = orientation.map(unit).transpose()?;
    Ok(Some((place, orientation)))
}

fn unit(quaternion: [f64; 4]) -> PyResult<[f64; 4]> {
    let length = quaternion
        .iter()
        .map(|part| part * part)
        .sum::<f64>()
        .sqrt();
    if !(0.99..=1.01).contains(&length) {
        return Err(PyValueError::new_err(format!(
            "read returned an orientation of the length {length}, but it must be 1"
        )));
    }
    Ok(quaternion.map(|part| part / length))
}

/// Returns the arguments of `write`: a number for one axis, else a tuple; and a tuple of torques, if there are any.
fn arguments<'py>(
    py: Python<'py>,
    can: &Capabilities,
    wrench: &Wrench,
) -> PyResult<Bound<'py, PyTuple>> {
    let [x, ..] = wrench.force;
    let force = if can.axes == 1 {
        x.into_pyobject(py)?.into_any()
    } else {
        PyTuple::new(py, wrench.force.iter().take(can.axes))?.into_any()
    };
    if can.torque_axes == 0 {
        return PyTuple::new(py, [force]);
    }
    let torque = PyTuple::new(py, wrench.torque.iter().take(can.torque_axes))?;
    PyTuple::new(py, [force, torque.into_any()])
}

impl Device for OwnDevice {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.has_failed {
            return Err(raised());
        }
        let read = self.call(|can, driver| sample(can, &driver.call_method0("read")?))?;
        let (position, orientation) = read.ok_or(DeviceError::new(
            DeviceErrorKind::NothingNew,
            "no new sample from the device",
        ))?;
        Ok(Pose {
            position,
            orientation,
            time: self.clock.now(),
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        // After an exception the device still gets the zero force that ends the loop, and no other.
        let given = if self.has_failed {
            Wrench::NONE
        } else {
            palpate_drivers::prepared::on_axes(&self.capabilities, wrench)
        };
        self.call(|can, driver| {
            let arguments = arguments(driver.py(), can, &given)?;
            driver.call_method1("write", arguments).map(|_| ())
        })?;
        if self.has_failed {
            return Err(raised());
        }
        if wrench.is_finite() {
            Ok(given)
        } else {
            Err(DeviceError::new(
                DeviceErrorKind::Refused,
                "the force is not finite",
            ))
        }
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Py<PyAny>);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                // Its exception has no receiver: the loop itself stalls.
                Python::attach(|py| {
                    let _ = self.0.bind(py).call_method0("zero");
                });
            }
        }
        if !self.has_zero {
            return None;
        }
        Python::attach(|py| Some(Box::new(Zero(self.driver.clone_ref(py))) as Box<dyn ZeroWriter>))
    }
}
