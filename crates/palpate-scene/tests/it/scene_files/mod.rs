//! Scene files: the committed ones are good, and every fault has its line, its column, and a
//! message that says what is allowed.

mod faults;
mod loop_faults;
mod settings_table;
mod several;
mod written;

use std::path::{Path, PathBuf};

use palpate_core::{AnyParams, HfcrParams, Mass, Parameter, ParameterError, ParameterValue, Side};
use palpate_scene::method::{MethodName, SettingKey, UnknownMethod, method_named};
use palpate_scene::{
    ContactFile, Delay, Dropped, Intention, Jitter, Measure, RateCollapse, Scene, Timing, beside,
};
use palpate_study::sim::closed_loop::{Bench, LoopError};

/// A good file with every key there is, but duration_s.
const GOOD: &str = r#"format = 2
title = "a block"

[loop]
period_s = 0.02
delay_samples = 0

[[device]]
name = "device"
axes = ["x"]
mass_kg = 0.25
position_m = [0.0, 0.0, 0.0]
velocity_m_per_s = [0.0, 0.0, 0.0]
quantum_m = 0

[device.hand]
force_n = [1.0, 0.0, 0.0]

[[body]]
name = "object"
axes = ["x"]
mass_kg = 0.1
position_m = [0.05, 0.0, 0.0]
velocity_m_per_s = [0.0, 0.0, 0.0]
force_n = [-0.981, 0.0, 0.0]
shape = { half_space = { normal = [-1.0, 0.0, 0.0] } }

[[contact]]
between = ["device", "object"]
stiffness_n_per_m = 400

[render]
method = "hfcr"
unilateral = false
force_limit_n = 10
slew_limit_n_per_s = 1000
speed_limit_m_per_s = 10

[measure]
collisions = 3

[methods.hfcr]
damping_n_s_per_m = 0.1

[methods.popc]
damping_cap_n_s_per_m = 6
speed_threshold_m_per_s = 1e-4
initial_energy_j = 0

[methods.seh]
estimate = "ab2"
"#;

/// The keys of a body that moves; a wall has `fixed = true` in place of them.
const MOVING: &str = "axes = [\"x\"]\nmass_kg = 0.1\nposition_m = [0.05, 0.0, 0.0]\n\
                      velocity_m_per_s = [0.0, 0.0, 0.0]\nforce_n = [-0.981, 0.0, 0.0]\n";

/// The text with its one `from` replaced by `to`.
#[track_caller]
fn edited(from: &str, to: &str) -> String {
    assert_eq!(GOOD.matches(from).count(), 1, "{from} must stand once");
    GOOD.replacen(from, to, 1)
}

/// The committed scenes: the paper's, those of users, those on which coupled rendering is shown, and
/// readings of the paper's.
fn committed() -> Vec<PathBuf> {
    let folders =
        ["", "users", "coupled", "readings"].map(|name| crate::common::experiments().join(name));
    let entries = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = entries
        .filter(|path| path.is_file() && path.extension().unwrap() != "csv")
        .collect();
    scenes.sort();
    scenes
}

fn read(path: &Path) -> Scene {
    let text = std::fs::read_to_string(path).unwrap();
    let name = path.file_name().unwrap().to_str().unwrap();
    ContactFile::parse_with(name, &text, &mut beside(path))
        .unwrap_or_else(|error| panic!("{error}"))
        .scene
}

#[test]
fn the_committed_scenes_are_good_and_run_by_every_method() {
    let scenes = committed();
    for path in &scenes {
        let mut scene = read(path);
        // Three press a wall for a minute, which takes a quarter of one to compute.
        if let Measure::Duration(duration) = &mut scene.measure {
            *duration = duration.min(5.0);
        }
        let bench = Bench::new(&scene).unwrap();
        for method in MethodName::ALL {
            let run = bench.run(method).unwrap();
            assert_eq!(run.faults(), 0, "{path:?} {method}");
            assert!(run.force.fidelity.is_some(), "{path:?} {method}");
        }
        eprintln!("{path:?}: {}", scene.title);
    }
    assert_eq!(scenes.len(), 10 + 13 + 9 + 6);
}

#[test]
fn the_paper_s_scenes_among_the_users_are_the_paper_s() {
    for (copy, name) in [
        ("s11a-fig2", "fig2"),
        ("s11b-experiment1", "experiment1"),
        ("s11c-experiment2", "experiment2"),
    ] {
        let original = crate::common::scene(name);
        let copy = crate::common::scene(&format!("users/{copy}"));
        assert_ne!(copy.title, original.title);
        let same = Scene {
            title: original.title.clone(),
            ..copy
        };
        assert_eq!(same, original, "{name}");
    }
}

#[test]
fn every_key_ends_up_in_the_scene() {
    let scene = ContactFile::parse("good", GOOD).unwrap().scene;
    assert_eq!(scene.title, "a block");
    assert_eq!(scene.contact.object_mass, Mass::Finite(0.1));
    assert_eq!(scene.contact.stiffness, 400.0);
    assert_eq!((scene.object.position, scene.object.velocity), (0.05, 0.0));
    assert_eq!(
        (scene.virtual_force, scene.device.hand_force()),
        (-0.981, 1.0)
    );
    assert_eq!(
        (scene.device.mass(), scene.device.encoder_quantum()),
        (0.25, 0.0)
    );
    assert_eq!((scene.loop_params.period, scene.delay), (0.02, Delay::NONE));
    assert_eq!(scene.loop_params.force_limit, Some(10.0));
    assert_eq!(scene.loop_params.slew_limit, Some(1000.0));
    assert_eq!(scene.loop_params.speed_limit, Some(10.0));
    assert_eq!(scene.measure, Measure::Collisions(3));
    assert_eq!(scene.method, MethodName::Hfcr);
    assert_eq!(scene.settings.len(), 3);
    assert_eq!(
        scene.settings[&MethodName::Hfcr].get(SettingKey::DAMPING),
        Some(ParameterValue::Number(0.1))
    );
    let edit = |from, to| {
        ContactFile::parse("edited", &edited(from, to))
            .unwrap()
            .scene
    };
    assert_eq!(
        edit("collisions = 3", "duration_s = 1.5").measure,
        Measure::Duration(1.5)
    );
    assert_eq!(
        edit("normal = [-1.0, 0.0, 0.0]", "normal = [1.0, 0.0, 0.0]")
            .contact
            .side,
        Side::Negative
    );
    assert!(
        edit("unilateral = false", "unilateral = true")
            .contact
            .unilateral
    );
    assert_eq!(
        edit(MOVING, "fixed = true\n").contact.object_mass,
        Mass::Infinite
    );
    assert_eq!(
        edit("delay_samples = 0", "delay_samples = 1024")
            .delay
            .whole_samples(),
        1024
    );
    let timing = edit(
        "delay_samples = 0",
        "delay_samples = 1\ndelay_fraction = 0.5\njitter_s = 0.002\njitter_deviation_s = 0.001\n\
         dropped_samples = [4, 9]\ncollapse = { from_s = 0.1, until_s = 0.2, period_s = 0.04 }\n\
         seed = 3",
    );
    let delay = Delay::Periods {
        samples: 1,
        fraction: 0.5,
    };
    assert_eq!(timing.delay, delay);
    assert_eq!(
        timing.timing,
        Timing {
            jitter: Jitter::Normal {
                deviation: 0.001,
                bound: 0.002
            },
            dropped: Dropped::Listed(vec![4, 9]),
            collapse: Some(RateCollapse {
                from: 0.1,
                until: 0.2,
                period: 0.04
            }),
            seed: 3,
            ..Timing::default()
        }
    );
    let timing = edit(
        "delay_samples = 0",
        "jitter_s = 0.002\ndrop_probability = 0.1",
    )
    .timing;
    assert_eq!(timing.jitter, Jitter::Uniform { bound: 0.002 });
    assert_eq!(timing.dropped, Dropped::Probability(0.1));
    assert!(scene.timing.is_perfect() && !timing.is_perfect());
    let gap = edit("speed_limit_m_per_s = 10", "largest_gap_s = 0.5").loop_params;
    assert_eq!(gap.largest_gap, Some(0.5));
    let auto = edit("damping_n_s_per_m = 0.1", "damping_n_s_per_m = \"auto\"");
    assert_eq!(
        auto.settings[&MethodName::Hfcr].get(SettingKey::DAMPING),
        Some(ParameterValue::ToBeDerived)
    );
}

#[test]
fn what_is_left_out_takes_its_documented_default() {
    let start = GOOD.find("[methods.hfcr]").unwrap();
    let mut text = GOOD[..start].to_owned();
    for line in [
        "delay_samples = 0\n",
        "method = \"hfcr\"\n",
        "force_limit_n = 10\n",
    ] {
        text = text.replace(line, "");
    }
    let scene = ContactFile::parse("s", &text).unwrap().scene;
    assert_eq!(
        (scene.delay, scene.method),
        (Delay::NONE, MethodName::Coupled)
    );
    assert_eq!(scene.loop_params.force_limit, None);
    // K T = 8 N s/m; the object rests out of contact and stores nothing.
    let reference = palpate_core::PopcRefParams::new(24.0);
    let popc = palpate_core::PopcParams {
        damping_cap: 24.0,
        speed_threshold: 1e-4,
        initial_energy: 0.0,
    };
    for (method, expected) in [
        (MethodName::Basic, AnyParams::Basic),
        (
            MethodName::Seh,
            AnyParams::Seh(palpate_core::SehParams::default()),
        ),
        (
            MethodName::VirtualDamper,
            AnyParams::VirtualDamper(palpate_core::VirtualDamperParams::new(4.0)),
        ),
        (MethodName::Popc, AnyParams::Popc(popc)),
        (MethodName::PopcRef, AnyParams::PopcRef(reference)),
        (
            MethodName::HfcrMod,
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
        ),
        (
            MethodName::HfcrModSt,
            AnyParams::Hfcr(HfcrParams::default()),
        ),
        (MethodName::Hfcr, AnyParams::Hfcr(HfcrParams::default())),
    ] {
        assert_eq!(scene.params(method).unwrap(), expected, "{method}");
    }
    // Pressed by 1 mm at the start: K p^2/2 may be given out, and M v^2/2.
    let text = text.replace(
        "position_m = [0.05, 0.0, 0.0]\nvelocity_m_per_s = [0.0, 0.0, 0.0]",
        "position_m = [-0.001, 0.0, 0.0]\nvelocity_m_per_s = [2.0, 0.0, 0.0]",
    );
    let scene = ContactFile::parse("s", &text).unwrap().scene;
    let AnyParams::Popc(popc) = scene.params(MethodName::Popc).unwrap() else {
        panic!("a passivity controller")
    };
    assert!((popc.initial_energy - (2e-4 + 0.2)).abs() < 1e-15);
}

#[test]
fn columns_count_characters_and_lines_count_comments() {
    let text = format!(
        "# \u{b5}\u{b5}\n{}",
        edited("title", "\"\u{e9}\u{e9}\" = 1\ntitle")
    );
    let error = ContactFile::parse("s", &text).unwrap_err();
    assert_eq!((error.first().line, error.first().column), (3, 1));
    let text = edited("mass_kg = 0.1\n", "\"mass_kg\" = 0 # \u{b5}g\n");
    let error = ContactFile::parse("s", &text).unwrap_err();
    assert_eq!((error.first().line, error.first().column), (22, 13));
    let text = edited("[[body]]", "[[body]] # \u{b5}")
        .replace("[render]\n", "[render]\nq = \"\u{b5}\"; z\n");
    let error = ContactFile::parse("s", &text).unwrap_err();
    assert_eq!(
        (error.first().line, error.first().column),
        (33, 8),
        "{error}"
    );
}

#[test]
fn a_window_the_ideal_cannot_fill_says_how_many_collisions_there_are() {
    // The hand pulls the device away: one collision and no other.
    let text = edited("force_n = [1.0, 0.0, 0.0]", "force_n = [-8.0, 0.0, 0.0]")
        .replace(
            "velocity_m_per_s = [0.0, 0.0, 0.0]\nquantum_m",
            "velocity_m_per_s = [2.0, 0.0, 0.0]\nquantum_m",
        )
        .replace("force_n = [-0.981, 0.0, 0.0]", "force_n = [0.0, 0.0, 0.0]");
    let scene = ContactFile::parse("s", &text).unwrap().scene;
    let error = Bench::new(&scene).unwrap_err();
    assert_eq!(error, LoopError::TooFewCollisions { asked: 3, found: 1 });
    assert_eq!(
        error.to_string(),
        "the window requires 3 collisions, but the ideal has only 1; give a duration instead"
    );
    // Falling apart from the start: none.
    let text = edited("force_n = [1.0, 0.0, 0.0]", "force_n = [-9.0, 0.0, 0.0]");
    let scene = ContactFile::parse("s", &text).unwrap().scene;
    let error = Bench::new(&scene).unwrap_err();
    assert_eq!(error, LoopError::TooFewCollisions { asked: 3, found: 0 });
}

#[test]
fn a_window_that_is_too_long_is_refused_and_a_duration_covers_whole_periods() {
    let bench_of = |to: &str| {
        let scene = ContactFile::parse("s", &edited("collisions = 3", to))
            .unwrap()
            .scene;
        Bench::new(&scene).map(|bench| bench.reference().profile.intervals())
    };
    assert_eq!(
        bench_of("duration_s = 1e9").unwrap_err(),
        LoopError::TooLong(5e10)
    );
    assert_eq!(
        bench_of("duration_s = 1e9").unwrap_err().to_string(),
        "the window has 50000000000 periods; at most 2000000 fit"
    );
    for (duration, intervals) in [("0.06", 3), ("0.0601", 4), ("0.001", 1), ("0.7", 35)] {
        assert_eq!(bench_of(&format!("duration_s = {duration}")), Ok(intervals));
    }
}

/// A key of its mass, spring or damper makes a hand a grip, even as 0; its spring rests where the device starts.
#[test]
fn a_hand_has_a_grip_if_a_key_of_it_is_given() {
    let grip = |keys: &str| {
        let text = edited("force_n = [1.0, 0.0, 0.0]", keys);
        let text = text.replace(
            "position_m = [0.0, 0.0, 0.0]",
            "position_m = [-0.01, 0.0, 0.0]",
        );
        let scene = ContactFile::parse("s", &text).unwrap().scene;
        scene.device.grip().cloned()
    };
    assert_eq!(grip("force_n = [1.0, 0.0, 0.0]"), None);
    let spring = grip("stiffness_n_per_m = 0").unwrap();
    assert_eq!(spring.intention, Intention::at(-0.01));
    let rest = grip("rest_m = [0.02, 0.0, 0.0]").unwrap();
    assert_eq!(rest.intention, Intention::at(0.02));
}

#[test]
fn a_method_by_name_suggests_the_nearest() {
    let error = method_named("virtual_damper").unwrap_err();
    assert_eq!(
        error,
        UnknownMethod {
            name: "virtual_damper".into()
        }
    );
    assert_eq!(
        error.to_string(),
        "no method is called \"virtual_damper\"; did you mean \"virtual-damper\"?"
    );
    for method in MethodName::ALL {
        assert_eq!(method_named(method.name()), Ok(method));
        assert_eq!(method.to_string(), method.name());
    }
}

#[test]
fn a_scene_made_in_code_is_checked_before_it_runs() {
    let mut scene = ContactFile::parse("good", GOOD).unwrap().scene;
    *scene.device.encoder_quantum_mut() = -1.0;
    let error = Bench::new(&scene).unwrap_err();
    let LoopError::Setup(palpate_scene::SetupError::Parameter(ParameterError {
        parameter,
        value,
        ..
    })) = error
    else {
        panic!("{error}");
    };
    assert_eq!(parameter, Parameter::EncoderQuantum.into());
    assert_eq!(value, -1.0);
}
