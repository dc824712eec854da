//! Recorded data of each device of a loop with several devices.

use super::row::part_of_row;
use super::state::Flags;

part_of_row! {
    /// Data of one device at one tick of a loop with several devices. A loop with one device has none of these: its
    /// tick contains all of the data. Columns have the same names as those of a tick.
    ///
    /// Vectors are in the frame of the device itself; NaN where there is no value.
    DeviceTick as device;

    sequence: u64, "1", several,
        "number of the tick",
        "sequence";
    device: u32, "1", several,
        "number of the device: 0, 1, 2, ..., in the order of the scene",
        "device";
    devices: u32, "1", several,
        "number of devices of the loop: so many messages on `/device` have the number of this tick",
        "devices";
    flags: Flags, "1", several,
        "what is to be said of this device, a bit each; safety-stopped: its own safety has stopped",
        "flags";
    time: f64, "s", several,
        "when this device was sampled last, since the loop's start; NaN before its first sample",
        "t_s";
    round_trip: f64, "s", several,
        "how long this device took to answer",
        "device_round_trip_s";
    axes: [f64; 3], "m", several,
        "end-point of this device in its own frame; NaN beyond the axes it has",
        "device_axis_1_m" @ 0, "device_axis_2_m" @ 1, "device_axis_3_m" @ 2;
    orientation: [f64; 4], "1", several,
        "unit quaternion that turns the end-point's own axes into those of this device's frame; NaN where it does not measure it",
        "device_orientation_w" @ 0, "device_orientation_x" @ 1, "device_orientation_y" @ 2,
        "device_orientation_z" @ 3;
    commanded_force: [f64; 3], "N", several,
        "force on this device as the loop commanded it, after the limits of its safety",
        "commanded_force_1_n" @ 0, "commanded_force_2_n" @ 1, "commanded_force_3_n" @ 2;
    commanded_torque: [f64; 3], "N m", several,
        "torque on this device as the loop commanded it, after the limits of its safety",
        "commanded_torque_1_n_m" @ 0, "commanded_torque_2_n_m" @ 1, "commanded_torque_3_n_m" @ 2;
    delivered_force: [f64; 3], "N", several,
        "force on this device that it holds by its own account; 0 where it refused the command",
        "delivered_force_1_n" @ 0, "delivered_force_2_n" @ 1, "delivered_force_3_n" @ 2;
    delivered_torque: [f64; 3], "N m", several,
        "torque on this device that it holds by its own account; 0 where it refused the command",
        "delivered_torque_1_n_m" @ 0, "delivered_torque_2_n_m" @ 1, "delivered_torque_3_n_m" @ 2;
}
