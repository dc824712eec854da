//! Runs programs of the firmware by QEMU.

use std::fmt;
use std::path::PathBuf;
use std::process::Command;

/// A core, and its board in QEMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Core {
    /// Name by its manufacturer.
    pub name: &'static str,
    machine: &'static str,
    target: &'static str,
}

/// Cortex-M4F, with a single-precision floating-point unit.
pub const M4F: Core = Core {
    name: "Cortex-M4F",
    machine: "mps2-an386",
    target: "thumbv7em-none-eabihf",
};
/// The same program on a Cortex-M7.
pub const M7: Core = Core {
    name: "Cortex-M7",
    machine: "mps2-an500",
    target: "thumbv7em-none-eabihf",
};
/// Cortex-M3, without a floating-point unit.
pub const M3: Core = Core {
    name: "Cortex-M3",
    machine: "mps2-an385",
    target: "thumbv7m-none-eabi",
};
/// All three cores.
pub const CORES: [Core; 3] = [M4F, M7, M3];

/// Returns the cores to test: all three, or the one in the variable `PALPATE_FIRMWARE_CORE`.
///
/// # Panics
/// Panics if the variable names none of them.
#[must_use]
pub fn cores() -> Vec<Core> {
    let Ok(only) = std::env::var("PALPATE_FIRMWARE_CORE") else {
        return CORES.to_vec();
    };
    let core = CORES.into_iter().find(|core| core.name == only);
    vec![
        core.unwrap_or_else(|| {
            panic!("PALPATE_FIRMWARE_CORE is {only}, which is none of {CORES:?}")
        }),
    ]
}

/// Clock of the emulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// As fast as possible.
    Free,
    /// Every instruction takes 256 ns, as the program `count` requires.
    Counted,
    /// Every instruction takes 8 ns: a core with 125 million instructions per second.
    Real,
}

/// Failure of a program.
#[derive(Debug)]
pub enum QemuError {
    /// The folder of the programs is unknown.
    NoPrograms,
    /// QEMU could not be started.
    NotStarted(std::io::Error),
    /// The program did not end with 0.
    Failed {
        /// Its name and core.
        what: String,
        /// The end of its output.
        said: String,
    },
}

impl fmt::Display for QemuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPrograms => f.write_str(
                "PALPATE_FIRMWARE does not say where the programs lie: firmware/run builds them and sets it",
            ),
            Self::NotStarted(error) => write!(f, "qemu-system-arm could not be started: {error}"),
            Self::Failed { what, said } => write!(f, "{what} has failed:\n{said}"),
        }
    }
}

impl std::error::Error for QemuError {}

impl Core {
    /// Returns the path of the program `name`.
    ///
    /// # Errors
    /// [`QemuError::NoPrograms`].
    pub fn program(&self, name: &str) -> Result<PathBuf, QemuError> {
        let programs = std::env::var_os("PALPATE_FIRMWARE").ok_or(QemuError::NoPrograms)?;
        Ok(PathBuf::from(programs).join(self.target).join(name))
    }

    /// Runs the program `name` and returns its output. `words` are written to the addresses of the emulated world's
    /// pins.
    ///
    /// # Errors
    /// There is no program or no QEMU, or the program did not end with 0 within a minute.
    pub fn run(&self, name: &str, time: Time, words: &[(u32, u32)]) -> Result<String, QemuError> {
        let mut command = Command::new("timeout");
        command
            .args(["60", "qemu-system-arm", "-machine", self.machine])
            .args(["-display", "none", "-monitor", "none", "-serial", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .arg("-kernel")
            .arg(self.program(name)?);
        for (address, word) in words {
            let loader = format!("loader,addr={address:#x},data={word},data-len=4");
            command.args(["-device", &loader]);
        }
        match time {
            Time::Free => {}
            Time::Counted => drop(command.args(["-icount", "shift=8,sleep=off"])),
            Time::Real => drop(command.args(["-icount", "shift=3,sleep=off"])),
        }
        let output = command.output().map_err(QemuError::NotStarted)?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        if output.status.success() {
            return Ok(said);
        }
        let complaint = String::from_utf8_lossy(&output.stderr);
        let end: Vec<&str> = said.lines().rev().take(3).collect();
        Err(QemuError::Failed {
            what: format!("{name} on {} ({})", self.name, output.status),
            said: format!("{complaint}\n{}", end.join("\n")),
        })
    }
}
