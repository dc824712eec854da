//! Worlds shared by several tests.

use palpate_world::{
    Body, Contact, ContactLaw, Free, Motion, Party, Sample, Shape, Tool, Vector, World,
    WorldRenderer, WorldState,
};

pub const FAR: Vector = [0.0, 0.0, 10.0];

pub fn ball(name: &str, radius: f64, free: Free) -> Body {
    Body::new(name, Shape::Sphere { radius }, Motion::Free(free))
}

pub fn plane(name: &str, normal: Vector) -> Body {
    let shape = Shape::HalfSpace {
        normal,
        offset: 0.0,
    };
    Body::new(name, shape, Motion::Fixed)
}

/// Returns a world with one point tool and these bodies, all with one law.
pub fn world(radius: f64, bodies: Vec<Body>, law: ContactLaw) -> World {
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius })],
        bodies,
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law,
        }],
    }
}

/// Steps with the tool out of reach.
pub fn leave_alone(renderer: &WorldRenderer, state: &mut WorldState, samples: usize) {
    for _ in 0..samples {
        let output = renderer.step(state, &Sample::at(&[FAR]));
        assert_eq!(output.fault, None);
        assert_eq!(output.forces, [[0.0; 3]]);
    }
}
