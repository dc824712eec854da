//! What several test programs share: the committed scenes, reproducible random numbers, and hand
//! motion, recorded or made up.
#![allow(dead_code, reason = "each test program uses its own part")]

use std::io::Write;
use std::path::{Path, PathBuf};

use palpate_core::{Actuation, Contact, LoopParams, ObjectState};
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::world::{Coupling, WorldScene, WorldSettings};
use palpate_scene::{ContactFile, Scene, beside};
use palpate_study::sim::replay::{Replay, ReplaySetup};
use palpate_testbed::metrics::Fidelity;

/// The paper's scenes, in the order of tables.
pub const PAPER_SCENES: [&str; 3] = ["fig2", "experiment1", "experiment2"];

/// Folder of the committed scenes.
pub fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments")
}

/// A scene of `experiments/`.
pub fn scene(name: &str) -> Scene {
    let path = experiments().join(name).with_extension("toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    match ContactFile::parse_with(name, &text, &mut beside(&path)) {
        Ok(file) => file.scene,
        Err(error) => panic!("{error}"),
    }
}

/// The scene with these settings for `method`, and no others for it.
pub fn with(mut scene: Scene, method: MethodName, settings: Settings) -> Scene {
    scene.settings.insert(method, settings);
    scene
}

/// A damping `[N s/m]` of the virtual damper or of HFCR.
pub fn damping(value: f64) -> Settings {
    Settings::default().with(SettingKey::DAMPING, value)
}

/// A cap `[N s/m]` of a passivity controller.
pub fn cap(value: f64) -> Settings {
    Settings::default().with(SettingKey::DAMPING_CAP, value)
}

/// The bench's verdict on a closed loop.
pub fn fidelity(scene: &Scene, method: MethodName) -> Fidelity {
    let bench = palpate_study::sim::closed_loop::Bench::new(scene).unwrap();
    bench.run(method).unwrap().force.fidelity.unwrap()
}

/// splitmix64: random numbers that are the same everywhere and for ever.
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Even over `[from, to)`.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Even over the decades of `[from, to)`.
    pub fn decades(&mut self, from: f64, to: f64) -> f64 {
        self.between(from.ln(), to.ln()).exp()
    }

    /// True once in `n`.
    pub fn once_in(&mut self, n: u64) -> bool {
        self.bits().is_multiple_of(n)
    }
}

/// A motion: time stamps `[s]` and positions `[m]`.
pub struct Trajectory {
    pub name: String,
    pub times: Vec<f64>,
    pub positions: Vec<f64>,
}

/// A hand made up of a few sines, 4 s at 2 kHz, about 2 cm of travel: smooth, and never exactly
/// periodic.
pub fn synthetic_hand(number: u32) -> Trajectory {
    let shift = f64::from(number);
    let position = |t: f64| {
        0.010 * (std::f64::consts::TAU * (1.1 + 0.13 * shift) * t + shift).sin()
            + 0.004 * (std::f64::consts::TAU * (2.7 - 0.11 * shift) * t + 0.7 * shift).cos()
            + 0.001 * (std::f64::consts::TAU * 7.3 * t).sin()
    };
    let times: Vec<f64> = (0..=8000).map(|i| f64::from(i) / 2000.0).collect();
    Trajectory {
        name: format!("synthetic_{number}"),
        positions: times.iter().map(|&t| position(t)).collect(),
        times,
    }
}

/// A hand taps under an object of 0.1 kg and 400 N/m that begins at rest 60 % up the hand's way,
/// and weighs on it.
pub fn lifted_object(hand: &Trajectory, period: f64, unilateral: bool) -> Replay {
    let mut sorted = hand.positions.clone();
    sorted.sort_by(f64::total_cmp);
    let setup = ReplaySetup {
        contact: Contact {
            unilateral,
            ..Contact::object(400.0, 0.1)
        },
        loop_params: LoopParams::new(period),
        object: ObjectState::at_rest(sorted[sorted.len() * 6 / 10]),
        virtual_force: -0.981,
        actuation: Actuation::default(),
        device_mass: None,
        encoder_quantum: 0.0,
    };
    Replay::new(setup, &hand.times, &hand.positions).unwrap()
}

/// Returns recordings of free hand motion, 2 kHz, if this machine has them beside the repository. Otherwise prints a
/// note to standard error, past the test runner's capture; the caller then checks less.
pub fn recorded_hands(caller: &str) -> Vec<Trajectory> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/human");
    if !folder.is_dir() {
        let missing = folder.display();
        let note = format!("NOT RUN: {caller}, on recordings: there is no folder {missing}\n");
        std::io::stderr().write_all(note.as_bytes()).unwrap();
        return Vec::new();
    }
    ["a", "b", "c", "d", "e", "f"]
        .map(|letter| {
            let name = format!("tap_{letter}_free_motion");
            let path = folder.join(&name).with_extension("csv");
            let file = std::fs::File::open(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
            let trace = palpate_record::trace::read(file, &name).unwrap_or_else(|e| panic!("{e}"));
            Trajectory {
                name,
                times: trace.t_s,
                positions: trace.position_m,
            }
        })
        .into()
}

/// Sets the settings of the methods for comparison.
pub fn set_comparison(scene: &mut WorldScene) {
    let settings = WorldSettings {
        damping: Some(4.0),
        coupling: Coupling {
            stiffness: Some(4000.0),
            mass: Some(0.05),
            ..Coupling::default()
        },
        ..WorldSettings::default()
    };
    scene.render.settings = WorldScene::METHODS
        .into_iter()
        .map(|method| (method, settings))
        .collect();
}
