//! The energy that a device and its avatar gain over an interval.

use super::coupled_avatar::Avatar;
use super::coupled_motions::Motions;
use crate::linkage::Linkage;
use crate::rigid::Vector3;

/// An interval of a device and its avatar, from its beginning to its end.
pub(super) struct Moved<'a> {
    pub device: [&'a Motions; 2],
    pub avatar: [&'a Avatar; 2],
    /// Where the device was measured at the beginning `[m]`.
    pub measured: &'a Vector3,
}

/// Energy that came with it `[J]`.
pub(super) struct Gained {
    /// What the avatar's drive has given it,
    pub driven: f64,
    /// what the device has gained of kinetic energy,
    pub device: f64,
    /// and how much more the avatar has.
    pub more: f64,
}

impl Moved<'_> {
    pub fn gained(&self, driven: f64) -> Gained {
        let [start, end] = self.device;
        let [before, after] = self.avatar.map(|avatar| avatar.velocity_offset);
        let [u, v] = self.device.map(|device| device.of(|axis| axis.velocity));
        let kinetic = |device: &Motions, velocity: &Vector3, w: &Vector3| {
            device.weighted(w, &(velocity + 0.5 * w))
        };
        Gained {
            driven,
            device: start.weighted(&(0.5 * (v - u)), &(v + u)),
            more: kinetic(end, &v, &after) - kinetic(start, &u, &before),
        }
    }

    /// Of a linkage, each with the mass of its own place; the contacts' `work` on the avatar, less what has gone into its turn
    /// `[J]`.
    pub fn gained_by(&self, linkage: &Linkage, work: f64) -> Gained {
        let [device, avatar] = [false, true].map(|is_avatar| {
            let ends = self.device.iter().zip(self.avatar);
            let mut energies = [0.0; 2];
            for (energy, (device, avatar)) in energies.iter_mut().zip(ends) {
                let mut place = self.measured + device.of(|axis| axis.offset);
                let mut velocity = device.of(|axis| axis.velocity);
                if is_avatar {
                    place += avatar.offset;
                    velocity += avatar.velocity_offset;
                }
                *energy = linkage.kinetic_energy(&device.theta(), [&place, &velocity]);
            }
            energies[1] - energies[0]
        });
        Gained {
            driven: avatar - work,
            device,
            more: avatar - device,
        }
    }
}
