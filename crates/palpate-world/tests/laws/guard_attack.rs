//! The guard by acceleration against an adversary who accelerates devices of unknown mobility within its bounds.

use std::fmt::Write as _;

use nalgebra::{Matrix4, Vector3, Vector4};
use palpate_core::Actuation;
use palpate_world::{
    BasicParams, Contact, ContactLaw, CoupledParams, Free, GodObjectParams, HfcrParams, IDENTITY,
    Party, PopcParams, Sample, SehParams, Shape, Tool, Vector, VirtualCouplingParams, World,
    WorldGuard, WorldGuardParams, WorldHandBound, WorldHandLimit, WorldLoop, WorldMethod,
    WorldRenderer,
};

use crate::common::{ball, plane};

const ALLOWANCE: f64 = 1e-3;
const SPEED: f64 = 1.0;
const TURNING: f64 = 30.0;
const ACCELERATION: f64 = 80.0;
const ANGULAR: f64 = 3000.0;
const FORCE: f64 = 8.0;
const TORQUE: f64 = 0.1;
const HAND: WorldHandBound = WorldHandBound {
    limit: WorldHandLimit::Acceleration {
        linear: ACCELERATION,
        angular: ANGULAR,
    },
    least_mass: [0.1, 0.15, 0.25],
    least_inertia: 3e-5,
};
/// Samples of an attack, and accelerations per sample.
const LENGTH: usize = 50;
const PARTS: usize = 3;
const TOOLS: usize = 2;

/// Generalised coordinates of a device: its position, and its rotation about x.
type Four = Vector4<f64>;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        // Knuth's generator, of which the high bits are sufficient.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 33).unwrap()) / f64::from(1u32 << 31)
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.unit()
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // not negative and small
    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Returns an acceleration within the bound of the hand, often the largest along an axis or a diagonal.
    fn acceleration(&mut self) -> Four {
        let mut part = || [-1.0, 0.0, 1.0, self.between(-1.0, 1.0)][self.below(4)];
        let [x, y, z, turn] = [part(), part(), part(), part()];
        let along = Vector3::new(x, y, z);
        let along = along * (ACCELERATION / along.norm().max(1.0));
        Four::new(along.x, along.y, along.z, turn * ANGULAR)
    }
}

/// Motion of the hands.
#[derive(Clone)]
struct Attack {
    accelerations: Vec<[Four; TOOLS]>,
    /// True mobility of each device.
    mobility: [Matrix4<f64>; TOOLS],
    velocities: [Four; TOOLS],
    /// Place of the quanta, as a fraction of one.
    phase: f64,
}

/// Returns a random mobility matrix within the bound.
fn mobility(random: &mut Random, turns: bool) -> Matrix4<f64> {
    let [x, y, z] = HAND.least_mass.map(|mass| 1.0 / mass.sqrt());
    let turn = if turns {
        1.0 / HAND.least_inertia.sqrt()
    } else {
        0.0
    };
    let root = Matrix4::from_diagonal(&Four::new(x, y, z, turn));
    let mut part = || random.between(-1.0, 1.0);
    let direction = Four::new(part(), part(), part(), part()).normalize();
    let along = [0.0, 1.0, random.unit()][random.below(3)];
    let rest = (1.0 - along) * [0.0, 1.0, random.unit()][random.below(3)];
    root * (direction * direction.transpose() * along + Matrix4::identity() * rest) * root
}

impl Attack {
    fn begun(random: &mut Random, attempt: usize) -> Self {
        let turn = PARTS * [1, 2, 4, 8][attempt % 4];
        let mut accelerations = Vec::new();
        for i in 0..LENGTH * PARTS {
            let now = match i.checked_sub(2 * turn).and_then(|i| accelerations.get(i)) {
                // It repeats, poke and run.
                Some(&before) if attempt % 8 < 4 => before,
                _ => [random.acceleration(), random.acceleration()],
            };
            accelerations.push(now);
        }
        let mut velocity = || {
            let part = SPEED / 3f64.sqrt();
            let mut along = || random.between(-part, 0.5 * part);
            Four::new(along(), along(), along(), 0.0)
        };
        let velocities = [velocity(), velocity()];
        Self {
            accelerations,
            mobility: [mobility(random, true), mobility(random, false)],
            velocities,
            phase: random.unit(),
        }
    }

    fn changed(&self, random: &mut Random) -> Self {
        let mut other = self.clone();
        match random.below(12) {
            0 => other.mobility[0] = mobility(random, true),
            1 => other.mobility[1] = mobility(random, false),
            2 => {
                let tool = random.below(TOOLS);
                let axis = random.below(3);
                other.velocities[tool][axis] += random.between(-0.2, 0.2);
            }
            3 => other.phase = random.unit(),
            _ => {
                let tool = random.below(TOOLS);
                let (from, to) = (random.below(LENGTH * PARTS), random.acceleration());
                let most = [2, 5, 20, 60][random.below(4)];
                let many = 1 + random.below(most);
                for each in other.accelerations.iter_mut().skip(from).take(many) {
                    each[tool] = to;
                }
            }
        }
        other
    }
}

/// A device under first-order actuators, integrated exactly.
#[derive(Clone, Copy)]
struct Device {
    place: Four,
    velocity: Four,
    felt: Four,
}

impl Device {
    /// Moves for `h` `[s]` under the delivered wrench `aim` behind the `lag` `[s]`. Returns the work of the wrench.
    fn moves(
        &mut self,
        mobility: &Matrix4<f64>,
        by_hand: &Four,
        aim: &Four,
        lag: f64,
        h: f64,
    ) -> f64 {
        let v = self.velocity;
        let gained = by_hand + mobility * aim;
        let mut way = v * h + gained * (0.5 * h * h);
        self.velocity += gained * h;
        let mut work = 0.0;
        let off = self.felt - aim;
        self.felt = *aim;
        if lag > 0.0 {
            let left = (-h / lag).exp();
            let (once, timed) = (lag * (1.0 - left), lag * (lag * (1.0 - left) - h * left));
            let change = mobility * off * lag;
            way += change * (h - once);
            work += off.dot(&((v + change) * once + gained * timed));
            work -= off.dot(&change) * 0.5 * lag * (1.0 - left * left);
            self.velocity += change * (1.0 - left);
            self.felt += off * left;
        }
        self.place += way;
        work + aim.dot(&way)
    }

    fn is_too_fast(&self) -> bool {
        let v = &self.velocity;
        v.xyz().norm() > SPEED || v.w.abs() > TURNING
    }
}

/// A world that is attacked in a loop.
struct Target {
    name: &'static str,
    renderer: WorldRenderer,
    starts: Vec<Vector>,
    period: f64,
    actuation: Actuation<f64>,
    guard: WorldGuardParams,
    /// Masses of the second device, relative to those of the first.
    second: f64,
}

/// Returns a corner of two walls, a point in it, and a method for one tool.
fn corner(stiffness: f64, method: usize) -> (World, Vec<Vector>, WorldMethod) {
    let world = World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies: vec![
            plane("floor", [0.0, 0.0, 1.0]),
            plane("wall", [0.8, 0.6, 0.0]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(stiffness),
        }],
    };
    let method = match method % 6 {
        0 => BasicParams::default().into(),
        1 => GodObjectParams {
            stiffness: vec![stiffness],
            damping: vec![0.0],
        }
        .into(),
        2 => HfcrParams::default().into(),
        3 => PopcParams::new(vec![20.0]).into(),
        4 => SehParams.into(),
        _ => CoupledParams::new(vec![[0.2; 3]]).into(),
    };
    (world, vec![[0.0075, 0.0, 0.0055]], method)
}

/// Returns a turning block and a finger, a ball of 50 g and a floor, and a method for them.
fn crowd(method: usize) -> (World, Vec<Vector>, WorldMethod) {
    let block = Shape::Box {
        half_extents: [0.01, 0.008, 0.006],
    };
    let weight = Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.5]);
    let world = World {
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
    };
    let coupled = CoupledParams::new(vec![[0.15; 3]; 2]).with_device_inertia(vec![[4e-5; 3]; 2]);
    let method = match method % 3 {
        0 => BasicParams::default().into(),
        1 => VirtualCouplingParams {
            stiffness: vec![3000.0; 2],
            damping: vec![2.0; 2],
            mass: vec![0.05; 2],
            rotational_stiffness: vec![1.0; 2],
            rotational_damping: vec![1e-3; 2],
            inertia: vec![1e-5; 2],
        }
        .into(),
        _ => coupled.into(),
    };
    let starts = vec![[-0.005, 0.0, 0.0065], [0.025, 0.0, 0.0245]];
    (world, starts, method)
}

impl Target {
    /// Creates a random target; `guarded` returns its guard.
    fn random(
        random: &mut Random,
        number: usize,
        guarded: impl Fn(WorldGuardParams) -> WorldGuard,
    ) -> Self {
        let is_corner = !number.is_multiple_of(3);
        let period = if is_corner {
            1.0 / (100.0 * 40f64.powf(random.unit()))
        } else {
            0.002
        };
        let (world, starts, method) = if is_corner {
            let kappa = 0.01 * 40f64.powf(random.unit());
            corner(kappa * 0.2 / (period * period), number / 3)
        } else {
            crowd(number / 3)
        };
        let whole = random.below(6) as f64;
        let kind = random.below(4);
        let delay = [
            0.0,
            whole,
            random.between(0.0, 6.0),
            random.between(0.0, 2.0),
        ][kind];
        // A lag mixes commands, whose balances differ if a body moves.
        let lag = if is_corner && kind == 3 {
            random.between(0.0, 2.0)
        } else {
            0.0
        };
        let quantum = if random.below(2) == 0 {
            0.0
        } else {
            1e-6 * 50f64.powf(random.unit())
        };
        let guard = WorldGuardParams {
            quantum,
            recovery: [0.0, 0.01][random.below(2)],
            hand: Some(HAND),
            ..WorldGuardParams::by_speed(SPEED, TURNING, ALLOWANCE)
        };
        let actuation = Actuation::after(delay * period)
            .with_lag(lag * period)
            .with_gain([1.0, random.between(0.5, 2.0)][random.below(2)]);
        let mut loop_params = WorldLoop::new(period)
            .with_actuation(actuation)
            .with_guard(guarded(guard));
        let mut second = 1.0;
        if !is_corner && (number / 9).is_multiple_of(2) {
            second = 4.0;
            let heavy = HAND.least_mass.map(|mass| second * mass);
            loop_params = loop_params.with_guard_masses(vec![HAND.least_mass, heavy]);
        }
        Self {
            name: method.name(),
            renderer: WorldRenderer::new(&world, loop_params, method).unwrap(),
            starts,
            period,
            actuation,
            guard,
            second,
        }
    }

    /// Returns the largest energy that the attack extracts beyond the energy put in and a `credit` `[W]` `[J]`, and the
    /// number of intervals beyond the bound that the guard saw.
    fn taken_by(&self, attack: &Attack, credit: f64) -> (f64, u32) {
        let Actuation {
            delay, lag, gain, ..
        } = self.actuation;
        let tools = self.starts.len();
        let lighter = 1.0 / self.second.sqrt();
        let lighter = Matrix4::from_diagonal(&Four::new(lighter, lighter, lighter, 1.0));
        let mobility = [attack.mobility[0], lighter * attack.mobility[1] * lighter];
        let mut state = self.renderer.start();
        let mut devices: Vec<Device> = (0..tools)
            .map(|tool| {
                let [x, y, z] = self.starts[tool];
                Device {
                    place: Four::new(x, y, z, 0.0),
                    velocity: attack.velocities[tool],
                    felt: Four::zeros(),
                }
            })
            .collect();
        let (mut commands, mut begun) = (Vec::new(), 0);
        let (mut aim, mut available) = ([Four::zeros(); TOOLS], 0.0f64);
        let (mut given_out, mut worst, mut beyond) = (0.0, f64::NEG_INFINITY, 0);
        let quantum = self.guard.quantum;
        let hand = self
            .renderer
            .loop_params()
            .guard
            .params()
            .and_then(|params| params.hand);
        // The wrench of a hand with a largest force, relative to the acceleration of the attack.
        let exerts = match hand.map(|hand| hand.limit) {
            Some(WorldHandLimit::Force { force, torque }) => {
                let linear = force / ACCELERATION;
                Some(Four::new(linear, linear, linear, torque / ANGULAR))
            }
            _ => None,
        };
        for i in 0..LENGTH {
            let positions: Vec<Vector> = devices
                .iter()
                .map(|device| {
                    let seen = |x: f64| match quantum > 0.0 {
                        true => (x / quantum + attack.phase).round() * quantum,
                        false => x,
                    };
                    device.place.xyz().map(seen).into()
                })
                .collect();
            let half = 0.5 * devices[0].place.w;
            let turns = [[half.cos(), half.sin(), 0.0, 0.0], IDENTITY];
            let sample = Sample::at(&positions).turned(&turns[..tools]);
            let output = self.renderer.step(&mut state, &sample);
            if output.fault.is_some() {
                // The world cannot be computed: its bodies are reset, and a different world follows.
                break;
            }
            beyond += u32::from(output.limited.beyond_guard);
            let mut sent = [Four::zeros(); TOOLS];
            for (tool, sent) in sent.iter_mut().enumerate().take(tools) {
                let [x, y, z] = output.forces[tool];
                *sent = Four::new(x, y, z, output.torques[tool][0]) * gain;
            }
            let ledger = state.ledger();
            let potential: f64 = ledger.bodies.iter().map(|entry| entry.potential).sum();
            let lost: f64 = ledger.contacts.iter().map(|entry| entry.dissipated).sum();
            commands.push((sent, -potential - lost));
            for part in 0..PARTS {
                let at = |n: usize| (i as f64 + n as f64 / PARTS as f64) * self.period;
                let (mut now, end) = (at(part), at(part + 1));
                while now < end - 1e-9 * self.period {
                    let begins = |k: usize| k as f64 * self.period + delay;
                    while begun <= i && begins(begun) <= now + 1e-9 * self.period {
                        // Energy put in up to the sample of the force, or already given out.
                        aim = commands[begun].0;
                        available = commands[begun].1.max(given_out - ALLOWANCE - credit * now);
                        begun += 1;
                    }
                    let mut until = end;
                    if begun <= i && begins(begun) < end - 1e-9 * self.period {
                        until = begins(begun);
                    }
                    for (tool, device) in devices.iter_mut().enumerate() {
                        let mobility = &mobility[tool];
                        let by_hand = &attack.accelerations[i * PARTS + part][tool];
                        let by_hand = match exerts {
                            Some(exerts) => mobility * by_hand.component_mul(&exerts),
                            None => *by_hand,
                        };
                        given_out += device.moves(mobility, &by_hand, &aim[tool], lag, until - now);
                    }
                    now = until;
                    if devices.iter().any(Device::is_too_fast) {
                        return (worst, beyond);
                    }
                    if devices.iter().any(|device| device.felt != Four::zeros()) {
                        worst = worst.max(given_out - available - credit * now);
                    }
                }
            }
        }
        (worst, beyond)
    }

    /// Returns the best of attacks that are improved in `tries` steps, and the intervals beyond the bound.
    fn attacked(
        &self,
        random: &mut Random,
        attempt: usize,
        tries: usize,
        credit: f64,
    ) -> (f64, u32) {
        let mut attack = Attack::begun(random, attempt);
        let (mut taken, mut beyond) = self.taken_by(&attack, credit);
        for _ in 0..tries {
            let other = attack.changed(random);
            let (by_other, seen) = self.taken_by(&other, credit);
            beyond += seen;
            if by_other >= taken {
                (attack, taken) = (other, by_other);
            }
        }
        (taken, beyond)
    }
}

/// Number of loops: 36 times `PALPATE_ATTACKS`, which is 1 unless set for a campaign.
fn loops() -> usize {
    36 * std::env::var("PALPATE_ATTACKS").map_or(1, |count| count.parse::<usize>().unwrap())
}

#[test]
fn hands_within_acceleration_bound_take_no_more_than_allowance() {
    let most = attacked_by_all(HAND.limit);
    // The bound is nearly reached, so the guard is not too strict.
    assert!(most > 0.8 * ALLOWANCE, "{most} J");
}

/// The force accelerates each device by its own mobility, whose rotation couples with its translation.
#[test]
fn hands_within_force_bound_take_no_more_than_allowance() {
    attacked_by_all(WorldHandLimit::Force {
        force: FORCE,
        torque: TORQUE,
    });
}

/// Returns the largest energy that hands within a limit take `[J]`, and fails if it exceeds the allowance.
fn attacked_by_all(limit: WorldHandLimit) -> f64 {
    let mut random = Random(5);
    let guarded = |guard| {
        let hand = Some(WorldHandBound { limit, ..HAND });
        WorldGuard::Limit(WorldGuardParams { hand, ..guard })
    };
    let (mut most, mut over) = (f64::NEG_INFINITY, String::new());
    for number in 0..loops() {
        let target = Target::random(&mut random, number, guarded);
        let credit = target.guard.recovery;
        let (taken, beyond) = target.attacked(&mut random, number / 3, 60, credit);
        if taken > ALLOWANCE * (1.0 + 1e-9) || beyond > 0 {
            let Target {
                name,
                period,
                actuation,
                guard,
                ..
            } = target;
            writeln!(
                over,
                "{number}, {name} at {period} s, {actuation:?}, {} m: {taken} J, {beyond} beyond",
                guard.quantum
            )
            .unwrap();
        }
        most = most.max(taken);
    }
    println!("{most} J");
    assert!(over.is_empty(), "over:\n{over}");
    most
}

/// The attack is effective: it takes more without a limit, and from a guard with a wrong quantum.
#[test]
fn the_same_hands_take_more_without_a_limit() {
    let largest = |guarded: &dyn Fn(WorldGuardParams) -> WorldGuard| {
        let mut random = Random(5);
        let taken = (0..36).map(|number| {
            let target = Target::random(&mut random, number, guarded);
            target.attacked(&mut random, number / 3, 30, 0.0).0
        });
        taken.fold(f64::NEG_INFINITY, f64::max)
    };
    let open = largest(&WorldGuard::Report);
    let fine = largest(&|guard| {
        WorldGuard::Limit(WorldGuardParams {
            quantum: 0.0,
            ..guard
        })
    });
    println!("{open} J, a fine sensor {fine} J");
    assert!(open > 20.0 * ALLOWANCE, "{open} J");
    assert!(fine > 2.0 * ALLOWANCE, "{fine} J");
}

/// Least masses of each device that equal the common one change nothing, and a heavier device gets more force, also if
/// they are set while the world runs.
#[test]
fn each_device_has_its_own_least_mass() {
    let held = |masses: Vec<Vector>, later: Option<Vec<Vector>>| {
        let (world, starts, method) = crowd(0);
        let guard = WorldGuardParams {
            hand: Some(HAND),
            ..WorldGuardParams::by_speed(SPEED, TURNING, ALLOWANCE)
        };
        let loop_params = WorldLoop::new(0.002).with_guard(WorldGuard::Limit(guard));
        let with = |masses| {
            let loop_params = loop_params.clone().with_guard_masses(masses);
            WorldRenderer::new(&world, loop_params, method.clone()).unwrap()
        };
        let mut renderer = with(masses);
        let mut state = renderer.start();
        let mut forces = Vec::new();
        for tick in 0..200 {
            if let (20, Some(masses)) = (tick, &later) {
                let mut next = with(masses.clone());
                let succession = next.migrate(&renderer, &[]).unwrap();
                let mut resumed = next.start();
                next.resume(&mut resumed, (&renderer, &state), &succession);
                (renderer, state) = (next, resumed);
            }
            let down = 2e-3 * (1.0 - (0.08 * f64::from(tick)).cos());
            let positions: Vec<Vector> =
                starts.iter().map(|[x, y, z]| [*x, *y, z - down]).collect();
            let turns = [IDENTITY; TOOLS];
            let output = renderer.step(&mut state, &Sample::at(&positions).turned(&turns));
            forces.extend_from_slice(output.forces);
        }
        forces
    };
    let common = held(Vec::new(), None);
    assert_eq!(common, held(vec![HAND.least_mass; TOOLS], None));
    let heavier = vec![HAND.least_mass, HAND.least_mass.map(|mass| 10.0 * mass)];
    for heavier in [held(heavier.clone(), None), held(Vec::new(), Some(heavier))] {
        // Up to the first difference the bodies have moved alike.
        let differ = common
            .iter()
            .zip(&heavier)
            .find(|(one, other)| one != other);
        let (less, more) = differ.expect("a guard that acts");
        let [less, more] = [less, more].map(|force| Vector3::from(*force).norm());
        println!("{less} N, {more} N");
        assert!(more > less, "{less} N, {more} N");
    }
}
