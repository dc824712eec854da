//! Loops of one contact, a world or a low-rate simulator, before and during a run.

use std::io;

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{ChangingWorld, ControlLoop, LocalWorld, LoopThread, Parameters, StopFlag, Tap};

use super::ended::Ended;

/// A loop that has not started.
pub enum Control {
    Contact(Box<ControlLoop<Box<dyn Device>, MonotonicClock>>),
    World(Box<ControlLoop<Box<dyn Device>, MonotonicClock, ChangingWorld>>),
    Local(Box<ControlLoop<Box<dyn Device>, MonotonicClock, LocalWorld>>),
}

/// A loop running in its thread.
pub enum Running {
    Contact(LoopThread<Box<dyn Device>, MonotonicClock>),
    World(LoopThread<Box<dyn Device>, MonotonicClock, ChangingWorld>),
    Local(LoopThread<Box<dyn Device>, MonotonicClock, LocalWorld>),
}

impl Control {
    /// Returns the loop with its ticks connected to `tap`.
    pub fn tapped(self, tap: Tap) -> Self {
        match self {
            Self::Contact(control) => Self::Contact(Box::new(control.tapped(tap))),
            Self::World(control) => Self::World(Box::new(control.tapped(tap))),
            Self::Local(control) => Self::Local(Box::new(control.tapped(tap))),
        }
    }

    /// Returns the parameter channel of a contact loop; other loops have none.
    pub fn parameters(&mut self) -> Option<Parameters> {
        match self {
            Self::Contact(control) => control.parameters(),
            Self::World(control) => control.parameters(),
            Self::Local(control) => control.parameters(),
        }
    }

    /// Starts the loop's thread, which runs until it is stopped or the device disconnects.
    pub fn start(self, request: Request) -> io::Result<Running> {
        let stop = StopFlag::new();
        Ok(match self {
            Self::Contact(control) => {
                Running::Contact(LoopThread::start(*control, request, &stop, None)?)
            }
            Self::World(control) => {
                Running::World(LoopThread::start(*control, request, &stop, None)?)
            }
            Self::Local(control) => {
                Running::Local(LoopThread::start(*control, request, &stop, None)?)
            }
        })
    }
}

impl Running {
    /// Returns the real-time requests to the system and their results.
    pub fn answers(&self) -> &[Answer] {
        match self {
            Self::Contact(thread) => thread.answers(),
            Self::World(thread) => thread.answers(),
            Self::Local(thread) => thread.answers(),
        }
    }

    /// Returns the number of times the supervisor has commanded zero force.
    pub fn cuts(&self) -> u64 {
        match self {
            Self::Contact(thread) => thread.cuts(),
            Self::World(thread) => thread.cuts(),
            Self::Local(thread) => thread.cuts(),
        }
    }

    /// Resets a latched safety stop at the next tick.
    pub fn rearm(&self) {
        match self {
            Self::Contact(thread) => thread.rearm(),
            Self::World(thread) => thread.rearm(),
            Self::Local(thread) => thread.rearm(),
        }
    }

    /// Stops the loop, waits for its end and closes the device. `names` are the names of several devices.
    pub fn end(self, names: &[String]) -> Ended {
        match self {
            Self::Contact(thread) => {
                thread.stop();
                // The returned loop owns the device; dropping it closes the device.
                Ended::of(&thread.join(), names)
            }
            Self::World(thread) => {
                thread.stop();
                Ended::of(&thread.join(), names)
            }
            Self::Local(thread) => {
                thread.stop();
                Ended::of(&thread.join(), names)
            }
        }
    }
}
