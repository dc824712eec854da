//! A scene with several errors reports all of them at once, each at its position.

use palpate_scene::{ContactFile, HandForceAt};

use super::{GOOD, edited};

/// Returns the error lines of the valid file with these edits.
fn said(edits: &[(&str, &str)]) -> Vec<String> {
    let text = edits.iter().fold(GOOD.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text.replace(from, to)
    });
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
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
            (
                "mass_kg = 0.25",
                "mass_kg = 0.25\nsafety_box = { y_m = [-1, 1] }"
            ),
            ("period_s = 0.02", "period_s = 0.02\nperod_s = 1"),
        ]),
        [
            "scene.toml:6:1: unknown key perod_s, did you mean period_s? Known here: period_s, \
             delay_samples, delay_fraction, delay_s, command_jitter_s, lag_s, gain, hold, jitter_s, \
             jitter_deviation_s, drop_probability, dropped_samples, collapse, seed",
            "scene.toml:13:14: device.safety_box is for a device with a linkage",
            "scene.toml:32:21: contact.stiffness_n_per_m is -400 N/m, but must be finite and greater than 0",
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
            "scene.toml:5:12: loop.period_s is -0.02 s, but must be finite and greater than 0",
            "scene.toml:11:11: device.mass_kg is 0 kg, but must be finite and greater than 0",
            "scene.toml:35:17: render.force_limit_n is 0 N, but must be finite and greater than 0",
            "scene.toml:43:21: damping_n_s_per_m is -0.1 N s/m, but must be finite and not below 0",
        ]
    );
}

/// A value that is derived from a wrong number, or contradicts the substitute of a faulty value, is not reported.
#[test]
fn a_fault_draws_no_others_after_it() {
    // K T/2 of the damper and 3 K T of the controllers would be negative.
    let stiffness = ("stiffness_n_per_m = 400", "stiffness_n_per_m = -400");
    assert_eq!(said(&[stiffness]).len(), 1);
    // Without its preset, the hand's force cannot act through motors.
    let text = on_linkage("sigma", "force_at = \"motors\"");
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
    let said: Vec<_> = errors.into_iter().map(|error| error.message).collect();
    assert_eq!(
        said,
        [
            "no preset is called \"sigma\"; the presets are paper-like, 2diy-gen1, 2diy-gen2, 2diy-gen3"
        ]
    );
    let text = on_linkage("paper", "force_n = [0.0, 1.0, 0.0]");
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
    assert_eq!(
        errors.first().message,
        "no preset is called \"paper\"; did you mean \"paper-like\"?"
    );
}

/// Returns the valid file on a linkage along y, with a hand of these keys.
fn on_linkage(preset: &str, hand: &str) -> String {
    let text = edited(
        "mass_kg = 0.25\nposition_m = [0.0, 0.0, 0.0]\nvelocity_m_per_s = [0.0, 0.0, 0.0]\nquantum_m = 0",
        &format!("linkage = {{ preset = \"{preset}\" }}"),
    );
    text.replace("axes = [\"x\"]", "axes = [\"y\"]")
        .replace("force_n = [1.0, 0.0, 0.0]", hand)
        .replace("[0.05, 0.0, 0.0]", "[0.0, 0.05, 0.0]")
        .replace("[-0.981, 0.0, 0.0]", "[0.0, -0.981, 0.0]")
        .replace("[-1.0, 0.0, 0.0]", "[0.0, -1.0, 0.0]")
}

#[test]
fn a_file_with_mistakes_of_device_hand_and_loop_shows_all_three() {
    // A point mass has no motors at joints; one delay is enough.
    let text = edited(
        "force_n = [1.0, 0.0, 0.0]",
        "tremor_n = 0.1\ntremor_hz = -8\nforce_at = \"motors\"",
    )
    .replace("delay_samples = 0", "delay_samples = 1\ndelay_s = 0.01");
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
    let said: Vec<String> = errors.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "scene.toml:7:11: either delay_s, or delay_samples with delay_fraction; not both",
            "scene.toml:19:13: device.hand.tremor_hz is -8 Hz, but must be finite and greater than 0",
            "scene.toml:20:12: device.hand.force_at is for a device with a linkage",
        ]
    );
}

#[test]
fn a_pantograph_is_in_the_hand_of_a_constant_force() {
    let text = on_linkage(
        "paper-like",
        "force_n = [0.0, 1.0, 0.0]\nforce_at = \"motors\"",
    );
    let scene = ContactFile::parse("scene.toml", &text);
    let device = scene.unwrap().scene.device;
    let device = device.pantograph().unwrap();
    assert_eq!((device.force, device.force_at), (1.0, HandForceAt::Motors));
    let text = on_linkage(
        "paper-like",
        "stiffness_n_per_m = 1\ntremor_n = 0.1\ntremor_hz = 8\nrelease_s = 0.1",
    );
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
    let only = |key: &str| {
        format!("device.hand.{key} is for the hand of a point mass; that of a linkage only pushes")
    };
    let said: Vec<_> = errors.iter().map(|error| error.message.clone()).collect();
    assert_eq!(
        said,
        ["stiffness_n_per_m", "tremor_n", "tremor_hz", "release_s"].map(only)
    );
    let text = on_linkage("paper-like", "force_n = [0.0, 1.0, 0.0]");
    let text = text.replace(
        "linkage = ",
        "mass_kg = 0.2\ndrivetrain.backlash_m = 1e-5\nlinkage = ",
    );
    let errors = ContactFile::parse("scene.toml", &text).unwrap_err();
    let said: Vec<_> = errors.iter().map(|error| error.message.clone()).collect();
    assert_eq!(
        said,
        [
            "device.mass_kg is set by the linkage",
            "device.drivetrain.backlash_m is set by the linkage"
        ]
    );
}
