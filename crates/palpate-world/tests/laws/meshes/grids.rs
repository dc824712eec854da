//! Contacts of meshes with point shells and solids with distance grids.
#![allow(clippy::print_stdout)] // prints the measured values

use std::sync::Arc;

use palpate_world::{
    Body, Contact, ContactLaw, CoupledParams, DistanceGrid, Free, Hull, Mesh, Motion, Party,
    PointShell, Sample, Shape, Tool, Vector, World, WorldLoop, WorldRenderer,
};

use super::common::{block, drawn_out, fixed, plane, world};
use crate::balance::{Balance, energy, of_bodies};

const HALF: Vector = [0.03, 0.02, 0.015];

fn with_shell(mesh: Mesh, points: usize) -> Mesh {
    let shell = PointShell::over(&mesh, points).unwrap();
    mesh.with_shell(shell)
}

fn with_grid(mesh: Mesh, spacing: f64) -> Mesh {
    let grid = DistanceGrid::new(&mesh, spacing).unwrap();
    mesh.with_grid(grid).unwrap()
}

/// Returns an L of 40 mm by 30 mm, 16 mm thick, about its centre.
fn angle() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [40.0, 0.0],
        [40.0, 10.0],
        [10.0, 10.0],
        [10.0, 30.0],
        [0.0, 30.0],
    ];
    let outline = outline.map(|[x, y]| [1e-3 * (x - 15.0), 1e-3 * (y - 10.0)]);
    let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    drawn_out(&outline, &triangles, 8e-3)
}

/// Returns a U of 60 mm by 40 mm with a slot of 24 mm by 28 mm, 50 mm long.
fn slotted() -> Mesh {
    let outline = [
        [-30.0, -12.0],
        [30.0, -12.0],
        [30.0, 28.0],
        [12.0, 28.0],
        [12.0, 0.0],
        [-12.0, 0.0],
        [-12.0, 28.0],
        [-30.0, 28.0],
    ];
    let outline = outline.map(|place| place.map(|x| 1e-3 * x));
    let triangles = [
        [0, 1, 4],
        [0, 4, 5],
        [1, 2, 3],
        [1, 3, 4],
        [0, 5, 6],
        [0, 6, 7],
    ];
    drawn_out(&outline, &triangles, 25e-3)
}

fn free() -> Free {
    Free {
        angular_velocity: [3.0, -2.0, 4.0],
        velocity: [0.1, 0.05, -0.2],
        ..Free::of_mass(0.1).pulled_by([0.0, 0.0, -0.981])
    }
}

fn apart(a: &[Vector], b: &[Vector]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
}

fn falls(shape: Shape) -> Body {
    Body::new("falls", shape, Motion::Free(free())).at([0.002, 0.001, 0.035])
}

/// Returns the positions of a body that falls on a floor, with the tool out of reach.
fn places(bodies: Vec<Body>, law: ContactLaw, samples: u32) -> Vec<Vector> {
    let world = world(0.006, bodies, law);
    let method = CoupledParams::new(vec![[0.1; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
    let mut state = renderer.start();
    (0..samples)
        .map(|_| {
            let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, 0.5]]));
            assert_eq!((output.fault, output.effort.left_out), (None, 0));
            state.bodies().last().unwrap().position
        })
        .collect()
}

/// The shell of a block's corners acts like a box; the grid of a slab acts like the half-space below its top.
#[test]
fn a_shell_of_corners_is_a_box_and_the_grid_of_a_slab_a_floor() {
    let slab = with_grid(block([0.12, 0.12, 0.02], 2), 2.5e-3);
    let mesh = with_shell(block(HALF, 3), 8);
    assert_eq!(mesh.shell().unwrap().sharers(), 4);
    let mesh = Shape::Mesh(Arc::new(mesh));
    let half_extents = HALF;
    for (friction, allowed) in [(0.0, 1e-5), (0.3, 1e-5)] {
        let law = ContactLaw::spring(5000.0)
            .with_damping(4.0)
            .with_friction(friction);
        let floor = plane("floor", [0.0, 0.0, 1.0], 0.0);
        let of_box = places(
            vec![floor.clone(), falls(Shape::Box { half_extents })],
            law,
            300,
        );
        let by_points = places(vec![floor, falls(mesh.clone())], law, 300);
        let slab = fixed("floor", slab.clone()).at([0.0, 0.0, -0.02]);
        let on_grid = places(vec![slab, falls(mesh.clone())], law, 300);
        let off = [apart(&of_box, &by_points), apart(&of_box, &on_grid)];
        println!(
            "a box on a floor, friction {friction}: by points {:.1e} m, by points on a grid {:.1e} m apart",
            off[0], off[1]
        );
        assert!(off[0] < 1e-10 && off[1] < allowed, "{off:?}");
    }
}

/// An angle that tumbles in a slot touches flat sides, concave edges and sharp ones; energy is conserved. Distant
/// points of a large shell are not evaluated.
#[test]
fn what_tumbles_in_a_slot_keeps_its_energy() {
    for points in [48, 300] {
        let slot = fixed("slot", with_grid(slotted(), 1e-3)).turned(upright());
        let mesh = with_shell(angle(), points);
        let mut falls = Body::new("falls", Shape::Mesh(Arc::new(mesh)), Motion::Free(free()));
        falls = falls.balanced().at([0.003, 0.0, 0.050]);
        let world = world(0.006, vec![slot, falls], ContactLaw::spring(60_000.0));
        let method = CoupledParams::new(vec![[0.1; 3]]);
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let start = energy(&state);
        let (mut worst, mut touched, mut kinetic) = (0.0_f64, 0, 0.0_f64);
        for _ in 0..400 {
            let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, 0.5]]));
            assert_eq!((output.fault, output.effort.left_out), (None, 0));
            worst = worst.max((energy(&state) - start).abs());
            kinetic = kinetic.max(state.ledger().bodies[1].kinetic);
            touched += u32::from(
                state
                    .ledger()
                    .contacts
                    .iter()
                    .any(|entry| entry.stored > 0.0),
            );
        }
        println!(
            "an angle of {points} points in a slot by its grid: {touched} of 400 samples touch, energy is off by {worst:.1e} \
             of {kinetic:.3} J"
        );
        assert!(touched > 50 && kinetic > 0.01, "{touched} {kinetic}");
        assert!(worst < 2e-3 * kinetic, "{worst} {kinetic}");
    }
}

/// Points touch a box-shaped hull as they touch the box, on its faces, edges and corners.
#[test]
fn points_touch_the_hull_of_a_box_as_the_box() {
    let half_extents = [0.012, 0.015, 0.01];
    let corners = block(half_extents, 1).vertices();
    let hull = Shape::Hull(Arc::new(Hull::around(&corners).unwrap()));
    for points in [40, 300] {
        let mesh = Shape::Mesh(Arc::new(with_shell(angle(), points)));
        let law = ContactLaw::spring(5000.0)
            .with_damping(4.0)
            .with_friction(0.3);
        let on = |shape: Shape| {
            let rests = Body::new("rests", shape, Motion::Fixed).turned(upright());
            places(vec![rests, falls(mesh.clone()).balanced()], law, 150)
        };
        let (on_box, on_hull) = (on(Shape::Box { half_extents }), on(hull.clone()));
        let off = apart(&on_box, &on_hull);
        let moved = on_box.last().unwrap();
        println!("{points} points on a box and on its hull: {off:.1e} m apart, at {moved:?}");
        assert!(off < 1e-9, "{off}");
        // It has been supported: without the box it would be 0.14 m lower.
        assert!(moved[2] > -0.02, "{moved:?}");
    }
}

/// An angle and a wedge that tumble and collide at the angle's points conserve momentum and, without damping and
/// friction, energy.
#[test]
fn an_angle_and_a_hull_that_collide_keep_momentum_and_energy() {
    let wedge = [
        [-0.03, -0.02, -0.012],
        [0.03, -0.02, -0.012],
        [0.03, 0.02, -0.012],
        [-0.03, 0.02, -0.012],
        [-0.02, 0.0, 0.02],
        [0.02, 0.0, 0.02],
    ];
    let wedge = Shape::Hull(Arc::new(Hull::around(&wedge).unwrap()));
    let free = |velocity: Vector, turning: Vector| {
        Motion::Free(Free {
            angular_velocity: turning,
            ..Free::of_mass(0.1).moving(velocity)
        })
    };
    let mesh = Shape::Mesh(Arc::new(with_shell(angle(), 50)));
    let bodies = vec![
        Body::new("angle", mesh, free([0.0, 0.02, -0.3], [5.0, -3.0, 4.0]))
            .balanced()
            .at([0.002, 0.001, 0.055]),
        Body::new("wedge", wedge, free([0.0; 3], [-2.0, 3.0, 1.0])).balanced(),
    ];
    let world = world(0.006, bodies, ContactLaw::spring(20_000.0));
    let method = CoupledParams::new(vec![[0.1; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
    let mut state = renderer.start();
    let start = energy(&state);
    let momentum = |state: &palpate_world::WorldState| -> Vector {
        let [one, other] = [0, 1].map(|number| state.bodies()[number].velocity);
        [0, 1, 2].map(|axis| 0.1 * (one[axis] + other[axis]))
    };
    let before = momentum(&state);
    let (mut worst, mut touched, mut off) = (0.0_f64, 0, 0.0_f64);
    for _ in 0..400 {
        let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, 0.9]]));
        assert_eq!((output.fault, output.effort.left_out), (None, 0));
        worst = worst.max((energy(&state) - start).abs());
        off = off.max(apart(&[momentum(&state)], &[before]));
        touched += u32::from(
            state
                .ledger()
                .contacts
                .iter()
                .any(|entry| entry.stored > 0.0),
        );
    }
    println!(
        "an angle and a wedge: {touched} samples touch, energy is off by {worst:.1e} of {start:.4} J, momentum by {off:.1e}"
    );
    assert!(touched > 3, "{touched}");
    assert!(worst < 5e-4 * start && off < 1e-13, "{worst} {off}");
}

/// The error states how many points lie in one plane, if there are more than may touch at a time.
#[test]
fn a_shell_with_too_many_points_in_a_plane_is_refused() {
    let refused = PointShell::over(&block(HALF, 3), 600)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("the shell has 600 points") && refused.contains("at most 64"),
        "{refused}"
    );
}

/// The slot opens upwards.
fn upright() -> [f64; 4] {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    [half, half, 0.0, 0.0]
}

/// A six-axis mesh tool on a prescribed motion in a slot.
#[test]
fn ledger_of_mesh_tool_with_shell_closes() {
    let tool = Tool {
        turns: true,
        ..Tool::new("tool", Shape::Mesh(Arc::new(with_shell(angle(), 40))))
    };
    let ball = Motion::Free(Free::of_mass(0.03).pulled_by([0.0, 0.0, -0.3]));
    let law = ContactLaw::spring(4000.0)
        .with_damping(3.0)
        .with_friction(0.3);
    let world = World {
        tools: vec![tool],
        bodies: vec![
            fixed("slot", with_grid(slotted(), 1e-3)).turned(upright()),
            Body::new("ball", Shape::Sphere { radius: 0.008 }, ball).at([0.0, 0.015, 0.007]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law,
        }],
        joints: Vec::new(),
        fields: Vec::new(),
    };
    let method = CoupledParams::new(vec![[0.15; 3]]).with_device_inertia(vec![[4e-5; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
    let mut state = renderer.start();
    let start = of_bodies(&state);
    let (mut most, mut torque) = (0.0_f64, 0.0_f64);
    for sample in 0..400 {
        let at = f64::from(sample) / 400.0;
        let place = [0.006 * (9.0 * at).sin(), 0.004 * at, 0.02 - 0.012 * at];
        let turn = 0.3 * (7.0 * at).sin();
        let orientation = [(0.5 * turn).cos(), 0.0, (0.5 * turn).sin(), 0.0];
        let (places, orientations) = ([place], [orientation]);
        let sample = Sample::at(&places).turned(&orientations);
        let output = renderer.step(&mut state, &sample);
        assert_eq!(output.fault, None);
        most = output.forces[0]
            .iter()
            .fold(most, |most, x| most.max(x.abs()));
        torque = output.torques[0]
            .iter()
            .fold(torque, |most, x| most.max(x.abs()));
    }
    let balance = Balance::since(start, &state);
    println!("a tool with a shell in a slot: up to {most:.1} N and {torque:.3} N m, {balance}");
    assert!(most > 1.0 && torque > 1e-3, "{most} {torque}");
    balance.holds_to(1e-13, 2e-2);
}

#[test]
fn a_pair_without_points_or_without_a_grid_is_refused() {
    let law = ContactLaw::spring(1000.0);
    let method = CoupledParams::new(vec![[0.1; 3]]);
    let refused = |one: Shape, other: Shape| {
        let falls = Body::new("falls", one, Motion::Free(free())).balanced();
        let rests = Body::new("rests", other, Motion::Fixed);
        let world = world(0.006, vec![rests, falls], law);
        let refused = WorldRenderer::new(&world, WorldLoop::new(0.001), method.clone());
        refused.err().map(|faults| format!("{faults:?}"))
    };
    let mesh = |mesh: Mesh| Shape::Mesh(Arc::new(mesh));
    let (plain, points) = (|| mesh(angle()), || mesh(with_shell(angle(), 30)));
    let grid = || mesh(with_grid(slotted(), 2e-3));
    let corners = angle().vertices();
    let hull = || Shape::Hull(Arc::new(Hull::around(&corners).unwrap()));
    for (one, other, allowed) in [
        (points(), grid(), true),
        (grid(), points(), true),
        (points(), Shape::Box { half_extents: HALF }, true),
        (plain(), grid(), false),
        (points(), plain(), false),
        (points(), hull(), true),
        (hull(), points(), true),
        (plain(), hull(), false),
        (Shape::Box { half_extents: HALF }, grid(), false),
    ] {
        let words = format!("{one:?} on {other:?}");
        let message = refused(one, other);
        assert_eq!(message.is_none(), allowed, "{words}: {message:?}");
        if let Some(message) = message {
            assert!(message.contains("shell of points"), "{words}: {message}");
        }
    }
    let world = |shape: Shape| World {
        tools: vec![Tool::new("tool", shape)],
        ..world(0.0, vec![fixed("slot", slotted())], law)
    };
    let tool = |shape| WorldRenderer::new(&world(shape), WorldLoop::new(0.001), method.clone());
    let message = tool(plain()).err().map(|faults| format!("{faults:?}"));
    assert!(message.is_some_and(|message| message.contains("a mesh with a shell of points")));
}
