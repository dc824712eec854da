//! Emulator of Haply's Inverse Service: its channels on the loopback interface, and a simulated device.
//!
//! Emulated: the simulation channel in its versions 3.1 and 3.5 (a full frame on connection, then one state frame for
//! each message), the events channel, `GET /version` and `GET /devices`. Supported messages: forces, probes and the
//! session's configuration. Not supported: positions, torques, transforms and grips. A device without further commands
//! idles, as with the service. The service's delay is not documented; here it is [`EmulatorOptions::idle_after`].

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

use crate::inverse3::Form;
use crate::inverse3::Status;
use device::EmulatedDevice;
use events::Audience;
use fault::{Faults, SplitMix64};

pub use device::{Body, holding};
pub use fault::{Fault, Latency};
pub use stepped::{Delays, SteppedInverse3};
pub use timed_fault::{NoTimedFault, TimedFault};

/// Interval at which a waiting thread checks whether to end.
const LOOK: Duration = Duration::from_millis(5);

/// Number of stored messages.
const REMEMBERED: usize = 1_000_000;

/// Settings of an emulator.
#[derive(Clone, Debug)]
pub struct EmulatorOptions {
    /// Version of the interface.
    pub form: Form,
    /// Port of the simulation channel and of HTTP; 0: any free port.
    pub port: u16,
    /// Port of the events channel; 0: any free port.
    pub events_port: u16,
    /// Names of the devices.
    pub device_ids: Vec<String>,
    /// Parameters of each device.
    pub body: Body,
    /// Time for which a force is held without another command.
    pub idle_after: Duration,
    /// Latency of a message through the service.
    pub latency: Latency,
}

impl Default for EmulatorOptions {
    /// One device with the 3.5 interface, on free ports, without added latency.
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

/// Reason why an emulator could not start.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A parameter of the device is invalid.
    #[error("emulated device: {0}")]
    Body(#[from] InvalidParameter),
    /// A port could not be opened.
    #[error("port {port}: {error}")]
    Port {
        /// Port number.
        port: u16,
        /// Error of the operating system.
        error: io::Error,
    },
    /// The operating system cannot create a thread.
    #[error("no thread: {0}")]
    Thread(io::Error),
}

/// A message received by the service.
#[derive(Clone, Debug, PartialEq)]
pub struct Received {
    /// Time of arrival.
    pub at: Instant,
    /// Session number, from 1.
    pub session: u64,
    /// Addressed device, if any.
    pub device_id: Option<String>,
    /// Commanded force `[N]`, if any.
    pub force: Option<Vector>,
}

/// Counters of an emulated service.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Started sessions.
    pub sessions: u64,
    /// Received messages.
    pub messages: u64,
    /// Sent replies, without the frames on connection.
    pub replies: u64,
    /// Messages that configured a session.
    pub configured: u64,
}

/// An emulated service; dropping it ends it.
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

/// Locks a mutex, even if its last holder panicked.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Starts a service on its own threads, on the loopback interface only.
    ///
    /// # Errors
    /// A parameter of the device is out of range, a port is taken, or a thread cannot be created.
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

    /// Returns the address of the simulation channel and of HTTP.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns the address of the events channel.
    #[must_use]
    pub fn events_address(&self) -> SocketAddr {
        self.events_address
    }

    /// Returns the URL of the simulation channel for a driver.
    #[must_use]
    pub fn url(&self) -> String {
        format!("ws://{}", self.address)
    }

    /// Returns the URL of the events channel.
    #[must_use]
    pub fn events_url(&self) -> String {
        format!("ws://{}", self.events_address)
    }

    /// Injects a fault into the next reply without one.
    pub fn inject(&self, fault: Fault) {
        lock(&self.shared.state).faults.push(fault);
    }

    /// Sets the latency of further messages.
    pub fn set_latency(&self, latency: Latency) {
        lock(&self.shared.state).latency = latency;
    }

    /// Changes the reported status of a device, if there is one with this name.
    pub fn set_status(&self, id: &str, change: impl FnOnce(&mut Status)) {
        self.with_device(id, |device| change(&mut device.status));
    }

    /// Unplugs a device or plugs it in, and sends an event.
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

    /// Sends the event that the device's safety system acted.
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

    /// Returns the current position of a device `[m]`; `None` if there is no device with this name.
    #[must_use]
    pub fn position(&self, id: &str) -> Option<Vector> {
        self.look(id, EmulatedDevice::position)
    }

    /// Returns the current commanded force of a device `[N]`; `None` if there is no device with this name.
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

    /// Returns the counters.
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

    /// Returns the received messages, at most the first million.
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

/// Accepts clients until the end, and simulates the devices.
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
