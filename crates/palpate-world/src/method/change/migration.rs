//! Migration of a state to another world, and the ledger entries of external changes.

use super::Succession;
use crate::WorldRenderer;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;
use crate::method::Memory;
use crate::method::state::{Progress, WorldState, body_state, show_contacts};

/// Elements that are new to a state after a change.
pub(super) enum New<'a> {
    /// Elements without a predecessor.
    Since(&'a Succession),
    /// Elements that involve a displaced body, given by its index among tools and bodies.
    Body(usize),
}

impl New<'_> {
    fn is_new(
        &self,
        origins: impl Fn(&Succession) -> &[Option<usize>],
        number: usize,
        parts: [usize; 2],
    ) -> bool {
        match self {
            Self::Since(from) => origins(from)[number].is_none(),
            Self::Body(body) => parts.contains(body),
        }
    }

    fn has_point(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.points.each, number, parts)
    }

    fn has_surface(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.surfaces, number, parts)
    }

    fn has_blocks(&self, number: usize, parts: [usize; 2]) -> bool {
        self.is_new(|from| &from.blocks, number, parts)
    }

    fn has_joint(&self, number: usize) -> bool {
        match self {
            Self::Since(from) => from.joints.each[number].is_none(),
            // A joint force depends only on the poses of its bodies, so re-evaluation is safe.
            Self::Body(_) => true,
        }
    }
}

impl WorldRenderer {
    /// Migrates `state` to the world of this renderer, between two samples. This renderer must have
    /// [started](Self::start) `state`. `before` is the other renderer with its state. `succession` is the result of
    /// [`migrate`](Self::migrate) for the two renderers. It allocates nothing.
    ///
    /// - [`changed`](Self::changed) defines which bodies, contacts and joints continue, and how their energy is
    ///   recorded.
    /// - The method may differ in kind or settings. It then starts with the devices at rest at the last sample.
    /// - The guard may differ. It then starts with the current energy of bodies, contacts and joints.
    /// - Forces in the actuation delay stay there if period and actuators are the same in both loops.
    /// - The field with the same index continues.
    /// - A new joint takes its point and axis from this world, and holds the bodies at their current poses.
    pub fn resume(
        &self,
        state: &mut WorldState,
        (before, past): (&Self, &WorldState),
        succession: &Succession,
    ) {
        let (old, new) = (&past.progress, &mut state.progress);
        new.tracking.copy_from(&old.tracking);
        let (here, there) = (&self.loop_params, &before.loop_params);
        let is_same_timing = here.actuation == there.actuation && here.period == there.period;
        let is_same_method = is_same_timing && self.described == before.described;
        if is_same_timing {
            new.commands.copy_from(&old.commands);
            new.slopes.copy_from(&old.slopes);
            new.torque_commands.copy_from(&old.torque_commands);
        }
        new.intended.copy_from_slice(&old.intended);
        new.intended_torques.copy_from_slice(&old.intended_torques);
        new.forces.copy_from_slice(&old.forces);
        new.torques.copy_from_slice(&old.torques);
        let is_same_guard = here.guard == there.guard && here.guard_masses == there.guard_masses;
        if is_same_guard {
            new.guard.copy_from(&old.guard);
        }
        self.carry_motion(new, (before, old), succession, is_same_method);
        carry_ledger(new, old, succession);
        self.carry_links(new, old, succession);
        self.settle(new, &New::Since(succession));
        if is_same_method {
            let points = &succession.points.each;
            state.memory.goes_on_from(&past.memory, points);
            state.progress.tools.copy_from_slice(&past.progress.tools);
        } else if state.progress.tracking.in_progress {
            self.begin_method(state, &past.progress, succession);
        }
        let progress = &mut state.progress;
        let created = past.progress.at_ports.created();
        progress.at_ports.resume(&progress.ledger, created);
        if !is_same_guard {
            let progress = &mut state.progress;
            let commands = (&progress.commands, &progress.torque_commands);
            progress.guard.begin_at(&progress.ledger, commands);
        }
    }

    /// Copies the motion of continued tools and bodies, and the states of their contacts.
    fn carry_motion(
        &self,
        new: &mut Progress,
        (before, old): (&Self, &Progress),
        succession: &Succession,
        is_same_method: bool,
    ) {
        let parts = new.now.parts.iter_mut().zip(&succession.parts);
        for (number, (part, was)) in parts.enumerate() {
            match was {
                Some(was) if number >= self.tools => part.goes_on_from(&old.now.parts[*was]),
                Some(was) if is_same_method => *part = old.now.parts[*was],
                Some(was) => part.rigid = old.now.parts[*was].rigid,
                None => {}
            }
        }
        let touches = new.now.touches.iter_mut().zip(&succession.points.each);
        for ((touch, was), point) in touches.zip(&self.points) {
            // If the method itself sets the contact force, another method has no state of the contact.
            if let Some(was) = was
                && point.is_held == before.points[*was].is_held
                && (is_same_method || !point.is_held)
            {
                *touch = old.now.touches[*was];
            }
        }
        for (surface, was) in new.now.surfaces.iter_mut().zip(&succession.surfaces) {
            if let Some(was) = was {
                surface.copy_from(&old.now.surfaces[*was]);
            }
        }
        for (blocks, was) in new.now.blocks.iter_mut().zip(&succession.blocks) {
            if let Some(was) = was {
                blocks.copy_from(&old.now.blocks[*was]);
            }
        }
    }

    /// Continues the links of continued joints, and attaches those of new joints at the current poses.
    fn carry_links(&self, new: &mut Progress, old: &Progress, succession: &Succession) {
        let befores = |joint: usize| old.now.links.iter().filter(move |link| link.joint == joint);
        for (joint, was) in succession.joints.each.iter().enumerate() {
            let links = new.now.links.iter_mut();
            let links = links.filter(|link| link.joint == joint);
            match was {
                Some(was) => links
                    .zip(befores(*was))
                    .for_each(|(link, before)| link.goes_on_from(before)),
                None => links.for_each(|link| link.is_borne(&self.parts, &new.now.parts)),
            }
        }
    }

    /// Starts a method that differs from that of the old world, and records the change in energy as external.
    fn begin_method(&self, state: &mut WorldState, old: &Progress, succession: &Succession) {
        self.meet_devices(&mut state.progress, &mut state.memory);
        // The resulting change is external, because no held force caused it.
        let contacts = state.progress.ledger.contacts.iter_mut();
        for (entry, was) in contacts.zip(&succession.points.each) {
            let before = was.map_or(0.0, |was| old.ledger.contacts[was].observed);
            entry.outside += entry.observed - before;
            entry.observed = before;
        }
        for (number, entry) in state.progress.ledger.fields.iter_mut().enumerate() {
            let before = old.ledger.fields.get(number);
            let before = before.map_or(0.0, |entry| entry.observed);
            entry.outside += entry.observed - before;
            entry.observed = before;
        }
        self.publish(&mut state.progress, &state.memory);
    }

    /// Initialises a method without device state: the devices are at rest at the last sample.
    fn meet_devices(&self, progress: &mut Progress, memory: &mut Memory) {
        let observed = progress.ledger.observed();
        let positions = progress.tracking.take_trusted();
        self.begin_and_plan(progress, memory, &positions);
        progress.tracking.put_trusted(positions);
        let appeared = progress.ledger.observed() - observed;
        progress.guard.appeared(appeared);
    }

    /// Evaluates the new elements after an external change, and records the change in energy. The other elements keep
    /// the forces of their last evaluation, so their motion is unaffected.
    pub(super) fn settle(&self, state: &mut Progress, new: &New<'_>) {
        self.evaluate_new(state, new);
        let appeared = self.record_stored(state);
        let parts = &state.now.parts[self.tools..];
        for (entry, part) in state.ledger.bodies.iter_mut().zip(parts) {
            let kinetic = part.mobility.kinetic_energy(&part.rigid);
            entry.outside += kinetic - entry.kinetic;
            entry.kinetic = kinetic;
        }
        for (part, body) in parts.iter().zip(&mut state.bodies) {
            *body = body_state(part);
        }
        state.guard.appeared(appeared);
        state.now.begin();
        show_contacts(&mut state.contacts, &mut state.shown, &state.now);
    }

    /// Evaluates the new elements at the current poses, and sums the loads of all elements on the bodies.
    fn evaluate_new(&self, state: &mut Progress, new: &New<'_>) {
        let Progress { now, room, .. } = state;
        let room = &mut room.before;
        now.parts.iter_mut().for_each(Part::wake);
        now.begin_everywhere();
        now.recollect();
        room.copy_from(now);
        room.look(&self.points);
        for (part, seen) in now.parts.iter_mut().zip(&room.parts) {
            part.force = Vector3::zeros();
            part.torque = Vector3::zeros();
            part.twist = seen.twist;
        }
        // The tool positions are unknown before the first sample and after a rejected one.
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
        now.recollect();
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
            // Use the current spring parameters.
            link.stored = seen.stored;
            link.load(&mut now.parts);
        }
        if state.tracking.in_progress {
            now.fields.copy_from_slice(&room.fields);
            for field in &now.fields {
                now.parts[field.tool].force += field.force;
            }
        }
    }

    /// Records the change in the stored energy of contacts, joints and fields as external. Returns its sum `[J]`.
    fn record_stored(&self, state: &mut Progress) -> f64 {
        let mut appeared = 0.0;
        for (number, (entry, point)) in state
            .ledger
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
            let outside = stored - entry.stored + past.dissipated - past.handed;
            entry.outside += outside;
            entry.handed += past.handed;
            entry.dissipated += past.dissipated;
            entry.stored = stored;
            appeared += outside;
        }
        for (number, entry) in state.ledger.joints.iter_mut().enumerate() {
            let links = state.now.links.iter().filter(|link| link.joint == number);
            let stored: f64 = links.map(|link| link.stored).sum();
            entry.outside += stored - entry.stored;
            appeared += stored - entry.stored;
            entry.stored = stored;
        }
        if state.tracking.in_progress {
            for (entry, field) in state.ledger.fields.iter_mut().zip(&state.now.fields) {
                entry.outside += field.stored - entry.stored;
                appeared += field.stored - entry.stored;
                entry.stored = field.stored;
            }
        }
        appeared
    }
}

/// Copies the ledgers of devices and of continued contacts, joints, fields and bodies.
fn carry_ledger(new: &mut Progress, old: &Progress, succession: &Succession) {
    let ledger = &mut new.ledger;
    ledger.gone = old.ledger.gone;
    ledger.devices.copy_from_slice(&old.ledger.devices);
    carry(
        &mut ledger.contacts,
        &old.ledger.contacts,
        &succession.points.each,
    );
    // All energy of new elements is external.
    let Succession {
        points,
        bodies,
        joints,
        ..
    } = succession;
    carry(&mut ledger.joints, &old.ledger.joints, &joints.each);
    carry(&mut ledger.bodies, &old.ledger.bodies, &bodies.each);
    let fields = ledger.fields.iter_mut().zip(&old.ledger.fields);
    fields.for_each(|(entry, was)| *entry = *was);
    let stored = ledger.take_leave(
        &old.ledger,
        points.gone(old.ledger.contacts.len()),
        bodies.gone(old.ledger.bodies.len()),
        joints.gone(old.ledger.joints.len()),
    );
    new.guard.appeared(-stored);
}

/// Copies the ledgers of continued elements. Those of new elements are empty.
fn carry<Book: Copy + Default>(new: &mut [Book], old: &[Book], from: &[Option<usize>]) {
    for (entry, was) in new.iter_mut().zip(from) {
        *entry = was.map_or_else(Book::default, |was| old[was]);
    }
}
