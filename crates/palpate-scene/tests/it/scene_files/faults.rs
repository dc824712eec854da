//! All errors of a scene file: position, message, and marked text.

use palpate_scene::{ContactFile, Intention};

use crate::scene_files::edited;

/// Checks a table of edits of the good file, three lines each: the edit, the message with its place, what is at fault.
#[track_caller]
pub fn assert_faults(table: &str, rows: usize) {
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 3 * rows, "the table has another length");
    for row in lines.chunks(3) {
        let (from, to) = row[0].split_once(" -> ").unwrap();
        let text = edited(&from.replace("\\n", "\n"), &to.replace("\\n", "\n"));
        let Err(errors) = ContactFile::parse("scene.toml", &text) else {
            panic!("{} is accepted", row[0]);
        };
        let error = errors.first();
        // A single error is reported once.
        assert_eq!(
            errors.to_string(),
            format!("scene.toml:{}", row[1].trim()),
            "{}",
            row[0]
        );
        assert_eq!(&text[error.span.clone()], row[2].trim(), "{}", row[0]);
        assert_eq!(error.source_text, text);
    }
    eprintln!("{rows} faults");
}

#[test]
fn an_unknown_key_is_named_with_the_nearest_known_one() {
    assert_faults(
        r#"mass_kg = 0.25\n -> mass_kg = 0.25\nmas_kg = 1\n
  12:1: unknown key mas_kg, did you mean mass_kg? Known here: name, axes, mass_kg, mass_table, linkage, safety_box, position_m, velocity_m_per_s, quantum_m, noise_m, inertia_kg_m2, gives_torque, orientation, angular_velocity_rad_per_s, quantum_rad, tool, drivetrain, hand
  mas_kg
period_s -> perod_s
  5:1: unknown key perod_s, did you mean period_s? Known here: period_s, delay_samples, delay_fraction, delay_s, command_jitter_s, lag_s, gain, hold, jitter_s, jitter_deviation_s, drop_probability, dropped_samples, collapse, seed
  perod_s
[loop] -> [lop]
  4:2: unknown key lop, did you mean loop? Known here: format, title, loop, device, body, contact, joint, field, model, render, methods, measure
  lop
[loop] -> [zzz]\n[loop]
  4:2: unknown key zzz. Known here: format, title, loop, device, body, contact, joint, field, model, render, methods, measure
  zzz
collisions = 3 -> collisons = 3
  40:1: unknown key collisons, did you mean collisions? Known here: collisions, duration_s
  collisons
damping_cap_n_s_per_m -> damping_cap
  46:1: unknown key damping_cap, did you mean damping_cap_n_s_per_m? Known here: estimate, damping_n_s_per_m, prediction, damper_object, longest_window_s, damping_cap_n_s_per_m, speed_threshold_m_per_s, initial_energy_j, assumed_damping_n_s_per_m, midpoint_device, desired_energy_j, coupling_stiffness_n_per_m, coupling_mass_kg, balance, entry_hold, placement, correction
  damping_cap"#,
        6,
    );
}

#[test]
fn a_missing_key_is_named_where_it_should_stand() {
    assert_faults(
        r#"format = 2\n -> 
  1:1: the key format is missing; a scene has format = 2
  
title = "a block"\n -> title = 3\n
  2:9: invalid type: integer `3`, expected a string
  3
mass_kg = 0.1\n -> 
  19:1: a body needs either mass_kg or fixed = true
  [[body]]
period_s = 0.02\n -> 
  4:1: the key period_s is missing
  [loop]
stiffness_n_per_m = 400\n -> 
  28:1: the key stiffness_n_per_m is missing
  [[contact]]
collisions = 3 -> collisions = 3\nduration_s = 1
  41:14: [measure] has either collisions or duration_s, not both
  1
name = "object"\n -> 
  19:1: the key name is missing
  [[body]]"#,
        7,
    );
}

#[test]
fn a_value_of_another_type_is_refused() {
    assert_faults(
        r#"format = 2 -> format = "2"
  1:10: invalid type: string "2", expected a whole number
  "2"
mass_kg = 0.1\n -> mass_kg = "light"\n
  22:11: invalid type: string "light", expected a number
  "light"
between = ["device", "object"] -> between = ["device"]
  29:11: invalid length 1, expected two names ["tool", "floor"], or "*" for any pair
  ["device"]
delay_samples = 0 -> delay_samples = -1
  6:17: invalid value: integer `-1`, expected a whole number from 0 up
  -1
delay_samples = 0 -> delay_samples = 1.5
  6:17: invalid type: floating point `1.5`, expected a whole number from 0 up
  1.5
collisions = 3 -> collisions = -3
  40:14: invalid value: integer `-3`, expected a whole number from 0 up
  -3
unilateral = false -> unilateral = 0
  34:14: invalid type: integer `0`, expected a boolean
  0
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = "atuo"
  43:21: invalid value: string "atuo", expected a number in N s/m or "stability-optimal" or "auto" or "adaptive"
  "atuo"
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = true
  43:21: invalid type: boolean `true`, expected a number in N s/m or "stability-optimal" or "auto" or "adaptive"
  true
estimate = "ab2" -> estimate = "ab4"
  51:12: unknown variant `ab4`, expected one of `ab2`, `differences`, `ab3`
  "ab4""#,
        10,
    );
}

#[test]
fn a_value_out_of_range_is_named_with_its_unit_and_what_is_allowed() {
    assert_faults(
        r#"format = 2 -> format = 3
  1:10: format is 3, but must be 2
  3
mass_kg = 0.1\n -> mass_kg = 0\n
  22:11: body.mass_kg is 0 kg, but must be finite and greater than 0
  0
mass_kg = 0.1\n -> mass_kg = nan\n
  22:11: body.mass_kg is NaN kg, but must be finite and greater than 0
  nan
mass_kg = 0.1\n -> mass_kg = -inf\n
  22:11: body.mass_kg is -inf kg, but must be finite and greater than 0
  -inf
stiffness_n_per_m = 400 -> stiffness_n_per_m = -400
  30:21: contact.stiffness_n_per_m is -400 N/m, but must be finite and greater than 0
  -400
stiffness_n_per_m = 400 -> stiffness_n_per_m = inf
  30:21: contact.stiffness_n_per_m is inf N/m, but must be finite and greater than 0
  inf
stiffness_n_per_m = 400 -> stiffness_n_per_m = 1e13
  30:21: contact.stiffness_n_per_m is 10000000000000 N/m, but must be at most 1e12
  1e13
position_m = [0.05, 0.0, 0.0] -> position_m = [-1e13, 0.0, 0.0]
  23:14: body.position_m is -10000000000000 m, but must be at least -1e12
  [-1e13, 0.0, 0.0]
position_m = [0.05, 0.0, 0.0] -> position_m = [inf, 0.0, 0.0]
  23:14: body.position_m is inf m, but must be finite
  [inf, 0.0, 0.0]
mass_kg = 0.1\n -> mass_kg = inf\n
  22:11: body.mass_kg is inf kg, but must be finite; a body that does not move has fixed = true, and neither mass_kg nor axes
  inf
velocity_m_per_s = [0.0, 0.0, 0.0]\nforce_n -> velocity_m_per_s = [nan, 0.0, 0.0]\nforce_n
  24:20: body.velocity_m_per_s is NaN m/s, but must be finite
  [nan, 0.0, 0.0]
force_n = [-0.981, 0.0, 0.0] -> force_n = [inf, 0.0, 0.0]
  25:11: body.force_n is inf N, but must be finite
  [inf, 0.0, 0.0]
mass_kg = 0.25 -> mass_kg = 0
  11:11: device.mass_kg is 0 kg, but must be finite and greater than 0
  0
mass_kg = 0.25 -> mass_kg = inf
  11:11: device.mass_kg is inf kg, but must be finite and greater than 0
  inf
position_m = [0.0, 0.0, 0.0] -> position_m = [nan, 0.0, 0.0]
  12:14: device.position_m is NaN m, but must be finite
  [nan, 0.0, 0.0]
velocity_m_per_s = [0.0, 0.0, 0.0]\nquantum_m -> velocity_m_per_s = [inf, 0.0, 0.0]\nquantum_m
  13:20: device.velocity_m_per_s is inf m/s, but must be finite
  [inf, 0.0, 0.0]
quantum_m = 0 -> quantum_m = -1e-6
  14:13: device.quantum_m is -0.000001 m, but must be finite and not below 0
  -1e-6
force_n = [1.0, 0.0, 0.0]\n -> force_n = [nan, 0.0, 0.0]\n
  17:11: device.hand.force_n is NaN N, but must be finite
  [nan, 0.0, 0.0]
period_s = 0.02 -> period_s = 0
  5:12: loop.period_s is 0 s, but must be finite and greater than 0
  0
period_s = 0.02 -> period_s = -0.02
  5:12: loop.period_s is -0.02 s, but must be finite and greater than 0
  -0.02
delay_samples = 0 -> delay_samples = 1025
  6:17: loop.delay_samples is 1025 samples, but must be at most 1024
  1025
collisions = 3 -> collisions = 0
  40:14: measure.collisions is 0, but must be at least 1
  0
collisions = 3 -> duration_s = 0
  40:14: measure.duration_s is 0 s, but must be finite and greater than 0
  0
collisions = 3 -> duration_s = inf
  40:14: measure.duration_s is inf s, but must be finite and greater than 0
  inf
force_limit_n = 10 -> force_limit_n = 0
  35:17: render.force_limit_n is 0 N, but must be finite and greater than 0
  0
slew_limit_n_per_s = 1000 -> slew_limit_n_per_s = -1
  36:22: render.slew_limit_n_per_s is -1 N/s, but must be finite and greater than 0
  -1
speed_limit_m_per_s = 10 -> speed_limit_m_per_s = nan
  37:23: render.speed_limit_m_per_s is NaN m/s, but must be finite and greater than 0
  nan
[measure] -> [model]\ndevice_mass_kg = 0\n\n[measure]
  40:18: model.device_mass_kg is 0 kg, but must be finite and greater than 0
  0"#,
        28,
    );
}

#[test]
fn a_method_that_is_unknown_or_cannot_use_a_setting_is_refused() {
    assert_faults(
        r#"method = "hfcr" -> method = "hfrc"
  33:10: no method is called "hfrc"; did you mean "hfcr"?
  "hfrc"
method = "hfcr" -> method = "magic"
  33:10: no method is called "magic"; the methods are basic, seh, virtual-damper, popc, popc-ref, energy-corrected, force-bounding, pmi, energy-tank, virtual-coupling, hfcr-mod, hfcr-mod-st, hfcr, coupled
  "magic"
[methods.hfcr] -> [methods.hfrc]
  42:10: no method is called "hfrc"; did you mean "hfcr"?
  hfrc
[methods.hfcr] -> [methods."?"]
  42:10: no method is called "?"; the methods are basic, seh, virtual-damper, popc, popc-ref, energy-corrected, force-bounding, pmi, energy-tank, virtual-coupling, hfcr-mod, hfcr-mod-st, hfcr, coupled
  "?"
[methods.hfcr] -> [methods.basic]
  43:1: basic does not use damping_n_s_per_m; it is for virtual-damper, energy-tank, virtual-coupling, hfcr
  damping_n_s_per_m
[methods.hfcr] -> [methods.hfcr-mod]
  43:1: hfcr-mod does not use damping_n_s_per_m; it is for virtual-damper, energy-tank, virtual-coupling, hfcr
  damping_n_s_per_m
damping_n_s_per_m = 0.1 -> damping_cap_n_s_per_m = 0.1
  43:1: hfcr does not use damping_cap_n_s_per_m; it is for popc, popc-ref, energy-tank
  damping_cap_n_s_per_m
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = -0.1
  43:21: damping_n_s_per_m is -0.1 N s/m, but must be finite and not below 0
  -0.1
[methods.hfcr]\ndamping_n_s_per_m = 0.1 -> [methods.virtual-damper]\ndamping_n_s_per_m = "auto"
  43:21: only hfcr accepts "auto" for its damping; give virtual-damper a number
  "auto"
damping_cap_n_s_per_m = 6 -> damping_cap_n_s_per_m = 0
  46:25: damping_cap_n_s_per_m is 0 N s/m, but must be finite and greater than 0
  0
speed_threshold_m_per_s = 1e-4 -> speed_threshold_m_per_s = -1
  47:27: speed_threshold_m_per_s is -1 m/s, but must be finite and not below 0
  -1
initial_energy_j = 0 -> initial_energy_j = -1
  48:20: initial_energy_j is -1 J, but must be finite and not below 0
  -1
[methods.popc] -> [methods.popc-ref]
  48:1: popc-ref does not use initial_energy_j; it is for popc, energy-tank
  initial_energy_j
estimate = "ab2" -> damping_n_s_per_m = 1
  51:1: seh does not use damping_n_s_per_m; it is for virtual-damper, energy-tank, virtual-coupling, hfcr
  damping_n_s_per_m
estimate = "ab2" -> prediction = "observer"
  51:1: seh does not use prediction; it is for virtual-damper, hfcr
  prediction
estimate = "ab2" -> correction = false
  51:1: seh does not use correction; it is for coupled
  correction
estimate = "ab2" -> entry_hold = "sample"
  51:1: seh does not use entry_hold; it is for hfcr-mod-st, hfcr
  entry_hold
damping_n_s_per_m = 0.1 -> damper_object = "spring"
  43:1: hfcr does not use damper_object; it is for virtual-damper
  damper_object
damping_n_s_per_m = 0.1 -> damper_object = "both"
  43:17: unknown variant `both`, expected one of `spring-and-damper`, `spring`, `held-force`
  "both"
damping_n_s_per_m = 0.1 -> longest_window_s = 0.1
  43:20: longest_window_s requires prediction first-order-adaptive-window, but that of hfcr is last-step
  0.1
damping_n_s_per_m = 0.1 -> prediction = "first-order-adaptive-window"\nlongest_window_s = 0
  44:20: longest_window_s is 0 s, but must be finite and greater than 0
  0"#,
        21,
    );
}

#[test]
fn friction_and_a_hand_have_ranges_and_belong_together() {
    assert_faults(
        r#"quantum_m = 0 -> drivetrain.viscous_friction_n_s_per_m = -1
  14:41: device.drivetrain.viscous_friction_n_s_per_m is -1 N s/m, but must be finite and not below 0
  -1
quantum_m = 0 -> drivetrain.coulomb_friction_n = nan
  14:33: device.drivetrain.coulomb_friction_n is NaN N, but must be finite and not below 0
  nan
quantum_m = 0 -> drivetrain.motor_limit_n = 0
  14:28: device.drivetrain.motor_limit_n is 0 N, but must be finite and greater than 0
  0
force_n = [1.0, 0.0, 0.0]\n -> tremor_n = 0.1\n
  17:12: a tremor needs both tremor_n and tremor_hz
  0.1
force_n = [1.0, 0.0, 0.0]\n -> tremor_n = 0.1\ntremor_hz = -8\n
  18:13: device.hand.tremor_hz is -8 Hz, but must be finite and greater than 0
  -8
force_n = [1.0, 0.0, 0.0] -> stiffness_n_per_m = -100
  17:21: device.hand.stiffness_n_per_m is -100 N/m, but must be finite and not below 0
  -100
force_n = [1.0, 0.0, 0.0] -> mass_kg = inf
  17:11: device.hand.mass_kg is inf kg, but must be finite and not below 0
  inf
force_n = [1.0, 0.0, 0.0] -> damping_n_s_per_m = -3
  17:21: device.hand.damping_n_s_per_m is -3 N s/m, but must be finite and not below 0
  -3
force_n = [1.0, 0.0, 0.0] -> rest_m = [nan, 0.0, 0.0]
  17:10: device.hand.rest_m is NaN m, but must be finite
  [nan, 0.0, 0.0]
force_n = [1.0, 0.0, 0.0] -> swing_m = [0.01, 0.0, 0.0]
  17:11: a swing needs both swing_m and swing_hz
  [0.01, 0.0, 0.0]
force_n = [1.0, 0.0, 0.0] -> swing_m = [0.01, 0.0, 0.0]\nswing_hz = 0
  18:12: device.hand.swing_hz is 0 Hz, but must be finite and greater than 0
  0
force_n = [1.0, 0.0, 0.0]\n -> release_s = -1\n
  17:13: device.hand.release_s is -1 s, but must be finite and not below 0
  -1
force_n = [1.0, 0.0, 0.0] -> rest_m = [0.01, 0.0, 0.0]\nrest_file = "hand.csv"
  17:10: rest_file already sets where the hand pulls to
  [0.01, 0.0, 0.0]
force_n = [1.0, 0.0, 0.0] -> rest_file = "hand.csv"
  17:13: hand.csv cannot be read: this scene is read without other files
  "hand.csv"
force_n = [1.0, 0.0, 0.0] -> rest_file = 3
  17:13: invalid type: integer `3`, expected a string
  3"#,
        15,
    );
}

#[test]
fn recorded_intention_is_read_and_its_faults_point_to_the_key() {
    let text = edited("force_n = [1.0, 0.0, 0.0]", "rest_file = \"hand.csv\"");
    let read = |content: &str| {
        ContactFile::parse_with("scene.toml", &text, &mut |name| {
            assert_eq!(name, "hand.csv");
            Ok(content.into())
        })
    };
    // Times count from the first sample.
    let scene = read("t_s,position_m\n5,0\n5.5,0.01\n").unwrap().scene;
    let Some(Intention::Recorded(path)) = scene.device.grip().map(|grip| &grip.intention) else {
        panic!("a recorded intention")
    };
    assert_eq!(
        (path.times(), path.positions()),
        (&[0.0, 0.5][..], &[0.0, 0.01][..])
    );
    for (content, message) in [
        ("t_s,position_m\n0,0\n0,1\n", "hand.csv:3:1: "),
        (
            "t_s,position\n0,0\n",
            "hand.csv:1:5: the header has no column `position_m`",
        ),
        ("t_s,position_m\n0,0\n", "hand.csv:2:4: a trace needs"),
    ] {
        let error = read(content).unwrap_err();
        assert_eq!(&text[error.first().span.clone()], "\"hand.csv\"");
        assert!(error.first().message.starts_with(message), "{error}");
        assert!(
            error.to_string().starts_with("scene.toml:17:13: "),
            "{error}"
        );
    }
}

#[test]
fn a_device_has_what_it_needs_and_nothing_else() {
    assert_faults(
        r#"mass_kg = 0.25\n -> 
  8:1: a device needs mass_kg, mass_table or linkage
  [[device]]
mass_kg = 0.25\n -> mass_kg = [0.25, 0.3]\n
  11:11: device.mass_kg has 2 numbers, but the device has 1 axis; give one number
  [0.25, 0.3]
mass_kg = 0.25\n -> mass_kg = 0.25\nsafety_box = { y_m = [-1, 1] }\n
  12:14: device.safety_box is for a device with a linkage
  { y_m = [-1, 1] }
axes = ["x"]\nmass_kg = 0.25\nposition_m = [0.0, 0.0, 0.0]\nvelocity_m_per_s = [0.0, 0.0, 0.0]\nquantum_m = 0\n\n[device.hand]\nforce_n = [1.0, 0.0, 0.0] -> axes = ["x"]\nlinkage = { preset = "paper-like" }
  10:8: a device with a linkage moves along y: axes = ["y"]
  ["x"]"#,
        4,
    );
}

#[test]
fn text_that_is_not_toml_is_refused() {
    assert_faults(
        r#"title = "a block" -> title = "a block
  2:17: invalid basic string, expected `"`
  
title = "a block" -> title = "a block"\ntitle = "b"
  3:1: duplicate key
  title"#,
        2,
    );
}

#[test]
fn of_two_unknown_methods_the_first_in_the_file_is_named_every_time() {
    let text =
        edited("[methods.popc]", "[methods.first]").replace("[methods.seh]", "[methods.second]");
    for _ in 0..50 {
        let error = ContactFile::parse("scene.toml", &text).unwrap_err();
        assert_eq!(&text[error.first().span.clone()], "first", "{error}");
    }
}

#[test]
fn a_file_of_another_version_is_refused_for_that_and_not_for_its_new_keys() {
    let text = edited("format = 2", "format = 3\nauthor = \"me\"");
    let error = ContactFile::parse("scene.toml", &text).unwrap_err();
    assert_eq!(
        error.to_string(),
        "scene.toml:1:10: format is 3, but must be 2"
    );
}

#[test]
fn a_radius_and_a_hand_in_the_motors_have_their_limits() {
    assert_faults(
        r#"force_n = [-0.981, 0.0, 0.0] -> force_n = [-0.981, 0.0, 0.0]\ncentre_m = [-0.01, 0.0, 0.0]
  26:12: body.centre_m must point into the solid, against the normal of the half_space
  [-0.01, 0.0, 0.0]
force_n = [1.0, 0.0, 0.0]\n -> force_n = [1.0, 0.0, 0.0]\nforce_at = "motors"\n
  18:12: device.hand.force_at is for a device with a linkage
  "motors"
force_n = [1.0, 0.0, 0.0]\n -> force_n = [1.0, 0.0, 0.0]\nforce_at = "elbow"\n
  18:12: unknown variant `elbow`, expected `end-point` or `motors`
  "elbow""#,
        3,
    );
}
