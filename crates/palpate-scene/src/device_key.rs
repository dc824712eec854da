//! The device of a scene file: a point mass, or a linkage from a device file.

use std::ops::Range;

use palpate_core::Parameter;
use serde::Deserialize;
use toml::Spanned;

use super::PointMassDevice;
use super::beside::{Files, beside_scene};
use super::device_file::RawBox;
use super::drivetrain_key::RawDrivetrain;
use super::fault::{Places, SceneError};
use super::linkage::Linkage;
use super::parameter::SceneParameter as Of;
use crate::method::nearest;

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DeviceKind {
    PointMass,
    Pantograph,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDevice {
    pub kind: Spanned<DeviceKind>,
    preset: Option<Spanned<String>>,
    file: Option<Spanned<String>>,
    safety_box: Option<Spanned<RawBox>>,
    pub mass_kg: Option<Spanned<f64>>,
    pub position_m: Option<Spanned<f64>>,
    pub velocity_m_per_s: Option<Spanned<f64>>,
    pub encoder_quantum_m: Option<Spanned<f64>>,
    pub viscous_n_s_per_m: Option<Spanned<f64>>,
    pub coulomb_n: Option<Spanned<f64>>,
    pub motor_limit_n: Option<Spanned<f64>>,
    resonance_hz: Option<Spanned<f64>>,
    resonance_damping_ratio: Option<Spanned<f64>>,
    motor_mass_share: Option<Spanned<f64>>,
    backlash_m: Option<Spanned<f64>>,
    cogging_n: Option<Spanned<f64>>,
    cogging_pitch_m: Option<Spanned<f64>>,
    noise_m: Option<Spanned<f64>>,
}

/// Error in the device of a scene.
pub(super) enum DeviceFault {
    /// In the scene file, with its span.
    Here(Range<usize>, String),
    /// In the device file.
    InDeviceFile(SceneError),
}

/// The device of a scene: what a point mass has, or a linkage has. Neither can have what the other has.
pub(super) enum ReadDevice {
    PointMass(ReadPointMass),
    /// A linkage and where along y from its home it begins `[m]`.
    Pantograph(Linkage, Option<Spanned<f64>>),
}

/// A point mass with the spans of its values.
pub(super) struct ReadPointMass {
    mass: Spanned<f64>,
    position: Option<Spanned<f64>>,
    velocity: Option<Spanned<f64>>,
    encoder_quantum: Option<Spanned<f64>>,
    viscous_friction: Option<Spanned<f64>>,
    coulomb_friction: Option<Spanned<f64>>,
    largest_force: Option<Spanned<f64>>,
    drivetrain: RawDrivetrain,
}

impl ReadPointMass {
    /// A point mass with its defaults.
    pub fn new(mass: Spanned<f64>) -> Self {
        Self {
            mass,
            position: None,
            velocity: None,
            encoder_quantum: None,
            viscous_friction: None,
            coulomb_friction: None,
            largest_force: None,
            drivetrain: RawDrivetrain::default(),
        }
    }

    pub fn device(self, places: &mut Places<Of>) -> PointMassDevice {
        let device = PointMassDevice {
            mass: places.take(Parameter::DeviceMass, self.mass),
            position: places.take_or(Of::DevicePosition, self.position, 0.0),
            velocity: places.take_or(Of::DeviceVelocity, self.velocity, 0.0),
            encoder_quantum: places.take_or(Parameter::EncoderQuantum, self.encoder_quantum, 0.0),
            viscous_friction: places.take_or(Of::ViscousFriction, self.viscous_friction, 0.0),
            coulomb_friction: places.take_or(Of::CoulombFriction, self.coulomb_friction, 0.0),
            largest_force: self
                .largest_force
                .map(|force| places.take(Of::MotorLimit, force)),
            ..PointMassDevice::default()
        };
        self.drivetrain.on(device, places)
    }
}

impl RawDevice {
    /// The device in the scene file called `scene`; `files` gives the text of a linkage's own file.
    pub fn read(self, scene: &str, files: Files<'_>) -> Result<ReadDevice, DeviceFault> {
        match self.kind.get_ref() {
            DeviceKind::PointMass => self.point_mass().map(ReadDevice::PointMass),
            DeviceKind::Pantograph => self.pantograph(scene, files),
        }
    }

    /// The keys of transmission, cogging and noise, taken out.
    fn drivetrain(&mut self) -> RawDrivetrain {
        RawDrivetrain {
            resonance_hz: self.resonance_hz.take(),
            resonance_damping_ratio: self.resonance_damping_ratio.take(),
            motor_mass_share: self.motor_mass_share.take(),
            backlash_m: self.backlash_m.take(),
            cogging_n: self.cogging_n.take(),
            cogging_pitch_m: self.cogging_pitch_m.take(),
            noise_m: self.noise_m.take(),
        }
    }

    fn point_mass(mut self) -> Result<ReadPointMass, DeviceFault> {
        let of_a_linkage = [&self.preset, &self.file];
        if let Some(key) = of_a_linkage.into_iter().flatten().next() {
            return here(
                key.span(),
                "only a device of kind pantograph has a preset or a file",
            );
        }
        if let Some(key) = &self.safety_box {
            return here(
                key.span(),
                "only a device of kind pantograph has a safety box",
            );
        }
        let drivetrain = self.drivetrain();
        if let Some((span, message)) = drivetrain.alone() {
            return here(span, message);
        }
        let Some(mass) = self.mass_kg else {
            return here(
                self.kind.span(),
                "a device of kind point-mass needs mass_kg",
            );
        };
        Ok(ReadPointMass {
            drivetrain,
            mass,
            position: self.position_m,
            velocity: self.velocity_m_per_s,
            encoder_quantum: self.encoder_quantum_m,
            viscous_friction: self.viscous_n_s_per_m,
            coulomb_friction: self.coulomb_n,
            largest_force: self.motor_limit_n,
        })
    }

    fn pantograph(mut self, scene: &str, files: Files<'_>) -> Result<ReadDevice, DeviceFault> {
        let linkage = match (&self.preset, &self.file) {
            (None, None) => {
                return here(
                    self.kind.span(),
                    &format!(
                        "a device of kind pantograph needs a preset, one of {}, or a file",
                        presets()
                    ),
                );
            }
            (Some(_), Some(file)) => {
                return here(file.span(), "a device has a preset or a file, not both");
            }
            (Some(preset), None) => by_name(preset)?,
            (None, Some(file)) => from_file(file, scene, files)?,
        };
        let drivetrain = self.drivetrain();
        let of_a_point_mass = [
            &self.mass_kg,
            &self.velocity_m_per_s,
            &self.encoder_quantum_m,
            &self.viscous_n_s_per_m,
            &self.coulomb_n,
            &self.motor_limit_n,
        ];
        let key = of_a_point_mass.into_iter().flatten().map(Spanned::span);
        if let Some(span) = key.chain(drivetrain.any()).next() {
            return here(
                span,
                "a pantograph's preset or file sets this; only position_m and safety_box can be \
                 added",
            );
        }
        let linkage = match self.safety_box {
            None => linkage,
            Some(safety_box) => {
                let bounds = safety_box.into_inner().read();
                linkage.in_box(bounds.map_err(|(span, message)| DeviceFault::Here(span, message))?)
            }
        };
        Ok(ReadDevice::Pantograph(linkage, self.position_m))
    }
}

fn here<T>(span: Range<usize>, message: &str) -> Result<T, DeviceFault> {
    Err(DeviceFault::Here(span, message.into()))
}

fn presets() -> String {
    Linkage::presets().collect::<Vec<_>>().join(", ")
}

fn by_name(preset: &Spanned<String>) -> Result<Linkage, DeviceFault> {
    let name = preset.get_ref();
    Linkage::preset(name).ok_or_else(|| {
        let known: Vec<_> = Linkage::presets().collect();
        let message = match nearest(name, &known) {
            Some(near) => format!("no preset is called \"{name}\"; did you mean \"{near}\"?"),
            None => format!(
                "no preset is called \"{name}\"; the presets are {}",
                presets()
            ),
        };
        DeviceFault::Here(preset.span(), message)
    })
}

fn from_file(
    file: &Spanned<String>,
    scene: &str,
    files: Files<'_>,
) -> Result<Linkage, DeviceFault> {
    let name = beside_scene(scene, file.get_ref());
    let text = files(file.get_ref()).map_err(|error| {
        let message = format!("the device file {name} cannot be read: {error}");
        DeviceFault::Here(file.span(), message)
    })?;
    Linkage::parse(&name, &text).map_err(DeviceFault::InDeviceFile)
}
