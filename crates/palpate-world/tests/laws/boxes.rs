//! Box contacts: stiffness, conservation, energy ledger, and a resting stack.

use palpate_world::{
    Body, ContactLaw, CoupledParams, Free, Motion, Sample, Shape, Tool, Vector, World, WorldLoop,
    WorldRenderer, WorldState,
};

use crate::balance::{Balance, of_bodies};
use crate::common::{FAR, leave_alone, plane, world};
use crate::tumbling::{conserves, renderer, thrown};

fn block(name: &str, size: Vector, free: Free) -> Body {
    let half_extents = size.map(|x| 0.5 * x);
    Body::new(name, Shape::Box { half_extents }, Motion::Free(free))
}

fn heavy(mass: f64) -> Free {
    Free::of_mass(mass).pulled_by([0.0, 0.0, -9.81 * mass])
}

fn about_z(angle: f64) -> [f64; 4] {
    [(0.5 * angle).cos(), 0.0, 0.0, (0.5 * angle).sin()]
}

/// A box on a large fixed box moves as on a half-space, to rounding: K has the same meaning.
#[test]
fn a_large_box_pushes_as_a_half_space() {
    let law = ContactLaw::spring(5000.0)
        .with_damping(4.0)
        .with_friction(0.4);
    let mut free = heavy(0.1);
    free.angular_velocity = [3.0, -2.0, 4.0];
    free.velocity = [0.2, 0.1, -0.3];
    let falls = block("falls", [0.06, 0.04, 0.03], free)
        .at([0.0, 0.0, 0.045])
        .turned([0.975_718_7, 0.123_999, 0.173_598, 0.049_599_6]);
    let table = Shape::Box {
        half_extents: [0.5, 0.4, 0.3],
    };
    let table = Body::new("table", table, Motion::Fixed)
        .at([0.02, 0.01, -0.3])
        .turned(about_z(0.3));
    let floor = plane("table", [0.0, 0.0, 1.0]);
    let renderers =
        [table, floor].map(|below| renderer(&world(0.005, vec![falls.clone(), below], law)));
    let mut states = renderers.each_ref().map(WorldRenderer::start);
    let (mut apart, mut pushed) = (0.0_f64, 0);
    for _ in 0..400 {
        for (renderer, state) in renderers.iter().zip(&mut states) {
            leave_alone(renderer, state, 1);
        }
        let [one, other] = states.each_ref().map(|state| state.bodies()[0]);
        for axis in 0..3 {
            apart = apart.max((one.position[axis] - other.position[axis]).abs());
        }
        let touching = |state: &WorldState| {
            let contacts = state.contacts().iter();
            contacts.filter(|contact| contact.penetration > 0.0).count()
        };
        assert_eq!(touching(&states[0]), touching(&states[1]));
        pushed += usize::from(touching(&states[0]) > 0);
    }
    println!(
        "box on a box against box on a half-space: {apart:.1e} m apart, {pushed} of 400 samples in contact"
    );
    assert!(apart < 1e-12, "{apart}");
    assert!(pushed > 100, "{pushed}");
}

/// The box of a six-axis device, on the same prescribed path over a fixed box and over a half-space: same force and
/// torque.
#[test]
fn a_turning_tool_feels_a_fixed_box_as_a_half_space_and_a_free_box_by_its_face() {
    let law = ContactLaw::spring(5000.0)
        .with_damping(4.0)
        .with_friction(0.4);
    let tool = Shape::Box {
        half_extents: [0.03, 0.02, 0.015],
    };
    let half_extents = [0.5, 0.4, 0.3];
    let table = Body::new("table", Shape::Box { half_extents }, Motion::Fixed);
    let table = table.at([0.02, 0.01, -0.3]).turned(about_z(0.3));
    // Heavy and without weight, so it hardly moves.
    let heavy = block("table", half_extents.map(|x| 2.0 * x), Free::of_mass(1e9));
    let heavy = heavy.at([0.02, 0.01, -0.3]).turned(about_z(0.3));
    let states = [table, plane("table", [0.0, 0.0, 1.0]), heavy].map(|below| {
        let mut world = world(0.0, vec![below], law);
        world.tools = vec![Tool::new("tool", tool.clone()).turning()];
        let method = CoupledParams::new(vec![[0.15; 3]]).with_device_inertia(vec![[1e-4; 3]]);
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let state = renderer.start();
        (renderer, state)
    });
    let mut states = states;
    let (mut apart, mut most, mut corners) = ([0.0_f64; 2], [0.0_f64; 2], [false; 9]);
    for sample in 0..400 {
        let t = 0.001 * f64::from(sample);
        let place = [
            0.02 * t,
            0.01 * (20.0 * t).sin(),
            0.0165 + 0.002 * (30.0 * t).cos(),
        ];
        let (a, b) = (0.5 * 0.12 * (17.0 * t).sin(), 0.5 * 0.09 * (23.0 * t).cos());
        let size = (1.0 + a * a + b * b).sqrt();
        let turned = [1.0 / size, a / size, b / size, 0.0];
        let felt = states.each_mut().map(|(renderer, state)| {
            let output = renderer.step(state, &Sample::at(&[place]).turned(&[turned]));
            assert_eq!(output.fault, None);
            let wrench = [output.forces[0], output.torques[0]];
            let touching = state
                .contacts()
                .iter()
                .filter(|contact| contact.penetration > 0.0);
            (wrench, touching.count())
        });
        corners[felt[0].1] = true;
        let [on_box, on_plane, on_heavy] = felt.map(|(wrench, _)| wrench);
        for kind in 0..2 {
            for axis in 0..3 {
                let plain = on_plane[kind][axis];
                most[kind] = most[kind].max(plain.abs());
                for other in [on_box, on_heavy] {
                    apart[kind] = apart[kind].max((other[kind][axis] - plain).abs());
                }
            }
        }
    }
    println!(
        "a turning box on a box and on a half-space: {:.1e} of {:.1} N and {:.1e} of {:.3} N m apart",
        apart[0], most[0], apart[1], most[1]
    );
    assert!(
        apart[0] < 1e-6 * most[0] && apart[1] < 1e-6 * most[1],
        "{apart:?} {most:?}"
    );
    assert!(
        most[0] > 5.0 && corners[..4].iter().all(|seen| *seen),
        "{most:?} {corners:?}"
    );
}

#[test]
fn two_free_boxes_conserve_momentum_angular_momentum_and_energy() {
    let half = [[0.03, 0.02, 0.015], [0.015, 0.025, 0.02]];
    let boxes = || half.map(|half_extents| Shape::Box { half_extents });
    conserves("boxes", (0..24).map(|case| thrown(case, boxes())), 15);
}

fn stack(law: ContactLaw) -> World {
    let size = [0.04, 0.04, 0.02];
    let bodies = vec![
        plane("table", [0.0, 0.0, 1.0]),
        block("lower", size, heavy(0.05)).at([0.0, 0.0, 0.01]),
        block("middle", size, heavy(0.05))
            .at([0.002, 0.001, 0.03])
            .turned(about_z(0.07)),
        block("upper", size, heavy(0.05))
            .at([0.001, -0.001, 0.05])
            .turned(about_z(-0.1)),
    ];
    world(0.005, bodies, law)
}

/// A tool pushes the middle box sideways, falls onto the stack and knocks it over: ledger of each contact, and the
/// transfers between the points of a pair.
#[test]
fn ledger_of_toppled_stack_closes() {
    let law = ContactLaw::spring(4000.0)
        .with_damping(2.0)
        .with_friction(0.4);
    let renderer = renderer(&stack(law));
    let mut state = renderer.start();
    let start = of_bodies(&state);
    let mut dissipated = 0.0;
    for sample in 0..700 {
        let x = -0.05 + 0.15 * 0.001 * f64::from(sample);
        renderer.step(&mut state, &Sample::at(&[[x, 0.004, 0.042]]));
        let now: f64 = state
            .ledger()
            .contacts
            .iter()
            .map(|entry| entry.dissipated)
            .sum();
        assert!(now >= dissipated);
        dissipated = now;
    }
    let balance = Balance::since(start, &state);
    println!("stack: {balance}");
    let (turned_over, handed_on) = (balance.turned_over, balance.handed_on);
    assert!(
        turned_over > 0.02 && handed_on > 1e-6,
        "{turned_over} {handed_on}"
    );
    balance.holds_to(1e-13, 2e-3);
}

/// Over 10 s. The friction bristles have no damping, so the boxes sway for a long time. Compared are the mean
/// position and the speed of each box.
#[test]
fn a_stack_rests() {
    let law = ContactLaw::spring(8000.0)
        .with_damping(8.0)
        .with_friction(0.5);
    let renderer = renderer(&stack(law));
    let mut state = renderer.start();
    // Mean position of each box and largest speed over a second.
    let second = |state: &mut WorldState| {
        let mut means = [[0.0; 3]; 4];
        let mut fastest = 0.0_f64;
        for _ in 0..1000 {
            let output = renderer.step(state, &Sample::at(&[FAR]));
            assert_eq!(output.fault, None);
            for (mean, body) in means.iter_mut().zip(state.bodies()) {
                for (axis, mean) in mean.iter_mut().enumerate() {
                    *mean += body.position[axis] / 1000.0;
                    fastest = fastest.max(body.velocity[axis].abs());
                }
            }
        }
        (means, fastest)
    };
    let mut seconds = Vec::new();
    for _ in 0..10 {
        seconds.push(second(&mut state));
    }
    let apart = |one: &[Vector; 4], other: &[Vector; 4]| {
        let pairs = one.as_flattened().iter().zip(other.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let crept = apart(&seconds[1].0, &seconds[9].0);
    let speeds: Vec<String> = seconds.iter().map(|(_, v)| format!("{v:.0e}")).collect();
    println!(
        "a stack of three for 10 s: crept by {crept:.1e} m from the second second to the last; m/s {speeds:?}"
    );
    assert!(crept < 1e-6, "{crept}");
    assert!(seconds[9].1 < 2e-4 && seconds[9].1 <= seconds[1].1);
    let sunk = 0.05 * 3.0 * 9.81 / 8000.0;
    assert!((0.01 - seconds[9].0[1][2] - sunk).abs() < 1e-6);
}
