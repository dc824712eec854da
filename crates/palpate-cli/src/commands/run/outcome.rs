//! Outcome of a loop as an exit code.

use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::recording::Recording;
use palpate_rt::safety::SafetyStop;
use palpate_rt::{Account, Ending, LoopEnd, LoopStatistics, Renders};

use crate::failure::Failure;
use crate::recorded::whole_or_said;
use palpate_study::recording::{motors_off, refused};

/// Intended run of a loop.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Intended duration `[s]`; infinite: until it is stopped.
    pub duration: f64,
    /// Whether the device may end earlier, as a recorded motion does.
    pub device_may_end: bool,
    /// Message for a lost device.
    pub lost: &'static str,
}

/// Minimum duration of a self-clearing safety stop at the end of a run for it to count: a shorter one is a hiccup of
/// the machine that coincided with the end.
const NO_MOMENT: Duration = Duration::from_millis(100);

/// Returns the outcome of a loop. `Err` is the most severe failure, in this order: a panic, a recording that could not
/// be written, a lost device, an incomplete recording, an early end, motors that were off at the end or for most of the
/// time, and samples rejected for as long.
pub fn of<D: Device, C: Clock, R: Renders>(
    end: &LoopEnd<D, C, R>,
    asked: &Asked,
    account: &Account,
    unwritten: Option<Failure>,
    recording: Option<&Recording>,
) -> Result<(), Failure> {
    if let Some(words) = &end.panic {
        return Err(Failure::System(format!(
            "the loop panicked; the commanded force is 0: {words}"
        )));
    }
    unwritten.map_or(Ok(()), Err)?;
    if end.ending == Ending::DeviceLost && !asked.device_may_end {
        return Err(Failure::System(asked.lost.into()));
    }
    recording.map_or(Ok(()), whole_or_said)?;
    if end.ending == Ending::Stopped && asked.duration.is_finite() {
        return Err(Failure::Interrupted(format!(
            "stopped before the end of {} s; results so far are kept",
            asked.duration
        )));
    }
    motors(end, asked, account)?;
    samples(&end.statistics)
}

/// Adds the names of lost or stopped devices to the outcome of a loop with several devices called `names`.
pub fn by_device<D: Device, C: Clock, R: Renders>(
    outcome: Result<(), Failure>,
    end: &LoopEnd<D, C, R>,
    names: &[&str],
) -> Result<(), Failure> {
    let stopped = end.control.stopped_device().filter(|_| names.len() > 1);
    let name = stopped.and_then(|(device, _)| names.get(device));
    match (outcome, name) {
        (Err(failure), Some(name))
            if end.ending == Ending::DeviceLost || matches!(failure, Failure::MotorsOff(_)) =>
        {
            Err(failure.of(&format!("device {name}")))
        }
        (outcome, _) => outcome,
    }
}

/// Treats an incomplete recording whose motion was replayed as an incomplete recording of this run.
pub fn with_motion(
    outcome: Result<(), Failure>,
    motion: Result<(), Failure>,
) -> Result<(), Failure> {
    match outcome {
        Err(lesser @ (Failure::Interrupted(_) | Failure::MotorsOff(_))) => motion.and(Err(lesser)),
        other => other.and(motion),
    }
}

/// Checks that the renderer accepted the samples: a rejected one commands no force.
fn samples(statistics: &LoopStatistics) -> Result<(), Failure> {
    let LoopStatistics {
        ticks,
        refused: all,
        refused_at_end: last,
        time,
        ..
    } = *statistics;
    let at_end = time.lasted.mul_f64(last as f64 / ticks.max(1) as f64);
    if all > ticks / 2 || at_end >= NO_MOMENT {
        return Err(Failure::MotorsOff(refused(all, ticks)));
    }
    Ok(())
}

/// Describes the safety stop of the end, with its time and the error of the device that caused it, if known.
fn stop_in_words(safety_stop: SafetyStop, account: &Account) -> String {
    let kind = format!("safety-stop-{}", safety_stop.name());
    let stop = account.last_stop.as_ref().filter(|stop| stop.kind == kind);
    let Some(stop) = stop else {
        return safety_stop.to_string();
    };
    let error = account.last_device_error.as_ref();
    let error = error.filter(|error| error.sequence == stop.sequence);
    let error = error.map_or_else(String::new, |error| format!(": {}", error.text));
    format!("{safety_stop}, since {:.4} s{error}", stop.time)
}

fn motors<D: Device, C: Clock, R: Renders>(
    end: &LoopEnd<D, C, R>,
    asked: &Asked,
    account: &Account,
) -> Result<(), Failure> {
    let statistics = &end.statistics;
    let stays = |safety_stop: &SafetyStop| match safety_stop {
        SafetyStop::DeviceLost => !asked.device_may_end,
        other => !other.is_passing() || statistics.off_at_end >= NO_MOMENT,
    };
    let time = statistics.time;
    let words = || motors_off(Some(time), statistics.motors_off, statistics.ticks);
    if let Some(safety_stop) = end.safety_stop.filter(stays) {
        return Err(Failure::MotorsOff(format!(
            "{}; when it ended: {}",
            words(),
            stop_in_words(safety_stop, account)
        )));
    }
    if time.motors_off > time.lasted / 2 {
        return Err(Failure::MotorsOff(words()));
    }
    Ok(())
}
