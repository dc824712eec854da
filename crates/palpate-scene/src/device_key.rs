//! The device of a scene file: a point mass, or a linkage from a device file.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::beside::{Files, beside_scene};
use super::device_file::RawBox;
use super::fault::SceneError;
use super::linkage::Linkage;
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
}

/// What is wrong with the device of a scene.
pub(super) enum DeviceFault {
    /// Something in the scene file, at a place.
    Here(Range<usize>, String),
    /// Something in the device file.
    InDeviceFile(SceneError),
}

impl RawDevice {
    /// The linkage of a device of kind `pantograph` in the scene file called `scene`; `files` gives
    /// the text of its own file. A point mass, checked to have a mass, has none.
    pub fn linkage(
        &mut self,
        scene: &str,
        files: Files<'_>,
    ) -> Result<Option<Linkage>, DeviceFault> {
        let here = |span, message: &str| Err(DeviceFault::Here(span, message.into()));
        let kind = self.kind.span();
        let (preset, file) = (self.preset.take(), self.file.take());
        let safety_box = self.safety_box.take();
        let linkage = match (self.kind.get_ref(), preset, file) {
            (DeviceKind::PointMass, Some(of), _) | (DeviceKind::PointMass, None, Some(of)) => {
                return here(
                    of.span(),
                    "only a device of kind pantograph has a preset or a file",
                );
            }
            (DeviceKind::PointMass, None, None) => {
                return match (safety_box, &self.mass_kg) {
                    (Some(of), _) => here(
                        of.span(),
                        "only a device of kind pantograph has a safety box",
                    ),
                    (None, Some(_)) => Ok(None),
                    (None, None) => here(kind, "a device of kind point-mass needs mass_kg"),
                };
            }
            (DeviceKind::Pantograph, None, None) => {
                return here(
                    kind,
                    &format!(
                        "a device of kind pantograph needs a preset, one of {}, or a file",
                        presets()
                    ),
                );
            }
            (DeviceKind::Pantograph, Some(_), Some(file)) => {
                return here(file.span(), "a device has a preset or a file, not both");
            }
            (DeviceKind::Pantograph, Some(preset), None) => by_name(&preset)?,
            (DeviceKind::Pantograph, None, Some(file)) => from_file(&file, scene, files)?,
        };
        let of_a_point_mass = [
            &self.mass_kg,
            &self.velocity_m_per_s,
            &self.encoder_quantum_m,
            &self.viscous_n_s_per_m,
            &self.coulomb_n,
            &self.motor_limit_n,
        ];
        if let Some(key) = of_a_point_mass.into_iter().flatten().next() {
            return here(
                key.span(),
                "a pantograph's preset or file says this; only position_m and safety_box stand \
                 beside it",
            );
        }
        let Some(safety_box) = safety_box else {
            return Ok(Some(linkage));
        };
        let bounds = safety_box
            .into_inner()
            .read()
            .map_err(|(span, message)| DeviceFault::Here(span, message))?;
        Ok(Some(linkage.in_box(bounds)))
    }
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
