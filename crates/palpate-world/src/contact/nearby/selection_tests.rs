use super::*;
use crate::{
    Body, Contact, ContactLaw, CoupledParams, Free, Mesh, Motion, Party, PointShell, Sample, Shape,
    Tool, World, WorldLoop, WorldRenderer,
};

/// Returns a ball of 20 mm with bumps: 16 rings of 24 vertices and two poles.
fn bumpy_ball() -> Mesh {
    let (rings, around) = (16_u32, 24_u32);
    let mut vertices = vec![[0.0, 0.0, 0.02], [0.0, 0.0, -0.02]];
    for ring in 1..=rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings + 1);
        for step in 0..around {
            let angle = std::f64::consts::TAU * f64::from(step) / f64::from(around);
            let radius = 0.02 * (1.0 + 0.15 * (3.0 * angle).cos() * polar.sin().powi(2));
            let (across, along) = (radius * polar.sin(), radius * polar.cos());
            vertices.push([across * angle.cos(), across * angle.sin(), along]);
        }
    }
    let at = |ring: u32, step: u32| 2 + (ring - 1) * around + step % around;
    let mut faces = Vec::new();
    for step in 0..around {
        faces.push([0, at(1, step), at(1, step + 1)]);
        faces.push([1, at(rings, step + 1), at(rings, step)]);
        for ring in 1..rings {
            faces.push([at(ring, step), at(ring + 1, step), at(ring + 1, step + 1)]);
            faces.push([at(ring, step), at(ring + 1, step + 1), at(ring, step + 1)]);
        }
    }
    Mesh::new(&vertices, &faces).unwrap()
}

/// The ball with `points` points falls into a corner formed by a floor, a block and a capsule.
fn renderer(points: usize) -> WorldRenderer {
    let shell = PointShell::over(&bumpy_ball(), points).unwrap();
    let mesh = bumpy_ball().with_shell(shell.shared_by(3).unwrap());
    let free = Free {
        velocity: [0.3, 0.1, -0.4],
        angular_velocity: [6.0, -9.0, 4.0],
        ..Free::of_mass(0.08).pulled_by([0.2, 0.1, -0.8])
    };
    let fixed = |name: &str, shape: Shape| Body::new(name, shape, Motion::Fixed);
    let world = World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies: vec![
            fixed(
                "floor",
                Shape::HalfSpace {
                    normal: [0.0, 0.0, 1.0],
                    offset: 0.0,
                },
            ),
            fixed(
                "block",
                Shape::Box {
                    half_extents: [0.02, 0.2, 0.05],
                },
            )
            .at([0.06, 0.0, 0.03]),
            fixed(
                "rod",
                Shape::Capsule {
                    radius: 0.01,
                    half_length: 0.1,
                },
            )
            .at([0.0, 0.05, 0.02]),
            Body::new("ball", Shape::Mesh(Arc::new(mesh)), Motion::Free(free)).at([0.0, 0.0, 0.04]),
        ],
        contacts: vec![Contact {
            between: [Party::Named("ball".into()), Party::Any],
            law: ContactLaw::spring(4000.0)
                .with_friction(0.3)
                .with_damping(1.0),
        }],
        ..World::default()
    };
    WorldRenderer::new(
        &world,
        WorldLoop::new(0.001),
        CoupledParams::new(vec![[0.2; 3]]),
    )
    .unwrap()
}

#[test]
fn looking_at_what_is_near_is_as_good_as_looking_at_all() {
    let all = renderer(20);
    assert!(all.nearby.patches.is_empty());
    let mut near = all.clone();
    let mut patches = Vec::new();
    for fixed in 1..=3 {
        let of_pair = (0..)
            .zip(&near.points)
            .filter(|(_, point)| point.second == fixed);
        patches.extend(Patch::new(
            of_pair
                .map(|(number, point)| (number, point.centre))
                .collect(),
        ));
    }
    near.nearby = Nearby::new(
        &near.points,
        &[],
        patches,
        [[].into(), [].into()],
        vec![Vector3::repeat(1.0); 5],
        1,
    );
    let (mut one, mut other) = (all.start(), near.start());
    let (mut off, mut least, mut touched) = (0.0_f64, usize::MAX, 0);
    for _ in 0..600 {
        let far = Sample::at(&[[0.5; 3]]);
        let outputs = [all.step(&mut one, &far), near.step(&mut other, &far)];
        for output in outputs {
            assert_eq!((output.fault, output.effort.left_out), (None, 0));
        }
        let places = one.bodies()[3]
            .position
            .iter()
            .zip(other.bodies()[3].position);
        off = places.fold(off, |off, (a, b)| off.max((a - b).abs()));
        least = least.min(other.progress.now.nearby.numbers().len());
        touched += usize::from(
            other
                .progress
                .now
                .touches
                .iter()
                .any(|touch| !touch.is_apart()),
        );
    }
    assert!(
        touched > 50 && least < 20,
        "{touched} samples touch, of {least} points at least"
    );
    assert!(off < 1e-9, "{off} m apart");
}

#[test]
fn every_point_that_touches_is_near_however_the_body_lies() {
    let renderer = renderer(400);
    let mut moving = renderer.start().progress.now;
    let mut random = 1_u64;
    let mut between = |low: f64, high: f64| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut seen = 0;
    for _ in 0..400 {
        let ball = moving.parts.last_mut().unwrap();
        ball.rigid.position = Vector3::new(
            between(-0.01, 0.025),
            between(-0.01, 0.03),
            between(0.018, 0.04),
        );
        let turned = Vector3::from_fn(|_, _| between(-3.0, 3.0));
        ball.rigid.orientation = crate::geometry::rigid::Rotation::from_scaled_axis(turned);
        moving.gather(&renderer.points, 0.0);
        let numbers = moving.nearby.numbers();
        let left_out = moving.nearby.clone().take_left_out();
        for (number, point) in renderer.points.iter().enumerate() {
            let (first, second) = (
                &moving.parts[point.first].rigid,
                &moving.parts[point.second].rigid,
            );
            let nearest = point.solid.nearest(second, &point.centre_of(first));
            if nearest.distance < 0.0 && left_out == 0 {
                seen += 1;
                assert!(
                    numbers.contains(&number),
                    "{number} is {} m deep",
                    -nearest.distance
                );
            }
        }
        moving.nearby.take_left_out();
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn what_there_is_no_room_for_is_counted_and_the_deepest_stay() {
    let mut found = Found::new();
    for number in 0..ROOM + 10 {
        found.take(-(number as f64), number);
    }
    assert_eq!((found.count, found.left_out), (ROOM, 10));
    assert!(found.has(ROOM + 9) && !found.has(0));
}
