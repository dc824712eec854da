//! The session: loops that run, and a thread that listens to them, tells what they do, and does what
//! clients request. The loops wait for none of it.

mod carried;
mod handle;
mod lane;
mod recording;
mod start;
mod turns;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_device::Capabilities;
use palpate_record::files::atomic::WriteError;
use palpate_rt::realtime::Answer;
use palpate_rt::{Account, Ending as LoopEnding, Note, StopFlag};
use palpate_scene::Scene;
use palpate_scene::method::MethodName;

use crate::hub::{ClientId, Hub};
use crate::message::{
    ClientRequest, DeviceSaid, LaneState, RecordingState, RecordingStatus, ServerMessage, Set,
};
use crate::pace::Pace;
use crate::settings::{self, Limits, Settings, written};

pub use handle::Session;
pub use lane::Ended;
use lane::Lane;
use recording::Ending;
pub use start::{Devices, MetadataOf, Placed, SessionError, Setup};
pub(crate) use turns::Turns;

/// Interval of messages about the position of a moving hand.
const HAND_EVERY: Duration = Duration::from_millis(100);
/// Notes of a rendering: burst size, and rate per second. Further notes are only counted.
const NOTES: (f64, f64) = (32.0, 20.0);
/// State messages: burst size, and rate per second. The newest state is sent with each frame.
const STATES: (f64, f64) = (32.0, 60.0);
/// Restarts, and beginnings of recordings, at once and then each second: more than any hand does.
const BEGINNINGS: (f64, f64) = (8.0, 4.0);
/// Reach of a hand `[m]`.
const REACH: f64 = 1.0;

/// ServerMessage of a request that would begin the loops again too soon.
const TOO_OFTEN: &str = "restarts are too frequent; allowed: 4 per second";

/// Command to the session.
#[derive(Clone, Debug)]
pub enum Command {
    /// A client asks for something.
    Request(ClientId, ClientRequest),
    /// A client is gone.
    Gone(ClientId),
}

/// Result of a session.
pub struct SessionEnd {
    /// The loops that ran last.
    pub lanes: Vec<LaneEnd>,
    /// Recordings that ended or failed before their loop did, or whose loop was not the last, by name.
    pub recordings: Vec<Written>,
    /// Reason why loops could not restart, if they did not.
    pub failed: Option<String>,
}

/// Result of a recording.
#[derive(Debug)]
pub struct Written {
    /// Its file.
    pub path: PathBuf,
    /// Number of ticks in the file, or the error while writing.
    pub ticks: Result<u64, WriteError>,
    /// Ticks that the loop made and that it does not hold.
    pub lost: u64,
}

/// Final state of a rendering, for a report.
pub struct LaneEnd {
    /// Final state of the rendered scene.
    pub scene: Scene,
    /// The device.
    pub capabilities: Capabilities,
    /// End of the loop.
    pub end: Ended,
    /// Scheduling that the system granted.
    pub answers: Vec<Answer>,
    /// Data received from the loop.
    pub account: Account,
    /// The recording that ended with it, if one was made.
    pub recording: Option<Written>,
}

impl Session {
    /// Starts the loops and the thread that receives their ticks, until `stop` is raised. The loops check `stop`
    /// themselves, so they end even if that thread is busy.
    ///
    /// # Errors
    /// There are more methods than the device supports, a device does not open, the scene cannot be rendered, or a
    /// recording cannot be started; with the reason as text.
    pub fn start(setup: Setup, stop: &StopFlag) -> Result<Self, SessionError> {
        settings::check_lanes(setup.methods.len(), setup.devices.most_lanes())?;
        Self::begin(stop, |hub, stop| {
            let mut running = Running::new(setup, stop, hub);
            running.start_lanes()?;
            running.greet();
            Ok(running)
        })
    }
}

struct Running {
    setup: Setup,
    settings: Settings,
    limits: Limits,
    hub: Arc<Hub>,
    /// Ends the session.
    stop: StopFlag,
    /// Ends the loops that run now.
    stop_lanes: StopFlag,
    lanes: Vec<Lane>,
    /// Number of starts of the loops.
    runs: u32,
    /// Time at which the recording began, and why it is written no more.
    recorded_since: f64,
    recording_failed: Option<String>,
    endings: Vec<Ending>,
    /// Results of ended recordings.
    written: Vec<Written>,
    /// Reason why no loop runs, if none has started.
    failed: Option<String>,
    /// Rate limits of restarts and of new recordings.
    restarts: Pace,
    recordings: Pace,
    /// Rate limit of the notes of each rendering, and the number of suppressed notes.
    notes: [(Pace, u64); 2],
    /// Rate limit of immediate state messages, and whether one is pending.
    states: Pace,
    is_state_due: bool,
    /// Client that moved the hand last.
    holder: Option<ClientId>,
    hand_sent: Instant,
}

impl Turns for Running {
    type End = SessionEnd;

    fn answers(&self) -> Vec<Answer> {
        self.lanes.first().map(Lane::answers).unwrap_or_default()
    }

    fn obey(&mut self, command: Command) {
        let (client, request) = match command {
            Command::Request(client, request) => (client, request),
            Command::Gone(client) => {
                if self.holder == Some(client) {
                    // Without a client the hand must release the device.
                    self.holder = None;
                    if let Some(hand) = &self.setup.hand {
                        hand.disable_output();
                    }
                }
                return;
            }
        };
        let changes_state = !matches!(request, ClientRequest::Hand(_));
        let (about, done) = match request {
            ClientRequest::Hand(target) => ("hand", self.lead(client, target)),
            ClientRequest::Tool { .. } => (
                "tool",
                Err("one contact needs `hand`, with one number".to_owned()),
            ),
            ClientRequest::Turn { .. } => {
                ("turn", Err("one contact has no orientation".to_owned()))
            }
            ClientRequest::Set(set) => ("set", self.set(&set)),
            ClientRequest::Restart => ("restart", self.restart_if_allowed()),
            ClientRequest::Rearm(lane) => ("rearm", self.rearm(lane)),
            ClientRequest::Record(true) => ("record", self.record()),
            ClientRequest::Record(false) => {
                self.end_recordings();
                ("record", Ok(()))
            }
        };
        if let Err(text) = done {
            let refused = ServerMessage::Refused { about, text: &text };
            self.hub.tell(client, refused.text());
        }
        self.is_state_due |= changes_state;
        // Otherwise the next frame carries the newest state.
        if self.is_state_due && self.states.take(Instant::now()) {
            self.tell_state();
        }
    }

    fn runs(&self) -> u32 {
        self.runs
    }

    fn listen(&mut self) {
        let mut texts = Vec::new();
        let mut changed = false;
        for ((index, lane), (pace, unsent)) in
            self.lanes.iter_mut().enumerate().zip(&mut self.notes)
        {
            let has_ended = lane.listen(|noted| {
                // A client that causes many notes must not overload the queues of the others.
                if !pace.take(Instant::now()) {
                    *unsent += 1;
                    return;
                }
                let event = noted.event();
                let note = ServerMessage::Note {
                    lane: index,
                    t_s: event.time,
                    kind: &event.kind,
                    text: &event.text,
                };
                // The device has its own word for an end, below.
                if !matches!(noted.note, Note::Ended(_)) {
                    texts.push(note.text());
                }
            });
            changed |= has_ended;
            // The code that stops a loop sends its own message.
            let is_over = |end: &&lane::Ended| end.ending != LoopEnding::Stopped;
            if has_ended && let Some(end) = lane.end().filter(is_over) {
                let mut text = format!("rendering {}: {}", index + 1, end.ending.text());
                if let Some(words) = &end.panic {
                    text = format!("{text}: {words}");
                }
                texts.push(ServerMessage::Ended { text: &text }.text());
            }
        }
        for text in texts {
            self.hub.tell_all(text);
        }
        self.send_pending();
        if changed {
            self.end_recordings_of_ended();
        }
        self.watch_recordings();
    }

    fn show(&mut self) {
        for (index, lane) in self.lanes.iter_mut().enumerate() {
            let number = u8::try_from(index).unwrap_or(u8::MAX);
            if let Some(frame) = lane.rows().take_frame(number, self.runs) {
                self.hub.show(frame);
            }
        }
        self.tell_state();
    }

    fn tell_status(&mut self) {
        let mut recording: Option<RecordingStatus> = None;
        for part in self.lanes.iter().filter_map(Lane::recording) {
            let all = recording.get_or_insert_default();
            all.ticks += part.ticks();
            all.lost += part.lost();
            all.bytes += part.bytes();
        }
        if let Some(failed) = &self.recording_failed {
            let all = recording.get_or_insert_default();
            all.failed = Some(failed.clone());
        }
        let lanes = self.lanes.iter().map(Lane::status).collect();
        self.hub.tell_all_counted(|clients| {
            let status = ServerMessage::Status {
                clients,
                lanes,
                recording,
            };
            status.text()
        });
    }

    fn is_over(&self) -> bool {
        self.setup.duration.is_some() && !self.lanes.iter().any(Lane::is_running)
    }

    fn finish(self) -> SessionEnd {
        Self::finish(self)
    }
}

impl Running {
    /// Sends the number of suppressed notes of each rendering as soon as the rate limit permits.
    fn send_pending(&mut self) {
        for (index, lane) in self.lanes.iter().enumerate() {
            let Some((pace, unsent)) = self.notes.get_mut(index) else {
                continue;
            };
            if *unsent > 0 && pace.take(Instant::now()) {
                let text = format!("{unsent} further events are in recordings only");
                *unsent = 0;
                let note = ServerMessage::Note {
                    lane: index,
                    t_s: lane.time(),
                    kind: "unsent",
                    text: &text,
                };
                self.hub.tell_all(note.text());
            }
        }
    }

    fn lead(&mut self, client: ClientId, target: Option<f64>) -> Result<(), String> {
        let Some(hand) = &self.setup.hand else {
            return Err(
                "this device has its own hand; only the device `pointer` is moved from a page"
                    .to_owned(),
            );
        };
        match target {
            None => {
                hand.disable_output();
                self.holder = None;
            }
            Some(target) if target.abs() <= REACH => {
                hand.move_to(target);
                self.holder = Some(client);
            }
            Some(target) => {
                let target = written(target);
                return Err(format!(
                    "position_m is {target}; allowed: -{REACH} to {REACH}, or null"
                ));
            }
        }
        Ok(())
    }

    fn set(&mut self, set: &Set) -> Result<(), String> {
        let most = self.setup.devices.most_lanes();
        let new = self.settings.with(set, &self.limits, most)?;
        // Check all values before changing anything.
        let renderings = new.renderings(&self.setup.scene)?;
        let another_loop =
            new.period != self.settings.period || new.lanes.len() != self.settings.lanes.len();
        if another_loop {
            if !self.restarts.take(Instant::now()) {
                return Err(TOO_OFTEN.to_owned());
            }
            self.settings = new;
            return self.restart();
        }
        let methods = new.lanes.iter().map(|lane| lane.method);
        for (lane, (method, rendering)) in self.lanes.iter_mut().zip(methods.zip(renderings)) {
            lane.change(method, rendering)?;
        }
        self.settings = new;
        Ok(())
    }

    fn restart_if_allowed(&mut self) -> Result<(), String> {
        if self.restarts.take(Instant::now()) {
            self.restart()
        } else {
            Err(TOO_OFTEN.to_owned())
        }
    }

    fn rearm(&mut self, lane: usize) -> Result<(), String> {
        let lanes = self.lanes.len();
        let rearmed = self.lanes.get(lane).map(Lane::rearm);
        rearmed.ok_or_else(|| format!("lane is {lane}; allowed: 0 to {}", lanes.max(1) - 1))
    }

    fn greet(&self) {
        let capabilities = self.lanes.first().map(Lane::capabilities);
        let device = DeviceSaid {
            name: capabilities.map_or("", |device| &device.name),
            axes: capabilities.map_or(1, |device| device.axes),
            pointer: self.setup.hand.is_some(),
            largest_force_n: capabilities.and_then(|device| device.largest_force),
            lanes: self.setup.devices.most_lanes(),
        };
        let hello = ServerMessage::hello(&self.setup.scene, self.limits, device);
        self.hub.set_hello(hello.text());
        self.hub.set_state(self.state().text());
    }

    fn state(&self) -> ServerMessage<'static> {
        let lanes = self.settings.lanes.iter().enumerate();
        let files: Vec<String> = self
            .lanes
            .iter()
            .filter_map(|lane| lane.recording())
            .map(|recording| {
                let name = recording.path().file_name().unwrap_or_default();
                name.to_string_lossy().into_owned()
            })
            .collect();
        ServerMessage::State {
            stiffness_n_per_m: self.settings.stiffness,
            mass_kg: self.settings.mass,
            virtual_force_n: self.settings.virtual_force,
            period_s: self.settings.period,
            model: self.settings.model(&self.setup.scene),
            lanes: lanes
                .map(|(index, choice)| {
                    let lane = self.lanes.get(index);
                    let safety_stop = lane.and_then(Lane::safety_stop);
                    LaneState {
                        choice: *choice,
                        running: lane.is_some_and(Lane::is_running),
                        safety_stop: safety_stop.map(|safety_stop| safety_stop.why.clone()),
                        safety_stop_method: safety_stop
                            .and_then(|safety_stop| safety_stop.method)
                            .map(MethodName::name),
                    }
                })
                .collect(),
            recording: (!files.is_empty()).then_some(RecordingState {
                files,
                since_s: self.recorded_since,
            }),
            hand_m: self.setup.hand.as_ref().and_then(|hand| hand.target()),
        }
    }

    /// Sends the state if it has changed. Positions of a moving hand are sent at a limited rate.
    fn tell_state(&mut self) {
        if std::mem::take(&mut self.is_state_due) || self.hand_sent.elapsed() >= HAND_EVERY {
            self.hand_sent = Instant::now();
            self.hub.set_state(self.state().text());
        }
    }
}
