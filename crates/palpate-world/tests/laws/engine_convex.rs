//! Contact of a tool with convex meshes and hulls of another engine.

use palpate_world::engine::{BodyNow, BodyWrench, EngineRenderer, Stepping};
use palpate_world::{Hull, Mesh, Sample, Shape, Vector, WorldLoop};

use super::engine::{params, still, tool};

/// Returns a renderer for a sphere of 5 mm and one fixed shape.
fn on(shape: Shape) -> EngineRenderer {
    let body = still("body", shape);
    let loop_params = WorldLoop::new(0.001);
    EngineRenderer::new(
        &[tool()],
        &[body],
        Stepping::MeanVelocity,
        loop_params,
        params(),
    )
    .unwrap()
}

/// Returns penetration and normal for a sphere at `centre`.
fn touched(renderer: &EngineRenderer, centre: Vector) -> (f64, Vector) {
    let mut state = renderer.start();
    let mut wrenches = [BodyWrench::default()];
    renderer.sample(&mut state, &Sample::at(&[centre]));
    renderer.advance(
        &mut state,
        0.001,
        &[BodyNow::fixed([0.0; 3])],
        &mut wrenches,
    );
    renderer.hold(&mut state);
    let contact = state.contacts()[0];
    (contact.penetration, contact.normal)
}

/// Returns evenly distributed positions in a cube with this half side.
fn places(count: u32, half: f64) -> impl Iterator<Item = Vector> {
    let part = |number: u32, by: f64| (f64::from(number) * by).fract() * 2.0 - 1.0;
    (1..=count).map(move |n| [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|by| half * part(n, by)))
}

#[test]
fn a_convex_mesh_is_touched_as_the_box_that_it_is() {
    let half = [0.03, 0.02, 0.01];
    let corner = |number: u32| {
        [0, 1, 2].map(|axis| {
            if number >> axis & 1 == 1 {
                half[axis]
            } else {
                -half[axis]
            }
        })
    };
    let corners: Vec<Vector> = (0..8).map(corner).collect();
    let block = on(Shape::Box { half_extents: half });
    let others = [
        on(Shape::Hull(Hull::around(&corners).unwrap().into())),
        on(Shape::Mesh(Mesh::convex(&corners).unwrap().into())),
    ];
    let mut depths = 0;
    for place in places(3000, 0.04) {
        let (depth, normal) = touched(&block, place);
        for other in &others {
            let (same, along) = touched(other, place);
            assert!(
                (same - depth).abs() < 1e-15,
                "{same} and {depth} at {place:?}"
            );
            let off = (0..3).map(|axis| (along[axis] - normal[axis]).abs());
            assert!(
                depth <= 0.0 || off.sum::<f64>() < 1e-9,
                "{along:?} and {normal:?} at {place:?}"
            );
        }
        depths += u32::from(depth > 0.0);
    }
    assert!(depths > 300, "{depths}");
}

#[test]
fn a_ball_of_many_corners_is_touched_as_the_ball_between_its_two_spheres() {
    // In single precision, like the vertices of engines.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a mesh in single precision"
    )]
    let single = |x: f64| f64::from(x as f32);
    let on_sphere = |place: Vector| {
        let length = place.iter().map(|x| x * x).sum::<f64>().sqrt();
        place.map(|x| single(x * 0.03 / length))
    };
    let points: Vec<Vector> = places(2000, 1.0).map(on_sphere).collect();
    let mesh = Mesh::convex(&points).unwrap();
    assert!(mesh.vertices().len() > 1900);
    let whole_ball = on(Shape::Sphere { radius: 0.03 });
    let ball = on(Shape::Mesh(mesh.into()));
    // A face whose corners are 4 mm from its centre lies 0.3 mm inside the sphere.
    for place in places(300, 0.035) {
        let (whole, _) = touched(&whole_ball, place);
        let (depth, normal) = touched(&ball, place);
        let length = place.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along: f64 = (0..3).map(|axis| normal[axis] * place[axis] / length).sum();
        assert!(
            depth <= whole + 1e-9 && depth > whole - 3e-4,
            "{depth} and {whole} at {place:?}"
        );
        assert!(
            depth == 0.0 || length < 0.01 || along > 0.98,
            "{normal:?} at {place:?}"
        );
    }
}
