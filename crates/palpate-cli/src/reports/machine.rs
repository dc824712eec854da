//! Real-time capabilities of this machine, with a test of a loop and a watchdog process.

use std::fmt;
use std::io;
use std::process::Command;
use std::time::Duration;

use crate::reports::Measured;
#[cfg(unix)]
use palpate_drivers::prepared::trial::try_out;
use palpate_drivers::two_diy::ports;
use palpate_rt::realtime::{Answer, Finding, machine};
use palpate_rt::safety::SafetyParams;
use palpate_study::text::{digits, hanging};
use serde::Serialize;

use crate::reports::device_list::LATCH_WARNING;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate doctor 1";

/// Rate of the test loop `[Hz]`.
pub const RATE: f64 = 1000.0;
/// Duration of the test loop `[s]`.
pub const SECONDS: f64 = 2.0;

/// Real-time capabilities of a machine.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MachineReport {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    asked: Vec<AskedReport>,
    machine: Vec<FindingReport>,
    watchdog: TriedReport,
    devices: Vec<DeviceReport>,
    loop_at_1000_hz: Measured,
}

/// Test result of the watchdog process of a device that holds its last force.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct TriedReport {
    starts: bool,
    why_not: Option<String>,
    /// Whether the watchdog process has the highest real-time priority.
    first: bool,
    /// Silence of the loop after which it shall command zero force `[s]`.
    silence_s: f64,
    /// Delay of the zero-force command after that silence `[s]`.
    late_median_s: Option<f64>,
    late_longest_s: Option<f64>,
}

/// Number of watchdog tests.
const SILENCES: usize = 20;

impl TriedReport {
    /// Tests the watchdog process that `command` starts, at the rate of the test loop.
    fn tried(command: io::Result<Command>) -> Self {
        let period = Duration::from_secs_f64(1.0 / RATE);
        let limit = SafetyParams::default().stall_after(period);
        #[cfg(unix)]
        let tried = command
            .map_err(|error| error.to_string())
            .and_then(|command| try_out(command, limit, SILENCES))
            .map(|tried| (tried.is_first, tried.late));
        #[cfg(not(unix))]
        let _ = command;
        #[cfg(not(unix))]
        let tried = Err::<(bool, Vec<Duration>), _>("it needs Linux or macOS".to_owned());
        let seconds = |late: Option<&Duration>| late.map(Duration::as_secs_f64);
        let (why_not, first, late) = match tried {
            Ok((first, late)) => (None, first, late),
            Err(why) => (Some(why), false, Vec::new()),
        };
        Self {
            starts: why_not.is_none(),
            why_not,
            first,
            silence_s: limit.as_secs_f64(),
            late_median_s: seconds(late.get(late.len() / 2)),
            late_longest_s: seconds(late.last()),
        }
    }
}

impl fmt::Display for TriedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(why) = &self.why_not {
            writeln!(f, "  NO  it does not start: {why}")?;
            return writeln!(
                f,
                "      a device that holds its last force runs with --watchdog off only"
            );
        }
        if self.first {
            writeln!(f, "  ok  it starts; SCHED_FIFO, priority 99: granted")?;
        } else {
            writeln!(f, "   ?  it starts; SCHED_FIFO, priority 99: refused")?;
            writeln!(f, "      a busy machine may make it late")?;
        }
        if let (Some(median), Some(longest)) = (self.late_median_s, self.late_longest_s) {
            writeln!(
                f,
                "      {SILENCES} silences of {} ms: zero force {} ms later at the median, {} at most",
                digits(1e3 * self.silence_s),
                digits(1e3 * median),
                digits(1e3 * longest)
            )?;
        }
        Ok(())
    }
}

/// A plugged-in device with advice for its user.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct DeviceReport {
    port: String,
    description: String,
    warning: &'static str,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct AskedReport {
    asked: String,
    granted: bool,
    why_not: Option<String>,
    remedy: Option<&'static str>,
}

impl MachineReport {
    /// Creates the report of a machine from its `answers` to the requests of a loop and from a loop `measured` at
    /// [`RATE`] for [`SECONDS`]. `watchdog` is the command of the watchdog process; it is started and tested.
    #[must_use]
    pub fn new(answers: &[Answer], measured: Measured, watchdog: io::Result<Command>) -> Self {
        let watchdog = TriedReport::tried(watchdog);
        let plugged_in = ports()
            .unwrap_or_default()
            .iter()
            .filter(|port| port.guess.is_likely())
            .map(|port| DeviceReport {
                port: port.path.clone(),
                description: port.description.clone(),
                warning: LATCH_WARNING,
            })
            .collect();
        Self {
            format: FORMAT,
            asked: answers.iter().map(AskedReport::from).collect(),
            machine: machine().iter().map(FindingReport::from).collect(),
            watchdog,
            devices: plugged_in,
            loop_at_1000_hz: measured,
        }
    }
}

impl From<&Answer> for AskedReport {
    fn from(answer: &Answer) -> Self {
        Self {
            asked: answer.asked.clone(),
            granted: answer.is_granted(),
            why_not: answer.outcome.clone().err(),
            remedy: (!answer.is_granted()).then_some(answer.remedy),
        }
    }
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct FindingReport {
    what: &'static str,
    found: String,
    advice: Option<&'static str>,
}

impl From<&Finding> for FindingReport {
    fn from(finding: &Finding) -> Self {
        Self {
            what: finding.what,
            found: finding.found.clone(),
            advice: finding.advice,
        }
    }
}

impl fmt::Display for MachineReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        self.write(&mut text)?;
        let mut lines = text.lines();
        lines.try_for_each(|line| writeln!(f, "{}", hanging(line, 6)))
    }
}

impl MachineReport {
    /// Writes the whole report, without line wrapping.
    fn write(&self, f: &mut impl fmt::Write) -> fmt::Result {
        writeln!(f, "Real-time requests of a loop")?;
        for asked in &self.asked {
            match (&asked.why_not, asked.remedy) {
                (None, _) => writeln!(f, "  ok  {}: granted and verified", asked.asked)?,
                (Some(why), remedy) => {
                    writeln!(f, "  NO  {}: {why}", asked.asked)?;
                    if let Some(remedy) = remedy {
                        writeln!(f, "      {remedy}")?;
                    }
                }
            }
        }
        if self.asked.is_empty() {
            writeln!(f, "      none")?;
        }
        writeln!(f, "\nThis machine")?;
        for finding in &self.machine {
            let mark = if finding.advice.is_some() { "?" } else { "ok" };
            writeln!(f, "  {mark:<2}  {}: {}", finding.what, finding.found)?;
            if let Some(advice) = finding.advice {
                writeln!(f, "      {advice}")?;
            }
        }
        writeln!(f, "\nThe watchdog of a device that holds its last force")?;
        write!(f, "{}", self.watchdog)?;
        for device in &self.devices {
            writeln!(
                f,
                "\n{}, {}, may be a Haply 2DIY",
                device.port, device.description
            )?;
            writeln!(f, "   ?  {}", device.warning)?;
        }
        writeln!(
            f,
            "\nA loop at {RATE} Hz for {SECONDS} s, with these requests"
        )?;
        write!(f, "{}", self.loop_at_1000_hz)
    }
}
