//! Models of a low-rate simulator in a loop on a manually stepped clock.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use palpate_device::clock::SteppedClock;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, LocalWorld, LowRateSimulator, SetupError, WorldFrame, local_world};
use palpate_scene::world::WorldFile;
use palpate_study::sim::device::SpatialDevice;
use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer, ModelRefusal};
use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, WorldLoop};

use crate::wide;

type Loop = ControlLoop<SpatialDevice<SteppedClock>, SteppedClock, LocalWorld>;

/// A hand that presses a device through the simulator's floor.
const DEVICE: &str = r#"
format = 2
loop = { period_s = 0.001 }
[[device]]
name = "tool"
mass_kg = 0.25
position_m = [0.0, 0.0, 0.011]
tool = { sphere = { radius_m = 0.01 } }
hand.stiffness_n_per_m = 200.0
hand.damping_n_s_per_m = 10.0
hand.rest_m = [0.0, 0.0, 0.004]
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0] } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 1000.0
"#;

fn renderer(tools: usize) -> LocalRenderer {
    let tool = |number| Tool::new(format!("{number}"), Shape::Sphere { radius: 0.01 });
    let tools: Vec<_> = (0..tools).map(tool).collect();
    let coupled = CoupledParams::new(vec![[0.25; 3]; tools.len()]);
    let params = LocalParams {
        stale_after: 0.1,
        ..LocalParams::new(0, 2)
    };
    LocalRenderer::new(&tools, params, WorldLoop::new(0.001), coupled).unwrap()
}

fn pressed(limits: SafetyParams) -> (LowRateSimulator, Loop) {
    let scene = WorldFile::parse("device", DEVICE).unwrap().scene;
    let clock = SteppedClock::new();
    let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
    let (host, world) = local_world(renderer(1), WorldFrame::the_same()).unwrap();
    let control = ControlLoop::of_local_world(device, clock, world, limits).unwrap();
    (host, control)
}

/// Contact found by the simulator: the floor z = 0 of 1000 N/m.
fn floor() -> Option<LocalContact> {
    let law = ContactLaw::spring(1000.0);
    Some(LocalContact::of_tool(
        0,
        None,
        [0.0; 3],
        [0.0, 0.0, 1.0],
        law,
    ))
}

fn publish(host: &mut LowRateSimulator) {
    let tick = host.progress().tick;
    host.publish(tick, &[], &[floor()]).unwrap();
}

fn force(control: &mut Loop) -> f64 {
    control.tick().tick.commanded_force[2]
}

/// Force at rest [N]: the hand's spring of 200 N/m and the floor's of 1000 N/m share the 6 mm between them.
const RESTING: f64 = 1.0;

#[test]
fn force_follows_published_model_and_fades_when_simulator_hangs() {
    let (mut host, mut control) = pressed(wide());
    publish(&mut host);
    let mut last = 0.0;
    for tick in 0..2000 {
        if tick % 20 == 0 {
            publish(&mut host);
        }
        last = force(&mut control);
    }
    assert!((last - RESTING).abs() < 0.01, "{last}");
    let row = control.tick();
    assert_eq!(row.tick.contacts, 1);
    let contact = control.tick().contact;
    assert!((contact.penetration - 0.001).abs() < 1e-5, "{contact:?}");
    assert!(!host.progress().is_stale);
    assert!(
        row.tick.created_energy < 1e-4,
        "{}",
        row.tick.created_energy
    );
    // The simulator hangs: its model is too old after 0.1 s, and the force fades in another 0.1 s.
    let mut largest = 0.0_f64;
    for _ in 0..300 {
        let now = force(&mut control);
        largest = largest.max((now - last).abs());
        last = now;
    }
    assert_eq!(last, 0.0);
    assert!(largest < 0.05, "{largest}");
    assert!(host.progress().is_stale);
    // The simulator continues, and so does the contact.
    for tick in 0..2000 {
        if tick % 20 == 0 {
            publish(&mut host);
        }
        last = force(&mut control);
    }
    assert!((last - RESTING).abs() < 0.01, "{last}");
}

#[test]
fn refused_model_is_reported_to_the_host() {
    let (mut host, mut control) = pressed(wide());
    publish(&mut host);
    control.tick();
    assert_eq!(
        (host.progress().refusal, host.progress().model_tick),
        (None, Some(0))
    );
    host.publish(50, &[], &[floor()]).unwrap();
    control.tick();
    assert_eq!(host.progress().refusal, Some(ModelRefusal::NotYet));
    // The refusal is reported until the next model.
    control.tick();
    assert_eq!(host.progress().refusal, Some(ModelRefusal::NotYet));
    publish(&mut host);
    control.tick();
    assert_eq!(
        (host.progress().refusal, host.progress().model_tick),
        (None, Some(3))
    );
    // A model that cannot be published leaves the loop unchanged.
    let three = [floor(); 3];
    let faults = host.publish(4, &[], &three).unwrap_err();
    assert!(
        faults.first().to_string().contains("at most 2 are allowed"),
        "{faults:?}"
    );
    let Err(error) = local_world(renderer(2), WorldFrame::the_same()) else {
        panic!("two devices");
    };
    assert_eq!(error, SetupError::Devices { world: 2, given: 1 });
}

/// Ends the simulator's thread, also after a failed check of the loop, because the test joins the thread.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[test]
fn a_host_on_a_thread_of_its_own_is_heard_and_hears() {
    let (mut host, mut control) = pressed(wide());
    publish(&mut host);
    let is_over = AtomicBool::new(false);
    let heard = AtomicU64::new(0);
    std::thread::scope(|threads| {
        threads.spawn(|| {
            let mut last = None;
            while !is_over.load(Ordering::Acquire) {
                let tick = host.progress().tick;
                assert!(last <= Some(tick), "{last:?} {tick}");
                heard.fetch_add(u64::from(last < Some(tick)), Ordering::AcqRel);
                last = Some(tick);
                publish(&mut host);
                #[allow(clippy::disallowed_methods, reason = "the host, not the loop")]
                std::thread::yield_now();
            }
        });
        let _ends = Ends(&is_over);
        let (mut taken, mut newest) = (0, None);
        while taken < 100 || heard.load(Ordering::Acquire) < 100 {
            let now = force(&mut control);
            assert!(now.is_finite());
            let progress = control.rendered().state().progress();
            // A simulator that the machine does not schedule for 100 ticks is too late.
            let refused = progress.refusal.filter(|it| *it != ModelRefusal::TooOld);
            assert_eq!(refused, None);
            taken += u32::from(progress.model_tick != newest);
            newest = progress.model_tick;
        }
    });
}
