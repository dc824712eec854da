//! Bodies on joints.

use super::{Benchmark, GRAVITY, PERIOD, STIFFNESS, device, fixed, pair};
use crate::world::joints::{Freedom, WorldJoint};
use crate::world::scene::{
    ContactLaw, FreeMotion, Member, Shape, Vector, WorldBody, WorldDevice, WorldScene,
};

/// A scene of a tool and one body, a box, on a joint with the world.
fn scene(
    tool: WorldDevice,
    name: &str,
    half_extents: Vector,
    mass: f64,
    joint: WorldJoint,
) -> WorldScene {
    let shape = Shape::Box { half_extents };
    let law = ContactLaw::spring(STIFFNESS)
        .damped(2.0)
        .rough(0.4, 0.5 * STIFFNESS);
    WorldScene {
        devices: vec![tool],
        bodies: vec![WorldBody {
            name: name.into(),
            motion: Some(FreeMotion::new(&shape, mass).pulled_by([0.0, 0.0, -mass * GRAVITY])),
            ..fixed(shape)
        }],
        pairs: vec![pair(Member::Device(0), Member::Body(0), law)],
        fields: Vec::new(),
        joints: vec![joint],
    }
}

fn joint(freedom: Freedom, axis: Vector) -> WorldJoint {
    WorldJoint {
        body: 0,
        against: None,
        freedom,
        point: [0.0; 3],
        axis,
        stiffness: 20_000.0,
        damping: 8.0,
        span: 0.04,
        spring: 0.0,
        rest: 0.0,
        along_damping: 0.0,
        limits: None,
    }
}

/// W10: a tool pushes a drawer to its stop, beside its middle, so that the bearing tilts.
#[must_use]
pub fn drawer() -> Benchmark {
    let mut tool = device("tool", [-0.0365, 0.008, 0.004], 0.005);
    tool.hand.force = [1.0, 0.0, 0.0];
    tool.hand.rest = [0.0, 0.008, 0.004];
    let slider = WorldJoint {
        along_damping: 0.5,
        limits: Some([-0.001, 0.012]),
        ..joint(Freedom::Slide, [1.0, 0.0, 0.0])
    };
    Benchmark {
        name: "drawer".into(),
        title: "A tool pushes a drawer to its stop".into(),
        scene: scene(tool, "drawer", [0.03, 0.025, 0.01], 0.08, slider),
        period: PERIOD,
        duration: 0.3,
        spread: [0.001, 0.0, 0.0],
    }
}

/// W10: a tool presses the end of a lever down to its stop, against a spring.
#[must_use]
pub fn lever() -> Benchmark {
    let mut tool = device("tool", [0.05, 0.003, 0.0135], 0.005);
    tool.hand.force = [0.0, 0.1, -2.0];
    tool.hand.rest = [0.05, 0.003, 0.005];
    let hinge = WorldJoint {
        point: [-0.02, 0.0, 0.0],
        spring: 0.3,
        rest: -0.1,
        along_damping: 1e-3,
        limits: Some([-0.05, 0.15]),
        ..joint(Freedom::Turn, [0.0, 1.0, 0.0])
    };
    Benchmark {
        name: "lever".into(),
        title: "A tool presses a lever against its spring and to its stop".into(),
        scene: scene(tool, "lever", [0.06, 0.015, 0.0075], 0.06, hinge),
        period: PERIOD,
        duration: 0.3,
        spread: [0.0, 0.0, 0.001],
    }
}

/// W10: a tool presses a button of 20 g on a spring, to its stop.
#[must_use]
pub fn button() -> Benchmark {
    let mut tool = device("tool", [0.002, -0.001, 0.012], 0.005);
    tool.hand.force = [0.1, 0.0, -2.5];
    tool.hand.rest = [0.002, -0.001, 0.008];
    let slider = WorldJoint {
        spring: 300.0,
        along_damping: 1.0,
        limits: Some([-0.003, 0.0005]),
        ..joint(Freedom::Slide, [0.0, 0.0, 1.0])
    };
    Benchmark {
        name: "button".into(),
        title: "A tool presses a button of 20 g to its stop".into(),
        scene: scene(tool, "button", [0.01, 0.01, 0.005], 0.02, slider),
        period: PERIOD,
        duration: 0.3,
        spread: [0.0, 0.0, 0.001],
    }
}
