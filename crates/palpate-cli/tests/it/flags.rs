//! The flags of contact, loop, method and device: the same on every command.

use crate::common::{
    Answer, Folder, METHODS, experiment_text, number, of_method, parse, taps, trace_text,
};

/// Each flag, an invalid value, and its message.
const WRONG: [(&str, &str, &str); 71] = [
    ("--stiffness", "0", "0 N/m"),
    ("--stiffness", "-400", "-400 N/m"),
    ("--stiffness", "nan", "NaN N/m"),
    ("--stiffness", "inf", "inf N/m"),
    ("--stiffness", "stiff", "a number is needed"),
    ("--mass", "0", "0 kg"),
    ("--mass", "-0.1", "-0.1 kg"),
    ("--mass", "-inf", "-inf kg"),
    ("--mass", "nan", "NaN kg"),
    ("--mass", "infinite-ish", "a number is needed"),
    ("--period", "0", "0 s"),
    ("--period", "-0.01", "-0.01 s"),
    ("--period", "nan", "NaN s"),
    ("--period", "inf", "inf s"),
    ("--period", "10ms", "a number is needed"),
    ("--force", "nan", "NaN N"),
    ("--force", "inf", "inf N"),
    ("--force", "-inf", "-inf N"),
    ("--object-position", "nan", "NaN m"),
    ("--object-position", "inf", "inf m"),
    ("--object-velocity", "nan", "NaN m/s"),
    ("--object-velocity", "-inf", "-inf m/s"),
    ("--side", "left", "positive and negative"),
    ("--delay-periods", "-1", "0 to 1024"),
    ("--delay-periods", "1024.5", "0 to 1024"),
    ("--delay-periods", "nan", "0 to 1024"),
    ("--delay", "-1", "-1 s"),
    ("--delay", "nan", "NaN s"),
    ("--delay-deviation", "-0.1", "-0.1 s"),
    ("--lag", "-0.001", "-0.001 s"),
    ("--lag", "inf", "inf s"),
    ("--lag-deviation", "nan", "NaN s"),
    ("--gain", "0", "is 0, but must be"),
    ("--gain", "much", "a number is needed"),
    ("--gain-deviation", "-1", "is -1, but must be"),
    ("--resonance", "0", "0 Hz"),
    ("--resonance", "inf", "inf Hz"),
    ("--resonance-damping-ratio", "1.5", "must be from 0 to 1"),
    ("--flexible-mass-fraction", "1", "must be from 0 to below 1"),
    ("--flexible-mass-fraction", "nan", "is NaN, but must be"),
    ("--force-limit", "0", "inf for no limit"),
    ("--force-limit", "nan", "inf for no limit"),
    ("--slew-limit", "-1", "-1 N/s"),
    ("--slew-limit", "inf", "inf N/s"),
    ("--speed-limit", "0", "0 m/s"),
    ("--speed-limit", "nan", "NaN m/s"),
    ("--largest-gap", "0.001", "at least one period"),
    ("--largest-gap", "nan", "at least one period"),
    ("--method", "hfrc", "did you mean \"hfcr\"?"),
    ("--method", "spring", "the methods are basic, seh,"),
    ("--method", "hfcr,hfcr", "named twice"),
    ("--damping", "-1", "-1 N s/m"),
    ("--damping", "nan", "NaN N s/m"),
    ("--damping", "inf", "inf N s/m"),
    ("--damping", "some", "\"auto\""),
    ("--damping-cap", "0", "0 N s/m"),
    ("--damping-cap", "inf", "inf N s/m"),
    ("--speed-threshold", "-1", "-1 m/s"),
    ("--speed-threshold", "nan", "NaN m/s"),
    ("--initial-energy", "-1", "-1 J"),
    ("--initial-energy", "inf", "inf J"),
    ("--estimate", "ab4", "ab2, differences and ab3"),
    (
        "--prediction",
        "spline",
        "last-step, first-order-adaptive-window, extrapolation and observer",
    ),
    (
        "--damper-object",
        "both",
        "spring-and-damper, spring and held-force",
    ),
    ("--entry-hold", "end", "crossing, sample and midpoint"),
    ("--longest-window", "0", "0 s"),
    ("--longest-window", "inf", "inf s"),
    ("--device-mass", "0", "0 kg"),
    ("--device-mass", "inf", "inf kg"),
    ("--encoder-quantum", "-1e-6", "-0.000001 m"),
    ("--encoder-quantum", "nan", "NaN m"),
];

/// Returns commands that take the flags; `flags` override their own.
fn commands(flags: &[(&str, &str)]) -> [String; 3] {
    let mut own = vec![
        ("--stiffness", "400"),
        ("--mass", "0.1"),
        ("--period", "0.01"),
    ];
    own.retain(|(name, _)| flags.iter().all(|(given, _)| given != name));
    let text = |flags: &[(&str, &str)]| -> String {
        flags
            .iter()
            .map(|(name, value)| format!(" {name} {value}"))
            .collect()
    };
    let (given, own) = (text(flags), text(&own));
    [
        format!("render tap.csv{own}{given}"),
        format!("simulate scene.toml{given}"),
        format!("pipe{own}{given}"),
    ]
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("tap.csv", trace_text(&taps(0.01, 1.5)));
    folder.write("scene.toml", experiment_text("fig2"));
    folder
}

/// Returns a method that can use `flag`.
fn method_for(flag: &str) -> Option<&'static str> {
    match flag {
        "--damping-cap" | "--speed-threshold" | "--initial-energy" => Some("popc"),
        "--estimate" => Some("seh"),
        "--damping" | "--prediction" | "--entry-hold" | "--longest-window" => Some("hfcr"),
        "--damper-object" => Some("virtual-damper"),
        _ => None,
    }
}

#[test]
fn a_wrong_value_is_named_with_its_flag_and_what_is_allowed_on_every_command() {
    let folder = folder();
    for (flag, value, said) in WRONG {
        let mut flags = vec![(flag, value)];
        flags.extend(method_for(flag).map(|method| ("--method", method)));
        if flag == "--longest-window" {
            flags.push(("--prediction", "first-order-adaptive-window"));
        }
        for command in commands(&flags) {
            folder.fail(
                &command,
                2,
                &[flag, said, "For more information, try '--help'."],
            );
            let answer = folder.palpate(&command);
            let allowed = ["must be", "needed", "are", "did you mean", "twice"];
            assert!(
                allowed.iter().any(|word| answer.stderr.contains(word)),
                "{answer:?}"
            );
        }
    }
}

#[test]
fn a_flag_without_its_value_is_an_error() {
    let folder = folder();
    for flag in [
        "--stiffness",
        "--mass",
        "--delay",
        "--method",
        "--damping",
        "--encoder-quantum",
    ] {
        for command in commands(&[(flag, "")]) {
            folder.fail(&command, 2, &[flag, "value is required"]);
        }
    }
}

#[test]
fn a_setting_is_refused_by_every_method_that_cannot_use_it() {
    let settings: [(&str, &str, &[&str]); 15] = [
        (
            "--damping",
            "0.5",
            &["virtual-damper", "energy-tank", "virtual-coupling", "hfcr"],
        ),
        ("--damping-cap", "2", &["popc", "popc-ref", "energy-tank"]),
        ("--speed-threshold", "0.001", &["popc", "popc-ref"]),
        ("--initial-energy", "0.1", &["popc", "energy-tank"]),
        ("--desired-energy", "0.1", &["energy-tank"]),
        ("--assumed-damping", "0.1", &["force-bounding"]),
        ("--midpoint-device", "extrapolated", &["pmi"]),
        ("--coupling-stiffness", "100", &["virtual-coupling"]),
        ("--coupling-mass", "0.1", &["virtual-coupling"]),
        ("--estimate", "ab3", &["seh"]),
        ("--prediction", "observer", &["virtual-damper", "hfcr"]),
        ("--damper-object", "spring", &["virtual-damper"]),
        ("--entry-hold", "sample", &["hfcr-mod-st", "hfcr"]),
        ("--no-placement", "", &["coupled"]),
        ("--no-correction", "", &["coupled"]),
    ];
    let folder = folder();
    for (flag, value, users) in settings {
        for method in METHODS {
            let flags = [
                ("--method", method),
                ("--device-mass", "0.2"),
                (flag, value),
            ];
            for command in commands(&flags) {
                let answer = folder.palpate(&command);
                if users.contains(&method) {
                    assert_eq!(answer.code, 0, "{command}: {answer:?}");
                } else {
                    let users = format!("it is for {}", users.join(", "));
                    let words = [flag, "cannot be used", method, &users];
                    answer.failed(&command, 2, &words);
                }
            }
        }
    }
}

#[test]
fn a_longest_window_needs_a_prediction_that_has_one() {
    let folder = folder();
    for method in ["virtual-damper", "hfcr"] {
        let flags = [
            ("--method", method),
            ("--longest-window", "0.05"),
            ("--device-mass", "0.2"),
        ];
        for (prediction, code) in [
            ("last-step", 2),
            ("extrapolation", 2),
            ("observer", 2),
            ("first-order-adaptive-window", 0),
        ] {
            let mut flags = flags.to_vec();
            flags.push(("--prediction", prediction));
            for command in commands(&flags) {
                let answer = folder.palpate(&command);
                assert_eq!(answer.code, code, "{command}: {answer:?}");
                if code == 2 {
                    let words = [
                        "--longest-window",
                        "first-order-adaptive-window",
                        method,
                        prediction,
                    ];
                    answer.failed(&command, 2, &words);
                }
            }
        }
        for command in commands(&flags) {
            folder.fail(&command, 2, &["--longest-window", "is last-step"]);
        }
    }
}

#[test]
fn a_prediction_at_constant_velocity_is_the_last_step_as_it_was_called_before() {
    let folder = folder();
    let answers = ["constant-velocity", "last-step", "extrapolation"].map(|prediction| {
        let command = format!("simulate scene.toml --method hfcr --json --prediction {prediction}");
        folder.palpate(&command).stdout
    });
    assert_eq!(answers[0], answers[1]);
    assert_ne!(answers[1], answers[2]);
    assert!(
        answers[0].contains("\"prediction\": \"last-step\""),
        "{}",
        answers[0]
    );
}

#[test]
fn facts_about_the_device_are_taken_by_every_method() {
    let folder = folder();
    for method in METHODS {
        let facts = [
            ("--method", method),
            ("--device-mass", "0.2"),
            ("--encoder-quantum", "1e-6"),
        ];
        for command in commands(&facts) {
            let answer = folder.palpate(&command);
            assert_eq!(answer.code, 0, "{command}: {answer:?}");
        }
    }
}

#[test]
fn guard_flags_have_ranges_and_belong_together() {
    let folder = Folder::new();
    folder.write("scene.toml", experiment_text("fig2"));
    for (flags, words) in [
        (
            "--guard limit --guard-acceleration 0",
            "--guard-acceleration is 0 m/s^2, but must be finite and greater than 0",
        ),
        (
            "--guard limit --guard-acceleration 80 --guard-mass 0",
            "--guard-mass is 0 kg, but must be finite and greater than 0",
        ),
        (
            "--guard limit --guard-recovery -1",
            "--guard-recovery is -1 W, but must be finite and not below 0",
        ),
        (
            "--guard limit --guard-hand-force 0",
            "--guard-hand-force is 0 N, but must be finite and greater than 0",
        ),
        (
            "--guard limit --guard-hand-force 8 --guard-acceleration 80",
            "cannot be used with",
        ),
        (
            "--guard limit --guard-mass 0.1",
            "--guard-acceleration <m/s^2>|--guard-hand-force <N>",
        ),
        (
            "--guard limit --guard-learn-mass",
            "--guard-acceleration <m/s^2>|--guard-hand-force <N>",
        ),
        ("--guard-recovery 0", "--guard <MODE>"),
    ] {
        folder.fail(&format!("simulate scene.toml {flags}"), 2, &[words]);
    }
}

#[test]
fn a_setting_that_means_two_things_needs_one_method() {
    let folder = folder();
    let both = [("--method", "virtual-damper,hfcr"), ("--damping", "1")];
    for command in &commands(&both)[..2] {
        folder.fail(
            command,
            2,
            &[
                "--damping has two meanings: for virtual-damper damping B of the contact",
                "for hfcr damping b of the leak dissipation",
            ],
        );
    }
    for command in &commands(&[("--method", "all"), ("--damping-cap", "1")])[..2] {
        folder.fail(
            command,
            2,
            &["--damping-cap cannot be used by method basic"],
        );
    }
}

#[test]
fn derived_damping_needs_hfcr_and_a_device_mass() {
    let folder = folder();
    let [render, simulate, pipe] = commands(&[("--method", "hfcr"), ("--damping", "auto")]);
    for command in [render, pipe] {
        folder.fail(&command, 2, &["--damping auto needs --device-mass <kg>"]);
    }
    assert_eq!(folder.palpate(&simulate).code, 0, "a scene has a device");
    let flags = [("--damping", "auto"), ("--device-mass", "0.2")];
    for command in commands(&[flags[0], flags[1], ("--method", "hfcr")]) {
        assert_eq!(folder.palpate(&command).code, 0, "{command}");
    }
    let flags = [flags[0], flags[1], ("--method", "virtual-damper")];
    for command in commands(&flags) {
        folder.fail(
            &command,
            2,
            &["--damping auto", "give virtual-damper a number"],
        );
    }
}

#[test]
fn negative_and_infinite_numbers_stand_as_arguments_of_their_own() {
    let folder = folder();
    for flags in [
        [("--force", "-0.981"), ("--object-position", "-1e-1")],
        [("--force", "-1e-1"), ("--object-velocity", "-.5")],
        [("--force", "+1"), ("--object-position", "-0")],
        [("--mass", "inf"), ("--object-position", "-0.001")],
    ] {
        for command in commands(&[flags[0], flags[1], ("--device-mass", "0.2")]) {
            // A window of that many collisions may be too short for another scene.
            let Answer { code, stderr, .. } = folder.palpate(&command);
            assert!(
                code == 0 || stderr.contains("window"),
                "{command}: {stderr}"
            );
        }
    }
    let report = folder.json(&commands(&[("--mass", "inf")])[0]);
    assert_eq!(report["object_mass_kg"], "inf");
    assert_eq!(number(&report, "object_kappa"), 0.0);
}

#[test]
fn every_flag_of_a_recording_changes_its_run() {
    let folder = folder();
    // A weight brings the object back to the device repeatedly.
    let run = |flags: &[(&str, &str)]| {
        let mut flags = flags.to_vec();
        if flags.iter().all(|(flag, _)| *flag != "--force") {
            flags.push(("--force", "-0.981"));
        }
        let answer = folder.palpate(&format!("{} --json", commands(&flags)[0]));
        assert_eq!(answer.code, 0, "{answer:?}");
        // From the other side, the device starts inside the object.
        let is_inside = flags.contains(&("--side", "negative"));
        assert_eq!(answer.stderr.contains("the device starts"), is_inside);
        parse(&answer.stdout)
    };
    let cases: [(&str, &str, &str); 20] = [
        ("--stiffness", "500", "hfcr"),
        ("--mass", "0.2", "hfcr"),
        ("--period", "0.02", "hfcr"),
        ("--force", "-0.5", "hfcr"),
        ("--object-position", "0.001", "hfcr"),
        ("--object-velocity", "-0.1", "hfcr"),
        ("--side", "negative", "hfcr"),
        ("--delay", "0.01", "hfcr"),
        ("--force-limit", "0.5", "hfcr"),
        ("--slew-limit", "20", "hfcr"),
        ("--damping", "0.3", "virtual-damper"),
        ("--damping-cap", "0.3", "popc-ref"),
        ("--speed-threshold", "0.5", "popc-ref"),
        ("--initial-energy", "0.01", "popc"),
        ("--estimate", "ab3", "seh"),
        ("--desired-energy", "0.01", "energy-tank"),
        ("--assumed-damping", "0.1", "force-bounding"),
        ("--midpoint-device", "extrapolated", "pmi"),
        ("--coupling-stiffness", "300", "virtual-coupling"),
        ("--coupling-mass", "0.2", "virtual-coupling"),
    ];
    for (flag, value, method) in cases {
        let plain = run(&[("--method", method)]);
        let changed = run(&[("--method", method), (flag, value)]);
        let leak = |report| number(of_method(report, method), "leak_held_j");
        assert_ne!(leak(&plain), leak(&changed), "{flag} {value}");
    }
    let stopped = run(&[("--speed-limit", "0.05")]);
    assert!(of_method(&stopped, "coupled")["faults"].as_u64() > Some(0));
}

#[test]
fn an_infinite_force_limit_takes_that_of_a_scene_away() {
    let folder = folder();
    let scene = experiment_text("wall");
    assert!(scene.contains("[render]\n"));
    let limit = "[render]\nforce_limit_n = 0.5\n";
    folder.write("limited.toml", scene.replace("[render]\n", limit));
    folder.write("scene.toml", scene);
    let leak = |arguments: &str| {
        let report = folder.json(&format!("simulate {arguments}"));
        number(of_method(&report, "hfcr-mod-st"), "leak_held_j")
    };
    let free = leak("scene.toml");
    assert_eq!(leak("limited.toml --force-limit inf"), free);
    assert_ne!(leak("limited.toml"), free);
}

#[test]
fn a_force_that_would_pull_is_held_back_where_asked() {
    let folder = folder();
    let flags = [
        ("--method", "hfcr"),
        ("--damping", "3"),
        ("--force", "-0.981"),
    ];
    let command = &commands(&flags)[0];
    let pull = |report| number(of_method(&report, "hfcr"), "strongest_pull_n");
    assert!(pull(folder.json(command)) > 0.1);
    assert_eq!(pull(folder.json(&format!("{command} --unilateral"))), 0.0);
}
