//! A loop on its own thread, with a supervisor.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};

use crate::control_loop::ControlLoop;
use crate::note::Ending;
use crate::realtime::{Answer, Request};
use crate::rendering::{OneContact, Parameters, Renders};
use crate::safety::{Heartbeat, SafetyStop};
use crate::statistics::LoopStatistics;
use crate::stop::StopFlag;
use palpate_device::Device;
use palpate_device::clock::Clock;

/// A loop that runs on its own thread. Dropping it stops the loop and waits until zero force has been commanded.
pub struct LoopThread<D: Device, C: Clock, R: Renders = OneContact> {
    thread: Option<JoinHandle<LoopEnd<D, C, R>>>,
    stop: StopFlag,
    rearm: Arc<AtomicBool>,
    heartbeat: Arc<Heartbeat>,
    parameters: Option<Parameters>,
    supervisor: Option<JoinHandle<()>>,
    ended: Arc<AtomicBool>,
    answers: Vec<Answer>,
}

/// Result of a loop.
pub struct LoopEnd<D: Device, C: Clock, R: Renders = OneContact> {
    /// Reason for its end.
    pub ending: Ending,
    /// Timing statistics.
    pub statistics: LoopStatistics,
    /// Safety stop that held the force at 0 at the end, if any.
    pub safety_stop: Option<SafetyStop>,
    /// Number of zero commands by the supervisor.
    pub cuts: u64,
    /// Message of the panic, if a tick panicked.
    pub panic: Option<String>,
    /// The loop itself, with its outputs disabled.
    pub control: ControlLoop<D, C, R>,
}

impl<D: Device + 'static, C: Clock, R: Renders + 'static> LoopThread<D, C, R> {
    /// Starts `control` on a thread with the real-time requests `request`, and runs it until `stop` is raised, `most`
    /// periods are over or the device is gone.
    ///
    /// # Errors
    /// The system cannot create a thread.
    pub fn start(
        mut control: ControlLoop<D, C, R>,
        request: Request,
        stop: &StopFlag,
        most: Option<u64>,
    ) -> io::Result<Self> {
        let parameters = control.parameters();
        let rearm = control.rearm();
        let heartbeat = control.heartbeat();
        // Before the loop starts: a loop that never sleeps might not let the supervisor make its requests.
        let Supervised {
            thread: supervisor,
            answers: beside,
            ended,
        } = Supervised::start(&mut control, request)?;
        let (messages, answered) = std::sync::mpsc::channel();
        let (stopped, over) = (stop.clone(), Arc::clone(&ended));
        let thread = Builder::new()
            .name("palpate loop".to_owned())
            .spawn(move || {
                let _over = Over(over);
                let _ = messages.send(request.ask());
                run(control, &stopped, most)
            });
        let thread = thread.inspect_err(|_| ended.store(true, Ordering::Release))?;
        let mut answers: Vec<Answer> = answered.recv().unwrap_or_default();
        let is_refused = answers.iter().any(|answer| !answer.is_granted());
        answers.extend(supervisors(beside, is_refused));
        Ok(Self {
            answers,
            thread: Some(thread),
            stop: stop.clone(),
            rearm,
            heartbeat,
            parameters,
            supervisor,
            ended,
        })
    }
}

impl<D: Device, C: Clock, R: Renders> LoopThread<D, C, R> {
    /// Returns the results of the real-time requests.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// Returns the other end of the loop's parameters.
    pub fn parameters(&mut self) -> Option<&mut Parameters> {
        self.parameters.as_mut()
    }

    /// Returns how often the supervisor has commanded zero force so far.
    #[must_use]
    pub fn cuts(&self) -> u64 {
        self.heartbeat.cuts()
    }

    /// Ends a latched safety stop at the next tick.
    pub fn rearm(&self) {
        self.rearm.store(true, Ordering::Release);
    }

    /// Returns whether the loop has ended.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    /// Requests the end of the loop.
    pub fn stop(&self) {
        self.stop.raise();
    }

    /// Waits for the loop to end.
    ///
    /// # Panics
    /// The thread ended without a result.
    #[must_use]
    pub fn join(mut self) -> LoopEnd<D, C, R> {
        let end = self.thread.take().map(JoinHandle::join);
        self.finish();
        match end {
            Some(Ok(end)) => end,
            _ => panic!("the loop's thread ended without a result"),
        }
    }

    fn finish(&mut self) {
        self.ended.store(true, Ordering::Release);
        if let Some(supervisor) = self.supervisor.take() {
            let _ = supervisor.join();
        }
    }
}

impl<D: Device, C: Clock, R: Renders> Drop for LoopThread<D, C, R> {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            self.stop.raise();
            let _ = thread.join();
        }
        self.finish();
    }
}

/// The supervisor of a loop on its thread.
pub(crate) struct Supervised {
    /// `None`: no device has a zero writer, or the clock advances only in the loop.
    pub thread: Option<JoinHandle<()>>,
    /// Results of its real-time requests.
    pub answers: Vec<Answer>,
    /// Ends it.
    pub ended: Arc<AtomicBool>,
}

impl Supervised {
    /// Starts the supervisor of `control`, whose own thread has the requests `request`.
    pub fn start<D: Device, C: Clock, R: Renders>(
        control: &mut ControlLoop<D, C, R>,
        request: Request,
    ) -> io::Result<Self> {
        let ended = Arc::new(AtomicBool::new(false));
        let (sent, answered) = std::sync::mpsc::channel();
        let supervisor = control.supervisor().filter(|_| C::RUNS);
        let thread = supervisor.map(|supervisor| {
            // The loop's own clock: by another clock the loop might never be late.
            let (clock, ended) = (control.clock(), Arc::clone(&ended));
            // Above the priority of the loop, or it could not cut a loop that never sleeps.
            let priority = request.priority.map(|priority| (priority + 1).min(99));
            Builder::new()
                .name("palpate supervisor".to_owned())
                .spawn(move || {
                    let beside = Request {
                        priority,
                        ..Request::nothing()
                    };
                    let _ = sent.send(beside.ask());
                    supervisor.watch(&clock, &ended);
                })
        });
        let thread = thread.transpose()?;
        Ok(Self {
            answers: answered.recv().unwrap_or_default(),
            thread,
            ended,
        })
    }
}

/// Returns the results of the supervisor's requests, without refusals that the loop's results already contain.
fn supervisors(beside: Vec<Answer>, loop_is_refused: bool) -> impl Iterator<Item = Answer> {
    beside
        .into_iter()
        .filter(move |answer| answer.is_granted() || !loop_is_refused)
        .map(|answer| Answer {
            asked: format!("supervisor: {}", answer.asked),
            ..answer
        })
}

/// Sets the flag when dropped, however the loop ended.
pub(crate) struct Over(pub Arc<AtomicBool>);

impl Drop for Over {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Runs the loop; zero force is commanded however it ends.
fn run<D: Device, C: Clock, R: Renders>(
    mut control: ControlLoop<D, C, R>,
    stop: &StopFlag,
    most: Option<u64>,
) -> LoopEnd<D, C, R> {
    let ran = catch_unwind(AssertUnwindSafe(|| control.run(stop, most)));
    let (ending, panic) = match ran {
        Ok(ending) => (ending, None),
        Err(payload) => {
            // The panic may come from the device.
            if catch_unwind(AssertUnwindSafe(|| control.disable_output())).is_err() {
                let _ = catch_unwind(AssertUnwindSafe(|| control.cut_off()));
            }
            (Ending::Panicked, Some(words(payload.as_ref())))
        }
    };
    concluded(control, ending, panic)
}

/// Closes the tap and returns the result of a loop.
pub(crate) fn concluded<D: Device, C: Clock, R: Renders>(
    mut control: ControlLoop<D, C, R>,
    ending: Ending,
    panic: Option<String>,
) -> LoopEnd<D, C, R> {
    control.close_tap(ending);
    LoopEnd {
        ending,
        statistics: control.statistics().clone(),
        safety_stop: control.safety_stop(),
        cuts: control.cuts(),
        panic,
        control,
    }
}

pub(crate) fn words(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}
