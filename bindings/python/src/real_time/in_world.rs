//! A world on its devices: their drivers, their frames in the world, and the rendering.

use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device, Vector};
use palpate_drivers::inverse3::Inverse3;
use palpate_drivers::prepared::{WorldPlaceError, world_frame};
use palpate_rt::{OnDevice, RenderedWorld, WorldAxis, WorldFrame};
use palpate_scene::world::{WorldDevice, WorldScene};
use palpate_study::device_loop::NotRendered;
use palpate_study::sim::device::{SpatialDevice, SpatialHand, SpatialPointer};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::devices::{Inverse3Given, TwoDiyGiven, two_diy};
use super::ended::Closed;
use super::external::{
    ExternalGiven, ForceDimensionGiven, PluginGiven, external, force_dimension, plugin,
};
use super::held::{Held, Telling};
use super::own_device::OwnDevice;
use crate::names::{refused, wrong_on_bench};
use crate::world::PyWorld;

/// An open device and its frame in the world.
pub struct OpenedInWorld {
    /// The device.
    pub device: Box<dyn Device>,
    /// Frame of the device in the world.
    pub frame: WorldFrame,
    /// Force that the device holds.
    pub held: Held,
    /// Message at the end.
    pub closed: Closed,
    /// Unique identity of a physical device on this machine.
    pub identity: Option<String>,
}

/// Target pose of a simulated hand in a world, which Python can set at any time.
#[pyclass(frozen, name = "HandInWorld", module = "palpate._palpate")]
pub struct HandInWorld(SpatialHand);

#[pymethods]
impl HandInWorld {
    /// Creates a hand that holds its device at `target` `[m]`.
    #[new]
    fn new(target: Vector) -> PyResult<Self> {
        let hand = Self(SpatialHand::at([0.0; 3]));
        hand.move_to(target)?;
        Ok(hand)
    }

    /// Sets the target `[m]` and grasps the device if it was released.
    fn move_to(&self, target: Vector) -> PyResult<()> {
        if let Some(wrong) = target.iter().find(|x| !x.is_finite()) {
            return Err(refused(format!(
                "target has a coordinate of {wrong} m, but all must be finite"
            )));
        }
        self.0.move_to(target);
        Ok(())
    }

    /// Releases the device.
    fn disable_output(&self) {
        self.0.disable_output();
    }

    /// Sets the target orientation of a device of six axes, a quaternion `[w, x, y, z]` of any length above 0; None:
    /// the initial orientation.
    fn turn_to(&self, orientation: Option<[f64; 4]>) -> PyResult<()> {
        let Some(orientation) = orientation else {
            self.0.turn_back();
            return Ok(());
        };
        let length = orientation
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Err(refused(format!(
                "orientation is {orientation:?}, but must be a quaternion w, x, y, z of a length above 0"
            )));
        }
        self.0.turn_to(orientation);
        Ok(())
    }

    /// Target orientation; None: the initial orientation.
    #[getter]
    fn orientation(&self) -> Option<[f64; 4]> {
        self.0.orientation()
    }

    /// Target position `[m]`; None if the device is released.
    #[getter]
    fn target(&self) -> Option<Vector> {
        self.0.target()
    }
}

/// Arguments that locate a device in a world; None: default.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Standing {
    origin: Option<Vec<f64>>,
    normal: Option<Vec<f64>>,
    world_axes: Option<Vec<String>>,
}

/// Opens the device that `given` describes as the world's device `own` called `name`, for a loop of `period` with at
/// most `silence` between commands.
pub fn open(
    py: Python<'_>,
    given: &Bound<'_, PyDict>,
    (name, own): (&str, &WorldDevice),
    clock: MonotonicClock,
    (period, silence): (Duration, Duration),
) -> PyResult<OpenedInWorld> {
    let kind: String = given.as_any().get_item("kind")?.extract()?;
    let closed = Closed::default();
    let mut identity = None;
    let (device, frame): (Box<dyn Device>, _) = match kind.as_str() {
        "simulated-in-world" => {
            let (scene, number) = own_device(given, name)?;
            let device = SpatialDevice::new(&scene, number, clock);
            let device = device.map_err(|error| wrong_on_bench(&error))?;
            let at = scene.devices[number].position;
            let frame = Standing::nowhere().frame(device.capabilities(), None, at)?;
            (Box::new(device), frame)
        }
        "pointer-in-world" => {
            let hand: Py<HandInWorld> = given.as_any().get_item("hand")?.extract()?;
            let (scene, number) = own_device(given, name)?;
            let device = SpatialPointer::new(&scene, number, &hand.get().0, clock);
            let device = device.map_err(|error| wrong_on_bench(&error))?;
            let at = scene.devices[number].position;
            let frame = Standing::nowhere().frame(device.capabilities(), None, at)?;
            (Box::new(device), frame)
        }
        "haply-2diy" => {
            let (device_given, standing): (TwoDiyGiven, Standing) =
                (given.extract()?, given.extract()?);
            standing.check()?;
            let opening = || two_diy(&device_given, clock, period, silence, &closed);
            let (device, (usual, _), which) = py.detach(opening)?;
            identity = which;
            let frame = standing.frame(device.capabilities(), Some(usual), own.position)?;
            (device, frame)
        }
        "inverse3" => {
            let (device_given, standing): (Inverse3Given, Standing) =
                (given.extract()?, given.extract()?);
            standing.check()?;
            let options = device_given.options(period);
            let device = py.detach(|| Inverse3::open(&options, clock));
            let device = device.map_err(|error| PyOSError::new_err(error.to_string()))?;
            let which =
                palpate_drivers::prepared::inverse3::identity(&options.service, device.device_id());
            identity = Some(which);
            let usual = device.opened_at();
            let frame = standing.frame(device.capabilities(), Some(usual), own.position)?;
            (Box::new(device), frame)
        }
        "external" => {
            let (device_given, standing): (ExternalGiven, Standing) =
                (given.extract()?, given.extract()?);
            standing.check()?;
            let opening = || external(&device_given, clock, period, silence, &closed);
            let (device, which) = py.detach(opening)?;
            identity = which;
            let frame = standing.frame(device.capabilities(), None, own.position)?;
            (device, frame)
        }
        "force-dimension" => {
            let (device_given, standing): (ForceDimensionGiven, Standing) =
                (given.extract()?, given.extract()?);
            standing.check()?;
            let opening = || force_dimension(&device_given, clock, period, silence, &closed);
            let (device, which) = py.detach(opening)?;
            identity = which;
            let frame = standing.frame(device.capabilities(), None, own.position)?;
            (device, frame)
        }
        "plugin" => {
            let (device_given, standing): (PluginGiven, Standing) =
                (given.extract()?, given.extract()?);
            standing.check()?;
            let (device, which) = py.detach(|| plugin(&device_given, clock, &closed))?;
            identity = which;
            let frame = standing.frame(device.capabilities(), None, own.position)?;
            (device, frame)
        }
        "own" => {
            let standing: Standing = given.extract()?;
            standing.check()?;
            let device = OwnDevice::new(given.as_any(), clock)?;
            let frame = standing.frame(device.capabilities(), None, own.position)?;
            (Box::new(device), frame)
        }
        _ => {
            return Err(refused(
                "device moves along one axis, or is of a scene of one contact; a world runs on \
                 palpate.devices.PointerInWorld, Simulated of a World, TwoDiy, Inverse3, ForceDimension and \
                 devices of your own",
            ));
        }
    };
    let held = Held::default();
    Ok(OpenedInWorld {
        device: Box::new(Telling::new(device, held.clone())),
        frame,
        held,
        closed,
        identity,
    })
}

/// Returns the scene that a simulated device belongs to with the index of the device: its only one, or the one named in
/// `given`, or by default the one called `name`.
fn own_device(given: &Bound<'_, PyDict>, name: &str) -> PyResult<(WorldScene, usize)> {
    let world = given.as_any().get_item("world")?;
    let world = world.cast::<PyWorld>()?.borrow();
    let scene = world.scene();
    if scene.devices.len() == 1 {
        return Ok((scene.clone(), 0));
    }
    let said: Option<String> = given
        .get_item("device")?
        .map(|said| said.extract())
        .transpose()?
        .flatten();
    let name = said.as_deref().unwrap_or(name);
    let mut tools = scene.world.tools.iter();
    let number = tools.position(|tool| tool.name == name).ok_or_else(|| {
        refused(format!(
            "the world of the simulated device has no device called \"{name}\""
        ))
    })?;
    Ok((scene.clone(), number))
}

/// Returns the rendering of a world on these devices, with limits within those of the devices.
pub fn rendered(world: &PyWorld, on: &[OnDevice]) -> PyResult<RenderedWorld> {
    palpate_study::device_loop::rendered(world.scene(), &world.method, on).map_err(|error| {
        match error {
            NotRendered::World(faults) => world.wrong(&faults),
            NotRendered::Devices(error) => refused(error),
        }
    })
}

impl Standing {
    fn nowhere() -> Self {
        Self {
            origin: None,
            normal: None,
            world_axes: None,
        }
    }

    fn check(&self) -> PyResult<()> {
        if self.normal.is_some() {
            return Err(refused(
                "normal is for a Renderer; for a World, give world_axes",
            ));
        }
        Ok(())
    }

    fn frame(
        &self,
        device: &Capabilities,
        usual: Option<Vector>,
        place: Vector,
    ) -> PyResult<WorldFrame> {
        let axes = self.world_axes.as_deref().map(axes).transpose()?;
        let frame = world_frame(
            self.origin.as_deref(),
            axes.as_deref(),
            device,
            usual,
            place,
        );
        frame.map_err(|error| match error {
            WorldPlaceError::Origin(_) => refused(format!("origin: {error}")),
            _ => refused(format!("world_axes: {error}")),
        })
    }
}

/// Parses world axes by their letters, with - if the device's axis points in the opposite direction.
fn axes(words: &[String]) -> PyResult<Vec<WorldAxis>> {
    let axis = |word: &String| {
        let letter = word.strip_prefix('-').unwrap_or(word);
        let number = ["x", "y", "z"].iter().position(|name| *name == letter);
        let along = WorldAxis::along(number.ok_or_else(|| {
            refused(format!(
                "world_axes names \"{word}\", but must name x, y and z, with - for a reversed axis"
            ))
        })?);
        Ok(if letter == word {
            along
        } else {
            along.reversed()
        })
    };
    words.iter().map(axis).collect()
}
