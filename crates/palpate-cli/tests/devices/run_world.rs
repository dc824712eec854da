//! `palpate run` with a world, on each device that takes one.

use crate::common::{Answer, Folder, experiment_text, number, parse};
use palpate_drivers::emulator::inverse3::{Body, Emulator, EmulatorOptions, holding};
use palpate_record::recording::{Entry, Recording};

fn folder() -> Folder {
    let folder = Folder::new();
    for name in ["block-at-wall", "ball-on-table"] {
        let text = experiment_text(&format!("worlds-on-devices/{name}"));
        folder.write(&format!("{name}.toml"), text);
    }
    folder
}

#[test]
fn a_loop_whose_samples_are_refused_is_no_success() {
    let folder = folder();
    let text = experiment_text("worlds-on-devices/ball-on-table");
    let stiff: Vec<String> = text
        .lines()
        .map(|line| match line.starts_with("stiffness_n_per_m") {
            true => "stiffness_n_per_m = 1e10".to_owned(),
            false => line.to_owned(),
        })
        .collect();
    folder.write("stiff.toml", stiff.join("\n"));
    let answer = folder.palpate("run stiff.toml --fast --duration 2 --json");
    assert_eq!(answer.code, 5, "{answer:?}");
    let report = parse(&answer.stdout);
    let timing = &report["timing"];
    let refused = timing["refused"].as_u64().unwrap();
    assert!(refused > 100 && timing["ticks"] == 2000, "{report}");
    let answer = folder.palpate("run stiff.toml --fast --duration 2");
    let said = format!("the renderer refused the samples of {refused} of 2000 ticks");
    assert!(
        crate::common::in_a_line(&answer.stdout).contains(&said),
        "{answer:?}"
    );
    assert!(answer.stderr.contains(&said), "{answer:?}");
    assert!(
        crate::common::in_a_line(&answer.stdout).contains("too stiff or too damped"),
        "{answer:?}"
    );
}

#[test]
fn a_recorded_world_of_one_tick_is_no_motion() {
    let folder = folder();
    folder.succeed("run ball-on-table.toml --record one.mcap --fast --duration 0.0004");
    folder.fail(
        "replay one.mcap --method basic",
        3,
        &[
            "one.mcap: 1 of 1 readable tick with a position",
            "a motion needs 2",
        ],
    );
}

#[test]
fn a_world_is_run_recorded_and_read_back() {
    let folder = folder();
    let command = "run ball-on-table.toml --record ball.mcap --fast --duration 2 --json";
    let report = parse(&folder.succeed(command));
    assert_eq!(report["method"], "coupled");
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
    assert!(number(&report, "peak_force_n") > 0.5, "{report}");
    assert!(number(&report, "leak_held_j").abs() < 0.005, "{report}");
    let recording = &report["recording"];
    assert!(
        recording["complete"] == true && recording["ticks"] == 2000,
        "{report}"
    );

    let info = parse(&folder.succeed("info ball.mcap --json"));
    assert!(
        info["complete"] == true && info["ticks_lost"] == 0,
        "{info}"
    );
    assert!(info["flags"]["contact"].as_u64().unwrap() > 1000, "{info}");
    let world = folder.succeed("info ball.mcap --text world");
    assert_eq!(world, experiment_text("worlds-on-devices/ball-on-table"));
    let frame = folder.succeed("info ball.mcap --text frame");
    assert!(frame.contains("axes = [\"x\", \"y\", \"z\"]"), "{frame}");

    let path = folder.path("ball.mcap");
    let mut in_hand = 0;
    for entry in Recording::open(&path).unwrap().entries().unwrap() {
        let Entry::Tick(tick, contacts, bodies, _) = entry.unwrap() else {
            continue;
        };
        assert_eq!(tick.contacts as usize, contacts.len());
        // The ball, and the proxy of the tool after ball and table.
        let numbers: Vec<u32> = bodies.iter().map(|body| body.body).collect();
        assert_eq!(numbers, [0, 2]);
        assert!(bodies[0].position.iter().all(|x| x.is_finite()));
        let [_, _, up] = tick.delivered_force;
        in_hand += usize::from(up > 0.5);
        for contact in &contacts {
            let square: f64 = contact.normal.iter().map(|n| n * n).sum();
            assert!((square - 1.0).abs() < 1e-9 && contact.force[2].is_finite());
        }
    }
    assert!(
        in_hand > 1000,
        "{in_hand} ticks with the ball's force in the hand"
    );

    folder.succeed("convert ball.mcap");
    let table = folder.read("ball.csv");
    let head = table
        .lines()
        .find(|line| line.starts_with("sequence"))
        .unwrap();
    for column in ["contact_force_3_n", "bodies", "created_energy_j", "pair"] {
        assert!(head.contains(column), "{head}");
    }
    let bodies = folder.read("ball-bodies.csv");
    let head = bodies
        .lines()
        .find(|line| line.starts_with("sequence"))
        .unwrap();
    assert!(head.contains("body_position_3_m"), "{head}");
    assert_eq!(
        bodies
            .lines()
            .filter(|line| !line.starts_with("sequence"))
            .count(),
        4000
    );
}

#[test]
fn the_pointer_holds_a_world_and_flags_of_one_contact_are_refused() {
    let folder = folder();
    let command = "run ball-on-table.toml --device pointer --fast --duration 0.5 --method basic";
    let said = folder.succeed(command);
    assert!(
        said.contains("basic on the device `pointer` at 1000 Hz"),
        "{said}"
    );
    for (command, words) in [
        ("run ball-on-table.toml --stiffness 100", "--stiffness"),
        ("run ball-on-table.toml --safe-range 0,1", "--safe-range"),
        ("run ball-on-table.toml --normal 0,0,1", "--normal"),
        ("run ball-on-table.toml --device null", "have one axis"),
        ("run ball-on-table.toml --world-axes x,x,y", "each once"),
        ("run ball-on-table.toml --world-axes x,z", "for the 3 axes"),
        ("run ball-on-table.toml --method basic,coupled", "--method"),
    ] {
        let answer = folder.palpate(command);
        assert_eq!(answer.code, 2, "{command}: {answer:?}");
        assert!(answer.stderr.contains(words), "{command}: {answer:?}");
    }
    folder.write("wall.toml", experiment_text("wall"));
    let answer = folder.palpate("run wall.toml --world-axes x,y,z --fast");
    assert_eq!(answer.code, 2, "{answer:?}");
}

/// In a world whose force exceeds a limit, the limit applies to the length of the vector.
#[test]
fn a_limit_of_the_force_holds_in_every_direction() {
    let folder = folder();
    let text = folder.read("ball-on-table.toml");
    let pressed = text.replace("force_n = [0.0, 0.0, -1.0]", "force_n = [0.7, 0.4, -3.0]");
    assert_ne!(pressed, text);
    folder.write("pressed.toml", pressed);
    let command = "run pressed.toml --record pressed.mcap --fast --duration 1 --safe-force 0.8 --oscillation inf --json";
    let report = parse(&folder.succeed(command));
    let peak = number(&report, "peak_force_n");
    assert!((peak - 0.8).abs() < 1e-9, "{report}");
    let recording = Recording::open(&folder.path("pressed.mcap")).unwrap();
    let mut limited_aslant = 0;
    for row in recording.rows().unwrap() {
        let [x, y, z] = row.unwrap().tick.delivered_force;
        let length = (x * x + y * y + z * z).sqrt();
        assert!(length < 0.8 + 1e-9, "{length} N");
        limited_aslant += usize::from(length > 0.79 && z < 0.79);
    }
    assert!(limited_aslant > 10, "{limited_aslant} ticks");
}

/// Runs an Inverse3 whose hand pulls it 9 mm down, into the ball. Returns the program's answer and the forces that the
/// service received [N].
fn a_ball_is_pressed(folder: &Folder) -> (Answer, Vec<[f64; 3]>) {
    // The service's z is up too.
    let mut body = Body {
        start: [0.01, 0.02, 0.1],
        ..Body::default()
    };
    body.hands[2] = holding(0.088, 150.0, 4.0);
    let emulator = Emulator::start(&EmulatorOptions {
        body,
        ..EmulatorOptions::default()
    })
    .unwrap();
    let answer = folder.palpate(&format!(
        "run ball-on-table.toml --record ball.mcap --device inverse3 --service {} --priority 0 \
         --service-priority 0 --stall-after-periods 50 --duration 2 --json",
        emulator.url()
    ));
    let received = emulator.received();
    let forces = received.iter().filter_map(|message| message.force);
    (answer, forces.collect())
}

#[test]
fn an_inverse3_presses_a_ball_on_a_table() {
    // A busy machine sometimes stalls the loop beyond its limit, which disables the motors.
    let (answer, pushed) = (0..10)
        .map(|_| {
            let (answer, pushed) = a_ball_is_pressed(&folder());
            assert_eq!(pushed.last(), Some(&[0.0; 3]));
            // 5 if the motors were off for most of the ticks.
            assert!(matches!(answer.code, 0 | 5), "{answer:?}");
            (answer, pushed)
        })
        .find(|(answer, _)| {
            answer.code == 0 && number(&parse(&answer.stdout), "peak_force_n") > 0.3
        })
        .expect("the loop was stopped in each of ten runs");
    let report = parse(&answer.stdout);
    assert_eq!(report["device"], "Haply Inverse3");
    // The ball is under the tool, 4 mm off its middle: it pushes up, and a little to the side.
    assert!(pushed.iter().any(|[_, _, z]| *z > 0.3));
    assert!(pushed.iter().any(|[_, y, _]| y.abs() > 0.005));
}

/// Records a 2DIY whose hand moves it 32 mm away from its base, into a block before a wall, as `block.mcap`.
#[cfg(unix)]
fn record_the_block(folder: &Folder) -> Answer {
    use palpate_drivers::emulator::port::PortSettings;
    use palpate_drivers::emulator::two_diy::{self, Hand, Settings};
    use palpate_drivers::two_diy::{Board, Generation};
    // The hand starts at the tool's position.
    let settings = Settings {
        angles: Some([130.0, 50.0]),
        hand: Hand::Holds {
            place: [0.019, 0.1169 + 0.032],
            sway: [0.0; 2],
            period: 1.0,
            stiffness: 40.0,
            damping: 4.0,
        },
        hand_waits: true,
        port: PortSettings::Socket {
            path: folder.path("haply"),
        },
        ..Settings::new(Generation::Three, Board::M0)
    };
    let emulator = two_diy::Emulator::start(&settings).unwrap();
    let answer = folder.palpate(
        "run block-at-wall.toml --record block.mcap --device haply-2diy --port haply --board m0 \
         --origin 0.019,0.1169 --start-pose 130,50 --priority 0 --stall-after-periods 200 --duration 1.2 --json",
    );
    // 5 if the motors were off for most of the ticks.
    assert!(matches!(answer.code, 0 | 5), "{answer:?}");
    assert_eq!(emulator.torques(), [0.0; 2]);
    answer
}

/// Returns the report of such a run, the block's positions [m], each with the device's force along y [N], and the
/// distance that the hand had moved the tool when the loop began [m].
#[cfg(unix)]
fn a_block_is_pushed(folder: &Folder) -> (serde_json::Value, Vec<(f64, f64)>, f64) {
    let answer = record_the_block(folder);
    assert!(!answer.stderr.contains("[[device]]"), "{}", answer.stderr);
    let recording = Recording::open(&folder.path("block.mcap")).unwrap();
    let (mut pushed, mut led) = (Vec::new(), None);
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(tick, _, bodies, _) = entry.unwrap() {
            assert!(tick.device_axes[2].is_nan() && tick.commanded_force[2] == 0.0);
            led.get_or_insert(tick.device_axes[1] - 0.1169);
            pushed.push((bodies[0].position[1], tick.commanded_force[1]));
        }
    }
    (parse(&answer.stdout), pushed, led.unwrap())
}

#[cfg(unix)]
#[test]
fn a_2diy_pushes_a_block_against_a_wall() {
    // A busy machine sometimes stalls the loop beyond its limit. Then the motors are off, the hand pushes the tool into
    // the block without a force against it, and the run shows nothing here. A run whose loop began with the tool
    // already in the block is unusable too, and one in which a late tick lets the hand push the block into the wall:
    // the wall is 30 mm away, and half of the block is 15 mm.
    let is_through = |pushed: &[(f64, f64)]| pushed.iter().any(|(y, _)| *y >= 0.017);
    let (report, pushed, _) = (0..10)
        .map(|_| a_block_is_pushed(&folder()))
        .find(|(report, pushed, led)| {
            let is_stopped = number(report, "motors_off_ticks") > 0.0;
            !is_stopped && led.abs() < 1e-3 && !is_through(pushed)
        })
        .expect("the loop was stopped, began late or was through the wall in each of ten runs");
    assert!(number(&report, "peak_force_n") > 0.3, "{report}");
    let (first, last) = (pushed[0].0, pushed.last().unwrap().0);
    assert!(first.abs() < 1e-4 && last > 0.005, "{first} to {last} m");
    let back = pushed.iter().filter(|(_, force)| *force < -0.3).count();
    assert!(back > 20, "{back} ticks with a force against the hand");
}

/// The file gives the device three axes. The loop renders no force along z and reports it, and the z axis is not
/// evaluated.
#[cfg(unix)]
#[test]
fn a_2diy_lacks_the_third_axis_whatever_its_file_says() {
    let folder = folder();
    let text = folder.read("block-at-wall.toml");
    let text = text.replace("axes = [\"x\", \"y\"]\n", "");
    // The tool is above the middle of the block, so the edge of the block would push it up.
    let text = text
        .replace("-0.025, 0.01]", "-0.025, 0.022]")
        .replace("0.0, 0.01]", "0.0, 0.022]");
    assert!(!text.contains("axes =") && text.contains("-0.025, 0.022]"));
    folder.write("block-at-wall.toml", &text);
    let answer = record_the_block(&folder);
    let said = "tool: the file has the axes x, y and z, but the device has x and y of the world (Haply 2DIY, generation 3, board m0): \
                the mechanism holds the tool along the other axes, without a rendered force; set `axes = [\"x\", \"y\"]` in \
                [[device]] for `simulate`, `compare` and `tune`, too";
    assert!(answer.stderr.contains(said), "{}", answer.stderr);
    let recording = Recording::open(&folder.path("block.mcap")).unwrap();
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(tick, ..) = entry.unwrap() {
            assert!(tick.commanded_force[2] == 0.0);
        }
    }
    let replayed = folder.json_of_a_loop("replay block.mcap --method coupled");
    let tool = &replayed["methods"][0]["devices"][0];
    assert_eq!(tool["axes"][2], serde_json::Value::Null, "{tool}");
}

#[test]
fn the_motion_of_a_recording_is_replayed_in_its_world() {
    let folder = folder();
    folder.write(
        "ball.toml",
        experiment_text("worlds-on-devices/ball-on-table"),
    );
    folder.succeed("run ball.toml --record ball.mcap --fast --duration 1");
    let replayed =
        folder.json_of_a_loop("replay ball.mcap --method basic,coupled --out replayed.csv");
    assert_eq!(replayed["format"], "palpate world 1");
    let samples = replayed["samples"].as_u64().unwrap();
    assert!((990..1000).contains(&samples), "{samples}");
    let methods = replayed["methods"].as_array().unwrap();
    let error = |place: usize| number(&methods[place]["sum"], "mean_force_error_percent");
    assert!(error(1) < error(0), "{} {}", error(1), error(0));
    let rows = folder.read("replayed.csv").lines().count() as u64;
    assert_eq!(rows, 1 + 2 * samples);
    folder.fail(
        "replay ball.mcap --replay hand",
        2,
        &["--replay", "is a world"],
    );
}

#[test]
fn a_simulated_device_says_that_its_mass_does_not_change_with_its_place() {
    let folder = folder();
    let scene = experiment_text("worlds-on-devices/ball-on-table");
    let table = "mass_table = { places_m = [[-0.1, 0.1], [0.0], [0.0]], mass_kg = [\
                 [0.25, 0.25, 0.25, 0.0, 0.0, 0.0], [0.3, 0.25, 0.25, 0.0, 0.0, 0.0]] }";
    folder.write("ball.toml", scene.replacen("mass_kg = 0.25", table, 1));
    let answer = folder.palpate("run ball.toml --fast --duration 0.05");
    let said = "the mass_table of tool is for the renderer and for `simulate`";
    assert!(
        answer.code == 0 && answer.stderr.contains(said),
        "{answer:?}"
    );
}

/// A replay leads the devices, so it does not need the trace of the hand that held them.
#[test]
fn a_recording_is_replayed_without_the_trace_of_its_hand() {
    let folder = folder();
    let scene = experiment_text("worlds-on-devices/ball-on-table");
    let rest = "rest_m = [0.0, 0.004, 0.05]";
    assert!(scene.contains(rest));
    folder.write("ball.toml", scene.replace(rest, "rest_file = \"hand.csv\""));
    folder.write(
        "hand.csv",
        "t_s,x_m,y_m,z_m\n0,0,0.004,0.05\n0.2,0,0.004,0.02\n",
    );
    folder.succeed("run ball.toml --record ball.mcap --fast --duration 0.3");
    let elsewhere = Folder::new();
    std::fs::copy(folder.path("ball.mcap"), elsewhere.path("ball.mcap")).unwrap();
    let replayed = elsewhere.json_of_a_loop("replay ball.mcap");
    assert_eq!(replayed["format"], "palpate world 1");
}

#[test]
fn a_device_of_six_axes_is_run_and_its_turns_and_torques_are_recorded() {
    let folder = Folder::new();
    folder.write("box.toml", experiment_text("worlds/box"));
    let report =
        parse(&folder.succeed("run box.toml --record box.mcap --fast --duration 0.3 --json"));
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
    assert!(number(&report, "peak_force_n") > 1.0, "{report}");
    let (mut torque, mut turned, mut proxy): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut first = None;
    for entry in Recording::open(&folder.path("box.mcap"))
        .unwrap()
        .entries()
        .unwrap()
    {
        let Entry::Tick(tick, _, bodies, _) = entry.unwrap() else {
            continue;
        };
        let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert_eq!(tick.commanded_torque, tick.delivered_torque);
        torque = torque.max(length(tick.delivered_torque));
        let start = *first.get_or_insert(tick.device_orientation);
        let apart = |q: [f64; 4]| {
            let parts = q.iter().zip(start);
            parts
                .map(|(q, start)| (q - start).abs())
                .fold(0.0, f64::max)
        };
        turned = turned.max(apart(tick.device_orientation));
        let of_tool = bodies.last().unwrap().orientation;
        let own = of_tool.iter().zip(tick.device_orientation);
        proxy = own.fold(proxy, |most, (proxy, device)| {
            most.max((proxy - device).abs())
        });
    }
    // The box tips, and its proxy is near the device, but not at its position.
    assert!(torque > 0.01 && torque <= 1.0, "{torque} N m");
    assert!(turned > 0.05, "{turned}");
    assert!(proxy > 0.0 && proxy < 0.15, "{proxy}");
    // Replay of its motion by another method; the first samples have the same torques.
    let replayed =
        folder.json_of_a_loop("replay box.mcap --method basic,coupled --out replayed.csv");
    let methods = replayed["methods"].as_array().unwrap();
    let error = |place: usize| number(&methods[place]["sum"], "mean_force_error_percent");
    assert!(error(1) < 0.5 * error(0), "{} {}", error(1), error(0));
    let table = folder.read("replayed.csv");
    let header = "method,device,t_s,x_m,y_m,z_m,fx_n,fy_n,fz_n,qw,qx,qy,qz,tx_n_m,ty_n_m,tz_n_m,\
                  mean_fx_n,mean_fy_n,mean_fz_n,ideal_fx_n,ideal_fy_n,ideal_fz_n,\
                  ideal_x_m,ideal_y_m,ideal_z_m,ideal_tx_n_m,ideal_ty_n_m,ideal_tz_n_m";
    assert_eq!(table.lines().next(), Some(header));
    let samples = replayed["samples"].as_u64().unwrap();
    assert_eq!(table.lines().count() as u64, 1 + 2 * samples);
    folder.succeed("convert box.mcap");
    assert!(folder.read("box.csv").contains("delivered_torque_1_n_m"));

    // The hand of a pointer holds it at its start.
    let report =
        parse(&folder.succeed("run box.toml --device pointer --fast --duration 0.1 --json"));
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
    folder.fail(
        "run box.toml --fast --duration 0.1 --world-axes y,x,z",
        3,
        &["box.toml", "x,y,z"],
    );
}

/// A stylus in the loop: its rotation is recorded, without a torque.
#[test]
fn a_device_that_gives_no_torque_is_run_and_replayed() {
    let folder = Folder::new();
    folder.write("stylus.toml", experiment_text("worlds/stylus"));
    let report =
        parse(&folder.succeed("run stylus.toml --record stylus.mcap --fast --duration 0.2 --json"));
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
    assert!(number(&report, "peak_force_n") > 1.0, "{report}");
    let replayed =
        folder.json_of_a_loop("replay stylus.mcap --method basic,coupled --out replayed.csv");
    let methods = replayed["methods"].as_array().unwrap();
    assert_eq!(methods[0]["devices"][0]["torque"], serde_json::Value::Null);
    let error = |place: usize| number(&methods[place]["sum"], "mean_force_error_percent");
    assert!(error(1) < 0.9 * error(0), "{} {}", error(1), error(0));
    let header = "method,device,t_s,x_m,y_m,z_m,fx_n,fy_n,fz_n,qw,qx,qy,qz,mean_fx_n,mean_fy_n,mean_fz_n,\
        ideal_fx_n,ideal_fy_n,ideal_fz_n,ideal_x_m,ideal_y_m,ideal_z_m";
    assert_eq!(folder.read("replayed.csv").lines().next(), Some(header));
    let report =
        parse(&folder.succeed("run stylus.toml --device pointer --fast --duration 0.1 --json"));
    assert_eq!(report["safety_stop"], serde_json::Value::Null);
}

#[test]
fn a_guard_acts_in_a_loop_of_a_world_and_is_counted() {
    let folder = folder();
    let guarded = |name: &str, more: &str| {
        let record = format!("run ball-on-table.toml --record {name} --fast --duration 1 --json");
        let _ = folder.succeed(&format!("{record} {more}"));
        let info = parse(&folder.succeed(&format!("info {name} --json")));
        info["flags"]["limited-guard"].as_u64().unwrap_or(0)
    };
    assert_eq!(guarded("a.mcap", "--guard limit"), 0);
    assert!(guarded("b.mcap", "--guard limit --guard-allowance 0.001") > 10);
}
