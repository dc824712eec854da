//! Changes of a world that runs, between two ticks.

use core::ffi::c_char;
use std::format;
use std::string::ToString;

use palpate_rt::WorldRows;
use palpate_world::{BodyState as Core, WorldField};

use super::{BodyState, Pose, World, names_of_bodies};
use crate::edge::status;
use crate::scene::{self, Scene};
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;

/// Goes on with another scene from the next tick on. What is there by its name already goes on from where it is, as it moves:
/// what the scene says of its place and velocity is not looked at, but its shape, mass and force, and whether it is fixed, are
/// those of the scene. What has another name begins as the scene says, and what is not in the scene is gone. Laws are those of
/// the scene. A joint of the same bodies, kind, point, axis and span goes on too; another one begins as the bodies stand. Devices
/// have to be the same, in the same order, but for the shapes of their tools; method, period, limits, and what is told of the
/// devices stay as they are. On an error all is as it was.
///
/// What the devices are held by passes over in 0.1 s, without a step; the energy of the change is booked as outside work. It
/// takes memory, as making a world does, and so long: a tick does not. The places of bodies may be other ones afterwards, names
/// that were given are gone, and recorders of the world are to be closed.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_change(world: *mut World, scene: *mut Scene) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: as the caller says.
        let scene = unsafe { scene::at(scene) }?;
        let period = world.bounded.renderer().in_loop().period;
        let given = scene.scene.timing.period;
        if given != period {
            return Err(Refusal::WorldChange(format!(
                "period is {given} s, but must be that of the world, {period} s"
            )));
        }
        let described = &scene.scene.world;
        world
            .bounded
            .change(described)
            .map_err(|faults| Refusal::WorldChange(scene::in_words(&faults)))?;
        world.bodies = names_of_bodies(described);
        world.rows = WorldRows::new(described, world.bounded.state());
        world.source = None;
        world.changes += 1;
        Ok(())
    })
}

/// Puts a body elsewhere from the next tick on, and gives it the velocities of `state`; a fixed one has none. `body` is its
/// place. What the devices are held by passes over in 0.1 s, without a step; the energy of it is booked as outside work. It
/// takes no memory, so the thread of the loop can call it between two ticks. On an error all is as it was.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_place(
    world: *mut World,
    body: usize,
    state: *const BodyState,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: as the caller says.
        let state = unsafe { sized::read(state) }?;
        let count = world.bodies.len();
        if body >= count {
            return Err(Refusal::Index {
                name: "body",
                given: body,
                count,
            });
        }
        let Pose {
            position,
            orientation,
        } = state.pose;
        let to = Core {
            position,
            orientation,
            velocity: state.velocity,
            angular_velocity: state.angular_velocity,
        };
        world.bounded.place(body, &to).map_err(|fault| {
            let mut velocities = to.velocity.iter().chain(&to.angular_velocity);
            // Of numbers that can be, only a fixed body refuses a velocity.
            if fault.field == WorldField::Velocity && velocities.all(|number| number.is_finite()) {
                Refusal::WorldChange(fault.to_string())
            } else {
                Refusal::Numbers(fault.to_string())
            }
        })
    })
}

/// Puts the place of the body of that name into `*body`; it holds until the world is changed.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_body_named(
    world: *const World,
    name: *const c_char,
    body: *mut usize,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (world, name) = unsafe { (super::at(world)?, text::read(name, "name")?) };
        // SAFETY: as the caller says.
        let out = unsafe { body.as_mut() }.ok_or(Refusal::Null("body"))?;
        let mut bodies = world.bodies.iter();
        let place = bodies.position(|body| body.as_bytes() == name.as_bytes());
        *out = place.ok_or_else(|| {
            Refusal::Scene(format!("name is {name:?}, but must be a body of the world"))
        })?;
        Ok(())
    })
}
