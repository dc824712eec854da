//! Changes of a running world: unchanged elements continue undisturbed, and the ledger has the external energy.

use palpate_world::{
    BasicParams, Body, BodyState, Contact, ContactLaw, ContactState, CoupledParams, Free,
    GodObjectParams, HfcrParams, IDENTITY, Joint, JointKind, JointLaw, Mode, Motion, Party, Sample,
    Shape, Side, Tool, Vector, VirtualCouplingParams, World, WorldLoop, WorldMethod, WorldPart,
    WorldRenderer, WorldState,
};

use crate::common::{FAR, ball, plane, world};

const MASS: f64 = 0.1;
const HALF: f64 = 0.02;

fn block(name: &str) -> Body {
    let free = Free::of_mass(MASS).pulled_by([0.0, 0.0, -9.81 * MASS]);
    let half_extents = [HALF; 3];
    Body::new(name, Shape::Box { half_extents }, Motion::Free(free))
}

/// Returns a block at rest on a floor, with friction.
pub fn on_floor() -> World {
    let law = ContactLaw::spring(2000.0)
        .with_friction(0.3)
        .with_damping(2.0);
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0]),
        block("block").at([0.0, 0.0, HALF]),
    ];
    world(0.005, bodies, law)
}

pub fn methods() -> [WorldMethod; 5] {
    [
        BasicParams::default().into(),
        VirtualCouplingParams {
            stiffness: vec![2000.0],
            damping: vec![2.0],
            mass: vec![0.05],
            ..VirtualCouplingParams::default()
        }
        .into(),
        GodObjectParams {
            stiffness: vec![2000.0],
            damping: vec![1.0],
        }
        .into(),
        HfcrParams::default().into(),
        CoupledParams::new(vec![[0.1; 3]]).into(),
    ]
}

/// Returns the tool position at a sample; the tool pushes the block from the side.
pub fn pushed(sample: usize) -> [Vector; 1] {
    let way = 1e-3 * f64::from(u16::try_from(sample).unwrap_or(u16::MAX)) * 0.05;
    [[-HALF - 0.006 + way, 0.003, HALF]]
}

pub fn start(world: &World, method: WorldMethod) -> (WorldRenderer, WorldState) {
    let renderer = WorldRenderer::new(world, WorldLoop::new(1e-3), method).expect("renderable");
    let state = renderer.start();
    (renderer, state)
}

/// Asserts that each ledger is balanced over the whole run.
pub fn assert_balanced(state: &WorldState, kinetic_at_start: f64) {
    let ledger = state.ledger();
    let mut sum = -kinetic_at_start;
    for entry in ledger.bodies.iter().chain([&ledger.gone.bodies]) {
        sum += entry.kinetic + entry.potential - entry.work - entry.outside - entry.step_error;
    }
    assert!(sum.abs() < 1e-12, "bodies: {sum}");
    for entry in ledger.contacts.iter().chain([&ledger.gone.contacts]) {
        let from = entry.observed + entry.outside + entry.handed + entry.step_error;
        let off = entry.stored - from + entry.work + entry.dissipated;
        assert!(off.abs() < 1e-12, "{entry:?}: {off}");
    }
    for entry in ledger.joints.iter().chain([&ledger.gone.joints]) {
        let off = entry.stored - entry.outside - entry.step_error + entry.work + entry.dissipated;
        assert!(off.abs() < 1e-12, "{entry:?}: {off}");
    }
}

#[test]
fn a_world_that_is_changed_to_itself_goes_on_as_it_would_have() {
    for method in methods() {
        let world = on_floor();
        let (mut renderer, mut state) = start(&world, method.clone());
        let (other, mut beside) = start(&world, method.clone());
        let mut most: f64 = 0.0;
        for sample in 0..600 {
            if sample % 50 == 25 {
                (renderer, state) = renderer.changed(&state, &world).expect("the same world");
            }
            let positions = pushed(sample);
            let force = renderer.step(&mut state, &Sample::at(&positions)).forces[0];
            let expected = other.step(&mut beside, &Sample::at(&positions)).forces[0];
            for (force, expected) in force.iter().zip(expected) {
                most = most.max(force.abs());
                assert!(
                    (force - expected).abs() < 1e-9,
                    "{}: {sample}",
                    method.name()
                );
            }
        }
        assert!(most > 0.1, "{}: the tool pushes", method.name());
        assert_balanced(&state, 0.0);
        let [moved, expected] = [&state, &beside].map(|state| state.bodies()[1].position[0]);
        assert!((moved - expected).abs() < 1e-9 && moved > 1e-3, "{moved}");
        let created = [&state, &beside].map(|state| state.ledger().created());
        assert!((created[0] - created[1]).abs() < 1e-9, "{created:?}");
    }
}

#[test]
fn a_body_that_comes_and_goes_leaves_the_others_alone() {
    for method in methods() {
        let world = on_floor();
        let (mut renderer, mut state) = start(&world, method.clone());
        let (other, mut beside) = start(&world, method.clone());
        let mut more = world.clone();
        // Inserted before the block, so that all indices change, and with its own contact.
        let flying = Free::of_mass(0.02).moving([0.0, 0.5, 0.0]);
        more.bodies
            .insert(0, ball("guest", 0.01, flying).at([0.0, 1.0, 1.0]));
        for sample in 0..600 {
            if sample == 200 {
                let created = state.ledger().created();
                (renderer, state) = renderer.changed(&state, &more).expect("one more");
                assert!((state.ledger().created() - created).abs() < 1e-15);
                let guest = state.bodies()[0];
                assert_eq!(
                    (guest.position, guest.velocity),
                    ([0.0, 1.0, 1.0], [0.0, 0.5, 0.0])
                );
                let entry = state.ledger().bodies[0];
                assert!(
                    (entry.outside - 0.5 * 0.02 * 0.25).abs() < 1e-15,
                    "{entry:?}"
                );
            }
            if sample == 400 {
                let guest = state.bodies()[0];
                assert!((guest.position[1] - 1.1).abs() < 1e-9, "{guest:?}");
                (renderer, state) = renderer.changed(&state, &world).expect("as before");
                let gone = state.ledger().gone;
                assert!(
                    gone.bodies.outside.abs() < 1e-15,
                    "it took along what it brought"
                );
            }
            let positions = pushed(sample);
            let force = renderer.step(&mut state, &Sample::at(&positions)).forces[0];
            let expected = other.step(&mut beside, &Sample::at(&positions)).forces[0];
            for (force, expected) in force.iter().zip(expected) {
                assert!(
                    (force - expected).abs() < 1e-9,
                    "{}: {sample}",
                    method.name()
                );
            }
        }
        assert_balanced(&state, 0.0);
    }
}

#[test]
fn contact_stiffness_increase_is_recorded_as_outside_energy() {
    let world = on_floor();
    let mut stiffer = world.clone();
    stiffer.contacts.push(Contact {
        between: [Party::Named("tool".into()), Party::Named("block".into())],
        law: ContactLaw::spring(4000.0),
    });
    for method in methods() {
        let (mut renderer, mut state) = start(&world, method.clone());
        for sample in 0..400 {
            renderer.step(&mut state, &Sample::at(&pushed(sample)));
        }
        let stored = |state: &WorldState| -> f64 {
            state
                .ledger()
                .contacts
                .iter()
                .map(|entry| entry.stored)
                .sum()
        };
        let before = (stored(&state), state.ledger().created());
        let dissipated = |state: &WorldState| -> f64 {
            let ledger = state.ledger();
            ledger.contacts.iter().map(|entry| entry.dissipated).sum()
        };
        let lost = dissipated(&state);
        (renderer, state) = renderer.changed(&state, &stiffer).expect("renderable");
        let outside: f64 = state
            .ledger()
            .contacts
            .iter()
            .map(|entry| entry.outside)
            .sum();
        let lost = dissipated(&state) - lost;
        assert!((stored(&state) + lost - before.0 - outside).abs() < 1e-15);
        assert_eq!(
            state.ledger().created(),
            before.1,
            "nothing was held meanwhile"
        );
        if method.name() == "basic" || method.name() == "coupled" {
            assert!(outside > 1e-6, "{}: {outside}", method.name());
        }
        for sample in 400..600 {
            let output = renderer.step(&mut state, &Sample::at(&pushed(sample)));
            assert_eq!(output.fault, None);
        }
        assert_balanced(&state, 0.0);
    }
}

/// Returns a block on a hinge above it.
pub fn pendulum() -> World {
    // The spring makes the angle observable.
    let law = JointLaw {
        spring: 0.02,
        ..JointLaw::new(2e4, 0.03)
    };
    World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies: vec![block("block").at([0.0, 0.0, -0.05])],
        fields: Vec::new(),
        joints: vec![Joint {
            body: "block".into(),
            against: None,
            kind: JointKind::Hinge,
            point: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            law,
        }],
        contacts: Vec::new(),
    }
}

#[test]
fn a_joint_goes_on_at_its_coordinate_and_a_new_one_begins_as_the_bodies_stand() {
    let mut world = pendulum();
    if let Motion::Free(free) = &mut world.bodies[0].motion {
        free.velocity = [0.3, 0.0, 0.0];
        free.angular_velocity = [0.0, -6.0, 0.0];
    }
    let kinetic = {
        let (_, state) = start(&world, CoupledParams::new(vec![[0.1; 3]]).into());
        state.ledger().bodies[0].kinetic
    };
    let (mut renderer, mut state) = start(&world, CoupledParams::new(vec![[0.1; 3]]).into());
    let (other, mut beside) = start(&world, CoupledParams::new(vec![[0.1; 3]]).into());
    let mut more = world.clone();
    more.bodies
        .insert(0, ball("guest", 0.01, Free::of_mass(0.02)).at([1.0; 3]));
    let far = Sample::at(&[FAR]);
    for sample in 0..300 {
        if sample == 100 {
            (renderer, state) = renderer.changed(&state, &more).expect("one more");
        }
        renderer.step(&mut state, &far);
        other.step(&mut beside, &far);
        let place = state.bodies().last().expect("the block").position;
        let expected = beside.bodies()[0].position;
        for (place, expected) in place.iter().zip(expected) {
            assert!((place - expected).abs() < 1e-9, "{sample}");
        }
    }
    assert!(state.bodies()[1].position[0].abs() > 1e-3, "it swings");
    assert_balanced(&state, kinetic);
    // Without its hinge it falls; with a new one it hangs from its current position.
    let mut free = more.clone();
    free.joints.clear();
    (renderer, state) = renderer.changed(&state, &free).expect("no joint");
    for _ in 0..100 {
        renderer.step(&mut state, &far);
    }
    let fallen = state.bodies()[1];
    assert!(fallen.position[2] < -0.08, "{fallen:?}");
    let mut again = more.clone();
    let [x, y, z] = fallen.position;
    again.joints[0].point = [x, y, z + 0.05];
    (renderer, state) = renderer.changed(&state, &again).expect("a new joint");
    let entry = state.ledger().joints[0];
    assert!(
        entry.stored.abs() < 1e-12,
        "nothing is stretched: {entry:?}"
    );
    for _ in 0..200 {
        renderer.step(&mut state, &far);
        let [px, _, pz] = state.bodies()[1].position;
        let arm = ((px - x).powi(2) + (pz - z - 0.05).powi(2)).sqrt();
        assert!((arm - 0.05).abs() < 5e-3, "{arm}");
    }
    assert_balanced(&state, kinetic);
}

#[test]
fn mass_change_keeps_velocity_and_records_energy() {
    let flying = |mass: f64| {
        let free = Free {
            angular_velocity: [1.0, 2.0, 3.0],
            ..Free::of_mass(mass).moving([0.2, 0.0, 0.0])
        };
        let half_extents = [0.03, 0.02, 0.01];
        let body = Body::new("block", Shape::Box { half_extents }, Motion::Free(free));
        world(0.005, vec![body], ContactLaw::spring(1000.0))
    };
    let (mut renderer, mut state) = start(&flying(0.1), BasicParams::default().into());
    for _ in 0..50 {
        renderer.step(&mut state, &Sample::at(&[FAR]));
    }
    let (before, kinetic) = (state.bodies()[0], state.ledger().bodies[0].kinetic);
    (renderer, state) = renderer.changed(&state, &flying(0.3)).expect("renderable");
    let after = state.bodies()[0];
    assert_eq!(
        (after.position, after.velocity),
        (before.position, before.velocity)
    );
    for (one, other) in after.angular_velocity.iter().zip(before.angular_velocity) {
        assert!((one - other).abs() < 1e-12);
    }
    let entry = state.ledger().bodies[0];
    assert!((entry.kinetic - 3.0 * kinetic).abs() < 1e-12, "{entry:?}");
    assert!((entry.outside - 2.0 * kinetic).abs() < 1e-12, "{entry:?}");
    assert_eq!(renderer.step(&mut state, &Sample::at(&[FAR])).fault, None);
}

#[test]
fn a_body_is_put_elsewhere() {
    for method in methods() {
        let world = on_floor();
        let (renderer, mut state) = start(&world, method.clone());
        for sample in 0..400 {
            renderer.step(&mut state, &Sample::at(&pushed(sample)));
        }
        // At the same depth in the floor but elsewhere, without a friction anchor.
        let still = state.bodies()[1];
        let [x, y, z] = still.position;
        let beside = BodyState {
            position: [x + 0.1, y, z],
            ..still
        };
        let bristle = |state: &WorldState| -> f64 {
            let contacts = state.contacts().iter();
            contacts
                .map(|contact| contact.bristle.map(f64::abs).iter().sum::<f64>())
                .sum()
        };
        let mut copy = state.clone();
        assert!(bristle(&copy) > 0.0, "{}: it slides", method.name());
        renderer
            .place(&mut copy, 1, &beside)
            .expect("a place beside");
        assert_eq!(bristle(&copy), 0.0, "{}", method.name());
        let to = BodyState {
            position: [0.3, 0.2, HALF + 0.01],
            orientation: IDENTITY,
            velocity: [0.0, 0.1, 0.0],
            angular_velocity: [0.0; 3],
        };
        renderer.place(&mut state, 1, &to).expect("a place");
        assert_eq!(state.bodies()[1], to);
        let mut force = [0.0; 3];
        for sample in 400..500 {
            force = renderer
                .step(&mut state, &Sample::at(&pushed(sample)))
                .forces[0];
        }
        let of_tool = |contact: &&ContactState| contact.between.contains(&Side::Tool(0));
        for contact in state.contacts().iter().filter(of_tool) {
            assert_eq!(contact.mode, Mode::Free, "{}: {contact:?}", method.name());
        }
        // The damper of a virtual coupling drags its proxy along.
        let drag = if method.name() == "virtual-coupling" {
            0.1
        } else {
            1e-3
        };
        assert!(
            force.iter().all(|x| x.abs() < drag),
            "{}: {force:?}",
            method.name()
        );
        let moved = state.bodies()[1].position[1] - 0.2;
        assert!(
            moved > 1e-3,
            "{}: it slides and comes to rest: {moved}",
            method.name()
        );
        assert_balanced(&state, 0.0);
    }
}

#[test]
fn what_cannot_be_is_refused_and_nothing_changes() {
    let world = on_floor();
    let (renderer, mut state) = start(&world, BasicParams::default().into());
    let before = state.clone();
    let still = state.bodies()[1];
    let wrong = [
        (
            BodyState {
                position: [f64::NAN; 3],
                ..still
            },
            1,
            "position",
        ),
        (
            BodyState {
                orientation: [2.0, 0.0, 0.0, 0.0],
                ..still
            },
            1,
            "orientation",
        ),
        (
            BodyState {
                velocity: [0.0, f64::INFINITY, 0.0],
                ..still
            },
            1,
            "velocity",
        ),
        (
            BodyState {
                velocity: [0.0, 1.0, 0.0],
                ..still
            },
            0,
            "fixed",
        ),
        (still, 2, "there is no body 2; the world has 2"),
    ];
    for (to, body, word) in wrong {
        let error = renderer.place(&mut state, body, &to).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
        assert_eq!(error.part, WorldPart::Body(body));
    }
    assert_eq!(state.bodies(), before.bodies());
    assert_eq!(state.ledger(), before.ledger());
    let mut other = world.clone();
    other.tools[0].name = "finger".into();
    let faults = renderer.changed(&state, &other).unwrap_err();
    let words = faults.first().to_string();
    assert!(words.contains("it was \"tool\""), "{words}");
    let mut two = world.clone();
    two.tools
        .push(Tool::new("second", Shape::Sphere { radius: 0.0 }));
    let faults = renderer.changed(&state, &two).unwrap_err();
    assert!(
        faults.first().to_string().contains("2 tools, previously 1"),
        "{}",
        faults.first()
    );
    let mut heavy = world;
    if let Motion::Free(free) = &mut heavy.bodies[1].motion {
        free.mass = 0.0;
    }
    assert_eq!(
        renderer
            .changed(&state, &heavy)
            .unwrap_err()
            .first()
            .field
            .name(),
        "mass"
    );
}

#[test]
fn a_body_that_is_taken_away_keeps_what_was_booked() {
    for method in methods() {
        let world = on_floor();
        let (mut renderer, mut state) = start(&world, method.clone());
        for sample in 0..600 {
            renderer.step(&mut state, &Sample::at(&pushed(sample)));
        }
        let created = state.ledger().created();
        let on_proxy: f64 = {
            let contacts = state.ledger().contacts.iter();
            contacts.map(|entry| entry.work_on_proxy).sum()
        };
        assert!(on_proxy.abs() > 1e-6, "{}: {on_proxy}", method.name());
        let mut empty = world;
        empty.bodies.truncate(1);
        (renderer, state) = renderer.changed(&state, &empty).expect("renderable");
        let ledger = state.ledger();
        assert!(
            (ledger.created() - created).abs() < 1e-15,
            "{}",
            method.name()
        );
        assert_eq!(
            (ledger.gone.contacts.stored, ledger.gone.bodies.kinetic),
            (0.0, 0.0)
        );
        for _ in 0..50 {
            renderer.step(&mut state, &Sample::at(&[FAR]));
        }
        assert_balanced(&state, 0.0);
    }
}
