//! All integration tests of palpate-testbed, in one program.

mod common;
mod driven;
mod drivetrain;
mod energy;
mod hands;
mod held_mass;
mod ideal;
mod metrics;
mod pantograph_device;
mod pantograph_dynamics;
mod pantograph_kinematics;
mod pantographs;
mod rebound;
mod reference;
mod relative_motion;
mod total;
mod viscous_ideal;
mod world_evaluation;
mod world_ideal;
mod world_meshes;
mod world_scenes;
mod world_six_axes;
