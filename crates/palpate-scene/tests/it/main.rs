//! All integration tests of palpate-scene, in one program.

mod common;
mod device_files;
mod edits;
mod mesh_files;
mod obj_files;
mod scene_files;
mod world_fields;
mod world_joints;
mod worlds;
