//! A simulator at 60 Hz owns a ball and a floor; a loop at 1 kHz renders them to a hand that presses the ball.
//!
//! ```text
//! cargo run --release -p palpate-rt --example low_rate_simulator
//! ```
//!
//! The device is simulated. `Host::step` and `Host::contact` take the place of a physics engine.
#![allow(clippy::print_stdout)] // prints the results
#![allow(
    clippy::disallowed_methods,
    reason = "the host's thread may wait; the loop's does not"
)]

use std::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{scope, sleep};
use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, LowRateSimulator, WorldFrame, local_world};
use palpate_scene::world::WorldFile;
use palpate_study::sim::device::SpatialDevice;
use palpate_world::engine::local::{LocalContact, LocalParams, LocalProgress, LocalRenderer};
use palpate_world::engine::{BodyNow, BodyWrench};
use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, Vector, WorldErrors, WorldLoop};

const PERIOD: f64 = 0.001;
const TOOL: f64 = 0.01;
const BALL: f64 = 0.02;
const MASS: f64 = 0.1;
const UP: Vector = [0.0, 0.0, 1.0];

/// Hand and device.
const DEVICE: &str = r#"
format = 2
loop = { period_s = 0.001 }
[[device]]
name = "tool"
mass_kg = 0.15
position_m = [0.0, 0.0, 0.055]
hand.stiffness_n_per_m = 60.0
hand.damping_n_s_per_m = 1.5
hand.rest_m = [0.0, 0.0, 0.02]
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 1000.0
"#;

/// A ball above a floor, with vertical motion only.
struct Host {
    height: f64,
    velocity: f64,
}

fn floor() -> ContactLaw {
    ContactLaw::spring(3000.0).with_damping(5.0)
}

impl Host {
    /// Advances the engine by `h` `[s]` under a constant wrench, in substeps.
    fn step(&mut self, wrench: &BodyWrench, h: f64) {
        let parts = (h / 1e-4).ceil().max(1.0);
        let part = h / parts;
        let mut done = 0.0;
        while done < parts {
            done += 1.0;
            let depth = BALL - self.height;
            let pressed = floor().stiffness * depth - floor().damping * self.velocity;
            let pushed = if depth > 0.0 { pressed.max(0.0) } else { 0.0 };
            self.velocity += part * ((pushed + wrench.force[2]) / MASS - 9.81);
            self.height += part * self.velocity;
        }
    }

    /// Returns the current ball. Apart from contact, only its weight acts: the floor is published as a contact.
    fn ball(&self) -> BodyNow {
        let mut now = BodyNow::fixed([0.0, 0.0, self.height]);
        now.velocity[2] = self.velocity;
        now.acceleration[2] = -9.81;
        let moment = 0.4 * MASS * BALL * BALL;
        for axis in 0..3 {
            now.mobility[axis][axis] = 1.0 / MASS;
            now.mobility[axis + 3][axis + 3] = 1.0 / moment;
        }
        now
    }

    /// Returns the contacts of the tool with the ball and of the ball with the floor.
    fn contacts(&self, tool: Vector) -> [Option<LocalContact>; 2] {
        let from = [tool[0], tool[1], tool[2] - self.height];
        let far = from.iter().map(|x| x * x).sum::<f64>().sqrt();
        let normal = if far > 0.0 { from.map(|x| x / far) } else { UP };
        let gap = far - BALL - TOOL;
        let law = ContactLaw::spring(1500.0);
        let ball = LocalContact::at_gap((0, tool, TOOL), Some(0), gap, normal, law);
        let centre = [0.0, 0.0, self.height];
        let on_floor = LocalContact::of_body((0, centre, BALL), None, [0.0; 3], UP, floor());
        [Some(ball.curved(1.0 / BALL)), Some(on_floor)]
    }
}

/// Runs the simulator thread.
fn host(mut slow: LowRateSimulator, is_over: &AtomicBool) -> Result<(), WorldErrors> {
    let mut world = Host {
        height: BALL,
        velocity: 0.0,
    };
    let mut taken: Option<LocalProgress> = None;
    while !is_over.load(Ordering::Acquire) {
        let progress = slow.progress().clone();
        if let Some(taken) = &taken {
            world.step(&progress.wrench_since(taken, 0), progress.time_since(taken));
        }
        slow.publish(
            progress.tick,
            &[world.ball()],
            &world.contacts(progress.positions[0]),
        )?;
        taken = Some(progress);
        sleep(Duration::from_micros(16_667));
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let tool = Tool::new("tool", Shape::Sphere { radius: TOOL });
    let renderer = LocalRenderer::new(
        &[tool],
        LocalParams::new(1, 2),
        WorldLoop::new(PERIOD),
        CoupledParams::new(vec![[0.15; 3]]),
    )?;
    let (slow, world) = local_world(renderer, WorldFrame::the_same())?;
    let scene = WorldFile::parse("device", DEVICE)?.scene;
    let clock = MonotonicClock::new();
    let device = SpatialDevice::new(&scene, 0, clock)?;
    let mut control = ControlLoop::of_local_world(device, clock, world, SafetyParams::default())?;
    let is_over = AtomicBool::new(false);
    scope(|threads| -> Result<(), Box<dyn Error>> {
        let host = threads.spawn(|| host(slow, &is_over));
        for tick in 0..1000 {
            let row = control.tick().tick;
            if tick % 100 == 99 {
                let state = control.rendered().state();
                let model = state.progress().model_tick.unwrap_or_default();
                println!(
                    "{:.1} s: {:5.2} N, tool at {:.2} mm, ball at {:.2} mm, model of tick {model}",
                    f64::from(tick + 1) * PERIOD,
                    row.commanded_force[2],
                    1e3 * row.device_axes[2],
                    1e3 * state.progress().copies[0][2],
                );
            }
        }
        control.disable_output();
        is_over.store(true, Ordering::Release);
        match host.join() {
            Ok(ended) => Ok(ended?),
            Err(_) => Err("the host's thread has panicked".into()),
        }
    })?;
    let ledger = control.rendered().state().ledger();
    println!("created energy: {:.3} mJ", 1e3 * ledger.created());
    Ok(())
}
