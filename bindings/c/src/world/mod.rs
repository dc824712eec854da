//! World handle: several devices, bodies and contacts in space.

mod change;
mod contacts;
mod methods;
mod output;
mod params;
mod sample;
mod state;
mod step;

pub use change::*;
pub use contacts::*;
pub use methods::*;
pub use output::*;
pub use params::*;
pub use sample::*;
pub use state::*;
pub use step::*;

use core::ffi::c_char;
use core::ptr;
use std::ffi::CString;

use palpate_rt::{BoundedWorld, WorldRows};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_world::{IDENTITY, Quaternion, Vector, WorldErrors};

use crate::edge::status;
use crate::identity::Identity;
use crate::scene::{self, Scene};
use crate::status::{Refusal, Status};
use crate::text;

/// A rendered world. Only one thread may use it at a time.
pub struct World {
    pub(crate) bounded: BoundedWorld,
    pub(crate) devices: Vec<ToolDevice>,
    pub(crate) bodies: Vec<CString>,
    /// For recordings: identity, source text of the scene if there is one, and method.
    pub(crate) identity: Identity,
    pub(crate) source: Option<String>,
    pub(crate) method: String,
    /// For recordings: number of changes.
    pub(crate) changes: u64,
    /// For recordings: scratch buffer for a tick.
    pub(crate) rows: WorldRows,
    /// Scratch buffer for the positions of a sample [m].
    pub(crate) positions: Vec<Vector>,
    /// Scratch buffer for the orientations of a sample.
    pub(crate) orientations: Vec<Quaternion>,
}

/// A device of the scene.
pub(crate) struct ToolDevice {
    pub name: CString,
    /// Whether the device measures six axes.
    pub turns: bool,
    /// Whether a device of six axes gives a torque.
    pub gives_torque: bool,
}

/// Creates the world of a scene file and stores it in `*world`, or NULL on an error. Free it with
/// palpate_world_free. Mesh files are searched beside the scene. `params` may be NULL: all defaults.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_open(
    path: *const c_char,
    params: *const WorldParams,
    world: *mut *mut World,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        make(params, world, || {
            let (path, text) = scene::text_of_file(path)?;
            Ok((path.to_owned(), text))
        })
    }
}

/// Creates a world from the text of a scene. `name` is the path of the scene for messages, and mesh files
/// are searched beside it; NULL: the working directory. Otherwise as palpate_world_open.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_new(
    scene: *const c_char,
    name: *const c_char,
    params: *const WorldParams,
    world: *mut *mut World,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        make(params, world, || {
            let name = if name.is_null() {
                "scene"
            } else {
                text::read(name, "name")?
            };
            Ok((name.to_owned(), text::read(scene, "scene")?.to_owned()))
        })
    }
}

/// Creates a world from the name and text that `source` returns.
///
/// # Safety
/// As for `palpate_world_open`.
unsafe fn make<'a>(
    params: *const WorldParams,
    world: *mut *mut World,
    source: impl FnOnce() -> Result<(String, String), Refusal<'a>>,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        *out = ptr::null_mut();
        // SAFETY: guaranteed by the caller.
        let asked = unsafe { Asked::at(params) }?;
        let (name, text) = source()?;
        let file =
            WorldFile::parse(&name, &text).map_err(|errors| Refusal::Scene(errors.to_string()))?;
        let words = |faults: &WorldErrors| in_words(&file, faults, asked.method.is_some());
        let world = World::new(&file.scene, Some(text), &asked, words)?;
        *out = Box::into_raw(Box::new(world));
        Ok(())
    })
}

/// Creates the world of a scene and stores it in `*world`, or NULL on an error. Free it with palpate_world_free. The
/// scene is not modified, and later changes of the scene do not affect the world. `params` may be NULL: all
/// defaults.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_of_scene(
    scene: *mut Scene,
    params: *const WorldParams,
    world: *mut *mut World,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        *out = ptr::null_mut();
        // SAFETY: guaranteed by the caller.
        let (scene, asked) = unsafe { (scene::at(scene)?, Asked::at(params)?) };
        let source = scene.source.clone();
        let world = World::new(&scene.scene, source, &asked, WorldErrors::to_string)?;
        *out = Box::into_raw(Box::new(world));
        Ok(())
    })
}

impl World {
    fn new<'a>(
        scene: &WorldScene,
        source: Option<String>,
        asked: &Asked,
        in_words: impl FnOnce(&WorldErrors) -> String,
    ) -> Result<Self, Refusal<'a>> {
        let mut scene = scene.clone();
        let limits = asked.limits(&mut scene);
        let method = asked.method.as_ref().unwrap_or(&scene.render.method);
        let renderer = scene.renderer(method).map_err(|faults| {
            let is_all = |place| faults.iter().all(|fault| fault.part == place);
            let words = in_words(&faults);
            if asked.method.is_some() && is_all(palpate_world::WorldPart::Method) {
                Refusal::WorldMethod(words)
            } else if asked.has_limits() && is_all(palpate_world::WorldPart::Loop) {
                Refusal::Numbers(words)
            } else {
                Refusal::Scene(words)
            }
        })?;
        let bounded = BoundedWorld::new(renderer, limits)
            .map_err(|error| Refusal::Numbers(error.to_string()))?;
        let tools = &scene.world.tools;
        Ok(Self {
            identity: Identity::next(),
            source,
            method: method.to_owned(),
            changes: 0,
            rows: WorldRows::new(&scene.world, bounded.state()),
            bounded,
            devices: tools
                .iter()
                .map(|tool| ToolDevice {
                    name: as_c(&tool.name),
                    turns: tool.turns,
                    gives_torque: tool.gives_torque,
                })
                .collect(),
            bodies: names_of_bodies(&scene.world),
            positions: vec![[0.0; 3]; tools.len()],
            orientations: vec![IDENTITY; tools.len()],
        })
    }
}

/// Converts a name to a C string. Names from files and from C contain no 0.
fn as_c(name: &str) -> CString {
    CString::new(name).unwrap_or_default()
}

fn names_of_bodies(world: &palpate_world::World) -> Vec<CString> {
    world.bodies.iter().map(|body| as_c(&body.name)).collect()
}

/// Returns the faults of a scene, one per line.
fn in_words(file: &WorldFile, faults: &WorldErrors, is_method_given: bool) -> String {
    let lines: Vec<String> = faults
        .iter()
        .map(|fault| {
            let is_of_file = fault.part != palpate_world::WorldPart::Method || !is_method_given;
            if is_of_file {
                file.at(fault.part, fault.field, fault.to_string())
                    .to_string()
            } else {
                format!("method: {}", fault.message)
            }
        })
        .collect();
    lines.join("\n")
}

/// Returns the world at `world`.
///
/// # Safety
/// `world` is NULL or a world that is not modified during `'a`.
pub(crate) unsafe fn at<'a>(world: *const World) -> Result<&'a World, Refusal<'static>> {
    // SAFETY: guaranteed by the caller.
    unsafe { world.as_ref() }.ok_or(Refusal::Null("world"))
}

/// Frees a world. NULL is ignored.
///
/// # Safety
/// `world` is NULL or a world, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_free(world: *mut World) {
    if !world.is_null() {
        // SAFETY: allocated with `Box::into_raw` by `make` or `palpate_world_of_scene`, and not used afterwards.
        drop(unsafe { Box::from_raw(world) });
    }
}
