//! Changes of a world that runs: other bodies, contacts and joints, and bodies that are put elsewhere.

use std::sync::Arc;

use crate::body::rotation;
use crate::moving::Touch;
use crate::rigid::Vector3;
use crate::state::{BodyState, Progress, WorldState, body_state, show_contacts};
use crate::world::{Faults, is_unit};
use crate::{Joint, Motion, Place, Shape, World, WorldError, WorldRenderer};

/// Where the parts of a changed world were in the world before.
struct Origins {
    /// Of each tool and body.
    parts: Vec<Option<usize>>,
    /// Of each point of contact,
    points: Vec<Option<usize>>,
    /// of the spheres on meshes,
    surfaces: Vec<Option<usize>>,
    /// of the pairs of boxes, hulls and capsules,
    blocks: Vec<Option<usize>>,
    /// and of each joint.
    joints: Vec<Option<usize>>,
}

/// What is new to a state after a change.
enum New<'a> {
    /// What has no origin.
    Since(&'a Origins),
    /// What a body has to do with, which has been put elsewhere: its number among tools and bodies.
    Body(usize),
}

impl New<'_> {
    fn is_new(
        &self,
        origins: impl Fn(&Origins) -> &[Option<usize>],
        number: usize,
        parts: [usize; 2],
    ) -> bool {
        match self {
            Self::Since(from) => origins(from)[number].is_none(),
            Self::Body(body) => parts.contains(body),
        }
    }

    fn has_point(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.points, number, parts)
    }

    fn has_surface(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.surfaces, number, parts)
    }

    fn has_blocks(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.blocks, number, parts)
    }

    fn has_joint(&self, number: usize) -> bool {
        match self {
            Self::Since(from) => from.joints[number].is_none(),
            // A joint answers to where its bodies are, so it may be looked at anew.
            Self::Body(_) => true,
        }
    }
}

impl WorldRenderer {
    /// The world that is rendered, its bodies as they were at the start or at the last change.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Goes on with another world: a renderer and a state for `world`, in which everything moves on that is there by its
    /// name already. Loop, method and tools stay as they are, but for the shapes of the tools.
    ///
    /// - A body of a name that there was goes on from where it is, as it moves; what `world` says of its place and
    ///   velocity is not looked at. Its shape, mass, force and whether it is fixed are those of `world`. With another mass
    ///   or inertia it keeps its velocities.
    /// - A body of a new name begins as `world` says.
    /// - A pair of which both shapes stay keeps its bristle. Its law is that of `world`.
    /// - A joint of the same bodies, kind, point, axis and span keeps its coordinate. Another one is new: its point and
    ///   axis hold as the bodies stand now.
    ///
    /// What the devices are known to do and what is sent to them goes on. The energy that a change puts in or takes out is
    /// booked as outside work, and the books of what is gone are summed up in [`Books::gone`](crate::Books::gone). The
    /// force may step with the next sample. It allocates, as [`new`](Self::new) does.
    ///
    /// # Errors
    /// Everything that is wrong with the new world, or another number, order, name or kind of tools.
    pub fn changed(
        &self,
        state: &WorldState,
        world: &World,
    ) -> Result<(Self, WorldState), Vec<WorldError>> {
        self.check_tools(world)?;
        let now = self.where_it_is(state, world);
        let mut renderer = Self::new(&now, self.in_loop.clone(), self.described.clone())?;
        let from = renderer.origins(self);
        for (joint, was) in from.joints.iter().enumerate() {
            let links = renderer.links.iter_mut().filter(|link| link.joint == joint);
            let befores = self.links.iter().filter(|link| Some(link.joint) == *was);
            for (link, before) in links.zip(befores) {
                link.stays_at(before, &renderer.parts);
            }
        }
        let mut next = renderer.start();
        renderer.go_on_from(&mut next, self, state, &from);
        Ok((renderer, next))
    }

    /// Puts a body elsewhere, or gives it another velocity, between two samples. The energy of it is booked as outside
    /// work; the force may step with the next sample. It does not allocate.
    ///
    /// # Errors
    /// There is no such body, a number is not finite, the orientation is no unit quaternion, or a fixed body is to move.
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
        part.rigid.orientation = rotation(to.orientation);
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

    /// Whether a body can be there. Words are only made of what is wrong, since they allocate.
    fn can_place(&self, body: usize, to: &BodyState) -> Result<(), WorldError> {
        let place = Place::Body(body);
        let Some(described) = self.world.bodies.get(body) else {
            let count = self.world.bodies.len();
            let message = format!("there is no body {body}; the world has {count}");
            return Err(WorldError::new(place, "body", "the world", message));
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
        checks.finite("position", position);
        checks.unit("orientation", orientation);
        checks.finite("velocity", velocity);
        checks.finite("angular_velocity", angular_velocity);
        if is_still {
            let message = "a fixed body has no velocity: give it 0, or make it a body that moves";
            checks.fault("velocity", message.into());
        }
        faults.into_iter().next().map_or(Ok(()), Err)
    }

    /// The tools are those that there were.
    fn check_tools(&self, world: &World) -> Result<(), Vec<WorldError>> {
        let before = &self.world.tools;
        if world.tools.len() != before.len() {
            let message = format!(
                "there are {} tools, and {} before; the tools of a world that runs stay",
                world.tools.len(),
                before.len()
            );
            return Err(vec![WorldError::new(
                Place::World,
                "tools",
                "the world",
                message,
            )]);
        }
        let tools = world.tools.iter().zip(before).enumerate();
        let faults: Vec<_> = tools
            .filter(|(_, (tool, before))| tool.name != before.name || tool.turns != before.turns)
            .map(|(number, (tool, before))| {
                let turns = if before.turns { "" } else { " does not" };
                WorldError::new(
                    Place::Tool(number),
                    "tools",
                    format!("tool {:?}", tool.name),
                    format!(
                        "it was {:?}, which{turns} turn{}; the tools of a world that runs stay, but for their shapes",
                        before.name,
                        if before.turns { "s" } else { "" }
                    ),
                )
            })
            .collect();
        if faults.is_empty() {
            Ok(())
        } else {
            Err(faults)
        }
    }

    /// `world` with the bodies that there were as they are now.
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

    fn name_and_shape(&self, part: usize) -> (&str, &Shape) {
        match self.world.tools.get(part) {
            Some(tool) => (&tool.name, &tool.shape),
            None => {
                let body = &self.world.bodies[part - self.tools];
                (&body.name, &body.shape)
            }
        }
    }

    /// Where everything was in `before`.
    fn origins(&self, before: &Self) -> Origins {
        let number = |name: &str| {
            let bodies = &before.world.bodies;
            let place = bodies.iter().position(|body| body.name == *name)?;
            Some(before.tools + place)
        };
        let parts: Vec<_> = (0..self.parts.len())
            .map(|part| {
                if part < self.tools {
                    Some(part)
                } else {
                    number(self.name_and_shape(part).0)
                }
            })
            .collect();
        // A part whose shape stays.
        let stays = |part: usize| {
            let was = parts[part]?;
            is_same_shape(self.name_and_shape(part).1, before.name_and_shape(was).1).then_some(was)
        };
        let pair = |[first, second]: [usize; 2]| Some([stays(first)?, stays(second)?]);
        let sides = |points: &[crate::pairs::Point]| -> Vec<[usize; 2]> {
            points.iter().map(|p| [p.first, p.second]).collect()
        };
        let points = in_order(&sides(&self.points), &sides(&before.points), pair);
        let surfaces = |of: &Self| -> Vec<_> { of.surfaces.iter().map(|s| s.parts()).collect() };
        let blocks = |of: &Self| -> Vec<_> { of.blocks.iter().map(|b| b.parts).collect() };
        let named = |name: &str| {
            let place = self
                .world
                .bodies
                .iter()
                .position(|body| body.name == *name)?;
            stays(self.tools + place)
        };
        let mut is_taken = vec![false; before.world.joints.len()];
        let joints = self.world.joints.iter().map(|joint| {
            named(&joint.body)?;
            if let Some(against) = &joint.against {
                named(against)?;
            }
            let mut olds = before.world.joints.iter().enumerate();
            let (old, _) =
                olds.find(|(old, was)| !is_taken[*old] && is_same_bearing(joint, was))?;
            is_taken[old] = true;
            Some(old)
        });
        Origins {
            joints: joints.collect(),
            points,
            surfaces: in_order(&surfaces(self), &surfaces(before), pair),
            blocks: in_order(&blocks(self), &blocks(before), pair),
            parts,
        }
    }

    /// Takes over what goes on, into a state at its start.
    fn go_on_from(&self, next: &mut WorldState, before: &Self, state: &WorldState, from: &Origins) {
        let (old, new) = (&state.progress, &mut next.progress);
        new.tracking = old.tracking.clone();
        new.commands = old.commands.clone();
        new.torque_commands = old.torque_commands.clone();
        new.intended.clone_from(&old.intended);
        new.intended_torques.clone_from(&old.intended_torques);
        new.forces.clone_from(&old.forces);
        new.torques.clone_from(&old.torques);
        new.tools.clone_from(&old.tools);
        new.guard = old.guard.clone();
        let parts = new.now.parts.iter_mut().zip(&from.parts);
        for (number, (part, was)) in parts.enumerate() {
            match was {
                Some(was) if number < self.tools => *part = old.now.parts[*was],
                Some(was) => part.goes_on_from(&old.now.parts[*was]),
                None => {}
            }
        }
        for (touch, was) in new.now.touches.iter_mut().zip(&from.points) {
            if let Some(was) = was {
                *touch = old.now.touches[*was];
            }
        }
        for (surface, was) in new.now.surfaces.iter_mut().zip(&from.surfaces) {
            if let Some(was) = was {
                surface.copy_from(&old.now.surfaces[*was]);
            }
        }
        for (blocks, was) in new.now.blocks.iter_mut().zip(&from.blocks) {
            if let Some(was) = was {
                blocks.copy_from(&old.now.blocks[*was]);
            }
        }
        next.memory = state.memory.of_points(&from.points);
        let books = &mut new.books;
        books.gone = old.books.gone;
        books.devices.clone_from(&old.books.devices);
        carry(&mut books.contacts, &old.books.contacts, &from.points);
        // What is new has all that it has from outside.
        carry(&mut books.joints, &old.books.joints, &from.joints);
        let bodies: Vec<_> = from.parts[self.tools..]
            .iter()
            .map(|was| was.map(|was| was - before.tools))
            .collect();
        carry(&mut books.bodies, &old.books.bodies, &bodies);
        let stored = books.take_leave(&old.books, &from.points, &bodies, &from.joints);
        new.guard.appeared(-stored);
        let befores = |joint: usize| old.now.links.iter().filter(move |link| link.joint == joint);
        for (joint, was) in from.joints.iter().enumerate() {
            let Some(was) = was else {
                continue;
            };
            let links = new.now.links.iter_mut();
            let links = links.filter(|link| link.joint == joint);
            for (link, before) in links.zip(befores(*was)) {
                link.goes_on_from(before);
            }
        }
        self.settle(new, &New::Since(from));
    }

    /// Looks at what is new after a change from outside, and books what it has changed. What is not new keeps the forces of
    /// the last look, so that it goes on as it would have.
    fn settle(&self, state: &mut Progress, new: &New<'_>) {
        let Progress { now, room, .. } = state;
        now.begin();
        room.copy_from(now);
        room.look(&self.points);
        for (part, seen) in now.parts.iter_mut().zip(&room.parts) {
            part.force = Vector3::zeros();
            part.torque = Vector3::zeros();
            part.twist = seen.twist;
        }
        // Before the first sample nobody knows where the tools are, and after a refused one not either.
        if state.tracking.in_progress {
            for (number, surface) in now.surfaces.iter_mut().enumerate() {
                if new.has_surface(number, surface.parts()) {
                    surface.copy_from(&room.surfaces[number]);
                }
            }
            for (number, blocks) in now.blocks.iter_mut().enumerate() {
                if new.has_blocks(number, blocks.parts) {
                    blocks.copy_from(&room.blocks[number]);
                }
            }
            for (number, (touch, point)) in now.touches.iter_mut().zip(&self.points).enumerate() {
                if new.has_point(number, [point.first, point.second]) && !point.is_held {
                    *touch = room.touches[number];
                }
            }
        }
        for (touch, point) in now.touches.iter().zip(&self.points) {
            if !touch.is_apart() {
                now.parts[point.first].load(&touch.force, &touch.place);
                now.parts[point.second].load(&-touch.force, &touch.place);
            }
        }
        for (link, seen) in now.links.iter_mut().zip(&room.links) {
            if new.has_joint(link.joint) {
                *link = *seen;
            }
            // By the springs that it has now.
            link.stored = seen.stored;
            link.load(&mut now.parts);
        }
        let mut appeared = 0.0;
        for (number, (book, point)) in state
            .books
            .contacts
            .iter_mut()
            .zip(&self.points)
            .enumerate()
        {
            let past = &state.now.touches[number].past;
            let stored = if point.is_held {
                0.0
            } else {
                state.now.stored(number, point)
            };
            let outside = stored - book.stored + past.dissipated - past.handed;
            book.outside += outside;
            book.handed += past.handed;
            book.dissipated += past.dissipated;
            book.stored = stored;
            appeared += outside;
        }
        for (number, book) in state.books.joints.iter_mut().enumerate() {
            let links = state.now.links.iter().filter(|link| link.joint == number);
            let stored: f64 = links.map(|link| link.stored).sum();
            book.outside += stored - book.stored;
            appeared += stored - book.stored;
            book.stored = stored;
        }
        let parts = &state.now.parts[self.tools..];
        for (book, part) in state.books.bodies.iter_mut().zip(parts) {
            let kinetic = part.mobility.kinetic_energy(&part.rigid);
            book.outside += kinetic - book.kinetic;
            book.kinetic = kinetic;
        }
        for (part, body) in parts.iter().zip(&mut state.bodies) {
            *body = body_state(part);
        }
        state.guard.appeared(appeared);
        state.now.begin();
        show_contacts(&mut state.contacts, &state.now);
    }
}

/// Whether two shapes are the same; the triangles of one mesh are not compared with themselves.
fn is_same_shape(one: &Shape, other: &Shape) -> bool {
    match (one, other) {
        (Shape::Mesh(one), Shape::Mesh(other)) => Arc::ptr_eq(one, other) || one == other,
        (Shape::Hull(one), Shape::Hull(other)) => Arc::ptr_eq(one, other) || one == other,
        _ => one == other,
    }
}

/// Of each of `new`, the one of `old` of the same pair and the same place among those of the pair.
fn in_order(
    new: &[[usize; 2]],
    old: &[[usize; 2]],
    pair: impl Fn([usize; 2]) -> Option<[usize; 2]>,
) -> Vec<Option<usize>> {
    let mut is_taken = vec![false; old.len()];
    new.iter()
        .map(|sides| {
            let was = pair(*sides)?;
            let number =
                (0..old.len()).find(|&old_one| !is_taken[old_one] && old[old_one] == was)?;
            is_taken[number] = true;
            Some(number)
        })
        .collect()
}

/// Whether a joint is the same bearing as before, with any springs.
fn is_same_bearing(joint: &Joint, before: &Joint) -> bool {
    let Joint {
        body,
        against,
        kind,
        point,
        axis,
        law,
    } = joint;
    *body == before.body
        && *against == before.against
        && *kind == before.kind
        && *point == before.point
        && *axis == before.axis
        && law.span == before.law.span
}

/// The books of what goes on; those of what is new are empty.
fn carry<Book: Copy + Default>(new: &mut [Book], old: &[Book], from: &[Option<usize>]) {
    for (book, was) in new.iter_mut().zip(from) {
        *book = was.map_or_else(Book::default, |was| old[was]);
    }
}
