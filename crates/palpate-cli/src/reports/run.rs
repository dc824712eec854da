//! Report on a real-time loop.

use std::fmt;
use std::time::Duration;

use comfy_table::CellAlignment;
use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Device};
use palpate_record::recording::{Event, LoopTime, Recording};
use palpate_rt::realtime::Answer;
use palpate_rt::safety::SafetyStop;
use palpate_rt::{Account, Durations, LoopEnd, LoopStatistics, RenderedWorld, Renders};
use palpate_world::EnergyLedger;
use serde::Serialize;

use palpate_study::recording::{in_a_line, motors_off, refused};
use palpate_study::text::{counted, digits, hanging, lines, number, plain_table};

use crate::reports::{ConnectionReport, WatchdogReport, if_as_modelled};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate run 1";

/// Number of events in the text; JSON and recordings contain more.
const SHOWN: usize = 8;

/// Report on a run, as text and as JSON.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RunReport {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    title: String,
    method: &'static str,
    device: String,
    period_s: f64,
    ending: &'static str,
    /// Real-time requests and the answers of the machine.
    realtime: Vec<AnswerReport>,
    timing: TimingReport,
    /// Safety stop that keeps the force at zero at the end, if any.
    safety_stop: Option<&'static str>,
    #[serde(skip)]
    safety_stop_in_words: &'static str,
    #[serde(skip)]
    several: bool,
    /// World name of the device with the safety stop, if there are several devices.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped_device: Option<String>,
    supervisor_cuts: u64,
    /// Duration of the loop.
    lasted_s: f64,
    /// Part of that duration without a delivered force, stalls included.
    motors_off_s: f64,
    /// Number of ticks that ended with a safety stop.
    motors_off_ticks: u64,
    #[serde(skip)]
    time: LoopTime,
    /// Watchdog process of a device that holds its last force.
    watchdog: Option<WatchdogReport>,
    /// Connections to devices of other programs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    connections: Vec<ConnectionReport>,
    peak_force_n: f64,
    deepest_penetration_m: f64,
    /// Generated energy of the forces that the motors held, if the loop is as modelled (delay, lag, gain). Energy
    /// that passes while the motors are off counts as external work.
    leak_held_j: f64,
    /// Maximum generated energy up to any tick, if the loop is as modelled. A part that dissipates later is missing
    /// at the end.
    most_created_energy_j: f64,
    /// Whether the method compares the samples with the modelled timing.
    #[serde(skip)]
    checks_timing: bool,
    port_work_j: f64,
    outside_work_j: f64,
    events: Vec<EventReport>,
    all_events: u64,
    /// Number of ticks and events that the recorder lost.
    unsent: u64,
    unreported_ticks: u64,
    recording: Option<RecordingReport>,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct AnswerReport {
    asked: String,
    granted: bool,
    why_not: Option<String>,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct EventReport {
    tick: u64,
    t_s: f64,
    kind: String,
    text: String,
}

/// Content of the recording file, read back.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct RecordingReport {
    file: String,
    /// Whether the file is complete and contains as many ticks as the loop counted.
    complete: bool,
    finished: bool,
    ticks: u64,
    ticks_made: Option<u64>,
    ticks_lost: u64,
    events_lost: u64,
    bytes: u64,
    #[serde(skip)]
    in_a_line: String,
}

/// Timing of a loop.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TimingReport {
    ticks: u64,
    missed_deadlines: u64,
    without_sample: u64,
    /// Number of ticks whose sample the renderer rejected; they render no force.
    refused: u64,
    /// Number of ticks at which the renderer of a world ignored triangles or shell points for lack of room: the furthest.
    crowded: u64,
    lateness_s: Percentiles,
    tick_s: Percentiles,
    round_trip_s: Percentiles,
}

/// Percentiles of durations `[s]`.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Percentiles {
    median: f64,
    p99: f64,
    p999: f64,
    longest: f64,
}

impl From<&Durations> for Percentiles {
    fn from(durations: &Durations) -> Self {
        let at = |part| seconds(durations.quantile(part));
        Self {
            median: at(0.5),
            p99: at(0.99),
            p999: at(0.999),
            longest: seconds(durations.longest()),
        }
    }
}

fn seconds(duration: Duration) -> f64 {
    duration.as_secs_f64()
}

impl From<&LoopStatistics> for TimingReport {
    fn from(statistics: &LoopStatistics) -> Self {
        Self {
            ticks: statistics.ticks,
            missed_deadlines: statistics.missed_deadlines,
            without_sample: statistics.without_sample,
            refused: statistics.refused,
            crowded: statistics.crowded,
            lateness_s: (&statistics.lateness).into(),
            tick_s: (&statistics.tick).into(),
            round_trip_s: (&statistics.round_trip).into(),
        }
    }
}

/// Title, method and period of a run.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Title of the scene.
    pub title: &'a str,
    /// Name of the method.
    pub method: &'static str,
    /// Period of the loop `[s]`.
    pub period: f64,
}

/// Sums of a loop's energy ledger `[J]`.
#[derive(Clone, Copy, Debug)]
pub struct Energies {
    leak_held: f64,
    port_work: f64,
    outside_work: f64,
}

impl Energies {
    /// Returns the energies of a world, summed over its devices, contacts and bodies.
    #[must_use]
    pub fn of_world<D: Device, C: Clock>(
        end: &LoopEnd<D, C, RenderedWorld>,
        ledger: &EnergyLedger,
    ) -> Self {
        Self {
            leak_held: end.control.rendered().created_energy(),
            port_work: -ledger
                .devices
                .iter()
                .map(|entry| entry.port_work)
                .sum::<f64>(),
            outside_work: ledger.bodies.iter().map(|entry| entry.outside).sum(),
        }
    }
}

impl RunReport {
    /// Creates the report of a loop on `device` with this `end`; `recording` is its recording, read back.
    #[must_use]
    pub fn new<D: Device, C: Clock, R: Renders>(
        subject: Subject<'_>,
        device: &Capabilities,
        end: &LoopEnd<D, C, R>,
        answers: &[Answer],
        account: &Account,
        recording: Option<&Recording>,
    ) -> Self {
        Self::of_devices(subject, &[device], &[""], end, answers, account, recording)
    }

    /// Creates the report of a loop on several `devices` with their `names` in its world.
    #[must_use]
    pub fn of_devices<D: Device, C: Clock, R: Renders>(
        subject: Subject<'_>,
        devices: &[&Capabilities],
        names: &[&str],
        end: &LoopEnd<D, C, R>,
        answers: &[Answer],
        account: &Account,
        recording: Option<&Recording>,
    ) -> Self {
        let several = devices.len() > 1;
        let named = devices.iter().zip(names).map(|(device, name)| {
            if several {
                format!("{name}: {}", device.name)
            } else {
                device.name.clone()
            }
        });
        let stopped = end.control.stopped_device().filter(|_| several);
        let last = account.last.unwrap_or_default().contact;
        Self {
            format: FORMAT,
            title: subject.title.to_owned(),
            method: subject.method,
            device: named.collect::<Vec<_>>().join(", "),
            period_s: subject.period,
            ending: end.ending.text(),
            realtime: answers
                .iter()
                .map(|answer| AnswerReport {
                    asked: answer.asked.clone(),
                    granted: answer.is_granted(),
                    why_not: answer.outcome.clone().err(),
                })
                .collect(),
            timing: (&end.statistics).into(),
            safety_stop: end.safety_stop.map(SafetyStop::name),
            safety_stop_in_words: safety_stop_in_words(end.safety_stop),
            several,
            stopped_device: stopped
                .and_then(|(device, _)| names.get(device))
                .map(|name| (*name).to_owned()),
            supervisor_cuts: end.cuts,
            lasted_s: seconds(end.statistics.time.lasted),
            motors_off_s: seconds(end.statistics.time.motors_off),
            motors_off_ticks: end.statistics.motors_off,
            time: end.statistics.time,
            watchdog: None,
            connections: connections(end, devices, names),
            peak_force_n: account.peak_force,
            deepest_penetration_m: account.deepest,
            leak_held_j: end.control.rendered().created_energy(),
            most_created_energy_j: account.most_created,
            checks_timing: end.control.rendered().checks_timing(),
            port_work_j: last.port_work,
            outside_work_j: last.outside_work,
            events: account.events.iter().map(event).collect(),
            all_events: account.events_made,
            unsent: account.lost_ticks() + account.lost_events(),
            unreported_ticks: account.lost_ticks(),
            recording: recording.map(|recording| RecordingReport {
                file: recording.path().display().to_string(),
                complete: recording.is_complete(),
                finished: recording.finished,
                ticks: recording.ticks,
                ticks_made: recording.ticks_made(),
                ticks_lost: recording.lost(),
                events_lost: recording.lost_events(),
                bytes: recording.bytes,
                in_a_line: in_a_line(recording),
            }),
        }
    }
}

impl RunReport {
    /// Replaces the energies of one contact by these energies.
    #[must_use]
    pub fn with_energies(self, energies: Energies) -> Self {
        Self {
            leak_held_j: energies.leak_held,
            port_work_j: energies.port_work,
            outside_work_j: energies.outside_work,
            ..self
        }
    }

    /// Sets the report on the device's watchdog process.
    #[must_use]
    pub fn guarded(self, watchdog: Option<WatchdogReport>) -> Self {
        Self { watchdog, ..self }
    }
}

/// Returns the reports on the connections of the devices that have one.
fn connections<D: Device, C: Clock, R: Renders>(
    end: &LoopEnd<D, C, R>,
    devices: &[&Capabilities],
    names: &[&str],
) -> Vec<ConnectionReport> {
    let is_one = devices.len() == 1;
    let driven = end.control.devices().zip(devices).zip(names);
    driven
        .filter_map(|((device, can), name)| {
            let name = if is_one { &can.name } else { *name };
            Some(ConnectionReport::new(name, &device.connection()?))
        })
        .collect()
}

/// Describes a safety stop that is active at the end.
fn safety_stop_in_words(safety_stop: Option<SafetyStop>) -> &'static str {
    match safety_stop {
        Some(SafetyStop::DeviceLost) => "the device was gone at the end",
        Some(safety_stop) if safety_stop.is_passing() => {
            "a temporary safety stop was active at the end"
        }
        _ => "safety stop until the end",
    }
}

fn event(event: &Event) -> EventReport {
    EventReport {
        tick: event.sequence,
        t_s: event.time,
        kind: event.kind.clone(),
        text: event.text.clone(),
    }
}

impl RunReport {
    /// Returns the clause about the time without force, which follows the end of the loop.
    fn but_no_force(&self) -> String {
        let (ticks, off, of_samples) = (
            self.timing.ticks,
            self.motors_off_ticks,
            self.timing.refused,
        );
        let words = [
            (of_samples > 0).then(|| refused(of_samples, ticks)),
            (off > 0).then(|| motors_off(Some(self.time), off, ticks)),
        ];
        let words: Vec<String> = words.into_iter().flatten().collect();
        if words.is_empty() {
            String::new()
        } else {
            format!(", but {}", words.join(", and "))
        }
    }

    /// Writes the whole report, without line wrapping.
    fn write(&self, f: &mut impl fmt::Write) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        writeln!(
            f,
            "{} on the {} `{}` at {} Hz; {}{}",
            self.method,
            if self.several { "devices" } else { "device" },
            self.device,
            digits(1.0 / self.period_s),
            self.ending,
            self.but_no_force()
        )?;
        for answer in &self.realtime {
            let outcome = match &answer.why_not {
                None => "granted".to_owned(),
                Some(why) => format!("refused: {why}"),
            };
            writeln!(f, "{}: {outcome}", answer.asked)?;
        }
        if let Some(watchdog) = &self.watchdog {
            writeln!(f, "{watchdog}")?;
        }
        for connection in &self.connections {
            writeln!(f, "{connection}")?;
        }
        writeln!(f, "\n{}", self.timing)?;
        writeln!(
            f,
            "force on the device up to {} N, penetration up to {} mm; held forces created {} mJ{}, at most {} mJ, {}",
            digits(self.peak_force_n),
            digits(1e3 * self.deepest_penetration_m),
            digits(1e3 * self.leak_held_j),
            if self.motors_off_ticks > 0 {
                " while the motors were on"
            } else {
                ""
            },
            digits(1e3 * self.most_created_energy_j),
            if_as_modelled(self.checks_timing)
        )?;
        if self.supervisor_cuts > 0 {
            let times = counted(self.supervisor_cuts, "time");
            writeln!(f, "the supervisor commanded zero force {times}")?;
        }
        if let Some(safety_stop) = self.safety_stop {
            let of = self.stopped_device.as_ref();
            let of = of.map_or_else(String::new, |name| format!(", by the device `{name}`"));
            writeln!(f, "{}: {safety_stop}{of}", self.safety_stop_in_words)?;
        }
        for event in self.events.iter().take(SHOWN) {
            writeln!(f, "  {:>10.4} s  {}: {}", event.t_s, event.kind, event.text)?;
        }
        let hidden = self.all_events - self.events.len().min(SHOWN) as u64;
        if hidden > 0 {
            writeln!(f, "  and {} more", counted(hidden, "event"))?;
        }
        if let Some(recording) = &self.recording {
            writeln!(f, "{}", recording.in_a_line)?;
        } else if self.unreported_ticks > 0 {
            writeln!(
                f,
                "{} lost: the listener was too slow",
                counted(self.unreported_ticks, "tick")
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for RunReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        self.write(&mut text)?;
        let mut lines = text.lines();
        lines.try_for_each(|line| writeln!(f, "{}", hanging(line, 2)))
    }
}

impl fmt::Display for TimingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}; {} missed; {} without a sample",
            counted(self.ticks, "tick"),
            counted(self.missed_deadlines, "deadline"),
            self.without_sample
        )?;
        if self.refused > 0 {
            write!(f, "; {} refused", self.refused)?;
        }
        if self.crowded > 0 {
            write!(f, "; {}", super::crowded(self.crowded, "tick"))?;
        }
        writeln!(f)?;
        let header = ["", "median [us]", "99 %", "99.9 %", "longest"];
        let mut table = plain_table(CellAlignment::Left, &header);
        for (name, of) in [
            ("woken late by", self.lateness_s),
            ("device's answer", self.round_trip_s),
            ("tick", self.tick_s),
        ] {
            let mut row = vec![comfy_table::Cell::new(name)];
            let values = [of.median, of.p99, of.p999, of.longest];
            row.extend(values.map(|value| number(Some(1e6 * value), digits)));
            table.add_row(row);
        }
        writeln!(f, "{}", lines(&table))
    }
}
