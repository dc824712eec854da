//! `palpate doctor`: what this machine grants a loop.

use std::fmt;
use std::io;
use std::time::Duration;

use clap::Args;
use palpate_device::clock::MonotonicClock;
#[cfg(unix)]
use palpate_devices::trial::try_out;
use palpate_rt::realtime::{Answer, Finding, machine};
use palpate_rt::safety::SafetyParams;
use serde::Serialize;

use super::bench::{Measured, measure};
use super::run::{RealtimeArguments, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print_report;
use crate::values::duration;
use palpate_study::text::digits;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate doctor 1";

/// Rate of the loop that is tried [Hz].
const RATE: f64 = 1000.0;
/// For how long [s].
const SECONDS: f64 = 2.0;

/// Arguments of `doctor`.
#[derive(Args, Debug)]
pub struct DoctorArguments {
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// What is asked for.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
}

/// Asks the machine, and tries a loop.
pub fn run(arguments: &DoctorArguments) -> Result<(), Failure> {
    let progress = Progress::new(1);
    progress.begin("asking the machine, trying a loop");
    let request = request(&arguments.realtime);
    // On a thread of its own: what is granted stays with the thread that asked.
    let answers = std::thread::Builder::new()
        .spawn(move || request.ask())
        .and_then(|thread| thread.join().map_err(|_| io::Error::other("it panicked")))
        .map_err(|error| Failure::System(format!("a thread to ask with: {error}")))?;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    let measured = measure(&clock, request, RATE, SECONDS)?;
    let guardian = GuardianReport::tried();
    drop(progress);
    let plugged_in = palpate_haply::two_diy::ports()
        .unwrap_or_default()
        .iter()
        .filter(|port| port.guess.is_likely())
        .map(|port| DeviceReport {
            port: port.path.clone(),
            description: port.description.clone(),
            warning: super::devices::LATCH_WARNING,
        })
        .collect();
    let report = Report {
        format: FORMAT,
        asked: answers.iter().map(AskedReport::from).collect(),
        machine: machine().iter().map(FindingReport::from).collect(),
        guardian,
        devices: plugged_in,
        loop_at_1000_hz: measured,
    };
    print_report(&report, arguments.json)
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Report {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    asked: Vec<AskedReport>,
    machine: Vec<FindingReport>,
    guardian: GuardianReport,
    devices: Vec<DeviceReport>,
    loop_at_1000_hz: Measured,
}

/// How the guardian of a device that holds its last force does here.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct GuardianReport {
    starts: bool,
    why_not: Option<String>,
    /// Whether it is served before everybody else.
    first: bool,
    /// Silence of the loop that it was told to wait for `[s]`.
    silence_s: f64,
    /// How long after that no force was commanded `[s]`.
    late_median_s: Option<f64>,
    late_longest_s: Option<f64>,
}

/// How often a guardian is tried.
const SILENCES: usize = 20;

impl GuardianReport {
    /// At the rate of the loop that is tried.
    fn tried() -> Self {
        let period = Duration::from_secs_f64(1.0 / RATE);
        let limit = SafetyParams::default().stall_after(period);
        #[cfg(unix)]
        let tried = crate::devices::guarding::command()
            .map_err(|error| error.to_string())
            .and_then(|command| try_out(command, limit, SILENCES))
            .map(|tried| (tried.is_first, tried.late));
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

impl fmt::Display for GuardianReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(why) = &self.why_not {
            writeln!(f, "  NO  it does not start: {why}")?;
            return writeln!(
                f,
                "      a device that holds its last force runs with --guardian off only"
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
                "      {SILENCES} silences of {} ms: no force {} ms later at the median, {} at most",
                digits(1e3 * self.silence_s),
                digits(1e3 * median),
                digits(1e3 * longest)
            )?;
        }
        Ok(())
    }
}

/// A device that is plugged in and has something to be minded.
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

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "What a loop asks for")?;
        for asked in &self.asked {
            match (&asked.why_not, asked.remedy) {
                (None, _) => writeln!(f, "  ok  {}: granted, and looked up", asked.asked)?,
                (Some(why), remedy) => {
                    writeln!(f, "  NO  {}: {why}", asked.asked)?;
                    if let Some(remedy) = remedy {
                        writeln!(f, "      {remedy}")?;
                    }
                }
            }
        }
        if self.asked.is_empty() {
            writeln!(f, "      nothing")?;
        }
        writeln!(f, "\nThis machine")?;
        for finding in &self.machine {
            let mark = if finding.advice.is_some() { "?" } else { "ok" };
            writeln!(f, "  {mark:<2}  {}: {}", finding.what, finding.found)?;
            if let Some(advice) = finding.advice {
                writeln!(f, "      {advice}")?;
            }
        }
        writeln!(f, "\nThe guardian of a device that holds its last force")?;
        write!(f, "{}", self.guardian)?;
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
            "\nA loop at {RATE} Hz for {SECONDS} s, as asked for above"
        )?;
        write!(f, "{}", self.loop_at_1000_hz)
    }
}
