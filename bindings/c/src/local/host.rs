//! Simulator side of a multirate local model.

use palpate_world::engine::BodyNow;

use super::{BodyProgress, HostBody, HostContact, Progress};
use crate::array::{array, array_mut};
use crate::edge::status;
use crate::sized::Room;
use crate::status::{Refusal, Status};

/// Simulator side of a multirate local model, for a low-rate simulator such as a 60 Hz physics engine. Only one
/// thread may use it at a time.
///
/// The simulator repeats four steps: read the progress; integrate over the time since the previous progress with
/// palpate_mean_wrench() on each body; detect contacts near the proxy; publish its bodies and contacts for the tick
/// of the progress.
pub struct LowRateSimulator {
    end: palpate_rt::LowRateSimulator,
    bodies: usize,
}

impl LowRateSimulator {
    pub(super) fn new(end: palpate_rt::LowRateSimulator, bodies: u32) -> Self {
        Self {
            end,
            bodies: bodies as usize,
        }
    }

    /// Rejects a wrong number of bodies.
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

/// Frees the simulator side of a local model. NULL is allowed. The loop fades out the last published model.
///
/// # Safety
/// `host` is NULL or a simulator side, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_low_rate_simulator_free(host: *mut LowRateSimulator) {
    if !host.is_null() {
        // SAFETY: allocated with `Box::into_raw` by `palpate_local_world_new`, and not used afterwards.
        drop(unsafe { Box::from_raw(host) });
    }
}

/// Writes the progress of the loop at its last tick to `*progress`, and the impulses of the tool on each body at the
/// same tick to `bodies`. `body_count` is the number of bodies of the local model.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type, `bodies` to `body_count` of them; the first field of each
/// sized struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_low_rate_simulator_progress(
    host: *mut LowRateSimulator,
    progress: *mut Progress,
    bodies: *mut BodyProgress,
    body_count: usize,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let host = unsafe { host.as_mut() }.ok_or(Refusal::Null("host"))?;
        host.counted(body_count)?;
        // SAFETY: guaranteed by the caller.
        let bodies = unsafe { array_mut(bodies, body_count, "bodies") }?;
        // SAFETY: guaranteed by the caller.
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

/// Publishes the simulator's bodies and contacts for a tick: the tick of the progress whose impulses the bodies
/// include. The loop renders them from its next tick on. The index in `contacts` identifies a contact: the same
/// index in the next model is the same, moved contact. On an error, whose message lists all faults, the previous
/// model stays. The next progress reports a model that the loop rejects.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type, `bodies` and `contacts` to `body_count` and
/// `contact_count` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_low_rate_simulator_publish(
    host: *mut LowRateSimulator,
    tick: u64,
    bodies: *const HostBody,
    body_count: usize,
    contacts: *const HostContact,
    contact_count: usize,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let host = unsafe { host.as_mut() }.ok_or(Refusal::Null("host"))?;
        host.counted(body_count)?;
        // SAFETY: guaranteed by the caller.
        let bodies = unsafe { array(bodies, body_count, "bodies") }?;
        // SAFETY: guaranteed by the caller.
        let contacts = unsafe { array(contacts, contact_count, "contacts") }?;
        let bodies: Vec<BodyNow> = bodies.iter().map(BodyNow::from).collect();
        let contacts: Vec<_> = contacts.iter().map(HostContact::local).collect();
        host.end
            .publish(tick, &bodies, &contacts)
            .map_err(|faults| Refusal::Numbers(faults.to_string()))
    })
}
