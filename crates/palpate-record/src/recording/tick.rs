//! Recorded data of a whole tick: device, timing and sent force.

use super::row::part_of_row;
use super::state::Flags;
use super::{BodyTick, ContactTick};

part_of_row! {
    /// Data of one tick of a device loop, independent of the rendering. Each contact has its own [`ContactTick`].
    ///
    /// Vectors are in the device's own frame; NaN: missing.
    Tick as tick;

    sequence: u64, "1", table,
        "number of the tick: 0, 1, 2, ...; a number that is missing is a tick that was lost",
        "sequence";
    time: f64, "s", table,
        "when the device was sampled, since the loop's start",
        "t_s";
    lateness: f64, "s", live,
        "time past the instant that was planned for the sample; negative if early",
        "lateness_s";
    period: f64, "s", table,
        "measured time since the sample before; NaN for the first",
        "period_s";
    device_axes: [f64; 3], "m", table,
        "end-point of the device in its own frame; NaN beyond the axes it has",
        "device_axis_1_m" @ 0, "device_axis_2_m" @ 1, "device_axis_3_m" @ 2;
    device_orientation: [f64; 4], "1", table,
        "unit quaternion that turns the end-point's own axes into those of the device's frame; NaN where the device does not measure it",
        "device_orientation_w" @ 0, "device_orientation_x" @ 1, "device_orientation_y" @ 2,
        "device_orientation_z" @ 3;
    commanded_force: [f64; 3], "N", table,
        "force on the device as the loop commanded it, after the limits of the safety",
        "commanded_force_1_n" @ 0, "commanded_force_2_n" @ 1, "commanded_force_3_n" @ 2;
    commanded_torque: [f64; 3], "N m", table,
        "torque on the device as the loop commanded it, after the limits of the safety",
        "commanded_torque_1_n_m" @ 0, "commanded_torque_2_n_m" @ 1, "commanded_torque_3_n_m" @ 2;
    delivered_force: [f64; 3], "N", table,
        "force on the device that it holds by its own account; 0 where it refused the command",
        "delivered_force_1_n" @ 0, "delivered_force_2_n" @ 1, "delivered_force_3_n" @ 2;
    delivered_torque: [f64; 3], "N m", table,
        "torque on the device that it holds by its own account; 0 where it refused the command",
        "delivered_torque_1_n_m" @ 0, "delivered_torque_2_n_m" @ 1, "delivered_torque_3_n_m" @ 2;
    tick_duration: f64, "s", live,
        "how long the tick took, from the sample to the command",
        "tick_duration_s";
    device_round_trip: f64, "s", table,
        "how long the device took to answer; NaN where that is not known",
        "device_round_trip_s";
    generation: u32, "1", table,
        "which parameters were in force: 0 for those of the metadata, one more with every change",
        "generation";
    contacts: u32, "1", several,
        "number of contacts: so many messages on `/contact` have the number of this tick",
        "contacts";
    bodies: u32, "1", several,
        "number of bodies that move, with the proxies of tools: so many messages on `/body` have the number of this tick; 0 where no world is rendered",
        "bodies";
    created_energy: f64, "J", several,
        "energy that held forces created since the start, summed over all contacts, while the motors were on: what the limit of the safety counts",
        "created_energy_j";
    flags: Flags, "1", live,
        "what is to be said of the tick, a bit each; what is to be said of any of its contacts is among it",
        "flags";
}

impl Tick {
    /// Sets the numbers of contacts and bodies, and the flags of the contacts.
    pub(super) fn with(self, contacts: &[ContactTick], bodies: &[BodyTick]) -> Self {
        let flags = contacts
            .iter()
            .fold(self.flags, |flags, contact| flags.with(contact.flags, true));
        Self {
            contacts: u32::try_from(contacts.len()).unwrap_or(u32::MAX),
            bodies: u32::try_from(bodies.len()).unwrap_or(u32::MAX),
            flags,
            ..self
        }
    }
}
