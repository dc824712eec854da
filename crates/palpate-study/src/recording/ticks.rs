//! Ticks of a recording for a replay.

use crate::sim::replay::ReplaySetup;
use palpate_record::recording::{Flags, Recording, RecordingError, Row};
use palpate_record::trace::Part;

use super::RecordedCurves;
use crate::text::counted;

/// Reason why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TicksError {
    /// The recording is not of one contact.
    #[error("{0}: not every tick has one contact; a replay needs a recording of one contact")]
    Contacts(String),
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The requested part of the recording is too short.
    #[error("{name}: the part between --from and --to has {ticks}, but needs at least 2{ends}")]
    Part {
        /// The recording.
        name: String,
        /// Number of ticks of the part, in words.
        ticks: String,
        /// Start and end of the recording, in words.
        ends: String,
    },
    /// The device position was unknown for too long.
    #[error(
        "{name}: no position between tick {} at {} s and tick {} at {} s; a hand is estimated across at most \
         {longest} s: pass a longer --largest-gap, or replay the motion with --replay motion",
        from.0, from.1, to.0, to.1
    )]
    Gap {
        /// The recording.
        name: String,
        /// Number and time `[s]` of the last tick before the gap.
        from: (u64, f64),
        /// Number and time `[s]` of the first tick after the gap.
        to: (u64, f64),
        /// Longest bridged gap `[s]`.
        longest: f64,
    },
    /// The recording contains no force.
    #[error(
        "{0}: no tick contains the sent force, so the hand's force cannot be separated from the motor's; --replay \
         motion needs no force"
    )]
    NoForce(String),
}

/// The ticks of a recording, each with its one contact.
#[derive(Clone, Debug, Default)]
pub struct Ticks {
    all: Vec<Tick>,
    /// Leak at the first position `[J]`.
    leak_before: Option<f64>,
    /// Curves over the ticks with a device position.
    pub curves: RecordedCurves,
    /// Number of ticks without a device position.
    pub without_position: u64,
    /// Strongest sent force `[N]`.
    pub peak_force: f64,
}

/// Data of a tick that a replay needs: a recording may have millions of ticks.
#[derive(Clone, Copy, Debug)]
struct Tick {
    sequence: u64,
    /// `[s]`
    time: f64,
    device_position: f64,
    object_position: f64,
    object_velocity: f64,
    /// Sent force on the device `[N]`.
    force_on_device: f64,
    /// Whether the tick has a device position. If a device did not respond, the tick repeats its last position and has
    /// the fault flag.
    is_seen: bool,
    /// Whether the renderer accepted this position; a rejected one is not a motion of the hand.
    is_believed: bool,
}

impl From<Row> for Tick {
    fn from(Row { tick, contact, .. }: Row) -> Self {
        let is_seen = contact.device_position.is_finite() && !tick.flags.has(Flags::DEVICE_FAULT);
        Self {
            sequence: tick.sequence,
            time: tick.time,
            device_position: contact.device_position,
            object_position: contact.object_position,
            object_velocity: contact.object_velocity,
            force_on_device: contact.force_on_device,
            is_seen,
            is_believed: is_seen && !tick.flags.has(Flags::FAULT),
        }
    }
}

impl Ticks {
    /// Reads the ticks of a part of a recording.
    ///
    /// # Errors
    /// The recording cannot be read, a tick does not have one contact, or a part that is not the whole has fewer than
    /// two ticks.
    pub fn new(recording: &Recording, part: &Part) -> Result<Self, TicksError> {
        if !recording.has_one_contact_each {
            let name = recording.path().display().to_string();
            return Err(TicksError::Contacts(name));
        }
        let mut ticks = Self::default();
        for row in recording.rows()? {
            let row = row?;
            if row.tick.time > part.to {
                break;
            }
            if row.tick.time >= part.from {
                ticks.add(row);
            }
        }
        if ticks.all.len() < 2 && *part != Part::WHOLE {
            let ends = recording.first.zip(recording.last);
            return Err(TicksError::Part {
                name: recording.path().display().to_string(),
                ticks: counted(ticks.all.len() as u64, "tick"),
                ends: ends.map_or_else(String::new, |(first, last)| {
                    format!(
                        "; the times of the recording begin at {} s and end at {} s",
                        first.time, last.time
                    )
                }),
            });
        }
        Ok(ticks)
    }

    fn add(&mut self, row: Row) {
        let tick = Tick::from(row);
        self.all.push(tick);
        // A sent force counts even if the tick has no position.
        self.peak_force = self.peak_force.max(tick.force_on_device.abs());
        if !tick.is_seen {
            self.without_position += 1;
            return;
        }
        self.curves.time.push(tick.time);
        self.curves.device_position.push(tick.device_position);
        self.curves.object_position.push(tick.object_position);
        self.curves.force_on_object.push(-tick.force_on_device);
        let leak = row.contact.held_leak;
        let first = *self.leak_before.get_or_insert(leak);
        self.curves.held_leak.push(leak - first);
    }

    /// Sets the object to its state in the first tick of the replay, of the motion or of the hand.
    pub fn place_object(&self, setup: &mut ReplaySetup, is_of_hand: bool) {
        let begins = |tick: &&Tick| match is_of_hand {
            true => tick.is_believed,
            false => tick.is_seen,
        };
        if let Some(first) = self.all.iter().find(begins)
            && first.object_position.is_finite()
            && first.object_velocity.is_finite()
        {
            setup.object.position = first.object_position;
            setup.object.velocity = first.object_velocity;
        }
    }

    /// Returns the known data of a hand, from the first position to the last, for a device that applies each force
    /// `delay` samples after it is sent.
    ///
    /// # Errors
    /// A gap without a position is longer than `longest_gap` `[s]`, or no force is known.
    pub fn held_device(
        &self,
        name: &str,
        delay: usize,
        period: f64,
        longest_gap: f64,
    ) -> Result<HeldDevice, TicksError> {
        let mut samples: Vec<Sample> = Vec::with_capacity(self.all.len());
        let mut unseen: Vec<&Tick> = Vec::new();
        let mut first_seen: Option<&Tick> = None;
        let mut last_seen: Option<&Tick> = None;
        for tick in &self.all {
            if !tick.is_believed {
                unseen.push(tick);
                continue;
            }
            if let Some(last) = last_seen {
                // The estimate rejects times in descending order.
                if tick.time - last.time > longest_gap {
                    return Err(TicksError::Gap {
                        name: name.to_owned(),
                        from: (last.sequence, last.time),
                        to: (tick.sequence, tick.time),
                        longest: longest_gap,
                    });
                }
                bridge(&mut samples, (last, tick), &unseen, period);
            }
            unseen.clear();
            samples.push(Sample {
                time: tick.time,
                position: tick.device_position,
                sent: tick.force_on_device,
            });
            first_seen = first_seen.or(Some(tick));
            last_seen = Some(tick);
        }
        let from_the_start = first_seen.is_none_or(|first| first.sequence == 0);
        let forces = acting(&samples, delay, from_the_start)
            .ok_or_else(|| TicksError::NoForce(name.to_owned()))?;
        Ok(HeldDevice {
            times: samples.iter().map(|sample| sample.time).collect(),
            positions: samples.iter().map(|sample| sample.position).collect(),
            forces,
        })
    }
}

/// Known data of a device in a hand, sample by sample.
#[derive(Clone, Debug)]
pub struct HeldDevice {
    /// Times of the samples `[s]`.
    pub times: Vec<f64>,
    /// Positions `[m]`; NaN if unknown.
    pub positions: Vec<f64>,
    /// Force on the device, held until the next sample `[N]`.
    pub forces: Vec<f64>,
}

struct Sample {
    time: f64,
    position: f64,
    /// Sent force on the device `[N]`; NaN if unknown.
    sent: f64,
}

/// Adds the samples between two ticks with a position: ticks without a position, and ticks lost in the recording. If
/// the recorded times are incomplete or out of order, the samples are evenly spaced.
fn bridge(samples: &mut Vec<Sample>, (from, to): (&Tick, &Tick), unseen: &[&Tick], period: f64) {
    let numbers = to.sequence.saturating_sub(from.sequence) as f64;
    let ticks = || std::iter::once(&from).chain(unseen).chain([&to]);
    let in_order = ticks().zip(ticks().skip(1)).all(|(a, b)| b.time > a.time);
    if in_order && numbers == (unseen.len() + 1) as f64 {
        samples.extend(unseen.iter().map(|tick| Sample {
            time: tick.time,
            position: f64::NAN,
            sent: tick.force_on_device,
        }));
        return;
    }
    // Tick numbers that increase faster than the time allows are not samples.
    let duration = to.time - from.time;
    let most = (duration / period).ceil().max((unseen.len() + 1) as f64);
    let steps = numbers.min(most);
    let mut step = 1.0;
    while step < steps {
        let sequence = from.sequence as f64 + step;
        let there = unseen.iter().find(|tick| tick.sequence as f64 == sequence);
        samples.push(Sample {
            time: from.time + duration * (step / steps),
            position: f64::NAN,
            sent: there.map_or(f64::NAN, |tick| tick.force_on_device),
        });
        step += 1.0;
    }
}

/// Returns the force on the device from each sample on. A sent force acts `delay` samples later; a sample with
/// unknown force keeps the last one. Returns `None` if no force is known.
fn acting(samples: &[Sample], delay: usize, from_the_start: bool) -> Option<Vec<f64>> {
    let known = |sample: &Sample| sample.sent.is_finite().then_some(sample.sent);
    if samples.is_empty() {
        return Some(Vec::new());
    }
    let first = samples.iter().find_map(known)?;
    // Before the first command of a loop the force is 0.
    let mut held = if from_the_start { 0.0 } else { first };
    let forces = (0..samples.len()).map(|index| {
        let sent = index.checked_sub(delay).map(|sender| &samples[sender]);
        held = sent.and_then(known).unwrap_or(held);
        held
    });
    Some(forces.collect())
}
