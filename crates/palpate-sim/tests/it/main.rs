//! All integration tests of palpate-sim, in one program.

mod actuators;
mod common;
mod hand_replay;
mod hard_worlds;
mod human;
mod imperfect;
mod linkages;
mod loops;
mod low_rate_simulator;
mod motion_replay;
mod own_axes;
mod paper;
mod plants;
mod pressed;
mod recorded_loop;
mod shells;
mod six_axes;
mod two_axes;
mod vectors;
mod worlds;
