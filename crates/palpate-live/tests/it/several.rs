//! A session on a world of two devices: ownership of the hands, messages about each device, and the effect of a removed
//! device on the other.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench};
use palpate_live::message::{ClientRequest, LaneChoice, Set};
use palpate_live::{Command, Outgoing, Seat, WorldLane, WorldSession, WorldSetup};
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{Ending, RenderedWorld, StopFlag, WorldFrame};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::device::{SpatialHand, SpatialPointer};
use serde_json::Value;

const PATIENCE: Duration = Duration::from_secs(20);

fn scene() -> WorldScene {
    let text = include_str!("../../../../experiments/worlds/pinch.toml");
    // Out of 50 g the fingers fly off when the machine lets the loop wait for a tenth of a second. A cube that hardly
    // moves stays there.
    let heavy = text.replace("mass_kg = 0.05\n", "mass_kg = 500.0\n");
    assert_ne!(heavy, text);
    WorldFile::parse("pinch.toml", &heavy).unwrap().scene
}

/// Last wrench written to each finger.
type Written = Arc<Mutex<[Wrench; 2]>>;

/// A finger that can be pulled out.
struct Finger {
    pointer: SpatialPointer<MonotonicClock>,
    is_out: Arc<AtomicBool>,
    number: usize,
    written: Written,
}

impl Device for Finger {
    fn capabilities(&self) -> &Capabilities {
        self.pointer.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.is_out.load(Ordering::Acquire) {
            let kind = DeviceErrorKind::Disconnected;
            return Err(DeviceError::new(kind, "pulled out"));
        }
        self.pointer.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.written.lock().unwrap()[self.number] = wrench;
        self.pointer.write(wrench)
    }
}

/// A session on two fingers, a flag that removes the right one, and the wrenches written to them.
struct Stage {
    session: WorldSession,
    is_out: Arc<AtomicBool>,
    stop: StopFlag,
    written: Written,
}

fn stage(methods: &[&'static str]) -> Stage {
    let scene = scene();
    let clock = MonotonicClock::new();
    let is_out = Arc::new(AtomicBool::new(false));
    let written = Written::default();
    let hands = scene
        .devices
        .iter()
        .map(|one| SpatialHand::at(one.position));
    let hands: Vec<SpatialHand> = hands.collect();
    let open = {
        let (scene, hands, methods) = (scene.clone(), hands.clone(), methods.to_vec());
        let (is_out, written) = (Arc::clone(&is_out), Arc::clone(&written));
        move |number: usize| {
            let renderer = scene.renderer(methods[number]).unwrap();
            let frames = vec![WorldFrame::the_same(); 2];
            let world = RenderedWorld::of_devices(&scene.world, renderer, methods[number], frames);
            // A busy machine is not what is tested here: a force that it holds for too long creates energy, and
            // recoveries follow.
            let mut limits = SafetyParams {
                stall_after_periods: 1000.0,
                ..SafetyParams::default()
            };
            limits.oscillation.energy = f64::INFINITY;
            limits.recoveries.too_many = None;
            let devices = hands.iter().enumerate();
            let devices = devices.map(|(number, hand)| {
                let pointer = SpatialPointer::new(&scene, number, hand, clock).unwrap();
                let is_out = if number == 1 {
                    Arc::clone(&is_out)
                } else {
                    Arc::default()
                };
                let written = Arc::clone(&written);
                let finger: Box<dyn Device> = Box::new(Finger {
                    pointer,
                    is_out,
                    number,
                    written,
                });
                (finger, limits)
            });
            Ok(WorldLane {
                devices: devices.collect(),
                world: world.unwrap(),
            })
        }
    };
    let setup = WorldSetup {
        scene,
        methods: methods.to_vec(),
        open: Box::new(open),
        hands: hands.into_iter().map(Some).collect(),
        clock,
        request: Request::nothing(),
        duration: None,
    };
    let stop = StopFlag::new();
    let session = WorldSession::of_world(setup, &stop).unwrap();
    Stage {
        session,
        is_out,
        stop,
        written,
    }
}

/// The next message to a client that is as it should be.
fn next<Found>(seat: &mut Seat, what: &str, fits: impl Fn(&Outgoing) -> Option<Found>) -> Found {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        match seat.queue.try_recv() {
            Ok(message) => {
                if let Some(found) = fits(&message) {
                    return found;
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    panic!("no {what}");
}

fn text(seat: &mut Seat, kind: &str, fits: impl Fn(&Value) -> bool) -> Value {
    next(seat, kind, |message| match message {
        Outgoing::Text(text) => {
            let text: Value = serde_json::from_str(text).unwrap();
            (text["type"] == kind && fits(&text)).then_some(text)
        }
        Outgoing::Samples(..) => None,
    })
}

/// Bytes of the next frame of this kind that is as it should be.
fn frame(seat: &mut Seat, kind: u8, fits: impl Fn(&[u8]) -> bool) -> Vec<u8> {
    next(seat, "frame", |message| match message {
        Outgoing::Samples(number, frame) => {
            let bytes = frame.numbered(*number);
            (bytes[0] == kind && fits(&bytes)).then_some(bytes)
        }
        Outgoing::Text(_) => None,
    })
}

fn lead(session: &WorldSession, seat: &Seat, device: usize, position: Option<[f64; 3]>) {
    let request = ClientRequest::Tool { device, position };
    let command = Command::Request(seat.id, request);
    session.commands().send(command).unwrap();
}

/// The force on the second device in a frame of a world.
fn second_force(bytes: &[u8]) -> [f32; 3] {
    let at = bytes.len() - 12;
    [0, 1, 2].map(|axis| {
        let at = at + 4 * axis;
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    })
}

#[test]
fn client_receives_both_devices_and_moves_each_independently() {
    let session = stage(&["basic", "coupled"]).session;
    let (mut one, other) = (session.hub().join(), session.hub().join());
    let hello = text(&mut one, "hello", |_| true);
    let tools = hello["world"]["tools"].as_array().unwrap();
    assert_eq!((tools.len(), &tools[1]["name"]), (2, &Value::from("right")));
    assert_eq!(hello["device"]["lanes"], 2);
    assert_eq!(hello["further_devices"].as_array().unwrap().len(), 1);
    assert_eq!(hello["further_devices"][0]["pointer"], true);
    let last = hello["columns"].as_array().unwrap().last().unwrap();
    assert_eq!(last["name"], "force_on_device_n right");
    assert_eq!(last["device"], 1);

    // Each leads one of them into the cube, and the other hand stays.
    lead(&session, &one, 0, Some([-0.012, 0.0005, 0.016]));
    let state = text(&mut one, "state", |state| state["hand_m"][0] == -0.012);
    assert_eq!(state["further_hands"][0]["hand_m"][0], 0.0202);
    lead(&session, &other, 1, Some([0.012, -0.0003, 0.016]));
    text(&mut one, "state", |state| {
        state["further_hands"][0]["hand_m"][0] == 0.012 && state["hand_m"][0] == -0.012
    });
    // Both lanes push the second finger out, to where x grows.
    for lane in [0, 1] {
        let bytes = frame(&mut one, 2, |bytes| {
            bytes[1] == lane && second_force(bytes)[0] > 0.2
        });
        assert_eq!(bytes[2..4], [1, 0]);
    }
    let columns = hello["columns"].as_array().unwrap().len();
    let bytes = frame(&mut one, 1, |_| true);
    assert_eq!(usize::from(bytes[2]), columns);

    // The hands of a departed client release their devices.
    let gone = Command::Gone(other.id);
    session.commands().send(gone).unwrap();
    let state = text(&mut one, "state", |state| {
        state["further_hands"][0]["hand_m"].is_null()
    });
    assert_eq!(state["hand_m"][0], -0.012);
    lead(&session, &one, 2, None);
    let refused = text(&mut one, "refused", |_| true);
    assert_eq!(refused["text"], "device is 2; allowed: 0 to 1");
    // A world rejects the same requests with several devices as with one.
    for request in [
        ClientRequest::Record(true),
        ClientRequest::Set(Set {
            lanes: Some(Vec::<LaneChoice>::new()),
            ..Set::default()
        }),
    ] {
        let command = Command::Request(one.id, request);
        session.commands().send(command).unwrap();
        text(&mut one, "refused", |_| true);
    }
    let restart = Command::Request(one.id, ClientRequest::Restart);
    session.commands().send(restart).unwrap();
    text(&mut one, "state", |state| {
        state["further_hands"][0]["hand_m"][0] == 0.0202 && state["hand_m"][0] == -0.0202
    });
}

#[test]
fn a_device_that_has_gone_is_named_and_takes_the_force_off_both() {
    let Stage {
        session,
        is_out,
        stop,
        written,
    } = stage(&["coupled"]);
    let mut seat = session.hub().join();
    lead(&session, &seat, 0, Some([-0.012, 0.0005, 0.016]));
    lead(&session, &seat, 1, Some([0.012, -0.0003, 0.016]));
    frame(&mut seat, 2, |bytes| second_force(bytes)[0] > 0.2);
    is_out.store(true, Ordering::Release);
    text(&mut seat, "ended", |_| true);
    let state = text(&mut seat, "state", |state| {
        state["lanes"][0]["running"] == false
    });
    let safety_stop = state["lanes"][0]["safety_stop"].as_str().unwrap();
    assert!(safety_stop.starts_with("right: "), "{safety_stop}");
    stop.raise();
    let end = session.join();
    let [lane] = &end.lanes[..] else {
        panic!("one lane ran");
    };
    assert_eq!(lane.capabilities.len(), 2);
    assert_eq!(lane.end.ending, Ending::DeviceLost);
    let stopped = lane.end.control.stopped_device();
    assert_eq!(stopped.map(|(device, _)| device), Some(1));
    assert_eq!(*written.lock().unwrap(), [Wrench::NONE; 2]);
}
