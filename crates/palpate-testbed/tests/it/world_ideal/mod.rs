//! The ideal of worlds against closed forms, laws of conservation and the one-dimensional ideals.
#![allow(clippy::print_stdout)] // what was measured

mod boxes;
mod by_other_means;
mod cans;
mod capsules;
mod chaos;
mod closed_forms;
mod conservation;
mod cylinders;
mod fields;
mod friction;
mod hands;
mod joints;
mod linkages;
mod one_dimension;
mod own_axes;
mod refused;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::{
    ContactLaw, FreeMotion, Member, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldHand,
    WorldIdeal, WorldScene,
};

const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// A device with a point as its tool, without a hand, at rest.
fn device(mass: f64, position: Vector) -> WorldDevice {
    WorldDevice {
        name: "tool".into(),
        own_axes: None,
        mass_table: None,
        drivetrain: palpate_testbed::world::Drivetrain::default(),
        mass: [mass; 3],
        position,
        velocity: [0.0; 3],
        tool: Tool::sphere(0.0),
        turning: None,
        hand: WorldHand::default(),
        quantum: [0.0; 3],
    }
}

fn half_space(normal: Vector, offset: f64) -> WorldBody {
    WorldBody {
        name: "plane".into(),
        shape: Shape::HalfSpace { normal, offset },
        position: [0.0; 3],
        orientation: IDENTITY,
        motion: None,
    }
}

/// A free body at rest.
fn body(shape: Shape, mass: f64, position: Vector) -> WorldBody {
    WorldBody {
        name: "body".into(),
        shape: shape.clone(),
        position,
        orientation: IDENTITY,
        motion: Some(FreeMotion::new(&shape, mass)),
    }
}

fn motion(body: &mut WorldBody) -> &mut FreeMotion {
    body.motion.as_mut().unwrap()
}

fn pair(one: Member, other: Member, law: ContactLaw) -> Pair {
    Pair {
        between: [one, other],
        law,
    }
}

fn solve(scene: &WorldScene, period: f64, intervals: usize) -> WorldIdeal {
    WorldIdeal::new(scene, Grid::even(0.0, period, intervals)).unwrap()
}
