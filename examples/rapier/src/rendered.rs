//! The tool of a scene in a loop with Rapier: what pushes it is the engine's own contact, or palpate's.

use std::f64::consts::TAU;
use std::time::Instant;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::{
    CheckedIdeal, PlantParams, Vector as Numbers, WorldEvaluation, WorldIdeal, WorldPlant,
};
use palpate_world::{ContactLaw, CoupledParams, WorldLoop};
use rapier3d_f64::prelude::*;

use crate::contact::Contact;
use crate::scenes::{BODY_MASS, DEVICE_MASS, DURATION, GRAVITY, HALF, Scene};

/// How the engine's own contact of the tool is set.
#[derive(Clone, Copy, Debug, Default)]
pub struct Own {
    /// Damping of the contact over its critical damping against a body that does not turn.
    pub damping_ratio: f64,
    /// Whether the tool continues over a period with the motion of the last one, instead of resting at its sampled
    /// position.
    pub moves: bool,
}

/// Result of one rendering method in a scene.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Mean-force error E `[%]`.
    pub error: f64,
    /// FRE over the hold bound, 1 at best.
    pub over_bound: f64,
    /// Median time of a step of the engine with the contact `[s]`.
    pub step: f64,
}

/// A scene with its ideal.
pub struct Bench {
    scene: Scene,
    ideal: WorldIdeal,
    /// Steps of the engine in a period, and parts into which the engine divides each.
    steps: u32,
    parts: usize,
}

impl Bench {
    /// Solves the ideal of a scene that is run with so many `steps` of the engine in a period, each of which the engine
    /// divides into so many `parts`.
    ///
    /// # Errors
    /// The scene has no ideal over its whole window.
    pub fn new(scene: Scene, steps: u32, parts: usize) -> Result<Self, String> {
        let name = scene.name;
        let grid = Grid::even(0.0, scene.period, samples(&scene));
        let checked = CheckedIdeal::new(&scene.evaluated, grid);
        let checked = checked.map_err(|error| format!("{name}: the ideal: {error}"))?;
        if let Some(time) = checked.chaotic_from {
            return Err(format!("{name}: the ideal is unknown from {time} s on"));
        }
        Ok(Self {
            scene,
            ideal: checked.ideal,
            steps,
            parts,
        })
    }

    /// Evaluates the engine's own contact.
    ///
    /// # Errors
    /// The forces cannot be evaluated.
    pub fn engine(&self, own: Own) -> Result<Outcome, String> {
        let mut engine = Engine::new(&self.scene, self.steps, self.parts);
        let tool = engine.put_tool(&self.scene, own.damping_ratio);
        let (steps, mut last) = (f64::from(self.steps), self.scene.start);
        self.evaluated(|position| {
            let way = std::array::from_fn(|axis| {
                if own.moves {
                    position[axis] - last[axis]
                } else {
                    0.0
                }
            });
            last = position;
            let mut mean = [0.0; 3];
            for part in 0..self.steps {
                let share = f64::from(part) / steps;
                let force = engine.step(&tool, way_on(position, way, share));
                for (sum, force) in mean.iter_mut().zip(force) {
                    *sum += force / steps;
                }
            }
            mean
        })
    }

    /// Evaluates palpate's contact in the same engine. `model` is the model mass of the device over the true one.
    ///
    /// # Errors
    /// palpate rejects the scene, or the forces cannot be evaluated.
    pub fn palpate(&self, model: f64) -> Result<Outcome, String> {
        let scene = &self.scene;
        let mut engine = Engine::new(scene, self.steps, self.parts);
        let law = ContactLaw::spring(scene.stiffness);
        let device = CoupledParams::new(vec![DEVICE_MASS.map(|mass| model * mass)]);
        let loop_params = WorldLoop::new(scene.period);
        let bodies = [engine.body];
        let mut contact = Contact::new(
            &engine.world,
            scene.tool_radius,
            &bodies,
            law,
            loop_params,
            device,
        )?;
        self.evaluated(|position| {
            contact.sample(position);
            for _ in 0..self.steps {
                contact.push(&mut engine.world);
                engine.advance();
                contact.pull(&mut engine.world);
            }
            contact.hold()
        })
    }

    /// Runs the loop with the force that `force` returns for each position of the device `[m]`, and evaluates it.
    fn evaluated(&self, mut force: impl FnMut(Numbers) -> Numbers) -> Result<Outcome, String> {
        let scene = &self.scene;
        let wrong = |error: &dyn std::fmt::Display| format!("{}: {error}", scene.name);
        let params = PlantParams::perfect(scene.period);
        let mut device =
            WorldPlant::new(&scene.evaluated, params).map_err(|error| wrong(&error))?;
        let count = samples(scene);
        let (mut held, mut times) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            let begin = Instant::now();
            let now = force(device.measure()[0]);
            times.push(begin.elapsed().as_secs_f64() / f64::from(self.steps));
            held.push(now);
            device.hold(&[now]);
        }
        times.sort_by(f64::total_cmp);
        let evaluation = WorldEvaluation::new(&scene.evaluated, &self.ideal, &[held]);
        let evaluation = evaluation.map_err(|error| wrong(&error))?;
        let sum = evaluation
            .sum
            .ok_or_else(|| wrong(&"the tool has no contact"))?;
        Ok(Outcome {
            error: sum.mean_force_error,
            over_bound: sum.error_over_bound.unwrap_or(f64::INFINITY),
            step: times[count / 2],
        })
    }
}

fn samples(scene: &Scene) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "40 to 400"
    )]
    let samples = (DURATION / scene.period).round() as usize;
    samples
}

fn way_on(position: Numbers, way: Numbers, share: f64) -> Vector {
    Vector::from_array(position) + Vector::from_array(way) * share
}

/// Makes the contact with the floor a spring.
///
/// The stiffness of the engine's contact is a squared rate times the effective mass at a point, which changes as a box
/// tilts. The depth of each point is therefore scaled to give the point its share of the floor's stiffness. The engine
/// also keeps points for a while after they part, and stops approaching points at the surface, unlike a spring; those
/// points are removed.
struct SpringFloor {
    /// Points that share the floor's stiffness.
    shares: f64,
}

impl PhysicsHooks for SpringFloor {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let (Some(handle), None) = (context.rigid_body2, context.rigid_body1) else {
            return;
        };
        let body = &context.bodies[handle];
        let (centre, answers) = (body.center_of_mass(), body.mass_properties());
        let (inverse_mass, inverse_inertia) = (
            answers.effective_inv_mass.z,
            answers.effective_world_inv_inertia,
        );
        let Some(contacts) = context.rigid_mut() else {
            return;
        };
        let normal = *contacts.normal;
        contacts.solver_contacts.retain(|point| point.dist <= 0.0);
        for point in contacts.solver_contacts.iter_mut() {
            let torque = (point.anchor2 - centre).cross(normal);
            let answer = inverse_mass + torque.dot(inverse_inertia * torque);
            point.dist *= answer / inverse_mass / self.shares;
        }
    }
}

/// Body and floor of a scene in the engine.
struct Engine {
    world: PhysicsWorld,
    body: RigidBodyHandle,
    floor: SpringFloor,
}

/// The tool in the engine.
struct OwnTool {
    body: RigidBodyHandle,
    collider: ColliderHandle,
}

impl Engine {
    fn new(scene: &Scene, steps: u32, parts: usize) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, 0.0, -GRAVITY);
        let params = &mut world.integration_parameters;
        params.dt = scene.period / f64::from(steps);
        params.num_solver_iterations = parts;
        // Make a contact a pure spring and damper: no prediction before the contact, no stabilisation after each part
        // of a step, no limit of the correcting speed. Solve to convergence.
        params.normalized_prediction_distance = 0.0;
        params.num_internal_stabilization_iterations = 0;
        params.normalized_max_corrective_velocity = Real::MAX;
        params.num_internal_pgs_iterations = 50;
        params.contact_recycling = false;
        if let Some((stiffness, damping)) = scene.floor {
            params.static_contact_softness = spring(params, stiffness, damping, BODY_MASS);
        }
        // Insert the floor first: the engine keeps the normal of a contact for a while, in the axes of its first
        // collider.
        if scene.floor.is_some() {
            let slab = ColliderBuilder::cuboid(1.0, 1.0, 0.1);
            let slab = slab.translation(Vector::new(0.0, 0.0, -0.1)).friction(0.0);
            let slab = slab.active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
            world.insert_collider(slab, None);
        }
        let body = RigidBodyBuilder::dynamic()
            .translation(Vector::from_array(scene.place))
            .can_sleep(false);
        let body = world.insert_body(body);
        let shape = if scene.is_box {
            ColliderBuilder::cuboid(HALF, HALF, HALF)
        } else {
            ColliderBuilder::ball(HALF)
        };
        world.insert_collider(shape.mass(BODY_MASS).friction(0.0), Some(body));
        // The engine computes masses at a step. No time passes in this one.
        let dt = std::mem::take(&mut world.integration_parameters.dt);
        world.step();
        world.integration_parameters.dt = dt;
        // A box that lies flat has a point at each corner.
        let shares = if scene.is_box { 4.0 } else { 1.0 };
        Self {
            world,
            body,
            floor: SpringFloor { shares },
        }
    }

    /// Makes a step.
    fn advance(&mut self) {
        self.world.step_with_events(&self.floor, &());
    }

    /// Puts the tool there, with the engine's own contact.
    fn put_tool(&mut self, scene: &Scene, damping_ratio: f64) -> OwnTool {
        // A box gives way at the place of the tool more than its mass says, as it turns.
        let [x, y, _] = scene.start;
        let lever = if scene.is_box { x * x + y * y } else { 0.0 };
        let mass = BODY_MASS / (1.0 + lever / (2.0 / 3.0 * HALF * HALF));
        let damping = damping_ratio * 2.0 * (scene.stiffness * BODY_MASS).sqrt();
        let params = &mut self.world.integration_parameters;
        params.contact_softness = spring(params, scene.stiffness, damping, mass);
        let start = Vector::from_array(scene.start);
        let body = RigidBodyBuilder::kinematic_position_based().translation(start);
        let body = self.world.insert_body(body);
        let ball = ColliderBuilder::ball(scene.tool_radius).friction(0.0);
        let collider = self.world.insert_collider(ball, Some(body));
        OwnTool { body, collider }
    }

    /// Puts the tool at a place, makes a step, and gives the force on the tool in it `[N]`.
    fn step(&mut self, tool: &OwnTool, place: Vector) -> Numbers {
        self.world.bodies[tool.body].set_translation(place, true);
        self.advance();
        let mut force = Vector::ZERO;
        for pair in self.world.narrow_phase.contact_pairs_with(tool.collider) {
            // A normal points from the first collider to the second, which is pushed along it.
            let side = if pair.collider1 == tool.collider {
                -1.0
            } else {
                1.0
            };
            for manifold in pair.manifolds() {
                let impulses = manifold.points.iter().map(|point| point.data.impulse);
                force += manifold.data.normal * (side * impulses.sum::<Real>());
            }
        }
        (force / self.world.integration_parameters.dt).to_array()
    }
}

/// Returns a spring `[N/m]` and damper `[N s/m]` between a fixed body and one of this `mass` `[kg]` at the contact
/// point.
///
/// The engine evaluates the spring at the end of a part of the step, which adds a damping of the part's length times
/// the stiffness. The damping is reduced by that amount, down to 0.
fn spring(
    params: &IntegrationParameters,
    stiffness: f64,
    damping: f64,
    mass: f64,
) -> SpringCoefficients<Real> {
    let part = params.dt / params.num_solver_iterations as f64;
    let rate = (stiffness / mass).sqrt();
    let model = (damping - part * stiffness).max(0.0);
    SpringCoefficients::new(rate / TAU, model / (2.0 * rate * mass))
}
