//! Changes of a running world between two ticks.

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

/// Changes to another scene from the next tick on. A body with an existing name keeps its pose and velocity and
/// takes shape, mass, force and fixedness from the scene. A body with a new name starts as in the scene, and a body
/// that is not in the scene is removed. The laws are those of the scene. A joint with the same bodies, kind, point,
/// axis and span continues; a new one starts at the current poses. The devices must be the same in the same order,
/// except for the shapes of their tools. Method, period, limits and the model values of the devices do not change.
/// On an error nothing changes.
///
/// The wrenches are blended over 0.1 s, without a step; the energy of the change is recorded as outside work. The
/// call allocates and takes as long as creating a world; a tick does not. Afterwards, indices of bodies may differ,
/// names returned earlier are invalid, and recorders of the world must be closed.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_change(world: *mut World, scene: *mut Scene) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: guaranteed by the caller.
        let scene = unsafe { scene::at(scene) }?;
        let period = world.bounded.renderer().loop_params().period;
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
            .map_err(|faults| Refusal::WorldChange(faults.to_string()))?;
        world.bodies = names_of_bodies(described);
        world.rows = WorldRows::new(described, world.bounded.state());
        world.source = None;
        world.changes += 1;
        Ok(())
    })
}

/// Moves a body from the next tick on to the pose and velocities of `state`; a fixed body must have zero velocity.
/// `body` is its index. The wrenches are blended over 0.1 s, without a step; the energy of the move is recorded as
/// outside work. It does not allocate, so the loop thread can call it between two ticks. On an error nothing
/// changes.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_place(
    world: *mut World,
    body: usize,
    state: *const BodyState,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: guaranteed by the caller.
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
            // With finite velocities the only possible velocity fault is motion of a fixed body.
            if fault.field == WorldField::Velocity && velocities.all(|number| number.is_finite()) {
                Refusal::WorldChange(fault.to_string())
            } else {
                Refusal::Numbers(fault.to_string())
            }
        })
    })
}

/// Writes the index of the body with this name to `*body`. It is valid until the world is changed.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_body_named(
    world: *const World,
    name: *const c_char,
    body: *mut usize,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (world, name) = unsafe { (super::at(world)?, text::read(name, "name")?) };
        // SAFETY: guaranteed by the caller.
        let out = unsafe { body.as_mut() }.ok_or(Refusal::Null("body"))?;
        let mut bodies = world.bodies.iter();
        let place = bodies.position(|body| body.as_bytes() == name.as_bytes());
        *out = place.ok_or_else(|| {
            Refusal::Scene(format!("name is {name:?}, but must be a body of the world"))
        })?;
        Ok(())
    })
}
