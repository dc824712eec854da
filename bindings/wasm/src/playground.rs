//! One or two loops with the same hand, and the messages of a page.

use palpate_live::message::{
    ClientMessage, ClientRequest, DeviceSaid, LaneState, ServerMessage, Set, parse,
};
use palpate_live::{Limits, Settings, make_room};
use palpate_rt::safety::SafetyParams;
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Delay, Scene};
use palpate_study::sim::device::{PointerHand, PointerParams};
use serde::{Deserialize, Serialize};

use crate::lane::Lane;

/// Largest number of renderings: two methods side by side.
const LANES: usize = 2;
/// Largest hand position along the axis `[m]`.
const REACH: f64 = 1.0;
/// Range of the mass of the virtual device `[kg]`.
const DEVICE_MASS: [f64; 2] = [0.01, 5.0];
/// Range of the delay of the virtual device `[s]`.
const DEVICE_DELAY: [f64; 2] = [0.0, 0.02];

/// Parameters of the virtual device that a page can change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceChoice {
    /// Mass `[kg]`.
    pub mass_kg: f64,
    /// Delay from a sample to the start of its force `[s]`. It is also the model value of the renderer.
    pub delay_s: f64,
    /// Whether a contact that generates energy causes a safety stop, as in `palpate live`.
    pub cut_off: bool,
}

/// A rejected message.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// The type of the message.
    pub about: &'static str,
    /// Reason, and the allowed values.
    pub why: String,
}

impl Refused {
    /// Returns the message for the page.
    #[must_use]
    pub fn text(&self) -> String {
        ServerMessage::Refused {
            about: self.about,
            text: &self.why,
        }
        .text()
    }
}

/// Loops in simulated time, and their changeable settings.
pub struct Playground {
    scene: Scene,
    settings: Settings,
    limits: Limits,
    device: DeviceChoice,
    hand: PointerHand,
    lanes: Vec<Lane>,
    /// Number of starts of the loops.
    runs: u32,
    notes: Vec<String>,
}

impl Playground {
    /// Opens a scene of one contact, rendered by its method and, side by side, by the sampled spring. The hand holds
    /// the device in its position.
    ///
    /// # Errors
    /// A fault of the scene, with line and column.
    pub fn open(source: &str) -> Result<Self, String> {
        let scene = ContactFile::parse("scene", source)
            .map_err(|errors| errors.to_string())?
            .scene;
        let methods = [MethodName::Basic, scene.method];
        let settings = Settings::new(&scene, &methods);
        let mut playground = Self {
            limits: Limits::around(&settings, &scene),
            settings,
            device: DeviceChoice {
                mass_kg: scene.device.mass(),
                delay_s: match scene.delay {
                    Delay::Periods { samples, fraction } => {
                        (samples as f64 + fraction) * scene.loop_params.period
                    }
                    Delay::Seconds(seconds) => seconds,
                },
                cut_off: false,
            },
            hand: PointerHand::at(scene.device.position()),
            scene,
            lanes: Vec::new(),
            runs: 0,
            notes: Vec::new(),
        };
        playground.lanes = playground.begin(&playground.settings, playground.device, false)?;
        Ok(playground)
    }

    /// Returns the scene with the selected device.
    fn scene_on(&self, device: DeviceChoice) -> Scene {
        let mut scene = self.scene.clone();
        // A scene file cannot contain a recorded hand, whose model has the mass.
        if let Some(mass) = scene.device.mass_mut() {
            *mass = device.mass_kg;
        }
        scene.delay = Delay::Seconds(device.delay_s);
        scene
    }

    /// Creates the loops. With `goes_on` the devices keep their positions.
    fn begin(
        &self,
        settings: &Settings,
        device: DeviceChoice,
        goes_on: bool,
    ) -> Result<Vec<Lane>, String> {
        let scene = self.scene_on(device);
        let usual = PointerParams::new(&scene);
        let first = self.lanes.first().and_then(Lane::position);
        let renderings = settings.renderings(&scene)?;
        let lanes = renderings.into_iter().enumerate();
        lanes
            .map(|(number, mut rendering)| {
                let own = self.lanes.get(number).and_then(Lane::position);
                let at = own.or(first).filter(|_| goes_on);
                if let Some(at) = at {
                    make_room(&mut rendering, at);
                }
                let params = PointerParams {
                    position: at.unwrap_or(usual.position),
                    ..usual
                };
                Lane::start(params, &self.hand, rendering, device.cut_off)
            })
            .collect()
    }

    /// Returns the greeting.
    #[must_use]
    pub fn hello(&self) -> String {
        let device = DeviceSaid {
            name: "pointer",
            axes: 1,
            pointer: true,
            largest_force_n: Some(SafetyParams::default().largest_force),
            lanes: LANES,
        };
        ServerMessage::hello(&self.scene, self.limits, device).text()
    }

    /// Returns the current rendering and the device.
    #[must_use]
    pub fn state(&self) -> String {
        #[derive(Serialize)]
        struct State<'a> {
            #[serde(flatten)]
            said: ServerMessage<'a>,
            device: DeviceChoice,
        }
        let lanes = self.settings.lanes.iter().zip(&self.lanes);
        let said = ServerMessage::State {
            stiffness_n_per_m: self.settings.stiffness,
            mass_kg: self.settings.mass,
            virtual_force_n: self.settings.virtual_force,
            period_s: self.settings.period,
            model: self.settings.model(&self.scene_on(self.device)),
            lanes: lanes
                .map(|(choice, lane)| LaneState {
                    choice: *choice,
                    running: true,
                    safety_stop: lane
                        .safety_stop()
                        .map(|safety_stop| safety_stop.why.clone()),
                    safety_stop_method: lane
                        .safety_stop()
                        .and_then(|safety_stop| safety_stop.method),
                })
                .collect(),
            recording: None,
            hand_m: self.hand.target(),
        };
        let device = self.device;
        serde_json::to_string(&State { said, device }).unwrap_or_default()
    }

    /// Handles a message: those of `palpate live` except recordings, and
    /// `{"type": "device", "mass_kg": , "delay_s": , "cut_off": }`.
    ///
    /// # Errors
    /// A fault of the message, and the allowed values.
    pub fn hear(&mut self, text: &str) -> Result<(), Refused> {
        #[derive(Deserialize)]
        #[serde(tag = "type", rename_all = "snake_case")]
        enum Own {
            Device(DeviceChoice),
        }
        let refused = |about| move |why| Refused { about, why };
        if is_about_device(text) {
            return serde_json::from_str(text)
                .map_err(|error| error.to_string())
                .and_then(|Own::Device(device)| self.set_device(device))
                .map_err(refused("device"));
        }
        match parse(text) {
            ClientMessage::Request(ClientRequest::Hand(target)) => {
                self.lead(target).map_err(refused("hand"))
            }
            ClientMessage::Request(ClientRequest::Set(set)) => {
                self.set(&set).map_err(refused("set"))
            }
            ClientMessage::Request(ClientRequest::Restart) => {
                self.restart().map_err(refused("restart"))
            }
            ClientMessage::Request(ClientRequest::Rearm(lane)) => {
                self.rearm(lane).map_err(refused("rearm"))
            }
            ClientMessage::Request(ClientRequest::Record(_)) => Err(Refused {
                about: "record",
                why: "the playground records nothing; palpate live does".into(),
            }),
            ClientMessage::Request(ClientRequest::Tool { .. }) => Err(Refused {
                about: "tool",
                why: "the hand of a single contact moves along one axis only".into(),
            }),
            ClientMessage::Request(ClientRequest::Turn { .. }) => Err(Refused {
                about: "turn",
                why: "a single contact has no rotation".into(),
            }),
            ClientMessage::Refused(about, why) => Err(Refused { about, why }),
            ClientMessage::Unknown(why) => Err(Refused {
                about: "unknown",
                why: why.into(),
            }),
        }
    }

    fn lead(&self, target: Option<f64>) -> Result<(), String> {
        match target {
            None => self.hand.disable_output(),
            Some(target) if target.abs() <= REACH => self.hand.move_to(target),
            Some(target) => {
                return Err(format!(
                    "position_m is {target}; allowed: -{REACH} to {REACH}, or null"
                ));
            }
        }
        Ok(())
    }

    fn set(&mut self, set: &Set) -> Result<(), String> {
        let new = self.settings.with(set, &self.limits, LANES)?;
        let renderings = new.renderings(&self.scene_on(self.device))?;
        let is_another_loop =
            new.period != self.settings.period || new.lanes.len() != self.settings.lanes.len();
        if is_another_loop {
            return self.begin_with(new, self.device, true);
        }
        for (lane, rendering) in self.lanes.iter_mut().zip(renderings) {
            lane.change(rendering)?;
        }
        self.settings = new;
        Ok(())
    }

    fn set_device(&mut self, device: DeviceChoice) -> Result<(), String> {
        for (name, value, [least, most]) in [
            ("mass_kg", device.mass_kg, DEVICE_MASS),
            ("delay_s", device.delay_s, DEVICE_DELAY),
        ] {
            if !(least..=most).contains(&value) {
                return Err(format!("{name} is {value}; allowed: {least} to {most}"));
            }
        }
        self.begin_with(self.settings.clone(), device, true)
    }

    /// Resets loops, object, device and hand to the scene.
    fn restart(&mut self) -> Result<(), String> {
        self.hand.move_to(self.scene.device.position());
        self.begin_with(self.settings.clone(), self.device, false)
    }

    /// Restarts with these settings. On an error nothing changes.
    fn begin_with(
        &mut self,
        settings: Settings,
        device: DeviceChoice,
        goes_on: bool,
    ) -> Result<(), String> {
        let lanes = self.begin(&settings, device, goes_on)?;
        self.lanes = lanes;
        self.settings = settings;
        self.device = device;
        self.runs = self.runs.wrapping_add(1);
        Ok(())
    }

    fn rearm(&self, lane: usize) -> Result<(), String> {
        let lanes = self.lanes.len();
        let rearmed = self.lanes.get(lane).map(Lane::rearm);
        rearmed.ok_or_else(|| format!("lane is {lane}; allowed: 0 to {}", lanes - 1))
    }

    /// Advances all renderings to this time of the run `[s]`, within the limit of one call, and returns the number
    /// of ticks.
    pub fn advance(&mut self, until: f64) -> u32 {
        let notes = &mut self.notes;
        let lanes = self.lanes.iter_mut().enumerate();
        lanes
            .map(|(number, lane)| lane.advance(until, number, notes))
            .sum()
    }

    /// Returns the time of the run that all renderings have reached `[s]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        let times = self.lanes.iter().map(Lane::time);
        times.fold(f64::INFINITY, f64::min)
    }

    /// Returns the new rows of a rendering as a frame of samples.
    pub fn frame(&mut self, lane: u32) -> Option<Vec<u8>> {
        let number = u8::try_from(lane).ok()?;
        let runs = self.runs;
        self.lanes.get_mut(usize::from(number))?.frame(number, runs)
    }

    /// Returns the messages since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }
}

fn is_about_device(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Typed<'a> {
        #[serde(borrow)]
        r#type: std::borrow::Cow<'a, str>,
    }
    serde_json::from_str::<Typed<'_>>(text).is_ok_and(|typed| typed.r#type == "device")
}
