//! Opening a device: find the service, choose, look whether it can be used, start the threads.

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

/// Exchanges of which the round trip is the median.
const TRIED: usize = 31;

/// An answer that takes this many times the median is still one, from however far it comes.
const SLOWER: u32 = 3;

/// Pause between two looks at a device that is not ready.
const AGAIN: Duration = Duration::from_millis(50);

/// Why a device is not opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// There is no service.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The service does not send what it has to.
    #[error("{url}: {what}")]
    Service {
        /// Where.
        url: String,
        /// What is wrong.
        what: String,
    },
    /// A frame that is not believed.
    #[error("{url}: {error}")]
    Frame {
        /// Where.
        url: String,
        /// What is wrong with it.
        error: FrameError,
    },
    /// The service has no Inverse3.
    #[error("{url} has no Inverse3: plug one in, and see that its light is on")]
    NoDevice {
        /// Where.
        url: String,
    },
    /// It has others.
    #[error("{url} has no device {wanted}; it has {there}")]
    NotThere {
        /// Where.
        url: String,
        /// Which one was asked for.
        wanted: String,
        /// The names of those that it has.
        there: String,
    },
    /// It has several: a force on the wrong one hits somebody who does not expect it.
    #[error("{url} has several devices: {there}; choose one by --device-id")]
    Several {
        /// Where.
        url: String,
        /// Their names.
        there: String,
    },
    /// The device cannot be used as it is.
    #[error("device {device}: {unfit}")]
    Unfit {
        /// Which.
        device: String,
        /// Why not.
        unfit: Unfit,
    },
    /// The system gives no thread.
    #[error("no thread for the device: {0}")]
    Thread(#[from] io::Error),
}

/// A device that a service has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its name.
    pub device_id: String,
    /// What it is, as the service calls it.
    pub model: String,
    /// Why it cannot be used as it is, if so.
    pub unfit: Option<Unfit>,
}

/// The devices that a service has.
///
/// # Errors
/// There is no service, or it does not send what it has to.
pub fn devices(service: &str, patience: Duration) -> Result<Vec<Found>, OpenError> {
    let address = Address::parse(service)?;
    let (_, _, frame) = first_frame(&address, patience)?;
    let found = frame.devices().iter().map(|device| Found {
        device_id: device.device_id.clone(),
        model: device
            .model()
            .map_or_else(|| "not said".to_owned(), ToString::to_string),
        unfit: Unfit::at_first(device),
    });
    Ok(found.collect())
}

impl<C: Clock> Inverse3<C> {
    /// Opens a device; its samples are stamped on `clock`, which is the loop's. Opening it again
    /// after it was lost is opening it.
    ///
    /// # Errors
    /// There is no service, or no such device, or the device cannot be used as it is: says what to
    /// do.
    pub fn open(options: &Inverse3Options, clock: C) -> Result<Self, OpenError> {
        let address = Address::parse(&options.service)?;
        let events = match &options.events {
            Some(given) => Some(Address::parse(given)?.connect(options.patience)?),
            None => None,
        };
        let deadline = Instant::now() + options.patience;
        // A session that has just ended may still have the device.
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
        // From here on the writer watches over the time.
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
        // First: a thread that nobody could end would be waited for, for ever.
        self.events = Some(half.stream().try_clone()?);
        let (id, link) = (self.device_id.clone(), Arc::clone(&self.link));
        let listening = Builder::new()
            .name("palpate inverse3 events".to_owned())
            .spawn(move || events::listen(socket, &id, &link))?;
        self.threads.push(listening);
        Ok(())
    }
}

/// A connection, and the frame that the service sends at once.
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

/// The next text that comes.
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
            Ok(Message::Binary(_)) => return Err(wrong("it sends bytes, not JSON".to_owned())),
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if super::is_a_pause(&error) => {}
            Err(error) => return Err(wrong(error.to_string())),
        }
    }
    let seconds = patience.as_secs_f64();
    Err(wrong(format!("it sent nothing within {seconds} s")))
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

/// How long an exchange takes at the median: of some, or of as many as fit into the patience.
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
