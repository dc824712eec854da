//! Descriptions that cannot be rendered are rejected with cause and allowed values.
#![allow(missing_docs)]

use palpate_core::Actuation;
use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Hull, Mesh, Motion, Party, Prior,
    Shape, SubSteps, Tool, World, WorldError, WorldGuard, WorldGuardParams, WorldLoop, WorldMethod,
    WorldPart, WorldRenderer,
};

fn a_world() -> World {
    let half_space = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let block = Shape::Box {
        half_extents: [0.01; 3],
    };
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.01 })],
        bodies: vec![
            Body::new("floor", half_space, Motion::Fixed),
            Body::new("block", block.clone(), Motion::Free(Free::of_mass(0.1))),
            Body::new("shelf", block, Motion::Fixed),
        ],
        contacts: vec![Contact {
            between: [Party::Named("tool".into()), Party::Any],
            law: ContactLaw::spring(1000.0),
        }],
    }
}

fn faults(
    world: &World,
    loop_params: WorldLoop,
    method: impl Into<WorldMethod>,
) -> Vec<WorldError> {
    let refused = WorldRenderer::new(world, loop_params, method).map(|_| ());
    refused.unwrap_err().into_iter().collect()
}

#[test]
fn a_pair_that_has_a_law_and_no_contact_is_refused_and_one_without_a_law_is_not() {
    let mut world = a_world();
    let loop_params = WorldLoop::new(0.001);
    assert!(WorldRenderer::new(&world, loop_params.clone(), BasicParams::default()).is_ok());
    world.contacts[0].between = [Party::Any, Party::Any];
    assert!(WorldRenderer::new(&world, loop_params.clone(), BasicParams::default()).is_ok());
    let [radius, half_length] = [0.01, 0.01];
    world.bodies[2].shape = Shape::Capsule {
        radius,
        half_length,
    };
    assert!(WorldRenderer::new(&world, loop_params.clone(), BasicParams::default()).is_ok());
    world.bodies[2].shape = Shape::Cylinder {
        radius,
        half_length,
    };
    assert!(WorldRenderer::new(&world, loop_params.clone(), BasicParams::default()).is_ok());
    let corners = [
        [0.0; 3],
        [0.01, 0.0, 0.0],
        [0.0, 0.01, 0.0],
        [0.0, 0.0, 0.01],
    ];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    world.bodies[2].shape = Shape::Mesh(Mesh::new(&corners, &faces).unwrap().into());
    let faults = faults(&world, loop_params, BasicParams::default());
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(
        faults[0].to_string(),
        "\"block\" and \"shelf\": there is no contact of a box with a mesh yet: edges can touch away from corners. A mesh \
         can touch a sphere, a tool of several spheres and a half-space; with a shell of points also a box, hull, \
         capsule, cylinder, and a mesh with a distance grid. Change one of the shapes, for example to a hull, or \
         remove the law of the pair"
    );
}

#[test]
fn a_tool_that_is_a_hull_and_more_points_than_fit_are_refused() {
    let mut world = a_world();
    world.contacts[0].between[1] = Party::Named("floor".into());
    let corners = [
        [0.0; 3],
        [0.01, 0.0, 0.0],
        [0.0, 0.01, 0.0],
        [0.0, 0.0, 0.01],
    ];
    world.tools[0].shape = Shape::Hull(Hull::around(&corners).unwrap().into());
    let refused = faults(&world, WorldLoop::new(0.001), BasicParams::default());
    assert_eq!(refused[0].part, WorldPart::Tool(0));
    assert!(
        refused[0]
            .to_string()
            .contains("a capsule, a cylinder or a mesh with a shell of points")
    );
    world.tools[0].shape = Shape::Spheres {
        spheres: Vec::new(),
    };
    let refused = faults(&world, WorldLoop::new(0.001), BasicParams::default());
    assert_eq!(refused[0].field.name(), "spheres");

    let mut world = a_world();
    let ball = Shape::Sphere { radius: 0.01 };
    for number in 0..362 {
        let free = Motion::Free(Free::of_mass(0.1));
        world
            .bodies
            .push(Body::new(format!("ball {number}"), ball.clone(), free));
    }
    world
        .bodies
        .retain(|body| body.name != "block" && body.name != "shelf");
    world.contacts[0].between = [Party::Any, Party::Any];
    let refused = faults(&world, WorldLoop::new(0.001), BasicParams::default());
    // 362 with the floor, 65 341 among each other, and the tool with all 363.
    assert!(
        refused[0].to_string().contains("there are 66066 points"),
        "{refused:?}"
    );
    assert!(
        refused[0].to_string().contains("at most 65536"),
        "{refused:?}"
    );
}

#[test]
fn every_parameter_of_loop_and_method_outside_its_range_is_said() {
    let world = a_world();
    let loop_params = WorldLoop {
        period: -1.0,
        largest_gap: None,
        speed_limit: Some(0.0),
        force_limits: vec![f64::NAN, 1.0],
        torque_limits: vec![0.0],
        turning_limit: Some(-1.0),
        actuation: Actuation::default(),
        sub_steps: SubSteps {
            least: 0,
            ..SubSteps::default()
        },
        guard: WorldGuard::Off,
        guard_masses: vec![[0.1, 0.0, 0.1], [0.1; 3]],
    };
    let method = CoupledParams {
        device_mass: vec![[0.1, -0.1, 0.1], [0.1; 3]],
        encoder_quantum: -1.0,
        offset_limit: 0.0,
        prior: Prior {
            jerk: f64::NAN,
            ..Prior::default()
        },
        ..CoupledParams::new(Vec::new())
    };
    let said: Vec<_> = faults(&world, loop_params, method)
        .iter()
        .map(|fault| fault.field.name())
        .collect();
    let expected = [
        "period",
        "speed_limit",
        "force_limits",
        "torque_limits",
        "guard.hand.least_mass",
        "turning_limit",
        "force_limits",
        "guard.hand.least_mass",
        "sub_steps",
        "device_mass",
        "device_mass",
        "offset_limit",
        "encoder_quantum",
        "prior.jerk",
    ];
    assert_eq!(said, expected);
}

#[test]
fn an_actuation_outside_its_range_is_refused() {
    let actuation = Actuation::after(0.1).with_gain(0.0);
    let loop_params = WorldLoop::new(0.001).with_actuation(actuation);
    let refused = faults(&a_world(), loop_params, BasicParams::default());
    let fields: Vec<_> = refused.iter().map(|fault| fault.field.name()).collect();
    assert_eq!(fields, ["actuation"; 2], "{refused:?}");
}

#[test]
fn a_tool_that_turns_needs_an_inertia() {
    let mut world = a_world();
    world.tools[0].turns = true;
    let model = |inertia| CoupledParams::new(vec![[0.1; 3]]).with_device_inertia(inertia);
    for inertia in [
        vec![],
        vec![[1e-4, 0.0, 1e-4]],
        vec![[1e-4, f64::INFINITY, 1e-4]],
    ] {
        let refused = faults(&world, WorldLoop::new(0.001), model(inertia));
        assert_eq!(refused[0].field.name(), "device_inertia", "{refused:?}");
    }
    let coupled = model(vec![[1e-4; 3]]);
    assert!(WorldRenderer::new(&world, WorldLoop::new(0.001), coupled).is_ok());
}

#[test]
fn a_device_has_at_least_one_axis() {
    let mut world = a_world();
    world.tools[0].axes = [false; 3];
    let faults = faults(&world, WorldLoop::new(0.001), BasicParams::default());
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(
        (faults[0].part, faults[0].field.name()),
        (WorldPart::Tool(0), "axes")
    );
    assert_eq!(
        faults[0].to_string(),
        "tool \"tool\": the device has no axis of the world; give it at least one of x, y and z"
    );
}

#[test]
fn what_is_too_large_or_too_small_to_reckon_with_is_refused() {
    let mut world = a_world();
    world.contacts[0].law.stiffness = 1e300;
    world.bodies[0].position = [0.0, -1e13, 0.0];
    let mut said = faults(&world, WorldLoop::new(0.001), BasicParams::default());
    let loop_params = WorldLoop::new(1e-21);
    said.extend(faults(&a_world(), loop_params, BasicParams::default()));
    for words in [
        "stiffness is 1e300, and has to be at most 1e12",
        "position is -10000000000000, and has to be at least -1e12",
        "period is 1e-21, and has to be at least 1e-20",
    ] {
        assert!(
            said.iter().any(|said| said.message == words),
            "{words}: {said:?}"
        );
    }
}

#[test]
fn what_is_infinite_and_has_to_be_finite_is_said_so() {
    let loop_params = WorldLoop {
        guard: WorldGuard::Limit(WorldGuardParams::by_speed(1.0, 10.0, f64::INFINITY)),
        ..WorldLoop::new(f64::INFINITY)
    };
    let mut world = a_world();
    let mut said = faults(&world, loop_params, BasicParams::default());
    world.contacts[0].law.stiffness = f64::INFINITY;
    let finite = WorldLoop::new(0.001);
    said.extend(faults(&world, finite, BasicParams::default()));
    for words in [
        "period is inf, and has to be finite",
        "guard.allowance is inf, and has to be finite",
        "stiffness is inf, and has to be finite",
    ] {
        assert!(
            said.iter().any(|said| said.message == words),
            "{words}: {said:?}"
        );
    }
}
