//! Initial bodies, joint springs and fields of a world.

use crate::dynamics::joint_springs::{Link, links_of};
use crate::dynamics::moving_body::{Drive, Part};
use crate::dynamics::potentials::Potential;
use crate::geometry::rigid::{Mobility, Rigid, Vector3};
use crate::{Body, Motion, World};

/// Returns the springs of all joints of a checked world.
pub(super) fn links(world: &World, parts: &[Part]) -> Vec<Link> {
    let number = |name: &String| {
        let place = world.bodies.iter().position(|body| body.name == *name);
        place.map(|body| world.tools.len() + body)
    };
    let joints = world.joints.iter().enumerate();
    joints
        .flat_map(|(joint, of)| {
            let sides = [number(&of.body), of.against.as_ref().and_then(number)];
            links_of(of, joint, sides, parts)
        })
        .collect()
}

/// Returns the fields of a checked world.
pub(super) fn fields(world: &World) -> Vec<Potential> {
    let tool = |name: &String| world.tools.iter().position(|tool| tool.name == *name);
    let fields = world.fields.iter();
    fields
        .filter_map(|field| Some(Potential::new(tool(&field.tool)?, field.kind)))
        .collect()
}

pub(super) fn part_of(body: &Body) -> Part {
    let orientation = crate::geometry::rigid::orientation(body.orientation);
    let mut rigid = Rigid {
        position: body.position.into(),
        orientation,
        velocity: Vector3::zeros(),
        spin: Vector3::zeros(),
    };
    let Motion::Free(free) = &body.motion else {
        return Part::fixed(rigid);
    };
    // A half-space has no moments of inertia and is rejected as a moving body.
    let moments = free.inertia.or_else(|| body.shape.moments(free.mass));
    let moments = moments.unwrap_or([f64::INFINITY; 3]);
    let mobility = Mobility::of_body(free.mass, moments);
    let own = orientation.inverse_transform_vector(&free.angular_velocity.into());
    rigid.velocity = free.velocity.into();
    rigid.spin = orientation * own.component_mul(&Vector3::from(moments));
    let force: Vector3 = free.force.into();
    Part::new(rigid, mobility, Drive::constant(force / free.mass))
}
