//! The force of a hand on its device.

use super::Placed;
use crate::world::scene::WorldDevice;
use crate::world::vector::Vec3;

/// Force of the hand on its device `[N]`.
pub(in crate::world) fn hand_force(device: &WorldDevice, time: f64, placed: &Placed) -> Vec3 {
    hand_force_at(device, time, placed.position, placed.velocity)
}

/// Force of the hand on its device at a position with a velocity `[N]`.
pub(in crate::world) fn hand_force_at(
    device: &WorldDevice,
    time: f64,
    position: Vec3,
    velocity: Vec3,
) -> Vec3 {
    let hand = &device.hand;
    let tremor = hand.tremor.each_ref();
    let tremor = tremor.map(|sines| sines.iter().map(|sine| sine.value(time)).sum());
    let tremor = device.out(Vec3(tremor));
    Vec3(std::array::from_fn(|axis| {
        hand.force[axis] + tremor.0[axis]
            - hand.stiffness * (position.0[axis] - hand.rest[axis])
            - hand.damping * velocity.0[axis]
    }))
}
