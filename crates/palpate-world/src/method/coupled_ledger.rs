//! Energy that a device and its proxy gain over an interval.

use super::coupled_motions::Motions;
use super::coupled_proxy::ProxyState;
use crate::dynamics::linkage::Linkage;
use crate::geometry::rigid::Vector3;

/// States of a device and its proxy at the beginning and the end of an interval.
pub(super) struct Moved<'a> {
    pub device: [&'a Motions; 2],
    pub proxy: [&'a ProxyState; 2],
    /// Measured device position at the beginning `[m]`.
    pub measured: &'a Vector3,
}

/// Energy gained over the interval `[J]`.
pub(super) struct Gained {
    /// Work of the proxy's drive.
    pub driven: f64,
    /// Kinetic energy gained by the device.
    pub device: f64,
    /// Kinetic energy gained by the proxy minus that gained by the device.
    pub more: f64,
}

impl Moved<'_> {
    pub fn gained(&self, driven: f64) -> Gained {
        let [start, end] = self.device;
        let [before, after] = self.proxy.map(|proxy| proxy.velocity_offset);
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

    /// Computes the energies for a linkage, with the mass at each position. `work` is the contacts' work on the proxy
    /// minus its rotational part `[J]`.
    pub fn gained_by(&self, linkage: &Linkage, work: f64) -> Gained {
        let [device, proxy] = [false, true].map(|is_proxy| {
            let ends = self.device.iter().zip(self.proxy);
            let mut energies = [0.0; 2];
            for (energy, (device, proxy)) in energies.iter_mut().zip(ends) {
                let mut place = self.measured + device.of(|axis| axis.offset);
                let mut velocity = device.of(|axis| axis.velocity);
                if is_proxy {
                    place += proxy.offset;
                    velocity += proxy.velocity_offset;
                }
                *energy = linkage.kinetic_energy(&device.theta(), [&place, &velocity]);
            }
            energies[1] - energies[0]
        });
        Gained {
            driven: proxy - work,
            device,
            more: proxy - device,
        }
    }
}
