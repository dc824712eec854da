//! A scene with several errors reports all of them at once, each at its position.

use palpate_scene::{HandForceAt, SceneFile};

use super::{GOOD, edited};

/// Returns the error lines of the valid file with these edits.
fn said(edits: &[(&str, &str)]) -> Vec<String> {
    let text = edits.iter().fold(GOOD.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    });
    let errors = SceneFile::parse("scene.toml", &text).unwrap_err();
    for error in &errors {
        assert_eq!(
            (error.file.as_str(), &error.source_text),
            ("scene.toml", &text)
        );
        let line = text.lines().nth(error.line - 1).unwrap_or_default();
        let marked = &text[error.span.clone()];
        let marked = marked.lines().next().unwrap_or_default();
        let after: String = line.chars().skip(error.column - 1).collect();
        assert!(after.starts_with(marked), "{error}: {marked}");
    }
    errors.iter().map(ToString::to_string).collect()
}

#[test]
fn key_combination_and_range_errors_are_reported_in_file_order() {
    assert_eq!(
        said(&[
            ("stiffness_n_per_m = 400", "stiffness_n_per_m = -400"),
            ("mass_kg = 0.25", "mass_kg = 0.25\npreset = \"paper-like\""),
            ("period_s = 0.02", "period_s = 0.02\nperod_s = 1"),
        ]),
        [
            "scene.toml:6:21: object.stiffness_n_per_m is -400 N/m, but must be finite and greater \
             than 0",
            "scene.toml:15:10: only a device of kind pantograph has a preset or a file",
            "scene.toml:26:1: unknown key perod_s, did you mean period_s? Known here: period_s, \
             delay_samples, delay_fraction, delay_s, command_jitter_s, lag_s, gain, jitter_s, \
             jitter_deviation_s, drop_probability, dropped_samples, collapse, seed",
        ]
    );
}

#[test]
fn range_errors_of_device_contact_loop_and_method_are_reported_together() {
    assert_eq!(
        said(&[
            ("mass_kg = 0.25", "mass_kg = 0"),
            ("period_s = 0.02", "period_s = -0.02"),
            ("force_limit_n = 10", "force_limit_n = 0"),
            ("damping_n_s_per_m = 0.1", "damping_n_s_per_m = -0.1"),
        ]),
        [
            "scene.toml:14:11: device.mass_kg is 0 kg, but must be finite and greater than 0",
            "scene.toml:24:12: loop.period_s is -0.02 s, but must be finite and greater than 0",
            "scene.toml:33:17: renderer.force_limit_n is 0 N, but must be finite and greater than 0",
            "scene.toml:38:21: damping_n_s_per_m is -0.1 N s/m, but must be finite and not below 0",
        ]
    );
}

/// A value that is derived from a wrong number, or contradicts the substitute of a faulty value, is not reported.
#[test]
fn a_fault_draws_no_others_after_it() {
    // K T/2 of the damper and 3 K T of the controllers would be negative.
    let stiffness = ("stiffness_n_per_m = 400", "stiffness_n_per_m = -400");
    assert_eq!(said(&[stiffness]).len(), 1);
    // Without its preset the device is not a pantograph, so the hand's force cannot act through its motors.
    let text = edited(
        "kind = \"point-mass\"\nmass_kg = 0.25",
        "kind = \"pantograph\"\npreset = \"x\"",
    );
    let errors = SceneFile::parse(
        "scene.toml",
        &text.replace("force_n = 1\n", "force_n = 1\nforce_at = \"motors\"\n"),
    );
    let said: Vec<_> = errors
        .unwrap_err()
        .into_iter()
        .map(|error| error.message)
        .collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("no preset is called \"x\""), "{said:?}");
}

#[test]
fn a_file_with_mistakes_of_device_hand_and_loop_shows_all_three() {
    // A constant force has no stiffness; a point mass has no motors at joints; one delay is enough.
    let text = edited(
        "kind = \"constant-force\"\nforce_n = 1",
        "tremor_n = 0.1\ntremor_hz = -8\nforce_at = \"motors\"",
    )
    .replace("delay_samples = 0", "delay_samples = 1\ndelay_s = 0.01");
    let errors = SceneFile::parse("scene.toml", &text).unwrap_err();
    let said: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "scene.toml:21:13: hand.tremor_hz is -8 Hz, but must be finite and greater than 0",
            "scene.toml:22:12: force_at = \"motors\" is for a device of kind pantograph, whose motors give torques",
            "scene.toml:27:11: either delay_s, or delay_samples with delay_fraction; not both",
        ]
    );
}

#[test]
fn a_pantograph_is_in_the_hand_of_a_constant_force() {
    let text = edited(
        "kind = \"point-mass\"\nmass_kg = 0.25\nposition_m = 0\nvelocity_m_per_s = 0\nencoder_quantum_m = 0",
        "kind = \"pantograph\"\npreset = \"paper-like\"",
    );
    let of = |hand: &str| text.replace("kind = \"constant-force\"\nforce_n = 1", hand);
    let scene = SceneFile::parse("scene.toml", &of("force_n = 1\nforce_at = \"motors\""));
    let device = scene.unwrap().scene.device;
    let device = device.pantograph().unwrap();
    assert_eq!((device.force, device.force_at), (1.0, HandForceAt::Motors));
    let hand = of("kind = \"impedance\"\ntremor_n = 0.1\ntremor_hz = 8\nrelease_s = 0.1");
    let errors = SceneFile::parse("scene.toml", &hand).unwrap_err();
    let said: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let only = |at: &str, what: &str| {
        format!(
            "scene.toml:{at}: the hand of a pantograph is a constant force; {what} is for a device of kind point-mass"
        )
    };
    assert_eq!(
        said,
        [
            only("17:8", "kind = \"impedance\""),
            only("18:12", "a tremor"),
            only("20:13", "release_s"),
        ]
    );
    // If the device itself is invalid, the valid properties of its hand are unknown.
    let errors = SceneFile::parse("scene.toml", &hand.replace("paper-like", "sigma")).unwrap_err();
    assert_eq!(errors.iter().count(), 1, "{errors}");
}
