//! Changes of a running world: different bodies, contacts and joints, and displaced bodies.

mod migration;
mod succession;

use crate::contact::point::Touch;
use crate::description::world::{Faults, is_unit};
use crate::geometry::rigid::orientation;
use crate::method::state::{BodyState, WorldState, body_state};
use crate::{Motion, World, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer};

use migration::New;
pub use succession::Succession;

impl WorldRenderer {
    /// Returns the rendered world, with its bodies in their states at the start or at the last change.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Continues with another world. Returns a renderer and a state for `world`; elements with an existing name
    /// continue their motion. Loop, method and tools stay the same, except for the shapes of the tools.
    ///
    /// - A body with an existing name keeps its pose and velocity; those in `world` are ignored. Its shape, mass,
    ///   force and whether it is fixed are taken from `world`. It keeps its velocities also if its mass or inertia
    ///   changes.
    /// - A body with a new name starts in its state in `world`.
    /// - A pair keeps its bristle if both shapes are unchanged. Its law is taken from `world`.
    /// - The field with the same index continues, and its potential is taken from `world`.
    /// - A joint with the same bodies, kind, point, axis and span keeps its coordinate. Any other joint is new: its
    ///   point and axis apply to the current poses of the bodies.
    ///
    /// Device estimates and commanded forces continue. The energy added or removed by a change is recorded as outside
    /// work. The ledgers of removed elements are summed in [`EnergyLedger::gone`](crate::EnergyLedger::gone). The force
    /// may step at the next sample. This function allocates, like [`new`](Self::new). [`migrate`](Self::migrate)
    /// followed by [`resume`](Self::resume) has the same effect, and `resume` does not allocate.
    ///
    /// # Errors
    /// All faults of the new world, or a changed number, order, name or kind of tools.
    pub fn changed(
        &self,
        state: &WorldState,
        world: &World,
    ) -> Result<(Self, WorldState), WorldErrors> {
        self.check_tools(world)?;
        let now = self.where_it_is(state, world);
        let mut renderer = Self::new(&now, self.loop_params.clone(), self.described.clone())?;
        let succession = renderer.migrate(self, &[])?;
        let mut next = renderer.start();
        renderer.resume(&mut next, (self, state), &succession);
        Ok((renderer, next))
    }

    /// Sets the pose and velocity of a body between two samples. The change in energy is recorded as outside work;
    /// the force may step at the next sample. It does not allocate.
    ///
    /// # Errors
    /// The body does not exist, a number is not finite, the orientation is not a unit quaternion, or a fixed body is
    /// given a velocity.
    pub fn place(
        &self,
        state: &mut WorldState,
        body: usize,
        to: &BodyState,
    ) -> Result<(), WorldError> {
        self.can_place(body, to)?;
        let number = self.tools + body;
        let progress = &mut state.progress;
        let part = &mut progress.now.parts[number];
        part.rigid.position = to.position.into();
        part.rigid.orientation = orientation(to.orientation);
        part.rigid.velocity = to.velocity.into();
        part.set_turning(&to.angular_velocity.into());
        let now = &mut progress.now;
        for (touch, point) in now.touches.iter_mut().zip(&self.points) {
            if point.first == number || point.second == number {
                *touch = Touch::apart();
            }
        }
        for surface in &mut now.surfaces {
            if surface.parts().contains(&number) {
                surface.forget();
            }
        }
        for blocks in &mut now.blocks {
            if blocks.parts.contains(&number) {
                blocks.forget();
            }
        }
        self.settle(progress, &New::Body(number));
        Ok(())
    }

    /// Checks whether a body can take this state.
    ///
    /// # Errors
    /// Those of [`place`](Self::place).
    // Messages are built only for faults, because they allocate.
    pub fn can_place(&self, body: usize, to: &BodyState) -> Result<(), WorldError> {
        let place = WorldPart::Body(body);
        let Some(described) = self.world.bodies.get(body) else {
            let count = self.world.bodies.len();
            let message = format!("there is no body {body}; the world has {count}");
            return Err(WorldError::new(
                place,
                WorldField::Body,
                "the world",
                message,
            ));
        };
        let BodyState {
            position,
            orientation,
            velocity,
            angular_velocity,
        } = to;
        let moves = *velocity != [0.0; 3] || *angular_velocity != [0.0; 3];
        let is_still = described.motion == Motion::Fixed && moves;
        let mut numbers = position.iter().chain(velocity).chain(angular_velocity);
        if numbers.all(|x| x.is_finite()) && is_unit(orientation) && !is_still {
            return Ok(());
        }
        let (mut faults, subject) = (Vec::new(), format!("body {:?}", described.name));
        let mut checks = Faults::new(&mut faults, place, &subject);
        checks.finite(WorldField::Position, position);
        checks.unit(WorldField::Orientation, orientation);
        checks.finite(WorldField::Velocity, velocity);
        checks.finite(WorldField::AngularVelocity, angular_velocity);
        if is_still {
            let message = "a fixed body has no velocity: give it 0, or make it a body that moves";
            checks.fault(WorldField::Velocity, message.into());
        }
        faults.into_iter().next().map_or(Ok(()), Err)
    }

    /// Checks that the tools are unchanged.
    fn check_tools(&self, world: &World) -> Result<(), WorldErrors> {
        let before = &self.world.tools;
        if world.tools.len() != before.len() {
            let message = format!(
                "there are {} tools, previously {}; the tools of a running world cannot change",
                world.tools.len(),
                before.len()
            );
            let (part, field) = (WorldPart::World, WorldField::Tools);
            return Err(WorldError::new(part, field, "the world", message).into());
        }
        let tools = world.tools.iter().zip(before).enumerate();
        let faults: Vec<_> = tools
            .filter(|(_, (tool, before))| {
                tool.name != before.name
                    || tool.turns != before.turns
                    || tool.gives_torque != before.gives_torque
                    || tool.axes != before.axes
                    || tool.own_axes != before.own_axes
                    || tool.mass_table != before.mass_table
            })
            .map(|(number, (tool, before))| {
                let turns = match (before.turns, before.gives_torque) {
                    (false, _) => "does not turn",
                    (true, true) => "turns",
                    (true, false) => "turns without torque",
                };
                WorldError::new(
                    WorldPart::Tool(number),
                    WorldField::Tools,
                    format!("tool {:?}", tool.name),
                    format!(
                        "it was {:?}, which moves along {} and {turns}; tools of a running world can change only their \
                         shapes",
                        before.name,
                        before.names_of_axes()
                    ),
                )
            })
            .collect();
        WorldErrors::check(faults)
    }

    /// Returns `world` with the existing bodies in their current states.
    fn where_it_is(&self, state: &WorldState, world: &World) -> World {
        let mut now = world.clone();
        for body in &mut now.bodies {
            let place = self
                .world
                .bodies
                .iter()
                .position(|old| old.name == body.name);
            let Some(place) = place else {
                continue;
            };
            let is = body_state(&state.progress.now.parts[self.tools + place]);
            body.position = is.position;
            body.orientation = is.orientation;
            let moved = self.world.bodies[place].motion != Motion::Fixed;
            if let Motion::Free(free) = &mut body.motion
                && moved
            {
                free.velocity = is.velocity;
                free.angular_velocity = is.angular_velocity;
            }
        }
        now
    }
}
