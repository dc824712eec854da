//! Worlds that no number of sub-steps follows.

use palpate_core::Fault;
use palpate_world::{
    BasicParams, Contact, ContactLaw, CoupledParams, Free, GodObjectParams, HfcrParams, Party,
    Sample, SehParams, VirtualCouplingParams, World, WorldLoop, WorldMethod, WorldRenderer,
};

use crate::common::{ball, plane, world};

fn methods() -> [WorldMethod; 6] {
    [
        BasicParams::default().into(),
        SehParams.into(),
        HfcrParams::default().into(),
        GodObjectParams {
            stiffness: vec![800.0],
            damping: vec![1.0],
        }
        .into(),
        VirtualCouplingParams {
            stiffness: vec![800.0],
            damping: vec![1.0],
            mass: vec![0.1],
            rotational_stiffness: Vec::new(),
            rotational_damping: Vec::new(),
            inertia: Vec::new(),
        }
        .into(),
        CoupledParams::new(vec![[0.1; 3]]).into(),
    ]
}

/// Returns a floor with balls, the first of which lies on a floor that is too stiff.
fn balls(count: usize) -> World {
    let mut bodies = vec![plane("floor", [0.0, 0.0, 1.0])];
    for number in 0..count {
        let at = [1.0 + 0.1 * number as f64, 0.5, 0.019_999_999];
        bodies.push(ball(&format!("ball {number}"), 0.02, Free::of_mass(0.05)).at(at));
    }
    let mut world = world(0.01, bodies, ContactLaw::spring(800.0));
    world.contacts.push(Contact {
        between: [Party::Named("ball 0".into()), Party::Any],
        law: ContactLaw::spring(1e10),
    });
    world
}

#[test]
fn a_distant_unstable_body_makes_no_force_come_and_go() {
    for count in [1, 5] {
        for method in methods() {
            let name = method.name();
            let renderer = WorldRenderer::new(&balls(count), WorldLoop::new(0.01), method).unwrap();
            let mut state = renderer.start();
            for _ in 0..12 {
                let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, 0.009]]));
                let fault = output.fault.map(|it| it.fault);
                assert_eq!(fault, Some(Fault::Overflow), "{name} of {count}");
                assert_eq!(output.forces, [[0.0; 3]], "{name} of {count}");
                assert!(output.effort.unstable && output.effort.too_fast);
            }
        }
    }
}
