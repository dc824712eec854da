//! Conversion of a scene for the reference solution.

use std::sync::Arc;

use palpate_scene::world::{DeviceTurning, Tremor, WorldDevice, WorldScene};
use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world as reference;
use palpate_world::{Body, Field, FieldKind, Joint, JointKind, MassTable, Motion, Shape, Tool};

/// Returns the scene for the reference solution: every pair that has a law and at least one movable member.
#[must_use]
pub fn as_evaluated(scene: &WorldScene) -> reference::WorldScene {
    let world = &scene.world;
    let tools = world.tools.iter().zip(&scene.devices);
    let devices = tools.map(|(tool, device)| reference_device(tool, device));
    let mut members: Vec<_> = world
        .tools
        .iter()
        .enumerate()
        .map(|(number, tool)| (reference::Member::Device(number), &tool.name, true))
        .collect();
    members.extend(world.bodies.iter().enumerate().map(|(number, body)| {
        let moves = body.motion != Motion::Fixed;
        (reference::Member::Body(number), &body.name, moves)
    }));
    let mut pairs = Vec::new();
    for (place, (one, name, moves)) in members.iter().enumerate() {
        for (other, other_name, other_moves) in &members[place + 1..] {
            let are_tools = matches!(
                (one, other),
                (reference::Member::Device(_), reference::Member::Device(_))
            );
            if are_tools || !(*moves || *other_moves) {
                continue;
            }
            if let Some(law) = world.law(name, other_name) {
                pairs.push(reference::Pair {
                    between: [*one, *other],
                    law: reference::ContactLaw {
                        stiffness: law.stiffness,
                        damping: law.damping,
                        friction: law.friction,
                        friction_stiffness: law.friction_stiffness,
                        friction_damping: law.friction_damping,
                    },
                });
            }
        }
    }
    reference::WorldScene {
        fields: world
            .fields
            .iter()
            .map(|field| reference_field(field, &world.tools))
            .collect(),
        joints: world
            .joints
            .iter()
            .map(|joint| reference_joint(joint, &world.bodies))
            .collect(),
        devices: devices.collect(),
        bodies: world.bodies.iter().map(reference_body).collect(),
        pairs,
    }
}

/// The joint with the numbers of its bodies; a checked world has bodies of these names.
fn reference_joint(joint: &Joint, bodies: &[Body]) -> reference::WorldJoint {
    let number = |name: &String| bodies.iter().position(|body| body.name == *name);
    let law = &joint.law;
    reference::WorldJoint {
        body: number(&joint.body).unwrap_or(bodies.len()),
        against: joint.against.as_ref().and_then(number),
        freedom: match joint.kind {
            JointKind::Hinge => reference::Freedom::Turn,
            JointKind::Slider => reference::Freedom::Slide,
        },
        point: joint.point,
        axis: joint.axis,
        stiffness: law.stiffness,
        damping: law.damping,
        span: law.span,
        spring: law.spring,
        rest: law.rest,
        along_damping: law.along_damping,
        limits: law.limits,
    }
}

/// The field with the number of its device; a checked world has a tool of this name.
fn reference_field(field: &Field, tools: &[Tool]) -> reference::ForceField {
    let spring = |to, at, stiffness, range| reference::Potential::Spring {
        to,
        at,
        stiffness,
        range,
    };
    let device = tools.iter().position(|tool| tool.name == field.tool);
    reference::ForceField {
        device: device.unwrap_or(tools.len()),
        potential: match field.kind {
            FieldKind::Point {
                at,
                stiffness,
                range,
            } => spring(reference::Attractor::Point, at, stiffness, range),
            FieldKind::Line {
                at,
                axis,
                stiffness,
                range,
            } => spring(reference::Attractor::Line(axis), at, stiffness, range),
            FieldKind::Plane {
                at,
                normal,
                stiffness,
                range,
            } => spring(reference::Attractor::Plane(normal), at, stiffness, range),
            FieldKind::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            } => reference::Potential::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            },
            FieldKind::Constant { force } => reference::Potential::Constant { force },
        },
    }
}

fn reference_device(tool: &Tool, device: &WorldDevice) -> reference::WorldDevice {
    reference::WorldDevice {
        mass_table: tool.mass_table.as_deref().map(reference_masses),
        tool: match &tool.shape {
            Shape::Spheres { spheres } => reference::Tool::Spheres(
                spheres
                    .iter()
                    .map(|sphere| reference::SphereAt {
                        centre: sphere.centre,
                        radius: sphere.radius,
                    })
                    .collect(),
            ),
            solid => reference::Tool::Solid(reference_shape(solid)),
        },
        ..reference_point(&tool.name, device)
    }
}

/// Converts a device with a point as its tool and a constant mass.
pub(crate) fn reference_point(name: &str, device: &WorldDevice) -> reference::WorldDevice {
    let hand = &device.hand;
    reference::WorldDevice {
        name: name.to_owned(),
        own_axes: device.own_axes,
        mass_table: None,
        mass: device.mass,
        position: device.position,
        velocity: device.velocity,
        tool: reference::Tool::sphere(0.0),
        turning: device.turning.as_ref().map(reference_turning),
        hand: reference::WorldHand {
            force: hand.force,
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: hand.rest,
            swing: hand.swing,
            path: hand.path.clone(),
            mass: hand.mass,
            release: hand.release,
            tremor: reference_tremor(&hand.tremor),
        },
        quantum: device.quantum,
        drivetrain: device.drivetrain,
    }
}

/// Converts a mass table for the reference solution.
///
/// # Panics
/// Never: every valid table of the renderer is valid for the reference solution.
fn reference_masses(table: &MassTable) -> Arc<reference::MassTable> {
    let (places, masses) = (table.places().clone(), table.matrices().to_vec());
    let evaluated = reference::MassTable::new(table.axes(), places, masses);
    Arc::new(evaluated.expect("a checked table has matrices of masses, in between too"))
}

/// A sine along each axis, a third of a turn apart.
fn reference_tremor(tremor: &Tremor) -> [Vec<Sinusoid>; 3] {
    [0.0, 1.0, 2.0].map(|axis| {
        let wave = Sinusoid {
            amplitude: tremor.amplitude,
            frequency_hz: tremor.frequency_hz,
            phase: -(std::f64::consts::TAU * axis / 3.0),
        };
        if wave.amplitude > 0.0 {
            vec![wave]
        } else {
            Vec::new()
        }
    })
}

/// Converts the rotation of a device for the reference solution.
pub(crate) fn reference_turning(turning: &DeviceTurning) -> reference::Turning {
    let hand = &turning.hand;
    reference::Turning {
        inertia: turning.inertia,
        orientation: turning.orientation,
        angular_velocity: turning.angular_velocity,
        gives_torque: turning.gives_torque,
        quantum: turning.quantum,
        hand: reference::TurningHand {
            torque: hand.torque,
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: hand.rest,
            tremor: reference_tremor(&hand.tremor),
        },
    }
}

/// Converts a mesh for the reference solution, with the same points and the same distance function.
///
/// # Panics
/// Never: every valid mesh of the renderer is valid for the reference solution.
fn reference_mesh(mesh: &palpate_world::Mesh) -> Arc<reference::mesh::TriangleMesh> {
    let evaluated = reference::mesh::TriangleMesh::new(&mesh.vertices(), mesh.faces());
    let mut evaluated =
        evaluated.expect("a checked mesh has neither flat triangles nor edges of three");
    if let Some(shell) = mesh.shell() {
        evaluated = evaluated.with_points(&shell.points(), shell.sharers());
    }
    if let Some(grid) = mesh.grid() {
        let coefficients = grid.coefficients().iter().map(|&of| f64::from(of));
        let (first, orientation) = grid.placed();
        let field = reference::Field::new(
            coefficients.collect(),
            grid.counts(),
            grid.spacing(),
            first,
            orientation,
        );
        evaluated = evaluated.with_field(field.expect("a grid has a number for each of its nodes"));
    }
    Arc::new(evaluated)
}

/// Converts a hull for the reference solution, from the same corners.
///
/// # Panics
/// Never: the corners of a hull have a hull.
fn reference_hull(hull: &palpate_world::Hull) -> Arc<reference::Hull> {
    let evaluated = reference::Hull::around(&hull.corners());
    Arc::new(evaluated.expect("the corners of a hull do not lie in a plane"))
}

/// A shape of a body, or of a tool that is one solid.
fn reference_shape(shape: &Shape) -> reference::Shape {
    match *shape {
        Shape::Mesh(ref mesh) => reference::Shape::Mesh(reference_mesh(mesh)),
        Shape::Hull(ref hull) => reference::Shape::Hull(reference_hull(hull)),
        // For tools only.
        Shape::Spheres { .. } => reference::Shape::Sphere { radius: 0.0 },
        Shape::Sphere { radius } => reference::Shape::Sphere { radius },
        Shape::HalfSpace { normal, offset } => reference::Shape::HalfSpace { normal, offset },
        Shape::Box { half_extents } => reference::Shape::Box { half_extents },
        Shape::Capsule {
            radius,
            half_length,
        } => reference::Shape::Capsule {
            radius,
            half_length,
        },
        Shape::Cylinder {
            radius,
            half_length,
        } => reference::Shape::Cylinder {
            radius,
            half_length,
        },
    }
}

fn reference_body(body: &Body) -> reference::WorldBody {
    let shape = reference_shape(&body.shape);
    let motion = match &body.motion {
        Motion::Fixed => None,
        Motion::Free(free) => Some(reference::FreeMotion {
            inertia: free.inertia.unwrap_or_else(|| shape.inertia(free.mass)),
            mass: free.mass,
            velocity: free.velocity,
            angular_velocity: free.angular_velocity,
            force: free.force,
        }),
    };
    reference::WorldBody {
        name: body.name.clone(),
        shape,
        position: body.position,
        orientation: body.orientation,
        motion,
    }
}
