//! All errors of a scene file: position, message, and marked text.

use palpate_scene::{Intention, SceneFile};

use crate::scene_files::edited;

/// Checks a table of edits of the good file, three lines each: the edit, the message with its place, what is at fault.
#[track_caller]
pub fn assert_faults(table: &str, rows: usize) {
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 3 * rows, "the table has another length");
    for row in lines.chunks(3) {
        let (from, to) = row[0].split_once(" -> ").unwrap();
        let text = edited(&from.replace("\\n", "\n"), &to.replace("\\n", "\n"));
        let Err(errors) = SceneFile::parse("scene.toml", &text) else {
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
  15:1: unknown key mas_kg, did you mean mass_kg? Known here: kind, preset, file, safety_box, mass_kg, position_m, velocity_m_per_s, encoder_quantum_m, viscous_n_s_per_m, coulomb_n, motor_limit_n, resonance_hz, resonance_damping_ratio, motor_mass_share, backlash_m, cogging_n, cogging_pitch_m, noise_m
  mas_kg
period_s -> perod_s
  24:1: unknown key perod_s, did you mean period_s? Known here: period_s, delay_samples, delay_fraction, delay_s, command_jitter_s, lag_s, gain, jitter_s, jitter_deviation_s, drop_probability, dropped_samples, collapse, seed
  perod_s
[hand] -> [hnd]
  19:2: unknown key hnd, did you mean hand? Known here: scene_format, title, object, device, hand, loop, model, measure, renderer, methods
  hnd
[hand] -> [zzz]\n[hand]
  19:2: unknown key zzz. Known here: scene_format, title, object, device, hand, loop, model, measure, renderer, methods
  zzz
collisions = 3 -> collisons = 3
  28:1: unknown key collisons, did you mean collisions? Known here: collisions, duration_s
  collisons
damping_cap_n_s_per_m -> damping_cap
  41:1: unknown key damping_cap, did you mean damping_cap_n_s_per_m? Known here: estimate, damping_n_s_per_m, prediction, damper_object, longest_window_s, damping_cap_n_s_per_m, speed_threshold_m_per_s, initial_energy_j, entry_hold, placement, correction
  damping_cap"#,
        6,
    );
}

#[test]
fn a_missing_key_is_named_where_it_should_stand() {
    assert_faults(
        r#"scene_format = 1\n -> 
  1:1: the key scene_format is missing; a scene of one contact has scene_format = 1, and a world of several bodies format = 2
  
title = "a block"\n -> 
  1:1: the key title is missing
  
mass_kg = 0.1\n -> 
  4:1: the key mass_kg is missing
  [object]
period_s = 0.02\n -> 
  23:1: the key period_s is missing
  [loop]
[measure]\ncollisions = 3\n -> 
  1:1: the key measure is missing
  
collisions = 3 -> collisions = 3\nduration_s = 1
  27:1: [measure] needs either collisions or duration_s
  [measure]
collisions = 3\n -> 
  27:1: [measure] needs either collisions or duration_s
  [measure]"#,
        7,
    );
}

#[test]
fn a_value_of_another_type_is_refused() {
    assert_faults(
        r#"scene_format = 1 -> scene_format = "1"
  1:16: invalid type: string "1", expected a whole number
  "1"
mass_kg = 0.1\n -> mass_kg = "light"\n
  5:11: invalid type: string "light", expected a number
  "light"
side = "positive" -> side = "left"
  10:8: unknown variant `left`, expected `positive` or `negative`
  "left"
kind = "point-mass" -> kind = "robot"
  13:8: unknown variant `robot`, expected `point-mass` or `pantograph`
  "robot"
kind = "constant-force" -> kind = "spring"
  20:8: unknown variant `spring`, expected `constant-force` or `impedance`
  "spring"
delay_samples = 0 -> delay_samples = -1
  25:17: invalid value: integer `-1`, expected a whole number from 0 up
  -1
delay_samples = 0 -> delay_samples = 1.5
  25:17: invalid type: floating point `1.5`, expected a whole number from 0 up
  1.5
collisions = 3 -> collisions = -3
  28:14: invalid value: integer `-3`, expected a whole number from 0 up
  -3
unilateral = false -> unilateral = 0
  32:14: invalid type: integer `0`, expected a boolean
  0
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = "atuo"
  38:21: invalid value: string "atuo", expected a number in N s/m or "auto"
  "atuo"
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = true
  38:21: invalid type: boolean `true`, expected a number in N s/m or "auto"
  true
estimate = "ab2" -> estimate = "ab4"
  46:12: unknown variant `ab4`, expected one of `ab2`, `differences`, `ab3`
  "ab4""#,
        12,
    );
}

#[test]
fn a_value_out_of_range_is_named_with_its_unit_and_what_is_allowed() {
    assert_faults(
        r#"scene_format = 1 -> scene_format = 2
  1:16: scene_format is 2, but this version reads 1 only
  2
mass_kg = 0.1\n -> mass_kg = 0\n
  5:11: object.mass_kg is 0 kg, but must be finite and greater than 0
  0
mass_kg = 0.1\n -> mass_kg = nan\n
  5:11: object.mass_kg is NaN kg, but must be finite and greater than 0
  nan
mass_kg = 0.1\n -> mass_kg = -inf\n
  5:11: object.mass_kg is -inf kg, but must be finite and greater than 0
  -inf
stiffness_n_per_m = 400 -> stiffness_n_per_m = -400
  6:21: object.stiffness_n_per_m is -400 N/m, but must be finite and greater than 0
  -400
stiffness_n_per_m = 400 -> stiffness_n_per_m = inf
  6:21: object.stiffness_n_per_m is inf N/m, but must be finite and greater than 0
  inf
stiffness_n_per_m = 400 -> stiffness_n_per_m = 1e13
  6:21: object.stiffness_n_per_m is 10000000000000 N/m, but must be at most 1e12
  1e13
position_m = 0.05 -> position_m = -1e13
  7:14: object.position_m is -10000000000000 m, but must be at least -1e12
  -1e13
position_m = 0.05 -> position_m = inf
  7:14: object.position_m is inf m, but must be finite
  inf
mass_kg = 0.1\nstiffness_n_per_m = 400\nposition_m = 0.05\nvelocity_m_per_s = 0 -> mass_kg = inf\nstiffness_n_per_m = 400\nposition_m = 0.05\nvelocity_m_per_s = 0.5
  8:20: object.velocity_m_per_s is 0.5 m/s, but must be 0 for a wall
  0.5
position_m = 0.05\nvelocity_m_per_s = 0 -> position_m = 0.05\nvelocity_m_per_s = nan
  8:20: object.velocity_m_per_s is NaN m/s, but must be finite
  nan
force_n = -0.981 -> force_n = inf
  9:11: object.force_n is inf N, but must be finite
  inf
mass_kg = 0.25 -> mass_kg = 0
  14:11: device.mass_kg is 0 kg, but must be finite and greater than 0
  0
mass_kg = 0.25 -> mass_kg = inf
  14:11: device.mass_kg is inf kg, but must be finite and greater than 0
  inf
mass_kg = 0.25\nposition_m = 0 -> mass_kg = 0.25\nposition_m = nan
  15:14: device.position_m is NaN m, but must be finite
  nan
position_m = 0\nvelocity_m_per_s = 0 -> position_m = 0\nvelocity_m_per_s = inf
  16:20: device.velocity_m_per_s is inf m/s, but must be finite
  inf
encoder_quantum_m = 0 -> encoder_quantum_m = -1e-6
  17:21: device.encoder_quantum_m is -0.000001 m, but must be finite and not below 0
  -1e-6
force_n = 1\n -> force_n = nan\n
  21:11: hand.force_n is NaN N, but must be finite
  nan
period_s = 0.02 -> period_s = 0
  24:12: loop.period_s is 0 s, but must be finite and greater than 0
  0
period_s = 0.02 -> period_s = -0.02
  24:12: loop.period_s is -0.02 s, but must be finite and greater than 0
  -0.02
delay_samples = 0 -> delay_samples = 1025
  25:17: loop.delay_samples is 1025 samples, but must be at most 1024
  1025
collisions = 3 -> collisions = 0
  28:14: measure.collisions is 0, but must be at least 1
  0
collisions = 3 -> duration_s = 0
  28:14: measure.duration_s is 0 s, but must be finite and greater than 0
  0
collisions = 3 -> duration_s = inf
  28:14: measure.duration_s is inf s, but must be finite and greater than 0
  inf
force_limit_n = 10 -> force_limit_n = 0
  33:17: renderer.force_limit_n is 0 N, but must be finite and greater than 0
  0
slew_limit_n_per_s = 1000 -> slew_limit_n_per_s = -1
  34:22: renderer.slew_limit_n_per_s is -1 N/s, but must be finite and greater than 0
  -1
speed_limit_m_per_s = 10 -> speed_limit_m_per_s = nan
  35:23: renderer.speed_limit_m_per_s is NaN m/s, but must be finite and greater than 0
  nan
unilateral = false -> device_mass_kg = 0
  32:18: renderer.device_mass_kg is 0 kg, but must be finite and greater than 0
  0"#,
        28,
    );
}

#[test]
fn a_method_that_is_unknown_or_cannot_use_a_setting_is_refused() {
    assert_faults(
        r#"method = "hfcr" -> method = "hfrc"
  31:10: no method is called "hfrc"; did you mean "hfcr"?
  "hfrc"
method = "hfcr" -> method = "magic"
  31:10: no method is called "magic"; the methods are basic, seh, virtual-damper, popc, popc-ref, hfcr-mod, hfcr-mod-st, hfcr, coupled
  "magic"
[methods.hfcr] -> [methods.hfrc]
  37:10: no method is called "hfrc"; did you mean "hfcr"?
  hfrc
[methods.hfcr] -> [methods."?"]
  37:10: no method is called "?"; the methods are basic, seh, virtual-damper, popc, popc-ref, hfcr-mod, hfcr-mod-st, hfcr, coupled
  "?"
[methods.hfcr] -> [methods.basic]
  38:1: basic does not use damping_n_s_per_m; it is for virtual-damper, hfcr
  damping_n_s_per_m
[methods.hfcr] -> [methods.hfcr-mod]
  38:1: hfcr-mod does not use damping_n_s_per_m; it is for virtual-damper, hfcr
  damping_n_s_per_m
damping_n_s_per_m = 0.1 -> damping_cap_n_s_per_m = 0.1
  38:1: hfcr does not use damping_cap_n_s_per_m; it is for popc, popc-ref
  damping_cap_n_s_per_m
damping_n_s_per_m = 0.1 -> damping_n_s_per_m = -0.1
  38:21: damping_n_s_per_m is -0.1 N s/m, but must be finite and not below 0
  -0.1
[methods.hfcr]\ndamping_n_s_per_m = 0.1 -> [methods.virtual-damper]\ndamping_n_s_per_m = "auto"
  38:21: only hfcr derives its damping; give virtual-damper a number
  "auto"
damping_cap_n_s_per_m = 6 -> damping_cap_n_s_per_m = 0
  41:25: damping_cap_n_s_per_m is 0 N s/m, but must be finite and greater than 0
  0
speed_threshold_m_per_s = 1e-4 -> speed_threshold_m_per_s = -1
  42:27: speed_threshold_m_per_s is -1 m/s, but must be finite and not below 0
  -1
initial_energy_j = 0 -> initial_energy_j = -1
  43:20: initial_energy_j is -1 J, but must be finite and not below 0
  -1
[methods.popc] -> [methods.popc-ref]
  43:1: popc-ref does not use initial_energy_j; it is for popc
  initial_energy_j
estimate = "ab2" -> damping_n_s_per_m = 1
  46:1: seh does not use damping_n_s_per_m; it is for virtual-damper, hfcr
  damping_n_s_per_m
estimate = "ab2" -> prediction = "observer"
  46:1: seh does not use prediction; it is for virtual-damper, hfcr
  prediction
estimate = "ab2" -> correction = false
  46:1: seh does not use correction; it is for coupled
  correction
estimate = "ab2" -> entry_hold = "sample"
  46:1: seh does not use entry_hold; it is for hfcr-mod-st, hfcr
  entry_hold
damping_n_s_per_m = 0.1 -> damper_object = "spring"
  38:1: hfcr does not use damper_object; it is for virtual-damper
  damper_object
damping_n_s_per_m = 0.1 -> damper_object = "both"
  38:17: unknown variant `both`, expected one of `spring-and-damper`, `spring`, `held-force`
  "both"
damping_n_s_per_m = 0.1 -> longest_window_s = 0.1
  38:20: longest_window_s requires prediction first-order-adaptive-window, but that of hfcr is last-step
  0.1
damping_n_s_per_m = 0.1 -> prediction = "first-order-adaptive-window"\nlongest_window_s = 0
  39:20: longest_window_s is 0 s, but must be finite and greater than 0
  0"#,
        21,
    );
}

#[test]
fn friction_and_a_hand_have_ranges_and_belong_together() {
    assert_faults(
        r#"encoder_quantum_m = 0 -> viscous_n_s_per_m = -1
  17:21: device.viscous_n_s_per_m is -1 N s/m, but must be finite and not below 0
  -1
encoder_quantum_m = 0 -> coulomb_n = nan
  17:13: device.coulomb_n is NaN N, but must be finite and not below 0
  nan
encoder_quantum_m = 0 -> motor_limit_n = 0
  17:17: device.motor_limit_n is 0 N, but must be finite and greater than 0
  0
force_n = 1\n -> tremor_n = 0.1\n
  21:12: a tremor needs both tremor_n and tremor_hz
  0.1
force_n = 1\n -> tremor_n = 0.1\ntremor_hz = -8\n
  22:13: hand.tremor_hz is -8 Hz, but must be finite and greater than 0
  -8
force_n = 1\n -> stiffness_n_per_m = 100\n
  21:21: a hand of kind constant-force does not use this; kind = "impedance" does
  100
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nstiffness_n_per_m = -100
  21:21: hand.stiffness_n_per_m is -100 N/m, but must be finite and not below 0
  -100
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nmass_kg = inf
  21:11: hand.mass_kg is inf kg, but must be finite and not below 0
  inf
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\ndamping_n_s_per_m = -3
  21:21: hand.damping_n_s_per_m is -3 N s/m, but must be finite and not below 0
  -3
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nposition_m = nan
  21:14: hand.position_m is NaN m, but must be finite
  nan
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nswing_m = 0.01
  21:11: a swing needs both swing_m and swing_hz
  0.01
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nswing_m = 0.01\nswing_hz = 0
  22:12: hand.swing_hz is 0 Hz, but must be finite and greater than 0
  0
force_n = 1\n -> release_s = -1\n
  21:13: hand.release_s is -1 s, but must be finite and not below 0
  -1
force_n = 1\n -> intention = "hand.csv"\n
  21:13: a hand of kind constant-force does not use this; kind = "impedance" does
  "hand.csv"
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nposition_m = 0.01\nintention = "hand.csv"
  21:14: the recorded intention already sets the position of the hand
  0.01
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nintention = "hand.csv"
  21:13: hand.csv cannot be read: this scene is read without other files
  "hand.csv"
kind = "constant-force"\nforce_n = 1 -> kind = "impedance"\nintention = 3
  21:13: invalid type: integer `3`, expected a string
  3"#,
        17,
    );
}

#[test]
fn recorded_intention_is_read_and_its_faults_point_to_the_key() {
    let text = edited(
        "kind = \"constant-force\"\nforce_n = 1",
        "kind = \"impedance\"\nintention = \"hand.csv\"",
    );
    let read = |content: &str| {
        SceneFile::parse_with("scene.toml", &text, &mut |name| {
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
            error.to_string().starts_with("scene.toml:21:13: "),
            "{error}"
        );
    }
}

#[test]
fn a_device_has_what_its_kind_needs_and_nothing_else() {
    assert_faults(
        r#"mass_kg = 0.25\n -> 
  13:8: a device of kind point-mass needs mass_kg
  "point-mass"
mass_kg = 0.25\n -> preset = "paper-like"\nmass_kg = 0.25\n
  14:10: only a device of kind pantograph has a preset or a file
  "paper-like"
mass_kg = 0.25\n -> mass_kg = 0.25\nfile = "mine.toml"\n
  15:8: only a device of kind pantograph has a preset or a file
  "mine.toml"
mass_kg = 0.25\n -> mass_kg = 0.25\nsafety_box = { y_m = [-1, 1] }\n
  15:14: only a device of kind pantograph has a safety box
  { y_m = [-1, 1] }
kind = "point-mass" -> kind = "pantograph"
  13:8: a device of kind pantograph needs a preset, one of paper-like, 2diy-gen1, 2diy-gen2, 2diy-gen3, or a file
  "pantograph"
kind = "point-mass" -> kind = "pantograph"\npreset = "paper-like"
  15:11: a pantograph's preset or file sets this; only position_m and safety_box can be added
  0.25
kind = "point-mass"\nmass_kg = 0.25 -> kind = "pantograph"\npreset = "paper"
  14:10: no preset is called "paper"; did you mean "paper-like"?
  "paper"
kind = "point-mass"\nmass_kg = 0.25 -> kind = "pantograph"\npreset = "sigma"
  14:10: no preset is called "sigma"; the presets are paper-like, 2diy-gen1, 2diy-gen2, 2diy-gen3
  "sigma"
kind = "point-mass"\nmass_kg = 0.25\nposition_m = 0\nvelocity_m_per_s = 0\nencoder_quantum_m = 0 -> kind = "pantograph"\npreset = "paper-like"\nposition_m = 1
  15:14: device position = 1 is not allowed; allowed: within the linkage's reach
  1
kind = "point-mass"\nmass_kg = 0.25\nposition_m = 0\nvelocity_m_per_s = 0\nencoder_quantum_m = 0 -> kind = "pantograph"\npreset = "paper-like"\nsafety_box = { x_m = [-1, 1], z_m = [-1, 1] }
  15:31: unknown key z_m. Known here: x_m, y_m
  z_m"#,
        10,
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
        let error = SceneFile::parse("scene.toml", &text).unwrap_err();
        assert_eq!(&text[error.first().span.clone()], "first", "{error}");
    }
}

#[test]
fn a_file_of_another_version_is_refused_for_that_and_not_for_its_new_keys() {
    let text = edited("scene_format = 1", "scene_format = 2\nauthor = \"me\"");
    let error = SceneFile::parse("scene.toml", &text).unwrap_err();
    assert_eq!(
        error.to_string(),
        "scene.toml:1:16: scene_format is 2, but this version reads 1 only"
    );
}

#[test]
fn a_radius_and_a_hand_in_the_motors_have_their_limits() {
    assert_faults(
        r#"force_n = -0.981 -> force_n = -0.981\nradius_m = -0.01
  10:12: object.radius_m is -0.01 m, but must be finite and not below 0
  -0.01
force_n = 1\n -> force_n = 1\nforce_at = "motors"\n
  22:12: force_at = "motors" is for a device of kind pantograph, whose motors give torques
  "motors"
force_n = 1\n -> force_n = 1\nforce_at = "elbow"\n
  22:12: unknown variant `elbow`, expected `end-point` or `motors`
  "elbow""#,
        3,
    );
}
