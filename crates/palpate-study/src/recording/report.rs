//! Report on a recording, as text or as JSON.

use std::collections::BTreeMap;
use std::fmt;

use palpate_record::recording::{
    DeviceTick, Entry, Event, Flags, LoopTime, Recording, RecordingError, Tick,
};
use serde::Serialize;

use super::{DEVICES, motors_off, shortcomings};
use crate::text::{counted, digits};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate info 1";

/// Report on a recording.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct RecordingReport {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// File of the recording.
    pub recording: String,
    /// Version of palpate that made the recording.
    pub palpate_version: String,
    /// Whether the recording is intact and contains as many ticks as the loop counted.
    pub complete: bool,
    /// Whether the recording was finished, is unchanged, and has no known losses.
    pub whole: bool,
    /// Whether the recording was finished.
    pub finished: bool,
    /// Size of the file `[bytes]`.
    pub bytes: u64,
    /// Shortcomings in words.
    pub shortcomings: Vec<String>,
    /// Number of recorded ticks.
    pub ticks: u64,
    /// Number of ticks counted by the loop.
    pub ticks_made: Option<u64>,
    /// Number of ticks missing in the recording.
    pub ticks_lost: u64,
    /// Number of events missing in the recording.
    pub events_lost: u64,
    /// Ticks and events of a truncated chunk, which no checksum covers.
    pub unchecked: u64,
    /// Positions of missing ticks.
    pub gaps: Vec<GapReport>,
    /// Duration of the loop; `None` if unknown, as in recordings of older versions.
    pub lasted_s: Option<f64>,
    /// Part of that duration without a delivered force, stalls included.
    pub motors_off_s: Option<f64>,
    /// The times for a terminal.
    #[serde(skip)]
    time: Option<LoopTime>,
    /// Ticks with the motors off, lost ones included; in older recordings only the recorded ticks.
    pub motors_off_ticks: u64,
    /// Reason for the end of the loop.
    pub ending: Option<String>,
    /// Time of the first tick `[s]`.
    pub first_s: Option<f64>,
    /// Time of the last tick `[s]`.
    pub last_s: Option<f64>,
    /// From the first tick to the last `[s]`.
    pub duration_s: Option<f64>,
    /// Ticks per second of the loop, lost ticks included.
    pub rate_hz: Option<f64>,
    /// Number of deadlines that the loop missed and skipped, from the recorded events.
    pub missed_deadlines: u64,
    /// Maximum generated energy of held forces up to any tick, while the motors were on `[J]`.
    pub most_created_energy_j: Option<f64>,
    /// Largest lateness of a sample `[s]`.
    pub largest_lateness_s: Option<f64>,
    /// Longest time between two samples `[s]`.
    pub longest_period_s: Option<f64>,
    /// Longest tick `[s]`.
    pub longest_tick_s: Option<f64>,
    /// Devices of a loop with several devices; empty for one device.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub devices: Vec<DeviceReport>,
    /// Longest response time of the device, or of several devices together `[s]`.
    pub longest_round_trip_s: Option<f64>,
    /// The renderer's initial model values of the device, by key with unit: mass, delay, lag and gain, and the
    /// standard deviations of delay, lag and gain. Empty if unknown, as in recordings of older versions.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub model: BTreeMap<String, f64>,
    /// Number of parameter changes.
    pub parameter_changes: u32,
    /// Number of ticks per flag.
    pub flags: BTreeMap<&'static str, u64>,
    /// Number of events per kind.
    pub events: BTreeMap<String, u64>,
    /// Length of each metadata text.
    pub metadata_bytes: BTreeMap<String, usize>,
}

/// Ticks that are missing between two recorded ticks.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GapReport {
    /// The last tick before the gap; none before the first tick.
    pub after_tick: Option<u64>,
    /// Number of missing ticks.
    pub ticks: u64,
}

/// A device of a loop with several devices.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct DeviceReport {
    /// Name in the world.
    pub name: String,
    /// Number of ticks per flag of the device.
    pub flags: BTreeMap<&'static str, u64>,
}

/// Number of ticks per flag of each device.
#[derive(Default)]
struct DeviceFlags(Vec<BTreeMap<&'static str, u64>>);

impl DeviceFlags {
    fn add(&mut self, devices: &[DeviceTick]) {
        if self.0.len() < devices.len() {
            self.0.resize(devices.len(), BTreeMap::new());
        }
        for (flags, device) in self.0.iter_mut().zip(devices) {
            let named = Flags::NAMED.into_iter();
            for (_, name) in named.filter(|(flag, _)| device.flags.has(*flag)) {
                *flags.entry(name).or_insert(0) += 1;
            }
        }
    }

    fn reports(self, recording: &Recording) -> Vec<DeviceReport> {
        let names = recording.metadata.texts.get(DEVICES);
        let names: Vec<&str> = names.map_or_else(Vec::new, |names| names.lines().collect());
        let reports = self.0.into_iter().enumerate().map(|(number, flags)| {
            let name = names.get(number);
            DeviceReport {
                name: name.map_or_else(|| format!("{}", number + 1), |name| (*name).to_owned()),
                flags,
            }
        });
        reports.collect()
    }
}

impl RecordingReport {
    /// Creates the report on `recording` and reads it completely.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn new(recording: &Recording) -> Result<Self, RecordingError> {
        let totals = Totals::of(recording)?;
        let off = totals
            .flags
            .get(Flags::SAFETY_STOPPED.names().as_str())
            .copied();
        let off = off.unwrap_or(0);
        let ends = recording.first.zip(recording.last);
        let steps = ends.map(|(first, last)| (last.sequence - first.sequence) as f64);
        // A tick without a sample keeps the time of the last sample.
        let sampled = totals.sampled.or(ends.map(|(first, last)| [first, last]));
        let rate = sampled.map(|[first, last]| {
            (last.sequence - first.sequence) as f64 / (last.time - first.time)
        });
        let rate = rate.filter(|rate| rate.is_finite());
        let duration = ends.and_then(|(first, last)| match sampled {
            Some([_, sampled]) if sampled.sequence < last.sequence => {
                Some(steps? / rate.filter(|rate| *rate > 0.0)?)
            }
            _ => Some(last.time - first.time),
        });
        let texts = recording.metadata.texts.iter();
        let counted = recording.counted.as_ref();
        let time = counted.and_then(|count| count.time);
        Ok(Self {
            format: FORMAT,
            recording: recording.path().display().to_string(),
            palpate_version: recording.metadata.palpate_version.clone(),
            complete: recording.is_complete(),
            whole: recording.is_whole(),
            finished: recording.finished,
            bytes: recording.bytes,
            shortcomings: shortcomings(recording),
            ticks: recording.ticks,
            ticks_made: recording.ticks_made(),
            ticks_lost: recording.lost(),
            events_lost: recording.lost_events(),
            unchecked: recording.unchecked,
            devices: totals.devices.reports(recording),
            lasted_s: time.map(|time| time.lasted.as_secs_f64()),
            motors_off_s: time.map(|time| time.motors_off.as_secs_f64()),
            time,
            motors_off_ticks: counted.map_or(off, |count| count.motors_off),
            ending: counted.and_then(|count| count.ending.clone()),
            gaps: recording
                .missing
                .iter()
                .map(|gap| GapReport {
                    after_tick: gap.after,
                    ticks: gap.count,
                })
                .collect(),
            first_s: recording.first.map(|tick| tick.time),
            last_s: ends
                .zip(duration)
                .map(|((first, last), duration)| last.time.max(first.time + duration)),
            duration_s: duration,
            rate_hz: rate,
            missed_deadlines: totals.missed_deadlines,
            most_created_energy_j: totals.created_energy,
            largest_lateness_s: totals.lateness,
            longest_period_s: totals.period,
            longest_tick_s: totals.tick_duration,
            longest_round_trip_s: totals.round_trip,
            model: model(recording),
            parameter_changes: recording.generation,
            flags: totals.flags,
            events: totals.events,
            metadata_bytes: texts
                .map(|(name, text)| (name.clone(), text.len()))
                .collect(),
        })
    }
}

/// Counts and maxima over all entries of a recording.
#[derive(Default)]
struct Totals {
    /// Number of ticks per flag.
    flags: BTreeMap<&'static str, u64>,
    /// Number of events per kind.
    events: BTreeMap<String, u64>,
    devices: DeviceFlags,
    /// First and last tick with a sample.
    sampled: Option<[Tick; 2]>,
    missed_deadlines: u64,
    /// Largest lateness of a sample `[s]`.
    lateness: Option<f64>,
    /// Longest time between two samples `[s]`.
    period: Option<f64>,
    /// Longest tick `[s]`.
    tick_duration: Option<f64>,
    /// Longest response time of the device `[s]`.
    round_trip: Option<f64>,
    /// Maximum generated energy `[J]`.
    created_energy: Option<f64>,
}

impl Totals {
    /// Reads the whole recording.
    fn of(recording: &Recording) -> Result<Self, RecordingError> {
        let mut totals = Self::default();
        let entries = recording.entries()?;
        for entry in entries {
            match entry? {
                Entry::Event(event) => {
                    totals.missed_deadlines += missed(&event);
                    *totals.events.entry(event.kind).or_insert(0) += 1;
                }
                Entry::Tick(tick, _, _, of_tick) => {
                    totals.devices.add(&of_tick);
                    if !tick.flags.has(Flags::DEVICE_FAULT) {
                        totals.sampled.get_or_insert([tick; 2])[1] = tick;
                    }
                    raise(&mut totals.lateness, tick.lateness);
                    raise(&mut totals.period, tick.period);
                    raise(&mut totals.tick_duration, tick.tick_duration);
                    raise(&mut totals.round_trip, tick.device_round_trip);
                    raise(&mut totals.created_energy, tick.created_energy);
                    let set = Flags::NAMED
                        .iter()
                        .filter(|(flag, _)| tick.flags.has(*flag));
                    for (_, name) in set {
                        *totals.flags.entry(*name).or_insert(0) += 1;
                    }
                }
            }
        }
        Ok(totals)
    }
}

/// Returns the number of missed deadlines of an event: the number at the end of its text.
fn missed(event: &Event) -> u64 {
    let words = event.text.rsplit(' ').next();
    let number = words.filter(|_| event.kind == Flags::MISSED_DEADLINE.names());
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}

/// Returns the renderer's model values in the metadata, one number per key.
pub(crate) fn model(recording: &Recording) -> BTreeMap<String, f64> {
    let text = recording.metadata.texts.get("model");
    let lines = text.map_or("", String::as_str).lines();
    lines
        .filter_map(|line| {
            let (key, value) = line.split_once(" = ")?;
            Some((key.to_owned(), value.parse().ok()?))
        })
        .collect()
}

/// Updates the maximum; NaN is ignored.
fn raise(largest: &mut Option<f64>, value: f64) {
    if !value.is_nan() {
        *largest = Some(largest.map_or(value, |largest| largest.max(value)));
    }
}

impl RecordingReport {
    /// Returns the renderer's model values as one line; `None` if unknown.
    fn model_in_words(&self) -> Option<String> {
        let of = |key: &str| self.model.get(key).copied();
        let known = [
            ("device", "device_mass_kg", "", 1.0, " kg"),
            ("delay", "delay_s", "delay_deviation_s", 1e3, " ms"),
            ("lag", "lag_s", "lag_deviation_s", 1e3, " ms"),
            ("gain", "gain", "gain_deviation", 1.0, ""),
            ("resonance", "resonance_hz", "", 1.0, " Hz"),
        ];
        let words: Vec<String> = known
            .iter()
            .filter_map(|(name, key, deviation, factor, unit)| {
                let value = digits(factor * of(key)?);
                let deviation = of(deviation).filter(|deviation| *deviation > 0.0);
                let deviation = deviation.map(|deviation| digits(factor * deviation));
                let deviation = deviation.map_or_else(String::new, |by| format!(" ± {by}"));
                Some(format!("{name} {value}{deviation}{unit}"))
            })
            .collect();
        (!words.is_empty()).then(|| format!("the renderer's model: {}", words.join(", ")))
    }
}

impl fmt::Display for RecordingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, recorded by palpate {}",
            self.recording, self.palpate_version
        )?;
        if self.complete {
            writeln!(f, "complete, nothing lost")?;
        } else if self.whole {
            writeln!(
                f,
                "finished, and no loss is known; the number of ticks of the loop is not recorded, so ticks after the \
                 last may be missing"
            )?;
        }
        for words in &self.shortcomings {
            writeln!(f, "{words}")?;
        }
        if self.motors_off_ticks > 0 {
            let all = self.ticks_made.unwrap_or(self.ticks + self.ticks_lost);
            let words = motors_off(self.time, self.motors_off_ticks, all);
            writeln!(f, "{words}")?;
        }
        writeln!(f)?;
        self.write_loop(f)?;
        let total: u64 = self.events.values().sum();
        writeln!(f, "{}", counted(total, "event"))?;
        for (kind, count) in &self.events {
            writeln!(f, "  {kind}: {count}")?;
        }
        writeln!(
            f,
            "{} in the metadata",
            counted(self.metadata_bytes.len() as u64, "text")
        )?;
        for (name, bytes) in &self.metadata_bytes {
            writeln!(f, "  {name}: {}", counted(*bytes as u64, "byte"))?;
        }
        Ok(())
    }
}

impl RecordingReport {
    /// Writes the ticks, the times and the flags of the loop, and the renderer's model.
    fn write_loop(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let over = match (self.duration_s, self.rate_hz) {
            (Some(duration), Some(rate)) => {
                format!(" over {duration:.3} s, {} Hz", digits(rate))
            }
            _ => String::new(),
        };
        writeln!(f, "{}{over}", counted(self.ticks, "tick"))?;
        for (name, seconds) in [
            ("largest lateness", self.largest_lateness_s),
            ("longest period", self.longest_period_s),
            ("longest tick", self.longest_tick_s),
            ("longest device response", self.longest_round_trip_s),
        ] {
            if let Some(seconds) = seconds {
                writeln!(f, "  {name}: {} ms", digits(1e3 * seconds))?;
            }
        }
        writeln!(f, "  missed deadlines: {}", self.missed_deadlines)?;
        if let Some(created) = self.most_created_energy_j {
            let created = digits(1e3 * created);
            writeln!(
                f,
                "  held forces created: at most {created} mJ, if the loop is as modelled"
            )?;
        }
        for (name, count) in &self.flags {
            writeln!(f, "  {name}: {count}")?;
        }
        self.write_devices(f)?;
        if self.parameter_changes > 0 {
            writeln!(f, "  changes of parameters: {}", self.parameter_changes)?;
        }
        if let Some(words) = self.model_in_words() {
            writeln!(f, "{words}")?;
        }
        Ok(())
    }

    /// Writes the flags of each device of several.
    fn write_devices(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for device in &self.devices {
            let flags = device.flags.iter();
            let flags: Vec<_> = flags
                .map(|(name, count)| format!("{name}: {count}"))
                .collect();
            let said = if flags.is_empty() {
                "no flags".to_owned()
            } else {
                flags.join(", ")
            };
            writeln!(f, "  device {}: {said}", device.name)?;
        }
        Ok(())
    }
}
