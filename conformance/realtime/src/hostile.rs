//! A hostile device, clock and user, with all behaviour that the types allow.

use std::hint::black_box;
use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, tap};
use palpate_scene::method::MethodName;

use crate::situations::{Watch, scene};

const LOOPS: u64 = 600;
const TICKS: u32 = 100;

/// A device with arbitrary readings that checks the limit of the commanded force.
pub struct Hostile {
    clock: SteppedClock,
    capabilities: Capabilities,
    random: fastrand::Rng,
    largest_force: f64,
    /// The last commanded wrench.
    pub asked: Wrench,
}

impl Hostile {
    /// Creates a device with this many axes and numbers of `random`, which checks that commands do not exceed
    /// `largest_force` [N].
    pub fn new(
        clock: &SteppedClock,
        axes: usize,
        random: fastrand::Rng,
        largest_force: f64,
    ) -> Self {
        Self {
            clock: clock.clone(),
            capabilities: Capabilities::unknown("hostile", axes),
            random,
            largest_force,
            asked: Wrench::NONE,
        }
    }
}

/// Returns a number mostly near `scale`, and sometimes any number, or NaN.
fn number(random: &mut fastrand::Rng, scale: f64) -> f64 {
    match random.u8(..20) {
        0 => f64::from_bits(random.u64(..)),
        1 => [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE, -0.0][random.usize(..5)],
        _ => scale * (2.0 * random.f64() - 1.0),
    }
}

fn error(random: &mut fastrand::Rng) -> DeviceError {
    use DeviceErrorKind::{Disconnected, NothingNew, Refused};
    let kind = [Disconnected, NothingNew, NothingNew, Refused][random.usize(..4)];
    DeviceError::new(kind, "for no reason")
}

impl Device for Hostile {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let random = &mut self.random;
        if random.u8(..10) == 0 {
            return Err(error(random));
        }
        if random.u8(..10) == 0 {
            // The device is slow.
            self.clock
                .advance(Duration::from_nanos(random.u64(..5_000_000)));
        }
        let now = self.clock.now();
        let time = match random.u8(..100) {
            0 => Duration::from_nanos(random.u64(..)),
            1 => now + Duration::from_nanos(random.u64(..10_000_000)),
            2..10 => now.saturating_sub(Duration::from_nanos(random.u64(..10_000_000))),
            10 if random.u8(..20) == 0 => Duration::MAX,
            _ => now,
        };
        let position = [5e-3, 5e-3, 5e-3].map(|scale| number(random, scale));
        Ok(Pose::at(position, time))
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.asked = wrench;
        let force = wrench.force;
        let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(size <= self.largest_force * (1.0 + 1e-12), "{force:?} N");
        let random = &mut self.random;
        match random.u8(..10) {
            0 => Err(error(random)),
            1 => Ok([1.0, 1.0, 1.0].map(|scale| number(random, scale)).into()),
            _ => Ok(wrench),
        }
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Nobody;
        impl ZeroWriter for Nobody {
            fn write_zero(&mut self) {}
        }
        Some(Box::new(Nobody))
    }
}

/// Loops of every method with random limits, faults, changes and delays, from fixed seeds.
pub fn anything(watch: &mut Watch) {
    let scenes = ["wall.toml", "experiment1.toml", "coupled/wall-1000.toml"].map(scene);
    let mut stopped = 0;
    for seed in 0..LOOPS {
        let mut random = fastrand::Rng::with_seed(seed);
        let scene = &scenes[random.usize(..3)];
        let methods = MethodName::ALL;
        let rendering = |random: &mut fastrand::Rng| {
            let method = methods[random.usize(..methods.len())];
            let mut rendering = scene.rendering(method).unwrap();
            rendering.loop_params.period = 0.001;
            rendering.contact.stiffness *= 10_f64.powf(6.0 * random.f64() - 3.0);
            rendering
        };
        let limits = SafetyParams {
            largest_force: 10_f64.powf(4.0 * random.f64() - 2.0),
            slew_limit: [f64::INFINITY, 100.0, 1e-300][random.usize(..3)],
            workspace: random.bool().then_some([[-4e-3; 3], [4e-3; 3]]),
            largest_speed: [f64::INFINITY, 5.0][random.usize(..2)],
            stale_after: random.u32(1..=2),
            soft_start: [0.0, 0.2][random.usize(..2)],
            ..SafetyParams::default()
        };
        let clock = SteppedClock::new();
        let axes = random.usize(1..=3);
        let device = Hostile::new(&clock, axes, random.fork(), limits.largest_force);
        let first = rendering(&mut random);
        let (tap, mut listener) = tap(10);
        let mut control = ControlLoop::new(device, clock.clone(), first, limits)
            .unwrap()
            .tapped(tap);
        let mut parameters = control.parameters().unwrap();
        let mut supervisor = control.supervisor().unwrap();
        for _ in 0..TICKS {
            match random.u8(..20) {
                0 => drop(parameters.change(rendering(&mut random))),
                1 => control.rearm().store(true, Ordering::Release),
                2 => clock.advance(Duration::from_nanos(random.u64(..20_000_000))),
                3 => clock.oversleep_once(Duration::from_nanos(random.u64(..u64::MAX >> 20))),
                4 => drop(supervisor.look(clock.now())),
                5 => drop(listener.by_ref().count()),
                _ => {}
            }
            watch(&mut || {
                black_box(control.tick());
            });
            stopped += u32::from(control.safety_stop().is_some());
        }
    }
    assert!(stopped > 1000, "{stopped}");
}
