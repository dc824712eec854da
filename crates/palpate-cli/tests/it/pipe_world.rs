//! `palpate pipe` with a world: the positions of all devices in, a force on each of them out.

use crate::common::Folder;
use palpate_scene::world::WorldFile;
use palpate_world::{Sample, Vector};

const BALL: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "thumb"
mass_kg = 0.25
position_m = [0.0, 0.0, 0.08]
tool = { sphere = { radius_m = 0.01 } }
[[device]]
name = "finger"
mass_kg = 0.25
position_m = [0.1, 0.0, 0.08]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 0.1
position_m = [0.0, 0.0, 0.03]
force_n = [0.0, 0.0, -0.981]
shape = { sphere = { radius_m = 0.03 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 4000.0
[render]
method = "basic"
"#;

/// A thumb that presses the ball beside its top, and a finger that reaches the floor.
fn motion() -> Vec<[Vector; 2]> {
    let positions = (0..200).map(|tick| {
        let down = 1e-5 * f64::from(tick);
        [[0.002, 0.001, 0.0705 - down], [0.1, 0.0, 0.0115 - down]]
    });
    positions.collect()
}

fn lines(motion: &[[Vector; 2]]) -> String {
    let line = |[a, b]: &[Vector; 2]| {
        let numbers = [a, b].map(|p| p.map(|x| x.to_string()).join(","));
        numbers.join(",") + "\n"
    };
    motion.iter().map(line).collect()
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    folder
}

#[test]
fn a_line_of_all_positions_is_answered_by_the_forces_of_the_library() {
    let motion = motion();
    let answer = folder().palpate_reading(
        lines(&motion),
        "pipe ball.toml --force-limit inf --soft-start 0 --header",
    );
    assert_eq!(answer.code, 0, "{answer:?}");
    let scene = WorldFile::parse("ball.toml", BALL).unwrap().scene;
    let renderer = scene.renderer("basic").unwrap();
    let mut state = renderer.start();
    let mut expected =
        vec!["thumb.fx_n,thumb.fy_n,thumb.fz_n,finger.fx_n,finger.fy_n,finger.fz_n".to_owned()];
    let mut pressed = [false; 2];
    for positions in &motion {
        let forces = renderer.step(&mut state, &Sample::at(positions)).forces;
        pressed = [0, 1].map(|tool| pressed[tool] || forces[tool][2] > 0.1);
        let text: Vec<String> = forces
            .iter()
            .flatten()
            .map(|force| (force + 0.0).to_string())
            .collect();
        expected.push(text.join(","));
    }
    assert_eq!(pressed, [true; 2], "both tools touch something");
    // The last line sets the forces to 0.
    expected.push("0,0,0,0,0,0".into());
    assert_eq!(answer.stdout.lines().collect::<Vec<_>>(), expected);
}

#[test]
fn a_force_is_limited_and_comes_in_softly_without_being_asked() {
    let inside = "0,0,0.05,1,0,0.08\n".repeat(300);
    let answer = folder().palpate_reading(&inside, "pipe ball.toml");
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(
        answer.stderr.contains("forces are limited to 20 N"),
        "{answer:?}"
    );
    assert!(
        answer
            .stderr
            .contains("\"thumb\" and \"ball\" overlap by 0.0200 m at the start"),
        "{answer:?}"
    );
    let norms: Vec<f64> = answer
        .stdout
        .lines()
        .map(|line| {
            let force: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            force[..3].iter().map(|x| x * x).sum::<f64>().sqrt()
        })
        .collect();
    assert_eq!(norms[0], 0.0);
    assert!(norms.iter().all(|&norm| norm <= 20.0 + 1e-9), "{norms:?}");
    assert!(norms[..100].iter().all(|&norm| norm <= 10.0), "{norms:?}");
    assert!(norms.iter().any(|&norm| norm > 1.0), "{norms:?}");
}

/// A tool and a cylinder of triangles, which ends at z = 20 mm.
const CYLINDER: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
position_m = [0.0, 0.0, 0.0]
tool = { sphere = { radius_m = 0.004 } }
[[body]]
name = "part"
fixed = true
shape = { mesh = { revolved = { profile_m = [[0.0, -0.02], [0.02, -0.02], [0.02, 0.02], [0.0, 0.02]], segments = 12 } } }
[[contact]]
between = "*"
stiffness_n_per_m = 3000.0
"#;

#[test]
fn a_tool_that_begins_inside_a_mesh_is_said_to_have_no_force() {
    let folder = folder();
    folder.write("in_a_mesh.toml", CYLINDER);
    let answer = folder.palpate_reading("0,0,0\n0,0,0.001\n", "pipe in_a_mesh.toml");
    assert_eq!(answer.code, 0, "{answer:?}");
    assert_eq!(answer.stdout, "0,0,0\n0,0,0\n0,0,0\n");
    let said =
        "line 1: \"tool\" starts inside \"part\"; no contact force acts on it until it is outside";
    assert!(answer.stderr.contains(said), "{answer:?}");
}

#[test]
fn ignored_triangles_are_said() {
    let folder = folder();
    // 400 triangles meet at the centre of the top: more than the renderer can hold.
    let fan = CYLINDER.replace("segments = 12", "segments = 400").replace(
        "position_m = [0.0, 0.0, 0.0]",
        "position_m = [0.0, 0.0, 0.023]",
    );
    folder.write("fan.toml", fan);
    let answer = folder.palpate_reading(
        "0,0,0.023\n0.015,0,0.023\n0.015,0,0.023\n",
        "pipe fan.toml --json",
    );
    assert_eq!(answer.code, 0, "{answer:?}");
    let said = "line 1: more triangles or shell points are near than the renderer can hold; it ignores the furthest";
    assert!(answer.stderr.contains(said), "{answer:?}");
    let summary = answer.stderr.lines().last().unwrap();
    assert_eq!(crate::common::parse(summary)["crowded"], 2, "{answer:?}");
    let answer = folder.palpate("run fan.toml --fast --duration 0.1 --json");
    let report = crate::common::parse(&answer.stdout);
    let ticks = report["timing"]["crowded"].as_u64().unwrap();
    // The contact pushes the tool away.
    assert!((10..=100).contains(&ticks), "{answer:?}");
}

#[test]
fn a_line_that_cannot_be_read_takes_the_forces_off_and_the_next_one_is_answered() {
    let input = "0,0,0.069,1,0,0.08\nwhat\n0,0,0.069,1,0,0.08\nnan,0,0,0,0,0\n";
    let answer = folder().palpate_reading(input, "pipe ball.toml --soft-start 0");
    assert_eq!(answer.code, 0, "{answer:?}");
    let lines: Vec<_> = answer.stdout.lines().collect();
    assert_eq!(lines.len(), 5, "{answer:?}");
    // The tool overlaps the ball by 1 mm.
    assert!(lines[0].starts_with("0,0,3.9999"), "{answer:?}");
    assert_eq!(lines[1], "0,0,0,0,0,0");
    assert!(lines[2].starts_with("0,0,"), "{answer:?}");
    assert_ne!(lines[2], "0,0,0,0,0,0");
    assert_eq!(lines[3], "0,0,0,0,0,0");
    let said = &answer.stderr;
    assert!(said.contains("line 2: \"what\" is not a number"), "{said}");
    assert!(said.contains("line 4: thumb: "), "{said}");
    assert!(said.contains("4 samples, 2 refused"), "{said}");
}

/// Two balls that overlap by 5 mm at 10 kN/m, far from the tool, store 125 mJ that no work created.
#[test]
fn what_bodies_store_from_the_start_is_no_leak() {
    let folder = Folder::new();
    folder.write(
        "overlap.toml",
        r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
position_m = [0.0, 0.0, 0.05]
tool = { sphere = { radius_m = 0.005 } }
[[body]]
name = "one"
mass_kg = 0.1
position_m = [0.5, 0.0, 0.0]
shape = { sphere = { radius_m = 0.02 } }
[[body]]
name = "other"
mass_kg = 0.1
position_m = [0.535, 0.0, 0.0]
shape = { sphere = { radius_m = 0.02 } }
[[contact]]
between = "*"
stiffness_n_per_m = 10000.0
"#,
    );
    let answer = folder.palpate_reading("0,0,0.05\n".repeat(5), "pipe overlap.toml");
    assert_eq!(answer.code, 0, "{answer:?}");
    let said = answer.stderr.split("leak ").nth(1).unwrap();
    let leak: f64 = said.split(" mJ").next().unwrap().parse().unwrap();
    assert!(leak.abs() < 1.0, "{answer:?}");
}

/// A device that is held by 2 N while it leaves a floor by 2 mm gets 4 mJ in every second period: the pipe stops. A
/// device that is pressed through the force limit gets none.
#[test]
fn created_energy_stops_a_pipe_with_a_world_and_a_limited_force_does_not() {
    let folder = Folder::new();
    folder.write(
        "floor.toml",
        r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
position_m = [0.0, 0.0, 0.001]
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }
[[contact]]
between = "*"
stiffness_n_per_m = 1000.0
"#,
    );
    let pipe = "pipe floor.toml --unit m --soft-start 0 --method basic";
    let answer = folder.palpate_reading("0,0,-0.002\n0,0,0\n".repeat(50), pipe);
    assert_eq!(answer.code, 5, "{answer:?}");
    let pushed = answer.stdout.matches(",2\n").count();
    assert!((10..20).contains(&pushed), "{answer:?}");
    let words = "safety stop: held forces created more than 50.0 mJ";
    assert!(answer.stderr.contains(words), "{answer:?}");

    let pressed: String = (0..800)
        .map(|tick| 0.015 * (1.0 - (f64::from(tick) * std::f64::consts::TAU / 800.0).cos()))
        .map(|depth| format!("0,0,{}\n", 0.001 - depth))
        .collect();
    let answer = folder.palpate_reading(pressed, &format!("{pipe} --force-limit 5"));
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let said = answer.stderr.split("leak ").nth(1).unwrap();
    let leak: f64 = said.split(" mJ").next().unwrap().parse().unwrap();
    assert!(leak.abs() < 2.0, "{}", answer.stderr);
}

#[test]
fn lines_of_other_columns_and_motions_no_hand_makes_end_the_pipe() {
    let in_millimetres: String = (0..200)
        .map(|tick| format!("0,0,{},100,0,80\n", 80.0 - 0.05 * f64::from(tick)))
        .collect();
    for (input, why) in [
        ("0,0,0.08\n", "has 3 columns; expected `thumb.x_m,thumb.y_m"),
        (&in_millimetres, "pass --unit mm"),
        // Each hand would get the force of the other.
        (
            "finger.x_m,finger.y_m,finger.z_m,thumb.x_m,thumb.y_m,thumb.z_m\n0.1,0,0.08,0,0,0.08\n",
            "line 1: the header has the columns `finger.x_m",
        ),
    ] {
        let answer = folder().palpate_reading(input, "pipe ball.toml");
        assert_eq!(answer.code, 3, "{answer:?}");
        assert!(answer.stderr.contains(why), "{answer:?}");
    }
}

#[test]
fn flags_of_one_contact_and_methods_of_one_contact_are_refused() {
    let folder = folder();
    for (flags, why) in [
        ("--stiffness 5", "--stiffness: ball.toml is a world"),
        ("--delay-periods 1", "--delay-periods: ball.toml is a world"),
        ("--damping 3", "--damping: ball.toml is a world"),
        (
            "--method pmi",
            "--method: there is no method \"pmi\" for worlds. Known here: basic",
        ),
        (
            "--columns force,penetration",
            "--columns of a world: allowed is force",
        ),
    ] {
        let answer = folder.palpate_reading("", &format!("pipe ball.toml {flags}"));
        assert_eq!(answer.code, 2, "{answer:?}");
        assert!(answer.stderr.contains(why), "{answer:?}");
    }
    let wrong = BALL.replace("method = \"basic\"", "method = \"bassic\"");
    folder.write("wrong.toml", &wrong);
    let answer = folder.palpate_reading("", "pipe wrong.toml");
    assert_eq!(answer.code, 3, "{answer:?}");
    assert!(
        answer.stderr.contains("wrong.toml:29:10") && answer.stderr.contains("did you mean basic?"),
        "{answer:?}"
    );
}

#[test]
fn a_box_that_begins_in_another_body_is_said_once() {
    let folder = Folder::new();
    folder.write("box.toml", BOX);
    let answer = folder.palpate_reading("0,0,0.014,1,0,0,0\n", "pipe box.toml");
    let said = answer.stderr.matches("overlap by 0.001000 m at the start");
    assert_eq!(said.count(), 1, "{answer:?}");
}

const BOX: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.15
inertia_kg_m2 = [9.4e-5, 1.69e-4, 1.95e-4]
tool = { box = { size_m = [0.06, 0.04, 0.03] } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = "*"
stiffness_n_per_m = 4000.0
"#;

/// A box that is pressed with one edge, so that the table turns it back.
#[test]
fn a_device_of_six_axes_is_read_with_its_orientation_and_answered_with_a_torque() {
    let folder = Folder::new();
    folder.write("box.toml", BOX);
    let poses: Vec<(Vector, [f64; 4])> = (0..60)
        .map(|tick| {
            let half = 0.05_f64;
            let height = 0.0181 - 2e-5 * f64::from(tick);
            ([0.0, 0.0, height], [half.cos(), 0.0, half.sin(), 0.0])
        })
        .collect();
    let line = |(p, q): &(Vector, [f64; 4])| {
        let numbers: Vec<String> = p.iter().chain(q).map(ToString::to_string).collect();
        numbers.join(",") + "\n"
    };
    let lines: String = poses.iter().map(line).collect();
    let exact = "pipe box.toml --force-limit inf --soft-start 0 --header";
    let answer = folder.palpate_reading(&lines, exact);
    assert_eq!(answer.code, 0, "{answer:?}");
    let scene = WorldFile::parse("box.toml", BOX).unwrap().scene;
    let renderer = scene.renderer("coupled").unwrap();
    let mut state = renderer.start();
    let mut expected = Vec::new();
    let mut largest: f64 = 0.0;
    for (position, orientation) in &poses {
        let (position, orientation) = ([*position], [*orientation]);
        let sample = Sample::at(&position).turned(&orientation);
        let output = renderer.step(&mut state, &sample);
        largest = largest.max(output.torques[0][1].abs());
        expected.push([output.forces[0], output.torques[0]].concat());
    }
    expected.push(vec![0.0; 6]);
    assert!(largest > 0.02, "{largest} N m");
    let mut answers = answer.stdout.lines();
    assert_eq!(answers.next(), Some("fx_n,fy_n,fz_n,tx_n_m,ty_n_m,tz_n_m"));
    let numbers = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
    let answers: Vec<Vec<f64>> = answers.map(numbers).collect();
    assert_eq!(answers, expected);

    // A torque has a separate limit.
    let limited = BOX.to_owned() + "[render]\ntorque_limit_n_m = 0.01\n";
    folder.write("box.toml", &limited);
    let answer = folder.palpate_reading(&lines, "pipe box.toml --force-limit inf --soft-start 0");
    let sizes = answer.stdout.lines().map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        numbers[3..].iter().map(|x| x * x).sum::<f64>().sqrt()
    });
    let most = sizes.fold(0.0, f64::max);
    assert!((most - 0.01).abs() < 1e-9, "{most}");

    // An orientation of length 0 sets all forces to 0.
    folder.write("box.toml", BOX);
    let lost = lines.lines().take(40).collect::<Vec<_>>().join("\n") + "\n0,0,0.0181,0,0,0,0\n";
    let answer = folder.palpate_reading(&lost, "pipe box.toml --soft-start 0");
    assert!(
        answer.stderr.contains("not a unit quaternion"),
        "{answer:?}"
    );
    assert_eq!(answer.stdout.lines().nth(40), Some("0,0,0,0,0,0"));
}

#[test]
fn a_last_line_without_a_newline_moves_no_device() {
    let line = "0,0,0.0695,0.1,0,0.0095";
    let arguments = "pipe ball.toml --soft-start 0";
    let answer = folder().palpate_reading(format!("{line}\n{line}"), arguments);
    let whole = folder().palpate_reading(format!("{line}\n{line}\n"), arguments);
    let [cut, whole_lines] = [&answer, &whole].map(|it| it.stdout.lines().collect::<Vec<_>>());
    assert_eq!(cut.len(), 3, "{answer:?}");
    assert_eq!(cut[0], whole_lines[0]);
    assert_eq!(cut[1], "0,0,0,0,0,0");
    assert_ne!(whole_lines[1], cut[1], "{whole:?}");
    assert!(
        answer
            .stderr
            .contains("line 2: the input ends within the line"),
        "{answer:?}"
    );
}

#[test]
fn a_guard_holds_back_in_a_pipe_and_says_so() {
    let pipe = |more: &str| {
        let arguments = format!("pipe ball.toml --soft-start 0 --json {more}");
        let answer = folder().palpate_reading(lines(&motion()), &arguments);
        assert_eq!(answer.code, 0, "{answer:?}");
        answer
    };
    let guarded = |answer: &crate::common::Answer| {
        let said = answer.stderr.lines().find(|line| line.starts_with('{'));
        let report: serde_json::Value = serde_json::from_str(said.unwrap()).unwrap();
        report["guarded"].as_u64().unwrap()
    };
    let open = pipe("");
    let reporting = pipe("--guard report --guard-allowance 1e-4");
    assert_eq!(open.stdout, reporting.stdout);
    assert_eq!(guarded(&open), 0);
    assert!(guarded(&reporting) > 20);
    assert!(
        reporting
            .stderr
            .contains("the bound of the passivity guard"),
        "{}",
        reporting.stderr
    );
    let limiting = pipe("--guard limit --guard-allowance 1e-4");
    assert!(guarded(&limiting) > 20 && limiting.stdout != open.stdout);
}

/// A pen turned by its hand: poses in, forces without torques out.
#[test]
fn a_device_that_gives_no_torque_is_read_with_its_orientation_and_answered_with_a_force() {
    let folder = Folder::new();
    let stylus = BOX.replacen("inertia", "gives_torque = false\ninertia", 1);
    folder.write("stylus.toml", &stylus);
    let line = |tick: u32| {
        let half = 0.05 + 1e-3 * f64::from(tick);
        format!("0,0,0.0178,{},0,{},0\n", half.cos(), half.sin())
    };
    let lines: String = (0..60).map(line).collect();
    let exact = "pipe stylus.toml --force-limit inf --soft-start 0 --header";
    let answer = folder.palpate_reading(&lines, exact);
    assert_eq!(answer.code, 0, "{answer:?}");
    assert!(!answer.stderr.contains("N m"), "{answer:?}");
    let mut answers = answer.stdout.lines();
    assert_eq!(answers.next(), Some("fx_n,fy_n,fz_n"));
    let forces: Vec<Vec<f64>> = answers
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(forces.len(), 61);
    assert!(forces.iter().all(|force| force.len() == 3));
    // The rotation alone presses it deeper.
    assert!(forces[1][2] < 0.5 * forces[59][2], "{forces:?}");
    let without = folder.palpate_reading("0,0,0.0178\n", "pipe stylus.toml");
    assert_eq!(without.code, 3, "{without:?}");
    assert!(
        without.stderr.contains("x_m,y_m,z_m,qw,qx,qy,qz"),
        "{without:?}"
    );
}

#[test]
fn a_hand_beyond_the_acceleration_of_the_guard_is_counted() {
    // Steps of 0.1 mm.
    let mut jerky = motion();
    for [thumb, _] in jerky.iter_mut().skip(5).step_by(2) {
        thumb[2] += 1e-4;
    }
    let pipe = |acceleration: &str| {
        let guard = format!("--guard limit --guard-acceleration {acceleration}");
        let arguments = format!("pipe ball.toml --soft-start 0 --json {guard}");
        let answer = folder().palpate_reading(lines(&jerky), &arguments);
        assert_eq!(answer.code, 0, "{answer:?}");
        let said = answer.stderr.lines().find(|line| line.starts_with('{'));
        let report: serde_json::Value = serde_json::from_str(said.unwrap()).unwrap();
        let told = answer.stderr.matches("accelerated beyond").count();
        (report["beyond_guard"].as_u64().unwrap(), told)
    };
    assert_eq!(pipe("1e6"), (0, 0));
    let (count, told) = pipe("1e-3");
    assert!(count > 20 && told == 1, "{count}, told {told} times");
}

#[test]
fn lines_of_a_world_have_their_slopes_beside_the_forces() {
    let folder = folder();
    let line = folder
        .read("ball.toml")
        .replacen("[loop]\n", "[loop]\nhold = \"line\"\n", 1);
    folder.write("line.toml", &line);
    let pipe = |arguments: &str| folder.palpate_reading(lines(&motion()), arguments);
    let coupled = "pipe line.toml --method coupled --soft-start 0";
    let answer = pipe(&format!("{coupled} --columns force,slope --header"));
    assert_eq!(answer.code, 0, "{answer:?}");
    let mut printed = answer.stdout.lines();
    let of_thumb =
        "thumb.fx_n,thumb.fy_n,thumb.fz_n,thumb.sx_n_per_s,thumb.sy_n_per_s,thumb.sz_n_per_s";
    let header = printed.next().unwrap();
    assert!(header.starts_with(of_thumb), "{header}");
    let rows: Vec<Vec<f64>> = printed
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert!(rows.iter().all(|row| row.len() == 12));
    let steepest = rows.iter().map(|row| row[5].abs()).fold(0.0, f64::max);
    assert!(steepest > 10.0, "{steepest} N/s");
    assert_eq!(rows.last().unwrap(), &[0.0; 12]);
    for (arguments, words) in [
        ("pipe line.toml --method coupled", "print both"),
        (
            "pipe line.toml --method coupled --columns force,phase",
            "allowed is force",
        ),
        ("pipe ball.toml --columns force,slope", "always 0"),
    ] {
        let answer = pipe(arguments);
        assert_eq!(answer.code, 2, "{answer:?}");
        assert!(answer.stderr.contains(words), "{answer:?}");
    }
}
