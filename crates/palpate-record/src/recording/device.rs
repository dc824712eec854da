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
        "number of devices of the loop, and of messages on `/device` with the number of this tick",
        "devices";
    flags: Flags, "1", several,
        "flags of this device, one bit each; safety-stopped: its own safety has stopped it",
        "flags";
    time: f64, "s", several,
        "time of this device's last sample since the loop's start; NaN before its first sample",
        "t_s";
    round_trip: f64, "s", several,
        "response time of this device",
        "device_round_trip_s";
    axes: [f64; 3], "m", several,
        "end-point of this device in its own frame; NaN for axes that it lacks",
        "device_axis_1_m" @ 0, "device_axis_2_m" @ 1, "device_axis_3_m" @ 2;
    orientation: [f64; 4], "1", several,
        "unit quaternion from the end-point's axes to this device's frame; NaN if it does not measure it",
        "device_orientation_w" @ 0, "device_orientation_x" @ 1, "device_orientation_y" @ 2,
        "device_orientation_z" @ 3;
    commanded_force: [f64; 3], "N", several,
        "commanded force on this device, after its safety limits",
        "commanded_force_1_n" @ 0, "commanded_force_2_n" @ 1, "commanded_force_3_n" @ 2;
    commanded_torque: [f64; 3], "N m", several,
        "commanded torque on this device, after its safety limits",
        "commanded_torque_1_n_m" @ 0, "commanded_torque_2_n_m" @ 1, "commanded_torque_3_n_m" @ 2;
    delivered_force: [f64; 3], "N", several,
        "held force on this device, as the device reports it; 0 if it refused the command",
        "delivered_force_1_n" @ 0, "delivered_force_2_n" @ 1, "delivered_force_3_n" @ 2;
    delivered_slope: [f64; 3], "N/s", several,
        "slope of the held force on this device, whose mean is the delivered force; 0 for a constant",
        "delivered_slope_1_n_per_s" @ 0, "delivered_slope_2_n_per_s" @ 1, "delivered_slope_3_n_per_s" @ 2;
    delivered_torque: [f64; 3], "N m", several,
        "held torque on this device, as the device reports it; 0 if it refused the command",
        "delivered_torque_1_n_m" @ 0, "delivered_torque_2_n_m" @ 1, "delivered_torque_3_n_m" @ 2;
}
