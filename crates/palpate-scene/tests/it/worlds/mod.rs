//! Scene files of worlds, and their error messages.
#![allow(missing_docs)]

mod devices;
mod guard;

use palpate_core::Hold;
use palpate_scene::world::WorldFile;
use palpate_scene::{ContactFile, SceneFile};
use palpate_world::{Motion, Party, Shape};

const BALL: &str = r#"
format = 2
title = "a ball on the floor"
[loop]
period_s = 0.001
delay_s = 0.0005
[[device]]
name = "tool"
mass_kg = [0.25, 0.3, 0.35]
position_m = [0.0, 0.0, 0.08]
hand.force_n = [0.0, 0.0, -1.0]
quantum_m = 2e-6
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.1
position_m = [0.0, 0.0, 0.03]
velocity_m_per_s = [0.0, 0.0, 0.0]
force_n = [0.0, 0.0, -0.981]
shape = { sphere = { radius_m = 0.03 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 2.0], offset_m = 0.0 } }
[[contact]]
between = ["tool", "*"]
stiffness_n_per_m = 4000.0
friction = 0.3
damping_n_s_per_m = 0.5
[[contact]]
between = ["ball", "floor"]
stiffness_n_per_m = 8000
friction_stiffness_n_per_m = 2000.0
[render]
method = "coupled"
[model]
device_mass_kg = 0.375
"#;

fn said(source: &str) -> Vec<String> {
    let errors = WorldFile::parse("ball.toml", source).unwrap_err();
    errors.iter().map(ToString::to_string).collect()
}

#[test]
fn a_world_is_read_with_its_devices_bodies_and_contacts() {
    let any = SceneFile::parse("ball.toml", BALL).unwrap();
    assert!(matches!(any, SceneFile::World(_)));
    let as_one_contact = ContactFile::parse("ball.toml", BALL).unwrap_err();
    assert_eq!(
        as_one_contact.to_string(),
        "ball.toml:7:1: one contact along one axis is needed here, but the device has 3 axes"
    );
    let without = said(&BALL.replace("format = 2", ""));
    assert_eq!(
        without,
        ["ball.toml:1:1: the key format is missing; a scene has format = 2"]
    );
    let scene = WorldFile::parse("ball.toml", BALL).unwrap().scene;
    assert_eq!(scene.timing.period, 0.001);
    assert_eq!(scene.timing.device_delay(), 0.0005);
    assert_eq!(scene.timing.actuator.gain, 1.0);
    let [device] = &scene.devices[..] else {
        panic!("one device")
    };
    assert_eq!(device.mass, [0.25, 0.3, 0.35]);
    assert_eq!(device.quantum, [2e-6; 3]);
    // Without a place of its own the hand's spring rests where the device begins.
    assert_eq!(device.hand.rest, device.position);
    assert_eq!(scene.render.device_mass, [[0.375; 3]]);
    // Without `[model]`, the model values equal the true ones.
    let (model, timing) = (scene.render.actuation, &scene.timing);
    assert_eq!(model.delay, timing.device_delay());
    assert_eq!(
        (model.lag, model.gain),
        (timing.actuator.lag, timing.actuator.gain)
    );
    let [ball, floor] = &scene.world.bodies[..] else {
        panic!("two bodies")
    };
    assert!(matches!(&ball.motion, Motion::Free(free) if free.force == [0.0, 0.0, -0.981]));
    assert_eq!(floor.motion, Motion::Fixed);
    // A normal of any length is a direction.
    let up = [0.0, 0.0, 1.0];
    assert_eq!(
        floor.shape,
        Shape::HalfSpace {
            normal: up,
            offset: 0.0
        }
    );
    let law = scene.world.law("tool", "floor").unwrap();
    assert_eq!((law.friction, law.damping), (0.3, 0.5));
    // Without one of its own, friction is as stiff as the contact.
    assert_eq!(law.friction_stiffness, 4000.0);
    // The same share of damping to stiffness as the contact.
    assert_eq!(law.friction_damping, 0.5);
    assert_eq!(scene.world.contacts[0].between[1], Party::Any);
}

#[test]
fn every_fault_is_said_at_its_place() {
    let wrong = BALL
        .replace("stiffness_n_per_m = 4000.0", "stiffness_n_per_m = -4000.0")
        .replace("period_s = 0.001", "period_s = 0")
        .replace("[\"ball\", \"floor\"]", "[\"ball\", \"flor\"]")
        .replace("mass_kg = 0.1", "mas_kg = 0.1");
    assert_eq!(
        said(&wrong),
        [
            "ball.toml:5:12: period_s is 0, and has to be above 0",
            "ball.toml:16:1: unknown key mas_kg, did you mean mass_kg? Known here: name, fixed, axes, \
             mass_kg, inertia_kg_m2, position_m, centre_m, orientation, velocity_m_per_s, \
             angular_velocity_rad_per_s, force_n, shape",
            "ball.toml:27:21: contact between \"tool\" and \"*\": stiffness is -4000, and has to be above 0",
            "ball.toml:31:11: contact between \"ball\" and \"flor\": \"flor\" is neither a tool nor a body of \
             this world",
        ]
    );
}

/// Consequences of a faulty key are not reported.
#[test]
fn a_fault_is_said_once() {
    let mesh = "shape = { mesh = { fil = \"ball.stl\" } }";
    for (wrong, instead, fault) in [
        (
            "shape = { sphere = { radius_m = 0.03 } }",
            mesh,
            "unknown key fil,",
        ),
        (
            "mass_kg = [0.25, 0.3, 0.35]",
            "axes = [\"x\", \"u\"]\nmass_kg = [0.25, 0.25]",
            "expected one to three of",
        ),
        (
            "stiffness_n_per_m = 4000.0",
            "stiffness_n_per_m = inf",
            "stiffness is inf, and has to be finite",
        ),
        (
            "mass_kg = [0.25, 0.3, 0.35]",
            "mass_kg = [0.25, 0.25, 1e200]",
            "mass_kg is 1",
        ),
        ("name = \"tool\"", "name = \"left, upper\"", "have no comma"),
        (
            "mass_kg = [0.25, 0.3, 0.35]",
            "mass_kg = 0.2\ninertia_kg_m2 = [1e-4, 1e-4]\norientation = [1, 0, 0, 0]\nquantum_rad = 1e-5",
            "invalid length 2",
        ),
        (
            "mass_kg = [0.25, 0.3, 0.35]",
            "mass_kg = 0.2\ninertia = [1e-4, 1e-4, 1e-4]\norientation = [1, 0, 0, 0]",
            "unknown key inertia, did you mean inertia_kg_m2?",
        ),
        (
            "mass_kg = [0.25, 0.3, 0.35]",
            "mass_kg = 0.2\nvelocity_m_per_s = [0.1, { y = 0.2 }, 0.0]",
            "invalid type: map, expected a number",
        ),
    ] {
        assert!(BALL.contains(wrong), "{wrong}");
        // Contacts also contain the name of the tool.
        let text = BALL.replacen(wrong, instead, 1).replace(
            "[\"tool\", \"*\"]",
            if instead.starts_with("name") {
                "[\"left, upper\", \"*\"]"
            } else {
                "[\"tool\", \"*\"]"
            },
        );
        let said = said(&text);
        assert!(
            said.len() == 1 && said[0].contains(fault),
            "{instead}: {said:?}"
        );
    }
}

/// Characters that a terminal would interpret as a command.
#[test]
fn a_body_has_no_control_character_in_its_name() {
    let said = said(&BALL.replace("floor", "flo\\u001b[31mor"));
    let [only] = &said[..] else {
        panic!("{said:?}");
    };
    assert!(only.contains("must have no control character"), "{only}");
}

/// A key at fault that has nothing to do with the axes does not hide that there are too few masses for them.
#[test]
fn two_faults_of_a_device_are_both_said() {
    let text = BALL.replacen(
        "mass_kg = [0.25, 0.3, 0.35]",
        "colour = 1\nmass_kg = [0.25, 0.3]",
        1,
    );
    let said = said(&text);
    for fault in [
        "unknown key colour",
        "mass_kg has 2 numbers, and the device has 3 axes",
    ] {
        let of_it = said.iter().filter(|line| line.contains(fault));
        assert_eq!(of_it.count(), 1, "{fault}: {said:?}");
    }
}

#[test]
fn a_world_without_contacts_is_said_to_have_none() {
    let end = BALL.find("[[contact]]").unwrap();
    let rest = BALL.find("[render]").unwrap();
    let text = BALL[..end].to_owned() + &BALL[rest..];
    let file = WorldFile::parse("ball.toml", &text).unwrap();
    assert_eq!(
        file.notes(),
        ["the world has no [[contact]], so nothing in it is felt"]
    );
}

#[test]
fn a_world_without_bodies_is_said_to_have_none() {
    let at = |part: &str| BALL.find(part).unwrap();
    let of_all = at("[[contact]]")..BALL.rfind("[[contact]]").unwrap();
    let text = [
        &BALL[..at("[[body]]")],
        &BALL[of_all],
        &BALL[at("[render]")..],
    ];
    let file = WorldFile::parse("tool.toml", &text.concat()).unwrap();
    assert_eq!(
        file.notes(),
        ["the world has no [[body]], so nothing in it is felt"]
    );
}

#[test]
fn a_mass_for_all_axes_or_for_each_and_nothing_else() {
    // Only the faulty value is reported, not the parts that depend on it.
    let message =
        "expected a number for all axes of the device, or one for each, such as [x, y, z]";
    for (given, length) in [("[]", 0), ("[0.1, 0.1, 0.1, 0.1]", 4)] {
        let wrong = BALL.replace("[0.25, 0.3, 0.35]", given);
        assert_eq!(
            said(&wrong),
            [format!(
                "ball.toml:9:11: invalid length {length}, {message}"
            )]
        );
    }
    let two = BALL.replace("[0.25, 0.3, 0.35]", "[0.25, 0.3]");
    assert_eq!(
        said(&two),
        [
            "ball.toml:9:11: mass_kg has 2 numbers, and the device has 3 axes; give one number for all axes, or 3 numbers in the \
             order x, y, z"
        ]
    );
    let word = BALL.replace("[0.25, 0.3, 0.35]", "\"heavy\"");
    assert_eq!(
        said(&word),
        [format!(
            "ball.toml:9:11: invalid type: string \"heavy\", {message}"
        )]
    );
    let neither = BALL.replace("mass_kg = 0.1\n", "");
    assert_eq!(
        said(&neither),
        ["ball.toml:14:1: a body needs either mass_kg or fixed = true"]
    );
}

#[test]
fn a_fixed_body_has_no_mass_and_no_velocity() {
    let heavy = BALL.replace("fixed = true", "fixed = true\nmass_kg = 3.0");
    assert_eq!(
        said(&heavy),
        ["ball.toml:24:11: a fixed body has no mass_kg"]
    );
    let moving = BALL.replace("fixed = true", "fixed = true\nforce_n = [0.0, 0.0, 1.0]");
    assert_eq!(
        said(&moving),
        ["ball.toml:24:11: a fixed body has no force_n"]
    );
    let belt = BALL.replace(
        "fixed = true",
        "fixed = true\nvelocity_m_per_s = [0.2, 0.0, 0.0]",
    );
    assert_eq!(
        said(&belt),
        [
            "ball.toml:24:20: a fixed body has no velocity_m_per_s; a body of a large mass keeps its velocity (mass_kg = \
          1e6 instead of fixed)"
        ]
    );
}

#[test]
fn numbers_that_no_world_has_are_refused() {
    for (right, wrong, message) in [
        (
            "radius_m = 0.03",
            "radius_m = 0.0",
            "radius_m is 0, and has to be above 0",
        ),
        (
            "normal = [0.0, 0.0, 2.0]",
            "normal = [0.0, 0.0, 0.0]",
            "normal has length 0, so it has no direction; give a finite length above 0",
        ),
        (
            "friction = 0.3",
            "friction = nan",
            "friction is NaN, and has to be at least 0",
        ),
        (
            "[0.0, 0.0, 0.08]",
            "[0.0, 0.0, inf]",
            "position_m is inf, and has to be finite",
        ),
        (
            "name = \"ball\"",
            "name = \"tool\"",
            "the name is taken by another tool or body",
        ),
        ("format = 2", "format = 3", "format is 3, but must be 2"),
    ] {
        let said = said(&BALL.replacen(right, wrong, 1));
        assert!(said[0].contains(message), "{wrong}: {said:?}");
    }
}

#[test]
fn every_committed_world_is_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/worlds");
    let mut files = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let source = std::fs::read_to_string(&path).unwrap();
        let name = path.display().to_string();
        let scene = WorldFile::parse(&name, &source).unwrap().scene;
        assert!(!scene.title.is_empty(), "{name}");
        files += 1;
    }
    assert!(files > 0);
}

#[test]
fn one_star_is_any_pair_and_other_words_say_what_is_allowed() {
    let any = BALL.replace(r#"["tool", "*"]"#, r#""*""#);
    let scene = WorldFile::parse("ball.toml", &any).unwrap().scene;
    assert_eq!(scene.world.contacts[0].between, [Party::Any, Party::Any]);
    for between in [
        r#""tool""#,
        r#"["tool"]"#,
        r#"["tool", "ball", "floor"]"#,
        "3",
    ] {
        let faults = said(&BALL.replace(r#"["tool", "*"]"#, between));
        let [fault] = &faults[..] else {
            panic!("{between}: {faults:?}")
        };
        assert!(
            fault.contains(r#"two names ["tool", "floor"], or "*" for any pair"#),
            "{fault}"
        );
    }
}

/// A world says which keys it cannot honour, and why it is a world.
#[test]
fn keys_of_one_contact_are_refused_in_a_world() {
    let after = |place: &str, keys: &str| BALL.replacen(place, &format!("{place}\n{keys}"), 1);
    for (place, keys) in [
        ("quantum_m = 2e-6", "hand.force_at = \"motors\""),
        ("quantum_m = 2e-6", "drivetrain.cogging_n = 0.1"),
        ("quantum_m = 2e-6", "drivetrain.resonance_hz = 80"),
        ("[render]", "slew_limit_n_per_s = 10"),
        ("[model]", "resonance_hz = 100"),
    ] {
        let (key, _) = keys.split_once(" = ").unwrap();
        let said = said(&after(place, keys));
        let [only] = &said[..] else {
            panic!("{keys}: {said:?}")
        };
        let words =
            format!("{key} is for one contact along one axis only, but the device has 3 axes");
        assert!(only.ends_with(&words), "{only}");
    }
    let line = BALL.replacen("[loop]", "[loop]\nhold = \"line\"", 1);
    let known = WorldFile::parse("ball.toml", &line).unwrap().scene;
    assert_eq!(known.render.actuation.hold, Hold::Line);
    for (place, keys) in [
        ("[loop]", "lag_s = 0.0001"),
        ("[loop]", "command_jitter_s = 0.0001"),
        ("[loop]", "jitter_s = 0.0001"),
        ("[loop]", "drop_probability = 0.1"),
        ("[loop]", "dropped_samples = [3]"),
        (
            "[loop]",
            "collapse = { from_s = 0, until_s = 0.1, period_s = 0.002 }",
        ),
        ("quantum_m = 2e-6", "drivetrain.motor_limit_n = 4"),
        ("quantum_m = 2e-6", "inertia_kg_m2 = [1e-4, 1e-4, 1e-4]"),
        ("[render]", "guard.mode = \"report\""),
    ] {
        let (key, _) = keys.split_once(" = ").unwrap();
        let said = said(&line.replacen(place, &format!("{place}\n{keys}"), 1));
        let words = format!("{key} excludes lines in a world");
        assert!(said.len() == 1 && said[0].contains(&words), "{said:?}");
    }
    let along = said(&BALL.replace("mass_kg = 0.1", "mass_kg = 0.1\naxes = [\"z\"]"));
    assert!(along[0].contains("a body with `axes`"), "{along:?}");
    // A part of a period is unknown to the model.
    let works = after(
        "quantum_m = 2e-6",
        "drivetrain.viscous_friction_n_s_per_m = 0.5",
    );
    let works = works.replace(
        "delay_s = 0.0005",
        "delay_samples = 1\ndelay_fraction = 0.25",
    );
    let scene = WorldFile::parse("ball.toml", &works).unwrap().scene;
    assert_eq!(scene.devices[0].drivetrain.viscous_friction, 0.5);
    assert_eq!(scene.timing.delay.time(scene.timing.period), 0.00125);
    assert_eq!(scene.render.actuation.delay, 0.001);
    // Nor has a device in a loop in time.
    assert_eq!(scene.timing.device_delay(), 0.001);
}

/// A world reads the loop, the hand and the drivetrain of one contact, and names their faults.
#[test]
fn an_imperfect_loop_and_a_moving_hand_are_read() {
    let with = |keys: &str, of_loop: &str| {
        BALL.replace("quantum_m = 2e-6", &format!("quantum_m = 2e-6\n{keys}"))
            .replace("delay_s = 0.0005", of_loop)
    };
    let source = with(
        "noise_m = 1e-6\nhand.mass_kg = 0.2\nhand.swing_m = [0, 0, 0.01]\nhand.swing_hz = 2\n\
         hand.release_s = 0.4\ndrivetrain.coulomb_friction_n = 0.1\ndrivetrain.motor_limit_n = 3",
        "delay_samples = 1\njitter_s = 1e-4\njitter_deviation_s = 5e-5\ndrop_probability = 0.1\nseed = 3\n\
         command_jitter_s = 2e-4\ncollapse = { from_s = 0.1, until_s = 0.2, period_s = 0.002 }",
    );
    let scene = WorldFile::parse("ball.toml", &source).unwrap().scene;
    assert_eq!(scene.random_seed(), Some(3));
    let timing = &scene.timing.imperfections;
    assert_eq!(timing.shortest_period(0.003), 0.002);
    assert_eq!(timing.command_jitter, 2e-4);
    let (hand, drivetrain) = (&scene.devices[0].hand, scene.devices[0].drivetrain);
    assert_eq!((hand.mass, hand.release), (0.2, Some(0.4)));
    assert_eq!(hand.swing.unwrap().amplitude, [0.0, 0.0, 0.01]);
    assert_eq!(
        (drivetrain.coulomb_friction, drivetrain.largest_force),
        (0.1, 3.0)
    );
    assert_eq!(drivetrain.noise, 1e-6);

    for (keys, of_loop, words) in [
        ("", "jitter_s = 6e-4", "jitter_s is 0.0006"),
        ("", "drop_probability = 1.0", "drop_probability is 1"),
        ("", "dropped_samples = [0]", "dropped_samples is 0"),
        ("", "delay_samples = 2000", "delay_samples is 2000"),
        (
            "",
            "jitter_deviation_s = 1e-4",
            "jitter_deviation_s needs jitter_s",
        ),
        (
            "hand.swing_hz = 2",
            "",
            "a swing needs both swing_m and swing_hz",
        ),
        ("hand.rest_file = \"no.csv\"", "", "no.csv cannot be read"),
        ("hand.mass_kg = -1", "", "hand.mass_kg is -1"),
        (
            "drivetrain.motor_limit_n = 0",
            "",
            "drivetrain.motor_limit_n is 0",
        ),
        ("noise_m = -1", "", "noise_m is -1"),
    ] {
        let said = said(&with(keys, of_loop));
        assert!(
            said.len() == 1 && said[0].contains(words),
            "{keys}{of_loop}: {said:?}"
        );
    }
}

#[test]
fn a_setting_of_a_method_is_for_the_methods_that_use_it() {
    let with = |table: &str| format!("{BALL}\n[methods.{table}\n");
    let read = with("god-object]\ncoupling_stiffness_n_per_m = 900\ndamping_n_s_per_m = 3");
    let scene = WorldFile::parse("ball.toml", &read).unwrap().scene;
    assert!(scene.renderer("god-object").is_ok());
    assert!(scene.renderer("virtual-damper").is_err());
    for (table, words) in [
        (
            "god-object]\ncoupling_mass_kg = 0.1",
            "god-object does not use coupling_mass_kg; it is for virtual-coupling",
        ),
        (
            "coupled]\ndamping_n_s_per_m = 1",
            "coupled does not use damping_n_s_per_m; it is for virtual-damper, hfcr, virtual-coupling, god-object",
        ),
        (
            "virtual-damper]\ndamping_n_s_per = 1",
            "unknown key damping_n_s_per, did you mean damping_n_s_per_m?",
        ),
        (
            "virtual-damper]\ndamping_n_s_per_m = \"auto\"",
            "damping_n_s_per_m needs a number",
        ),
        (
            "virtual-damper]\ndamping_n_s_per_m = -1",
            "damping_n_s_per_m is -1, and has to be at least 0",
        ),
        ("seh]\nestimate = \"ab2\"", "unknown key estimate"),
    ] {
        let said = said(&with(table));
        assert!(said.len() == 1 && said[0].contains(words), "{said:?}");
    }
}

#[test]
fn one_contact_along_one_axis_is_read_as_such() {
    let wall = r#"
format = 2
loop = { period_s = 0.001 }
render = { method = "basic" }
[[device]]
name = "tip"
axes = [[0.0, 0.6, 0.8]]
mass_kg = [0.2]
position_m = [5.0, -0.012, -0.016]
hand.force_n = [0.0, 0.6, 0.8]
[[body]]
name = "wall"
fixed = true
position_m = [9.0, 0.0, 0.0]
orientation = [0.0, 1.0, 0.0, 0.0]
shape = { half_space = { normal = [0.0, 3.0, 4.0], offset_m = 0.01 } }
[[contact]]
between = "*"
stiffness_n_per_m = 1000
"#;
    let file = ContactFile::parse("wall.toml", wall).unwrap();
    let scene = file.scene;
    assert!((scene.object.position + 0.01).abs() < 1e-15);
    assert_eq!(scene.contact.side, palpate_core::Side::Positive);
    assert!((scene.device.position() + 0.02).abs() < 1e-15);
    assert!((scene.device.hand_force() - 1.0).abs() < 1e-15);
    assert_eq!(scene.measure, palpate_scene::Measure::Duration(0.5));
    // The same file is a world for who asks for one.
    assert!(WorldFile::parse("wall.toml", wall).is_ok());
    for (right, other, reason) in [
        (
            "[[0.0, 0.6, 0.8]]",
            "[[0.0, 0.6, 0.8], [1, 0, 0]]",
            "the device has 2 axes",
        ),
        (
            "mass_kg = [0.2]",
            "mass_kg = [0.2]\ntool = { sphere = { radius_m = 0.01 } }",
            "the tool is not a point",
        ),
        (
            "normal = [0.0, 3.0, 4.0]",
            "normal = [0.0, 3.0, 4.1]",
            "the normal of the half_space is not along the axis of the device",
        ),
        (
            "stiffness_n_per_m = 1000",
            "stiffness_n_per_m = 1000\nfriction = 0.1",
            "the contact has friction",
        ),
        (
            "method = \"basic\"",
            "method = \"basic\", guard = { mode = \"limit\", late_samples = 1 }",
            "the guard has late_samples",
        ),
    ] {
        let said = ContactFile::parse("wall.toml", &wall.replacen(right, other, 1)).unwrap_err();
        assert!(said.to_string().contains(reason), "{other}: {said}");
    }
}
