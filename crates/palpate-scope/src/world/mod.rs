//! A session on a world: one loop or two, a thread that listens to them, and what clients ask for. The loops wait for none
//! of it.

mod coarse;
mod lane;
mod shown;

use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device, Vector};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{Account, Ending, LoopEnd, Note, RenderedWorld, StopFlag};
use palpate_scene::world::WorldScene;
use palpate_sim::device::SpatialHand;

use crate::hub::{ClientId, Hub};
use crate::message::{ClientRequest, ServerMessage};
use crate::pace::Pace;
use crate::session::{Command, Session, SessionError, Turns};
use lane::{Lane, Run};

/// Most lanes: what the page has room for.
pub const MOST_LANES: usize = 2;
/// Notes of all lanes that are told at once, and then each second.
const NOTES: (f64, f64) = (32.0, 20.0);
/// Restarts at once and then each second: more than any hand does.
const RESTARTS: (f64, f64) = (8.0, 4.0);
/// By how much the length of a quaternion may be another than 1: a page has few digits.
const LENGTH_SLACK: f64 = 1e-3;
/// How far from where the tool begins a hand may reach along each axis `[m]`.
const REACH: f64 = 1.0;

/// A device that is open, and the world that is rendered on it.
pub struct WorldLane {
    /// The device.
    pub device: Box<dyn Device>,
    /// The world, with where the device stands in it.
    pub world: RenderedWorld,
    /// Limits between renderer and device.
    pub limits: SafetyParams,
}

/// Opens the device of a lane, by its number, and its world.
///
/// The error is why it cannot, in words.
pub type OpenLane = Box<dyn FnMut(usize) -> Result<WorldLane, String> + Send>;

/// What a session on a world is set up with.
pub struct WorldSetup {
    /// The world, for the page.
    pub scene: WorldScene,
    /// A method for each lane, by name; one or two.
    pub methods: Vec<&'static str>,
    /// Where lanes come from.
    pub open: OpenLane,
    /// The hand that the page leads, if it leads one; its lanes can begin anew.
    pub hand: Option<SpatialHand>,
    /// The clock of loops and devices.
    pub clock: MonotonicClock,
    /// What the machine is asked for.
    pub request: Request,
    /// How long loops last, if not until they are stopped.
    pub duration: Option<Duration>,
}

/// How a loop on a world has ended.
pub type WorldEnded = LoopEnd<Box<dyn Device>, MonotonicClock, RenderedWorld>;

/// How a lane has ended, for a report.
pub struct WorldLaneEnd {
    /// Name of its method.
    pub method: &'static str,
    /// The device.
    pub capabilities: Capabilities,
    /// How the loop has ended.
    pub end: WorldEnded,
    /// What the machine granted.
    pub answers: Vec<Answer>,
    /// What was heard of the loop.
    pub account: Account,
}

/// How a session has ended.
pub struct WorldSessionEnd {
    /// The loops that ran last.
    pub lanes: Vec<WorldLaneEnd>,
    /// Why loops that were to begin anew did not, if they did not.
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
        if !(1..=MOST_LANES).contains(&methods) {
            return Err(SessionError::Other(format!(
                "{methods} methods; the page shows one, or two side by side"
            )));
        }
        Self::begin(stop, |hub, stop| {
            let mut running = Running {
                hub,
                stop_lanes: stop.below(),
                stop,
                lanes: Vec::new(),
                runs: 0,
                holder: None,
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
    /// Who moved the hand last.
    holder: Option<ClientId>,
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
                if self.holder == Some(client) {
                    self.holder = None;
                    if let Some(hand) = &self.setup.hand {
                        hand.let_go();
                    }
                }
                return;
            }
            Command::Request(client, request) => (client, request),
        };
        let (about, done) = match request {
            ClientRequest::Tool(place) => ("tool", self.lead(client, place)),
            ClientRequest::Turn(orientation) => ("turn", self.turn(orientation)),
            ClientRequest::Restart => ("restart", self.restart()),
            ClientRequest::Rearm(number) => ("rearm", self.rearm(number)),
            ClientRequest::Hand(_) => (
                "hand",
                Err("a world is led by `tool`, with three numbers".to_owned()),
            ),
            ClientRequest::Set(_) => ("set", Err("what a world is stands in its file".to_owned())),
            ClientRequest::Record(_) => (
                "record",
                Err("`palpate record` records a world; this page does not yet".to_owned()),
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
            let has_ended = lane.listen(|noted| {
                if matches!(noted.note, Note::Ended(_)) || !notes.take(Instant::now()) {
                    return;
                }
                let event = noted.event();
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
                let mut text = format!("lane {}: {}", number + 1, end.ending.text());
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
        let start = self.setup.scene.devices.first().map(|one| one.position);
        if let Some((hand, start)) = self.setup.hand.as_ref().zip(start) {
            hand.move_to(start);
            hand.turn_back();
        }
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

    /// Leads the hand to a place, or lets go.
    fn lead(&mut self, client: ClientId, place: Option<Vector>) -> Result<(), String> {
        let Some(hand) = &self.setup.hand else {
            return Err("this device is not led from here; --device pointer is".into());
        };
        let start = self.setup.scene.devices.first().map(|one| one.position);
        let start = start.unwrap_or_default();
        self.holder = match place {
            None => {
                hand.let_go();
                None
            }
            Some(place) => {
                let reaches = place
                    .iter()
                    .zip(start)
                    .all(|(to, from)| (to - from).abs() <= REACH);
                if !reaches {
                    return Err(format!(
                        "position_m is {place:?}; allowed: within {REACH} m of {start:?} along each axis, or null"
                    ));
                }
                hand.move_to(place);
                Some(client)
            }
        };
        Ok(())
    }

    /// Turns the hand, whoever leads it, or turns it back to as it began.
    fn turn(&mut self, orientation: Option<[f64; 4]>) -> Result<(), String> {
        let Some(hand) = &self.setup.hand else {
            return Err("this device is not led from here; --device pointer is".into());
        };
        let turns = self.setup.scene.devices.first().and_then(|one| one.turning);
        if turns.is_none() {
            return Err("this device has three axes, and turns nothing".into());
        }
        match orientation {
            None => hand.turn_back(),
            Some(orientation) => {
                let length = orientation
                    .iter()
                    .map(|part| part * part)
                    .sum::<f64>()
                    .sqrt();
                let is_unit = (length - 1.0).abs() <= LENGTH_SLACK;
                if !is_unit {
                    return Err(format!(
                        "orientation is {orientation:?}; allowed: a quaternion of length 1, or null"
                    ));
                }
                hand.turn_to(orientation);
            }
        }
        Ok(())
    }

    fn restart(&mut self) -> Result<(), String> {
        if self.setup.hand.is_none() {
            return Err("only a world on --device pointer begins anew from here".into());
        }
        if !self.restarts.take(Instant::now()) {
            return Err("the loops begin anew too often; allowed: 4 times each second".into());
        }
        self.stop_lanes.raise();
        for lane in &mut self.lanes {
            lane.finish();
        }
        // They are gone before their successors come.
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
        let capabilities = self.lanes.first().map(|lane| &lane.capabilities);
        let hello = shown::hello(
            &self.setup.scene,
            capabilities,
            self.setup.hand.is_some(),
            self.setup.methods.len(),
        );
        self.hub.set_hello(hello);
        self.hub.set_state(self.state());
    }

    fn state(&self) -> String {
        let hand = self.setup.hand.as_ref();
        let target = hand.and_then(SpatialHand::target);
        let orientation = hand.and_then(SpatialHand::orientation);
        shown::state(&self.setup.scene, &self.lanes, target, orientation)
    }
}
