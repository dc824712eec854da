//! Scenes written as files read back to the same bits.

use std::sync::Arc;

use palpate_core::{Guard, HandBound, Hold};
use palpate_scene::{ContactFile, Grip, Intention, Scene};
use palpate_testbed::recorded_path::RecordedPath;

use super::{GOOD, MOVING, edited};
use crate::common;

/// Checks that `text` reads to the same scene as its written form.
#[track_caller]
fn assert_written(name: &str, text: &str) -> Scene {
    let read = |text: &str| {
        ContactFile::parse(name, text)
            .unwrap_or_else(|error| panic!("{error} in:\n{text}"))
            .scene
    };
    let scene = read(text);
    let written = scene.to_toml().unwrap();
    assert_eq!(read(&written), scene, "{written}");
    assert_eq!(read(&written).to_toml().unwrap(), written);
    scene
}

#[test]
fn the_committed_scenes_read_back_from_what_is_written_of_them() {
    for entry in std::fs::read_dir(common::experiments()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let text = std::fs::read_to_string(&path).unwrap();
            assert_written(path.to_str().unwrap(), &text);
        }
    }
}

#[test]
fn every_key_is_written() {
    assert_written("good", GOOD);
    let edit = |from, to| assert_written("edited", &edited(from, to));
    let model = edit("[measure]", "[model]\ndevice_mass_kg = 0.3\n\n[measure]");
    assert_eq!(model.model_device_mass, Some(0.3));
    assert!(
        edit("unilateral = false", "unilateral = true")
            .contact
            .unilateral
    );
    let guard = "guard = { mode = \"limit\", acceleration_m_per_s2 = 80, least_mass_kg = 0.1, recovery_w = 0.01 }";
    let guarded = edit("unilateral = false", guard);
    let Guard::Limit(params) = guarded.loop_params_with_delay().guard else {
        panic!("{:?}", guarded.loop_params.guard);
    };
    let hand = HandBound::from_acceleration(80.0, 0.1);
    assert_eq!((params.hand, params.recovery), (Some(hand), 0.01));
    let coupled = GOOD.replace("method = \"hfcr\"", "method = \"coupled\"");
    let of_line = coupled.replace("slew_limit_n_per_s = 1000\n", "");
    let of_line = of_line.replace("delay_samples = 0", "hold = \"line\"");
    assert_eq!(assert_written("line", &of_line).hold(), Hold::Line);
    for (from, to) in [
        ("\"a block\"", "\"a \\\"block\\\", \\\\ and a\\ttab\""),
        (MOVING, "fixed = true\nposition_m = [0.05, 0.0, 0.0]\n"),
        ("collisions = 3", "duration_s = 0.1234567890123456789"),
        ("normal = [-1.0, 0.0, 0.0]", "normal = [1.0, 0.0, 0.0]"),
        ("force_n = [-0.981, 0.0, 0.0]", "force_n = [-0.0, 0.0, 0.0]"),
        (
            "velocity_m_per_s = [0.0, 0.0, 0.0]\nforce",
            "velocity_m_per_s = [1e-300, 0.0, 0.0]\nforce",
        ),
        ("quantum_m = 0", "quantum_m = 1e-5"),
        (
            "quantum_m = 0\n",
            "\n[device.drivetrain]\nviscous_friction_n_s_per_m = 0.1\ncoulomb_friction_n = 0.02\nmotor_limit_n = 3\n",
        ),
        (
            "force_n = [1.0, 0.0, 0.0]\n",
            "force_n = [1.0, 0.0, 0.0]\ntremor_n = 0.2\ntremor_hz = 8\n",
        ),
        (
            "force_n = [1.0, 0.0, 0.0]\n",
            "mass_kg = 0.1\nstiffness_n_per_m = 60\ndamping_n_s_per_m = 1\n\
             rest_m = [0.01, 0.0, 0.0]\nswing_m = [0.02, 0.0, 0.0]\nswing_hz = 2\n",
        ),
        ("delay_samples = 0", "delay_samples = 3"),
        (
            "delay_samples = 0",
            "delay_s = 0.0123\ncommand_jitter_s = 0.001\nlag_s = 3e-4\ngain = 0.97\n\n[model]\n\
             delay_s = 0.013\ndelay_deviation_s = 1e-5\nlag_s = 2e-4\nlag_deviation_s = 1e-4\n\
             gain = 1.01\ngain_deviation = 0.02\nsensor_quantum_m = 1e-6\nsensor_noise_m = 5e-6\nresonance_hz = 140\nresonance_damping_ratio = 0.03\n\
             flexible_mass_fraction = 0.4\n",
        ),
        (
            "quantum_m = 0\n",
            "noise_m = 1e-6\n\n[device.drivetrain]\nresonance_hz = 150\nresonance_damping_ratio = 0.05\n\
             motor_mass_fraction = 0.6\nbacklash_m = 1e-5\ncogging_n = 0.1\ncogging_pitch_m = 0.005\n",
        ),
        (
            "delay_samples = 0",
            "delay_fraction = 0.3\njitter_s = 0.001\ndrop_probability = 0.2\nseed = 7\n\
             collapse = { from_s = 0.1, until_s = 0.2, period_s = 0.03 }",
        ),
        (
            "delay_samples = 0",
            "jitter_s = 0.001\njitter_deviation_s = 2e-4\ndropped_samples = [3, 5]",
        ),
        (
            "estimate = \"ab2\"",
            "estimate = \"ab2\"\n\n[methods.coupled]\nplacement = false\ncorrection = false",
        ),
        ("damping_n_s_per_m = 0.1", "prediction = \"observer\""),
        (
            "damping_n_s_per_m = 0.1",
            "prediction = \"extrapolation\"\nentry_hold = \"sample\"",
        ),
        ("damping_n_s_per_m = 0.1", "entry_hold = \"midpoint\""),
        (
            "damping_n_s_per_m = 0.1",
            "prediction = \"first-order-adaptive-window\"\nlongest_window_s = 0.05",
        ),
        (
            "estimate = \"ab2\"",
            "estimate = \"ab2\"\n\n[methods.virtual-damper]\ndamper_object = \"held-force\"",
        ),
        (
            "estimate = \"ab2\"",
            "estimate = \"ab2\"\n\n[methods.virtual-damper]\ndamper_object = \"spring\"",
        ),
        ("unilateral = false", "largest_gap_s = 0.5"),
        (
            "unilateral = false",
            "guard = { mode = \"report\", speed_m_per_s = 0.5, allowance_j = 0.1 }",
        ),
        (
            "unilateral = false",
            "guard = { mode = \"limit\", recovery_w = 0.0 }",
        ),
        (
            "unilateral = false",
            "guard = { mode = \"limit\", acceleration_m_per_s2 = 80.0 }",
        ),
        (
            "unilateral = false",
            "guard = { mode = \"limit\", hand_force_n = 8.0, learn_mass = true }",
        ),
        ("damping_n_s_per_m = 0.1", "damping_n_s_per_m = \"auto\""),
        ("estimate = \"ab2\"", "estimate = \"ab3\""),
        ("estimate = \"ab2\"", "estimate = \"differences\""),
        ("period_s = 0.02", "period_s = 0.1e-4"),
        (
            "force_n = [-0.981, 0.0, 0.0]",
            "force_n = [-0.981, 0.0, 0.0]\ncentre_m = [0.01, 0.0, 0.0]",
        ),
    ] {
        edit(from, to);
    }
}

#[test]
fn what_has_no_key_is_not_left_out_silently() {
    let mut scene = ContactFile::parse("good", GOOD).unwrap().scene;
    let path = RecordedPath::new(&[0.0, 1.0], &[0.0, 0.1]).unwrap();
    scene.device.point_mass_mut().unwrap().hand.grip = Some(Grip {
        mass: 0.1,
        stiffness: 100.0,
        damping: 1.0,
        intention: Intention::Recorded(Arc::new(path)),
    });
    assert_eq!(
        scene.to_toml().unwrap_err().to_string(),
        "a scene file cannot contain the recorded intention of a hand"
    );
}
