//! Conversion of a scene for the reference solution.

use std::sync::Arc;

use palpate_scene::world::{DeviceTurning, Tremor, WorldDevice, WorldScene};
use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world as judge;
use palpate_world::{Body, Joint, JointKind, MassTable, Motion, Shape, Tool};

/// Returns the scene for the reference solution: every pair that has a law and at least one movable member.
#[must_use]
pub fn as_judged(scene: &WorldScene) -> judge::WorldScene {
    let world = &scene.world;
    let tools = world.tools.iter().zip(&scene.devices);
    let devices = tools.map(|(tool, device)| judged_device(tool, device));
    let mut members: Vec<_> = world
        .tools
        .iter()
        .enumerate()
        .map(|(number, tool)| (judge::Member::Device(number), &tool.name, true))
        .collect();
    members.extend(world.bodies.iter().enumerate().map(|(number, body)| {
        let moves = body.motion != Motion::Fixed;
        (judge::Member::Body(number), &body.name, moves)
    }));
    let mut pairs = Vec::new();
    for (place, (one, name, moves)) in members.iter().enumerate() {
        for (other, other_name, other_moves) in &members[place + 1..] {
            let are_tools = matches!(
                (one, other),
                (judge::Member::Device(_), judge::Member::Device(_))
            );
            if are_tools || !(*moves || *other_moves) {
                continue;
            }
            if let Some(law) = world.law(name, other_name) {
                pairs.push(judge::Pair {
                    between: [*one, *other],
                    law: judge::ContactLaw {
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
    judge::WorldScene {
        joints: world
            .joints
            .iter()
            .map(|joint| judged_joint(joint, &world.bodies))
            .collect(),
        devices: devices.collect(),
        bodies: world.bodies.iter().map(judged_body).collect(),
        pairs,
    }
}

/// The joint with the numbers of its bodies; a checked world has bodies of these names.
fn judged_joint(joint: &Joint, bodies: &[Body]) -> judge::WorldJoint {
    let number = |name: &String| bodies.iter().position(|body| body.name == *name);
    let law = &joint.law;
    judge::WorldJoint {
        body: number(&joint.body).unwrap_or(bodies.len()),
        against: joint.against.as_ref().and_then(number),
        freedom: match joint.kind {
            JointKind::Hinge => judge::Freedom::Turn,
            JointKind::Slider => judge::Freedom::Slide,
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

fn judged_device(tool: &Tool, device: &WorldDevice) -> judge::WorldDevice {
    let hand = &device.hand;
    judge::WorldDevice {
        name: tool.name.clone(),
        own_axes: device.own_axes,
        mass_table: tool.mass_table.as_deref().map(judged_masses),
        mass: device.mass,
        position: device.position,
        velocity: device.velocity,
        tool: match &tool.shape {
            Shape::Spheres { spheres } => judge::Tool::Spheres(
                spheres
                    .iter()
                    .map(|sphere| judge::SphereAt {
                        centre: sphere.centre,
                        radius: sphere.radius,
                    })
                    .collect(),
            ),
            solid => judge::Tool::Solid(judged_shape(solid)),
        },
        turning: device.turning.as_ref().map(judged_turning),
        hand: judge::WorldHand {
            force: hand.force,
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: hand.rest,
            tremor: judged_tremor(&hand.tremor),
        },
        quantum: device.quantum,
    }
}

/// Converts a mass table for the reference solution.
///
/// # Panics
/// Never: every valid table of the renderer is valid for the reference solution.
fn judged_masses(table: &MassTable) -> Arc<judge::MassTable> {
    let (places, masses) = (table.places().clone(), table.matrices().to_vec());
    let judged = judge::MassTable::new(table.axes(), places, masses);
    Arc::new(judged.expect("a checked table has matrices of masses, in between too"))
}

/// A sine along each axis, a third of a turn apart.
fn judged_tremor(tremor: &Tremor) -> [Vec<Sinusoid>; 3] {
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
pub(crate) fn judged_turning(turning: &DeviceTurning) -> judge::Turning {
    let hand = &turning.hand;
    judge::Turning {
        inertia: turning.inertia,
        orientation: turning.orientation,
        angular_velocity: turning.angular_velocity,
        gives_torque: turning.gives_torque,
        quantum: turning.quantum,
        hand: judge::TurningHand {
            torque: hand.torque,
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: hand.rest,
            tremor: judged_tremor(&hand.tremor),
        },
    }
}

/// Converts a mesh for the reference solution, with the same points and the same distance function.
///
/// # Panics
/// Never: every valid mesh of the renderer is valid for the reference solution.
fn judged_mesh(mesh: &palpate_world::Mesh) -> Arc<judge::mesh::TriangleMesh> {
    let judged = judge::mesh::TriangleMesh::new(&mesh.vertices(), mesh.faces());
    let mut judged = judged.expect("a checked mesh has neither flat triangles nor edges of three");
    if let Some(shell) = mesh.shell() {
        judged = judged.with_points(&shell.points(), shell.sharers());
    }
    if let Some(grid) = mesh.grid() {
        let coefficients = grid.coefficients().iter().map(|&of| f64::from(of));
        let (first, orientation) = grid.placed();
        let field = judge::Field::new(
            coefficients.collect(),
            grid.counts(),
            grid.spacing(),
            first,
            orientation,
        );
        judged = judged.with_field(field.expect("a grid has a number for each of its nodes"));
    }
    Arc::new(judged)
}

/// Converts a hull for the reference solution, from the same corners.
///
/// # Panics
/// Never: the corners of a hull have a hull.
fn judged_hull(hull: &palpate_world::Hull) -> Arc<judge::Hull> {
    let judged = judge::Hull::around(&hull.corners());
    Arc::new(judged.expect("the corners of a hull do not lie in a plane"))
}

/// A shape of a body, or of a tool that is one solid.
fn judged_shape(shape: &Shape) -> judge::Shape {
    match *shape {
        Shape::Mesh(ref mesh) => judge::Shape::Mesh(judged_mesh(mesh)),
        Shape::Hull(ref hull) => judge::Shape::Hull(judged_hull(hull)),
        // For tools only.
        Shape::Spheres { .. } => judge::Shape::Sphere { radius: 0.0 },
        Shape::Sphere { radius } => judge::Shape::Sphere { radius },
        Shape::HalfSpace { normal, offset } => judge::Shape::HalfSpace { normal, offset },
        Shape::Box { half_extents } => judge::Shape::Box { half_extents },
        Shape::Capsule {
            radius,
            half_length,
        } => judge::Shape::Capsule {
            radius,
            half_length,
        },
        Shape::Cylinder {
            radius,
            half_length,
        } => judge::Shape::Cylinder {
            radius,
            half_length,
        },
    }
}

fn judged_body(body: &Body) -> judge::WorldBody {
    let shape = judged_shape(&body.shape);
    let motion = match &body.motion {
        Motion::Fixed => None,
        Motion::Free(free) => Some(judge::FreeMotion {
            inertia: free.inertia.unwrap_or_else(|| shape.inertia(free.mass)),
            mass: free.mass,
            velocity: free.velocity,
            angular_velocity: free.angular_velocity,
            force: free.force,
        }),
    };
    judge::WorldBody {
        name: body.name.clone(),
        shape,
        position: body.position,
        orientation: body.orientation,
        motion,
    }
}
