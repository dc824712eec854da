//! A session on a world, on one device or several: one loop or two, a thread that listens to them, and what clients ask
//! for. The loops wait for none of it.

mod coarse;
mod hands;
mod lane;
mod shown;

use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{Account, Ending, LoopEnd, Note, RenderedWorld, StopFlag};
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::SpatialHand;

use crate::hub::Hub;
use crate::message::{ClientRequest, ServerMessage};
use crate::pace::Pace;
use crate::session::{Command, Session, SessionError, Turns};
use hands::Hands;
use lane::{Lane, Run};

/// Most lanes: what the page has room for.
pub const MAX_LANES: usize = 2;
/// Notes of all renderings: burst size, and rate per second.
const NOTES: (f64, f64) = (32.0, 20.0);
/// Restarts at once and then each second: more than any hand does.
const RESTARTS: (f64, f64) = (8.0, 4.0);

/// The devices of a loop that are open, and the world that is rendered on them.
pub struct WorldLane {
    /// The devices, one for each tool of the world in their order, with the limits between renderer and device.
    pub devices: Vec<(Box<dyn Device>, SafetyParams)>,
    /// The world, with the frame of each device.
    pub world: RenderedWorld,
}

/// Opens the devices and the world of a rendering, by its number.
///
/// The error is the reason as text.
pub type OpenLane = Box<dyn FnMut(usize) -> Result<WorldLane, String> + Send>;

/// Parameters for a session on a world.
pub struct WorldSetup {
    /// The world, for the page.
    pub scene: WorldScene,
    /// Method of each rendering, by name; one or two.
    pub methods: Vec<&'static str>,
    /// Source of renderings.
    pub open: OpenLane,
    /// Hands that the page moves, in the order of the devices; `None` for a device that it does not move. Renderings
    /// can restart if the page moves all hands.
    pub hands: Vec<Option<SpatialHand>>,
    /// The clock of loops and devices.
    pub clock: MonotonicClock,
    /// Requested scheduling.
    pub request: Request,
    /// Duration of the loops; `None`: until they are stopped.
    pub duration: Option<Duration>,
}

/// End of a loop on a world.
pub type WorldEnded = LoopEnd<Box<dyn Device>, MonotonicClock, RenderedWorld>;

/// Final state of a rendering, for a report.
pub struct WorldLaneEnd {
    /// Name of its method.
    pub method: &'static str,
    /// The devices.
    pub capabilities: Vec<Capabilities>,
    /// End of the loop.
    pub end: WorldEnded,
    /// Scheduling that the system granted.
    pub answers: Vec<Answer>,
    /// Data received from the loop.
    pub account: Account,
}

/// Result of a session.
pub struct WorldSessionEnd {
    /// The loops that ran last.
    pub lanes: Vec<WorldLaneEnd>,
    /// Reason why loops could not restart, if they did not.
    pub failed: Option<String>,
}

/// A session on a world.
pub type WorldSession = Session<WorldSessionEnd>;

impl Session<WorldSessionEnd> {
    /// Starts the loops and the thread that listens to them, until `stop` is raised.
    ///
    /// # Errors
    /// There are no methods or more than two, a device does not open, a limit is outside its range.
    pub fn of_world(setup: WorldSetup, stop: &StopFlag) -> Result<Self, SessionError> {
        let methods = setup.methods.len();
        if !(1..=MAX_LANES).contains(&methods) {
            return Err(SessionError::Other(format!(
                "{methods} methods; allowed: one, or two side by side"
            )));
        }
        Self::begin(stop, |hub, stop| {
            let mut running = Running {
                hands: Hands::new(&setup.scene, &setup.hands),
                hub,
                stop_lanes: stop.below(),
                stop,
                lanes: Vec::new(),
                runs: 0,
                notes: Pace::new(NOTES.0, NOTES.1),
                restarts: Pace::new(RESTARTS.0, RESTARTS.1),
                failed: None,
                setup,
            };
            running.start_lanes()?;
            running.greet();
            Ok(running)
        })
    }
}

struct Running {
    setup: WorldSetup,
    hub: Arc<Hub>,
    stop: StopFlag,
    stop_lanes: StopFlag,
    lanes: Vec<Lane>,
    runs: u32,
    hands: Hands,
    notes: Pace,
    restarts: Pace,
    failed: Option<String>,
}

impl Turns for Running {
    type End = WorldSessionEnd;

    fn answers(&self) -> Vec<Answer> {
        let first = self.lanes.first().map(|lane| lane.answers.clone());
        first.unwrap_or_default()
    }

    fn obey(&mut self, command: Command) {
        let (client, request) = match command {
            Command::Gone(client) => {
                self.hands.gone(client);
                return;
            }
            Command::Request(client, request) => (client, request),
        };
        let (about, done) = match request {
            ClientRequest::Tool { device, position } => {
                ("tool", self.hands.lead(client, device, position))
            }
            ClientRequest::Turn {
                device,
                orientation,
            } => ("turn", self.hands.turn(device, orientation)),
            ClientRequest::Restart => ("restart", self.restart()),
            ClientRequest::Rearm(number) => ("rearm", self.rearm(number)),
            ClientRequest::Hand(_) => (
                "hand",
                Err("a world needs `tool`, with three numbers".to_owned()),
            ),
            ClientRequest::Set(_) => ("set", Err("a world is defined by its file".to_owned())),
            ClientRequest::Record(_) => (
                "record",
                Err("this page cannot record a world; use `palpate run --record`".to_owned()),
            ),
        };
        if let Err(text) = done {
            let text = ServerMessage::Refused { about, text: &text }.text();
            self.hub.tell(client, text);
        }
    }

    fn runs(&self) -> u32 {
        self.runs
    }

    fn listen(&mut self) {
        let mut texts = Vec::new();
        for (number, lane) in self.lanes.iter_mut().enumerate() {
            let notes = &mut self.notes;
            let has_ended = lane.listen(|noted, event| {
                if matches!(noted.note, Note::Ended(_)) || !notes.take(Instant::now()) {
                    return;
                }
                texts.push(
                    ServerMessage::Note {
                        lane: number,
                        t_s: event.time,
                        kind: &event.kind,
                        text: &event.text,
                    }
                    .text(),
                );
            });
            let is_over = |end: &&WorldEnded| end.ending != Ending::Stopped;
            if has_ended && let Some(end) = lane.end().filter(is_over) {
                let mut text = format!("rendering {}: {}", number + 1, end.ending.text());
                if let Some(words) = &end.panic {
                    text = format!("{text}: {words}");
                }
                texts.push(ServerMessage::Ended { text: &text }.text());
            }
        }
        for text in texts {
            self.hub.tell_all(text);
        }
    }

    fn show(&mut self) {
        for (number, lane) in (0..).zip(&mut self.lanes) {
            for frame in lane.frames(number, self.runs) {
                self.hub.show(frame);
            }
        }
        self.hub.set_state(self.state());
    }

    fn tell_status(&mut self) {
        let lanes = self.lanes.iter().map(Lane::status).collect();
        self.hub.tell_all_counted(|clients| {
            let status = ServerMessage::Status {
                clients,
                lanes,
                recording: None,
            };
            status.text()
        });
    }

    fn is_over(&self) -> bool {
        self.setup.duration.is_some() && !self.lanes.iter().any(Lane::is_running)
    }

    fn finish(mut self) -> WorldSessionEnd {
        self.stop_lanes.raise();
        for lane in &mut self.lanes {
            lane.finish();
        }
        let lanes = self.lanes.drain(..).filter_map(Lane::into_end).collect();
        self.hub.close();
        WorldSessionEnd {
            lanes,
            failed: self.failed,
        }
    }
}

impl Running {
    fn start_lanes(&mut self) -> Result<(), SessionError> {
        self.stop_lanes = self.stop.below();
        self.runs = self.runs.wrapping_add(1);
        self.hands.begin();
        let mut lanes = Vec::new();
        for (number, method) in self.setup.methods.clone().into_iter().enumerate() {
            let opened = (self.setup.open)(number).map_err(SessionError::Other)?;
            let run = Run {
                clock: &self.setup.clock,
                request: self.setup.request,
                stop: &self.stop_lanes,
                duration: self.setup.duration,
            };
            lanes.push(Lane::start(method, opened, &run)?);
        }
        self.lanes = lanes;
        Ok(())
    }

    fn restart(&mut self) -> Result<(), String> {
        if !self.hands.are_all_led() {
            return Err("only a world on --device pointer can be restarted from the page".into());
        }
        if !self.restarts.take(Instant::now()) {
            return Err("restarts are too frequent; allowed: 4 per second".into());
        }
        self.stop_lanes.raise();
        for lane in &mut self.lanes {
            lane.finish();
        }
        // Drop the old loops before starting new ones.
        self.lanes.clear();
        match self.start_lanes() {
            Ok(()) => {
                self.failed = None;
                self.greet();
                Ok(())
            }
            Err(error) => {
                let text = error.to_string();
                self.hub
                    .tell_all(ServerMessage::Ended { text: &text }.text());
                self.failed = Some(text.clone());
                Err(text)
            }
        }
    }

    fn rearm(&self, number: usize) -> Result<(), String> {
        let lane = self.lanes.get(number);
        lane.map(Lane::rearm).ok_or_else(|| {
            format!(
                "lane is {number}; allowed: 0 to {}",
                self.lanes.len().max(1) - 1
            )
        })
    }

    fn greet(&self) {
        let capabilities = self.lanes.first().map(|lane| &lane.capabilities[..]);
        let hello = shown::hello(
            &self.setup.scene,
            capabilities.unwrap_or_default(),
            &self.hands,
            self.setup.methods.len(),
        );
        self.hub.set_hello(hello);
        self.hub.set_state(self.state());
    }

    fn state(&self) -> String {
        shown::state(&self.setup.scene, &self.lanes, &self.hands)
    }
}
