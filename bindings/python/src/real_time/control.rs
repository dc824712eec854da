//! A loop of one contact, of a world or of a slow host, before and while it runs.

use std::io;

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{ChangingWorld, ControlLoop, LocalWorld, LoopThread, Parameters, StopFlag, Tap};

use super::ended::Ended;

/// A loop that has not begun.
pub enum Control {
    Contact(Box<ControlLoop<Box<dyn Device>, MonotonicClock>>),
    World(Box<ControlLoop<Box<dyn Device>, MonotonicClock, ChangingWorld>>),
    Local(Box<ControlLoop<Box<dyn Device>, MonotonicClock, LocalWorld>>),
}

/// A loop in its thread.
pub enum Running {
    Contact(LoopThread<Box<dyn Device>, MonotonicClock>),
    World(LoopThread<Box<dyn Device>, MonotonicClock, ChangingWorld>),
    Local(LoopThread<Box<dyn Device>, MonotonicClock, LocalWorld>),
}

impl Control {
    /// The same loop, telling `tap` what it does.
    pub fn tapped(self, tap: Tap) -> Self {
        match self {
            Self::Contact(control) => Self::Contact(Box::new(control.tapped(tap))),
            Self::World(control) => Self::World(Box::new(control.tapped(tap))),
            Self::Local(control) => Self::Local(Box::new(control.tapped(tap))),
        }
    }

    /// The other end of the parameters of a contact; others have none.
    pub fn parameters(&mut self) -> Option<Parameters> {
        match self {
            Self::Contact(control) => control.parameters(),
            Self::World(control) => control.parameters(),
            Self::Local(control) => control.parameters(),
        }
    }

    /// Starts the loop's thread, and runs it until it is stopped or the device is gone.
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
    /// What the machine was asked for, and what it granted.
    pub fn answers(&self) -> &[Answer] {
        match self {
            Self::Contact(thread) => thread.answers(),
            Self::World(thread) => thread.answers(),
            Self::Local(thread) => thread.answers(),
        }
    }

    /// How often the supervisor has commanded no force so far.
    pub fn cuts(&self) -> u64 {
        match self {
            Self::Contact(thread) => thread.cuts(),
            Self::World(thread) => thread.cuts(),
            Self::Local(thread) => thread.cuts(),
        }
    }

    /// Ends a trip that stays, with the next tick.
    pub fn rearm(&self) {
        match self {
            Self::Contact(thread) => thread.rearm(),
            Self::World(thread) => thread.rearm(),
            Self::Local(thread) => thread.rearm(),
        }
    }

    /// Ends the loop, waits for its end and closes the device.
    /// `names` are those of several devices.
    pub fn end(self, names: &[String]) -> Ended {
        match self {
            Self::Contact(thread) => {
                thread.stop();
                // What it gives back holds the device, which closes as it goes.
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
