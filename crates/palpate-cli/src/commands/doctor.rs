//! `palpate doctor`: what this machine grants a loop.

use std::fmt;
use std::io;

use clap::Args;
use palpate_rt::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Finding, machine};
use serde::Serialize;

use super::bench::{Measured, measure};
use super::run::{RealtimeArguments, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print;
use crate::values::duration;

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
        format: "palpate doctor 1",
        asked: answers.iter().map(AskedReport::from).collect(),
        machine: machine().iter().map(FindingReport::from).collect(),
        devices: plugged_in,
        loop_at_1000_hz: measured,
    };
    print(&if arguments.json {
        serde_json::to_string_pretty(&report).expect("a report has string keys only") + "\n"
    } else {
        report.to_string()
    })
}

#[derive(Debug, Serialize)]
struct Report {
    format: &'static str,
    asked: Vec<AskedReport>,
    machine: Vec<FindingReport>,
    devices: Vec<DeviceReport>,
    loop_at_1000_hz: Measured,
}

/// A device that is plugged in and has something to be minded.
#[derive(Debug, Serialize)]
struct DeviceReport {
    port: String,
    description: String,
    warning: &'static str,
}

#[derive(Debug, Serialize)]
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
