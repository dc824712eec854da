//! Properties of the machine that affect a loop's timing.

use std::fs;

/// A property of the machine that affects a loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Name of the property.
    pub what: &'static str,
    /// Value of the property.
    pub found: String,
    /// Effect on a loop and remedy, if the value is harmful.
    pub advice: Option<&'static str>,
}

/// Returns the properties of the machine that can be read.
#[must_use]
pub fn machine() -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |what, found: Option<String>, advice: &dyn Fn(&str) -> Option<&'static str>| {
        if let Some(found) = found {
            let advice = advice(&found);
            findings.push(Finding {
                what,
                found,
                advice,
            });
        }
    };
    add("kernel", kernel(), &|found| {
        (!found.contains("PREEMPT_RT")).then_some(
            "not a real-time kernel: wake-ups can be late by tens of microseconds or more, without an upper bound",
        )
    });
    let processors = std::thread::available_parallelism().ok();
    add(
        "processors",
        processors.map(|number| number.to_string()),
        &|found| (found == "1").then_some("the loop shares its processor with everything else"),
    );
    add("share for real-time threads", runtime_share(), &|found| {
        (found != "all")
            .then_some("a loop that spins all the time is suspended for the remaining share")
    });
    add(
        "frequency governor",
        read("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        &|found| {
            (found != "performance").then_some(
                "clock rates change: `cpupower frequency-set -g performance` keeps them high",
            )
        },
    );
    add("isolated processors", isolated(), &|found| {
        (found == "none")
            .then_some("no processor is reserved for the loop (kernel option `isolcpus`)")
    });
    add("virtual machine", hypervisor(), &|found| {
        (found != "no").then_some("the host can suspend the loop at any time")
    });
    findings
}

fn read(path: &str) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    Some(text.trim().to_owned())
}

fn kernel() -> Option<String> {
    let release = read("/proc/sys/kernel/osrelease")?;
    let version = read("/proc/sys/kernel/version")?;
    let is_realtime = read("/sys/kernel/realtime").is_some_and(|text| text == "1")
        || version.contains("PREEMPT_RT");
    let preemption = if is_realtime {
        "PREEMPT_RT"
    } else if version.contains("PREEMPT") {
        "preemptible"
    } else {
        "not preemptible"
    };
    Some(format!("{release}, {preemption}"))
}

fn runtime_share() -> Option<String> {
    let runtime: f64 = read("/proc/sys/kernel/sched_rt_runtime_us")?.parse().ok()?;
    let period: f64 = read("/proc/sys/kernel/sched_rt_period_us")?.parse().ok()?;
    Some(if runtime < 0.0 {
        "all".to_owned()
    } else {
        format!("{:.0} %", 100.0 * runtime / period)
    })
}

fn isolated() -> Option<String> {
    let list = read("/sys/devices/system/cpu/isolated")?;
    Some(if list.is_empty() {
        "none".to_owned()
    } else {
        list
    })
}

fn hypervisor() -> Option<String> {
    let processor = read("/proc/cpuinfo")?;
    let flags = processor.lines().find(|line| line.starts_with("flags"))?;
    let is_guest = flags.split_whitespace().any(|flag| flag == "hypervisor");
    Some(if is_guest { "yes" } else { "no" }.to_owned())
}
