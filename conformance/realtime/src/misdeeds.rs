//! Forbidden operations of a tick, committed on purpose by a device when the loop reads it.

use std::hint::black_box;
use std::str::FromStr;
use std::sync::{Arc, Mutex, mpsc};
use std::thread;
use std::time::Duration;

use palpate_device::clock::SteppedClock;
use palpate_device::{Capabilities, Device, DeviceError, NullDevice, Pose, Wrench, ZeroWriter};
use palpate_rt::ControlLoop;
use palpate_rt::safety::SafetyParams;
use palpate_scene::method::MethodName;

use crate::situations::{Watch, scene};

/// Duration of a lock in another thread, and of a sleep.
const WHILE: Duration = Duration::from_millis(100);

/// A forbidden operation of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misdeed {
    /// Nothing: the baseline.
    Nothing,
    /// Allocates and frees memory.
    Allocate,
    /// Prints a line.
    Print,
    /// Acquires a free lock.
    LockFree,
    /// Acquires a lock held by another thread.
    LockHeld,
    /// Sleeps by `std`.
    Sleep,
    /// Sleeps by a direct system call, without the C library.
    SleepRaw,
    /// Opens a file.
    Open,
}

impl Misdeed {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Nothing,
        Self::Allocate,
        Self::Print,
        Self::LockFree,
        Self::LockHeld,
        Self::Sleep,
        Self::SleepRaw,
        Self::Open,
    ];
}

impl FromStr for Misdeed {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|misdeed| format!("{misdeed:?}") == name)
            .ok_or_else(|| format!("no misdeed {name}; there are {:?}", Self::ALL))
    }
}

/// Runs ten ticks of a loop whose device commits `misdeed` in each.
pub fn commit(misdeed: Misdeed, watch: &mut Watch) {
    let clock = SteppedClock::new();
    let rendering = scene("wall.toml").rendering(MethodName::Coupled).unwrap();
    let device = Misbehaving {
        misdeed,
        device: NullDevice::new(clock.clone()),
        lock: Arc::default(),
    };
    let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
    for _ in 0..10 {
        let holder = (misdeed == Misdeed::LockHeld).then(|| hold(&control.device().lock));
        watch(&mut || {
            black_box(control.tick());
        });
        if let Some(holder) = holder {
            holder.join().unwrap();
        }
    }
}

/// Starts a thread that already holds `lock` on return, and keeps it for a while.
fn hold(lock: &Arc<Mutex<u32>>) -> thread::JoinHandle<()> {
    let lock = Arc::clone(lock);
    let (messages, holds) = mpsc::channel();
    let holder = thread::spawn(move || {
        let _held = lock.lock().unwrap();
        messages.send(()).unwrap();
        thread::sleep(WHILE);
    });
    holds.recv().unwrap();
    holder
}

struct Misbehaving {
    misdeed: Misdeed,
    device: NullDevice<SteppedClock>,
    lock: Arc<Mutex<u32>>,
}

impl Device for Misbehaving {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        match self.misdeed {
            Misdeed::Nothing => {}
            Misdeed::Allocate => drop(black_box(Box::new([0_u8; 64]))),
            Misdeed::Print => println!("a tick prints"),
            Misdeed::LockFree | Misdeed::LockHeld => *self.lock.lock().unwrap() += 1,
            Misdeed::Sleep => thread::sleep(WHILE / 100),
            Misdeed::SleepRaw => {
                let time = rustix::thread::Timespec {
                    tv_sec: 0,
                    tv_nsec: 1_000_000,
                };
                let _ = rustix::thread::nanosleep(&time);
            }
            Misdeed::Open => drop(std::fs::File::open("/dev/null").unwrap()),
        }
        self.device.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.device.write(wrench)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.zero_writer()
    }
}
