//! Descriptions of worlds that are made and changed by calls.

mod bodies;
mod laws;
mod params;
mod parts;
mod shape;

pub use bodies::*;
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

use palpate_scene::scene_bytes;
use palpate_scene::world::{
    Coupling, WorldActuator, WorldFile, WorldRender, WorldScene, WorldTiming,
};
use palpate_world::{World, WorldError, WorldField, WorldGuard};

use crate::edge::status;
use crate::status::{Refusal, Status};
use crate::text;

/// What a world is made of: its loop, devices, bodies, laws of contacts and joints. It renders nothing: a world is made of it,
/// or changed to it, and knows nothing of it afterwards. One thread at a time may use it.
pub struct Scene {
    pub(crate) scene: WorldScene,
    /// The text of a scene file that says the same.
    pub(crate) source: Option<String>,
}

/// How long a scene of calls would be simulated, which nobody does [s].
const DURATION: f64 = 0.5;

/// The scene at `scene`.
///
/// # Safety
/// `scene` is NULL or a scene, which nobody else uses during `'a`.
pub(crate) unsafe fn at<'a>(scene: *mut Scene) -> Result<&'a mut Scene, Refusal<'static>> {
    // SAFETY: as the caller says.
    unsafe { scene.as_mut() }.ok_or(Refusal::Null("scene"))
}

/// The name at `name`, which is called `what` in messages.
///
/// # Safety
/// `name` is NULL, or a 0 ends what it points to, which nobody changes during `'a`.
unsafe fn named<'a>(name: *const c_char, what: &'static str) -> Result<&'a str, Refusal<'a>> {
    // SAFETY: as the caller says.
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

/// Every fault in a line of its own.
pub(crate) fn in_words(faults: &[WorldError]) -> String {
    let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// Makes an empty scene, to be freed by palpate_scene_free, and puts it into `*scene`; NULL on an error. It has no devices, no
/// bodies, no laws and no joints yet.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_new(
    params: *const SceneParams,
    scene: *mut *mut Scene,
) -> Status {
    // SAFETY: as the caller says.
    unsafe {
        make(scene, || {
            let params = SceneParams::at(params)?;
            let actuator = WorldActuator {
                delay: params.delay,
                lag: params.lag,
                gain: params.gain,
            };
            let said = |number: f64| (number != 0.0).then_some(number);
            let scene = WorldScene {
                title: String::new(),
                world: World::default(),
                devices: Vec::new(),
                timing: WorldTiming {
                    period: params.period,
                    actuator,
                },
                render: WorldRender {
                    method: "coupled".to_owned(),
                    device_mass: Vec::new(),
                    device_inertia: Vec::new(),
                    damping: said(params.damping),
                    rotational_damping: said(params.rotational_damping),
                    coupling: Coupling {
                        stiffness: said(params.coupling_stiffness),
                        mass: said(params.coupling_mass),
                        rotational_stiffness: said(params.coupling_rotational_stiffness),
                        inertia: said(params.coupling_inertia),
                    },
                    force_limit: None,
                    torque_limit: None,
                    actuator,
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

/// Makes the scene of a scene file of format 2, to be changed by calls. The rest is as for palpate_scene_new and
/// palpate_world_open.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_open(path: *const c_char, scene: *mut *mut Scene) -> Status {
    // SAFETY: as the caller says.
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

/// The path of a scene file, and its text.
///
/// # Safety
/// `path` is NULL, or a 0 ends what it points to, which nobody changes during `'a`.
pub(crate) unsafe fn text_of_file<'a>(
    path: *const c_char,
) -> Result<(&'a str, String), Refusal<'a>> {
    // SAFETY: as the caller says.
    let path = unsafe { text::read(path, "path") }?;
    if path.is_empty() {
        return Err(wrong("path is \"\", but must name a file"));
    }
    let bytes = scene_bytes(Path::new(path)).map_err(|error| wrong(format!("{path}: {error}")))?;
    let text = String::from_utf8(bytes).map_err(|error| wrong(format!("{path}: {error}")))?;
    Ok((path, text))
}

/// Makes a scene by `made`.
///
/// # Safety
/// `scene` is NULL, or a pointer can be written there.
unsafe fn make<'a>(
    scene: *mut *mut Scene,
    made: impl FnOnce() -> Result<Scene, Refusal<'a>>,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let out = unsafe { scene.as_mut() }.ok_or(Refusal::Null("scene"))?;
        *out = ptr::null_mut();
        *out = Box::into_raw(Box::new(made()?));
        Ok(())
    })
}

/// Frees a scene; worlds that were made of it stay. NULL is left alone.
///
/// # Safety
/// `scene` is NULL or a scene, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_scene_free(scene: *mut Scene) {
    if !scene.is_null() {
        // SAFETY: `make` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(scene) });
    }
}

impl Scene {
    /// Changes the scene: nothing of a text says it any more.
    fn edit(&mut self) -> &mut WorldScene {
        self.source = None;
        &mut self.scene
    }

    /// A name that no device or body has yet.
    fn free_name(&self, name: &str) -> Result<(), Refusal<'static>> {
        let World { tools, bodies, .. } = &self.scene.world;
        let is_taken = tools.iter().any(|tool| tool.name == *name)
            || bodies.iter().any(|body| body.name == *name);
        if is_taken {
            return Err(wrong(format!(
                "name is {name:?}, which a device or body of the scene has already"
            )));
        }
        Ok(())
    }

    /// The place of the body of that name.
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

    /// The faults of the world that `is` one's, after a change; devices may still be missing. They are those of names, or else
    /// of the numbers that a call has given.
    fn check(&self, is: impl Fn(&WorldError) -> bool) -> Result<(), Refusal<'static>> {
        let faults = self.scene.world.check().err().unwrap_or_default();
        let own: Vec<_> = faults.into_iter().filter(is).collect();
        if own.is_empty() {
            Ok(())
        } else if own.iter().any(|fault| fault.field == WorldField::Between) {
            Err(wrong(in_words(&own)))
        } else {
            Err(Refusal::Numbers(in_words(&own)))
        }
    }
}
