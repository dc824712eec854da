//! `Loop`: the loop of `palpate run` beside Python. Only a device in Python runs Python code in a tick.

mod control;
mod devices;
mod ended;
mod external;
mod heard;
mod held;
mod in_world;
mod low_rate_simulator;
mod options;
mod own_device;
mod prepared;
#[cfg(unix)]
mod two_diy;

pub use devices::Hand;
pub use in_world::HandInWorld;
pub use low_rate_simulator::LowRateSimulator;
#[cfg(unix)]
pub use two_diy::guard;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use numpy::PyArray1;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{OnDevice, Parameters, Recorder, Worlds, tap};
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::array;
use crate::fields::named;
use crate::names::refused;
use crate::renderer::rendering;
use crate::world::PyWorld;
use control::{Control, Running};
use ended::{Closed, EndValues, Ended};
use heard::{Events, Heard, Rows, listen};
use held::Held;
use options::Options;
use prepared::{Beside, Prepared, prepare_contact, prepare_low_rate_simulator, prepare_world};

/// Capacity of the queue to the listener thread [ticks]: 4 s at 4 kHz.
const ROOM: usize = 1 << 14;
/// Polling interval of a waiting caller for pending Python signals.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// A real-time loop on one or several devices.
#[pyclass(frozen, subclass, name = "Loop", module = "palpate._palpate")]
pub struct RealTimeLoop {
    stage: Mutex<Stage>,
    parameters: Mutex<Option<Parameters>>,
    in_world: Mutex<Option<InWorld>>,
    heard: Arc<Heard>,
    /// Held force of each device.
    held: Vec<Held>,
    /// Process that created the loop; a forked child has none of its threads.
    process: u32,
    /// Description of the devices.
    runs_on: String,
    /// Names of several devices in the world; empty for one device.
    names: Vec<String>,
    largest_force: f64,
    period: f64,
}

/// World rendering of a loop and its devices.
struct InWorld {
    worlds: Worlds,
    on: Vec<OnDevice>,
}

/// Stage of a loop with its resources.
enum Stage {
    Made(Box<Made>),
    Runs(Box<Runs>),
    Ended(Box<Ended>),
}

struct Made {
    control: Control,
    request: Request,
    recorder: Option<Recorder>,
    listening: Listening,
    opened: Vec<Closed>,
}

/// Initial state of the listener thread.
struct Listening {
    listener: palpate_rt::Listener,
    recording: Option<palpate_rt::Tap>,
}

struct Runs {
    thread: Running,
    recorder: Option<Recorder>,
    ears: std::thread::JoinHandle<()>,
    closed: Vec<Closed>,
}

/// Whether the loop runs, ticks, dropped ticks, time since the last received tick `[s]`, cuts, whether a safety stop
/// disables the motors, and the force of each device `[N]`.
type Now = (bool, u64, u64, Option<f64>, u64, bool, Vec<[f64; 3]>);

/// Words of rows: contacts, bodies, and several devices.
type Taken<'py> = (
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<u64>>,
);

#[pymethods]
impl RealTimeLoop {
    /// Opens the devices and prepares the loop; the Python file documents the arguments. `devices` are in the order
    /// of the world's devices; `rendered` is a world, a low-rate simulator, or method, parameters and settings of a
    /// contact.
    #[new]
    fn new(
        py: Python<'_>,
        devices: Vec<Bound<'_, PyDict>>,
        rendered: &Bound<'_, PyAny>,
        options: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let options: Options = options.extract().map_err(|error| named(options, error))?;
        let clock = MonotonicClock::new().with_spin(options.checked_spin()?);
        let prepared = if let Ok(world) = rendered.cast::<PyWorld>() {
            prepare_world(py, &devices, &world.borrow(), clock, &options)?
        } else if let Ok(host) = rendered.cast::<LowRateSimulator>() {
            prepare_low_rate_simulator(py, &devices, host.get(), clock, &options)?
        } else {
            prepare_contact(py, &devices, rendered, clock, &options)?
        };
        let Prepared {
            mut control,
            period,
            devices,
            in_world,
            low_rate_simulator,
            metadata,
            names,
            runs_on,
            largest_force,
        } = prepared;
        let request = options.request();
        let (recording, recorder) = match &options.record {
            Some(path) => {
                let (tap, recorder) = Recorder::begin(path, &metadata)
                    .map_err(|error| PyOSError::new_err(error.to_string()))?;
                (Some(tap), Some(recorder))
            }
            None => (None, None),
        };
        let heard = Arc::new(Heard::new(options.ring));
        if let (Some(own), Ok(host)) = (low_rate_simulator, rendered.cast::<LowRateSimulator>()) {
            host.get().belong(own, Arc::clone(&heard))?;
        }
        let (tap, listener) = tap(ROOM);
        let parameters = control.parameters();
        let (held, closed) = devices
            .into_iter()
            .map(|Beside { held, closed }| (held, closed))
            .unzip();
        Ok(Self {
            parameters: Mutex::new(parameters),
            in_world: Mutex::new(in_world),
            heard,
            held,
            process: std::process::id(),
            runs_on,
            names,
            largest_force,
            period,
            stage: Mutex::new(Stage::Made(Box::new(Made {
                control: control.tapped(tap),
                request,
                recorder,
                listening: Listening {
                    listener,
                    recording,
                },
                opened: closed,
            }))),
        })
    }

    /// Starts the loop's thread and returns each real-time request: its name, whether it was granted, and a message.
    fn start(&self, py: Python<'_>) -> PyResult<Vec<(String, bool, String)>> {
        self.check_process()?;
        py.detach(|| {
            let mut stage = lock(&self.stage);
            let Stage::Made(_) = &*stage else {
                return Err(PyRuntimeError::new_err(
                    "the loop was started before; make another Loop to run again",
                ));
            };
            let empty = Stage::Ended(Box::new(Ended::never_ran()));
            let Stage::Made(made) = std::mem::replace(&mut *stage, empty) else {
                return Err(PyRuntimeError::new_err("the loop was started before"));
            };
            let Made {
                control,
                request,
                recorder,
                listening,
                opened,
            } = *made;
            let heard = Arc::clone(&self.heard);
            let no_thread = |error: std::io::Error| {
                PyOSError::new_err(format!("cannot start the thread of the loop: {error}"))
            };
            let ears = std::thread::Builder::new()
                .name("palpate listener".to_owned())
                .spawn(move || listen(listening.listener, listening.recording, &heard))
                .map_err(no_thread)?;
            let thread = control.start(request).map_err(no_thread)?;
            let answers = thread.answers().iter().map(answer_values).collect();
            *stage = Stage::Runs(Box::new(Runs {
                thread,
                recorder,
                ears,
                closed: opened,
            }));
            Ok(answers)
        })
    }

    /// Stops the loop, waits until zero force is commanded and the outputs are disabled, and returns the result.
    fn stop(&self, py: Python<'_>) -> PyResult<EndValues> {
        self.check_process()?;
        Ok(py.detach(|| self.end()).messages())
    }

    /// Changes the parameters from the next tick on and returns their number.
    fn change(
        &self,
        method: &Bound<'_, PyAny>,
        parameters: &Bound<'_, PyDict>,
        settings: &Bound<'_, PyDict>,
    ) -> PyResult<u32> {
        self.check_process()?;
        let (_, rendering) = rendering(method, parameters, settings)?;
        match &mut *lock(&self.parameters) {
            Some(parameters) => parameters.change(rendering).map_err(refused),
            None => Err(PyRuntimeError::new_err("the loop has ended")),
        }
    }

    /// Changes the world from the next tick on and returns its number.
    fn change_world(&self, world: &Bound<'_, PyWorld>) -> PyResult<u32> {
        self.check_process()?;
        let Some(InWorld { worlds, on }) = &mut *lock(&self.in_world) else {
            return Err(PyRuntimeError::new_err("the loop has ended"));
        };
        let world = world.borrow();
        let rendered = in_world::rendered(&world, on)?;
        let described = world.scene().world.clone();
        worlds.change(described, rendered).map_err(refused)
    }

    /// Resets a latched safety stop at the next tick.
    fn rearm(&self, py: Python<'_>) -> PyResult<()> {
        self.check_process()?;
        // `stop` holds this lock until the loop has ended, so release the GIL while waiting.
        py.detach(|| match &*lock(&self.stage) {
            Stage::Runs(runs) => {
                runs.thread.rearm();
                Ok(())
            }
            _ => Err(PyRuntimeError::new_err("the loop does not run")),
        })
    }

    /// Returns the ticks since the last read. Waits up to `wait` `[s]` for the first one, and not beyond the end of
    /// the loop.
    fn take<'py>(&self, py: Python<'py>, wait: f64) -> PyResult<Taken<'py>> {
        self.check_process()?;
        let wait = Duration::try_from_secs_f64(wait).map_err(|_| {
            refused(format!(
                "wait is {wait} s, but must be finite and not below 0"
            ))
        })?;
        let until = Instant::now().checked_add(wait);
        loop {
            let rows = py.detach(|| {
                let left = until.map_or(LOOK_EVERY, |until| {
                    until.saturating_duration_since(Instant::now())
                });
                self.heard.take(left.min(LOOK_EVERY))
            });
            let is_over = until.is_some_and(|until| until <= Instant::now());
            let is_empty = rows.contacts.is_empty();
            if !is_empty || is_over || self.heard.is_closed() {
                // Include ticks that arrived between the two checks.
                let Rows {
                    contacts,
                    bodies,
                    devices,
                } = if is_empty {
                    self.heard.take(Duration::ZERO)
                } else {
                    rows
                };
                return Ok((array(py, contacts), array(py, bodies), array(py, devices)));
            }
            py.check_signals()?;
        }
    }

    /// Returns the events since the last call and the number of dropped events.
    fn events(&self) -> PyResult<Events> {
        self.check_process()?;
        Ok(self.heard.events())
    }

    /// Returns the state of the loop.
    fn now(&self, py: Python<'_>) -> PyResult<Now> {
        self.check_process()?;
        let (runs, cuts) = py.detach(|| match &*lock(&self.stage) {
            Stage::Runs(runs) => (!self.heard.is_closed(), runs.thread.cuts()),
            Stage::Ended(ended) => (false, ended.cuts),
            Stage::Made(_) => (false, 0),
        });
        let heard = self.heard.now();
        Ok((
            runs,
            heard.ticks,
            heard.lost,
            heard.silent,
            cuts,
            heard.stopped,
            self.held.iter().map(Held::force).collect(),
        ))
    }

    /// Name of the device, or of several devices, each after its name in the world.
    #[getter]
    fn device_name(&self) -> &str {
        &self.runs_on
    }

    /// Nominal period `[s]`.
    #[getter]
    fn period(&self) -> f64 {
        self.period
    }

    /// Largest commanded force `[N]`: the maximum over several devices.
    #[getter]
    fn force_limit(&self) -> f64 {
        self.largest_force
    }
}

impl RealTimeLoop {
    /// Rejects a process that has none of the loop's threads.
    fn check_process(&self) -> PyResult<()> {
        if self.process == std::process::id() {
            return Ok(());
        }
        Err(PyRuntimeError::new_err(format!(
            "the loop runs in process {}, but this process was forked off it: make a Loop in this process",
            self.process
        )))
    }

    /// Ends the loop in any stage. Takes the time of a tick and of the device's last reply.
    fn end(&self) -> Ended {
        // Held until the end, so that concurrent callers wait for the same result.
        let mut stage = lock(&self.stage);
        let empty = Stage::Ended(Box::new(Ended::never_ran()));
        let ended = match std::mem::replace(&mut *stage, empty) {
            Stage::Ended(ended) => ended,
            Stage::Made(made) => {
                let Made {
                    control,
                    recorder,
                    listening,
                    opened,
                    ..
                } = *made;
                drop((control, listening));
                let mut ended = Ended::never_ran();
                ended.closes(recorder, &opened, &self.names);
                Box::new(ended)
            }
            Stage::Runs(runs) => {
                let Runs {
                    thread,
                    recorder,
                    ears,
                    closed,
                } = *runs;
                let mut ended = thread.end(&self.names);
                let is_deaf = ears.join().is_err();
                ended.closes(recorder, &closed, &self.names);
                if is_deaf {
                    ended.fails(
                        "the listener thread of the loop panicked, a defect in palpate".into(),
                    );
                }
                Box::new(ended)
            }
        };
        lock(&self.parameters).take();
        lock(&self.in_world).take();
        self.heard.close();
        *stage = Stage::Ended(ended.clone());
        *ended
    }
}

impl Drop for RealTimeLoop {
    fn drop(&mut self) {
        if self.process == std::process::id() {
            // A device in Python needs the interpreter's lock for its last tick.
            let this: &Self = self;
            if Python::try_attach(|py| py.detach(|| this.end())).is_none() {
                let _ = this.end();
            }
            return;
        }
        // Threads and device belong to the parent process: do not communicate with the device from here.
        let stage = std::mem::replace(
            self.stage.get_mut().unwrap_or_else(PoisonError::into_inner),
            Stage::Ended(Box::new(Ended::never_ran())),
        );
        std::mem::forget(stage);
    }
}

fn answer_values(answer: &Answer) -> (String, bool, String) {
    (
        answer.asked.clone(),
        answer.is_granted(),
        answer.to_string(),
    )
}

/// Locks a mutex and ignores poisoning: a loop must be stoppable after a panic.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
