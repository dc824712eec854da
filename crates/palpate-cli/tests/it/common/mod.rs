//! Shared code of the test programs: a working folder, the program, and readers of its answers.
#![allow(dead_code, reason = "each test program uses its own part")]

pub mod running;
pub mod schema;

use std::path::{Path, PathBuf};

use palpate_core::{
    AnyParams, CoupledParams, EnergyCorrectedParams, EnergyTankParams, ForceBoundingParams,
    HfcrParams, PmiParams, PopcParams, PopcRefParams, SehParams, VirtualCouplingParams,
    VirtualDamperParams,
};
use serde_json::Value;

/// Every method, in the order of tables.
pub const METHODS: [&str; 14] = [
    "basic",
    "seh",
    "virtual-damper",
    "popc",
    "popc-ref",
    "energy-corrected",
    "force-bounding",
    "pmi",
    "energy-tank",
    "virtual-coupling",
    "hfcr-mod",
    "hfcr-mod-st",
    "hfcr",
    "coupled",
];

/// A separate folder for each test, deleted when the test ends.
pub struct Folder(tempfile::TempDir);

/// Joins the lines of a text that was wrapped to 80 columns.
pub fn in_a_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Output of a run of the program.
#[derive(Debug)]
pub struct Answer {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Folder {
    /// An empty folder.
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// Path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file into it.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.path(name), content).unwrap();
        self
    }

    /// Returns the contents of a file.
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of everything in it, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Runs the program in it, with arguments separated by blanks.
    pub fn palpate(&self, arguments: &str) -> Answer {
        self.palpate_reading("", arguments)
    }

    /// Runs the program with text on standard input.
    pub fn palpate_reading(&self, input: impl AsRef<[u8]>, arguments: &str) -> Answer {
        let output = assert_cmd::Command::cargo_bin("palpate")
            .unwrap()
            .current_dir(self.0.path())
            .args(arguments.split_whitespace())
            .write_stdin(input.as_ref())
            .timeout(std::time::Duration::from_secs(600))
            .output()
            .unwrap();
        Answer {
            code: output.status.code().expect("ended by itself"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the program, which must succeed without messages on standard error.
    pub fn succeed(&self, arguments: &str) -> String {
        let answer = self.palpate(arguments);
        assert_eq!(answer.code, 0, "palpate {arguments}: {answer:?}");
        // On a busy machine the program may print progress lines.
        let mut said = answer.stderr.lines();
        let said = said.find(|line| !line.starts_with("progress: "));
        assert_eq!(said, None, "palpate {arguments}");
        answer.stdout
    }

    /// Runs the program with `--json`, which must succeed. Returns its report, checked against its schema.
    pub fn json(&self, arguments: &str) -> Value {
        let report = parse(&self.succeed(&format!("{arguments} --json")));
        schema::check(&report);
        report
    }

    /// Runs the program with `--json` on a recording of a real-time loop: standard error may report missed ticks.
    pub fn json_of_a_loop(&self, arguments: &str) -> Value {
        let answer = self.palpate(&format!("{arguments} --json"));
        // 4 if the recorder lost ticks.
        assert!(
            matches!(answer.code, 0 | 4),
            "palpate {arguments}: {answer:?}"
        );
        let report = parse(&answer.stdout);
        schema::check(&report);
        report
    }

    /// Runs the program, which must fail with exit code `code` and print every one of `words`.
    pub fn fail(&self, arguments: &str, code: i32, words: &[&str]) {
        self.palpate(arguments).failed(arguments, code, words);
    }

    /// A run file in it.
    pub fn run_file(&self, name: &str) -> palpate_record::run::Run {
        palpate_record::run::read(std::fs::File::open(self.path(name)).unwrap(), name).unwrap()
    }
}

impl Answer {
    /// Checks a failure: its exit code, and that every one of `words` is printed, with nothing but warnings before it.
    pub fn failed(&self, what: &str, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{what}: {self:?}");
        assert_eq!(self.stdout, "", "{what}");
        let mut lines = self.stderr.lines();
        let first = lines.find(|line| !line.starts_with("warning: "));
        let is_error = first.is_some_and(|line| line.starts_with("error: "));
        assert!(is_error, "{what}: {self:?}");
        for word in words {
            assert!(
                self.stderr.contains(word),
                "{what}: no {word:?} in:\n{}",
                self.stderr
            );
        }
    }
}

/// Text that must be JSON.
pub fn parse(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}:\n{text}"))
}

/// The report's entry of a method.
pub fn of_method<'a>(report: &'a Value, method: &str) -> &'a Value {
    report["methods"]
        .as_array()
        .unwrap()
        .iter()
        .find(|entry| entry["method"] == method)
        .unwrap_or_else(|| panic!("no {method} in {report}"))
}

/// A number of a report.
pub fn number(value: &Value, field: &str) -> f64 {
    value[field]
        .as_f64()
        .unwrap_or_else(|| panic!("no number {field} in {value}"))
}

/// Returns arguments of `pipe`, without a limit or a soft start unless they contain one.
pub fn unlimited(arguments: &str) -> String {
    let limits = [("--force-limit", "inf"), ("--soft-start", "0")];
    let missing = limits.iter().filter(|(flag, _)| !arguments.contains(flag));
    missing.fold(arguments.to_owned(), |all, (flag, value)| {
        format!("{all} {flag} {value}")
    })
}

/// A committed scene.
pub fn experiment(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments")
        .join(name)
        .with_extension("toml")
}

/// Text of a committed scene.
pub fn experiment_text(name: &str) -> String {
    std::fs::read_to_string(experiment(name)).unwrap()
}

/// A press into the object and back, twice, never at rest: positions `[m]` at multiples of
/// `step` `[s]`, for `seconds`.
pub fn taps(step: f64, seconds: f64) -> Vec<(f64, f64)> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few thousand"
    )]
    let samples = (seconds / step).round() as u32;
    (0..=samples)
        .map(|i| {
            let t = f64::from(i) * step;
            (
                t,
                -0.004 + 0.02 * (9.0 * t).sin() + 0.001 * (31.0 * t).cos(),
            )
        })
        .collect()
}

/// Formats the samples as a trace file.
pub fn trace_text(samples: &[(f64, f64)]) -> String {
    let mut text = String::from("t_s,position_m\n");
    for (t, x) in samples {
        text.push_str(&format!("{t},{x}\n"));
    }
    text
}

/// Returns the default parameters of `--help`, for a device that starts out of contact with an object at rest.
pub fn default_params(
    method: &str,
    stiffness: f64,
    period: f64,
    device_mass: f64,
) -> AnyParams<f64> {
    let cap = 3.0 * (stiffness * period);
    match method {
        "basic" => AnyParams::Basic,
        "seh" => AnyParams::Seh(SehParams::default()),
        "virtual-damper" => {
            AnyParams::VirtualDamper(VirtualDamperParams::new(0.5 * (stiffness * period)))
        }
        "popc" => AnyParams::Popc(PopcParams::new(cap)),
        "popc-ref" => AnyParams::PopcRef(PopcRefParams::new(cap)),
        "energy-corrected" => AnyParams::EnergyCorrected(EnergyCorrectedParams {}),
        "force-bounding" => AnyParams::ForceBounding(ForceBoundingParams {
            device_damping: 0.5 * (stiffness * period),
        }),
        "pmi" => AnyParams::Pmi(PmiParams::default()),
        "energy-tank" => AnyParams::EnergyTank(EnergyTankParams {
            damping: stiffness * period,
            damping_cap: cap,
            initial_energy: 0.0,
            desired_energy: 0.1,
        }),
        "virtual-coupling" => AnyParams::VirtualCoupling(VirtualCouplingParams {
            damping: stiffness * period,
            stiffness,
            mass: stiffness * period * period,
        }),
        "hfcr-mod" => AnyParams::Hfcr(HfcrParams::modified_force_only()),
        "hfcr-mod-st" | "hfcr" => AnyParams::Hfcr(HfcrParams::default()),
        "coupled" => AnyParams::Coupled(CoupledParams::new(device_mass)),
        other => panic!("no method {other}"),
    }
}
