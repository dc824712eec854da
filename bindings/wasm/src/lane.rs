//! One rendering of the playground: the program's loop on a virtual device, with a clock that the page advances.

use palpate_device::clock::{Clock as _, SteppedClock};
use palpate_live::message::ServerMessage;
use palpate_live::rows::Rows;
use palpate_record::recording::Row;
use palpate_rt::safety::{OscillationParams, SafetyParams, SafetyStop};
use palpate_rt::{ControlLoop, Listener, Message, Note, Parameters, Rendering, tap};
use palpate_study::sim::device::{PointerDevice, PointerHand, PointerParams};

/// Capacity for ticks, contacts and notes of one call of [`Lane::advance`].
const ROOM: usize = 1 << 14;
/// Largest number of ticks per call: each needs an entry for itself and its contact, and may have notes.
const MAX_TICKS: u64 = (ROOM / 4) as u64;
/// Largest number of notes that one call reports; the rest is counted.
const MAX_NOTES: usize = 16;

/// A loop, its device, and its rows that have not been shown.
pub struct Lane {
    control: ControlLoop<PointerDevice<SteppedClock>, SteppedClock>,
    parameters: Parameters,
    clock: SteppedClock,
    listener: Listener,
    period: f64,
    ticks: u64,
    rows: Rows,
    frames: u32,
    safety_stop: Option<Stopped>,
    /// Last known device position `[m]`.
    position: Option<f64>,
}

/// A safety stop, which holds the force at 0.
#[derive(Clone, Debug)]
pub struct Stopped {
    /// Reason.
    pub why: String,
    /// Method whose held forces caused the stop, if a method did.
    pub method: Option<&'static str>,
}

impl Lane {
    /// Starts a loop that renders `rendering` on a device in `hand`. `cuts_off`: whether a contact that generates
    /// energy causes a safety stop, as in `palpate live`.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn start(
        params: PointerParams,
        hand: &PointerHand,
        rendering: Rendering,
        cuts_off: bool,
    ) -> Result<Self, String> {
        let clock = SteppedClock::new();
        let device = PointerDevice::new(params, hand, clock.clone()).map_err(in_words)?;
        let mut limits = SafetyParams::default();
        if !cuts_off {
            limits.oscillation = OscillationParams {
                energy: f64::INFINITY,
                ..limits.oscillation
            };
        }
        let (tap, listener) = tap(ROOM);
        let mut control = ControlLoop::new(device, clock.clone(), rendering, limits)
            .map_err(in_words)?
            .tapped(tap);
        let parameters = control
            .parameters()
            .ok_or("the parameters of the loop are already in use")?;
        let period = rendering.loop_params.period;
        Ok(Self {
            control,
            parameters,
            clock,
            listener,
            period,
            ticks: 0,
            rows: Rows::new(period),
            frames: 0,
            safety_stop: None,
            position: None,
        })
    }

    /// Returns the time of the run `[s]`.
    pub fn time(&self) -> f64 {
        self.clock.now().as_secs_f64()
    }

    /// Advances to this time `[s]`, adds messages to `notes` under this number, and returns the number of ticks.
    pub fn advance(&mut self, until: f64, number: usize, notes: &mut Vec<String>) -> u32 {
        let mut made = 0;
        while self.ticks as f64 * self.period <= until && u64::from(made) < MAX_TICKS {
            self.control.tick();
            self.ticks += 1;
            made += 1;
        }
        self.listen(number, notes);
        made
    }

    fn listen(&mut self, number: usize, notes: &mut Vec<String>) {
        let (mut messages, mut unsent) = (0, 0);
        for heard in self.listener.by_ref() {
            match heard {
                Message::Tick(tick, contacts, _, _) => {
                    if let Some(row) = Row::new(tick, &contacts).next() {
                        self.position = Some(row.contact.device_position);
                        self.rows.add(&row);
                    }
                }
                Message::Note(noted) => {
                    match noted.note {
                        Note::Stopped(safety_stop) => {
                            self.safety_stop = Some(Stopped {
                                why: safety_stop.to_string(),
                                method: None,
                            });
                        }
                        Note::Oscillated { method, .. } => {
                            self.safety_stop = Some(Stopped {
                                why: SafetyStop::Oscillation.to_string(),
                                method: Some(method),
                            });
                        }
                        _ => {}
                    }
                    if messages == MAX_NOTES {
                        unsent += 1;
                        continue;
                    }
                    messages += 1;
                    let event = noted.event();
                    notes.push(note(number, event.time, &event.kind, &event.text));
                }
            }
        }
        if unsent > 0 {
            let text = format!("{unsent} further events");
            notes.push(note(number, self.time(), "unsent", &text));
        }
        if self.control.safety_stop().is_none() {
            self.safety_stop = None;
        }
    }

    /// Returns the active safety stop.
    pub fn safety_stop(&self) -> Option<&Stopped> {
        self.safety_stop.as_ref()
    }

    /// Resets the safety stop.
    pub fn rearm(&self) {
        let rearm = self.control.rearm();
        rearm.store(true, std::sync::atomic::Ordering::Release);
    }

    /// Changes the rendering from the next tick on.
    ///
    /// # Errors
    /// A change that a running loop cannot make.
    pub fn change(&mut self, rendering: Rendering) -> Result<(), String> {
        self.parameters
            .change(rendering)
            .map(|_| ())
            .map_err(in_words)
    }

    /// Returns the last known position of the device `[m]`.
    pub fn position(&self) -> Option<f64> {
        self.position.filter(|position| position.is_finite())
    }

    /// Returns the new rows as a frame of samples, or `None` if there are none.
    pub fn frame(&mut self, number: u8, run: u32) -> Option<Vec<u8>> {
        let frame = self.rows.take_frame(number, run)?;
        let bytes = frame.numbered(self.frames);
        self.frames = self.frames.wrapping_add(1);
        Some(bytes)
    }
}

fn note(lane: usize, t_s: f64, kind: &str, text: &str) -> String {
    ServerMessage::Note {
        lane,
        t_s,
        kind,
        text,
    }
    .text()
}

fn in_words(error: impl std::fmt::Display) -> String {
    error.to_string()
}
