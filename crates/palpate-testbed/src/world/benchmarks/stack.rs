//! Boxes on boxes.

use super::{Benchmark, GRAVITY, PERIOD, STIFFNESS, device, fixed, pair, table};
use crate::world::scene::{ContactLaw, FreeMotion, Member, Shape, Vector, WorldBody, WorldScene};

/// W5: a tool presses on a stack of three equal boxes and pushes it sideways.
///
/// Waves go through several contacts of box with box. Each box lies a little beside the one below and is turned by some
/// degrees, so corners of both are in contact; friction holds the stack.
#[must_use]
pub fn stack() -> Benchmark {
    let half_extents = [0.02, 0.02, 0.01];
    let shape = Shape::Box { half_extents };
    let weight = 0.05 * GRAVITY;
    let rough = ContactLaw::spring(8000.0).damped(8.0).rough(0.5, 4000.0);
    let by_tool = ContactLaw::spring(STIFFNESS)
        .damped(2.0)
        .rough(0.5, 0.5 * STIFFNESS);
    // About z, by 0, 4 and -6 degrees; each box is as deep in the one below as the weight above asks for.
    let block = |name: &str, position: Vector, [w, z]: [f64; 2]| WorldBody {
        name: name.into(),
        position,
        orientation: [w, 0.0, 0.0, z],
        motion: Some(FreeMotion::new(&shape, 0.05).pulled_by([0.0, 0.0, -weight])),
        ..fixed(shape.clone())
    };
    let mut tool = device("tool", [0.004, -0.003, 0.0666], 0.005);
    tool.hand.force = [0.8, 0.3, -3.0];
    tool.hand.rest = [0.004, -0.003, 0.0646];
    let body = Member::Body;
    Benchmark {
        name: "stack".into(),
        title: "A tool presses on a stack of three boxes and pushes it sideways".into(),
        scene: WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![
                block("lower", [0.0, 0.0, 0.009_816_06], [1.0, 0.0]),
                block(
                    "middle",
                    [0.002, 0.001, 0.029_693_44],
                    [0.999_390_83, 0.034_899_5],
                ),
                block(
                    "upper",
                    [0.001, -0.001, 0.049_632_12],
                    [0.998_629_53, -0.052_335_96],
                ),
                table(),
            ],
            pairs: vec![
                pair(Member::Device(0), body(2), by_tool),
                pair(body(2), body(1), rough),
                pair(body(1), body(0), rough),
                pair(body(0), body(3), rough),
            ],
        },
        period: PERIOD,
        duration: 0.3,
        spread: [0.001, 0.0, 0.0],
    }
}
