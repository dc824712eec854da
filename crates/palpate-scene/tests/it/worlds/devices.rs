//! Devices of a scene file: axes, torques and masses.

use palpate_scene::world::WorldFile;

use super::{BALL, said};

#[test]
fn a_device_says_which_axes_it_has() {
    let in_a_plane = |of: &str| {
        BALL.replace("mass_kg = [0.25, 0.3, 0.35]", of)
            .replace("hand.force_n = [0.0, 0.0, -1.0]\nquantum_m = 2e-6\n", "")
    };
    let scene = WorldFile::parse(
        "ball.toml",
        &in_a_plane("axes = [\"x\", \"z\"]\nmass_kg = [0.25, 0.35]\nquantum_m = [1e-6, 2e-6]"),
    );
    let scene = scene.unwrap().scene;
    assert_eq!(scene.world.tools[0].axes, [true, false, true]);
    assert_eq!(scene.world.tools[0].names_of_axes(), "x and z");
    let device = &scene.devices[0];
    assert_eq!(device.mass, [0.25, f64::INFINITY, 0.35]);
    assert_eq!(device.quantum, [1e-6, 0.0, 2e-6]);
    assert_eq!(scene.render.device_mass, [[0.375, f64::INFINITY, 0.375]]);
    // One number is that of all axes that there are.
    let scene = WorldFile::parse("ball.toml", &in_a_plane("axes = [\"y\"]\nmass_kg = 0.2"));
    let scene = scene.unwrap().scene;
    assert_eq!(scene.devices[0].mass, [f64::INFINITY, 0.2, f64::INFINITY]);
    // All axes are what a device has that names none.
    let named = in_a_plane("axes = [\"x\", \"y\", \"z\"]\nmass_kg = [0.25, 0.3, 0.35]");
    let named = WorldFile::parse("ball.toml", &named).unwrap().scene;
    assert_eq!(
        named,
        WorldFile::parse("ball.toml", &in_a_plane("mass_kg = [0.25, 0.3, 0.35]"))
            .unwrap()
            .scene
    );
}

#[test]
fn a_device_may_have_axes_of_its_own() {
    let with = |of: &str| {
        let source = BALL
            .replace("mass_kg = [0.25, 0.3, 0.35]", of)
            .replace("hand.force_n = [0.0, 0.0, -1.0]\nquantum_m = 2e-6\n", "");
        WorldFile::parse("ball.toml", &source).unwrap().scene
    };
    let scene = with(
        "axes = [[3.0, 4.0, 0.0], [-8, 6, 0], [0, 0, 1e-3]]\nmass_kg = [0.25, 0.3, 0.35]\nquantum_m = [1e-6, 2e-6, 3e-6]",
    );
    let own = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(scene.world.tools[0].own_axes, Some(own));
    assert_eq!(scene.devices[0].own_axes, Some(own));
    assert_eq!(scene.devices[0].mass, [0.25, 0.3, 0.35]);
    assert_eq!(scene.devices[0].quantum, [1e-6, 2e-6, 3e-6]);
    assert_eq!(scene.world.tools[0].axes, [true; 3]);
    // What lies in a plane, with decimals that are rounded.
    let plane = "axes = [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]\nmass_kg = [0.2, 0.3]\nvelocity_m_per_s = [0.3, 0.4, 1.0]";
    let scene = with(plane);
    assert_eq!(scene.world.tools[0].axes, [true, true, false]);
    assert_eq!(scene.devices[0].mass, [0.2, 0.3, f64::INFINITY]);
    assert_eq!(
        scene.world.tools[0].names_of_axes(),
        "the first and the second of its own axes"
    );
    let third = scene.devices[0].own_axes.unwrap()[2];
    let along = |vector: [f64; 3]| third.iter().zip(vector).map(|(a, b)| a * b).sum::<f64>();
    assert!(along([0.6, 0.8, 0.0]).abs() < 1e-15 && (along(third) - 1.0).abs() < 1e-15);
    // One axis is a slide.
    let scene = with("axes = [[1.0, 1.0, 1.0]]\nmass_kg = 0.2");
    assert_eq!(scene.devices[0].mass[1..], [f64::INFINITY; 2]);
    let said = said(&BALL.replace(
        "mass_kg = [0.25, 0.3, 0.35]",
        "axes = [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]\nmass_kg = 0.2\nvelocity_m_per_s = [0.4, -0.3, 1.0]",
    ));
    assert_eq!(
        said,
        [
            "ball.toml:11:20: velocity_m_per_s has a component of 0.5 along an axis that is not in the `axes` of the \
             device: its mechanism blocks that axis; give components along its axes only"
        ]
    );
}

/// Of a device of the loop that lacks an axis of the world, that has to be one of the own axes.
#[test]
fn own_axes_on_a_device_that_lacks_an_axis_of_the_world() {
    let with = |of: &str| {
        let source = BALL.replace("mass_kg = [0.25, 0.3, 0.35]", of);
        WorldFile::parse("ball.toml", &source).unwrap().scene
    };
    let along_z = with(
        "axes = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]\nmass_kg = [0.1, 0.2, 0.3]",
    );
    let model = along_z.with_axes(0, [true, true, false]);
    assert_eq!(model.world.tools[0].axes, [true, true, false]);
    assert_eq!(model.devices[0].mass, [0.1, 0.2, f64::INFINITY]);
    assert!(model.renderer("coupled").is_ok());
    let oblique = with("axes = [[2, 2, 1], [-2, 1, 2], [1, -2, 2]]\nmass_kg = [0.1, 0.2, 0.3]");
    assert!(oblique.renderer("coupled").is_ok());
    let model = oblique.with_axes(0, [true, true, false]);
    let faults = model.renderer("coupled").unwrap_err();
    assert!(
        faults
            .first()
            .to_string()
            .contains("has none of its own axes"),
        "{}",
        faults.first()
    );
}

#[test]
fn axes_that_contradict_the_rest_are_refused() {
    let with = |of: &str| said(&BALL.replace("mass_kg = [0.25, 0.3, 0.35]", of));
    let expected = "expected one to three of \"x\", \"y\" and \"z\", in this order, such as [\"x\", \"y\"], or one to three \
                    directions at right angles, such as [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0]]";
    for (given, what) in [
        ("[]", "no axis"),
        ("[\"z\", \"x\"]", "[\"z\", \"x\"]"),
        ("[\"x\", \"x\"]", "[\"x\", \"x\"]"),
        ("[\"x\", \"up\"]", "[\"x\", \"up\"]"),
        ("[[1.0, 0.0, 0.0], \"y\"]", "names and directions"),
        (
            "[[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]]",
            "4 directions",
        ),
        ("[[0.0, 0.0, 0.0]]", "[0.0, 0.0, 0.0] has no direction"),
        ("[[nan, 0.0, 0.0]]", "[NaN, 0.0, 0.0] has no direction"),
        (
            "[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]",
            "[1.0, 1.0, 0.0] is at 45.0000 degrees to another axis",
        ),
    ] {
        let said = with(&format!("axes = {given}\nmass_kg = 0.2"));
        assert_eq!(said, [format!("ball.toml:9:8: {what}, {expected}")]);
    }
    assert_eq!(
        with("axes = [\"x\", \"z\"]\nmass_kg = [0.25, 0.3, 0.35]"),
        [
            "ball.toml:10:11: mass_kg has 3 numbers, and the device has 2 axes; give one number for all axes, or 2 numbers in the \
             order x, y, z"
        ]
    );
    assert_eq!(
        with("mass_kg = [0.25, 0.3, inf]"),
        [
            "ball.toml:9:11: mass_kg is inf: list the axes of the device in `axes`, such as axes = [\"x\", \"y\"], \
             and give masses along these only"
        ]
    );
    let moved = with("axes = [\"x\", \"y\"]\nmass_kg = 0.2\nvelocity_m_per_s = [0.1, 0.0, -0.1]");
    let why = "along z, but the `axes` of the device are x and y only: its mechanism blocks z; write 0 there";
    assert_eq!(
        moved,
        [
            format!("ball.toml:11:20: velocity_m_per_s is -0.1 {why}"),
            format!("ball.toml:13:16: hand.force_n is -1 {why}"),
        ]
    );
}

/// A stylus: its device measures six axes and pushes along three.
#[test]
fn a_device_says_whether_it_gives_a_torque() {
    let with = |keys: &str| BALL.replacen("mass_kg", &format!("{keys}\nmass_kg"), 1);
    let scene = |keys: &str| WorldFile::parse("ball.toml", &with(keys)).unwrap().scene;
    let inertia = "inertia_kg_m2 = [1e-4, 1e-4, 2e-5]";
    for (given, gives_torque) in [
        ("", true),
        ("\ngives_torque = true", true),
        ("\ngives_torque = false", false),
    ] {
        let scene = scene(&format!("{inertia}{given}"));
        let tool = &scene.world.tools[0];
        assert!(tool.turns);
        assert_eq!(tool.feels_torque(), gives_torque, "{given}");
        assert_eq!(scene.devices[0].turning.unwrap().gives_torque, gives_torque);
    }
    for given in ["false", "true"] {
        assert_eq!(
            said(&with(&format!("gives_torque = {given}"))),
            [
                "ball.toml:9:16: gives_torque needs a device of six axes, with inertia_kg_m2 (three moments)"
            ]
        );
    }
    let wrong = said(&with(&format!("{inertia}\ngives_torque = 0")));
    assert!(
        wrong[0].starts_with("ball.toml:10:16") && wrong[0].contains("boolean"),
        "{wrong:?}"
    );

    // A virtual coupling needs no rotational keys for a torque-free device; a god-object does not turn a tool.
    let coupling = "method = \"virtual-coupling\"\n[methods.virtual-damper]\ndamping_n_s_per_m = 2.0\n\
                    [methods.virtual-coupling]\ncoupling_stiffness_n_per_m = 1000.0\ncoupling_mass_kg = 0.1\n\
                    damping_n_s_per_m = 2.0\n\
                    [methods.god-object]\ncoupling_stiffness_n_per_m = 1000.0\ndamping_n_s_per_m = 2.0";
    let stylus = with(&format!("{inertia}\ngives_torque = false"));
    let coupled = stylus.replace("method = \"coupled\"", coupling);
    let coupled = WorldFile::parse("ball.toml", &coupled).unwrap().scene;
    for method in ["basic", "virtual-damper", "virtual-coupling", "coupled"] {
        let made = coupled.renderer(method);
        assert!(made.is_ok(), "{method}: {made:?}");
    }
    let refused = coupled.renderer("god-object").unwrap_err();
    assert!(refused.first().to_string().contains("turns"), "{refused:?}");
    let felt = with(inertia).replace("method = \"coupled\"", coupling);
    let felt = WorldFile::parse("ball.toml", &felt).unwrap().scene;
    assert!(felt.renderer("virtual-coupling").is_err());
}

#[test]
fn the_mass_of_a_device_may_change_with_its_place() {
    let with = |of: &str| {
        BALL.replace("mass_kg = [0.25, 0.3, 0.35]", of)
            .replace("hand.force_n = [0.0, 0.0, -1.0]\nquantum_m = 2e-6\n", "")
            .replace("device_mass_kg = 0.375\n", "")
    };
    let table = "axes = [\"x\", \"z\"]\n\
                 mass_table = { places_m = [[-0.1, 0.1], [0.0]], mass_kg = [[0.2, 0.3, 0.05], [0.3, 0.3, 0.05]] }";
    let scene = WorldFile::parse("ball.toml", &with(table)).unwrap().scene;
    let (tool, device) = (&scene.world.tools[0], &scene.devices[0]);
    assert_eq!(tool.axes, [true, false, true]);
    assert_eq!(tool.own_axes, device.own_axes);
    // In the middle of the table: 0.25, 0.3 and 0.05 kg.
    assert_eq!(device.position[0], 0.0);
    let [one, lacking, other] = device.mass;
    assert!(lacking.is_infinite());
    assert!((one + other - 0.55).abs() < 1e-12);
    assert!((one * other - (0.25 * 0.3 - 0.05 * 0.05)).abs() < 1e-12);
    assert_eq!(scene.render.device_mass, [device.mass]);
    for (of, says) in [
        ("", "a device needs mass_kg, mass_table or linkage"),
        (
            &format!("{table}\nmass_kg = 0.3")[..],
            "a device has either mass_kg or mass_table",
        ),
        (
            "mass_table = { places_m = [[0.1, 0.0], [0.0], [0.0]], mass_kg = [] }",
            "mass_table: the places along axis 1 are [0.1, 0.0]",
        ),
        (
            "mass_table = { places_m = [[0.0], [0.0], [0.0]], mass_kg = [[1.0, 1.0, 1.0]] }",
            "matrix 1 has 3 numbers; a device of 3 axes has 6",
        ),
        ("mass_table = { places_m = [[0.0]] }", "mass_kg"),
    ] {
        let refused = WorldFile::parse("ball.toml", &with(of)).unwrap_err();
        assert!(refused.to_string().contains(says), "{of}: {refused}");
    }
    let line = with(table).replacen("[loop]", "[loop]\nhold = \"line\"", 1);
    let refused = WorldFile::parse("ball.toml", &line).unwrap_err();
    let says = "device.mass_table excludes lines in a world";
    assert!(refused.to_string().contains(says), "{refused}");
}
