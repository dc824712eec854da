//! Passivity guard: energy delivered to the hands in a faulty loop, and by adversarial device motions.

use nalgebra::UnitQuaternion;
use palpate_core::Actuation;
use palpate_world::{
    BasicParams, Contact, ContactLaw, CoupledParams, Free, GodObjectParams, Party, Quaternion,
    Sample, Shape, Tool, Vector, VirtualCouplingParams, World, WorldGuard, WorldGuardParams,
    WorldLoop, WorldMethod, WorldPart, WorldRenderer, WorldState,
};

use crate::common::{ball, plane};
use crate::ideal::dot;

type Rotation = UnitQuaternion<f64>;

const SPEED: f64 = 1.0;
const TURNING: f64 = 10.0;

fn guard(allowance: f64, late: usize) -> WorldGuardParams {
    WorldGuardParams {
        late,
        ..WorldGuardParams::by_speed(SPEED, TURNING, allowance)
    }
}

/// Returns the energy available to the hands at a sample, by the ledger: input minus dissipation by damping and
/// friction.
fn there(state: &WorldState, at_start: f64) -> f64 {
    let ledger = state.ledger();
    let potential: f64 = ledger.bodies.iter().map(|entry| entry.potential).sum();
    let taken: f64 = ledger.contacts.iter().map(|entry| entry.dissipated).sum();
    at_start - potential - taken
}

/// Returns a corner of two stiff walls, in a plane.
fn corner(law: ContactLaw) -> World {
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies: vec![
            plane("floor", [0.0, 0.0, 1.0]),
            plane("wall", [1.0, 0.0, 0.0]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law,
        }],
    }
}

/// Energy and forces that a loop delivered to a hand.
#[derive(Debug)]
struct Given {
    /// Largest energy delivered by the end of an interval with a force, in excess of the energy available at the
    /// sample from which that force was computed `[J]`.
    most: f64,
    /// Number of samples at which the guard acted.
    acted: usize,
    /// Largest force that acted `[N]`.
    peak: f64,
}

/// A device of 0.2 kg falls into the corner, and a hand of 200 N/m and 1 N s/m presses it there for a second. Each
/// force acts two samples later than in the renderer's model. The energy is computed with the forces that actually
/// act.
fn broken(method: impl Into<WorldMethod>, guard: WorldGuard) -> Given {
    let (period, mass, late) = (1e-3, 0.2, 2);
    let law = ContactLaw::spring(20_000.0).with_damping(1.0);
    let loop_params = WorldLoop::new(period).with_guard(guard);
    let renderer = WorldRenderer::new(&corner(law), loop_params, method).unwrap();
    let mut state = renderer.start();
    let rest = [0.0, 0.0, -0.002];
    let (mut x, mut v) = ([0.008_f64, 0.0, 0.01], [0.0_f64; 3]);
    let mut queue = vec![([0.0; 3], 0.0); late];
    let mut given = Given {
        most: f64::NEG_INFINITY,
        acted: 0,
        peak: 0.0,
    };
    // Without a guard, or with an unmodelled delay, the device may become too fast.
    let is_told = matches!(guard, WorldGuard::Limit(WorldGuardParams { late: 2, .. }));
    let mut work = 0.0;
    for _ in 0..1000 {
        let output = renderer.step(&mut state, &Sample::at(&[x]));
        if output.fault.is_some() {
            // The device exceeds the plausible speed.
            assert!(!is_told, "{:?}", output.fault);
            break;
        }
        given.acted += usize::from(output.limited.guard);
        let sent = output.forces[0];
        queue.push((sent, there(&state, 0.0)));
        let (force, there) = queue.remove(0);
        given.peak = given.peak.max(dot(force, force).sqrt());
        let before = x;
        for axis in 0..3 {
            for _ in 0..20 {
                let hand = 200.0 * (rest[axis] - x[axis]) - v[axis];
                v[axis] += period / 20.0 * (force[axis] + hand) / mass;
                x[axis] += period / 20.0 * v[axis];
            }
        }
        let way = [0, 1, 2].map(|axis| x[axis] - before[axis]);
        assert!(
            !is_told || dot(way, way).sqrt() < SPEED * period,
            "the guard's premise: {way:?}"
        );
        work += dot(force, way);
        if force != [0.0; 3] {
            given.most = given.most.max(work - there);
        }
    }
    given
}

fn in_the_corner() -> [(&'static str, WorldMethod); 3] {
    [
        ("basic", BasicParams::default().into()),
        (
            "god-object",
            GodObjectParams {
                stiffness: vec![20_000.0],
                damping: vec![1.0],
            }
            .into(),
        ),
        ("coupled", CoupledParams::new(vec![[0.2; 3]]).into()),
    ]
}

#[test]
fn guard_keeps_energy_within_allowance_under_unmodelled_delay() {
    for (name, method) in in_the_corner() {
        for allowance in [0.01, 0.1] {
            let given = broken(method.clone(), WorldGuard::Limit(guard(allowance, 2)));
            println!("{name}, {allowance} J, told of 2 samples: {given:?}");
            assert!(given.most <= allowance * (1.0 + 1e-9), "{name}: {given:?}");
            assert!(given.acted > 0 && given.peak > 1.0, "{name}: {given:?}");
        }
    }
}

/// Without the guard the same loop delivers many times as much. A guard that only reports changes nothing.
#[test]
fn without_the_guard_the_same_loop_gives_out_many_times_as_much() {
    for (name, method) in in_the_corner() {
        let open = broken(method.clone(), WorldGuard::Off);
        let model = broken(method.clone(), WorldGuard::Limit(guard(0.01, 0)));
        println!("{name}: {open:?}; with a guard of .01 J that is told of no lateness {model:?}");
        assert!(open.most > 10.0 * 0.1, "{name}: {open:?}");
        // With an unmodelled delay the guard underestimates the delivered energy.
        assert!(model.most > 0.02, "{name}: {model:?}");
    }
    let method = CoupledParams::new(vec![[0.2; 3]]);
    let open = broken(method.clone(), WorldGuard::Off);
    let seen = broken(method, WorldGuard::Report(guard(0.01, 2)));
    assert_eq!(open.most.to_bits(), seen.most.to_bits());
    assert!(seen.acted > 100, "{seen:?}");
}

const ALLOWANCE: f64 = 2e-3;
/// Number of moves of an attack.
const LENGTH: usize = 40;
/// A move of an attack: directions of the tools, and rotation of the first tool.
type Move = [usize; 3];

/// Returns the direction along an axis, its opposite, or zero.
fn direction(number: usize) -> Vector {
    let mut direction = [0.0; 3];
    if number < 6 {
        direction[number / 2] = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    }
    direction
}

/// Returns two tools, the first of them a box that turns, a ball of 50 g and a floor.
fn crowd() -> World {
    let block = Shape::Box {
        half_extents: [0.01, 0.008, 0.006],
    };
    let weight = Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.5]);
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![
            Tool::new("block", block).turning(),
            Tool::new("finger", Shape::Sphere { radius: 0.004 }),
        ],
        bodies: vec![
            plane("floor", [0.0, 0.0, 1.0]),
            ball("ball", 0.01, weight).at([0.025, 0.0, 0.01]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(4000.0)
                .with_damping(1.0)
                .with_friction(0.5),
        }],
    }
}

struct Target {
    renderer: WorldRenderer,
    period: f64,
    /// Delay from a force to its beginning, in samples, including the unmodelled part.
    delay: usize,
}

impl Target {
    fn new(method: &WorldMethod, model: usize, unmodelled: usize, guard: WorldGuard) -> Self {
        let period = 0.002;
        let loop_params = WorldLoop::new(period)
            .with_actuation(Actuation::after_samples(model, period))
            .with_guard(guard);
        Self {
            renderer: WorldRenderer::new(&crowd(), loop_params, method.clone()).unwrap(),
            period,
            delay: model + unmodelled,
        }
    }

    /// Returns the largest energy that an attack extracted in excess of the available energy, and the number of
    /// samples at which the guard acted.
    fn taken_by(&self, moves: &[Move]) -> (f64, usize) {
        let mut state = self.renderer.start();
        let mut positions = [[-0.005, 0.0, 0.0065], [0.025, 0.0, 0.0245]];
        let mut turned = Rotation::identity();
        let none = ([[0.0; 3]; 3], 0.0);
        let mut queue = vec![none; self.delay];
        let (mut work, mut most, mut acted) = (0.0, f64::NEG_INFINITY, 0);
        for next in moves {
            let q = turned.quaternion();
            let turns: [Quaternion; 2] = [[q.w, q.i, q.j, q.k], palpate_world::IDENTITY];
            let sample = Sample::at(&positions).turned(&turns);
            let output = self.renderer.step(&mut state, &sample);
            if output.fault.is_some() {
                // The world cannot be computed: its bodies are reset, and a different world follows.
                break;
            }
            acted += usize::from(output.limited.guard);
            let sent = [output.forces[0], output.forces[1], output.torques[0]];
            queue.push((sent, there(&state, 0.0)));
            let (held, there) = queue.remove(0);
            for tool in 0..2 {
                let way = direction(next[tool]).map(|part| part * SPEED * self.period);
                positions[tool] = [0, 1, 2].map(|axis| positions[tool][axis] + way[axis]);
                work += dot(held[tool], way);
            }
            let turn = direction(next[2]).map(|part| part * TURNING * self.period);
            turned = UnitQuaternion::from_scaled_axis(turn.into()) * turned;
            work += dot(held[2], turn);
            if held != [[0.0; 3]; 3] {
                most = most.max(work - there);
            }
        }
        (most, acted)
    }

    /// Returns the best of many attacks, each improved move by move as long as it helps.
    fn attacked(&self, seed: u64) -> (f64, usize) {
        let mut random = seed;
        let mut below = |bound: usize| {
            // Knuth's generator, of which the high bits are sufficient.
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            usize::try_from(random >> 33).unwrap() % bound
        };
        let (mut most, mut acted) = (f64::NEG_INFINITY, 0);
        for attempt in 0..4 {
            let moves = (0..LENGTH).map(|i| {
                // Poke and run with a different rhythm each time, or at random.
                let poke = if (i / (attempt + 1)).is_multiple_of(2) {
                    5
                } else {
                    4
                };
                if attempt < 2 {
                    [poke, poke, 6]
                } else {
                    [below(7), below(7), below(7)]
                }
            });
            let mut moves: Vec<Move> = moves.collect();
            let (mut best, _) = self.taken_by(&moves);
            for _ in 0..15 {
                let mut other = moves.clone();
                let (from, many) = (below(LENGTH), 1 + below(6));
                let to = [below(7), below(7), below(7)];
                for step in other.iter_mut().skip(from).take(many) {
                    *step = to;
                }
                let (taken, _) = self.taken_by(&other);
                if taken >= best {
                    (best, moves) = (taken, other);
                }
            }
            let (taken, times) = self.taken_by(&moves);
            acted += times;
            most = most.max(taken);
        }
        (most, acted)
    }
}

fn in_the_crowd() -> [(&'static str, WorldMethod); 3] {
    let coupled = CoupledParams::new(vec![[0.15; 3]; 2]).with_device_inertia(vec![[3e-5; 3]; 2]);
    [
        ("basic", BasicParams::default().into()),
        (
            "virtual-coupling",
            VirtualCouplingParams {
                stiffness: vec![3000.0; 2],
                damping: vec![2.0; 2],
                mass: vec![0.05; 2],
                rotational_stiffness: vec![1.0; 2],
                rotational_damping: vec![1e-3; 2],
                inertia: vec![1e-5; 2],
            }
            .into(),
        ),
        ("coupled", coupled.into()),
    ]
}

#[test]
fn nobody_takes_out_of_a_world_more_than_there_is_and_the_allowance() {
    for (name, method) in in_the_crowd() {
        for (model, unmodelled) in [(0, 0), (2, 0), (1, 2)] {
            let limit = WorldGuard::Limit(guard(ALLOWANCE, unmodelled));
            let (taken, acted) = Target::new(&method, model, unmodelled, limit).attacked(17);
            println!("{name}, delay {model} + {unmodelled}: {taken:.6} J, acted {acted} times");
            assert!(taken <= ALLOWANCE * (1.0 + 1e-9), "{name}: {taken} J");
            assert!(acted > 0, "{name}");
        }
    }
}

#[test]
fn without_the_guard_the_same_adversary_takes_more_out_of_a_world() {
    for (name, method) in in_the_crowd() {
        let open = Target::new(&method, 0, 0, WorldGuard::Off);
        let (taken, acted) = open.attacked(17);
        println!("{name}: {taken:.4} J without a guard");
        assert!(taken > 5.0 * ALLOWANCE, "{name}: {taken} J");
        assert_eq!(acted, 0);
    }
}

/// Lost samples are charged at the maximum speed, and the next force has the remaining energy.
#[test]
fn a_lost_sample_gives_nobody_anything() {
    let method = WorldMethod::from(BasicParams::default());
    let limit = WorldGuard::Limit(guard(0.02, 0));
    let period = 1e-3;
    let loop_params = WorldLoop::new(period).with_guard(limit);
    let law = ContactLaw::spring(1000.0);
    let renderer = WorldRenderer::new(&corner(law), loop_params, method).unwrap();
    let mut state = renderer.start();
    let at = |depth: f64| [[0.1, 0.0, 0.005 - depth]];
    let force = |state: &mut WorldState, depth: f64| {
        let output = renderer.step(state, &Sample::at(&at(depth)));
        (output.forces[0][2], output.limited.guard)
    };
    // 20 mJ at 1 m/s over 1 ms is 20 N; 4 N over 4 mm have been taken from the hand.
    for depth in [0.0, 1e-3, 2e-3, 3e-3, 4e-3] {
        assert_eq!(force(&mut state, depth), (1e3 * depth, false));
    }
    let mut left = 0.02 + 6e-3;
    for _ in 0..6 {
        assert_eq!(force(&mut state, 4e-3), (4.0, false));
        let output = renderer.step(&mut state, &Sample::at(&[[f64::NAN; 3]]));
        assert_eq!(output.forces[0], [0.0; 3]);
        left -= 4.0 * SPEED * period;
    }
    // 2 mJ remain, which limits the force to 2 N.
    let (last, acted) = force(&mut state, 4e-3);
    assert!((left - 2e-3).abs() < 1e-12 && acted, "{left} {acted}");
    assert!((last - left / (SPEED * period)).abs() < 1e-9, "{last}");
}

#[test]
fn a_guard_of_a_world_without_meaning_is_refused() {
    let good = guard(1e-3, 0);
    for (params, field) in [
        (
            WorldGuardParams {
                largest_speed: 0.0,
                ..good
            },
            "guard.largest_speed",
        ),
        (
            WorldGuardParams {
                largest_turning: f64::NAN,
                ..good
            },
            "guard.largest_turning",
        ),
        (
            WorldGuardParams {
                allowance: -1e-9,
                ..good
            },
            "guard.allowance",
        ),
        (WorldGuardParams { late: 9, ..good }, "guard.late"),
    ] {
        for guard in [WorldGuard::Report(params), WorldGuard::Limit(params)] {
            let loop_params = WorldLoop::new(1e-3).with_guard(guard);
            let world = corner(ContactLaw::spring(1000.0));
            let refused = WorldRenderer::new(&world, loop_params, BasicParams::default());
            let faults = refused.unwrap_err();
            assert_eq!(
                (faults.first().part, faults.first().field.name()),
                (WorldPart::Loop, field)
            );
        }
    }
}

/// A device without z. In each cycle an external motion of the mechanism presses its tool along z into a slope
/// without resistance by a motor, and the hand moves out along x, where the motors push it. No motor took this energy
/// from the hand: the guard withholds it.
#[test]
fn what_comes_in_along_an_axis_without_a_motor_is_not_there_for_the_hand() {
    let (allowance, step) = (5e-3, 2.5e-4);
    let mut world = corner(ContactLaw::spring(2000.0));
    world.tools[0].axes = [true, true, false];
    world.bodies = vec![plane("slope", [-0.6, 0.0, 0.8])];
    let rounds = [(0.0, -1.0), (-1.0, 0.0), (0.0, 1.0), (1.0, 0.0)];
    let ways = rounds.map(|way| [way; 24]).concat();
    let mut given = [0.0_f64; 2];
    let guards = [WorldGuard::Off, WorldGuard::Limit(guard(allowance, 0))];
    for (given, guard) in given.iter_mut().zip(guards) {
        let loop_params = WorldLoop::new(1e-3).with_guard(guard);
        let renderer = WorldRenderer::new(&world, loop_params, BasicParams::default()).unwrap();
        let mut state = renderer.start();
        // The tool is just outside.
        let (mut place, mut work) = ([0.0, 0.0, 0.0063], 0.0);
        for (x, z) in [&ways[..]; 5].concat() {
            let force = renderer.step(&mut state, &Sample::at(&[place])).forces[0];
            assert_eq!(force[2], 0.0);
            let way = [x * step, 0.0, z * step];
            work += dot(force, way);
            place = [0, 1, 2].map(|axis| place[axis] + way[axis]);
            *given = given.max(work);
        }
    }
    println!("given {given:?} J");
    assert!(given[0] > 10.0 * allowance, "{given:?}");
    assert!(
        given[1] <= allowance && given[1] > 0.5 * allowance,
        "{given:?}"
    );
}
