//! The world outside the controller: the handle with motor and sensor, the hand, the host. It is in memory that the
//! program does not own, and survives a reset of the controller. A separate timer interrupt of the highest priority
//! advances it 20000 times a second.
#![allow(unsafe_code)] // the world lies in memory that Rust does not know

mod host;
mod scene;

use core::fmt::{self, Write};
use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};

use crate::emulator::{Lines, exit};
use crate::example::PARAMS;
use crate::handle::{Handle, STEP};
use crate::mps2::watchdog;
pub use host::{Host, LEAD};
pub use scene::{Scene, Stall};

/// Address of the pins, to which QEMU's loader writes the scene's number and the phases.
const PINS: usize = 0x2030_0000;
/// Address of the world.
const WORLD: usize = 0x2030_1000;
/// Marker of a started world: memory is 0 when the emulator starts.
const BEGUN: u32 = 0x0077_0a1d;
/// Steps between two log entries: a period of the loop.
const LOGGED_EVERY: u32 = 5;
/// Log entries of a run: 1.2 s.
const ENTRIES: usize = 4800;

/// The pins between controller and world, at the offsets in `check/src/ran.rs`.
#[repr(C)]
pub struct Pins {
    scene: AtomicU32,
    /// Duty of the PWM timer.
    pub duty: AtomicI32,
    /// Whether the timer's outputs are on; a reset turns them off.
    pub is_on: AtomicBool,
    /// Count of the sensor.
    pub count: AtomicU32,
    /// Number of the host's messages.
    pub words: AtomicU32,
    /// Stall of the loop, set by a test: see [`Stall`].
    pub stall: AtomicU32,
    /// Status of the loop as a number.
    pub status: AtomicU32,
    /// Number of starts of the controller.
    pub starts: AtomicU32,
    /// Ticks that the loop has begun, over all starts.
    pub ticks: AtomicU32,
    /// Longest tick, in counts of the 25 MHz timer.
    pub longest: AtomicU32,
    /// Ticks that lasted longer than a period.
    pub overruns: AtomicU32,
    /// Delay of the first tick of the loop, in counts of the 25 MHz timer; written by the emulator's loader.
    pub loop_phase: AtomicU32,
    /// Delay of the first check of the supervisor.
    pub supervisor_phase: AtomicU32,
    /// Period of the host in ticks of the loop; written by the emulator's loader.
    pub host_ticks: AtomicU32,
    /// Sample for the host: the number of a tick, written last, and the count of that tick.
    pub sampled: AtomicU32,
    pub sampled_count: AtomicU32,
    /// Message of the host: the number of its sample's tick, written last, and the bits of its line.
    pub line_of: AtomicU32,
    pub line_mean: AtomicU32,
    pub line_slope: AtomicU32,
    /// Whether the host's next message is to come late.
    pub is_late: AtomicBool,
}

impl Pins {
    /// The pins.
    pub fn get() -> &'static Self {
        // SAFETY: exclusive, aligned memory of static lifetime; every stored bit pattern is valid for an atomic, and
        // the emulator starts with 0.
        unsafe { &*core::ptr::with_exposed_provenance::<Self>(PINS) }
    }

    /// Returns the scene to run.
    pub fn scene(&self) -> Scene {
        Scene::of(self.scene.load(Ordering::Relaxed))
    }
}

#[derive(Clone, Copy)]
struct Entry {
    handle: Handle,
    motor: f32,
    status: u32,
    starts: u32,
}

struct World {
    begun: u32,
    steps: u32,
    handle: Handle,
    scene: Scene,
    /// Time of the scene's event, in steps.
    event: Option<u32>,
    entries: [Entry; ENTRIES],
}

/// Advances the world. Call it from its interrupt only.
pub fn resume() {
    let world = core::ptr::with_exposed_provenance_mut::<World>(WORLD);
    // SAFETY: exclusive, aligned memory; only this function accesses it, and its interrupt does not preempt itself.
    // Every bit pattern of the number is valid, and the rest is read only after it has been written.
    let world = unsafe {
        if (&raw const (*world).begun).read() != BEGUN {
            (&raw mut (*world).steps).write(0);
            (&raw mut (*world).scene).write(Pins::get().scene());
            (&raw mut (*world).handle).write(Pins::get().scene().start());
            (&raw mut (*world).event).write(None);
            let entries = (&raw mut (*world).entries).cast::<Entry>();
            for index in 0..ENTRIES {
                entries.add(index).write(Entry {
                    handle: Handle::default(),
                    motor: 0.0,
                    status: 0,
                    starts: 0,
                });
            }
            (&raw mut (*world).begun).write(BEGUN);
        }
        &mut *world
    };
    world.step(Pins::get());
}

impl World {
    fn step(&mut self, pins: &Pins) {
        let time = self.steps as f32 * STEP;
        let duty = i16::try_from(pins.duty.load(Ordering::Relaxed)).unwrap_or(0);
        let is_on = pins.is_on.load(Ordering::Relaxed);
        let motor = if is_on { PARAMS.drive.force(duty) } else { 0.0 };
        if self.steps.is_multiple_of(LOGGED_EVERY)
            && let Some(entry) = self.entries.get_mut((self.steps / LOGGED_EVERY) as usize)
        {
            *entry = Entry {
                handle: self.handle,
                motor,
                status: pins.status.load(Ordering::Relaxed),
                starts: pins.starts.load(Ordering::Relaxed),
            };
        }
        let hand = self.scene.hand(time, &self.handle);
        self.handle.resume(motor, hand);
        self.steps += 1;

        // The event occurs while the wall pushes.
        let mut count = self.handle.count();
        if self.event.is_none() && time > 0.3 && motor < -2.0 {
            self.event = Some(self.steps);
            pins.stall
                .store(self.scene.stall() as u32, Ordering::Relaxed);
        }
        if self.event == Some(self.steps) && self.scene.has_late_line() {
            pins.is_late.store(true, Ordering::Relaxed);
        }
        let since = self.event.map(|event| self.steps - event);
        if self.scene.has_glitch() && since.is_some_and(|since| since < LOGGED_EVERY) {
            count = count.wrapping_add(3000);
        }
        if pins.starts.load(Ordering::Relaxed) > 1 {
            pins.stall.store(Stall::Not as u32, Ordering::Relaxed);
        }
        pins.count.store(u32::from(count), Ordering::Relaxed);
        if self.scene.host_speaks(time) && self.steps.is_multiple_of(80) {
            pins.words.fetch_add(1, Ordering::Relaxed);
        }
        if (self.steps / LOGGED_EVERY) as usize == ENTRIES {
            watchdog::stop();
            exit(self.print(pins).is_ok());
        }
    }

    /// Lines: `entry TIME POSITION VELOCITY MOTOR HAND_WORK MOTOR_WORK STATUS STARTS`, then `event TIME` if there was
    /// one, and `loop LONGEST OVERRUNS TICKS`.
    fn print(&self, pins: &Pins) -> fmt::Result {
        let mut out = Lines::default();
        for (index, entry) in self.entries.iter().enumerate() {
            let handle = &entry.handle;
            writeln!(
                out,
                "entry {} {:e} {:e} {} {:e} {:e} {} {}",
                index as f32 * LOGGED_EVERY as f32 * STEP,
                handle.position,
                handle.velocity,
                entry.motor,
                handle.hand_work,
                handle.motor_work,
                entry.status,
                entry.starts,
            )?;
        }
        if let Some(event) = self.event {
            writeln!(out, "event {}", event as f32 * STEP)?;
        }
        let said = [&pins.longest, &pins.overruns, &pins.ticks];
        let [longest, overruns, ticks] = said.map(|pin| pin.load(Ordering::Relaxed));
        writeln!(out, "loop {longest} {overruns} {ticks}")
    }
}
