//! A session with a server in front of it, and clients as a page would be.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate_core::AlongAxis;
use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench};
use palpate_live::{Devices, Home, Listening, Placed, Server, Session, SessionError, Setup};
use palpate_record::recording::{Column, RecordingMetadata, columns};
use palpate_rt::StopFlag;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Scene};
use palpate_study::sim::device::{PointerDevice, PointerHand, PointerParams};
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// Longest wait.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// The scene of `palpate live`, at 1 kHz.
pub fn scene() -> Scene {
    let text = include_str!("../../../../../experiments/live.toml");
    let mut scene = ContactFile::parse("live.toml", text).unwrap().scene;
    scene.loop_params.period = 0.001;
    scene
}

/// Devices in a pointer's hand, which can be pulled out all at once.
pub struct Pointers {
    pub hand: PointerHand,
    pub clock: MonotonicClock,
    pub most: usize,
    pub is_out: Arc<AtomicBool>,
    pub read_takes: Duration,
}

struct Plugged(PointerDevice<MonotonicClock>, Arc<AtomicBool>, Duration);

impl Device for Plugged {
    fn capabilities(&self) -> &Capabilities {
        self.0.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.1.load(Ordering::Acquire) {
            let kind = DeviceErrorKind::Disconnected;
            return Err(DeviceError::new(kind, "pulled out"));
        }
        std::thread::sleep(self.2);
        self.0.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.0.write(wrench)
    }
}

impl Devices for Pointers {
    fn most_lanes(&self) -> usize {
        self.most
    }

    fn resume(&self) -> bool {
        true
    }

    fn any_period(&self) -> bool {
        self.most > 1
    }

    fn open(&mut self, at: Option<f64>) -> Result<Placed, String> {
        if self.is_out.load(Ordering::Acquire) {
            return Err("there is no device".to_owned());
        }
        let params = PointerParams {
            position: at.unwrap_or(0.0),
            ..PointerParams::default()
        };
        let device = PointerDevice::new(params, &self.hand, self.clock).unwrap();
        Ok(Placed {
            device: Box::new(Plugged(device, Arc::clone(&self.is_out), self.read_takes)),
            axis: AlongAxis::new([0.0; 3], [1.0, 0.0, 0.0]).unwrap(),
        })
    }
}

/// Configuration of a test session.
pub struct Play {
    pub scene: Scene,
    pub methods: Vec<MethodName>,
    pub most_lanes: usize,
    pub is_led: bool,
    pub listen: &'static str,
    pub workspace: Option<[Vector; 2]>,
    pub duration: Option<Duration>,
    pub read_takes: Duration,
}

impl Default for Play {
    fn default() -> Self {
        Self {
            scene: scene(),
            methods: vec![MethodName::Coupled],
            most_lanes: 2,
            is_led: true,
            listen: "127.0.0.1:0",
            workspace: None,
            duration: None,
            read_takes: Duration::ZERO,
        }
    }
}

/// A session and a server that run.
pub struct Stage {
    pub address: SocketAddr,
    pub url: String,
    pub hand: PointerHand,
    pub is_out: Arc<AtomicBool>,
    pub folder: tempfile::TempDir,
    pub stop: StopFlag,
    pub session: Option<Session>,
    server: Option<Server>,
}

impl Stage {
    pub fn new(play: Play) -> Self {
        Self::begin(play).unwrap()
    }

    pub fn begin(play: Play) -> Result<Self, SessionError> {
        let folder = tempfile::tempdir().unwrap();
        let clock = MonotonicClock::new();
        let hand = PointerHand::at(0.0);
        let is_out = Arc::new(AtomicBool::new(false));
        let listening = Listening::on(play.listen.parse().unwrap(), Vec::new()).unwrap();
        let workspace = play.workspace;
        let setup = Setup {
            scene: play.scene,
            methods: play.methods,
            devices: Box::new(Pointers {
                hand: hand.clone(),
                clock,
                most: play.most_lanes,
                is_out: Arc::clone(&is_out),
                read_takes: play.read_takes,
            }),
            hand: play.is_led.then(|| hand.clone()),
            clock,
            request: Request::nothing(),
            limits: Box::new(move |_| SafetyParams {
                workspace,
                // A busy machine is not what is tested here.
                stall_after_periods: 1000.0,
                ..SafetyParams::default()
            }),
            duration: play.duration,
            metadata: Box::new(|scene, _| {
                let text = scene.to_toml().map_err(|error| error.to_string())?;
                Ok(RecordingMetadata::new("test").with("scene", &text))
            }),
            folder: folder.path().to_path_buf(),
            record: None,
        };
        let stop = StopFlag::new();
        let session = Session::start(setup, &stop)?;
        let (mut address, url) = (listening.address(), listening.url());
        let server =
            Server::start(listening, session.hub(), session.commands(), Home::Contact).unwrap();
        address.set_ip("127.0.0.1".parse().unwrap());
        Ok(Self {
            address,
            url,
            hand,
            is_out,
            folder,
            stop,
            session: Some(session),
            server: Some(server),
        })
    }

    pub fn client(&self) -> Client {
        Client::at(self.address, "/live", &[]).unwrap()
    }

    /// A request as it stands; the whole answer.
    pub fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// The page by its own name.
    pub fn get(&self, path: &str) -> String {
        let address = self.address;
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n"))
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.stop.raise();
        if let Some(session) = self.session.take() {
            let _ = session.join();
        }
        self.server.take();
    }
}

/// A page.
pub struct Client {
    pub socket: WebSocket<TcpStream>,
}

/// A frame of samples.
#[derive(Clone, Debug)]
pub struct Samples {
    pub lane: u8,
    pub number: u32,
    pub run: u32,
    pub times: Vec<f64>,
    pub columns: Vec<Vec<f32>>,
}

/// Columns, by their name.
pub const DEVICE: &str = "device_position_m";
pub const FORCE: &str = "force_on_device_n";

/// The columns that the page is sent.
pub fn sent() -> impl Iterator<Item = &'static Column> {
    columns().iter().copied().filter(|column| column.is_live())
}

impl Samples {
    /// The values of a column that the page is sent.
    pub fn column(&self, name: &str) -> &[f32] {
        let names: Vec<_> = sent().map(|column| column.name).collect();
        assert_eq!(self.columns.len(), names.len());
        &self.columns[names.iter().position(|other| *other == name).unwrap()]
    }

    fn read(bytes: &[u8]) -> Self {
        assert_eq!(bytes[0], 1);
        let columns = usize::from(u16::from_le_bytes([bytes[2], bytes[3]]));
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let rows = word(4) as usize;
        assert_eq!(bytes.len(), 24 + 4 * rows * (1 + columns));
        let first = f64::from_le_bytes(bytes[16..24].try_into().unwrap());
        let float = |index: usize| f32::from_bits(word(24 + 4 * index));
        Self {
            lane: bytes[1],
            number: word(8),
            run: word(12),
            times: (0..rows).map(|row| first + f64::from(float(row))).collect(),
            columns: (1..=columns)
                .map(|column| (0..rows).map(|row| float(column * rows + row)).collect())
                .collect(),
        }
    }
}

/// Received message.
#[derive(Clone, Debug)]
pub enum Received {
    Text(Value),
    Samples(Samples),
}

impl Client {
    /// Opens a WebSocket with other headers beside; the status if it is refused.
    pub fn at(
        address: SocketAddr,
        path: &str,
        headers: &[(&'static str, &str)],
    ) -> Result<Self, u16> {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_write_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{address}{path}");
        let mut request = url.into_client_request().unwrap();
        for (name, value) in headers {
            let value = value.parse().unwrap();
            request.headers_mut().insert(*name, value);
        }
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self { socket }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
                Err(response.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub fn say(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap();
    }

    pub fn next(&mut self) -> Received {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => return Received::Text(serde_json::from_str(&text).unwrap()),
                Message::Binary(bytes) => return Received::Samples(Samples::read(&bytes)),
                Message::Close(frame) => panic!("closed: {frame:?}"),
                _ => {}
            }
        }
    }

    /// The next text of a type that is as it should be.
    pub fn until(&mut self, kind: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        let mut last = Value::Null;
        while Instant::now() < end {
            if let Received::Text(text) = self.next()
                && text["type"] == kind
            {
                if fits(&text) {
                    return text;
                }
                last = text;
            }
        }
        panic!("no such {kind}; the last: {last}");
    }

    pub fn text(&mut self, kind: &str) -> Value {
        self.until(kind, |_| true)
    }

    /// The next frame that is as it should be.
    pub fn frame(&mut self, fits: impl Fn(&Samples) -> bool) -> Samples {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            if let Received::Samples(samples) = self.next()
                && fits(&samples)
            {
                return samples;
            }
        }
        panic!("no such frame");
    }

    /// Reads until it is sent away, or the connection is gone.
    pub fn goodbye(&mut self) -> Option<(u16, String)> {
        let end = Instant::now() + PATIENCE;
        loop {
            assert!(Instant::now() < end, "nobody sends it away");
            match self.socket.read() {
                Ok(Message::Close(frame)) => {
                    return frame.map(|frame| (frame.code.into(), frame.reason.to_string()));
                }
                Ok(_) => {}
                Err(_) => return None,
            }
        }
    }

    /// Checks that loop and server continue: the loop ticks, and this client receives its status.
    pub fn is_well(&mut self) {
        let ticks = |text: &Value| text["lanes"][0]["ticks"].as_u64().unwrap();
        let mut messages = vec![ticks(&self.text("status"))];
        // Two status messages are half a second apart. An earlier restart request resets the count of ticks, so some
        // pairs may decrease.
        while !messages.windows(2).any(|pair| pair[1] > pair[0] + 50) {
            assert!(messages.len() < 12, "ticks of a lane: {messages:?}");
            messages.push(ticks(&self.text("status")));
        }
        let lanes = &self.text("status")["lanes"];
        assert_eq!(lanes[0]["unsent"], 0, "{lanes}");
        let frame = self.frame(|_| true);
        self.frame(|next| next.number == frame.number + 1);
    }
}
