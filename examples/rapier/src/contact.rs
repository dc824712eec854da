//! Contacts of a tool with bodies that Rapier moves: states out of the engine, forces into it.

use palpate_world::engine::{
    BodyNow, BodyWrench, EngineBody, EngineRenderer, EngineState, PlacedShape, Stepping,
};
use palpate_world::{
    ContactLaw, CoupledParams, Mesh, Sample, Shape, Tool, Vector as Numbers, WorldLoop,
};
use rapier3d_f64::prelude::*;

/// Physics hook that excludes palpate's contact pairs from the engine.
///
/// At least one of the two colliders needs `ActiveHooks::FILTER_CONTACT_PAIRS`; otherwise the engine does not call the
/// hook.
pub struct WithoutTool {
    /// The collider of the tool, which a viewer may show.
    pub tool: ColliderHandle,
}

impl PhysicsHooks for WithoutTool {
    fn filter_contact_pair(&self, pair: &PairFilterContext) -> Option<SolverFlags> {
        let is_of_tool = [pair.collider1, pair.collider2].contains(&self.tool);
        (!is_of_tool).then_some(SolverFlags::default())
    }
}

/// Contacts of a tool with bodies of a [`PhysicsWorld`], in a loop with a device.
///
/// What else accelerates a body, its weight and its other contacts, the engine does not say beforehand: it is taken to
/// go on as it went from the step before the last to the last one.
pub struct Contact {
    renderer: EngineRenderer,
    state: EngineState,
    bodies: Vec<Touched>,
    wrenches: Vec<BodyWrench>,
}

/// A body that the tool touches.
struct Touched {
    handle: RigidBodyHandle,
    /// Force `[N]` and torque `[N m]` that other code has added to the body.
    theirs: (Vector, Vector),
    /// Velocity that it would have after the step if nothing but our wrench acted `[m/s]`, `[rad/s]`.
    expected: (Vector, Vector),
    /// Acceleration by everything else in the last step and in the one before it `[m/s^2]`, `[rad/s^2]`; none before
    /// the first.
    others: Option<[(Vector, Vector); 2]>,
}

impl Contact {
    /// Creates contacts of a sphere of `radius` `[m]` with bodies made of balls, cuboids and convex polyhedrons, by one
    /// `law`.
    ///
    /// # Errors
    /// A collider has another shape, or palpate rejects a value; the text states the reason.
    ///
    /// The number of parts of an engine step is read here; it must not change afterwards.
    pub fn new(
        world: &PhysicsWorld,
        radius: f64,
        bodies: &[RigidBodyHandle],
        law: ContactLaw,
        loop_params: WorldLoop,
        device: CoupledParams,
    ) -> Result<Self, String> {
        let described: Result<Vec<_>, _> = bodies
            .iter()
            .enumerate()
            .map(|(number, handle)| described(world, number, *handle, law))
            .collect();
        let tool = Tool::new("tool", Shape::Sphere { radius });
        // Rapier divides a step, and moves a body by the velocity at the end of each part.
        let parts = world.integration_parameters.num_solver_iterations;
        let stepping = Stepping::Parts(u32::try_from(parts).unwrap_or(u32::MAX));
        let renderer = EngineRenderer::new(&[tool], &described?, stepping, loop_params, device);
        let renderer = renderer.map_err(|faults| faults.to_string())?;
        Ok(Self {
            state: renderer.start(),
            renderer,
            bodies: bodies.iter().map(|handle| Touched::new(*handle)).collect(),
            wrenches: vec![BodyWrench::default(); bodies.len()],
        })
    }

    /// A period begins: takes the position of the device `[m]`.
    pub fn sample(&mut self, position: Numbers) {
        self.renderer
            .sample(&mut self.state, &Sample::at(&[position]));
    }

    /// Adds the wrenches of the contacts to the bodies' present ones. Call it before a step of the engine.
    pub fn push(&mut self, world: &mut PhysicsWorld) {
        let h = world.integration_parameters.dt;
        let now: Vec<BodyNow> = self.bodies.iter().map(|body| body.look(world)).collect();
        self.renderer
            .advance(&mut self.state, h, &now, &mut self.wrenches);
        for (body, wrench) in self.bodies.iter_mut().zip(&self.wrenches) {
            body.push(world, wrench);
        }
    }

    /// After a step of the engine: takes the wrenches off again, and sees what everything else did.
    pub fn pull(&mut self, world: &mut PhysicsWorld) {
        for body in &mut self.bodies {
            body.pull(world);
        }
    }

    /// Puts a wrench of a test on the only body, as [`Contact::push`] puts those of the contacts.
    #[cfg(test)]
    pub fn push_wrench(&mut self, world: &mut PhysicsWorld, force: Numbers, torque: Numbers) {
        self.bodies[0].push(world, &BodyWrench { force, torque });
    }

    /// Returns the mobility of a body in palpate's model.
    #[cfg(test)]
    pub fn mobility(&self, world: &PhysicsWorld, number: usize) -> [[f64; 6]; 6] {
        self.bodies[number].look(world).mobility
    }

    /// The period ends: the force on the device `[N]`, to hold until the next. 0 where the sample could not be used.
    pub fn hold(&mut self) -> Numbers {
        self.renderer.hold(&mut self.state).forces[0]
    }

    /// Returns the proxy position of the tool `[m]`, for a viewer.
    pub fn proxy(&self) -> Numbers {
        self.state.proxies()[0]
    }
}

impl Touched {
    fn new(handle: RigidBodyHandle) -> Self {
        Self {
            handle,
            theirs: (Vector::ZERO, Vector::ZERO),
            expected: (Vector::ZERO, Vector::ZERO),
            others: None,
        }
    }

    /// The body as palpate wants to know it. Its reference point is the centre of mass: the engine takes torques about
    /// it.
    fn look(&self, world: &PhysicsWorld) -> BodyNow {
        let body = &world.bodies[self.handle];
        let turned = body.rotation();
        let mut now = BodyNow::fixed(body.center_of_mass().to_array());
        now.orientation = [turned.w, turned.x, turned.y, turned.z];
        if !body.is_dynamic() {
            return now;
        }
        let weight = world.gravity * body.gravity_scale();
        let (linear, angular) = match self.others {
            Some([last, before]) => (last.0 * 2.0 - before.0, last.1 * 2.0 - before.1),
            None => (weight, Vector::ZERO),
        };
        now.velocity = body.linvel().to_array();
        now.angular_velocity = body.angvel().to_array();
        now.acceleration = linear.to_array();
        now.angular_acceleration = angular.to_array();
        let answers = body.mass_properties();
        for axis in 0..3 {
            now.mobility[axis][axis] = answers.effective_inv_mass[axis];
            let mut unit = [0.0; 3];
            unit[axis] = 1.0;
            let answer = answers.effective_world_inv_inertia * Vector::from_array(unit);
            for other in 0..3 {
                now.mobility[3 + other][3 + axis] = answer[other];
            }
        }
        now
    }

    fn push(&mut self, world: &mut PhysicsWorld, wrench: &BodyWrench) {
        let h = world.integration_parameters.dt;
        let body = &mut world.bodies[self.handle];
        if !body.is_dynamic() {
            return;
        }
        self.theirs = (body.user_force(), body.user_torque());
        let force = Vector::from_array(wrench.force);
        let torque = Vector::from_array(wrench.torque);
        let answers = body.mass_properties();
        let gained = answers.effective_inv_mass * force;
        let turned = answers.effective_world_inv_inertia * torque;
        self.expected = (body.linvel() + gained * h, body.angvel() + turned * h);
        // A body that sleeps is woken where it is touched.
        let wakes = force != Vector::ZERO || torque != Vector::ZERO;
        body.add_force(force, wakes);
        body.add_torque(torque, wakes);
    }

    fn pull(&mut self, world: &mut PhysicsWorld) {
        let h = world.integration_parameters.dt;
        let body = &mut world.bodies[self.handle];
        if !body.is_dynamic() {
            return;
        }
        body.reset_forces(false);
        body.reset_torques(false);
        body.add_force(self.theirs.0, false);
        body.add_torque(self.theirs.1, false);
        let (linear, angular) = self.expected;
        let last = ((body.linvel() - linear) / h, (body.angvel() - angular) / h);
        let before = self.others.map_or(last, |[before, _]| before);
        self.others = Some([last, before]);
    }
}

/// The shapes of a body, in its axes, from its centre of mass.
fn described(
    world: &PhysicsWorld,
    number: usize,
    handle: RigidBodyHandle,
    law: ContactLaw,
) -> Result<EngineBody, String> {
    let body = &world.bodies[handle];
    let name = format!("body {number}");
    let centre = body.mass_properties().local_mprops.local_com;
    let mut shapes = Vec::new();
    for collider in body.colliders() {
        let collider = &world.colliders[*collider];
        let shape = collider.shape();
        let shape = if let Some(ball) = shape.as_ball() {
            Shape::Sphere {
                radius: ball.radius,
            }
        } else if let Some(cuboid) = shape.as_cuboid() {
            Shape::Box {
                half_extents: cuboid.half_extents.to_array(),
            }
        } else if let Some(polyhedron) = shape.as_convex_polyhedron() {
            let corners: Vec<_> = polyhedron
                .points()
                .iter()
                .map(|point| point.to_array())
                .collect();
            Shape::Mesh(
                Mesh::convex(&corners)
                    .map_err(|error| format!("{name}: {error}"))?
                    .into(),
            )
        } else {
            return Err(format!(
                "{name} has a collider of the shape {:?}, but only balls, cuboids and convex polyhedrons are supported",
                shape.shape_type()
            ));
        };
        let place = collider.position_wrt_parent().copied().unwrap_or_default();
        let turned = place.rotation;
        shapes.push(PlacedShape {
            shape,
            position: (place.translation - centre).to_array(),
            orientation: [turned.w, turned.x, turned.y, turned.z],
        });
    }
    Ok(EngineBody { name, shapes, law })
}
