//! The host: it renders the wall from the samples that the board sends, at its own rate.

use core::sync::atomic::Ordering;

use palpate::{
    Actuation, Contact, Coupled, Hold, LoopParams, ObjectState, Renderer, Sample, State,
};

use super::{Pins, Scene};
use crate::emulator::exit;
use crate::example::{PARAMS, coupled};
use crate::handle::MASS;

/// Ticks of the board from a sample to the beginning of its force.
pub const LEAD: u32 = 2;
/// K T^2/m of the host's wall.
const KAPPA: f32 = 0.2;

type Memory = <Coupled<f32> as palpate::Method<f32>>::Memory;

/// The host.
pub struct Host {
    scene: Scene,
    period_ticks: u32,
    renderer: Renderer<f32, Coupled<f32>>,
    state: State<f32, Memory>,
    seen: u32,
    /// A message that waits for a tick.
    held_back: Option<(u32, Message)>,
}

#[derive(Clone, Copy)]
struct Message {
    sampled: u32,
    mean: f32,
    slope: f32,
}

impl Host {
    /// Creates a host with a wall of [`KAPPA`].
    pub fn new(pins: &Pins) -> Self {
        let period_ticks = pins.host_ticks.load(Ordering::Relaxed);
        let period = period_ticks as f32 * PARAMS.period;
        let wall = Contact::wall(KAPPA * MASS / (period * period));
        let scene = pins.scene();
        let loop_params = LoopParams {
            actuation: Actuation {
                hold: if scene == Scene::HostConstants {
                    Hold::Constant
                } else {
                    Hold::Line
                },
                ..Actuation::after(LEAD as f32 * PARAMS.period)
            },
            ..LoopParams::new(period).with_force_limit(PARAMS.drive.full_force)
        };
        let renderer = Renderer::new(wall, loop_params, coupled());
        let object = ObjectState::at_rest(PARAMS.wall_at);
        let started = renderer.and_then(|renderer| Ok((renderer, renderer.start(object)?)));
        let Ok((renderer, state)) = started else {
            exit(false)
        };
        Self {
            scene,
            period_ticks,
            renderer,
            state,
            seen: 0,
            held_back: None,
        }
    }

    /// Answers a new sample of the board.
    pub fn look(&mut self, pins: &Pins) {
        let now = pins.ticks.load(Ordering::Relaxed);
        if let Some((due, message)) = self.held_back
            && now >= due
        {
            self.held_back = None;
            send(pins, message);
        }
        let sampled = pins.sampled.load(Ordering::Acquire);
        if sampled == self.seen {
            return;
        }
        self.seen = sampled;
        #[allow(clippy::cast_possible_truncation)] // a counter of 16 bits
        let count = (pins.sampled_count.load(Ordering::Relaxed) as u16).cast_signed();
        let position = f32::from(count) * PARAMS.metres_per_count;
        let output = self.renderer.step(&mut self.state, Sample::at(position));
        let message = Message {
            sampled,
            mean: output.force_on_device,
            slope: output.slope_on_device,
        };
        let time = now as f32 * PARAMS.period;
        if pins.is_late.swap(false, Ordering::Relaxed) {
            let late = 3 * self.period_ticks / 2;
            self.held_back = Some((sampled + late, message));
        } else if self.held_back.is_none()
            && (self.scene != Scene::HostLinesSilent || self.scene.host_speaks(time))
        {
            send(pins, message);
        }
    }
}

fn send(pins: &Pins, message: Message) {
    pins.line_mean
        .store(message.mean.to_bits(), Ordering::Relaxed);
    pins.line_slope
        .store(message.slope.to_bits(), Ordering::Relaxed);
    pins.line_of.store(message.sampled, Ordering::Release);
}
