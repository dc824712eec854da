//! Recorded data of each moving body of a world.

use super::row::part_of_row;

part_of_row! {
    /// Data of one body of a world at one tick. Fixed bodies are left out. After the bodies follow the proxy states
    /// of the tools, which are in contact with the bodies in place of the devices.
    ///
    /// Vectors are along the axes of the world; NaN where there is no value.
    BodyTick as body;

    sequence: u64, "1", several,
        "number of the tick",
        "sequence";
    body: u32, "1", several,
        "number of the body in the order of the scene, from 0; the tool proxies are numbered after the \
        bodies of the scene",
        "body";
    position: [f64; 3], "m", several,
        "position of the body's centre of mass",
        "body_position_1_m" @ 0, "body_position_2_m" @ 1, "body_position_3_m" @ 2;
    orientation: [f64; 4], "1", several,
        "unit quaternion from the body's axes to those of the world",
        "body_orientation_w" @ 0, "body_orientation_x" @ 1, "body_orientation_y" @ 2,
        "body_orientation_z" @ 3;
    velocity: [f64; 3], "m/s", several,
        "velocity of the body's centre of mass",
        "body_velocity_1_m_per_s" @ 0, "body_velocity_2_m_per_s" @ 1, "body_velocity_3_m_per_s" @ 2;
    angular_velocity: [f64; 3], "rad/s", several,
        "angular velocity of the body",
        "body_angular_velocity_1_rad_per_s" @ 0, "body_angular_velocity_2_rad_per_s" @ 1,
        "body_angular_velocity_3_rad_per_s" @ 2;
}
