//! Conversion of a scene of the reference solution for a renderer.

use std::sync::Arc;

use palpate_testbed::world as reference;
use palpate_world::{
    Body, Contact, ContactLaw, Free, Hull, Joint, JointKind, JointLaw, Mesh, Motion, Party, Shape,
    SphereAt, Tool, World,
};

/// Returns the world of a random scene of the testbed: its tools, bodies and laws, without its devices.
///
/// # Panics
/// The scene has a mesh or hull that the renderer rejects; the testbed's gallery has no such mesh.
#[must_use]
pub fn as_rendered(scene: &reference::WorldScene) -> World {
    let tools = scene.devices.iter().map(|device| {
        let shape = match &device.tool {
            reference::Tool::Solid(solid) => shape(solid),
            reference::Tool::Spheres(spheres) => Shape::Spheres {
                spheres: spheres
                    .iter()
                    .map(|sphere| SphereAt {
                        centre: sphere.centre,
                        radius: sphere.radius,
                    })
                    .collect(),
            },
        };
        Tool {
            turns: device.turning.is_some(),
            gives_torque: device.turning.as_ref().is_none_or(|it| it.gives_torque),
            axes: device.mass.map(f64::is_finite),
            own_axes: device.own_axes,
            ..Tool::new(&device.name, shape)
        }
    });
    let name = |member| match member {
        reference::Member::Device(number) => Party::Named(scene.devices[number].name.clone()),
        reference::Member::Body(number) => Party::Named(scene.bodies[number].name.clone()),
    };
    let contacts = scene.pairs.iter().map(|pair| Contact {
        between: pair.between.map(name),
        law: ContactLaw {
            stiffness: pair.law.stiffness,
            damping: pair.law.damping,
            friction: pair.law.friction,
            friction_stiffness: pair.law.friction_stiffness,
            friction_damping: pair.law.friction_damping,
        },
    });
    World {
        fields: Vec::new(),
        joints: scene.joints.iter().map(|of| joint(scene, of)).collect(),
        tools: tools.collect(),
        bodies: scene.bodies.iter().map(body).collect(),
        contacts: contacts.collect(),
    }
}

fn joint(scene: &reference::WorldScene, joint: &reference::WorldJoint) -> Joint {
    let name = |number: usize| scene.bodies[number].name.clone();
    Joint {
        body: name(joint.body),
        against: joint.against.map(name),
        kind: match joint.freedom {
            reference::Freedom::Turn => JointKind::Hinge,
            reference::Freedom::Slide => JointKind::Slider,
        },
        point: joint.point,
        axis: joint.axis,
        law: JointLaw {
            stiffness: joint.stiffness,
            damping: joint.damping,
            span: joint.span,
            spring: joint.spring,
            rest: joint.rest,
            along_damping: joint.along_damping,
            limits: joint.limits,
        },
    }
}

fn shape(shape: &reference::Shape) -> Shape {
    match *shape {
        reference::Shape::Mesh(ref mesh) => {
            let mesh = Mesh::new(&mesh.vertices(), &mesh.faces());
            Shape::Mesh(Arc::new(mesh.expect("a mesh that the renderer takes")))
        }
        reference::Shape::Hull(ref hull) => {
            let hull = Hull::around(&hull.corners());
            Shape::Hull(Arc::new(hull.expect("a hull that the renderer takes")))
        }
        reference::Shape::Sphere { radius } => Shape::Sphere { radius },
        reference::Shape::HalfSpace { normal, offset } => Shape::HalfSpace { normal, offset },
        reference::Shape::Box { half_extents } => Shape::Box { half_extents },
        reference::Shape::Capsule {
            radius,
            half_length,
        } => Shape::Capsule {
            radius,
            half_length,
        },
        reference::Shape::Cylinder {
            radius,
            half_length,
        } => Shape::Cylinder {
            radius,
            half_length,
        },
    }
}

fn body(body: &reference::WorldBody) -> Body {
    let shape = shape(&body.shape);
    let motion = body.motion.map_or(Motion::Fixed, |motion| {
        Motion::Free(Free {
            mass: motion.mass,
            inertia: Some(motion.inertia),
            velocity: motion.velocity,
            angular_velocity: motion.angular_velocity,
            force: motion.force,
        })
    });
    Body {
        name: body.name.clone(),
        shape,
        position: body.position,
        orientation: body.orientation,
        motion,
    }
}
