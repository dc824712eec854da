//! Energy that a device and its proxy gain over an interval.

use super::coupled_motions::Motions;
use super::coupled_proxy::ProxyState;
use super::coupled_turning::TurningWork;
use crate::contact::pairs::Point;
use crate::device::commands::Acting;
use crate::dynamics::ledger::{DeviceLedger, EnergyLedger};
use crate::dynamics::linkage::Linkage;
use crate::dynamics::moving_body::Part;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::Vector3;
use crate::integration::moving::Moving;

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

/// Motion of a tool and its device over an interval that has ended.
pub(super) struct ToolInterval<'a> {
    pub tool: usize,
    pub axes: Axes,
    /// Proxy at the end of the interval.
    pub part: &'a Part,
    /// Force on the device.
    pub acted: Acting,
    /// Displacement of the estimated device `[m]`.
    pub way: Vector3,
    /// Measured displacement of the device `[m]`.
    pub moved: Vector3,
    /// Acceleration of the estimated device with a line hold, else 0 `[m/s^2]`. A force that comes early by a lead does
    /// less work by its product with the lead.
    pub bend: Vector3,
    /// Mean contact force `[N]`.
    pub mean: Vector3,
    /// Lead of the contact force `[N s^2]`.
    pub lead: Vector3,
    /// Mean contact torque about the mass centre `[N m]`.
    pub mean_torque: Vector3,
    /// Rotation of a tool that turns.
    pub turned: Option<Turned>,
    /// Duration `[s]`.
    pub elapsed: f64,
}

/// Rotation of a tool over an interval that has ended.
pub(super) struct Turned {
    pub work: TurningWork,
    /// Torque on the device.
    pub acted: Acting,
    /// Measured rotation vector `[rad]`.
    pub by: Vector3,
}

impl ToolInterval<'_> {
    /// Adds the work of the mean force of contacts and fields on the device. Returns the work that rotated the proxy `[J]`.
    #[inline]
    pub fn hold(&self, points: &[Point], moving: &Moving, ledger: &mut EnergyLedger) -> f64 {
        let Self {
            tool, part, way, ..
        } = self;
        let (tool, elapsed) = (*tool, self.elapsed);
        let turned = self.turned.as_ref();
        let path = turned.map_or(Vector3::zeros(), |turned| turned.work.path);
        // Work that rotated the proxy: by contacts and drive, or by the hand against the contacts.
        let mut to_turn = turned.map_or(0.0, |turned| turned.work.by_proxy - part.turning_error);
        let entry = &mut ledger.devices[tool];
        entry.carried += self.axes.across(&self.mean).dot(way);
        for &number in moving.nearby.recent() {
            let (touch, contact) = (&moving.touches[number], &mut ledger.contacts[number]);
            if let Some(sign) = points[number].sign_on(tool) {
                let past = &touch.past;
                let lead = past.impulse * (0.5 * elapsed) - past.moment;
                let impulse = (past.impulse.dot(way) - lead.dot(&self.bend) * elapsed) * sign;
                let held = if part.led {
                    // The hand rotates the tool against the contact force itself, not against its mean.
                    entry.carried += past.work_on_led_turn;
                    to_turn += past.work_on_led_turn;
                    impulse / elapsed + past.work_on_led_turn
                } else {
                    (impulse + past.angular_impulse.dot(&path)) / elapsed
                };
                contact.held += held;
                entry.held += held;
            }
        }
        let fields = moving.fields.iter().zip(&mut ledger.fields);
        for (field, of_field) in fields.filter(|(field, _)| field.tool == tool) {
            let past = &field.past;
            let lead = past.impulse * (0.5 * elapsed) - past.moment;
            let held = past.impulse.dot(way) / elapsed - lead.dot(&self.bend);
            of_field.held += held;
            entry.held += held;
        }
        to_turn
    }

    /// Adds the work at the port and the energies gained; `work` is that of the contacts without rotation `[J]`.
    #[inline]
    pub fn account(
        &self,
        entry: &mut DeviceLedger,
        motion: &Moved<'_>,
        linkage: Option<&Linkage>,
        work: f64,
    ) {
        let Self {
            part, acted, way, ..
        } = self;
        let by_lead = acted.lead.dot(&self.bend);
        entry.port_work += acted.sent.dot(&self.moved) - by_lead;
        if let Some(Turned { work, acted, by }) = &self.turned {
            entry.port_work += acted.sent.dot(by);
            entry.offset += part.turning_error - work.by_hand;
            entry.velocity_offset += work.gained_more;
            if !part.led {
                entry.unpaid += (self.mean_torque - acted.intended).dot(&work.path);
            }
        }
        entry.unforeseen = entry.port_work + entry.carried - entry.held;
        let gained = match linkage {
            None => motion.gained(part.driven),
            Some(linkage) => motion.gained_by(linkage, work),
        };
        entry.offset += gained.driven - (gained.device - acted.intended.dot(way) + by_lead);
        entry.velocity_offset += gained.more;
        entry.unpaid += self.axes.along(&(self.mean - acted.intended)).dot(way);
        entry.unpaid -= self.axes.along(&(self.lead - acted.lead)).dot(&self.bend);
    }
}
