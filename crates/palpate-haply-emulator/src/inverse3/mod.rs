//! An emulator of Haply's Inverse Service: its channels on this machine's loopback, and behind them
//! a device that moves.
//!
//! What is emulated: the simulation channel in its 3.1 and its 3.5 form (a full frame on connect,
//! then one state frame for each message), the events channel, `GET /version` and `GET /devices`.
//! Forces, probes and the session's configuration are understood; positions, torques, transforms
//! and grips are not. A device whose commands stop idles, as the service's do; after how long the
//! service's do is not documented, here it is [`EmulatorOptions::idle_after`].

mod device;
mod events;
mod fault;
mod frames;
mod http;
mod service;
mod stepped;
mod timed_fault;

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use palpate_device::Vector;
use palpate_testbed::InvalidParameter;
use serde_json::json;

use device::EmulatedDevice;
use events::Audience;
use fault::{Faults, SplitMix64};
use palpate_haply::inverse3::Form;
use palpate_haply::inverse3::Status;

pub use device::{Body, holding};
pub use fault::{Fault, Latency};
pub use stepped::{Delays, SteppedInverse3};
pub use timed_fault::{NoTimedFault, TimedFault};

/// How often a thread that waits looks whether it is to end.
const LOOK: Duration = Duration::from_millis(5);

/// Messages that are remembered.
const REMEMBERED: usize = 1_000_000;

/// What is emulated, and where.
#[derive(Clone, Debug)]
pub struct EmulatorOptions {
    /// The form that is spoken.
    pub form: Form,
    /// Port of the simulation channel and of HTTP; 0: any that is free.
    pub port: u16,
    /// Port of the events channel; 0: any that is free.
    pub events_port: u16,
    /// A device for each name.
    pub device_ids: Vec<String>,
    /// What each device is.
    pub body: Body,
    /// How long a force is held without another command.
    pub idle_after: Duration,
    /// How long a message takes through the service.
    pub latency: Latency,
}

impl Default for EmulatorOptions {
    /// One device with the 3.5 form, on ports that are free, as fast as the machine is.
    fn default() -> Self {
        Self {
            form: Form::V35,
            port: 0,
            events_port: 0,
            device_ids: vec!["049D".to_owned()],
            body: Body::default(),
            idle_after: Duration::from_millis(50),
            latency: Latency::NONE,
        }
    }
}

/// Why an emulator does not start.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A quantity of the device.
    #[error("emulated device: {0}")]
    Body(#[from] InvalidParameter),
    /// A port.
    #[error("port {port}: {error}")]
    Port {
        /// Which.
        port: u16,
        /// Why.
        error: io::Error,
    },
    /// The system gives no thread.
    #[error("no thread: {0}")]
    Thread(io::Error),
}

/// A message as the service has received it.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// When.
    pub at: Instant,
    /// In which session; they count from 1.
    pub session: u64,
    /// The device that it addresses, if it does.
    pub device_id: Option<String>,
    /// The force that it commands, if it does `[N]`.
    pub force: Option<Vector>,
}

/// What an emulated service has done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Sessions that were begun.
    pub sessions: u64,
    /// Messages that came.
    pub messages: u64,
    /// Replies that were sent, the frames on connect not among them.
    pub replies: u64,
    /// Messages that configured a session.
    pub configured: u64,
}

/// An emulated service. It ends with this.
#[derive(Debug)]
pub struct Emulator {
    address: SocketAddr,
    events_address: SocketAddr,
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    form: Form,
    state: Mutex<State>,
    audience: Arc<Audience>,
    ended: Arc<AtomicBool>,
}

#[derive(Debug)]
struct State {
    devices: Vec<EmulatedDevice>,
    latency: Latency,
    random: SplitMix64,
    faults: Faults,
    clients: usize,
    sessions: u64,
    messages: u64,
    replies: u64,
    configured: u64,
    received: Vec<Received>,
}

impl State {
    fn remember(&mut self, received: Received) {
        if self.received.len() < REMEMBERED {
            self.received.push(received);
        }
    }
}

/// What is behind the lock, whatever became of its last holder.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Starts a service on threads of its own, on the loopback and nowhere else.
    ///
    /// # Errors
    /// A quantity of the device outside its range; a port that is taken; no thread.
    pub fn start(options: &EmulatorOptions) -> Result<Self, EmulatorError> {
        let devices = options
            .device_ids
            .iter()
            .map(|id| EmulatedDevice::new(id.clone(), &options.body, options.idle_after))
            .collect::<Result<_, _>>()?;
        let (service, address) = bind(options.port)?;
        let (events, events_address) = bind(options.events_port)?;
        let shared = Arc::new(Shared {
            form: options.form,
            state: Mutex::new(State {
                devices,
                latency: options.latency,
                random: SplitMix64(1),
                faults: Faults::default(),
                clients: 0,
                sessions: 0,
                messages: 0,
                replies: 0,
                configured: 0,
                received: Vec::new(),
            }),
            audience: Arc::default(),
            ended: Arc::default(),
        });
        let mut emulator = Self {
            address,
            events_address,
            shared: Arc::clone(&shared),
            threads: Vec::new(),
        };
        let (audience, ended) = (Arc::clone(&shared.audience), Arc::clone(&shared.ended));
        emulator.spawn("palpate service", move || accept(&service, &shared))?;
        emulator.spawn("palpate events", move || {
            events::listen(&events, &audience, &ended);
        })?;
        Ok(emulator)
    }

    fn spawn(
        &mut self,
        name: &str,
        run: impl FnOnce() + Send + 'static,
    ) -> Result<(), EmulatorError> {
        let builder = thread::Builder::new().name(name.to_owned());
        self.threads
            .push(builder.spawn(run).map_err(EmulatorError::Thread)?);
        Ok(())
    }

    /// Where the simulation channel and HTTP are.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Where the events channel is.
    #[must_use]
    pub fn events_address(&self) -> SocketAddr {
        self.events_address
    }

    /// The simulation channel, as a driver wants to hear it.
    #[must_use]
    pub fn url(&self) -> String {
        format!("ws://{}", self.address)
    }

    /// The events channel, likewise.
    #[must_use]
    pub fn events_url(&self) -> String {
        format!("ws://{}", self.events_address)
    }

    /// Something goes wrong with the next reply that nothing else goes wrong with.
    pub fn inject(&self, fault: Fault) {
        lock(&self.shared.state).faults.push(fault);
    }

    /// Messages take this long from now on.
    pub fn set_latency(&self, latency: Latency) {
        lock(&self.shared.state).latency = latency;
    }

    /// Changes what the service says of a device, if there is one of this name.
    pub fn set_status(&self, id: &str, change: impl FnOnce(&mut Status)) {
        self.with_device(id, |device| change(&mut device.status));
    }

    /// Unplugs a device, or plugs it in; the events channel tells.
    pub fn set_present(&self, id: &str, present: bool) {
        self.with_device(id, |device| device.present = present);
        let name = if present {
            "device-connected"
        } else {
            "device-disconnected"
        };
        let data = json!({ "device_family": "inverse3", "device_id": id });
        let event = events::event(name, "device", "notice", &data);
        self.shared.audience.tell(&event);
    }

    /// Tells the events channel that the device's own safety acted.
    pub fn trigger_safety(&self, id: &str, safety_type: &str) {
        let data = json!({
            "device_family": "inverse3", "device_id": id, "safety_type": safety_type,
        });
        let event = events::event("device-safety-triggered", "device", "warning", &data);
        self.shared.audience.tell(&event);
    }

    fn with_device(&self, id: &str, change: impl FnOnce(&mut EmulatedDevice)) {
        let mut state = lock(&self.shared.state);
        if let Some(device) = state.devices.iter_mut().find(|device| device.id == id) {
            change(device);
        }
    }

    /// Where a device is now `[m]`; none of this name: nothing.
    #[must_use]
    pub fn position(&self, id: &str) -> Option<Vector> {
        self.look(id, EmulatedDevice::position)
    }

    /// The force that a device's motors are told to hold now `[N]`; none of this name: nothing.
    #[must_use]
    pub fn force(&self, id: &str) -> Option<Vector> {
        self.look(id, EmulatedDevice::force)
    }

    fn look(&self, id: &str, at: impl FnOnce(&EmulatedDevice) -> Vector) -> Option<Vector> {
        let mut state = lock(&self.shared.state);
        let device = state.devices.iter_mut().find(|device| device.id == id)?;
        device.move_on(Instant::now());
        Some(at(device))
    }

    /// What it has done so far.
    #[must_use]
    pub fn served(&self) -> Served {
        let state = lock(&self.shared.state);
        Served {
            sessions: state.sessions,
            messages: state.messages,
            replies: state.replies,
            configured: state.configured,
        }
    }

    /// Messages that came, the first million of them.
    #[must_use]
    pub fn received(&self) -> Vec<Received> {
        lock(&self.shared.state).received.clone()
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Release);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

fn bind(port: u16) -> Result<(TcpListener, SocketAddr), EmulatorError> {
    let bound = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).and_then(|listener| {
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        Ok((listener, address))
    });
    bound.map_err(|error| EmulatorError::Port { port, error })
}

/// Takes clients until the end, and lets the devices move meanwhile.
fn accept(listener: &TcpListener, shared: &Arc<Shared>) {
    let mut clients = Vec::new();
    while !shared.ended.load(Ordering::Acquire) {
        if let Ok((stream, _)) = listener.accept() {
            let shared = Arc::clone(shared);
            clients.push(thread::spawn(move || service::serve(stream, &shared)));
        } else {
            thread::sleep(LOOK);
        }
        clients.retain(|client| !client.is_finished());
        let mut state = lock(&shared.state);
        let (now, alone) = (Instant::now(), state.clients == 0);
        for device in &mut state.devices {
            device.move_on(now);
            if alone && !device.is_commanded() {
                device.rest();
            }
        }
    }
    for client in clients {
        let _ = client.join();
    }
}
