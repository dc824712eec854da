//! A loop whose ticks another scheduler makes.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::JoinHandle;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::recording::Row;

use crate::control_loop::ControlLoop;
use crate::note::Ending;
use crate::realtime::{Answer, Request};
use crate::rendering::{OneContact, Renders};
use crate::stop::StopFlag;
use crate::thread::{LoopEnd, Over, Supervised, concluded, words};

/// A loop that is ticked by a thread of another scheduler, such as the callback of a vendor's library or of a sound card.
///
/// The other thread calls [`tick`](Self::tick) about once in a period. Deadlines, missed deadlines, the supervisor, the
/// recorder and the end are those of a [`LoopThread`](crate::LoopThread). Each deadline is a period after the last tick:
/// the other scheduler keeps its own phase and may drift.
///
/// When this is dropped, it commands zero force on each device.
pub struct ForeignTicks<D: Device, C: Clock, R: Renders = OneContact> {
    /// `None` after the end.
    control: Option<ControlLoop<D, C, R>>,
    stop: StopFlag,
    most: Option<u64>,
    ended: Option<(Ending, Option<String>)>,
    answers: Vec<Answer>,
    supervisor: Option<JoinHandle<()>>,
    over: Option<Over>,
}

impl<D: Device, C: Clock, R: Renders> ForeignTicks<D, C, R> {
    /// Prepares `control` and starts its supervisor, with one more than the priority of `request`; the loop's thread belongs
    /// to its scheduler, so nothing is requested for it. The loop ends when `stop` is raised, `most` periods are over or
    /// the device is gone.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn start(
        mut control: ControlLoop<D, C, R>,
        request: Request,
        stop: &StopFlag,
        most: Option<u64>,
    ) -> io::Result<Self> {
        let Supervised {
            thread,
            answers,
            ended,
        } = Supervised::start(&mut control, request)?;
        Ok(Self {
            control: Some(control),
            stop: stop.clone(),
            most,
            ended: None,
            answers,
            supervisor: thread,
            over: Some(Over(ended)),
        })
    }

    /// Returns the results of the supervisor's requests.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// Performs one tick now, without sleeping. `None`: the loop has ended, and zero force is commanded. It never panics: a
    /// panic of the device ends the loop.
    pub fn tick(&mut self) -> Option<Row> {
        let control = self.control.as_mut().filter(|_| self.ended.is_none())?;
        let ticked = catch_unwind(AssertUnwindSafe(|| {
            control.tick_unless(&self.stop, self.most)
        }));
        match ticked {
            Ok(Ok(row)) => Some(row),
            Ok(Err(ending)) => {
                self.ended = Some((ending, None));
                None
            }
            Err(payload) => {
                if catch_unwind(AssertUnwindSafe(|| control.disable_output())).is_err() {
                    let _ = catch_unwind(AssertUnwindSafe(|| control.cut_off()));
                }
                self.ended = Some((Ending::Panicked, Some(words(payload.as_ref()))));
                None
            }
        }
    }

    /// Ends the loop, commands zero force and returns the result. The other scheduler must have stopped.
    #[must_use]
    pub fn finish(mut self) -> Option<LoopEnd<D, C, R>> {
        let mut control = self.control.take()?;
        let (ending, panic) = self.ended.take().unwrap_or_else(|| {
            control.disable_output();
            (Ending::Stopped, None)
        });
        self.rest();
        Some(concluded(control, ending, panic))
    }

    /// Ends the supervisor.
    fn rest(&mut self) {
        self.over = None;
        if let Some(supervisor) = self.supervisor.take() {
            let _ = supervisor.join();
        }
    }
}

impl<D: Device, C: Clock, R: Renders> Drop for ForeignTicks<D, C, R> {
    fn drop(&mut self) {
        // Zero force first: dropping the loop commands it.
        self.control = None;
        self.rest();
    }
}
