//! Real-time requests to Linux and the files with the granted values.

use std::fs;

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

pub fn run_first(priority: u8) -> Result<(), String> {
    let value = ThreadPriorityValue::try_from(priority)
        .ok()
        .filter(|_| (1..=99).contains(&priority))
        .ok_or("allowed: 1 to 99")?;
    let asked = set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    );
    let (policy, given) = scheduling()?;
    if policy == "FIFO" && given == u32::from(priority) {
        return Ok(());
    }
    let has = format!("the thread runs under {policy}, priority {given}");
    Err(match asked {
        Ok(()) => format!("the call succeeded, but {has}"),
        Err(_) => format!("not permitted; {has}"),
    })
}

pub fn lock_memory() -> Result<(), String> {
    // Do not lock future memory: without the right to lock any amount, a program that locks its future memory cannot
    // allocate beyond its limit and is terminated.
    let asked = mlockall(MlockAllFlags::CURRENT);
    let locked = status("VmLck")?;
    match asked {
        Ok(()) if locked > 0 => Ok(()),
        Ok(()) => Err("the call succeeded, but no memory is locked".to_owned()),
        Err(error) => Err(format!("{error}; {locked} kB are locked")),
    }
}

pub fn stay_on(processor: usize) -> Result<(), String> {
    if processor >= CpuSet::MAX_CPU {
        return Err(format!("allowed: 0 to {}", CpuSet::MAX_CPU - 1));
    }
    let mut only = CpuSet::new();
    only.set(processor);
    let asked = sched_setaffinity(None, &only);
    let given = sched_getaffinity(None).map_err(|error| error.to_string())?;
    if given == only {
        return Ok(());
    }
    let allowed: Vec<String> = (0..CpuSet::MAX_CPU)
        .filter(|processor| given.is_set(*processor))
        .map(|processor| processor.to_string())
        .collect();
    let why = asked
        .err()
        .map_or("ignored".to_owned(), |error| error.to_string());
    Err(format!("{why}; it may run on {}", allowed.join(", ")))
}

/// Returns policy and real-time priority of the calling thread, as reported by the kernel.
pub fn scheduling() -> Result<(&'static str, u32), String> {
    let path = "/proc/thread-self/stat";
    let line = fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    // The program's name, in brackets, may contain any characters; the third field follows it.
    let fields: Vec<&str> = line
        .rsplit_once(')')
        .map(|(_, rest)| rest.split_whitespace().collect())
        .unwrap_or_default();
    let field = |number: usize| -> Result<u32, String> {
        fields
            .get(number - 3)
            .and_then(|field| field.parse().ok())
            .ok_or_else(|| format!("{path} has no field {number}"))
    };
    let policy = match field(41)? {
        0 => "OTHER",
        1 => "FIFO",
        2 => "RR",
        3 => "BATCH",
        5 => "IDLE",
        6 => "DEADLINE",
        _ => "an unknown policy",
    };
    Ok((policy, field(40)?))
}

/// Returns a number of /proc/self/status.
fn status(key: &str) -> Result<u64, String> {
    let path = "/proc/self/status";
    let text = fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    text.lines()
        .find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))
        .and_then(|rest| rest.split_whitespace().next()?.parse().ok())
        .ok_or_else(|| format!("{path} has no {key}"))
}
