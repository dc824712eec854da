//! Ideals on meshes: each beside that of the shape that the mesh is one of.
#![allow(clippy::print_stdout)] // what was measured

use std::sync::Arc;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::mesh::{TriangleMesh, gallery};
use palpate_testbed::world::{
    CheckedIdeal, ContactLaw, Member, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldHand,
    WorldIdeal, WorldScene,
};

fn fixed(shape: Shape) -> WorldBody {
    WorldBody {
        name: "part".into(),
        shape,
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        motion: None,
    }
}

fn mesh((vertices, faces): &gallery::Triangles) -> Shape {
    Shape::Mesh(Arc::new(TriangleMesh::new(vertices, faces).unwrap()))
}

fn law() -> ContactLaw {
    ContactLaw::spring(4000.0).damped(3.0).rough(0.3, 2000.0)
}

/// A tool of 0.15 kg that falls from `position` and is pulled to `rest`.
fn scene(radius: f64, position: Vector, rest: Vector, bodies: Vec<WorldBody>) -> WorldScene {
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![WorldDevice {
            name: "tool".into(),
            own_axes: None,
            mass_table: None,
            drivetrain: palpate_testbed::world::Drivetrain::default(),
            mass: [0.15; 3],
            position,
            velocity: [0.0; 3],
            tool: Tool::sphere(radius),
            turning: None,
            hand: WorldHand {
                stiffness: 200.0,
                damping: 5.0,
                rest,
                ..WorldHand::default()
            },
            quantum: [0.0; 3],
        }],
        pairs: (0..bodies.len())
            .map(|body| Pair {
                between: [Member::Device(0), Member::Body(body)],
                law: law(),
            })
            .collect(),
        bodies,
    }
}

fn ideal(scene: &WorldScene) -> WorldIdeal {
    WorldIdeal::new(scene, Grid::even(0.0, 0.001, 250)).unwrap()
}

/// Largest difference of the impulses of two ideals over their largest.
fn apart(one: &WorldIdeal, other: &WorldIdeal) -> f64 {
    let [a, b] = [one, other].map(|ideal| ideal.devices[0].impulses.iter().flatten());
    let largest = a.clone().fold(0.0_f64, |most, j| most.max(j.abs()));
    assert!(largest > 1e-4, "{largest}");
    a.zip(b)
        .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
        / largest
}

/// A block of 40 mm, 40 mm and 20 mm whose sides are cut into squares.
fn block(cells: u32) -> (gallery::Triangles, Vector) {
    let half = [0.02, 0.02, 0.01];
    let (vertices, faces) = gallery::bumpy_sphere(1.0, 0.0, 1.0, cells);
    // The directions of a sphere made from a cube, back onto it.
    let onto = |v: &Vector| {
        let largest = v.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        [0, 1, 2].map(|axis| {
            let x = v[axis] / largest;
            // Round-off must not bend a face.
            half[axis] * if x.abs() > 1.0 - 1e-9 { x.signum() } else { x }
        })
    };
    ((vertices.iter().map(onto).collect(), faces), half)
}

#[test]
fn a_block_of_triangles_is_a_box() {
    let (triangles, half_extents) = block(7);
    let shape = Shape::Box { half_extents };
    for (name, radius, position, rest) in [
        ("face", 0.005, [0.0, 0.001, 0.016], [0.008, 0.004, 0.005]),
        ("edge", 0.005, [0.017, 0.001, 0.016], [0.03, 0.004, -0.005]),
        ("corner", 0.004, [0.018, 0.018, 0.015], [0.03, 0.025, 0.0]),
    ] {
        let of = |shape: &Shape| {
            let mut body = fixed(shape.clone());
            body.orientation = [0.8, 0.36, -0.48, 0.0];
            // Turn the tool with the block.
            let turn = |[x, y, z]: Vector| {
                let [w, a, b] = [0.8, 0.36, -0.48];
                let cross = [b * z, -a * z, a * y - b * x];
                let twice = [b * cross[2], -a * cross[2], a * cross[1] - b * cross[0]];
                let v = [x, y, z];
                [0, 1, 2].map(|i| v[i] + 2.0 * (w * cross[i] + twice[i]))
            };
            ideal(&scene(radius, turn(position), turn(rest), vec![body]))
        };
        let (smooth, triangles) = (of(&shape), of(&mesh(&triangles)));
        let apart = apart(&smooth, &triangles);
        println!(
            "{name}: {apart:.0e} apart, {} events for {}",
            triangles.events, smooth.events
        );
        assert!(triangles.events > smooth.events, "{name}");
        assert!(apart < 1e-7, "{name}: {apart}");
    }
}

/// A sphere in a groove of triangles is pushed by both walls, as by two half-spaces; a body of two half-spaces has two
/// contacts with it.
#[test]
fn a_groove_of_triangles_is_two_half_spaces() {
    for degrees in [60.0_f64, 90.0, 120.0] {
        let (sine, cosine) = (0.5 * degrees.to_radians()).sin_cos();
        let mut vertices = Vec::new();
        for (side, row) in [(1.0, 6), (1.0, 3), (0.0, 0), (-1.0, 3), (-1.0, 6)] {
            for y in -6..=6 {
                let up = 0.005 * f64::from(row);
                vertices.push([side * up * sine, 0.005 * f64::from(y), up * cosine]);
            }
        }
        let faces: Vec<[u32; 3]> = (0..4)
            .flat_map(|row| (0..12).map(move |k| row * 13 + k))
            .flat_map(|a| [[a, a + 1, a + 14], [a, a + 14, a + 13]])
            .collect();
        let walls = [1.0, -1.0].map(|side: f64| {
            fixed(Shape::HalfSpace {
                normal: [-side * cosine, 0.0, sine],
                offset: 0.0,
            })
        });
        let of = |bodies| {
            ideal(&scene(
                0.004,
                [0.002, 0.0, 0.012],
                [-0.001, 0.012, -0.006],
                bodies,
            ))
        };
        let smooth = of(walls.into());
        let triangles = of(vec![fixed(mesh(&(vertices, faces)))]);
        let apart = apart(&smooth, &triangles);
        println!(
            "{degrees}: {apart:.0e} apart, {} events for {}",
            triangles.events, smooth.events
        );
        assert!(apart < 1e-7, "{degrees}: {apart}");
        let at_once = |ideal: &WorldIdeal| {
            let pushing = |contacts: &[palpate_testbed::world::ContactState]| {
                contacts.iter().filter(|it| it.normal_force > 0.0).count()
            };
            ideal
                .states
                .iter()
                .map(|state| pushing(&state.contacts))
                .max()
        };
        assert_eq!(at_once(&triangles), Some(2));
    }
}

/// Over bumps and hollows, edges and corners of triangles, the ideal has one motion.
#[test]
fn the_ideal_on_a_bumpy_sphere_agrees_with_itself_and_keeps_its_energy() {
    let ball = mesh(&gallery::bumpy_sphere(0.04, 0.001, 12.0, 33));
    let scene = scene(
        0.004,
        [0.012, 0.005, 0.0445],
        [-0.01, -0.008, 0.036],
        vec![fixed(ball)],
    );
    let checked = CheckedIdeal::new(&scene, Grid::even(0.0, 0.001, 250)).unwrap();
    let ideal = &checked.ideal;
    let balance = |number: usize| ideal.states[number].ledger.balance();
    let error = (balance(250) - balance(0)).abs();
    let turned_over = ideal.states[250].ledger.dissipated;
    println!(
        "itself {:.0e} %, {} events, {} steps; energy to {error:.0e} J of {turned_over:.1e} J",
        checked.error, ideal.events, ideal.steps
    );
    assert_eq!(checked.chaotic_from, None);
    assert!(ideal.events > 20 && turned_over > 1e-4);
    assert!(error < 1e-6 * turned_over, "{error} {turned_over}");
}

/// A point that is pressed through a wall of 0.5 mm, and further than that, is pulled back to where it came from.
#[test]
fn a_tool_does_not_pop_through_a_thin_wall() {
    let (mut triangles, _) = block(9);
    for vertex in &mut triangles.0 {
        vertex[2] *= 0.025;
    }
    for radius in [0.0, 0.0005] {
        let scene = scene(
            radius,
            [0.003, 0.001, 0.004],
            [0.006, -0.003, -0.03],
            vec![fixed(mesh(&triangles))],
        );
        let ideal = ideal(&scene);
        let last = ideal.states.last().unwrap();
        let [_, _, height] = last.devices[0].position;
        println!(
            "radius {radius}: at {:.2} mm, {:.2} N",
            1e3 * height,
            last.devices[0].force[2]
        );
        assert!(height < -0.0006 && last.devices[0].force[2] > 4.0);
    }
}

/// An open mesh is touched from its front only: a tool that passes its border from behind meets nothing.
#[test]
fn a_tool_that_comes_round_the_border_of_an_open_mesh_is_not_pushed() {
    let corners = vec![
        [0.0, -0.02, -0.02],
        [0.0, 0.02, -0.02],
        [0.0, 0.02, 0.0],
        [0.0, -0.02, 0.0],
    ];
    let plate = |faces: Vec<[u32; 3]>| vec![fixed(mesh(&(corners.clone(), faces)))];
    let back = plate(vec![[0, 2, 1], [0, 3, 2]]);
    let front = plate(vec![[0, 1, 2], [0, 2, 3]]);
    for x in [0.001, 0.003, 0.0045] {
        let fall = |plate: &[WorldBody]| {
            let mut scene = scene(0.005, [x, 0.0, 0.012], [x, 0.0, -0.012], plate.to_vec());
            scene.devices[0].hand.stiffness = 30.0;
            let ideal = ideal(&scene);
            let impulses = ideal.devices[0].impulses.iter().flatten();
            impulses.fold(0.0_f64, |most, impulse| most.max(impulse.abs()))
        };
        assert!(fall(&back) == 0.0, "{x}: {}", fall(&back));
        assert!(fall(&front) > 1e-4, "{x}: {}", fall(&front));
    }
}
