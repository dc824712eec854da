//! The simplest loops in random worlds: the spring force at the sample, alone and with the best damper.
//!
//! The loop is implemented here independently, for spheres and planes only, to test the evaluation.

use palpate_testbed::world::random_worlds::{RandomHands, RandomWorld, WorldKind, random_worlds};
use palpate_testbed::world::{
    Member, PlantParams, Shape, Tool, Vector, WorldEvaluation, WorldPlant, WorldScene,
};

const PERIOD: f64 = 0.001;
const QUANTUM: f64 = 2e-6;
const PARTS: usize = 10;

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// a + s b
fn add(a: Vector, s: f64, b: Vector) -> Vector {
    std::array::from_fn(|axis| a[axis] + s * b[axis])
}

/// The balls of a scene, moved by springs, with the tool held in place.
struct Balls<'a> {
    scene: &'a WorldScene,
    radii: Vec<f64>,
    places: Vec<Vector>,
    velocities: Vec<Vector>,
    /// Deflection of the tool's bristle on each plane.
    bristles: Vec<Vector>,
}

impl<'a> Balls<'a> {
    fn new(scene: &'a WorldScene) -> Self {
        let mut radii = vec![match scene.devices[0].tool {
            Tool::Solid(Shape::Sphere { radius }) => radius,
            _ => panic!("a sphere"),
        }];
        let mut places = vec![scene.devices[0].position];
        for body in &scene.bodies {
            radii.push(match body.shape {
                Shape::Sphere { radius } => radius,
                _ => 0.0,
            });
            places.push(body.position);
        }
        Self {
            scene,
            velocities: vec![[0.0; 3]; places.len()],
            bristles: vec![[0.0; 3]; places.len()],
            places,
            radii,
        }
    }

    fn place_of(member: Member) -> usize {
        match member {
            Member::Device(_) => 0,
            Member::Body(number) => number + 1,
        }
    }

    /// Forces on all spheres; `moved` is what the tool has moved by since the last sample, for the bristles.
    fn forces(&mut self, moved: Option<Vector>) -> Vec<Vector> {
        let mut forces = vec![[0.0; 3]; self.places.len()];
        for pair in &self.scene.pairs {
            let [one, other] = pair.between.map(Self::place_of);
            let law = &pair.law;
            match self.scene.bodies[other - 1].shape {
                Shape::HalfSpace { normal, offset } => {
                    let p = self.radii[one] + offset - dot(normal, self.places[one]);
                    let z = &mut self.bristles[other];
                    if p <= 0.0 {
                        if one == 0 {
                            *z = [0.0; 3];
                        }
                        continue;
                    }
                    forces[one] = add(forces[one], law.stiffness * p, normal);
                    if one == 0 && law.friction > 0.0 {
                        if let Some(moved) = moved {
                            *z = add(*z, 1.0, add(moved, -dot(moved, normal), normal));
                        }
                        let largest = law.friction * law.stiffness * p / law.friction_stiffness;
                        let length = dot(*z, *z).sqrt();
                        if length > largest {
                            *z = z.map(|part| part * largest / length);
                        }
                        forces[0] = add(forces[0], -law.friction_stiffness, *z);
                    }
                }
                _ => {
                    let apart = add(self.places[one], -1.0, self.places[other]);
                    let distance = dot(apart, apart).sqrt();
                    let p = self.radii[one] + self.radii[other] - distance;
                    if p > 0.0 {
                        forces[one] = add(forces[one], law.stiffness * p / distance, apart);
                        forces[other] = add(forces[other], -law.stiffness * p / distance, apart);
                    }
                }
            }
        }
        forces
    }

    /// Moves the balls over a period by velocity Verlet.
    fn advance(&mut self) {
        let step = PERIOD / PARTS as f64;
        let kick = |balls: &mut Self, forces: &[Vector]| {
            for (number, body) in balls.scene.bodies.iter().enumerate() {
                if let Some(motion) = &body.motion {
                    let push = add(forces[number + 1], 1.0, motion.force);
                    let v = &mut balls.velocities[number + 1];
                    *v = add(*v, 0.5 * step / motion.mass, push);
                }
            }
        };
        for _ in 0..PARTS {
            let forces = self.forces(None);
            kick(self, &forces);
            for number in 1..self.places.len() {
                self.places[number] = add(self.places[number], step, self.velocities[number]);
            }
            let forces = self.forces(None);
            kick(self, &forces);
        }
    }
}

/// E [%] of the spring force at the sample, less `damping` [N s/m] times the backward difference in contact.
fn error(world: &RandomWorld, damping: f64) -> f64 {
    let mut scene = world.scene.clone();
    scene.devices[0].quantum = [QUANTUM; 3];
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(PERIOD)).unwrap();
    let mut balls = Balls::new(&scene);
    let mut before = plant.measure()[0];
    for _ in 0..world.ideal.grid.intervals() {
        let now = plant.measure()[0];
        let moved = add(now, -1.0, before);
        before = now;
        balls.places[0] = now;
        let mut force = balls.forces(Some(moved))[0];
        balls.advance();
        if dot(force, force) > 0.0 {
            force = add(force, -damping / PERIOD, moved);
        }
        plant.hold(&[force]);
    }
    let held = [plant.delivered(0)];
    let evaluation = WorldEvaluation::new(&scene, &world.ideal, &held).unwrap();
    evaluation.sum.unwrap().mean_force_error.min(999.0)
}

fn spread(mut errors: Vec<f64>) -> [f64; 3] {
    errors.sort_by(f64::total_cmp);
    let last = errors.len() - 1;
    [
        errors[errors.len() / 2],
        errors[errors.len() * 9 / 10],
        errors[last],
    ]
}

#[test]
fn a_sampled_spring_is_far_from_the_ideal_and_its_best_damper_less_far() {
    let worlds = random_worlds(RandomHands::Springs, 60, PERIOD, 11).unwrap();
    for kind in WorldKind::ALL {
        let count = worlds.iter().filter(|world| world.kind == kind).count();
        println!("{kind:?}: {count} scenes");
        assert!(count >= 3);
    }
    let spring = spread(worlds.iter().map(|world| error(world, 0.0)).collect());
    let best = |world: &RandomWorld| {
        let dampers = (0..30).map(|i| 0.02 * 200_f64.powf(f64::from(i) / 29.0));
        let tried = [0.0].into_iter().chain(dampers);
        tried
            .map(|share| error(world, share * world.stiffness * PERIOD))
            .fold(f64::INFINITY, f64::min)
    };
    let damper = spread(worlds.iter().map(best).collect());
    println!(
        "E, median / 90 % / largest: spring {spring:.0?}, best damper of each scene {damper:.0?}"
    );
    assert!(spring[0] > 50.0 && spring[0] < 110.0);
    assert!(damper[0] < 0.8 * spring[0]);
    assert!(damper[0] > 15.0);
}

#[test]
fn random_worlds_follow_from_their_seed_and_have_ideals() {
    let worlds = random_worlds(RandomHands::Springs, 8, 0.004, 3).unwrap();
    assert_eq!(
        worlds,
        random_worlds(RandomHands::Springs, 8, 0.004, 3).unwrap()
    );
    assert_ne!(
        worlds[0].scene,
        random_worlds(RandomHands::Springs, 8, 0.004, 4).unwrap()[0].scene
    );
    for (number, world) in worlds.iter().enumerate() {
        let device = &world.scene.devices[0];
        assert_eq!(device.hand.stiffness, [60.0, 300.0][number % 2]);
        let model = world.model_mass[1] / device.mass[1];
        assert!((model - [1.5, 0.67][number / 2 % 2]).abs() < 1e-12);
        assert!(world.ideal.grid.end() <= 0.3 + 1e-9);
        assert!(!world.ideal.touches_of(0).is_empty());
        assert!(world.scene.pairs.iter().all(|pair| pair.law.damping > 0.0));
    }
}
