//! God-object: the proxy stays on the surface, friction holds it, and touched bodies receive the opposite of the
//! device force.

use palpate_world::{
    Body, ContactLaw, Free, GodObjectParams, Mesh, Mode, Motion, Sample, Shape, Tool, Vector,
    WorldLoop, WorldRenderer, WorldState,
};

use crate::common::{ball, plane, world};

const K: f64 = 2000.0;

fn params(damping: f64) -> GodObjectParams {
    GodObjectParams {
        stiffness: vec![K],
        damping: vec![damping],
    }
}

fn renderer(bodies: Vec<Body>, friction: f64, damping: f64) -> WorldRenderer {
    let law = ContactLaw::spring(K).with_friction(friction);
    let world = world(0.005, bodies, law);
    WorldRenderer::new(&world, WorldLoop::new(0.001), params(damping)).unwrap()
}

/// Moves the tool along a line in a number of samples. Returns the final force.
fn lead(
    renderer: &WorldRenderer,
    state: &mut WorldState,
    from: Vector,
    to: Vector,
    samples: u32,
) -> Vector {
    let mut force = [0.0; 3];
    for sample in 1..=samples {
        let share = f64::from(sample) / f64::from(samples);
        let place = std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
        let output = renderer.step(state, &Sample::at(&[place]));
        assert_eq!(output.fault, None);
        force = output.forces[0];
    }
    force
}

fn near(force: Vector, expected: Vector, within: f64) {
    for (is, wanted) in force.iter().zip(expected) {
        assert!((is - wanted).abs() < within, "{force:?} {expected:?}");
    }
}

#[test]
fn the_proxy_stays_on_a_floor_and_at_the_edge_of_a_groove() {
    let floor = renderer(vec![plane("floor", [0.0, 0.0, 1.0])], 0.0, 0.0);
    let mut state = floor.start();
    let above = [0.0, 0.0, 0.01];
    let force = lead(&floor, &mut state, above, [0.0, 0.0, 0.0051], 50);
    assert_eq!(force, [0.0; 3]);
    near(state.tools()[0].proxy_position, [0.0, 0.0, 0.0051], 1e-15);
    let force = lead(&floor, &mut state, above, [0.02, 0.0, 0.003], 200);
    near(force, [0.0, 0.0, K * 0.002], 1e-9);
    near(state.tools()[0].proxy_position, [0.02, 0.0, 0.005], 1e-12);
    assert_eq!(state.contacts()[0].penetration, 0.0);

    // With other methods two walls push with K each; the proxy has only one coupling.
    let walls = [[0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]];
    let walls = walls.map(|normal| plane(&format!("wall {}", normal[0]), normal));
    let groove = renderer(walls.into(), 0.0, 0.0);
    let mut state = groove.start();
    let force = lead(
        &groove,
        &mut state,
        [0.0, 0.0, 0.02],
        [0.0002, 0.01, 0.004],
        200,
    );
    let edge = 0.005 / 0.8;
    near(state.tools()[0].proxy_position, [0.0, 0.01, edge], 1e-9);
    near(force, [-K * 0.0002, 0.0, K * (edge - 0.004)], 1e-5);
}

#[test]
fn friction_holds_the_proxy_until_the_force_leaves_its_cone() {
    let rough = renderer(vec![plane("floor", [0.0, 0.0, 1.0])], 0.5, 0.0);
    let mut state = rough.start();
    let start = [0.0, 0.0, 0.006];
    let pressed = [0.0, 0.0, 0.003];
    lead(&rough, &mut state, start, pressed, 50);
    let stuck = lead(&rough, &mut state, pressed, [0.0005, 0.0, 0.003], 50);
    near(stuck, [-K * 0.0005, 0.0, K * 0.002], 1e-9);
    assert_eq!(state.contacts()[0].mode, Mode::Sticks);
    let taken = state.ledger().contacts[0].dissipated;
    assert!(taken < 1e-12, "{taken}");
    let slides = lead(
        &rough,
        &mut state,
        [0.0005, 0.0, 0.003],
        [0.01, 0.0, 0.003],
        200,
    );
    near(slides, [-0.5 * K * 0.002, 0.0, K * 0.002], 1e-9);
    assert_eq!(state.contacts()[0].mode, Mode::Slides);
    // Friction force times the displacement of the proxy.
    let taken = state.ledger().contacts[0].dissipated;
    let expected = 0.5 * K * 0.002 * (0.01 - 0.001);
    assert!((taken - expected).abs() < 1e-9, "{taken} {expected}");
}

#[test]
fn a_ball_gets_the_impulse_that_the_device_gives() {
    for damping in [0.0, 0.5] {
        let object = ball("ball", 0.02, Free::of_mass(0.1)).at([0.03, 0.001, 0.0]);
        let renderer = renderer(vec![object], 0.3, damping);
        let mut state = renderer.start();
        let mut sum = [0.0; 3];
        for sample in 0..200 {
            let place = [2e-4 * f64::from(sample), 0.0, 0.0];
            let output = renderer.step(&mut state, &Sample::at(&[place]));
            for (sum, force) in sum.iter_mut().zip(output.forces[0]) {
                *sum -= 0.001 * force;
            }
        }
        // The force of the last sample has not acted yet.
        let last = state.tools()[0].force;
        let velocity = state.bodies()[0].velocity;
        for axis in 0..3 {
            let given = sum[axis] + 0.001 * last[axis];
            assert!(
                (given - 0.1 * velocity[axis]).abs() < 1e-12,
                "{given} {velocity:?}"
            );
        }
        assert!(velocity[0] > 0.1, "{velocity:?}");
    }
}

#[test]
fn pressed_deep_against_a_thin_wall_of_triangles_it_does_not_pop_through() {
    // A plate of 0.5 mm thickness, 60 mm wide.
    let half = [0.03, 0.03, 0.000_25];
    let corner = |n: usize| -> Vector {
        std::array::from_fn(|axis| {
            if n >> axis & 1 == 0 {
                -half[axis]
            } else {
                half[axis]
            }
        })
    };
    let corners: Vec<Vector> = (0..8).map(corner).collect();
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    let mesh = Mesh::new(&corners, &faces).unwrap();
    let plate = Body::new("plate", Shape::Mesh(mesh.into()), Motion::Fixed);
    let renderer = renderer(vec![plate], 0.0, 0.0);
    let mut state = renderer.start();
    let force = lead(
        &renderer,
        &mut state,
        [0.0, 0.0, 0.01],
        [0.003, 0.0, -0.01],
        400,
    );
    let surface = half[2] + 0.005;
    near(state.tools()[0].proxy_position, [0.003, 0.0, surface], 1e-9);
    near(force, [0.0, 0.0, K * (surface + 0.01)], 1e-5);
}

#[test]
fn tools_that_turn_or_are_no_spheres_are_refused() {
    let floor = || vec![plane("floor", [0.0, 0.0, 1.0])];
    let law = ContactLaw::spring(K);
    let refused = |tool: Tool, params: GodObjectParams| {
        let mut world = world(0.005, floor(), law);
        world.tools[0] = tool;
        let faults = WorldRenderer::new(&world, WorldLoop::new(0.001), params).unwrap_err();
        faults
            .into_iter()
            .map(|fault| fault.to_string())
            .collect::<Vec<_>>()
            .join("; ")
    };
    let half_extents = [0.01; 3];
    let said = refused(Tool::new("cube", Shape::Box { half_extents }), params(0.0));
    assert!(said.contains("\"cube\" has another shape"), "{said}");
    let turning = Tool {
        turns: true,
        ..Tool::new("tip", Shape::Sphere { radius: 0.01 })
    };
    let said = refused(turning, params(0.0));
    assert!(said.contains("\"tip\" turns"), "{said}");
    let none = GodObjectParams {
        stiffness: vec![0.0],
        damping: Vec::new(),
    };
    let said = refused(Tool::new("tip", Shape::Sphere { radius: 0.01 }), none);
    assert!(
        said.contains("stiffness is 0, and has to be above 0"),
        "{said}"
    );
    assert!(said.contains("damping has 0 entries for 1 tools"), "{said}");
}
