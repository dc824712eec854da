//! Results of a real-time loop after its end.

use std::sync::{Arc, OnceLock};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Connection, Device};
use palpate_rt::{Account, Durations, Ending, LoopEnd, Recorder, Renders};

/// Message of a device at its end.
#[derive(Clone, Debug)]
pub enum AtTheEnd {
    /// Its output could not be disabled, for this reason.
    NotDisabled(String),
    /// A message.
    Said(String),
}

/// Message of a device at its end, if it has one.
pub type Closed = Arc<OnceLock<AtTheEnd>>;

/// Results of a loop.
#[derive(Clone)]
pub struct Ended {
    ending: Option<Ending>,
    /// Errors, the most severe first.
    failure: Option<String>,
    ticks: u64,
    missed_deadlines: u64,
    without_sample: u64,
    refused: u64,
    crowded: u64,
    motors_off: u64,
    pub cuts: u64,
    safety_stop: Option<String>,
    /// Name of the device that caused the safety stop, if there are several.
    device: Option<String>,
    /// Median, 99 % and longest lateness of a tick `[s]`.
    lateness: [f64; 3],
    /// Median, 99 % and longest duration of a tick `[s]`.
    duration: [f64; 3],
    recorded: Option<(u64, u64)>,
    /// Connection to each device of another program.
    connections: Vec<Option<Connection>>,
}

/// Samples, lost, late, reordered, duplicate and unreadable ones, commands not taken; round trip: median, 99 % and
/// longest `[s]`.
pub type ConnectionValues = ([u64; 7], Option<[f64; 3]>);

/// Ending, failure, safety stop and its device if there are several; ticks, missed deadlines, ticks without a
/// sample, ticks with a rejected sample, ticks with disabled motors, cuts; lateness, duration; ticks in the
/// recording and missing ticks; the connection to each device of another program.
pub type EndValues = (
    (
        Option<&'static str>,
        Option<String>,
        Option<String>,
        Option<String>,
    ),
    (u64, u64, u64, u64, u64, u64, u64),
    ([f64; 3], [f64; 3]),
    Option<(u64, u64)>,
    Vec<Option<ConnectionValues>>,
);

impl Ended {
    /// Returns the result of a loop that was never started.
    pub fn never_ran() -> Self {
        Self {
            ending: None,
            failure: None,
            ticks: 0,
            missed_deadlines: 0,
            without_sample: 0,
            refused: 0,
            crowded: 0,
            motors_off: 0,
            cuts: 0,
            safety_stop: None,
            device: None,
            lateness: [0.0; 3],
            duration: [0.0; 3],
            recorded: None,
            connections: Vec::new(),
        }
    }

    /// Returns the result of a loop whose thread has ended. `names` are the device names, or empty for one device.
    pub fn of<R: Renders>(
        end: &LoopEnd<Box<dyn Device>, MonotonicClock, R>,
        names: &[String],
    ) -> Self {
        let stopped = end.control.stopped_device();
        let device = stopped.and_then(|(device, _)| names.get(device));
        let statistics = &end.statistics;
        let spread = |durations: &Durations| {
            [
                durations.quantile(0.5),
                durations.quantile(0.99),
                durations.longest(),
            ]
            .map(|duration| duration.as_secs_f64())
        };
        let failure = match (end.ending, &end.panic) {
            (_, Some(words)) => Some(format!(
                "the loop panicked and commanded zero force: {words}"
            )),
            (Ending::DeviceLost, None) => Some(match device {
                Some(name) => format!("the device {name} is gone"),
                None => Ending::DeviceLost.text().to_owned(),
            }),
            _ => None,
        };
        Self {
            ending: Some(end.ending),
            failure,
            ticks: statistics.ticks,
            missed_deadlines: statistics.missed_deadlines,
            without_sample: statistics.without_sample,
            refused: statistics.refused,
            crowded: statistics.crowded,
            motors_off: statistics.motors_off,
            cuts: end.cuts,
            safety_stop: end.safety_stop.map(|safety_stop| safety_stop.to_string()),
            device: device.cloned(),
            lateness: spread(&statistics.lateness),
            duration: spread(&statistics.tick),
            recorded: None,
            connections: end.control.devices().map(Device::connection).collect(),
        }
    }

    /// Appends an error.
    pub fn fails(&mut self, why: String) {
        self.failure = Some(match self.failure.take() {
            Some(before) => format!("{before}; {why}"),
            None => why,
        });
    }

    /// Adds the results of closing the devices and the recording.
    pub fn closes(&mut self, recorder: Option<Recorder>, closed: &[Closed], names: &[String]) {
        for (number, closed) in closed.iter().enumerate() {
            if let Some(why) = closed.get() {
                let which = match names.get(number) {
                    Some(name) => format!("the device {name}"),
                    None => "the device".to_owned(),
                };
                self.fails(match why {
                    AtTheEnd::NotDisabled(why) => format!(
                        "the output of {which} could not be disabled: {why}; switch its motors off"
                    ),
                    AtTheEnd::Said(why) => why.clone(),
                });
            }
        }
        if let Some(recorder) = recorder {
            let (account, unwritten) = recorder.finish();
            let Account { recording, .. } = &account;
            let written = recording.as_ref().map(|_| account.ticks);
            self.recorded = written.map(|ticks| (ticks, account.lost_ticks()));
            if let Some(error) = unwritten {
                self.fails(error.to_string());
            }
        }
    }

    /// Converts to the tuple for Python.
    pub fn messages(self) -> EndValues {
        (
            (
                self.ending.map(Ending::text),
                self.failure,
                self.safety_stop,
                self.device,
            ),
            (
                self.ticks,
                self.missed_deadlines,
                self.without_sample,
                self.refused,
                self.crowded,
                self.motors_off,
                self.cuts,
            ),
            (self.lateness, self.duration),
            self.recorded,
            (self.connections.into_iter())
                .map(|connection| connection.map(values))
                .collect(),
        )
    }
}

/// Converts to the tuple for Python.
fn values(connection: Connection) -> ConnectionValues {
    let counts = [
        connection.samples,
        connection.lost,
        connection.late,
        connection.reordered,
        connection.duplicate,
        connection.unreadable,
        connection.untaken,
    ];
    let times = connection.round_trip;
    (
        counts,
        times.map(|times| times.map(|time| time.as_secs_f64())),
    )
}
