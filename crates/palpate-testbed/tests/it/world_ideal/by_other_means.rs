//! Compares the ideal with a scheme of small fixed steps without modes and events.
//!
//! The scheme is a half kick, a drift with return mapping of the bristle, and a half kick. It is of low order and
//! supports spheres and one floor only. Its error goes to 0 with its step, so its limit must equal the ideal.

use palpate_testbed::world::{ContactLaw, Member, Shape, Tool, Vector, WorldScene};

use super::{body, device, half_space, motion, pair, solve};

const RADIUS: [f64; 2] = [0.01, 0.02];
const LAW: ContactLaw = ContactLaw {
    stiffness: 4000.0,
    damping: 1.5,
    friction: 0.3,
    friction_stiffness: 2000.0,
    friction_damping: 0.0,
};
const DURATION: f64 = 0.12;

/// A tool drops on a ball beside its middle; the ball turns, rolls and slips on the floor.
fn scene() -> WorldScene {
    let mut tool = device(0.2, [-0.008, 0.004, 0.052]);
    tool.tool = Tool::sphere(RADIUS[0]);
    tool.mass = [0.1, 0.16, 0.25];
    tool.velocity = [0.2, 0.05, -0.3];
    tool.hand.force = [0.3, 0.1, -1.0];
    let mut ball = body(Shape::Sphere { radius: RADIUS[1] }, 0.1, [0.0, 0.0, 0.02]);
    motion(&mut ball).force = [0.0, 0.0, -0.981];
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![tool],
        bodies: vec![ball, half_space([0.0, 0.0, 1.0], 0.0)],
        pairs: vec![
            pair(Member::Device(0), Member::Body(0), LAW),
            pair(Member::Body(0), Member::Body(1), LAW),
        ],
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// a + s b
fn add(a: Vector, s: f64, b: Vector) -> Vector {
    std::array::from_fn(|axis| a[axis] + s * b[axis])
}

fn cross([a, b, c]: Vector, [x, y, z]: Vector) -> Vector {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// One contact: normal towards the first, penetration, its rate and the tangential velocity.
fn contact(first: &Sphere, second: Option<&Sphere>) -> (Vector, f64, f64, Vector) {
    let (normal, p, at_second) = match second {
        None => {
            let p = first.radius - first.place[2];
            ([0.0, 0.0, 1.0], p, [0.0; 3])
        }
        Some(second) => {
            let apart = add(first.place, -1.0, second.place);
            let distance = dot(apart, apart).sqrt();
            let normal = apart.map(|part| part / distance);
            let p = first.radius + second.radius - distance;
            let arm = normal.map(|part| part * (second.radius - 0.5 * p));
            (
                normal,
                p,
                add(second.velocity, 1.0, cross(second.turning, arm)),
            )
        }
    };
    let arm = normal.map(|part| -part * (first.radius - 0.5 * p));
    let at_first = add(first.velocity, 1.0, cross(first.turning, arm));
    let relative = add(at_first, -1.0, at_second);
    let rate = -dot(relative, normal);
    (normal, p, rate, add(relative, rate, normal))
}

#[derive(Clone)]
struct Sphere {
    radius: f64,
    mass: Vector,
    inertia: f64,
    place: Vector,
    velocity: Vector,
    turning: Vector,
    force: Vector,
}

/// Place of tool and ball, spin of the ball and impulse on the tool at the end, by so many steps.
fn stepped(steps: u32) -> Vec<f64> {
    let scene = scene();
    let device = &scene.devices[0];
    let ball = scene.bodies[0].motion.unwrap();
    let mut spheres = [
        Sphere {
            radius: RADIUS[0],
            mass: device.mass,
            inertia: f64::INFINITY,
            place: device.position,
            velocity: device.velocity,
            turning: [0.0; 3],
            force: device.hand.force,
        },
        Sphere {
            radius: RADIUS[1],
            mass: [ball.mass; 3],
            inertia: ball.inertia[0],
            place: scene.bodies[0].position,
            velocity: [0.0; 3],
            turning: [0.0; 3],
            force: ball.force,
        },
    ];
    let mut bristles = [[0.0; 3]; 2];
    let mut impulse = [0.0; 3];
    let step = DURATION / f64::from(steps);
    for _ in 0..steps {
        for sphere in &mut spheres {
            sphere.place = add(sphere.place, 0.5 * step, sphere.velocity);
        }
        let mut pushes = [[0.0; 3], [0.0; 3]];
        let mut torques = [[0.0; 3], [0.0; 3]];
        for (number, (first, second)) in [(0, Some(1)), (1, None)].into_iter().enumerate() {
            let of_second = second.map(|second: usize| &spheres[second]);
            let (normal, p, rate, tangential) = contact(&spheres[first], of_second);
            let z = &mut bristles[number];
            if p <= 0.0 {
                *z = [0.0; 3];
                continue;
            }
            let push = (LAW.stiffness * p + LAW.damping * rate).max(0.0);
            *z = add(*z, -dot(*z, normal), normal);
            *z = add(*z, step, tangential);
            let largest = LAW.friction * push / LAW.friction_stiffness;
            let length = dot(*z, *z).sqrt();
            if length > largest {
                *z = z.map(|part| part * largest / length);
            }
            let force = add(normal.map(|part| part * push), -LAW.friction_stiffness, *z);
            let below = |radius: f64| radius - 0.5 * p;
            let arm = normal.map(|part| -part * below(spheres[first].radius));
            pushes[first] = add(pushes[first], 1.0, force);
            torques[first] = add(torques[first], 1.0, cross(arm, force));
            if let Some(second) = second {
                let arm = normal.map(|part| part * below(spheres[second].radius));
                pushes[second] = add(pushes[second], -1.0, force);
                torques[second] = add(torques[second], -1.0, cross(arm, force));
            }
        }
        impulse = add(impulse, step, pushes[0]);
        for (sphere, (push, torque)) in spheres.iter_mut().zip(pushes.iter().zip(torques)) {
            let total = add(*push, 1.0, sphere.force);
            for ((v, total), mass) in sphere.velocity.iter_mut().zip(total).zip(sphere.mass) {
                *v += step * total / mass;
            }
            sphere.turning = add(sphere.turning, step / sphere.inertia, torque);
            sphere.place = add(sphere.place, 0.5 * step, sphere.velocity);
        }
    }
    let [tool, ball] = spheres;
    let spin = ball.turning.map(|part| part * RADIUS[1]);
    [tool.place, ball.place, spin, impulse].concat()
}

#[test]
fn a_scheme_of_small_steps_tends_to_the_ideal() {
    let ideal = solve(&scene(), 0.001, 120);
    let end = ideal.states.last().unwrap();
    let spin = end.bodies[0].angular_velocity.map(|part| part * RADIUS[1]);
    let impulses = &ideal.devices[0].impulses;
    let impulse = impulses.iter().fold([0.0; 3], |sum, j| add(sum, 1.0, *j));
    let expected = [
        end.devices[0].position,
        end.bodies[0].position,
        spin,
        impulse,
    ]
    .concat();
    let error = |steps: u32| {
        let found = stepped(steps);
        let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    let errors = [30_000, 120_000, 480_000].map(error);
    println!(
        "largest difference [m, m/s, N s] {errors:?} by 30, 120 and 480 thousand steps; the ideal took {} and \
         {} events; spin {spin:?} m/s",
        ideal.steps, ideal.events
    );
    assert!(ideal.events > 10 && spin[1].abs() > 0.05);
    assert!(errors[1] < 0.4 * errors[0] && errors[2] < 0.4 * errors[1]);
    assert!(errors[2] < 1e-5);
}
