//! What became of a loop, as an exit code.

use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::recording::Recording;
use palpate_rt::safety::Trip;
use palpate_rt::{Ending, LoopEnd, LoopStatistics, Renders};

use crate::failure::Failure;
use crate::recorded::whole_or_said;
use palpate_study::recording::{motors_off, refused};

/// What a loop was to do.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// How long it was to run `[s]`; infinite: until it is stopped.
    pub duration: f64,
    /// Whether the device may go before that, as a recorded motion does at its end.
    pub device_may_end: bool,
    /// What to say of a device that was lost.
    pub lost: &'static str,
}

/// A trip that passes by itself counts at the end of a run when the motors have been off for as long: a shorter one is a hiccup of
/// the machine, which the end of the run has met by chance.
const NO_MOMENT: Duration = Duration::from_millis(100);

/// Whether the loop did what it was asked to: `Err` is the gravest thing that went wrong, in the order
/// of a panic, a recording that could not be written, a lost device, a recording that is not whole, an
/// end before its time, motors that were off at the end or for most of the time, and samples that the renderer refused as
/// long.
pub fn of<D: Device, C: Clock, R: Renders>(
    end: &LoopEnd<D, C, R>,
    asked: &Asked,
    unwritten: Option<Failure>,
    recording: Option<&Recording>,
) -> Result<(), Failure> {
    if let Some(words) = &end.panic {
        return Err(Failure::System(format!(
            "the loop panicked, and no force was commanded: {words}"
        )));
    }
    unwritten.map_or(Ok(()), Err)?;
    if end.ending == Ending::DeviceLost && !asked.device_may_end {
        return Err(Failure::System(asked.lost.into()));
    }
    recording.map_or(Ok(()), whole_or_said)?;
    if end.ending == Ending::Stopped && asked.duration.is_finite() {
        return Err(Failure::Interrupted(format!(
            "stopped before its {} s were over; what was done is kept",
            asked.duration
        )));
    }
    motors(end, asked)?;
    samples(&end.statistics)
}

/// The same, where the loop had devices with these `names`: of several, the one that has gone or tripped is named.
pub fn by_device<D: Device, C: Clock, R: Renders>(
    outcome: Result<(), Failure>,
    end: &LoopEnd<D, C, R>,
    names: &[&str],
) -> Result<(), Failure> {
    let tripped = end.control.tripped_device().filter(|_| names.len() > 1);
    let name = tripped.and_then(|(device, _)| names.get(device));
    match (outcome, name) {
        (Err(failure), Some(name))
            if end.ending == Ending::DeviceLost || matches!(failure, Failure::MotorsOff(_)) =>
        {
            Err(failure.of(&format!("device {name}")))
        }
        (outcome, _) => outcome,
    }
}

/// The same, where a recorded motion was replayed: a recording that is not whole counts as one that was
/// made and is not.
pub fn with_motion(
    outcome: Result<(), Failure>,
    motion: Result<(), Failure>,
) -> Result<(), Failure> {
    match outcome {
        Err(lesser @ (Failure::Interrupted(_) | Failure::MotorsOff(_))) => motion.and(Err(lesser)),
        other => other.and(motion),
    }
}

/// Whether the renderer took the samples: a refused one commands no force.
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

fn motors<D: Device, C: Clock, R: Renders>(
    end: &LoopEnd<D, C, R>,
    asked: &Asked,
) -> Result<(), Failure> {
    let statistics = &end.statistics;
    let stays = |trip: &Trip| match trip {
        Trip::DeviceLost => !asked.device_may_end,
        other => !other.is_passing() || statistics.off_at_end >= NO_MOMENT,
    };
    let time = statistics.time;
    let words = || motors_off(Some(time), statistics.motors_off, statistics.ticks);
    if let Some(trip) = end.trip.filter(stays) {
        return Err(Failure::MotorsOff(format!(
            "{}; when it ended: {trip}",
            words()
        )));
    }
    if time.motors_off > time.lasted / 2 {
        return Err(Failure::MotorsOff(words()));
    }
    Ok(())
}
