//! Worlds behind a handle: several devices, bodies and contacts in space.

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
use palpate_world::{NOT_TURNED, Quaternion, Vector, WorldError};

use crate::edge::status;
use crate::identity::Identity;
use crate::scene::{self, Scene};
use crate::status::{Refusal, Status};
use crate::text;

/// A world that is rendered. One thread at a time may use it.
pub struct World {
    pub(crate) bounded: BoundedWorld,
    pub(crate) devices: Vec<ToolDevice>,
    pub(crate) bodies: Vec<CString>,
    /// For recordings: which world it is, the text of the scene, if one says the world, the method,
    pub(crate) identity: Identity,
    pub(crate) source: Option<String>,
    pub(crate) method: String,
    /// how often it was changed,
    pub(crate) changes: u64,
    /// and room for what they have of a tick.
    pub(crate) rows: WorldRows,
    /// Room for the sample of a tick: positions [m],
    pub(crate) positions: Vec<Vector>,
    /// and orientations.
    pub(crate) orientations: Vec<Quaternion>,
}

/// A device of a world, as the scene says it.
pub(crate) struct ToolDevice {
    pub name: CString,
    /// Whether it measures six axes,
    pub turns: bool,
    /// and gives a torque, too, if it does.
    pub gives_torque: bool,
}

/// Makes the world of a scene file of format 2, to be freed by palpate_world_free, and puts it into `*world`; NULL on
/// an error. Files of meshes are looked for beside the scene. `params` may be NULL: every default.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_open(
    path: *const c_char,
    params: *const WorldParams,
    world: *mut *mut World,
) -> Status {
    // SAFETY: as the caller says.
    unsafe {
        make(params, world, || {
            let (path, text) = scene::text_of_file(path)?;
            Ok((path.to_owned(), text))
        })
    }
}

/// Makes a world of the text of a scene of format 2. `name` stands for the path of the scene in messages, and files of
/// meshes are looked for beside it; NULL: the working folder. The rest is as for palpate_world_open.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_new(
    scene: *const c_char,
    name: *const c_char,
    params: *const WorldParams,
    world: *mut *mut World,
) -> Status {
    // SAFETY: as the caller says.
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

/// The world of a scene, by its name and its text.
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
        // SAFETY: as the caller says.
        let asked = unsafe { Asked::at(params) }?;
        let (name, text) = source()?;
        let file =
            WorldFile::parse(&name, &text).map_err(|errors| Refusal::Scene(errors.to_string()))?;
        let words = |faults: &[WorldError]| in_words(&file, faults, asked.method.is_some());
        let world = World::new(&file.scene, Some(text), &asked, words)?;
        *out = Box::into_raw(Box::new(world));
        Ok(())
    })
}

/// Makes the world of a scene, to be freed by palpate_world_free, and puts it into `*world`; NULL on an error. The scene stays as
/// it is, and what becomes of it does not change the world. `params` may be NULL: every default.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
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
        // SAFETY: as the caller says.
        let (scene, asked) = unsafe { (scene::at(scene)?, Asked::at(params)?) };
        let source = scene.source.clone();
        let world = World::new(&scene.scene, source, &asked, scene::in_words)?;
        *out = Box::into_raw(Box::new(world));
        Ok(())
    })
}

impl World {
    fn new<'a>(
        scene: &WorldScene,
        source: Option<String>,
        asked: &Asked,
        in_words: impl FnOnce(&[WorldError]) -> String,
    ) -> Result<Self, Refusal<'a>> {
        let mut scene = scene.clone();
        let limits = asked.limits(&mut scene.render);
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
            orientations: vec![NOT_TURNED; tools.len()],
        })
    }
}

/// A name as C has it: a name in a file or from C has no 0 in it.
fn as_c(name: &str) -> CString {
    CString::new(name).unwrap_or_default()
}

fn names_of_bodies(world: &palpate_world::World) -> Vec<CString> {
    world.bodies.iter().map(|body| as_c(&body.name)).collect()
}

/// What keeps a world from being rendered, each fault in a line of its own.
fn in_words(file: &WorldFile, faults: &[WorldError], is_method_given: bool) -> String {
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

/// The world at `world`.
///
/// # Safety
/// `world` is NULL or a world that nobody changes during `'a`.
pub(crate) unsafe fn at<'a>(world: *const World) -> Result<&'a World, Refusal<'static>> {
    // SAFETY: as the caller says.
    unsafe { world.as_ref() }.ok_or(Refusal::Null("world"))
}

/// Frees a world. NULL is left alone.
///
/// # Safety
/// `world` is NULL or a world, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_free(world: *mut World) {
    if !world.is_null() {
        // SAFETY: `make` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(world) });
    }
}
