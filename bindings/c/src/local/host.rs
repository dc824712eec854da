//! The host's end of a local model.

use palpate_world::engine::BodyNow;

use super::{BodyProgress, HostBody, HostContact, Progress};
use crate::array::{array, array_mut};
use crate::edge::status;
use crate::scene::in_words;
use crate::sized::Room;
use crate::status::{Refusal, Status};

/// A slow host, such as a physics engine of 60 Hz: the host's end of a local model. One thread at a time may use it.
///
/// The host repeats: take the progress; step over the time since the progress before under palpate_mean_wrench() on each body;
/// look for contacts near the avatar; publish its bodies and contacts as of the progress's tick.
pub struct SlowHost {
    end: palpate_rt::SlowHost,
    bodies: usize,
}

impl SlowHost {
    pub(super) fn new(end: palpate_rt::SlowHost, bodies: u32) -> Self {
        Self {
            end,
            bodies: bodies as usize,
        }
    }

    /// Refuses another number of bodies than there are.
    fn counted(&self, given: usize) -> Result<(), Refusal<'static>> {
        if given == self.bodies {
            return Ok(());
        }
        Err(Refusal::Count {
            name: "body_count",
            given,
            needed: self.bodies,
            of: ("the local model", "bodies"),
        })
    }
}

/// Frees the host's end of a local model. NULL is allowed. What it has published fades in the loop.
///
/// # Safety
/// `host` is NULL or such an end, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_slow_host_free(host: *mut SlowHost) {
    if !host.is_null() {
        // SAFETY: `palpate_local_world_new` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(host) });
    }
}

/// Puts how far the loop has come, as of its last tick, into `*progress`, and what the tool has given to each body into `bodies`,
/// of which there are `body_count`: as many as the local model has. Both are of the same tick.
///
/// # Safety
/// Each pointer is NULL or to what its type says, `bodies` to `body_count` of them; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_slow_host_progress(
    host: *mut SlowHost,
    progress: *mut Progress,
    bodies: *mut BodyProgress,
    body_count: usize,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let host = unsafe { host.as_mut() }.ok_or(Refusal::Null("host"))?;
        host.counted(body_count)?;
        // SAFETY: as the caller says.
        let bodies = unsafe { array_mut(bodies, body_count, "bodies") }?;
        // SAFETY: as the caller says.
        let room = unsafe { Room::at(progress) }?;
        let now = host.end.progress();
        room.write(Progress::from(now));
        let given = now.impulses.iter().zip(&now.copies);
        for (body, (given, copy)) in bodies.iter_mut().zip(given) {
            *body = BodyProgress {
                impulse: given.linear,
                moment: given.angular,
                copy: *copy,
            };
        }
        Ok(())
    })
}

/// Publishes the host's bodies and contacts as of a tick: that of the progress whose impulses the bodies have in them. The loop
/// renders by them from its next tick on. A contact is known by its place in `contacts`: the one in the same place of the next
/// model is the same contact, which has moved. On an error, which says everything that is wrong, the model before stays. What the
/// loop does not take, the next progress says.
///
/// # Safety
/// Each pointer is NULL or to what its type says, `bodies` and `contacts` to as many as are said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_slow_host_publish(
    host: *mut SlowHost,
    tick: u64,
    bodies: *const HostBody,
    body_count: usize,
    contacts: *const HostContact,
    contact_count: usize,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let host = unsafe { host.as_mut() }.ok_or(Refusal::Null("host"))?;
        host.counted(body_count)?;
        // SAFETY: as the caller says.
        let bodies = unsafe { array(bodies, body_count, "bodies") }?;
        // SAFETY: as the caller says.
        let contacts = unsafe { array(contacts, contact_count, "contacts") }?;
        let bodies: Vec<BodyNow> = bodies.iter().map(BodyNow::from).collect();
        let contacts: Vec<_> = contacts.iter().map(HostContact::local).collect();
        host.end
            .publish(tick, &bodies, &contacts)
            .map_err(|faults| Refusal::Numbers(in_words(&faults)))
    })
}
