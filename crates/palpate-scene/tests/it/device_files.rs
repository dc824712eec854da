//! Device files: the committed ones, every fault with its place, and what scenes make of them.
#![allow(clippy::print_stdout)] // what was measured

use std::path::{Path, PathBuf};

use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, HandForceAt, Linkage, Scene, beside};
use palpate_study::sim::closed_loop::Bench;

/// A good file with every key there is.
const GOOD: &str = r#"device_format = 1
title = "a small pantograph"
gravity_m_per_s2 = [0, 0]

[geometry]
proximal_m = 0.12
distal_m = 0.16
base_m = 0.05
assembly = "far"
origin = "centre"

[home]
angles_deg = [130, 50]

[proximal]
mass_kg = 0.06
centre = 0.45
inertia_kg_m2 = [7e-5, 8e-5]

[distal]
mass_kg = [0.05, 0.04]
centre = [0.5, 0.6]
inertia_kg_m2 = 1e-4

[end_point]
mass_kg = 0.15

[motors]
rotor_inertia_kg_m2 = 3e-5
torque_limit_n_m = 1
counts_per_rev = 20000
actuation = "measured-pose"

[friction]
coulomb_n_m = 1e-3
viscous_n_m_s_per_rad = 5e-4

[hold_x]
proportional_n_per_m = 100
integral_n_per_m_s = 50
derivative_n_s_per_m = 3
limit_n = 5

[safety_box]
x_m = [-0.03, 0.04]
y_m = [-0.05, 0.06]
"#;

/// A scene with a linkage; `DEVICE` is replaced by its keys.
const SCENE: &str = r#"format = 2
title = "a block"

[loop]
period_s = 0.01

[measure]
duration_s = 0.5

[[device]]
name = "device"
axes = ["y"]
DEVICE

[device.hand]
force_n = [0.0, 1.0, 0.0]

[[body]]
name = "object"
axes = ["y"]
mass_kg = 0.1
position_m = [0.0, 0.02, 0.0]
force_n = [0.0, -0.981, 0.0]
shape = { half_space = { normal = [0.0, -1.0, 0.0] } }

[[contact]]
between = ["device", "object"]
stiffness_n_per_m = 400
"#;

fn devices() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../devices")
}

#[track_caller]
fn edited(from: &str, to: &str) -> String {
    assert_eq!(GOOD.matches(from).count(), 1, "{from} must stand once");
    GOOD.replacen(from, to, 1)
}

/// A scene whose device has `keys`, in a folder with `small.toml`.
fn scene(keys: &str, device: &str) -> Result<Scene, String> {
    let folder = std::env::temp_dir().join(format!(
        "palpate-device-files-{}-{:?}",
        std::process::id(),
        std::thread::current().id()
    ));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("small.toml"), device).unwrap();
    let path = folder.join("scene.toml");
    let text = SCENE.replace("DEVICE", keys);
    let read = ContactFile::parse_with(&path.display().to_string(), &text, &mut beside(&path));
    std::fs::remove_dir_all(&folder).unwrap();
    let shown = folder.display().to_string();
    read.map(|file| file.scene)
        .map_err(|error| error.to_string().replace(&shown, "FOLDER"))
}

#[test]
fn the_committed_devices_are_good_and_are_the_presets() {
    let mut files = 0;
    for entry in std::fs::read_dir(devices()).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let name = path.file_name().unwrap().to_str().unwrap();
        let device = Linkage::parse(name, &text).unwrap_or_else(|error| panic!("{error}"));
        let preset = Linkage::presets().find(|preset| name.ends_with(&format!("{preset}.toml")));
        let preset = preset.unwrap_or_else(|| panic!("{name} is no preset"));
        assert_eq!(Linkage::preset(preset), Some(device), "{name}");
        files += 1;
    }
    assert_eq!(files, Linkage::presets().count());
    assert_eq!(Linkage::preset("paper"), None);
}

#[test]
fn the_paper_like_device_has_the_published_mass_where_the_experiments_need_it() {
    let device = Linkage::preset("paper-like").unwrap();
    let mass = |offset: f64| device.effective_mass(offset).unwrap();
    assert!((mass(0.0) - 0.25).abs() < 1e-4, "{}", mass(0.0));
    let spread = |from: f64, to: f64| {
        (0..=100)
            .map(|i| mass(from + (to - from) * f64::from(i) / 100.0) / mass(0.0) - 1.0)
            .fold((0.0_f64, 0.0_f64), |(least, most), x| {
                (least.min(x), most.max(x))
            })
    };
    let (least, most) = spread(-0.4, 0.2);
    println!("from -0.4 to 0.2 m: {least:+.4} to {most:+.4} of the mass at home");
    assert!(least > -0.02 && most < 0.02, "{least} {most}");
    // Range of the ideal of both experiments.
    for name in ["fig4", "fig5"] {
        let scene = crate::common::scene(name);
        let bench = Bench::new(&scene).unwrap();
        let reach = bench.reference().curve.iter().map(|p| p.device_position);
        let (low, high) = reach.fold((0.0_f64, 0.0_f64), |(l, h), y| (l.min(y), h.max(y)));
        let (least, most) = spread(low, high);
        println!("{name}: ideal from {low:.3} to {high:.3} m, mass {least:+.5} to {most:+.5}");
        assert!(high - low > 0.01 && least > -3e-3 && most < 3e-3);
        // Half a metre further down, and a quarter up, the links still move.
        let box_y = device.safety_box.unwrap().y;
        assert!(box_y[0] <= low - 0.45 && box_y[1] >= high + 0.2);
        assert!(device.effective_mass(box_y[0]).unwrap() < 0.3);
        assert!(device.effective_mass(box_y[1]).unwrap() < 0.3);
    }
}

#[test]
fn a_good_file_says_what_its_links_are() {
    let device = Linkage::parse("small.toml", GOOD).unwrap();
    let [first, second] = device.params.distal;
    assert_eq!((first.mass, second.mass), (0.05, 0.04));
    assert_eq!((first.centre, second.centre), (0.5, 0.6));
    assert_eq!((first.inertia, second.inertia), (1e-4, 1e-4));
    assert_eq!(device.params.proximal[1].inertia, 8e-5);
    assert_eq!(device.hold_x.unwrap().max_force, 5.0);
    assert_eq!(device.safety_box.unwrap().x, [-0.03, 0.04]);
    // A silent file has uniform rods, exact encoders, endless torque, and neither friction,
    // controller nor box.
    let short = edited("centre = 0.45\ninertia_kg_m2 = [7e-5, 8e-5]\n", "")
        .replace("torque_limit_n_m = 1\n", "")
        .replace("counts_per_rev = 20000\n", "");
    let end = short.find("[friction]").unwrap();
    let device = Linkage::parse("short.toml", &short[..end]).unwrap();
    let rod = device.params.proximal[0];
    assert_eq!(rod.centre, 0.5);
    assert!((rod.inertia - 0.06 * 0.12 * 0.12 / 12.0).abs() < 1e-18);
    assert_eq!(device.params.max_torque, f64::INFINITY);
    assert_eq!(device.params.counts_per_rev, None);
    assert_eq!(
        (
            device.params.coulomb_friction,
            device.params.viscous_friction
        ),
        (0.0, 0.0)
    );
    assert_eq!((device.hold_x, device.safety_box), (None, None));
}

#[test]
fn every_fault_of_a_device_file_has_its_place_and_says_what_is_allowed() {
    // The edit; the message with its line and column; what is marked.
    let table = r#"device_format = 1\n -> device_format = 2\nauthor = 1\n
  1:17: device_format is 2, but this version reads 1 only
  2
device_format = 1\n -> 
  1:1: the key device_format is missing
  
base_m = 0.05\n -> 
  5:1: the key base_m is missing
  [geometry]
[home]\nangles_deg = [130, 50]\n -> 
  1:1: the key home is missing
  
distal_m -> dstal_m
  7:1: unknown key dstal_m, did you mean distal_m? Known here: proximal_m, distal_m, base_m, assembly, origin
  dstal_m
[motors] -> [motor]
  28:2: unknown key motor, did you mean motors? Known here: device_format, title, geometry, home, proximal, distal, end_point, motors, friction, gravity_m_per_s2, hold_x, safety_box
  motor
proximal_m = 0.12 -> proximal_m = "long"
  6:14: invalid type: string "long", expected a number
  "long"
proximal_m = 0.12 -> proximal_m = 0
  6:14: proximal_m is 0, but must be finite and above 0 m
  0
base_m = 0.05 -> base_m = -0.05
  8:10: base_m is -0.05, but must be finite and at least 0 m
  -0.05
assembly = "far" -> assembly = "left"
  9:12: unknown variant `left`, expected `far` or `near`
  "left"
angles_deg = [130, 50] -> angles_deg = [130, 50, 10]
  13:14: invalid length 3, expected a list of two numbers
  [130, 50, 10]
angles_deg = [130, 50] -> angles_deg = [130, nan]
  13:14: angles_deg must be finite [rad]
  [130, nan]
base_m = 0.05 -> base_m = 0.5
  13:14: angles_deg must be motor angles [rad] of a pose that is in reach and not singular
  [130, 50]
mass_kg = 0.06 -> mass_kg = -1
  16:11: mass_kg is -1, but must be finite and at least 0 kg
  -1
mass_kg = [0.05, 0.04] -> mass_kg = [0.05, nan]
  21:11: mass_kg is NaN, but must be finite and at least 0 kg
  [0.05, nan]
mass_kg = [0.05, 0.04] -> mass_kg = [0.05]
  21:11: invalid length 1, expected a number, or a list of two, one for each arm
  [0.05]
centre = 0.45 -> centre = inf
  17:10: centre is inf, but must be finite, a fraction of the length
  inf
inertia_kg_m2 = 1e-4 -> inertia_kg_m2 = -1e-4
  23:17: inertia_kg_m2 is -0.0001, but must be finite and at least 0 kg m²
  -1e-4
mass_kg = 0.15 -> mass_kg = nan
  26:11: mass_kg is NaN, but must be finite and at least 0 kg
  nan
rotor_inertia_kg_m2 = 3e-5 -> rotor_inertia_kg_m2 = -1
  29:23: rotor_inertia_kg_m2 is -1, but must be finite and at least 0 kg m²
  -1
torque_limit_n_m = 1 -> torque_limit_n_m = 0
  30:20: torque_limit_n_m is 0, but must be above 0 N m; infinite for no limit
  0
counts_per_rev = 20000 -> counts_per_rev = -1
  31:18: counts_per_rev is -1, but must be finite and above 0
  -1
actuation = "measured-pose" -> actuation = "perfect"
  32:13: unknown variant `perfect`, expected one of `ideal`, `true-pose`, `measured-pose`
  "perfect"
coulomb_n_m = 1e-3 -> coulomb_n_m = -1e-3
  35:15: coulomb_n_m is -0.001, but must be finite and at least 0 N m
  -1e-3
viscous_n_m_s_per_rad = 5e-4 -> viscous_n_m_s_per_rad = inf
  36:25: viscous_n_m_s_per_rad is inf, but must be finite and at least 0 N m s/rad
  inf
gravity_m_per_s2 = [0, 0] -> gravity_m_per_s2 = [0, nan]
  3:20: gravity_m_per_s2 is NaN, but must be finite [m/s²]
  [0, nan]
derivative_n_s_per_m = 3 -> derivative_n_s_per_m = nan
  41:24: derivative_n_s_per_m is NaN, but must be finite [N s/m]
  nan
limit_n = 5 -> limit_n = 0
  42:11: limit_n is 0, but must be finite and above 0 N
  0
x_m = [-0.03, 0.04] -> x_m = [0.03, 0.04]
  45:7: x_m is [0.03, 0.04], but must be one bound below 0 and one above: bounds are relative to home, which is inside
  [0.03, 0.04]
y_m = [-0.05, 0.06] -> y_m = [-0.05, nan]
  46:7: y_m is [-0.05, NaN], but must be one bound below 0 and one above: bounds are relative to home, which is inside
  [-0.05, nan]"#;
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 3 * 30);
    for row in lines.chunks(3) {
        let (from, to) = row[0].split_once(" -> ").unwrap();
        let text = edited(&from.replace("\\n", "\n"), &to.replace("\\n", "\n"));
        let Err(error) = Linkage::parse("small.toml", &text) else {
            panic!("{} is accepted", row[0]);
        };
        let expected = format!("small.toml:{}", row[1].trim());
        assert_eq!(error.to_string(), expected, "{}", row[0]);
        assert_eq!(&text[error.span.clone()], row[2].trim(), "{}", row[0]);
        assert_eq!(error.source_text, text);
    }
}

#[test]
fn links_without_inertia_need_a_rotor() {
    let text = edited("rotor_inertia_kg_m2 = 3e-5", "rotor_inertia_kg_m2 = 0")
        .replace("inertia_kg_m2 = [7e-5, 8e-5]", "inertia_kg_m2 = [7e-5, 0]");
    assert_eq!(
        Linkage::parse("small.toml", &text).unwrap_err().to_string(),
        "small.toml:29:23: rotor_inertia_kg_m2 together with the inertia of the proximal link is 0, \
         but must be above 0 kg m² for each motor"
    );
}

#[test]
fn a_scene_finds_its_device_file_beside_itself() {
    let from_file = scene("linkage.file = \"small.toml\"", GOOD).unwrap();
    let device = &from_file.device.pantograph().unwrap().linkage;
    assert_eq!(*device, Linkage::parse("small.toml", GOOD).unwrap());
    assert_eq!(
        device.effective_mass(0.0).unwrap().to_bits(),
        from_file.device.mass().to_bits()
    );
    // The same numbers as the preset, read from the preset's own file.
    let haply = std::fs::read_to_string(devices().join("haply-2diy-gen3.toml")).unwrap();
    let copied = scene("linkage.file = \"small.toml\"", &haply).unwrap();
    let preset = scene("linkage.preset = \"2diy-gen3\"", "").unwrap();
    assert_eq!(copied, preset);
}

#[test]
fn a_device_file_that_is_missing_or_bad_is_named() {
    let error = |keys: &str, device: &str| scene(keys, device).unwrap_err();
    let missing = error("linkage.file = \"other.toml\"", GOOD);
    assert!(
        missing.starts_with(
            "FOLDER/scene.toml:13:16: the device file FOLDER/other.toml cannot be read: No such file"
        ),
        "{missing}"
    );
    assert_eq!(
        error(
            "linkage.file = \"small.toml\"",
            &edited("base_m = 0.05", "base_m = -1")
        ),
        "FOLDER/small.toml:8:10: base_m is -1, but must be finite and at least 0 m"
    );
    assert_eq!(
        error(
            "linkage.preset = \"paper-like\"\nlinkage.file = \"small.toml\"",
            GOOD
        ),
        "FOLDER/scene.toml:14:16: a linkage has a preset or a file, not both"
    );
    assert_eq!(
        error(
            "linkage.file = \"small.toml\"\nposition_m = [0.0, 0.5, 0.0]",
            GOOD
        ),
        "FOLDER/scene.toml:14:14: device position = 0.5 is not allowed; allowed: within the linkage's reach"
    );
    assert_eq!(
        error(
            "linkage.file = \"small.toml\"\nposition_m = [0.0, -0.055, 0.0]",
            GOOD
        ),
        "FOLDER/scene.toml:14:14: device.position_m is -0.055 m, but must be inside the safety box of the device"
    );
    assert_eq!(
        error(
            "linkage.file = \"small.toml\"\nsafety_box = { y_m = [-0.1, -0.05] }",
            GOOD
        ),
        "FOLDER/scene.toml:14:22: y_m is [-0.1, -0.05], but must be one bound below 0 and one above: \
         bounds are relative to home, which is inside"
    );
    let text = SCENE.replace("DEVICE", "linkage.file = \"small.toml\"");
    assert_eq!(
        ContactFile::parse("scene.toml", &text)
            .unwrap_err()
            .to_string(),
        "scene.toml:13:16: the device file small.toml cannot be read: this scene is read without \
         other files"
    );
}

#[test]
fn a_scene_on_a_preset_is_written_with_its_box_and_one_on_a_file_is_not() {
    for keys in [
        "linkage.preset = \"2diy-gen1\"",
        "linkage.preset = \"paper-like\"\nposition_m = [0.0, 0.001, 0.0]",
        "linkage.preset = \"paper-like\"\nsafety_box = { y_m = [-0.05, 0.006] }",
        "linkage.preset = \"2diy-gen3\"\nsafety_box = { x_m = [-0.1, 0.01], y_m = [-0.05, inf] }",
    ] {
        let read = scene(keys, "").unwrap();
        let written = read.to_toml().unwrap();
        let again = ContactFile::parse("written", &written).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.scene, read, "{written}");
        let mut in_motors = read;
        in_motors.device.pantograph_mut().unwrap().force_at = HandForceAt::Motors;
        let written = in_motors.to_toml().unwrap();
        let again = ContactFile::parse("written", &written).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.scene, in_motors, "{written}");
    }
    let own = scene("linkage.file = \"small.toml\"", GOOD).unwrap();
    assert_eq!(
        own.to_toml().unwrap_err().to_string(),
        "a scene file cannot contain the values of a separate device file"
    );
}

#[test]
fn leaving_the_safety_box_ends_the_forces_and_is_reported() {
    // A wide box is left by neither; in the scene's own narrow one both end.
    let wide = scene("linkage.preset = \"paper-like\"", "").unwrap();
    let bench = Bench::new(&wide).unwrap();
    assert_eq!(bench.reference().leaves_box_at, None);
    let free = bench.run(MethodName::Basic).unwrap();
    assert_eq!(free.left_box_at, None);

    let narrow = "linkage.preset = \"paper-like\"\nsafety_box = { y_m = [-0.05, 0.006] }";
    let narrow = scene(narrow, "").unwrap();
    let bench = Bench::new(&narrow).unwrap();
    // The ideal has no box; it is the same, and tells where it would have left it.
    let leaves = bench.reference().leaves_box_at.unwrap();
    let reference = Bench::new(&wide).unwrap().reference().profile.clone();
    assert_eq!(bench.reference().profile, reference);
    let run = bench.run(MethodName::Basic).unwrap();
    let left = run.left_box_at.unwrap();
    // Seen at the first sample after.
    assert!((0.0..0.01).contains(&(left - leaves)), "{left} {leaves}");
    let mut inside = 0;
    for (tick, free) in run.ticks.iter().zip(&free.ticks) {
        if tick.time < left {
            assert_eq!(tick.held_force_on_object, free.held_force_on_object);
            inside += 1;
        } else {
            assert_eq!(tick.held_force_on_object, 0.0, "{}", tick.time);
        }
    }
    assert!(inside > 5 && run.ticks[inside].device_position > 0.006);
    // Motion of the device without motors does not count as divergence of the loop.
    assert_eq!(run.diverged, Some(false));
    let end = &run.last().true_device_position;
    assert!(*end > 0.05, "the hand pushes on: {end}");
}
