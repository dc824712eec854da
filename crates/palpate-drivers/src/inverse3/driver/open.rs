//! Opening a device: find the service, choose the device, check its readiness, start the threads.

use std::io;
use std::sync::Arc;
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_rt::realtime::Request;
use tungstenite::{Message, WebSocket};

use super::super::command::{Commands, Form};
use super::super::fitness::Unfit;
use super::super::frame::{DeviceFrame, Frame, FrameError};
use super::address::{Address, ConnectError, Half};
use super::link::{Arrival, Link, Order};
use super::reader::Reader;
use super::writer::Writer;
use super::{Inverse3, Inverse3Options, capabilities, events};

/// Number of exchanges for the median round trip.
const TRIED: usize = 31;

/// Limit of a reply time, in median round trips.
const SLOWER: u32 = 3;

/// Interval between checks of a device that is not ready.
const AGAIN: Duration = Duration::from_millis(50);

/// Reason why a device could not be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// There is no service.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The service sends unexpected data.
    #[error("{url}: {what}")]
    Service {
        /// Address.
        url: String,
        /// Description of the error.
        what: String,
    },
    /// A frame was rejected.
    #[error("{url}: {error}")]
    Frame {
        /// Address.
        url: String,
        /// Reason.
        error: FrameError,
    },
    /// The service has no Inverse3.
    #[error("{url} has no Inverse3: plug one in and check that its light is on")]
    NoDevice {
        /// Address.
        url: String,
    },
    /// The service has other devices only.
    #[error("{url} has no device {wanted}; it has {there}")]
    NotThere {
        /// Address.
        url: String,
        /// Requested name.
        wanted: String,
        /// Names of the present devices.
        there: String,
    },
    /// The service has several devices; a force on the wrong one could surprise its user.
    #[error("{url} has several devices: {there}; choose one by --device-id")]
    Several {
        /// Address.
        url: String,
        /// Their names.
        there: String,
    },
    /// The device is not ready.
    #[error("device {device}: {unfit}")]
    Unfit {
        /// Device id.
        device: String,
        /// Reason.
        unfit: Unfit,
    },
    /// The operating system cannot create a thread.
    #[error("no thread for the device: {0}")]
    Thread(#[from] io::Error),
}

/// A device of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its name.
    pub device_id: String,
    /// Model, with the service's name for it.
    pub model: String,
    /// Reason why it cannot be used, if any.
    pub unfit: Option<Unfit>,
}

/// Returns the devices of a service.
///
/// # Errors
/// There is no service, or it sends unexpected data.
pub fn devices(service: &str, patience: Duration) -> Result<Vec<Found>, OpenError> {
    let address = Address::parse(service)?;
    let (_, _, frame) = first_frame(&address, patience)?;
    let found = frame.devices().iter().map(|device| Found {
        device_id: device.device_id.clone(),
        model: device
            .model()
            .map_or_else(|| "unknown".to_owned(), ToString::to_string),
        unfit: Unfit::at_first(device),
    });
    Ok(found.collect())
}

impl<C: Clock> Inverse3<C> {
    /// Opens a device; its samples are stamped on `clock`, which is the loop's clock. A lost device is opened again in
    /// the same way.
    ///
    /// # Errors
    /// There is no service, no such device, or the device is not ready. The error contains the remedy.
    pub fn open(options: &Inverse3Options, clock: C) -> Result<Self, OpenError> {
        let address = Address::parse(&options.service)?;
        let events = match &options.events {
            Some(given) => Some(Address::parse(given)?.connect(options.patience)?),
            None => None,
        };
        let deadline = Instant::now() + options.patience;
        // A session that has just ended may still hold the device.
        let (mut socket, half, device) = loop {
            let (socket, half, frame) = first_frame(&address, options.patience)?;
            let device = choose(&frame, &address, options.device_id.as_deref())?;
            let Some(unfit) = Unfit::at_first(device) else {
                break (socket, half, device.clone());
            };
            if Instant::now() >= deadline || unfit == Unfit::OtherModel {
                return Err(OpenError::Unfit {
                    device: device.device_id.clone(),
                    unfit,
                });
            }
            drop((socket, half));
            thread::sleep(AGAIN);
        };
        let sample = device.sample().map_err(|error| OpenError::Frame {
            url: address.url().to_owned(),
            error,
        })?;
        let form = options.form.unwrap_or(if device.is_of_3_5() {
            Form::V35
        } else {
            Form::V31
        });
        let mut commands = Commands::new(&device.device_id, form);
        let round_trip = round_trip(&mut socket, &mut commands, &address, options.patience)?;
        // From here on the writer enforces the time limits.
        socket.get_ref().stream().set_read_timeout(None)?;
        let mut options = options.clone();
        options.pace.reply_timeout = options.pace.reply_timeout.max(round_trip * SLOWER);
        let mut opened = Self::start(&options, clock, (socket, half), commands)?;
        opened.round_trip = round_trip;
        opened.opened_at = sample.position;
        if let Some(events) = events {
            opened.listen(events)?;
        }
        Ok(opened)
    }

    fn start(
        options: &Inverse3Options,
        clock: C,
        (socket, half): (WebSocket<Half>, Half),
        commands: Commands,
    ) -> Result<Self, OpenError> {
        let link = Arc::new(Link::new());
        let (orders, taken) = triple_buffer::triple_buffer(&Order {
            number: 0,
            force: [0.0; 3],
            at: Duration::ZERO,
        });
        let (handed, samples) = triple_buffer::triple_buffer(&Arrival {
            number: 0,
            position: [0.0; 3],
            time: Duration::ZERO,
        });
        let request = Request {
            priority: options.priority,
            ..Request::nothing()
        };
        let device_id = commands.device_id().to_owned();
        let form = commands.form();
        let writer = Writer::new(
            half,
            clock.clone(),
            commands,
            options.pace,
            Arc::clone(&link),
            taken,
        );
        let writing = Builder::new()
            .name("palpate inverse3 writer".to_owned())
            .spawn(move || {
                let _ = request.ask();
                writer.run();
            })?;
        let reader = Reader {
            socket,
            clock: clock.clone(),
            device_id: device_id.clone(),
            reply_timeout: options.pace.reply_timeout,
            link: Arc::clone(&link),
            samples: handed,
            writer: writing.thread().clone(),
            handed: 0,
            unreadable: 0,
        };
        let mut device = Self {
            clock,
            capabilities: capabilities(),
            device_id,
            form,
            round_trip: Duration::ZERO,
            opened_at: [0.0; 3],
            link,
            orders,
            samples,
            ordered: 0,
            seen: 0,
            writer: writing.thread().clone(),
            threads: vec![writing],
            events: None,
        };
        let reading = Builder::new()
            .name("palpate inverse3 reader".to_owned())
            .spawn(move || {
                let _ = request.ask();
                reader.run();
            })?;
        device.threads.push(reading);
        Ok(device)
    }

    fn listen(&mut self, (socket, half): (WebSocket<Half>, Half)) -> Result<(), OpenError> {
        half.stream().set_read_timeout(None)?;
        // Keep the connection before starting the thread: without it, the thread could not be ended and joining would
        // hang.
        self.events = Some(half.stream().try_clone()?);
        let (id, link) = (self.device_id.clone(), Arc::clone(&self.link));
        let listening = Builder::new()
            .name("palpate inverse3 events".to_owned())
            .spawn(move || events::listen(socket, &id, &link))?;
        self.threads.push(listening);
        Ok(())
    }
}

/// Connects, and reads the frame that the service sends at once.
fn first_frame(
    address: &Address,
    patience: Duration,
) -> Result<(WebSocket<Half>, Half, Frame), OpenError> {
    let (mut socket, half) = address.connect(patience)?;
    let text = next(&mut socket, address, patience)?;
    let frame = Frame::parse(&text).map_err(|error| OpenError::Frame {
        url: address.url().to_owned(),
        error,
    })?;
    Ok((socket, half, frame))
}

/// Returns the next text message.
fn next(
    socket: &mut WebSocket<Half>,
    address: &Address,
    patience: Duration,
) -> Result<String, OpenError> {
    let wrong = |what| OpenError::Service {
        url: address.url().to_owned(),
        what,
    };
    let deadline = Instant::now() + patience;
    while Instant::now() < deadline {
        match socket.read() {
            Ok(Message::Text(text)) => return Ok(text.to_string()),
            Ok(Message::Binary(_)) => return Err(wrong("binary data instead of JSON".to_owned())),
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if super::is_a_pause(&error) => {}
            Err(error) => return Err(wrong(error.to_string())),
        }
    }
    let seconds = patience.as_secs_f64();
    Err(wrong(format!("no message within {seconds} s")))
}

fn choose<'a>(
    frame: &'a Frame,
    address: &Address,
    wanted: Option<&str>,
) -> Result<&'a DeviceFrame, OpenError> {
    let url = address.url().to_owned();
    let devices = frame.devices();
    let there = || {
        let names: Vec<&str> = devices.iter().map(|d| d.device_id.as_str()).collect();
        names.join(", ")
    };
    match (wanted, devices) {
        (_, []) => Err(OpenError::NoDevice { url }),
        (Some(wanted), _) => frame.device(wanted).ok_or_else(|| OpenError::NotThere {
            url,
            wanted: wanted.to_owned(),
            there: there(),
        }),
        (None, [only]) => Ok(only),
        (None, _) => Err(OpenError::Several {
            url,
            there: there(),
        }),
    }
}

/// Measures the median round trip of up to `TRIED` exchanges within the time limit.
fn round_trip(
    socket: &mut WebSocket<Half>,
    commands: &mut Commands,
    address: &Address,
    patience: Duration,
) -> Result<Duration, OpenError> {
    let begun = Instant::now();
    let mut took = Vec::with_capacity(TRIED);
    while took.len() < TRIED && (took.is_empty() || begun.elapsed() < patience / 2) {
        let sent = Instant::now();
        socket
            .send(Message::text(commands.probe()))
            .map_err(|error| OpenError::Service {
                url: address.url().to_owned(),
                what: error.to_string(),
            })?;
        next(socket, address, patience)?;
        took.push(sent.elapsed());
    }
    took.sort_unstable();
    Ok(took[took.len() / 2])
}
