//! A loop on a thread of its own, with a supervisor beside it.

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
use crate::safety::{Heartbeat, Trip};
use crate::statistics::LoopStatistics;
use crate::stop::StopFlag;
use palpate_device::Device;
use palpate_device::clock::Clock;

/// A loop that runs on its own thread. Dropping it stops the loop and waits for the device to be
/// commanded no force.
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

/// What a loop has left behind.
pub struct LoopEnd<D: Device, C: Clock, R: Renders = OneContact> {
    /// Why it ended.
    pub ending: Ending,
    /// How it kept time.
    pub statistics: LoopStatistics,
    /// The trip that held the force at none at the end, if one did.
    pub trip: Option<Trip>,
    /// How often the supervisor had to command no force.
    pub cuts: u64,
    /// What the panic said, if a tick panicked.
    pub panic: Option<String>,
    /// The loop itself, which has let go of its device.
    pub control: ControlLoop<D, C, R>,
}

impl<D: Device + 'static, C: Clock, R: Renders + 'static> LoopThread<D, C, R> {
    /// Starts `control` on a thread for which the machine is asked `request`, and runs it until
    /// `stop` is raised, `most` periods are over or the device is gone.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        mut control: ControlLoop<D, C, R>,
        request: Request,
        stop: &StopFlag,
        most: Option<u64>,
    ) -> io::Result<Self> {
        let parameters = control.parameters();
        let rearm = control.rearm();
        let heartbeat = control.heartbeat();
        let ended = Arc::new(AtomicBool::new(false));
        let (told_beside, answered_beside) = std::sync::mpsc::channel();
        let supervisor = control
            .supervisor()
            .filter(|_| C::RUNS)
            .map(|supervisor| {
                // The loop's own: on another one it might never seem late.
                let (clock, ended) = (control.clock(), Arc::clone(&ended));
                let interval = control.period() / 2;
                // Before the loop in line, or a loop that never sleeps could not be cut.
                let priority = request.priority.map(|priority| (priority + 1).min(99));
                Builder::new()
                    .name("palpate supervisor".to_owned())
                    .spawn(move || {
                        let beside = Request {
                            priority,
                            ..Request::nothing()
                        };
                        let _ = told_beside.send(beside.ask());
                        supervisor.watch(&clock, interval, &ended);
                    })
            })
            .transpose()?;
        // Before the loop begins: one that never sleeps might not let the supervisor ask.
        let beside = answered_beside.recv().unwrap_or_default();
        let (told, answered) = std::sync::mpsc::channel();
        let (stopped, over) = (stop.clone(), Arc::clone(&ended));
        let thread = Builder::new()
            .name("palpate loop".to_owned())
            .spawn(move || {
                let _over = Over(over);
                let _ = told.send(request.ask());
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
    /// What the machine granted, and what not.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// The other end of the loop's parameters.
    pub fn parameters(&mut self) -> Option<&mut Parameters> {
        self.parameters.as_mut()
    }

    /// How often the supervisor has commanded no force so far.
    #[must_use]
    pub fn cuts(&self) -> u64 {
        self.heartbeat.cuts()
    }

    /// Ends a trip that stays, with the next tick.
    pub fn rearm(&self) {
        self.rearm.store(true, Ordering::Release);
    }

    /// Whether the loop has ended.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    /// Asks the loop to end.
    pub fn stop(&self) {
        self.stop.raise();
    }

    /// Waits for the loop to end.
    ///
    /// # Panics
    /// The thread could not even say how it ended.
    #[must_use]
    pub fn join(mut self) -> LoopEnd<D, C, R> {
        let end = self.thread.take().map(JoinHandle::join);
        self.finish();
        match end {
            Some(Ok(end)) => end,
            _ => panic!("the loop's thread is gone without a word"),
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

/// What the supervisor was answered, but for a refusal where the loop was refused as well: once is
/// enough.
fn supervisors(beside: Vec<Answer>, loop_is_refused: bool) -> impl Iterator<Item = Answer> {
    beside
        .into_iter()
        .filter(move |answer| answer.is_granted() || !loop_is_refused)
        .map(|answer| Answer {
            asked: format!("supervisor: {}", answer.asked),
            ..answer
        })
}

/// Says that the loop has ended, however it did.
struct Over(Arc<AtomicBool>);

impl Drop for Over {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Runs the loop; whatever happens in it, the device is commanded no force.
fn run<D: Device, C: Clock, R: Renders>(
    mut control: ControlLoop<D, C, R>,
    stop: &StopFlag,
    most: Option<u64>,
) -> LoopEnd<D, C, R> {
    let ran = catch_unwind(AssertUnwindSafe(|| control.run(stop, most)));
    let (ending, panic) = match ran {
        Ok(ending) => (ending, None),
        Err(payload) => {
            // The device may be what panics.
            if catch_unwind(AssertUnwindSafe(|| control.let_go())).is_err() {
                let _ = catch_unwind(AssertUnwindSafe(|| control.cut_off()));
            }
            (Ending::Panicked, Some(words(payload.as_ref())))
        }
    };
    control.close_tap(ending);
    LoopEnd {
        ending,
        statistics: control.statistics().clone(),
        trip: control.trip(),
        cuts: control.cuts(),
        panic,
        control,
    }
}

fn words(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "it did not say why".to_owned())
}
