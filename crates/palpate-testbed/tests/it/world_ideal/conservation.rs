//! What must not change: energy, momentum and angular momentum.

use palpate_testbed::world::{ContactLaw, Member, Shape, Tool, WorldIdeal, WorldScene, WorldState};

use super::{body, device, half_space, motion, pair, solve};

/// Two balls and a turned cylinder, a capsule or a box that fly into each other.
fn crash(other: Shape, law: ContactLaw) -> WorldScene {
    let mut thing = body(other, 0.08, [0.0, 0.0, 0.0]);
    thing.orientation = [0.8, 0.36, 0.48, 0.0];
    motion(&mut thing).angular_velocity = [3.0, -5.0, 8.0];
    let mut balls = [
        body(Shape::Sphere { radius: 0.02 }, 0.05, [0.07, 0.004, -0.01]),
        body(Shape::Sphere { radius: 0.03 }, 0.1, [-0.01, 0.09, 0.01]),
    ];
    motion(&mut balls[0]).velocity = [-0.5, 0.1, 0.05];
    motion(&mut balls[0]).angular_velocity = [0.0, 40.0, 10.0];
    motion(&mut balls[1]).velocity = [0.05, -0.4, 0.0];
    let [a, b] = balls;
    let pairs = [(1, 0), (0, 2), (1, 2)]
        .map(|(i, k)| pair(Member::Body(i), Member::Body(k), law))
        .to_vec();
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![],
        bodies: vec![thing, a, b],
        pairs,
    }
}

fn shapes() -> [Shape; 4] {
    [
        Shape::Sphere { radius: 0.025 },
        Shape::Box {
            half_extents: [0.02, 0.03, 0.015],
        },
        Shape::Capsule {
            radius: 0.015,
            half_length: 0.02,
        },
        Shape::Cylinder {
            radius: 0.02,
            half_length: 0.03,
        },
    ]
}

fn momenta(scene: &WorldScene, state: &WorldState) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (body, state) in scene.bodies.iter().zip(&state.bodies) {
        let mass = body.motion.unwrap().mass;
        let ([x, y, z], [u, v, w]) = (state.position, state.velocity);
        let orbital = [y * w - z * v, z * u - x * w, x * v - y * u];
        for axis in 0..3 {
            sum[axis] += mass * state.velocity[axis];
            sum[3 + axis] += mass * orbital[axis] + state.angular_momentum[axis];
        }
    }
    sum
}

fn drift(ideal: &WorldIdeal) -> f64 {
    let start = ideal.states[0].ledger.balance();
    let apart = ideal
        .states
        .iter()
        .map(|state| (state.ledger.balance() - start).abs());
    apart.fold(0.0, f64::max) / ideal.states[0].ledger.kinetic
}

#[test]
fn bodies_that_collide_keep_energy_momentum_and_angular_momentum() {
    let spring = ContactLaw::spring(4000.0);
    for (name, law) in [
        ("springs", spring),
        ("friction", spring.rough(0.5, 3000.0)),
        ("damping", spring.damped(1.5)),
        ("both", spring.rough(0.4, 2000.0).damped(1.0)),
    ] {
        for shape in shapes() {
            let scene = crash(shape.clone(), law);
            let ideal = solve(&scene, 0.005, 60);
            let (first, last) = (&ideal.states[0], ideal.states.last().unwrap());
            let before = momenta(&scene, first);
            let mut apart = [0.0_f64; 2];
            for state in &ideal.states {
                for (i, (a, b)) in momenta(&scene, state).iter().zip(before).enumerate() {
                    apart[i / 3] = apart[i / 3].max((a - b).abs());
                }
            }
            let lost = last.ledger.dissipated / first.ledger.kinetic;
            println!(
                "{name}, {shape:?}: energy to {:.1e}, momentum to {:.1e} N s, angular to {:.1e}; lost {lost:.3}; \
                 {} contacts, {} events, {} steps",
                drift(&ideal),
                apart[0],
                apart[1],
                ideal.encounters.len(),
                ideal.events,
                ideal.steps
            );
            assert!(ideal.encounters.len() >= 2, "they meet");
            assert!(
                drift(&ideal) < 1e-10,
                "{name}, {shape:?}: {}",
                drift(&ideal)
            );
            assert!(apart[0] < 1e-14 && apart[1] < 1e-15);
            if name == "springs" {
                assert!(lost.abs() < 1e-14);
            } else {
                assert!(lost > 0.001);
            }
            for pair in ideal.states.windows(2) {
                assert!(pair[1].ledger.dissipated >= pair[0].ledger.dissipated - 1e-14);
            }
        }
    }
}

/// A tool in a hand pushes a ball that rolls on a rough floor.
#[test]
fn the_hand_pays_for_what_a_push_takes() {
    let mut tool = device(0.2, [-0.05, 0.003, 0.03]);
    tool.tool = Tool::sphere(0.01);
    tool.mass = [0.1, 0.16, 0.25];
    tool.hand.force = [1.5, 0.0, -0.1];
    tool.hand.stiffness = 60.0;
    tool.hand.damping = 1.5;
    tool.hand.rest = [-0.02, 0.0, 0.03];
    let mut ball = body(Shape::Sphere { radius: 0.02 }, 0.1, [0.0, 0.0, 0.02]);
    motion(&mut ball).force[2] = -0.981;
    let law = ContactLaw::spring(4000.0).rough(0.4, 2000.0).damped(0.5);
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![tool],
        bodies: vec![ball, half_space([0.0, 0.0, 1.0], 0.0)],
        pairs: vec![
            pair(Member::Device(0), Member::Body(0), law),
            pair(Member::Body(0), Member::Body(1), law),
        ],
    };
    let ideal = solve(&scene, 0.005, 60);
    let start = ideal.states[0].ledger.balance();
    for state in &ideal.states {
        assert!((state.ledger.balance() - start).abs() < 1e-10);
    }
    let end = &ideal.states.last().unwrap().ledger;
    println!("{end:?}");
    assert!(end.hand_work > 0.005 && end.dissipated > 1e-4);
    // The profile contains the impulses of the contacts on the device.
    let contacts = ideal.encounters.iter().filter(|e| e.is_of_device(0));
    let of_contacts: f64 = contacts.map(|encounter| encounter.impulse[0]).sum();
    let of_profile: f64 = ideal.devices[0].impulses.iter().map(|j| j[0]).sum();
    assert!((of_contacts - of_profile).abs() < 1e-12 && of_profile < -0.01);
}
