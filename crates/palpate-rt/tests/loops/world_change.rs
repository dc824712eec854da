//! Replacement of worlds while the loop runs, on a manually stepped clock.

use palpate_device::Vector;
use palpate_device::clock::SteppedClock;
use palpate_record::recording::Row;
use palpate_rt::{
    ChangingWorld, ControlLoop, Message, RenderedWorld, WorldChangeError, WorldFrame, Worlds,
    changing_world, tap,
};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::device::SpatialDevice;
use palpate_world::Motion;

use crate::wide;

type Loop = ControlLoop<SpatialDevice<SteppedClock>, SteppedClock, ChangingWorld>;

/// A ball that flies above a floor, and a device that a hand presses into the floor.
fn scene() -> WorldScene {
    let text = r#"
format = 2
title = "A ball above a floor"
loop = { period_s = 0.002 }
[[device]]
name = "tool"
mass_kg = 0.25
position_m = [0.0, 0.0, 0.009]
tool = { sphere = { radius_m = 0.01 } }
hand.stiffness_n_per_m = 200.0
hand.damping_n_s_per_m = 10.0
hand.rest_m = [0.0, 0.0, 0.004]
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }
[[body]]
name = "ball"
mass_kg = 0.1
position_m = [0.3, 0.0, 0.5]
velocity_m_per_s = [0.0, 0.1, 0.0]
angular_velocity_rad_per_s = [3.0, 0.0, 1.0]
force_n = [0.0, 0.0, 0.02]
shape = { box = { size_m = [0.02, 0.04, 0.06] } }
[[contact]]
between = ["tool", "floor"]
stiffness_n_per_m = 500.0
[measure]
duration_s = 1.0
[render]
method = "basic"
"#;
    WorldFile::parse("scene", text).unwrap().scene
}

fn rendered(scene: &WorldScene, method: &'static str) -> RenderedWorld {
    let renderer = scene.renderer(method).unwrap();
    RenderedWorld::new(&scene.world, renderer, method, WorldFrame::the_same()).unwrap()
}

fn changing(scene: &WorldScene, method: &'static str) -> (Worlds, Loop) {
    let clock = SteppedClock::new();
    let device = SpatialDevice::new(scene, 0, clock.clone()).unwrap();
    let (worlds, world) = changing_world(scene.world.clone(), rendered(scene, method));
    let control = ControlLoop::of_changing_world(device, clock, world, wide()).unwrap();
    (worlds, control)
}

fn force(row: &Row) -> f64 {
    row.tick.commanded_force[2]
}

fn ball(control: &Loop) -> (Vector, Vector, Vector) {
    let ball = control.rendered().world().state().bodies()[1];
    (ball.position, ball.velocity, ball.angular_velocity)
}

#[test]
fn the_same_world_again_changes_nothing_but_the_number() {
    for (method, delay) in [("basic", 0.0), ("coupled", 0.0), ("coupled", 0.003)] {
        let mut scene = scene();
        scene.timing.delay = palpate_scene::Delay::Seconds(delay);
        let (mut worlds, mut control) = changing(&scene, method);
        let (_, mut alone) = changing(&scene, method);
        let mut most = 0.0_f64;
        for tick in 0..300 {
            if tick % 7 == 3 {
                let number = worlds.change(scene.world.clone(), rendered(&scene, method));
                assert_eq!(number, Ok(tick / 7 + 1));
            }
            let (row, same) = (control.tick(), alone.tick());
            assert_eq!(row.tick.generation, worlds.generation());
            let apart = (force(&row) - force(&same)).abs();
            assert!(apart < 1e-9, "{method}, tick {tick}: {apart} N");
            most = most.max(force(&row));
            let (one, other) = (ball(&control), ball(&alone));
            for (one, other) in [(one.0, other.0), (one.1, other.1), (one.2, other.2)] {
                assert_near(one, other);
            }
            let created = [&row, &same].map(|row| row.tick.created_energy);
            assert!((created[0] - created[1]).abs() < 1e-12, "{created:?} J");
        }
        assert!(most > 0.5, "{most} N");
    }
}

#[track_caller]
fn assert_near(one: Vector, other: Vector) {
    for (one, other) in one.iter().zip(other) {
        assert!((one - other).abs() < 1e-10, "{one} and {other}");
    }
}

#[test]
fn stiffness_change_ramps_in_tenth_of_second_and_is_reported() {
    let scene = scene();
    let (mut worlds, control) = changing(&scene, "basic");
    let (tap, mut listener) = tap(1000);
    let mut control = control.tapped(tap);
    for _ in 0..100 {
        control.tick();
    }
    let mut stiffer = scene.clone();
    stiffer.world.contacts[0].law.stiffness = 1500.0;
    worlds
        .change(stiffer.world.clone(), rendered(&stiffer, "basic"))
        .unwrap();
    for tick in 0..80 {
        let row = control.tick();
        let depth = control.rendered().world().state().contacts()[0].penetration;
        if tick < 3 {
            assert!((force(&row) - 500.0 * depth).abs() < 1e-9, "tick {tick}");
        } else if tick > 52 {
            assert!((force(&row) - 1500.0 * depth).abs() < 1e-9, "tick {tick}");
        }
        let own = control.rendered().world().state().contacts()[0].force[2];
        assert!(
            (own - 1500.0 * depth).abs() < 1e-9,
            "the contact is the new one"
        );
        assert!(force(&row) > 0.0 && force(&row) < 1500.0 * depth + 1e-9);
    }
    let notes: Vec<_> = listener
        .by_ref()
        .filter_map(|messages| match messages {
            Message::Note(noted) => Some(noted.event()),
            Message::Tick(..) => None,
        })
        .collect();
    let [event] = &notes[..] else {
        panic!("{notes:?}");
    };
    assert_eq!((event.sequence, event.kind.as_str()), (100, "parameters"));
    let words = "parameters number 1 from here on: another world, rendered by basic";
    assert_eq!(event.text, words);
}

#[test]
fn a_body_keeps_its_velocities_under_another_mass_and_one_described_elsewhere_is_put_there() {
    let scene = scene();
    for method in ["basic", "coupled"] {
        let (mut worlds, mut control) = changing(&scene, method);
        let (_, mut alone) = changing(&scene, method);
        for _ in 0..50 {
            control.tick();
            alone.tick();
        }
        let mut other = scene.clone();
        let Motion::Free(free) = &mut other.world.bodies[1].motion else {
            panic!("the ball is free");
        };
        free.mass = 0.7;
        free.force = [0.0; 3];
        worlds
            .change(other.world.clone(), rendered(&other, method))
            .unwrap();
        let before = ball(&control);
        control.tick();
        alone.tick();
        let (now, then) = (ball(&control), ball(&alone));
        // No force acts on it any more. It rotates like a body of the same shape; the mass does not matter.
        assert_near(
            now.0,
            [0, 1, 2].map(|axis| before.0[axis] + 0.002 * before.1[axis]),
        );
        assert_near(now.1, before.1);
        assert_near(now.2, then.2);

        // The next world replaces this one before a tick takes it: the ball is at the position that both describe.
        other.world.bodies[1].position = [0.1, 0.2, 0.3];
        for stiffness in [700.0, 800.0] {
            other.world.contacts[0].law.stiffness = stiffness;
            let world = rendered(&other, method);
            worlds.change(other.world.clone(), world).unwrap();
        }
        control.tick();
        // One period of 2 ms from there.
        assert_near(ball(&control).0, [0.1, 0.2 + 0.002 * 0.1, 0.3]);
        assert_eq!(control.rendered().world().state().tools().len(), 1);
    }
}

/// Another method starts with a device at rest; bodies and energy ledger continue, and the force changes over
/// gradually.
#[test]
fn another_method_passes_over_without_a_step() {
    let scene = scene();
    for (one, other) in [("basic", "coupled"), ("coupled", "basic")] {
        let (mut worlds, mut control) = changing(&scene, one);
        let (_, mut alone) = changing(&scene, one);
        let (mut before, mut created) = (0.0, 0.0);
        for tick in 0..400 {
            if tick == 250 {
                let world = rendered(&scene, other);
                worlds.change(scene.world.clone(), world).unwrap();
            }
            let row = control.tick();
            alone.tick();
            let now = force(&row);
            if tick >= 250 {
                let step = (now - before).abs();
                assert!(
                    step < 0.02 * before,
                    "{one} to {other}, {tick}: {step} N of {before}"
                );
                let more = row.tick.created_energy - created;
                assert!(
                    more.abs() < 1e-6,
                    "{one} to {other}, {tick}: {more} J at once"
                );
            }
            (before, created) = (now, row.tick.created_energy);
            assert_near(ball(&control).0, ball(&alone).0);
        }
        assert!(before > 0.5, "{before} N");
    }
}

#[test]
fn what_cannot_take_its_place_is_refused() {
    let scene = scene();
    let (mut worlds, _control) = changing(&scene, "basic");
    let mut refused = |change: &dyn Fn(&mut WorldScene)| {
        let mut other = scene.clone();
        change(&mut other);
        worlds
            .change(other.world.clone(), rendered(&other, "basic"))
            .unwrap_err()
    };
    let period = refused(&|other| other.timing.period = 0.004);
    let (now, then) = (0.002, 0.004);
    assert_eq!(period, WorldChangeError::Period { now, then });
    let names = refused(&|other| other.world.bodies[1].name = "cube".into());
    assert_eq!(
        names.to_string(),
        "the bodies are floor, cube, but must stay floor, ball while the loop runs: ticks refer to their indices"
    );
    assert!(matches!(
        refused(&|other| other.world.contacts.clear()),
        WorldChangeError::Names {
            what: "the contact pairs",
            ..
        }
    ));
    for _ in 0..8 {
        let world = rendered(&scene, "basic");
        worlds.change(scene.world.clone(), world).unwrap();
    }
    let world = rendered(&scene, "basic");
    assert_eq!(
        worlds.change(scene.world.clone(), world),
        Err(WorldChangeError::Busy)
    );
    assert_eq!(worlds.generation(), 8);
}
