//! Force fields on devices: potentials that need no contact.

use std::f64::consts::PI;

use super::scene::{InvalidScene, Vector, above_zero, all_finite, not_negative, unit_length};
use super::vector::Vec3;
use crate::InvalidParameter;

/// A force field on a device. The force acts on the centre of its tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceField {
    /// Number of the device.
    pub device: usize,
    /// Potential of the field.
    pub potential: Potential,
}

/// Places that a [`Potential::Spring`] pulls to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Attractor {
    /// A point.
    Point,
    /// The line along this unit vector.
    Line(Vector),
    /// The plane with this unit normal.
    Plane(Vector),
}

/// Potential energy of a device at x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Potential {
    /// K d²/2 up to the distance d = `range`, with a constant force beyond it.
    Spring {
        /// Places with d = 0.
        to: Attractor,
        /// One of them `[m]`.
        at: Vector,
        /// K, above 0 `[N/m]`.
        stiffness: f64,
        /// Range, above 0 `[m]`.
        range: f64,
    },
    /// A/2 (1 − cos(2π q/p)) for 0 ≤ q ≤ (n − 1) p along an axis; K e²/2 at a distance e beyond.
    Detents {
        /// q = 0 `[m]`.
        at: Vector,
        /// Unit vector along q.
        axis: Vector,
        /// n, at least 1.
        positions: u32,
        /// p, above 0 `[m]`.
        period: f64,
        /// A, at least 0 `[J]`.
        amplitude: f64,
        /// K, at least 0 `[N/m]`.
        stiffness: f64,
    },
    /// −F·x
    Constant {
        /// F `[N]`.
        force: Vector,
    },
}

impl ForceField {
    pub(super) fn check(&self, name: &str, devices: usize) -> Result<(), InvalidScene> {
        InvalidParameter::unless(
            self.device < devices,
            format!("{name}.device"),
            self.device as f64,
            "the index of a device of the scene, from 0",
        )?;
        let unit = |axis: &Vector| unit_length(&format!("{name}.axis"), axis);
        match &self.potential {
            Potential::Spring {
                to,
                at,
                stiffness,
                range,
            } => {
                if let Attractor::Line(axis) | Attractor::Plane(axis) = to {
                    unit(axis)?;
                }
                all_finite(&format!("{name}.at"), at)?;
                above_zero(&format!("{name}.stiffness"), &[*stiffness])?;
                above_zero(&format!("{name}.range"), &[*range])
            }
            Potential::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            } => {
                unit(axis)?;
                all_finite(&format!("{name}.at"), at)?;
                above_zero(&format!("{name}.positions"), &[f64::from(*positions)])?;
                above_zero(&format!("{name}.period"), &[*period])?;
                not_negative(&format!("{name}.amplitude"), &[*amplitude])?;
                not_negative(&format!("{name}.stiffness"), &[*stiffness])
            }
            Potential::Constant { force } => all_finite(&format!("{name}.force"), force),
        }
    }

    /// Force on the device at a place `[N]`, and the energy `[J]`.
    pub(super) fn pull(&self, place: Vec3) -> (Vec3, f64) {
        match self.potential {
            Potential::Spring {
                to,
                at,
                stiffness,
                range,
            } => {
                let off = place - Vec3(at);
                let off = match to {
                    Attractor::Point => off,
                    Attractor::Line(axis) => off.across(Vec3(axis)),
                    Attractor::Plane(normal) => Vec3(normal) * Vec3(normal).dot(off),
                };
                let distance = off.norm();
                let within = distance.min(range);
                let held = if distance > 0.0 {
                    within / distance
                } else {
                    1.0
                };
                let energy = stiffness * within * (distance - 0.5 * within);
                (off * (-stiffness * held), energy)
            }
            Potential::Detents {
                at,
                axis,
                positions,
                period,
                amplitude,
                stiffness,
            } => {
                let axis = Vec3(axis);
                let q = axis.dot(place - Vec3(at));
                let last = period * f64::from(positions - 1);
                let (push, energy) = if q < 0.0 {
                    (-stiffness * q, 0.5 * stiffness * q * q)
                } else if q > last {
                    let e = q - last;
                    (-stiffness * e, 0.5 * stiffness * e * e)
                } else {
                    let phase = 2.0 * PI * q / period;
                    let slope = PI * amplitude / period;
                    (-slope * phase.sin(), 0.5 * amplitude * (1.0 - phase.cos()))
                };
                (axis * push, energy)
            }
            Potential::Constant { force } => (Vec3(force), -Vec3(force).dot(place)),
        }
    }
}
