//! Local model of a low-rate simulator: models that are new, lost, stale or invalid cause no step in the force and no
//! energy without a ledger entry.

mod bad_numbers;

use palpate_world::engine::local::{
    LocalContact, LocalModel, LocalParams, LocalProgress, LocalRenderer, LocalState, ModelRefusal,
};
use palpate_world::engine::{BodyNow, BodyWrench};
use palpate_world::{ContactLaw, CoupledParams, Effort, Sample, Shape, Tool, Vector, WorldLoop};

const PERIOD: f64 = 0.001;
const RADIUS: f64 = 0.005;
const UP: Vector = [0.0, 0.0, 1.0];
const MASS: f64 = 0.06;
const BALL: f64 = 0.02;

fn tool() -> Tool {
    Tool::new("tool", Shape::Sphere { radius: RADIUS })
}

fn renderer(params: LocalParams, device_mass: f64) -> LocalRenderer {
    let coupled = CoupledParams::new(vec![[device_mass; 3]]);
    LocalRenderer::new(&[tool()], params, WorldLoop::new(PERIOD), coupled).unwrap()
}

/// Returns a renderer for a device that no force moves: the force is the contact force at the prescribed position.
fn led(params: LocalParams) -> LocalRenderer {
    renderer(params, f64::INFINITY)
}

/// Returns the plane z = `height`.
fn plane(height: f64, law: ContactLaw) -> Option<LocalContact> {
    Some(LocalContact::of_tool(0, None, [0.0, 0.0, height], UP, law))
}

fn soft() -> ContactLaw {
    ContactLaw::spring(1000.0)
}

/// Returns the position with the tool's lowest point at this depth below z = 0.
fn at_depth(depth: f64) -> [Vector; 1] {
    [[0.0, 0.0, RADIUS - depth]]
}

struct Led {
    renderer: LocalRenderer,
    state: LocalState,
    last: Vector,
}

impl Led {
    fn new(params: LocalParams) -> Self {
        let renderer = led(params);
        let state = renderer.start();
        Self {
            renderer,
            state,
            last: [0.0; 3],
        }
    }

    fn model(&self, contacts: &[Option<LocalContact>]) -> LocalModel {
        let tick = self.state.progress().tick;
        self.renderer.model(tick, &[], contacts).unwrap()
    }

    /// Performs a tick at a depth. Returns the force and its change.
    fn step(&mut self, depth: f64, model: Option<&LocalModel>) -> (Vector, f64) {
        let position = at_depth(depth);
        let sample = Sample::at(&position);
        let output = self.renderer.step(&mut self.state, &sample, model);
        assert_eq!((output.fault, output.refusal), (None, None));
        let force = output.forces[0];
        let change = (0..3).map(|axis| (force[axis] - self.last[axis]).powi(2));
        let change = change.sum::<f64>().sqrt();
        self.last = force;
        (force, change)
    }

    /// Presses 2 mm deep into the plane z = 0, which was published before contact and is published again in every
    /// tick.
    fn pressed(params: LocalParams, law: ContactLaw) -> Self {
        let mut led = Self::new(params);
        for tick in 0..100 {
            let model = led.model(&[plane(0.0, law)]);
            led.step(0.002 * f64::from(tick.min(20)) / 20.0, Some(&model));
        }
        assert!((led.last[2] - 2.0).abs() < 1e-9, "{:?}", led.last);
        led
    }
}

#[test]
fn a_model_that_gets_too_old_fades_and_comes_back_without_a_step() {
    let params = LocalParams {
        stale_after: 0.05,
        fade: 0.02,
        ..LocalParams::new(0, 1)
    };
    let mut led = Led::pressed(params, soft());
    // The host hangs: its last model is from the previous tick.
    for tick in 1..200_u32 {
        let (force, change) = led.step(0.002, None);
        let age = f64::from(tick) * PERIOD;
        let left = (1.0 - (age - 0.05) / 0.02).clamp(0.0, 1.0);
        assert!((force[2] - 2.0 * left).abs() < 0.11, "{tick}: {force:?}");
        assert!(change < 0.11, "{tick}: {change}");
    }
    assert_eq!(led.last, [0.0; 3]);
    // The host is back, and finds the tool inside.
    let model = led.model(&[plane(0.0, soft())]);
    led.step(0.002, Some(&model));
    for tick in 1..=40 {
        let (force, change) = led.step(0.002, None);
        assert!(change < 0.11, "{tick}: {force:?}");
    }
    assert!((led.last[2] - 2.0).abs() < 1e-9, "{:?}", led.last);
}

#[test]
fn a_hang_is_said_with_its_age() {
    let mut led = Led::pressed(LocalParams::new(0, 1), soft());
    let sample = at_depth(0.0);
    let mut stale_from = None;
    for _ in 0..400 {
        let output = led
            .renderer
            .step(&mut led.state, &Sample::at(&sample), None);
        if output.is_stale && stale_from.is_none() {
            stale_from = output.age;
        }
    }
    let age = stale_from.unwrap();
    assert!((age - 0.2).abs() < 2.5 * PERIOD, "{age}");
    // Before any model there is no age and no contact.
    let fresh = led.renderer.start();
    assert_eq!(fresh.progress().model_tick, None);
    let output_state = &mut fresh.clone();
    let output = led.renderer.step(output_state, &Sample::at(&sample), None);
    assert_eq!(
        (output.is_stale, output.age, output.forces[0]),
        (true, None, [0.0; 3])
    );
}

#[test]
fn contacts_come_go_and_move_without_a_step() {
    let rough = soft().with_friction(0.5).with_damping(2.0);
    let turned = [0.28, 0.0, 0.96];
    let tilted = LocalContact::of_tool(0, None, [0.0; 3], turned, rough);
    let stiffer = ContactLaw::spring(1500.0);
    for (name, next, expected) in [
        ("gone", None, 0.0),
        ("lower", plane(-0.001, rough), 1.0),
        ("higher", plane(0.001, rough), 3.0),
        ("far lower", plane(-0.01, rough), 0.0),
        ("tilted", Some(tilted), 0.0),
        ("stiffer, and lower", plane(-0.001, stiffer), 1.5),
    ] {
        let mut led = Led::pressed(LocalParams::new(0, 2), rough);
        let (before, _) = led.step(0.002, None);
        // The host publishes every 20 ms.
        for _ in 0..19 {
            led.step(0.002, None);
        }
        let model = led.model(&[next, None]);
        let mut largest = 0.0_f64;
        let (_, change) = led.step(0.002, Some(&model));
        largest = largest.max(change);
        for _ in 0..30 {
            largest = largest.max(led.step(0.002, None).1);
        }
        let after = led.last;
        let whole: f64 = (0..3)
            .map(|axis| (after[axis] - before[axis]).powi(2))
            .sum();
        println!(
            "{name}: {largest:.3} N a tick, {:.3} N in all",
            whole.sqrt()
        );
        // 10 ms: a tenth of the change in each tick; more if the law changes too.
        let most = if name.starts_with("stiffer") {
            0.6
        } else {
            0.13
        };
        assert!(largest < most * whole.sqrt().max(0.5), "{name}: {largest}");
        if name != "tilted" {
            assert!((after[2] - expected).abs() < 1e-6, "{name}: {after:?}");
        } else {
            assert!(after[0] > 0.3, "{after:?}");
        }
    }
}

#[test]
fn a_contact_that_begins_inside_comes_in_and_its_energy_is_from_outside() {
    let mut led = Led::pressed(LocalParams::new(0, 2), soft());
    let contact = plane(0.0, soft());
    for _ in 0..20 {
        led.step(0.002, None);
    }
    let model = led.model(&[contact, contact]);
    let mut largest = led.step(0.002, Some(&model)).1;
    for _ in 0..20 {
        largest = largest.max(led.step(0.002, None).1);
    }
    assert!(largest < 0.25, "{largest}");
    assert!((led.last[2] - 4.0).abs() < 1e-9);
    let slots: Vec<_> = led.state.contacts().collect();
    assert_eq!(slots.len(), 2);
    for (number, (slot, contact)) in slots.into_iter().enumerate() {
        // No body: a fixed surface.
        assert_eq!((slot, contact.tool, contact.body), (number, 0, 0));
        assert!((contact.force[2] - 2.0).abs() < 1e-9 && contact.normal == UP);
    }
    let ledger = led.state.ledger();
    let second = ledger.contacts[1];
    assert!(
        (second.outside - 0.5 * 1000.0 * 0.002_f64.powi(2)).abs() < 1e-12,
        "{second:?}"
    );
    assert_eq!(second.outside, second.stored);
}

#[test]
fn models_that_do_not_fit_are_refused_by_name_and_change_nothing() {
    let mut led = Led::pressed(LocalParams::new(0, 1), soft());
    let now = led.state.progress().tick;
    let contacts = [plane(0.001, soft())];
    let of_tick = |tick| led.renderer.model(tick, &[], &contacts).unwrap();
    let other = renderer(LocalParams::new(1, 1), 1.0);
    let other = other
        .model(now, &[BodyNow::fixed([0.0; 3])], &contacts)
        .unwrap();
    let cases = [
        (of_tick(now + 10), ModelRefusal::NotYet),
        (of_tick(now - 50), ModelRefusal::OutOfOrder),
        (other, ModelRefusal::OtherRoom),
    ];
    let sample = at_depth(0.002);
    for (model, refusal) in cases {
        let output = led
            .renderer
            .step(&mut led.state, &Sample::at(&sample), Some(&model));
        assert_eq!(output.refusal, Some(refusal));
        assert!((output.forces[0][2] - 2.0).abs() < 1e-9, "{output:?}");
    }
    // For a host slower than allowed, each model is stale.
    let old = led.model(&contacts);
    for _ in 0..300 {
        led.step(0.002, None);
    }
    let output = led
        .renderer
        .step(&mut led.state, &Sample::at(&sample), Some(&old));
    assert_eq!(output.refusal, Some(ModelRefusal::TooOld));
    assert!(output.is_stale);
}

#[test]
fn what_cannot_be_published_is_said_with_its_number() {
    let renderer = led(LocalParams::new(1, 2));
    let body = BodyNow::fixed([0.0; 3]);
    let good = LocalContact::of_tool(0, Some(0), [0.0; 3], UP, soft());
    assert!(renderer.model(0, &[body], &[Some(good)]).is_ok());
    let said = |bodies: &[BodyNow], contacts: &[Option<LocalContact>]| {
        let faults = renderer.model(0, bodies, contacts).unwrap_err();
        let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
        faults.join("\n")
    };
    let nowhere = BodyNow::fixed([f64::NAN; 3]);
    let many = [Some(good); 3];
    let contact = |change: fn(&mut LocalContact)| {
        let mut contact = good;
        change(&mut contact);
        [None, Some(contact)]
    };
    let foot = LocalContact::of_body((0, [0.0; 3], -1.0), Some(0), [0.0; 3], UP, soft());
    for (faults, part) in [
        (
            said(&[], &[]),
            "there are 0 bodies, and the loop needs exactly 1",
        ),
        (
            said(&[nowhere], &[]),
            "body 0: position, orientation, motion",
        ),
        (
            said(&[body], &many),
            "there are 3 contacts, and at most 2 are allowed",
        ),
        (
            said(&[body], &contact(|it| it.normal = [0.0, 0.0, 2.0])),
            "contact 1: normal has length 2, and has to have length 1",
        ),
        (
            said(&[body], &contact(|it| it.normal = [f64::NAN; 3])),
            "contact 1: normal has length NaN",
        ),
        (
            said(&[body], &contact(|it| it.place[1] = f64::INFINITY)),
            "contact 1: place is [0.0, inf, 0.0] m",
        ),
        (
            said(&[body], &contact(|it| it.curvature = f64::NAN)),
            "curvature is NaN 1/m, and has to be a number",
        ),
        (
            said(&[body], &contact(|it| it.law.stiffness = 0.0)),
            "stiffness is 0, and has to be above 0",
        ),
        (
            said(&[body], &contact(|it| it.on = Some(1))),
            "it is on body 1, and there are 1 bodies",
        ),
        (
            said(
                &[body],
                &contact(|it| it.touching = palpate_world::engine::local::Touching::Tool(3)),
            ),
            "its tool is 3, and there are 1 tools",
        ),
        (said(&[body], &[Some(foot)]), "body 0 cannot touch itself"),
        (
            said(&[body], &[Some(foot)]),
            "radius is -1 m, and has to be at least 0",
        ),
    ] {
        assert!(faults.contains(part), "{part:?} is not in {faults:?}");
    }
    let params = LocalParams {
        stale_after: 0.0,
        settle: f64::NAN,
        ..LocalParams::new(17, 65)
    };
    let coupled = CoupledParams::new(vec![[0.1; 3]]);
    let made = LocalRenderer::new(&[tool()], params, WorldLoop::new(PERIOD), coupled);
    let faults: Vec<_> = made.unwrap_err().iter().map(ToString::to_string).collect();
    let faults = faults.join("\n");
    for part in [
        "bodies is 17, and at most 16 are allowed",
        "contacts is 65, and has to be 1 to 64",
        "stale_after is 0 s, and has to be 0.001 to 1 s",
        "settle is NaN s, and has to be above 0",
    ] {
        assert!(faults.contains(part), "{part:?} is not in {faults:?}");
    }
}

/// A ball of a host, moved only by its weight and the tool.
struct Host {
    now: BodyNow,
    taken: LocalProgress,
}

impl Host {
    fn new(taken: LocalProgress) -> Self {
        let mut now = BodyNow::fixed([0.002, -0.001, 0.035]);
        now.acceleration = [0.0, 0.0, -9.81];
        let moment = 0.4 * MASS * BALL * BALL;
        for axis in 0..3 {
            now.mobility[axis][axis] = 1.0 / MASS;
            now.mobility[axis + 3][axis + 3] = 1.0 / moment;
        }
        Self { now, taken }
    }

    fn step(&mut self, progress: &LocalProgress) -> BodyWrench {
        let h = progress.time_since(&self.taken);
        let wrench = progress.wrench_since(&self.taken, 0);
        for axis in 0..3 {
            let a = self.now.acceleration[axis] + wrench.force[axis] / MASS;
            self.now.position[axis] += h * (self.now.velocity[axis] + 0.5 * h * a);
            self.now.velocity[axis] += h * a;
        }
        self.taken = progress.clone();
        wrench
    }

    fn contact(&self, centre: Vector) -> Option<LocalContact> {
        let from = [0, 1, 2].map(|axis| centre[axis] - self.now.position[axis]);
        let far = from.iter().map(|x| x * x).sum::<f64>().sqrt();
        let normal = from.map(|x| x / far);
        let gap = far - BALL - RADIUS;
        let law = ContactLaw::spring(400.0)
            .with_friction(0.4)
            .with_damping(0.5);
        let contact = LocalContact::at_gap((0, centre, RADIUS), Some(0), gap, normal, law);
        Some(contact.curved(1.0 / BALL))
    }
}

/// The host's ball and the device receive opposite impulses, and every ledger closes, with a host at 50 Hz that is
/// late by half a step.
#[test]
fn body_and_device_receive_opposite_impulses_and_ledgers_close() {
    const DEVICE: f64 = 0.15;
    let renderer = renderer(LocalParams::new(1, 1), DEVICE);
    let mut state = renderer.start();
    let mut host = Host::new(state.progress().clone());
    let (mut position, mut velocity, mut held) = ([0.0; 3], [0.0; 3], 0.0);
    let publish = |host: &Host| {
        let contact = host.contact(host.taken.positions[0]);
        renderer
            .model(host.taken.tick, &[host.now], &[contact])
            .unwrap()
    };
    let mut coming = Some((0, publish(&host)));
    let (mut given, mut effort) = (0.0, Effort::default());
    for sample in 0..260 {
        if sample > 0 && sample % 20 == 0 {
            let progress = state.progress().clone();
            let h = progress.time_since(&host.taken);
            given += h * host.step(&progress).force[2];
            coming = Some((sample + 10, publish(&host)));
        }
        let due = coming.take_if(|(due, _)| *due == sample);
        let model = due.map(|(_, model)| model);
        let positions = [position];
        let output = renderer.step(&mut state, &Sample::at(&positions), model.as_ref());
        assert_eq!((output.fault, output.refusal), (None, None));
        effort.sub_steps = effort.sub_steps.max(output.effort.sub_steps);
        let force = output.forces[0];
        held += PERIOD * force[2];
        for axis in 0..3 {
            let hand = if axis == 2 { 0.8 } else { 0.0 };
            let a = (hand + force[axis]) / DEVICE;
            position[axis] += PERIOD * (velocity[axis] + 0.5 * PERIOD * a);
            velocity[axis] += PERIOD * a;
        }
        let ledger = state.ledger();
        let [entry] = ledger.contacts else {
            panic!("one contact");
        };
        let left =
            entry.observed + entry.outside - entry.work - entry.dissipated + entry.step_error;
        assert!((entry.stored - left).abs() < 1e-12, "{sample}: {entry:?}");
        // All energy known to the tick: given to hand and host, stored, and dissipated.
        let work_on_copy = entry.work - entry.work_on_proxy;
        let port = ledger.slow_ports[0];
        let ports = ledger.devices[0].port_work + port.host_work;
        let balance = ports + entry.stored + entry.dissipated + work_on_copy - port.work;
        assert!(
            (ledger.created() - balance).abs() < 1e-12,
            "{sample}: {balance}"
        );
    }
    // Remaining impulse on the ball since the host's last step.
    let h = state.progress().time_since(&host.taken);
    given += h * state.progress().wrench_since(&host.taken, 0).force[2];
    println!("{given} N s to the ball, {held} N s to the device, {effort:?}");
    assert!(given > 0.05, "{given}");
    assert!((held + given).abs() < 0.02 * given, "{held} {given}");
    let ledger = state.ledger();
    println!("{ledger:?}: {} J", ledger.created());
    let turned_over = ledger.slow_ports[0].work.abs();
    // A host's ball pushed by the mean force takes less energy than the copy: energy is lost, not generated.
    assert!(turned_over > 1e-3, "{ledger:?}");
    assert!(ledger.created() < 0.01 * turned_over, "{ledger:?}");
}

/// A host that displaces its body does not kick the hand.
#[test]
fn a_body_that_the_host_puts_elsewhere_makes_no_step() {
    let renderer = renderer(LocalParams::new(1, 1), f64::INFINITY);
    let mut state = renderer.start();
    let mut body = BodyNow::fixed([0.0; 3]);
    let contact = |height: f64| {
        Some(LocalContact::of_tool(
            0,
            Some(0),
            [0.0, 0.0, height],
            UP,
            soft(),
        ))
    };
    let mut last = 0.0;
    let mut largest = 0.0_f64;
    for tick in 0..300 {
        let position = at_depth(0.002 * f64::from(tick.min(50)) / 50.0);
        let model = (tick % 20 == 0).then(|| {
            if tick == 200 {
                body.position[2] -= 0.0015;
            }
            let now = state.progress().tick;
            renderer
                .model(now, &[body], &[contact(body.position[2])])
                .unwrap()
        });
        let output = renderer.step(&mut state, &Sample::at(&position), model.as_ref());
        let force = output.forces[0][2];
        if tick >= 100 {
            largest = largest.max((force - last).abs());
        }
        last = force;
    }
    assert!((last - 0.5).abs() < 1e-9, "{last}");
    let (slot, touched) = state.contacts().next().unwrap();
    assert_eq!((slot, touched.tool, touched.body), (0, 0, 0));
    assert!(largest < 0.16, "{largest}");
    let entry = state.ledger().contacts[0];
    let lost = 0.5 * 1000.0 * (0.002_f64.powi(2) - 0.0005_f64.powi(2));
    assert!((entry.outside + lost).abs() < 1e-9, "{entry:?}");
}
