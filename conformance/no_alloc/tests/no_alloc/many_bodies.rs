//! A tick of a world with many bodies allocates nothing.

use std::hint::black_box;

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, GodObjectParams, HfcrParams,
    Motion, Party, Sample, Shape, Tool, World, WorldLoop, WorldMethod, WorldRenderer,
};

use crate::allocations;

/// Memory for near points is reserved when it is created.
#[test]
fn a_hundred_balls_are_touched_without_allocating() {
    let floor = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let mut bodies = vec![Body::new("floor", floor, Motion::Fixed)];
    for number in 0..100 {
        let free = Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.5]);
        let ball = Shape::Sphere { radius: 0.01 };
        let place = [
            0.021 * f64::from(number % 10),
            0.021 * f64::from(number / 10),
            0.01,
        ];
        bodies.push(Body::new(format!("ball {number}"), ball, Motion::Free(free)).at(place));
    }
    let world = World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.004 })],
        bodies,
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(2000.0)
                .with_damping(1.0)
                .with_friction(0.3),
        }],
    };
    let methods: [WorldMethod; 4] = [
        BasicParams::default().into(),
        GodObjectParams {
            stiffness: vec![2000.0],
            damping: vec![1.0],
        }
        .into(),
        HfcrParams::default().into(),
        CoupledParams::new(vec![[0.1; 3]]).into(),
    ];
    for method in methods {
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let mut touched = 0;
        let count = allocations(|| {
            for tick in 0..200 {
                let t = f64::from(tick) * 0.001;
                let sway = 0.08 * (1.0 - (20.0 * t).cos());
                let positions = [[sway, 0.7 * sway, 0.021 + 0.004 * (30.0 * t).sin()]];
                let output = black_box(renderer.step(&mut state, &Sample::at(&positions)));
                touched += usize::from(output.forces[0] != [0.0; 3]);
            }
        });
        assert!(touched > 50, "{touched}");
        assert_eq!(count, 0);
    }
}
