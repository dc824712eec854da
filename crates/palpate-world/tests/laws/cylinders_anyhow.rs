//! Random collisions of cylinders, boxes, hulls and balls of any size and weight: ledger, faults and determinism.

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Motion, Party, Sample, Shape,
    Tool, Vector, World, WorldLoop, WorldMethod, WorldRenderer, WorldState,
};

use crate::balance::{Balance, of_bodies};
use crate::common::{plane, world};
use crate::hulls::{box_of, stone};
use crate::tumbling::turned;

fn cylinder(radius: f64, half_length: f64) -> Shape {
    Shape::Cylinder {
        radius,
        half_length,
    }
}

/// Random numbers of a case.
struct Numbers(u64);

impl Numbers {
    /// Returns a number from 0 to 1.
    fn next(&mut self) -> f64 {
        let grown = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = grown.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> Vector {
        [0; 3].map(|_| size * (2.0 * self.next() - 1.0))
    }

    /// Returns a log-uniform number from `least` to `most`.
    fn between(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(self.next())
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    /// Returns a shape: more than half are cylinders, including discs and needles.
    fn shape(&mut self) -> Shape {
        let size = self.between(0.003, 0.03);
        match self.below(7) {
            0 => Shape::Sphere { radius: size },
            1 => box_of([size, size * self.between(0.2, 2.0), size]),
            2 => stone(self.below(1000) as u32, 5 + self.below(4) as u32),
            3 => cylinder(size, self.between(1e-4, 0.03)),
            4 => cylinder(self.between(1e-4, 0.03), size),
            _ => cylinder(size, size * self.between(0.3, 3.0)),
        }
    }

    fn body(&mut self, number: usize) -> Body {
        let mass = self.between(0.01, 1.0);
        let place = self.vector(0.05);
        let aside = self.vector(0.2);
        let free = Free {
            velocity: [0, 1, 2].map(|axis| aside[axis] - 5.0 * place[axis]),
            angular_velocity: self.vector(20.0),
            ..Free::of_mass(mass).pulled_by([0.0, 0.0, -9.81 * mass])
        };
        let shape = self.shape();
        let body = Body::new(&*format!("b{number}"), shape, Motion::Free(free))
            .at([place[0], place[1], place[2] + 0.06])
            .balanced();
        // A quarter of them have parallel axes.
        if self.below(4) == 0 {
            return body;
        }
        let [a, b, c] = self.vector(1.0);
        body.turned(turned(a, b, c))
    }

    /// Returns two to four bodies, a tool that turns and usually a floor, with as many pairs as the contact points
    /// allow.
    fn world(&mut self) -> World {
        let mut law = ContactLaw::spring(self.between(500.0, 50_000.0));
        if self.below(3) > 0 {
            law = law.with_damping(self.between(0.01, 20.0));
            law = law.with_friction((1.3 * self.next() - 0.3).max(0.0));
        }
        let mut bodies: Vec<Body> = (0..2 + self.below(3))
            .map(|number| self.body(number))
            .collect();
        if self.below(3) > 0 {
            bodies.push(plane("floor", [0.0, 0.0, 1.0]));
        }
        let tool = match self.below(3) {
            0 => Shape::Sphere { radius: 0.005 },
            1 => cylinder(0.01, 0.02),
            _ => cylinder(0.02, 0.001),
        };
        let mut world = world(0.005, bodies, law);
        world.tools = vec![Tool::new("tool", tool).turning()];
        let has = |name: &str| name == "tool" || world.bodies.iter().any(|body| body.name == name);
        let pairs = [
            ["tool", "b0"],
            ["b0", "b1"],
            ["b1", "b2"],
            ["b2", "b3"],
            ["floor", "b0"],
            ["floor", "b1"],
            ["floor", "b2"],
        ];
        let there = pairs
            .into_iter()
            .filter(|pair| pair.iter().all(|name| has(name)));
        let contacts = there.take(6).map(|pair| Contact {
            between: pair.map(|name| Party::Named(name.into())),
            law,
        });
        world.contacts = contacts.collect();
        world
    }
}

/// Outcome of a run.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Debug)]
enum Went {
    /// The sub-steps resolved the motion.
    Well,
    /// The motion was reported as too fast for the sub-steps.
    TooFast,
    Fault,
}

/// Returns the final state. A fault must be preceded by a report that the world is too fast.
fn run(world: &World, period: f64, method: WorldMethod, case: u32) -> (WorldState, Went) {
    let renderer = WorldRenderer::new(world, WorldLoop::new(period), method).unwrap();
    let mut state = renderer.start();
    let mut went = Went::Well;
    for sample in 0..(0.4 / period) as u32 {
        let a = 3.0 * f64::from(sample) * period + f64::from(case);
        let height = 0.05 + 0.04 * (4.0 * a).sin();
        let positions = [[0.03 * (7.0 * a).sin(), 0.03 * (5.0 * a).cos(), height]];
        let orientations = [turned((2.0 * a).sin(), (3.0 * a).cos(), 0.3)];
        let sample = Sample::at(&positions).turned(&orientations);
        let output = renderer.step(&mut state, &sample);
        if output.effort.too_fast {
            went = Went::TooFast;
        }
        if output.fault.is_some() {
            assert_eq!(went, Went::TooFast, "{case}: {:?} {world:?}", output.fault);
            return (state, Went::Fault);
        }
        let mut numbers = output.forces[0].iter().chain(&output.torques[0]);
        assert!(numbers.all(|x| x.is_finite()), "{case}: {world:?}");
    }
    (state, went)
}

#[test]
fn ledger_of_random_cylinder_worlds_closes() {
    let (mut met, mut followed, mut worst) = (0, 0, [0.0_f64; 2]);
    for case in 0..90 {
        let mut numbers = Numbers(7919 * u64::from(case) + 17);
        let world = numbers.world();
        let period = [0.001, 0.004, 0.01][case as usize % 3];
        let method: WorldMethod = if case % 2 == 0 {
            let coupled = CoupledParams::new(vec![[0.2; 3]]);
            coupled.with_device_inertia(vec![[1e-4; 3]]).into()
        } else {
            BasicParams::default().into()
        };
        let renderer = WorldRenderer::new(&world, WorldLoop::new(period), method.clone()).unwrap();
        let start = of_bodies(&renderer.start());
        let (state, went) = run(&world, period, method.clone(), case);
        let (again, _) = run(&world, period, method, case);
        assert_eq!(state.bodies(), again.bodies(), "{case}");
        if went == Went::Fault {
            continue;
        }
        let balance = Balance::since(start, &state);
        let ledger = state.ledger().bodies.iter();
        let has: f64 = ledger
            .map(|entry| entry.kinetic + entry.potential.abs())
            .sum();
        let over = balance.turned_over + has;
        met += u32::from(balance.turned_over > 1e-3);
        let off = balance.contact.max(balance.world.abs()) / over;
        worst[0] = worst[0].max(off);
        assert!(off < 1e-12, "{case}: {off} {balance} {world:?}");
        if went == Went::Well {
            followed += 1;
            let steps = balance.steps.abs() / over;
            worst[1] = worst[1].max(steps);
            assert!(steps < 0.02, "{case}: {balance} {world:?}");
        }
    }
    println!(
        "{met} worlds with hits: books off by {:.1e} of what is turned over; steps {:.1e} of it in the {followed} that they follow",
        worst[0], worst[1]
    );
    assert!(met > 40 && followed > 10, "{met} {followed}");
}
