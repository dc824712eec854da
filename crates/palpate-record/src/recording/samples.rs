//! Rows for tests.

use super::{BodyTick, ContactTick, DeviceTick, Flags, Phase, Row, Tick};

/// Returns a row of a tick with two contacts, in which every quantity has a distinct value.
pub fn row(sequence: u64, contact: u32) -> Row {
    let of = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity + 100 * contact) / 3.0;
    let tick = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity) / 3.0;
    let flags = Flags::CONTACT.with(Flags::LIMITED_PULL, true);
    Row {
        tick: Tick {
            sequence,
            time: sequence as f64 * 1e-3,
            lateness: tick(1),
            period: tick(2),
            device_axes: [tick(3), -tick(4), f64::NAN],
            device_orientation: [tick(5), tick(6), tick(7), tick(8)],
            commanded_force: [tick(9), tick(10), tick(11)],
            commanded_torque: [tick(12), tick(13), tick(14)],
            delivered_force: [tick(15), tick(16), tick(17)],
            delivered_torque: [tick(18), tick(19), tick(20)],
            delivered_slope: [tick(24), tick(25), tick(26)],
            tick_duration: tick(21),
            device_round_trip: tick(22),
            generation: 3,
            contacts: 2,
            bodies: 0,
            created_energy: tick(23),
            flags: flags.with(Flags::MISSED_DEADLINE, true),
        },
        contact: ContactTick {
            sequence,
            contact,
            pair: contact + 4,
            flags,
            device_position: of(31),
            object_position: of(32),
            object_velocity: of(33),
            penetration: of(34),
            proxy_shift: of(35),
            force_on_object: of(36),
            force_on_device: of(37),
            stored_energy: of(38),
            port_work: of(39),
            virtual_force_work: of(40),
            outside_work: of(41),
            original_leak: of(42),
            held_leak: of(43),
            point: [of(44), of(45), of(46)],
            normal: [of(47), of(48), of(49)],
            force: [of(50), of(51), of(52)],
            phase: Phase::Leaves,
        },
        ..Row::UNKNOWN
    }
}

/// Returns one of the two devices of a tick, in which every quantity has a distinct value.
pub fn device(sequence: u64, device: u32) -> DeviceTick {
    let of = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity + 100 * device) / 3.0;
    let three = |first: u32| [of(first), of(first + 1), of(first + 2)];
    DeviceTick {
        sequence,
        device,
        devices: 2,
        flags: Flags::DEVICE_FAULT,
        time: of(71),
        round_trip: of(72),
        axes: three(73),
        orientation: [of(76), of(77), of(78), of(79)],
        commanded_force: three(80),
        commanded_torque: three(83),
        delivered_force: three(86),
        delivered_slope: three(92),
        delivered_torque: three(89),
    }
}

/// Returns a body of a tick, in which every quantity has a distinct value.
pub fn body(sequence: u64, body: u32) -> BodyTick {
    let of = |quantity: u32| sequence as f64 * 1e-3 + f64::from(quantity + 100 * body) / 3.0;
    BodyTick {
        sequence,
        body,
        position: [of(61), of(62), of(63)],
        orientation: [of(64), of(65), of(66), of(67)],
        velocity: [of(68), of(69), of(70)],
        angular_velocity: [of(71), of(72), of(73)],
    }
}
