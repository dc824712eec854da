//! Momentum, angular momentum and energy of two bodies that collide and tumble.

use palpate_world::{
    Body, ContactLaw, CoupledParams, Free, Motion, Vector, World, WorldLoop, WorldRenderer,
    WorldState,
};

use crate::common::{leave_alone, world};

/// Returns the angular momentum R I Rᵀ ω of a body with these moments along its axes [kg m^2/s].
fn spin_of([w, x, y, z]: [f64; 4], omega: Vector, moments: Vector) -> Vector {
    let axes = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ],
        [
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ],
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let mut spin = [0.0; 3];
    for (axis, moment) in axes.iter().zip(moments) {
        let along: f64 = (0..3).map(|n| axis[n] * omega[n]).sum();
        for n in 0..3 {
            spin[n] += moment * along * axis[n];
        }
    }
    spin
}

/// Returns momentum [kg m/s] and angular momentum about the origin [kg m^2/s] of bodies with these masses [kg] and
/// moments [kg m^2].
pub fn momenta(state: &WorldState, of_bodies: &[(f64, Vector)]) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for (body, &(mass, moments)) in state.bodies().iter().zip(of_bodies) {
        let (x, v) = (body.position, body.velocity);
        let spin = spin_of(body.orientation, body.angular_velocity, moments);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            sums[i] += mass * v[i];
            sums[3 + i] += mass * (x[j] * v[k] - x[k] * v[j]) + spin[i];
        }
    }
    sums
}

/// Returns the unit quaternion along `[1, a, b, c]`.
pub fn turned(a: f64, b: f64, c: f64) -> [f64; 4] {
    let q = [1.0, a, b, c];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / size)
}

/// Returns a number from -1 to 1 for a case.
pub fn part(case: u32, prime: f64) -> f64 {
    2.0 * (f64::from(case + 1) * prime).fract() - 1.0
}

/// Returns a renderer of a world with one device without a hand, at 1 kHz.
pub fn renderer(world: &World) -> WorldRenderer {
    let method = CoupledParams::new(vec![[0.1; 3]]);
    WorldRenderer::new(world, WorldLoop::new(0.001), method).unwrap()
}

/// Returns two bodies of 0.1 and 0.06 kg with arbitrary orientations that approach each other at 1 m/s.
pub fn thrown(case: u32, shapes: [palpate_world::Shape; 2]) -> [Body; 2] {
    let turn = |prime: f64| part(case, prime);
    let free = |sign: f64, mass: f64| Free {
        velocity: [-0.5 * sign, 0.1 * turn(0.618), 0.1 * turn(0.414)],
        angular_velocity: [5.0 * turn(0.755), 5.0 * turn(0.570), 5.0 * turn(0.430)],
        ..Free::of_mass(mass)
    };
    let [one, other] = shapes;
    [
        Body::new("one", one, Motion::Free(free(1.0, 0.1)))
            .at([0.06, 0.0, 0.0])
            .turned(turned(turn(0.82), turn(0.67), turn(0.55)))
            .balanced(),
        Body::new("other", other, Motion::Free(free(-1.0, 0.06)))
            .at([-0.06, 0.006 * turn(0.3), 0.006 * turn(0.7)])
            .turned(turned(turn(0.732), turn(0.236), turn(0.142)))
            .balanced(),
    ]
}

/// Returns mass `[kg]` and moments of inertia `[kg m^2]` of a moving body.
pub fn mass_and_moments(body: &Body) -> (f64, Vector) {
    let Motion::Free(free) = &body.motion else {
        panic!("{} is fixed", body.name);
    };
    (free.mass, body.shape.moments(free.mass).unwrap())
}

/// Tests the conservation laws for two bodies over 0.25 s without damping and friction, at 8 kN/m.
///
/// Momentum and angular momentum are conserved to rounding, energy up to the sub-step error. More than `least_hits`
/// of the pairs must collide.
pub fn conserves(what: &str, pairs: impl IntoIterator<Item = [Body; 2]>, least_hits: usize) {
    let (mut worst, mut hits, mut count) = ([0.0_f64; 3], 0, 0);
    for bodies in pairs {
        count += 1;
        let of_bodies = bodies.each_ref().map(mass_and_moments);
        let renderer = renderer(&world(0.005, bodies.into(), ContactLaw::spring(8000.0)));
        let mut state = renderer.start();
        let energy = |state: &WorldState| {
            let ledger = state.ledger();
            let kinetic: f64 = ledger.bodies.iter().map(|entry| entry.kinetic).sum();
            let stored: f64 = ledger.contacts.iter().map(|entry| entry.stored).sum();
            (kinetic + stored, stored)
        };
        let (before, (at_start, _)) = (momenta(&state, &of_bodies), energy(&state));
        let mut most = 0.0_f64;
        for _ in 0..250 {
            leave_alone(&renderer, &mut state, 1);
            most = most.max(energy(&state).1);
        }
        hits += usize::from(most > 1e-4);
        let (after, (at_end, _)) = (momenta(&state, &of_bodies), energy(&state));
        for i in 0..3 {
            worst[0] = worst[0].max((after[i] - before[i]).abs() / 0.05);
            worst[1] = worst[1].max((after[3 + i] - before[3 + i]).abs() / 5e-4);
        }
        worst[2] = worst[2].max((at_end / at_start - 1.0).abs());
    }
    println!(
        "{count} pairs of {what}, {hits} hits: momentum {:.1e}, angular momentum {:.1e}, energy {:.1e} of what there was",
        worst[0], worst[1], worst[2]
    );
    assert!(hits > least_hits, "{hits}");
    assert!(worst[0] < 1e-12 && worst[1] < 1e-11, "{worst:?}");
    assert!(worst[2] < 2e-3, "{worst:?}");
}
