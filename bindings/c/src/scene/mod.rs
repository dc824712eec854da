//! Scenes: descriptions of worlds that C functions create and change.

mod bodies;
mod guard;
mod laws;
mod params;
mod parts;
mod shape;

pub use bodies::*;
pub use guard::*;
pub use laws::*;
pub use params::*;
pub use parts::*;
pub use shape::*;

use core::ffi::c_char;
use core::ptr;
use std::borrow::ToOwned;
use std::boxed::Box;
use std::format;
use std::path::Path;
use std::string::{String, ToString};
use std::vec::Vec;

use palpate_core::Actuation;
use palpate_scene::world::{
    Coupling, WorldFile, WorldRender, WorldScene, WorldSettings, WorldTiming,
};
use palpate_scene::{ActuatorParams, Delay, Timing, scene_bytes};
use palpate_world::{World, WorldError, WorldField, WorldGuard};

use crate::edge::status;
use crate::loop_params::HoldKind;
use crate::status::{Refusal, Status};
use crate::text;

/// Description of a world: its loop, devices, bodies, contact laws and joints. A scene renders nothing. A world is
/// created from it or changed to it, and is independent of it afterwards. Only one thread may use it at a time.
pub struct Scene {
    pub(crate) scene: WorldScene,
    /// Text of the scene file, if the scene is unchanged.
    pub(crate) source: Option<String>,
}

/// Placeholder for the simulated time of a scene, which the C API does not use [s].
const DURATION: f64 = 0.5;

/// Returns the scene at `scene`.
///
/// # Safety
/// `scene` is NULL or a scene that is not used otherwise during `'a`.
pub(crate) unsafe fn at<'a>(scene: *mut Scene) -> Result<&'a mut Scene, Refusal<'static>> {
    // SAFETY: guaranteed by the caller.
    unsafe { scene.as_mut() }.ok_or(Refusal::Null("scene"))
}

/// Reads the name at `name`, called `what` in messages.
///
/// # Safety
/// `name` is NULL or points to a text that is terminated by a 0 and not modified during `'a`.
unsafe fn named<'a>(name: *const c_char, what: &'static str) -> Result<&'a str, Refusal<'a>> {
    // SAFETY: guaranteed by the caller.
    let name = unsafe { text::read(name, what) }?;
    if name.is_empty() || name == "*" || name == "world" {
        return Err(wrong(format!(
            "{what} is {name:?}, but must be a name that is not \"\", \"*\" or \"world\""
        )));
    }
    Ok(name)
}

fn wrong(words: impl Into<String>) -> Refusal<'static> {
    Refusal::Scene(words.into())
}

/// Creates a scene without devices, bodies, laws and joints and stores it in `*scene`, or NULL on an error. Free it
/// with palpate_scene_free.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_new(
    params: *const SceneParams,
    scene: *mut *mut Scene,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        make(scene, || {
            let params = SceneParams::at(params)?;
            let actuator = ActuatorParams {
                lag: params.lag,
                gain: params.gain,
            };
            let said = |number: f64| (number != 0.0).then_some(number);
            let settings = WorldSettings {
                damping: said(params.damping),
                rotational_damping: said(params.rotational_damping),
                coupling: Coupling {
                    stiffness: said(params.coupling_stiffness),
                    mass: said(params.coupling_mass),
                    rotational_stiffness: said(params.coupling_rotational_stiffness),
                    inertia: said(params.coupling_inertia),
                },
                ..WorldSettings::default()
            };
            let scene = WorldScene {
                title: String::new(),
                world: World::default(),
                devices: Vec::new(),
                timing: WorldTiming {
                    period: params.period,
                    delay: Delay::Seconds(params.delay),
                    actuator,
                    imperfections: Timing::default(),
                },
                render: WorldRender {
                    method: "coupled".to_owned(),
                    device_mass: Vec::new(),
                    device_inertia: Vec::new(),
                    sensor_quantum: None,
                    settings: WorldScene::METHODS
                        .into_iter()
                        .map(|method| (method, settings))
                        .collect(),
                    speed_limit: None,
                    largest_gap: None,
                    force_limit: None,
                    torque_limit: None,
                    actuation: Actuation {
                        delay: params.delay,
                        lag: params.lag,
                        gain: params.gain,
                        hold: HoldKind::read(params.hold)?,
                        ..Actuation::default()
                    },
                    guard: WorldGuard::Off,
                },
                duration: DURATION,
            };
            Ok(Scene {
                scene,
                source: None,
            })
        })
    }
}

/// Creates a scene from a scene file, to be changed by calls. Otherwise as palpate_scene_new and
/// palpate_world_open.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_open(path: *const c_char, scene: *mut *mut Scene) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        make(scene, || {
            let (path, text) = text_of_file(path)?;
            let file = WorldFile::parse(path, &text).map_err(|errors| wrong(errors.to_string()))?;
            Ok(Scene {
                scene: file.scene,
                source: Some(text),
            })
        })
    }
}

/// Returns the path of a scene file and its text.
///
/// # Safety
/// `path` is NULL or points to a text that is terminated by a 0 and not modified during `'a`.
pub(crate) unsafe fn text_of_file<'a>(
    path: *const c_char,
) -> Result<(&'a str, String), Refusal<'a>> {
    // SAFETY: guaranteed by the caller.
    let path = unsafe { text::read(path, "path") }?;
    if path.is_empty() {
        return Err(wrong("path is \"\", but must name a file"));
    }
    let bytes = scene_bytes(Path::new(path)).map_err(|error| wrong(format!("{path}: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| wrong(format!("{path}: {error}")))?;
    Ok((path, text))
}

/// Stores the scene that `made` returns.
///
/// # Safety
/// `scene` is NULL, or a pointer can be written there.
unsafe fn make<'a>(
    scene: *mut *mut Scene,
    made: impl FnOnce() -> Result<Scene, Refusal<'a>>,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let out = unsafe { scene.as_mut() }.ok_or(Refusal::Null("scene"))?;
        *out = ptr::null_mut();
        *out = Box::into_raw(Box::new(made()?));
        Ok(())
    })
}

/// Frees a scene. Worlds created from it stay valid. NULL is ignored.
///
/// # Safety
/// `scene` is NULL or a scene, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_free(scene: *mut Scene) {
    if !scene.is_null() {
        // SAFETY: allocated with `Box::into_raw` by `make`, and not used afterwards.
        drop(unsafe { Box::from_raw(scene) });
    }
}

impl Scene {
    /// Returns the scene for a change, after which its source text no longer matches.
    fn edit(&mut self) -> &mut WorldScene {
        self.source = None;
        &mut self.scene
    }

    /// Rejects a name that a device or body already has.
    fn free_name(&self, name: &str) -> Result<(), Refusal<'static>> {
        let World { tools, bodies, .. } = &self.scene.world;
        let is_taken = tools.iter().any(|tool| tool.name == *name)
            || bodies.iter().any(|body| body.name == *name);
        if is_taken {
            return Err(wrong(format!(
                "name is {name:?}, which a device or body of the scene already has"
            )));
        }
        Ok(())
    }

    /// Returns the index of the body with this name.
    fn body(&self, name: &str) -> Result<usize, Refusal<'static>> {
        let bodies = &self.scene.world.bodies;
        let place = bodies.iter().position(|body| body.name == *name);
        place.ok_or_else(|| {
            let names: Vec<_> = bodies.iter().map(|body| body.name.as_str()).collect();
            wrong(format!(
                "name is {name:?}, but must be a body of the scene: {}",
                names.join(", ")
            ))
        })
    }

    /// Checks the world after a change and reports the faults that `is` selects; devices may still be missing. An
    /// unknown name is a scene error, any other fault a parameter error.
    fn check(&self, is: impl Fn(&WorldError) -> bool) -> Result<(), Refusal<'static>> {
        let faults = self.scene.world.check().err().into_iter().flatten();
        let own: Vec<_> = faults.filter(is).collect();
        let words = || {
            own.iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join("\n")
        };
        if own.is_empty() {
            Ok(())
        } else if own.iter().any(|fault| fault.field == WorldField::Between) {
            Err(wrong(words()))
        } else {
            Err(Refusal::Numbers(words()))
        }
    }
}
