//! A world that goes on as another: from the state of one renderer to that of another.

use crate::renderer::WorldRenderer;
use crate::rigid::Rigid;
use crate::state::WorldState;

impl WorldRenderer {
    /// Lets what was sent to the tools by the `other` renderer, up to the last sample of its state `before`, act in `state` too,
    /// which this renderer has started: where both are told the same of the loop. For a state that then
    /// [takes over](Self::take_over). It allocates nothing and does not panic.
    pub fn take_commands(
        &self,
        state: &mut WorldState,
        (other, before): (&WorldRenderer, &WorldState),
    ) {
        let (here, there) = (&self.in_loop, &other.in_loop);
        let is_same_loop = here.actuation == there.actuation && here.period == there.period;
        if is_same_loop && self.turns == other.turns {
            let (now, then) = (&mut state.progress, &before.progress);
            now.commands.copy_from(&then.commands);
            now.torque_commands.copy_from(&then.torque_commands);
        }
    }

    /// Lets `state`, which this renderer has started, go on from the sample at which `before` is, the state of another
    /// renderer. The bodies of which `is_kept` says so are where they are there, and move as they move there, whatever their
    /// masses are here; the others are as this world describes them. The next sample is the first of `state`: it finds the
    /// devices at rest, and the energy in the contacts is there from outside.
    ///
    /// Bodies go by their number. One that is fixed here or there is not kept, nor is one that there is not. It allocates nothing
    /// and does not panic.
    pub fn take_over(&self, state: &mut WorldState, before: &WorldState, is_kept: &[bool]) {
        let (now, then) = (&mut state.progress, &before.progress);
        let from = then.now.parts.get(then.now.tools..).unwrap_or_default();
        let to = now.now.parts.get_mut(self.tools..).unwrap_or_default();
        let mut appeared = 0.0;
        let books = now.books.bodies.iter_mut();
        for (((to, from), is_kept), book) in to.iter_mut().zip(from).zip(is_kept).zip(books) {
            if !is_kept || to.is_fixed || from.is_fixed {
                continue;
            }
            let turning = from
                .mobility
                .turning(&from.rigid.orientation, &from.rigid.spin);
            let own = from.rigid.orientation.inverse_transform_vector(&turning);
            let spin = own.zip_map(&to.mobility.angular, |turning, mobility| {
                if mobility > 0.0 {
                    turning / mobility
                } else {
                    0.0
                }
            });
            to.rigid = Rigid {
                spin: from.rigid.orientation * spin,
                ..from.rigid
            };
            let kinetic = to.mobility.kinetic_energy(&to.rigid);
            appeared += kinetic - book.kinetic;
            book.kinetic = kinetic;
        }
        // Joints are looked at in the room that is there for what is predicted.
        now.room.parts.copy_from_slice(&now.now.parts);
        for book in &mut now.books.joints {
            appeared -= book.stored;
            book.stored = 0.0;
        }
        for link in &mut now.room.links {
            link.meet(&mut now.room.parts);
            if let Some(book) = now.books.joints.get_mut(link.joint) {
                book.stored += link.stored;
                appeared += link.stored;
            }
        }
        now.guard.appeared(appeared);
        self.show_bodies(now);
    }
}
