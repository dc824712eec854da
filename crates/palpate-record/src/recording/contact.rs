//! Recorded data of each contact of a tick.

use super::row::part_of_row;
use super::state::{Flags, Phase};

part_of_row! {
    /// Data of one contact at one tick.
    ///
    /// Scalar positions, velocities and forces are along the contact's normal and in the user's frame, positive along
    /// it; NaN: missing. `docs/signs.md` draws the axis. Those of a contact of a world are vectors along the axes of
    /// the world.
    ContactTick as contact;

    sequence: u64, "1", several,
        "number of the tick",
        "sequence";
    contact: u32, "1", several,
        "number of the contact: 0, 1, 2, ...",
        "contact";
    flags: Flags, "1", several,
        "flags of the contact, one bit each",
        "contact_flags";
    device_position: f64, "m", live,
        "position of the device along the contact's normal, as the renderer used it",
        "device_position_m";
    object_position: f64, "m", live,
        "position of the object along the contact's normal",
        "object_position_m";
    object_velocity: f64, "m/s", live,
        "velocity of the object along the contact's normal",
        "object_velocity_m_per_s";
    penetration: f64, "m", live,
        "penetration of the device into the object; positive in contact, on either side of the object",
        "penetration_m";
    proxy_shift: f64, "m", table,
        "shift of the object by `coupled` over the interval before the sample; 0 for other methods",
        "proxy_shift_m";
    force_on_object: f64, "N", table,
        "force of the renderer on the object, before the safety limits",
        "force_on_object_n";
    force_on_device: f64, "N", live,
        "force on the device as sent, after the safety limits",
        "force_on_device_n";
    stored_energy: f64, "J", live,
        "energy stored in object and contact",
        "stored_energy_j";
    port_work: f64, "J", live,
        "work of the held force through the port since the start; positive into the object",
        "port_work_j";
    virtual_force_work: f64, "J", live,
        "work of the virtual force f_V on the object since the start",
        "virtual_force_work_j";
    outside_work: f64, "J", live,
        "external work since the start: teleports, changed parameters, time without samples, and \
        the leak of intervals with the motors off",
        "outside_work_j";
    original_leak: f64, "J", live,
        "accumulated leak of the spring force on the same motion; positive for generated energy",
        "leak_original_j";
    held_leak: f64, "J", live,
        "accumulated leak of the held force; positive for generated energy",
        "leak_held_j";
    point: [f64; 3], "m", several,
        "contact point of a contact of a world, along the world's axes; NaN without a world",
        "contact_point_1_m" @ 0, "contact_point_2_m" @ 1, "contact_point_3_m" @ 2;
    normal: [f64; 3], "1", several,
        "unit normal of a contact of a world, from the second of its pair to the first",
        "contact_normal_1" @ 0, "contact_normal_2" @ 1, "contact_normal_3" @ 2;
    force: [f64; 3], "N", several,
        "force of a contact of a world on the first of its pair",
        "contact_force_1_n" @ 0, "contact_force_2_n" @ 1, "contact_force_3_n" @ 2;
    pair: u32, "1", several,
        "number of the contact point in a world, the same from tick to tick; 0 without a world",
        "pair";
    phase: Phase, "1", table,
        "predicted phase of the next interval",
        "phase";
}
