//! The guard of a world, by flags and in its file.

use super::{BALL, error};
use crate::common::{Folder, schema};

#[test]
fn a_guard_is_asked_for_by_flags_or_the_file_and_what_it_holds_back_is_counted() {
    let folder = Folder::new();
    folder.write("ball.toml", BALL);
    let guarded = |arguments: &str| {
        let report = folder.json(arguments);
        assert_eq!(schema::check(&report), "world");
        let count = |key: &str| report["methods"][0][key].as_u64().unwrap();
        // No other limit applies here, and a guard that reports changes no force.
        let changed = if arguments.contains("report") {
            0
        } else {
            count("guarded_samples")
        };
        assert_eq!(count("limited_samples"), changed, "{arguments}");
        (count("guarded_samples"), error(&report, "coupled"))
    };
    let open = guarded("simulate ball.toml");
    assert_eq!(guarded("simulate ball.toml --guard limit"), open);
    let (seen, error) = guarded("simulate ball.toml --guard report --guard-allowance 1e-5");
    assert!(seen > 4 && error == open.1, "{seen} {error}");
    let said = folder.succeed("simulate ball.toml --guard report --guard-allowance 1e-5");
    let words = format!("coupled: at {seen} samples the forces exceeded the guard's bound.");
    assert!(said.contains(&words), "{said}");
    let (acted, error) = guarded("simulate ball.toml --guard limit --guard-allowance 1e-5");
    assert!(acted > 4 && error > 10.0 * open.1, "{acted} {error}");
    // The guard of the file, with its speed changed by a flag.
    let guard = "[render]\nguard = { mode = \"limit\", allowance_j = 1e-5 }";
    folder.write("guarded.toml", BALL.replace("[render]", guard));
    assert_eq!(guarded("simulate guarded.toml"), (acted, error));
    let (fewer, _) = guarded("simulate guarded.toml --guard limit --guard-speed 0.1");
    assert!(fewer < acted, "{fewer} {acted}");
    assert_eq!(guarded("simulate guarded.toml --guard off"), open);
    folder.fail(
        "simulate ball.toml --guard limit --guard-speed 0",
        2,
        &["--guard-speed", "above 0"],
    );
    // The bound by acceleration, from flags and in the file.
    let by_hand = "simulate ball.toml --guard limit --guard-allowance 1e-5 --guard-acceleration 80";
    let (fewer, _) = guarded(by_hand);
    assert!(fewer < acted, "{fewer} {acted}");
    let guard = guard.replace("1e-5", "1e-5, acceleration_m_per_s2 = 80");
    folder.write("by-hand.toml", BALL.replace("[render]", &guard));
    assert_eq!(guarded("simulate by-hand.toml"), guarded(by_hand));
    assert!(guarded(&format!("{by_hand} --guard-recovery 0")).0 >= fewer);
    // The same acceleration by the force of the hand.
    let mass = "--guard-mass 0.125";
    let same = by_hand.replace("acceleration 80", &format!("hand-force 10 {mass}"));
    assert_eq!(guarded(&same), guarded(&format!("{by_hand} {mass}")));
    for (flags, words) in [
        ("--guard-hand-force 0", ["--guard-hand-force", "above 0"]),
        (
            "--guard-acceleration 0",
            ["--guard-acceleration", "above 0"],
        ),
        (
            "--guard-acceleration 80 --guard-mass 0",
            ["--guard-mass", "above 0"],
        ),
        ("--guard-recovery -1", ["--guard-recovery", "at least 0"]),
    ] {
        folder.fail(
            &format!("simulate ball.toml --guard limit {flags}"),
            2,
            &words,
        );
    }
    let inertia = "inertia_kg_m2 = [1e-4, 1e-4, 1e-4]\nmass_kg";
    folder.write("turning.toml", BALL.replacen("mass_kg", inertia, 1));
    folder.fail(
        "simulate turning.toml --guard limit --guard-acceleration 80",
        2,
        &["--guard-acceleration", "turning_acceleration_rad_per_s2"],
    );
    folder.fail(
        "simulate turning.toml --guard limit --guard-hand-force 8",
        2,
        &["--guard-hand-force", "hand_torque_n_m"],
    );
}
