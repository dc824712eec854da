//! What is outside the controller: the handle with motor and sensor, the hand, the host. It lives in memory
//! that the program does not own, and outlives a reset of the controller. Its own timer interrupt moves it
//! 20000 times a second, before everything else.
#![allow(unsafe_code)] // the world lies in memory that Rust does not know

mod scene;

use core::fmt::{self, Write};
use core::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};

use crate::emulator::{Lines, exit};
use crate::example::PARAMS;
use crate::handle::{Handle, STEP};
use crate::mps2::watchdog;
pub use scene::{Scene, Stall};

/// Address of the pins: QEMU's loader writes the scene's number and the phases there.
const PINS: usize = 0x2030_0000;
/// Where the world lies.
const WORLD: usize = 0x2030_1000;
/// Written once the world has begun: memory is 0 when the emulator starts.
const BEGUN: u32 = 0x0077_0a1d;
/// Steps from one entry of the log to the next: a period of the loop.
const LOGGED_EVERY: u32 = 5;
/// Entries of a run: 1.2 s.
const ENTRIES: usize = 4800;

/// The pins between controller and world, at the offsets that `check/src/ran.rs` knows.
#[repr(C)]
pub struct Pins {
    scene: AtomicU32,
    /// Duty of the PWM timer.
    pub duty: AtomicI32,
    /// Whether the timer's outputs are on; a reset turns them off.
    pub is_on: AtomicBool,
    /// Count of the sensor.
    pub count: AtomicU32,
    /// How often the host has spoken.
    pub words: AtomicU32,
    /// How the loop is to stall, a test's doing: see [`Stall`].
    pub stall: AtomicU32,
    /// What the loop says of itself: its status as a number.
    pub status: AtomicU32,
    /// How often the controller has started.
    pub starts: AtomicU32,
    /// Ticks that the loop has begun, over all starts.
    pub ticks: AtomicU32,
    /// Longest tick, in counts of the 25 MHz timer.
    pub longest: AtomicU32,
    /// Ticks that lasted longer than a period.
    pub overruns: AtomicU32,
    /// By how many counts of the 25 MHz timer the first tick of the loop comes later; the emulator's loader writes it.
    pub loop_phase: AtomicU32,
    /// The same for the first look of the supervisor.
    pub supervisor_phase: AtomicU32,
}

impl Pins {
    /// The pins.
    pub fn get() -> &'static Self {
        // SAFETY: memory that nothing else uses, aligned, for ever; every bit pattern that is ever stored
        // there is one of an atomic's, and the emulator starts with 0.
        unsafe { &*core::ptr::with_exposed_provenance::<Self>(PINS) }
    }

    /// What is to be rendered and to happen.
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
    /// When the event of the scene has come, in steps.
    event: Option<u32>,
    entries: [Entry; ENTRIES],
}

/// Moves the world on. Call it from its interrupt only.
pub fn go_on() {
    let world = core::ptr::with_exposed_provenance_mut::<World>(WORLD);
    // SAFETY: memory that nothing else uses, aligned; only this function looks there, and its interrupt
    // does not interrupt itself. The number is valid whatever it is, and the rest is read only after it
    // has been written.
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
        self.handle.go_on(motor, hand);
        self.steps += 1;

        // The event comes while the wall pushes.
        let mut count = self.handle.count();
        if self.event.is_none() && time > 0.3 && motor < -2.0 {
            self.event = Some(self.steps);
            pins.stall
                .store(self.scene.stall() as u32, Ordering::Relaxed);
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

    /// Lines: `entry TIME POSITION VELOCITY MOTOR HAND_WORK MOTOR_WORK STATUS STARTS`, then
    /// `event TIME` where there was one, and `loop LONGEST OVERRUNS TICKS`.
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
