//! Start and end of a session's loops and recordings.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_core::AlongAxis;
use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device};
use palpate_record::recording::RecordingMetadata;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{SetupError, StopFlag};
use palpate_scene::Scene;
use palpate_scene::method::MethodName;
use palpate_study::sim::device::PointerHand;

use super::lane::{Lane, Run};
use super::recording::{Ending, LaneRecording};
use super::{BEGINNINGS, LaneEnd, NOTES, Running, STATES, SessionEnd, Written};
use crate::hub::Hub;
use crate::message::ServerMessage;
use crate::pace::Pace;
use crate::settings::{Limits, Settings, make_room};

/// Source of devices.
pub trait Devices: Send {
    /// Returns the largest number of renderings, 1 or 2; several only if the device can exist several times.
    fn most_lanes(&self) -> usize;

    /// Returns whether a device continues at its position when its loop restarts; otherwise it is reopened.
    fn resume(&self) -> bool;

    /// Whether a device that is open can be in a loop of another period.
    fn any_period(&self) -> bool;

    /// Opens a device, at the position `at` `[m]` if possible, otherwise at its start position.
    ///
    /// # Errors
    /// The reason as text.
    fn open(&mut self, at: Option<f64>) -> Result<Placed, String>;
}

/// A device, and where the contact's axis lies in it.
pub struct Placed {
    /// The device.
    pub device: Box<dyn Device>,
    /// Origin and direction of the contact's axis in the device's frame.
    pub axis: AlongAxis<f64, 3>,
}

/// Reason why a session does not start.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// Error in the scene or in a safety limit.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Any other reason, as text.
    #[error("{0}")]
    Other(String),
}

impl From<String> for SessionError {
    fn from(text: String) -> Self {
        Self::Other(text)
    }
}

/// State of an ended rendering: position of its device `[m]`, and the device if it can be used again.
type Carried = (Option<f64>, Option<Placed>);

/// Creates the metadata of a recording from the rendered scene and the device.
pub type MetadataOf =
    Box<dyn Fn(&Scene, &Capabilities) -> Result<RecordingMetadata, String> + Send>;

/// Parameters for starting a session.
pub struct Setup {
    /// Initial scene.
    pub scene: Scene,
    /// Methods, one for each rendering; one or two.
    pub methods: Vec<MethodName>,
    /// Source of devices.
    pub devices: Box<dyn Devices>,
    /// The hand that clients lead, if they do.
    pub hand: Option<PointerHand>,
    /// The clock of loops and devices.
    pub clock: MonotonicClock,
    /// Requested scheduling.
    pub request: Request,
    /// Limits between renderer and device.
    pub limits: Box<dyn Fn(&Capabilities) -> SafetyParams + Send>,
    /// Duration of a loop in whole periods, including missed ones; `None`: until it is stopped.
    pub duration: Option<Duration>,
    /// MetadataOf of recordings.
    pub metadata: MetadataOf,
    /// Folder of recordings that clients request.
    pub folder: PathBuf,
    /// File of a recording that begins with the first tick, for a single rendering.
    pub record: Option<PathBuf>,
}

impl Running {
    pub(super) fn new(setup: Setup, stop: StopFlag, hub: Arc<Hub>) -> Self {
        let settings = Settings::new(&setup.scene, &setup.methods);
        let mut limits = Limits::around(&settings, &setup.scene);
        if !setup.devices.any_period() {
            limits.period_s = [settings.period; 2];
        }
        Self {
            limits,
            settings,
            setup,
            hub,
            stop_lanes: stop.below(),
            stop,
            lanes: Vec::new(),
            runs: 0,
            recorded_since: 0.0,
            recording_failed: None,
            endings: Vec::new(),
            written: Vec::new(),
            failed: None,
            restarts: Pace::new(BEGINNINGS.0, BEGINNINGS.1),
            recordings: Pace::new(BEGINNINGS.0, BEGINNINGS.1),
            notes: [(Pace::new(NOTES.0, NOTES.1), 0); 2],
            states: Pace::new(STATES.0, STATES.1),
            is_state_due: false,
            holder: None,
            hand_sent: Instant::now(),
        }
    }

    /// Stops the loops, so that no force is on, and restarts them.
    pub(super) fn restart(&mut self) -> Result<(), String> {
        let was_recording = self.lanes.iter().any(|lane| lane.recording().is_some());
        self.stop_lanes();
        if was_recording {
            self.end_recordings();
            let text = "the recording ended with the loop; a new one can be started";
            self.tell_note("recording", text);
        }
        let at = self.lanes.first().and_then(Lane::position);
        let mut carried: Vec<Carried> = Vec::new();
        for lane in self.lanes.drain(..) {
            carried.push((lane.position(), lane.into_device()));
        }
        if !self.setup.devices.resume() {
            carried.clear();
        }
        self.runs = self.runs.wrapping_add(1);
        let opened = self.open_lanes(carried, at, false);
        let failed = opened.map_err(|error| error.to_string()).err();
        self.failed.clone_from(&failed);
        failed.map_or(Ok(()), |text| {
            // If a device cannot be opened, no rendering runs: the page shows all requested renderings or none.
            self.stop_lanes();
            self.end_recordings();
            self.lanes.clear();
            self.hub
                .tell_all(ServerMessage::Ended { text: &text }.text());
            Err(text)
        })
    }

    /// Begins the first time.
    pub(super) fn start_lanes(&mut self) -> Result<(), SessionError> {
        self.open_lanes(Vec::new(), None, true)
    }

    fn open_lanes(
        &mut self,
        carried: Vec<Carried>,
        at: Option<f64>,
        record: bool,
    ) -> Result<(), SessionError> {
        self.stop_lanes = self.stop.below();
        let mut carried = carried.into_iter();
        let at = at.filter(|_| self.setup.devices.resume());
        let mut renderings = self.settings.renderings(&self.setup.scene)?;
        let mut devices = Vec::new();
        for rendering in &mut renderings {
            // A new rendering starts at the position of the first.
            let (at, device) = carried.next().unwrap_or((at, None));
            if let Some(at) = at {
                make_room(rendering, at);
            }
            devices.push(match device {
                Some(device) => device,
                None => self.setup.devices.open(at)?,
            });
        }
        let mut recordings: Vec<Option<LaneRecording>> = Vec::new();
        let first = self.setup.record.clone().filter(|_| record);
        for (lane, placed) in devices.iter().enumerate() {
            let path = first.as_ref().map(|path| self.path_of(path, lane));
            let device = placed.device.capabilities();
            recordings.push(match path {
                Some(path) => {
                    let begun = self.begin_recording(path, lane, device, 0)?;
                    Some(begun.with_the_first_tick())
                }
                None => None,
            });
        }
        let most = self.setup.duration.map(|duration| {
            let periods = duration.as_secs_f64() / self.settings.period;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a positive number of periods; a cast is clamped"
            )]
            let periods = (periods * (1.0 - 1e-12)).ceil() as u64;
            periods
        });
        let methods: Vec<_> = self.settings.lanes.iter().map(|lane| lane.method).collect();
        let rendered = methods.into_iter().zip(renderings);
        for ((placed, rendering), recording) in devices.into_iter().zip(rendered).zip(recordings) {
            let run = Run {
                clock: &self.setup.clock,
                request: self.setup.request,
                limits: (self.setup.limits)(placed.device.capabilities()),
                stop: &self.stop_lanes,
                most,
            };
            let lane = Lane::start(placed, rendering, &run, recording)?;
            self.lanes.push(lane);
        }
        Ok(())
    }

    fn stop_lanes(&mut self) {
        self.stop_lanes.raise();
        for lane in &mut self.lanes {
            lane.finish(|_| {});
        }
    }

    /// Ends everything.
    pub(super) fn finish(mut self) -> SessionEnd {
        self.stop_lanes();
        self.end_recordings_of_ended();
        for ending in self.endings.drain(..) {
            let written = ending.finish();
            if let Err(error) = &written.ticks {
                // Notify the connected clients; new clients receive the same message.
                let text = error.to_string();
                self.hub
                    .tell_all(ServerMessage::Ended { text: &text }.text());
            }
            self.written.push(written);
        }
        let text = "palpate live has ended";
        self.hub.tell_all(ServerMessage::Ended { text }.text());
        self.hub.close();
        let mut lanes = Vec::new();
        for (lane, choice) in self.lanes.into_iter().zip(&self.settings.lanes) {
            let is_its = |written: &Written| lane.recorded() == Some(&written.path);
            let recording = self.written.iter().position(is_its);
            let recording = recording.map(|index| self.written.remove(index));
            let capabilities = lane.capabilities().clone();
            let Some((account, end, answers)) = lane.into_account() else {
                continue;
            };
            lanes.push(LaneEnd {
                scene: self.settings.scene(&self.setup.scene, *choice),
                capabilities,
                end,
                answers,
                account,
                recording,
            });
        }
        // The recordings ended in arbitrary order.
        self.written.sort_by(|one, other| one.path.cmp(&other.path));
        SessionEnd {
            lanes,
            recordings: self.written,
            failed: self.failed,
        }
    }

    /// Starts a recording of every rendering.
    pub(super) fn record(&mut self) -> Result<(), String> {
        if self.lanes.iter().any(|lane| lane.recording().is_some()) {
            return Err("a recording is running; end it first".to_owned());
        }
        if !self.lanes.iter().any(Lane::is_running) {
            return Err("the loop is over; restart it first".to_owned());
        }
        if !self.recordings.take(Instant::now()) {
            return Err("recordings start too often; allowed: 4 per second".to_owned());
        }
        let name = self.free_name();
        self.recording_failed = None;
        let mut recordings = Vec::new();
        for index in 0..self.lanes.len() {
            let generation = self.lanes[index].generation();
            let capabilities = self.lanes[index].capabilities().clone();
            let path = self.path_of(&name, index);
            let begun = self.begin_recording(path, index, &capabilities, generation);
            recordings.push(begun?);
        }
        self.recorded_since = self.lanes.first().map_or(0.0, Lane::time);
        for (lane, recording) in self.lanes.iter_mut().zip(recordings) {
            lane.record(recording);
        }
        Ok(())
    }

    fn begin_recording(
        &self,
        path: PathBuf,
        lane: usize,
        device: &Capabilities,
        generation: u32,
    ) -> Result<LaneRecording, String> {
        let scene = self
            .settings
            .scene(&self.setup.scene, self.settings.lanes[lane]);
        let metadata = (self.setup.metadata)(&scene, device)?;
        LaneRecording::begin(path, &metadata, generation).map_err(|error| error.to_string())
    }

    /// `live-001.mcap`, or the next number that nothing has.
    fn free_name(&self) -> PathBuf {
        let number = |file: std::fs::DirEntry| -> Option<u32> {
            let name = file.file_name();
            let name = name.to_str()?.strip_prefix("live-")?;
            let digits = name.find(|letter: char| !letter.is_ascii_digit());
            name[..digits.unwrap_or(name.len())].parse().ok()
        };
        let files = std::fs::read_dir(&self.setup.folder);
        let files = files.into_iter().flatten().flatten();
        let taken: BTreeSet<u32> = files.filter_map(number).collect();
        let mut number = 1;
        while taken.contains(&number) {
            number += 1;
        }
        self.setup.folder.join(format!("live-{number:03}.mcap"))
    }

    /// Returns the file of a rendering; with two, its name contains number and method.
    fn path_of(&self, path: &std::path::Path, lane: usize) -> PathBuf {
        if self.settings.lanes.len() == 1 {
            return path.to_path_buf();
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let method = self.settings.lanes[lane].method.name();
        path.with_file_name(format!("{stem}-{}-{method}.mcap", lane + 1))
    }

    pub(super) fn end_recordings(&mut self) {
        for lane in &mut self.lanes {
            self.endings.extend(lane.end_recording());
        }
    }

    /// A recording ends with its loop.
    pub(super) fn end_recordings_of_ended(&mut self) {
        for lane in self.lanes.iter_mut().filter(|lane| !lane.is_running()) {
            self.endings.extend(lane.end_recording_with_loop());
        }
    }

    /// Reports the results of ended recordings, and ends recordings that cannot be written.
    pub(super) fn watch_recordings(&mut self) {
        let failing = |lane: &&mut Lane| lane.recording().is_some_and(LaneRecording::has_failed);
        for lane in self.lanes.iter_mut().filter(|lane| failing(lane)) {
            self.endings.extend(lane.end_recording());
        }
        while let Some(index) = self.endings.iter().position(Ending::is_over) {
            let written = self.endings.swap_remove(index).finish();
            let name = written.path.display();
            let text = match &written.ticks {
                Ok(ticks) => format!("{name} is written: {ticks} ticks, {} lost", written.lost),
                Err(error) => {
                    let text = error.to_string();
                    self.recording_failed = Some(text.clone());
                    text
                }
            };
            self.tell_note("recording", &text);
            self.written.push(written);
        }
    }

    fn tell_note(&self, kind: &str, text: &str) {
        let note = ServerMessage::Note {
            lane: 0,
            t_s: self.lanes.first().map_or(0.0, Lane::time),
            kind,
            text,
        };
        self.hub.tell_all(note.text());
    }
}
