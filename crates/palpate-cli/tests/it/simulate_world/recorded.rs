//! `palpate render`: a recorded motion in a world.

use super::{BALL, error};
use crate::common::{self, Folder, schema};

#[test]
fn a_recorded_motion_is_rendered_in_a_world() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let mut motion = String::from("t,x,y,z\n");
    for sample in 0..=300 {
        let time = 0.001 * f64::from(sample);
        let z = 0.08 - 0.013 * (1.0 - (40.0 * time).cos()) / 2.0;
        motion += &format!("{},0.002,0,{z}\n", 7.0 + time);
    }
    folder.write("motion.csv", motion);
    let report =
        folder.json("render ball.toml --input motion.csv --method basic,coupled --out forces.csv");
    assert_eq!(schema::check(&report), "world");
    assert_eq!(report["samples"], 300);
    let (basic, coupled) = (error(&report, "basic"), error(&report, "coupled"));
    assert!(coupled < 0.5 * basic, "{basic} {coupled}");
    let forces = folder.read("forces.csv");
    assert_eq!(forces.lines().count(), 1 + 2 * 300);
    assert!(
        forces.starts_with(
            "method,device,t_s,x_m,y_m,z_m,fx_n,fy_n,fz_n,mean_fx_n,mean_fy_n,mean_fz_n,\
             ideal_fx_n,ideal_fy_n,ideal_fz_n,ideal_x_m,ideal_y_m,ideal_z_m\nbasic,tool,0,0.002,0,0.08,"
        )
    );

    folder.fail("render ball.toml", 2, &["--input RECORDING.csv"]);
    folder.write("wrong.csv", "t,x,y\n0,0,0\n1,0,0\n");
    folder.fail(
        "render ball.toml --input wrong.csv",
        3,
        &["wrong.csv:1", "no column `z`", "--columns"],
    );
    folder.write(
        "cut.csv",
        "t,x,y,z\n0,0,0,0.08\n0.001,0,0,0.08\n0.002,0,0,0.0",
    );
    folder.write(
        "long.csv",
        "t,x,y,z\n0,0,0,0.08\n20,0,0,0.08\n1e9,0,0,0.08\n",
    );
    folder.fail(
        "render ball.toml --input long.csv --method basic --time-unit s",
        3,
        &["long.csv: the trace continues for more than 2000000 periods (2000 s)"],
    );
    let cut = folder.palpate("render ball.toml --input cut.csv --method basic");
    assert!(cut.stderr.contains("`0.0`, may be cut off"), "{cut:?}");
    folder.succeed("render ball.toml --input motion.csv --plot x.svg");
    assert!(folder.read("x.svg").contains("force z [N]"));
    folder.write("fig2.toml", common::experiment_text("fig2"));
    folder.fail(
        "render fig2.toml --input motion.csv",
        2,
        &["is one contact"],
    );
}

/// The same motion in millimetres, milliseconds and other columns: rejected as metres and seconds, and accepted with
/// flags.
#[test]
fn a_recorders_table_is_rendered_in_a_world_as_flags_say() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let (mut metres, mut recorder) = ("t,x,y,z\n".to_owned(), "Z\tgrip\ttime\tY\tX\n".to_owned());
    for sample in (0..=300).filter(|sample| !(100..150).contains(sample)) {
        let time = 0.001 * f64::from(sample);
        let z = 0.08 - 0.013 * (1.0 - (40.0 * time).cos()) / 2.0;
        metres += &format!("{time},0.002,0,{z}\n");
        recorder += &format!("{}\t1\t{}\t0\t2\n", 1000.0 * z, 1000.0 * time);
    }
    folder.write("metres.csv", metres);
    folder.write("recorder.csv", recorder);
    let render = "render ball.toml --method basic --input";
    let json = |render: &str| -> serde_json::Value {
        let answer = folder.palpate(&format!("{render} --json"));
        assert!(
            answer
                .stderr
                .contains("no sample was recorded for 0.0510 s"),
            "{answer:?}"
        );
        serde_json::from_str(&answer.stdout).unwrap_or_else(|_| panic!("{answer:?}"))
    };
    let right = json(&format!("{render} metres.csv"));
    let columns = "recorder.csv --columns t=time,x=X,y=Y,z=Z";
    for (flags, words) in [
        ("recorder.csv", "--columns t=NAME"),
        (columns, "--time-unit ms"),
        (&format!("{columns} --unit mm"), "--time-unit ms"),
        (&format!("{columns} --time-unit ms"), "--unit mm"),
    ] {
        folder.fail(&format!("{render} {flags}"), 3, &["recorder.csv", words]);
    }
    let said = json(&format!("{render} {columns} --unit mm --time-unit ms"));
    assert_eq!(schema::check(&said), "world");
    let (found, ideal) = (error(&said, "basic"), error(&right, "basic"));
    assert!((found - ideal).abs() < 1e-6 * ideal, "{found} {ideal}");
    let motion = &said["motion"];
    let gap = motion["longest_gap_s"].as_f64().unwrap();
    assert!((gap - 0.051).abs() < 1e-9, "{motion}");
    let share = motion["interpolated_percent"].as_f64().unwrap();
    assert!((share - 100.0 * 50.0 / 301.0).abs() < 1e-9, "{motion}");
    // A slow motion of less than 2 m, but far from the device of the scene, or deep in a solid.
    folder.write("far.csv", "t,x,y,z\n0,0,0,80\n0.1,0,0,80\n0.2,0,0,80.1\n");
    folder.fail(
        &format!("{render} far.csv"),
        3,
        &["from its position in the scene", "--unit mm"],
    );
}

/// A box that is turned about an edge on the table: E of force and torque together.
#[test]
fn a_recorded_motion_of_six_axes_is_rendered_with_its_torques() {
    let folder = Folder::new();
    folder.write("box.toml", common::experiment_text("worlds/box"));
    let mut motion = String::from("t,x,y,z,qw,qx,qy,qz\n");
    for sample in 0..=300 {
        let time = 0.001 * f64::from(sample);
        let (z, half) = (
            0.0165 - 0.004 * (20.0 * time).sin(),
            0.1 * (30.0 * time).sin(),
        );
        motion += &format!("{time},0,0,{z},{},0,{},0\n", half.cos(), half.sin());
    }
    folder.write("motion.csv", motion);
    let report =
        folder.json("render box.toml --input motion.csv --method basic,coupled --out forces.csv");
    assert_eq!(schema::check(&report), "world");
    let (basic, coupled) = (error(&report, "basic"), error(&report, "coupled"));
    assert!(coupled < 0.5 * basic, "{basic} {coupled}");
    let forces = folder.read("forces.csv");
    assert!(
        forces
            .lines()
            .next()
            .unwrap()
            .contains("qw,qx,qy,qz,tx_n_m,ty_n_m,tz_n_m,mean_fx_n,")
    );
    let largest = forces
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .nth(14)
                .unwrap()
                .parse::<f64>()
                .unwrap()
                .abs()
        })
        .fold(0.0, f64::max);
    assert!(largest > 1e-3, "a torque about y of {largest} N m at most");
    folder.write("wrong.csv", "t,x,y,z\n0,0,0,0\n1,0,0,0\n");
    folder.fail(
        "render box.toml --input wrong.csv",
        3,
        &["wrong.csv:1", "no column `qw`", "x, y, z, qw, qx, qy, qz"],
    );
}
