//! Joints in scene files, and their error messages.
#![allow(missing_docs)]

use palpate_scene::world::WorldFile;
use palpate_world::{Joint, JointKind, JointLaw};

const DRAWER: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "drawer"
mass_kg = 0.1
position_m = [0.1, 0.0, 0.0]
shape = { box = { size_m = [0.04, 0.04, 0.02] } }
[[body]]
name = "lid"
mass_kg = 0.05
position_m = [0.1, 0.0, 0.02]
shape = { box = { size_m = [0.04, 0.04, 0.01] } }
[[joint]]
kind = "slider"
between = ["drawer", "world"]
axis = [2.0, 0.0, 0.0]
stiffness_n_per_m = 2e4
span_m = 0.05
limits_m = [0.0, 0.03]
[[joint]]
kind = "hinge"
between = ["lid", "drawer"]
point_m = [0.12, 0.0, 0.01]
axis = [0.0, 1.0, 0.0]
stiffness_n_per_m = 1e4
damping_n_s_per_m = 5.0
span_m = 0.03
spring_n_m_per_rad = 0.1
rest_rad = 0.2
along_damping_n_m_s_per_rad = 1e-3
limits_rad = [-0.1, 1.5]
"#;

#[test]
fn joints_are_read() {
    let joints = WorldFile::parse("drawer.toml", DRAWER)
        .unwrap()
        .scene
        .world
        .joints;
    let slider = Joint {
        body: "drawer".into(),
        against: None,
        kind: JointKind::Slider,
        // That of the body.
        point: [0.1, 0.0, 0.0],
        axis: [1.0, 0.0, 0.0],
        law: JointLaw {
            limits: Some([0.0, 0.03]),
            ..JointLaw::new(2e4, 0.05)
        },
    };
    let hinge = Joint {
        body: "lid".into(),
        against: Some("drawer".into()),
        kind: JointKind::Hinge,
        point: [0.12, 0.0, 0.01],
        axis: [0.0, 1.0, 0.0],
        law: JointLaw {
            damping: 5.0,
            spring: 0.1,
            rest: 0.2,
            along_damping: 1e-3,
            limits: Some([-0.1, 1.5]),
            ..JointLaw::new(1e4, 0.03)
        },
    };
    assert_eq!(joints, [slider, hinge]);
}

#[test]
fn faults_of_joints_have_their_place_and_say_what_is_allowed() {
    for (right, wrong, message) in [
        (
            "[\"drawer\", \"world\"]",
            "[\"drawr\", \"world\"]",
            ":21:11: joint of \"drawr\" and \"world\": \"drawr\" is not a body of this world",
        ),
        (
            "[\"drawer\", \"world\"]",
            "[\"tool\", \"world\"]",
            "\"tool\" is not a body of this world",
        ),
        (
            "[\"drawer\", \"world\"]",
            "[\"world\", \"drawer\"]",
            "the first name must be a moving body; \"world\" may be the second",
        ),
        (
            "[\"lid\", \"drawer\"]",
            "[\"lid\", \"lid\"]",
            "a body has no joint with itself",
        ),
        (
            "name = \"drawer\"\nmass_kg = 0.1",
            "name = \"drawer\"\nfixed = true",
            "one of the two has to be a body that moves",
        ),
        (
            "limits_m = [0.0, 0.03]",
            "limits_rad = [0.0, 0.03]",
            "a slider has limits_m, not limits_rad",
        ),
        (
            "spring_n_m_per_rad = 0.1",
            "spring_n_per_m = 0.1",
            "a hinge has spring_n_m_per_rad, not spring_n_per_m",
        ),
        (
            "[0.0, 0.03]",
            "[0.04, 0.03]",
            ":25:12: joint of \"drawer\" and \"world\": limits are 0.04 and 0.03; the lower limit has to come first",
        ),
        (
            "[-0.1, 1.5]",
            "[-0.1, 3.5]",
            "those of a hinge have to be between -3 and 3 rad",
        ),
        (
            "span_m = 0.05",
            "span_m = 0.0",
            "span is 0, and has to be above 0",
        ),
        (
            "axis = [2.0, 0.0, 0.0]",
            "axis = [0.0, 0.0, 0.0]",
            "axis has length 0, so it has no direction; give a finite length above 0",
        ),
        (
            "kind = \"slider\"",
            "kind = \"screw\"",
            "unknown variant `screw`, expected `hinge` or `slider`",
        ),
        ("span_m = 0.05\n", "", "the key span_m is missing"),
        (
            "name = \"lid\"",
            "name = \"world\"",
            "\"world\" is the fixed world, but a body has that name",
        ),
    ] {
        let errors =
            WorldFile::parse("drawer.toml", &DRAWER.replacen(right, wrong, 1)).unwrap_err();
        let said: Vec<_> = errors.iter().map(ToString::to_string).collect();
        assert!(
            said.iter().any(|said| said.contains(message)),
            "{wrong}: {said:?}"
        );
    }
}
