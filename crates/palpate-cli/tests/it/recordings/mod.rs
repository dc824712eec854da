//! Recordings for tests: simulated loops, recorded like live ones.
#![allow(dead_code, reason = "each test program uses its own part")]

use std::path::Path;

use palpate_record::recording::{
    ContactTick, Event, Flags, LoopCount, Phase, RecordingMetadata, RecordingWriter, Row, Tick,
};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Jitter};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;

/// Runs a committed scene with early and late samples by a method. Returns its text and its run.
pub fn loop_of(name: &str, method: MethodName) -> (String, Run) {
    let text = super::common::experiment_text(name);
    let run = loop_in(&text, method);
    (text, run)
}

/// Runs a scene with early and late samples by a method.
pub fn loop_in(text: &str, method: MethodName) -> Run {
    let mut scene = ContactFile::parse("scene", text).unwrap().scene;
    scene.timing.jitter = Jitter::Uniform {
        bound: 0.2 * scene.loop_params.period,
    };
    Bench::new(&scene).unwrap().run(method).unwrap()
}

/// Returns a tick of a run and its contact in the form of a recorder.
#[allow(clippy::needless_update, reason = "columns may come")]
pub fn row(run: &Run, at: usize) -> Row {
    let tick = &run.ticks[at];
    let period = at
        .checked_sub(1)
        .map(|before| tick.time - run.ticks[before].time);
    let ledger = &tick.ledger;
    Row {
        tick: Tick {
            sequence: at as u64,
            time: tick.time,
            lateness: 1e-5 * (at % 7) as f64,
            period: period.unwrap_or(f64::NAN),
            device_axes: [0.0, tick.device_position, f64::NAN],
            tick_duration: 2e-5,
            device_round_trip: f64::NAN,
            generation: 0,
            flags: Flags::default().with(Flags::CONTACT, tick.output.penetration > 0.0),
            ..Tick::UNKNOWN
        },
        contact: ContactTick {
            device_position: tick.device_position,
            object_position: tick.output.object_position,
            object_velocity: tick.output.object_velocity,
            penetration: tick.output.penetration,
            proxy_shift: tick.output.proxy_shift,
            force_on_object: tick.output.force_on_object,
            force_on_device: tick.output.force_on_device,
            stored_energy: ledger.stored,
            port_work: ledger.port_work,
            virtual_force_work: ledger.virtual_force_work,
            outside_work: ledger.outside_work,
            original_leak: ledger.original_leak.accumulated,
            held_leak: ledger.held_leak.accumulated,
            phase: Phase::ALL
                .into_iter()
                .find(|phase| phase.name() == tick.output.phase.name())
                .unwrap(),
            ..ContactTick::UNKNOWN
        },
        ..Row::UNKNOWN
    }
}

/// Appends a row.
pub fn append(writer: &mut RecordingWriter, row: &Row) {
    writer.append(&row.tick, &[row.contact]).unwrap();
}

/// Records a run, without the ticks that `keeps` rejects.
pub fn write(path: &Path, text: &str, run: &Run, keeps: impl Fn(usize) -> bool) {
    let metadata = RecordingMetadata::new("0.1.0").with("scene", text);
    let mut writer = RecordingWriter::create(path, &metadata).unwrap();
    for at in (0..run.ticks.len()).filter(|&at| keeps(at)) {
        append(&mut writer, &row(run, at));
    }
    let end = run.ticks.len() - 1;
    let event = |kind: &str, text: &str| Event {
        sequence: end as u64,
        time: run.ticks[end].time,
        kind: kind.into(),
        text: text.into(),
    };
    writer
        .event(&event("safety", "the force limit acted"))
        .unwrap();
    writer.event(&event("end", "ctrl-C")).unwrap();
    let count = LoopCount {
        ticks: run.ticks.len() as u64,
        events: 2,
        motors_off: 0,
        time: None,
        ending: Some("it was asked to stop".into()),
    };
    writer.count(&count).unwrap();
    writer.finish().unwrap();
}

/// A whole recording of a loop by hfcr.
pub fn record(path: &Path) -> Run {
    let (text, run) = loop_of("experiment1", MethodName::Hfcr);
    write(path, &text, &run, |_| true);
    run
}
