//! Emulator of Force Dimension's library `libdrd` and of a device behind it.
//!
//! The library is a C file, compiled by `cc`, whose functions ask this emulator over a Unix socket. The device therefore
//! outlives a program that is killed, and its firmware's watchdog then takes the force off. Emulated: types, status,
//! positions, orientation, gripper, forces and torques, saturation, reads without a new sample, the watchdog, and the
//! matrix of inertia, which is the same at all poses. Not emulated: brakes, gravity, buttons and the DRD functions.

mod device;
mod protocol;
mod timed_fault;

use std::io::{self, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use palpate_device::Vector;
use palpate_device::clock::Clock;
use palpate_testbed::InvalidParameter;

use crate::emulator::inverse3::Body;
use crate::force_dimension::Kind;
use device::EmulatedDevice;
pub use device::Trouble;
pub use timed_fault::{NoTimedFault, TimedFault};

/// Interval at which a waiting thread checks whether to end.
const LOOK: Duration = Duration::from_millis(5);

const SOURCE: &str = include_str!("libdrd.c");

/// Settings of an emulator.
#[derive(Clone, Debug)]
pub struct EmulatorOptions {
    /// Type of the device.
    pub kind: Kind,
    /// Serial number.
    pub serial: i32,
    /// Number of devices that the library reports; only one can be opened.
    pub devices: i32,
    /// The handle and the hand.
    pub body: Body,
    /// Angles of the wrist about x, y and z `[rad]`.
    pub wrist: Vector,
    /// Whether the firmware has a watchdog.
    pub has_watchdog: bool,
    /// Functions that the library lacks.
    pub without: Vec<String>,
}

impl Default for EmulatorOptions {
    /// An omega.3 at rest in a hand.
    fn default() -> Self {
        Self {
            kind: crate::force_dimension::KINDS[0],
            serial: 1234,
            devices: 1,
            body: Body::default(),
            wrist: [0.0; 3],
            has_watchdog: true,
            without: Vec::new(),
        }
    }
}

/// Reason why an emulator could not start.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A parameter of the device is invalid.
    #[error("emulated device: {0}")]
    Body(#[from] InvalidParameter),
    /// The folder cannot be used.
    #[error("{}: {error}", .path.display())]
    File {
        /// The file or socket.
        path: PathBuf,
        /// Error of the operating system.
        error: io::Error,
    },
    /// The library cannot be compiled.
    #[error("the emulated library needs a C compiler, `cc`: {0}")]
    Compiler(String),
    /// The operating system cannot create a thread.
    #[error("no thread: {0}")]
    Thread(io::Error),
}

/// An emulated library and device; dropping it ends the device.
#[derive(Debug)]
pub struct Emulator {
    library: PathBuf,
    socket: PathBuf,
    shared: Arc<Shared>,
    accepting: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    device: Mutex<EmulatedDevice>,
    clients: Mutex<Vec<UnixStream>>,
    ended: AtomicBool,
    calls: AtomicU64,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Compiles the library `libdrd.so` in `folder`, and starts its device, which moves by `clock`.
    ///
    /// # Errors
    /// A parameter is out of range, there is no C compiler, or the folder cannot be written.
    pub fn start<C: Clock>(
        folder: &Path,
        options: &EmulatorOptions,
        clock: &C,
    ) -> Result<Self, EmulatorError> {
        let device = EmulatedDevice::new(options)?;
        let file = |path: &Path| {
            let path = path.to_path_buf();
            move |error| EmulatorError::File { path, error }
        };
        let folder = folder.canonicalize().map_err(file(folder))?;
        let (source, library) = (folder.join("libdrd.c"), folder.join("libdrd.so"));
        let socket = folder.join("socket");
        if socket.exists() && UnixStream::connect(&socket).is_err() {
            std::fs::remove_file(&socket).map_err(file(&socket))?;
        }
        let listener = UnixListener::bind(&socket).map_err(file(&socket))?;
        listener.set_nonblocking(true).map_err(file(&socket))?;
        std::fs::write(&source, SOURCE).map_err(file(&source))?;
        compile(&source, &library, &socket, &options.without)?;
        let shared = Arc::new(Shared {
            device: Mutex::new(device),
            clients: Mutex::default(),
            ended: AtomicBool::new(false),
            calls: AtomicU64::new(0),
        });
        let (known, clock) = ((options.devices, options.serial), clock.clone());
        let serving = Arc::clone(&shared);
        let accepting = thread::Builder::new()
            .name("palpate libdrd".to_owned())
            .spawn(move || accept(&listener, &serving, known, &clock))
            .map_err(EmulatorError::Thread)?;
        Ok(Self {
            library,
            socket,
            shared,
            accepting: Some(accepting),
        })
    }

    /// Returns the path of the library.
    #[must_use]
    pub fn library(&self) -> &Path {
        &self.library
    }

    /// Changes the faults.
    pub fn trouble(&self, change: impl FnOnce(&mut Trouble)) {
        change(&mut lock(&self.shared.device).trouble);
    }

    /// Changes the status that the device reports, by the indices of the interface.
    pub fn set_status(&self, change: impl FnOnce(&mut [i32; 17])) {
        change(&mut lock(&self.shared.device).status);
    }

    /// Returns force `[N]`, torque `[N m]` and gripper force `[N]` that the motors hold at `clock`'s time.
    #[must_use]
    pub fn held<C: Clock>(&self, clock: &C) -> (Vector, Vector, f64) {
        let mut device = lock(&self.shared.device);
        device.move_on(clock.now());
        let [x, y, z, a, b, c, grip] = device.held();
        ([x, y, z], [a, b, c], grip)
    }

    /// Returns whether a program has the device open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        lock(&self.shared.device).is_open
    }

    /// Returns the limits that were set: force `[N]` and torque `[N m]`.
    #[must_use]
    pub fn limits(&self) -> [f64; 2] {
        lock(&self.shared.device).limits
    }

    /// Returns whether the gravity compensation is on.
    #[must_use]
    pub fn has_gravity_compensation(&self) -> bool {
        lock(&self.shared.device).has_gravity_compensation
    }

    /// Returns whether the firmware's watchdog has taken a force off.
    #[must_use]
    pub fn was_cut(&self) -> bool {
        lock(&self.shared.device).was_cut
    }

    /// Returns the number of calls that the library has answered.
    #[must_use]
    pub fn calls(&self) -> u64 {
        self.shared.calls.load(Ordering::Relaxed)
    }

    /// Returns the position of the handle `[m]`.
    #[must_use]
    pub fn position(&self) -> Vector {
        lock(&self.shared.device).position()
    }
}

/// Compiles the library. A function that it lacks has another name.
fn compile(
    source: &Path,
    library: &Path,
    socket: &Path,
    without: &[String],
) -> Result<(), EmulatorError> {
    let mut command = Command::new("cc");
    command.args([
        "-shared",
        "-fPIC",
        "-std=gnu99",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
    ]);
    command.arg(format!("-DPALPATE_SOCKET=\"{}\"", socket.display()));
    for name in without {
        command.arg(format!("-D{name}=other{name}"));
    }
    let done = command.arg(source).arg("-o").arg(library).output();
    let done = done.map_err(|error| EmulatorError::Compiler(error.to_string()))?;
    if done.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    Err(EmulatorError::Compiler(said))
}

/// Accepts programs until the end.
fn accept<C: Clock>(listener: &UnixListener, shared: &Arc<Shared>, known: (i32, i32), clock: &C) {
    let mut threads = Vec::new();
    while !shared.ended.load(Ordering::Acquire) {
        // On some systems the program's socket inherits that accepting does not block.
        let accepted = listener.accept().and_then(|(client, _)| {
            client.set_nonblocking(false)?;
            lock(&shared.clients).push(client.try_clone()?);
            Ok(client)
        });
        let Ok(client) = accepted else {
            thread::sleep(LOOK);
            continue;
        };
        let (serving, clock) = (Arc::clone(shared), clock.clone());
        threads.push(thread::spawn(move || {
            serve(client, &serving, known, &clock);
        }));
    }
    for client in lock(&shared.clients).drain(..) {
        let _ = client.shutdown(Shutdown::Both);
    }
    for thread in threads {
        let _ = thread.join();
    }
}

/// Answers a program until it ends.
fn serve<C: Clock>(mut client: UnixStream, shared: &Shared, known: (i32, i32), clock: &C) {
    let mut question = [0; protocol::QUESTION];
    let mut has_opened = false;
    while client.read_exact(&mut question).is_ok() {
        let answer = {
            let mut device = lock(&shared.device);
            let was_open = device.is_open;
            let answer = protocol::answer(&question, &mut device, known, clock.now());
            has_opened |= device.is_open && !was_open;
            answer
        };
        shared.calls.fetch_add(1, Ordering::Relaxed);
        if client.write_all(&answer).is_err() {
            break;
        }
    }
    if has_opened {
        lock(&shared.device).is_open = false;
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Release);
        if let Some(thread) = self.accepting.take() {
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.socket);
    }
}
