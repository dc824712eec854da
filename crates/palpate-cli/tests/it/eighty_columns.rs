//! The output of studies fits a terminal of 80 columns, and a legend below the tables explains their columns.

use crate::common::Folder;

/// The lines of a text that are too long.
fn too_long(text: &str) -> Vec<&str> {
    let long = |line: &&str| line.chars().count() > 80;
    text.lines().filter(long).collect()
}

/// Checks that the text fits, and that it explains each of these terms once.
fn assert_fits(text: &str, explained: &[&str]) {
    assert_eq!(too_long(text), [""; 0], "in:\n{text}");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for term in explained {
        assert_eq!(words.matches(term).count(), 1, "{term:?} in:\n{text}");
    }
}

const E: &str = "E: error of the mean force";
const FRE: &str = "FRE: error of the held force";
const LEAK: &str = "|leak|: energy that the held force";

/// The scenes of these folders of `experiments`, by their paths.
fn scenes(folders: &[&str]) -> Vec<String> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
    let mut scenes = Vec::new();
    for folder in folders {
        for entry in std::fs::read_dir(format!("{root}{folder}")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|it| it == "toml") {
                scenes.push(path.display().to_string());
            }
        }
    }
    scenes.sort();
    assert!(scenes.len() > 9, "{scenes:?}");
    scenes
}

#[test]
fn compare() {
    let folder = Folder::new();
    let text = folder.succeed(&format!("compare {}", scenes(&["", "/users"]).join(" ")));
    assert_fits(&text, &[E, FRE, LEAK]);
    // Some notes on a method do not fit beside its numbers.
    assert!(
        text.lines()
            .any(|line| line.starts_with("     ") && line.contains("left the safety box")),
        "{text}"
    );
}

#[test]
fn demo() {
    assert_fits(&Folder::new().succeed("demo"), &["Next steps"]);
}

#[test]
fn simulate() {
    let folder = Folder::new();
    // A table whose last column does not fit beside the others, and devices that leave their box.
    for (scene, flags) in [
        ("fig2", "--method all"),
        ("fig5_box", "--method all"),
        ("experiment1_in_a_hand", ""),
        ("worlds/pinch", "--method all"),
    ] {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
        let text = folder.succeed(&format!("simulate {root}/{scene}.toml {flags}"));
        assert_fits(&text, &["E: error of the mean force", FRE]);
    }
}

#[test]
fn a_loop_and_its_machine() {
    let folder = Folder::new();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/live.toml");
    assert_fits(&folder.succeed("devices"), &[]);
    assert_fits(
        &folder.palpate("doctor").stdout,
        &["Real-time requests of a loop"],
    );
    let ran = folder.palpate(&format!("run {scene} --duration 0.2 --fast"));
    // A loaded machine misses ticks.
    assert!([0, 4].contains(&ran.code), "{ran:?}");
    assert_fits(&ran.stdout, &[]);
    assert!(!ran.stdout.is_empty());
}

#[test]
fn tune() {
    let folder = Folder::new();
    for scene in ["fig2", "fig2_long", "live", "wall"] {
        let scene = format!(
            "{}/../../experiments/{scene}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        for method in ["virtual-damper", "hfcr", "popc", "popc-ref"] {
            let asked = format!("tune {scene} --method {method} --steps 2");
            assert_fits(&folder.succeed(&asked), &[E, LEAK]);
        }
    }
}

#[test]
fn sweep() {
    let folder = Folder::new();
    let asked = |scene: &str| {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
        format!("sweep {root}/{scene}.toml --over friction --method all")
    };
    for scene in ["fig4", "fig5", "fig5_box", "experiment1_in_a_hand"] {
        let text = folder.succeed(&format!("{} --values 0.5,2", asked(scene)));
        assert_fits(&text, &[FRE, LEAK]);
    }
    let heights = format!("{} --values 1 --heights", asked("experiment1_in_a_hand"));
    assert_fits(&folder.succeed(&heights), &[FRE, LEAK]);
}

#[test]
fn advise() {
    let folder = Folder::new();
    let device = "advise --device-mass 0.3 --period 0.01";
    for contact in [
        "--stiffness 1234567 --mass 0.0123",
        "--stiffness 1000 --coulomb-friction 0.2 --viscous-friction 0.05 --encoder-quantum 1e-5",
    ] {
        assert_fits(&folder.succeed(&format!("{device} {contact}")), &[E]);
    }
}

#[test]
fn map() {
    let folder = Folder::new();
    let asked = "map --cells 2 --encoder-quantum 1e-5 --delay-periods 1 --out m.csv";
    assert_fits(&folder.succeed(asked), &[E]);
}

#[test]
fn suite() {
    let folder = Folder::new();
    let text = folder.succeed("suite --plants 2 --method all");
    assert_fits(&text, &[E, FRE]);
    let worlds = folder.succeed("suite --set worlds --plants 3");
    assert_fits(
        &worlds,
        &[
            "E: error of the mean force",
            "Best: with the setting of the least E",
        ],
    );
}

#[test]
fn report() {
    let folder = Folder::new();
    folder.write(
        "device.toml",
        "calibration_format = 1\nperiod_s = 0.01\ndevice_mass_kg = 0.25\ndelay_s = 0.00412345\n\
         coulomb_friction_n = 0.05\nsensor_quantum_m = 1e-5\n",
    );
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/wall.toml");
    let recorded = format!("run {scene} --record tap.mcap --duration 0.3 --fast --period 0.005");
    assert_eq!(folder.palpate(&recorded).code, 0);
    let text =
        folder.succeed("report tap.mcap --device-file device.toml --method basic --out p.html");
    assert_fits(&text, &[]);
    for words in [
        "stiffest wall",
        "hold bound",
        "warning: modelled delay",
        "not checked:",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}
