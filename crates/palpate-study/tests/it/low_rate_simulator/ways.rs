//! Methods for rendering the results of a low-rate simulator.

use std::time::Instant;

use palpate_testbed::world::{PlantParams, WorldPlant};
use palpate_world::engine::local::{LocalParams, LocalRenderer};
use palpate_world::{CoupledParams, Sample, Shape, Tool, WorldLoop};

use crate::low_rate_simulator::host::{FINE, Host};
use crate::low_rate_simulator::scenes::{Bench, DEVICE_MASS, PERIOD, SAMPLES};
use crate::low_rate_simulator::vector::{Vector, dot, less, sum, times};

/// When the host works: it takes what is there every so many samples, and what comes out is there so many samples
/// later.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    pub every: usize,
    pub late: usize,
}

impl Pace {
    /// Half a step of computing.
    pub fn of(every: usize) -> Self {
        Self {
            every,
            late: every / 2,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// E `[%]`.
    pub error: f64,
    /// Energy that was made out of nothing `[J]`.
    pub created: f64,
    /// Largest change of the force from sample to sample `[N]`.
    pub step: f64,
    /// Median time of a tick without a model and of one that takes a model `[us]`, of a local model.
    pub times: [f64; 2],
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// Contents of the local model.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    pub is_curved: bool,
    pub with_floor: bool,
    /// Longest part into which the host divides its steps `[s]`.
    pub part: f64,
    /// Model mass of the device over the true one.
    pub mass: f64,
}

pub const ALL: Model = Model {
    is_curved: true,
    with_floor: true,
    part: FINE,
    mass: 1.0,
};

/// The loop by the force that `force` gives for each sample's number and position.
fn run(bench: &Bench, mut force: impl FnMut(usize, Vector) -> Vector) -> (f64, f64, f64, Vector) {
    let mut device = WorldPlant::new(&bench.scene.evaluated, PlantParams::perfect(PERIOD)).unwrap();
    let mut held: Vec<Vector> = Vec::with_capacity(SAMPLES);
    let (mut work, mut step) = (0.0, 0.0_f64);
    for sample in 0..SAMPLES {
        let at = device.measure()[0];
        let now = force(sample, at);
        if let Some(last) = held.last() {
            step = step.max(dot(less(now, *last), less(now, *last)).sqrt());
        }
        held.push(now);
        device.hold(&[now]);
        work += dot(now, less(device.measure()[0], at));
    }
    (bench.error(held), work, step, device.measure()[0])
}

pub fn local(
    bench: &Bench,
    pace: Pace,
    model: Model,
    change: impl Fn(&mut LocalParams),
) -> Outcome {
    let tool = Tool::new(
        "tool",
        Shape::Sphere {
            radius: bench.scene.tool(),
        },
    );
    let mut host = Host::new(&bench.scene);
    host.part = model.part;
    let bodies = host.bodies(model.with_floor).len();
    let mut params = LocalParams::new(bodies, 9);
    change(&mut params);
    let renderer = LocalRenderer::new(
        &[tool],
        params,
        WorldLoop::new(PERIOD),
        CoupledParams::new(vec![DEVICE_MASS.map(|mass| model.mass * mass)]),
    )
    .unwrap();
    let mut state = renderer.start();
    // Until the next model is there.
    let ahead = PERIOD * (pace.every + pace.late) as f64;
    let publish = |host: &Host, tick: u64, at: Vector, velocity: Vector| {
        let contacts = host.contacts(
            (at, times(velocity, ahead)),
            model.is_curved,
            model.with_floor,
        );
        renderer
            .model(tick, &host.bodies(model.with_floor), &contacts)
            .unwrap()
    };
    let mut coming = vec![(0, publish(&host, 0, bench.scene.start, [0.0; 3]))];
    let mut taken = state.progress().clone();
    let mut times = [Vec::new(), Vec::new()];
    let (error, _, step, _) = run(bench, |sample, at| {
        if sample > 0 && sample % pace.every == 0 {
            let progress = state.progress().clone();
            let (h, wrench) = (
                progress.time_since(&taken),
                progress.wrench_since(&taken, 0),
            );
            host.step(h, |_, _| [wrench.force, wrench.torque]);
            let model = publish(
                &host,
                progress.tick,
                progress.positions[0],
                progress.velocities[0],
            );
            coming.push((sample + pace.late, model));
            taken = progress;
        }
        let due = coming.first().is_some_and(|(due, _)| *due <= sample);
        let model = due.then(|| coming.remove(0).1);
        let begin = Instant::now();
        let output = renderer.step(&mut state, &Sample::at(&[at]), model.as_ref());
        times[usize::from(due)].push(1e6 * begin.elapsed().as_secs_f64());
        assert_eq!((output.fault, output.refusal), (None, None));
        assert!(!output.is_stale, "{sample}");
        output.forces[0]
    });
    Outcome {
        error,
        created: state.ledger().created(),
        step,
        times: times.map(median),
    }
}

/// The host's own force, held between its steps.
pub fn held(bench: &Bench, pace: Pace, damping: f64) -> Outcome {
    let mut host = Host::new(&bench.scene);
    let (mut force, mut last) = ([0.0; 3], bench.scene.start);
    let mut coming: Vec<(usize, Vector)> = Vec::new();
    let (error, work, step, end) = run(bench, |sample, at| {
        if sample % pace.every == 0 {
            let h = PERIOD * pace.every as f64;
            let velocity = times(less(at, last), 1.0 / h);
            last = at;
            let push = host.pushed_by(at, velocity, damping);
            coming.push((sample + pace.late, times(push[0], -1.0)));
            host.step(h, |_, _| push);
        }
        while coming.first().is_some_and(|(due, _)| *due <= sample) {
            force = coming.remove(0).1;
        }
        force
    });
    Outcome {
        error,
        created: work + host.work + host.stored(end),
        step,
        times: [0.0; 2],
    }
}

/// A virtual coupling: the tool is a body of 50 g in the host, and a spring and a damper pull it to the device; the
/// loop pulls the device to where that body was last.
pub fn coupling(bench: &Bench, pace: Pace, stiffness: f64, damping: f64) -> Outcome {
    const MASS: f64 = 0.05;
    let mut host = Host::new(&bench.scene);
    if bench.scene.mesh.is_some() {
        // A query of the mesh takes its time.
        host.part = 4.0 * FINE;
    }
    let (mut place, mut motion) = (bench.scene.start, [0.0; 3]);
    let (mut shown, mut shown_motion) = (place, motion);
    let (mut last, mut last_sample) = (place, place);
    let mut coming: Vec<(usize, Vector, Vector)> = Vec::new();
    let (error, work, step, end) = run(bench, |sample, at| {
        if sample % pace.every == 0 {
            let h = PERIOD * pace.every as f64;
            let velocity = times(less(at, last), 1.0 / h);
            last = at;
            host.step(h, |host, fine| {
                let push = host.pushed_by(place, motion, 0.0);
                let spring = sum(
                    times(less(at, place), stiffness),
                    times(less(velocity, motion), damping),
                );
                motion = sum(motion, times(less(spring, push[0]), fine / MASS));
                place = sum(place, times(motion, fine));
                push
            });
            coming.push((sample + pace.late, place, motion));
        }
        while coming.first().is_some_and(|(due, ..)| *due <= sample) {
            (_, shown, shown_motion) = coming.remove(0);
        }
        let velocity = times(less(at, last_sample), 1.0 / PERIOD);
        last_sample = at;
        sum(
            times(less(shown, at), stiffness),
            times(less(shown_motion, velocity), damping),
        )
    });
    let apart = less(place, end);
    let kept = 0.5 * stiffness * dot(apart, apart) + 0.5 * MASS * dot(motion, motion);
    Outcome {
        error,
        created: work + host.work + host.stored(place) + kept,
        step,
        times: [0.0; 2],
    }
}
