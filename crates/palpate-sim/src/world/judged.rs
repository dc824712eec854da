//! A scene as its judge takes it.

use palpate_scene::world::{WorldDevice, WorldScene};
use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world as judge;
use palpate_world::{Body, Motion, Shape};

/// The scene as the judge takes it: every pair that has a law and of which one side can move.
#[must_use]
pub fn as_judged(scene: &WorldScene) -> judge::WorldScene {
    let world = &scene.world;
    let tools = world.tools.iter().zip(&scene.devices);
    let devices = tools.map(|(tool, device)| judged_device(&tool.name, &tool.shape, device));
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
                    },
                });
            }
        }
    }
    judge::WorldScene {
        devices: devices.collect(),
        bodies: world.bodies.iter().map(judged_body).collect(),
        pairs,
    }
}

fn judged_device(name: &str, tool: &Shape, device: &WorldDevice) -> judge::WorldDevice {
    let hand = &device.hand;
    let tremor = |axis: usize| {
        let turn = std::f64::consts::TAU * axis as f64 / 3.0;
        let wave = Sinusoid {
            amplitude: hand.tremor.amplitude,
            frequency_hz: hand.tremor.frequency_hz,
            phase: -turn,
        };
        if wave.amplitude > 0.0 {
            vec![wave]
        } else {
            Vec::new()
        }
    };
    judge::WorldDevice {
        name: name.to_owned(),
        mass: device.mass,
        position: device.position,
        velocity: device.velocity,
        tool_radius: match tool {
            Shape::Sphere { radius } => *radius,
            // No renderer takes another tool.
            _ => 0.0,
        },
        hand: judge::WorldHand {
            force: hand.force,
            stiffness: hand.stiffness,
            damping: hand.damping,
            rest: hand.rest,
            tremor: [tremor(0), tremor(1), tremor(2)],
        },
        quantum: device.quantum,
    }
}

fn judged_body(body: &Body) -> judge::WorldBody {
    let shape = match body.shape {
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
    };
    let motion = match &body.motion {
        Motion::Fixed => None,
        Motion::Free(free) => Some(judge::Motion {
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
