//! The device of a scene file: a point mass, or a linkage from a device file.

use std::ops::Range;
use std::path::Path;

use palpate_testbed::pantograph::SafetyBox;
use serde::Deserialize;
use toml::Spanned;

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
    /// The linkage of a device of kind `pantograph`, whose file is looked for in `folder`. A point
    /// mass, checked to have a mass, has none.
    pub fn linkage(&mut self, folder: Option<&Path>) -> Result<Option<Linkage>, DeviceFault> {
        let here = |span, message: &str| Err(DeviceFault::Here(span, message.into()));
        let kind = self.kind.span();
        let (preset, file) = (self.preset.take(), self.file.take());
        let safety_box = self.safety_box.take();
        let mut linkage = match (self.kind.get_ref(), preset, file) {
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
            (DeviceKind::Pantograph, None, Some(file)) => from_file(&file, folder)?,
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
        if let Some(safety_box) = safety_box {
            let bounds = safety_box
                .into_inner()
                .read()
                .map_err(|(span, message)| DeviceFault::Here(span, message))?;
            linkage
                .keys
                .retain(|(key, _)| !key.starts_with("safety_box."));
            linkage.keys.extend(box_keys(&bounds));
            linkage.safety_box = Some(bounds);
        }
        Ok(Some(linkage))
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

fn from_file(file: &Spanned<String>, folder: Option<&Path>) -> Result<Linkage, DeviceFault> {
    let here = |message| Err(DeviceFault::Here(file.span(), message));
    let Some(folder) = folder else {
        return here(
            "this scene was not read from a folder, so there is no place to look for a device file"
                .into(),
        );
    };
    let path = folder.join(file.get_ref());
    let name = path.display().to_string();
    let text = match std::fs::read(&path) {
        Ok(bytes) => String::from_utf8(bytes),
        Err(error) => return here(format!("the device file {name} cannot be read: {error}")),
    };
    match text {
        Ok(text) => Linkage::parse(&name, &text).map_err(DeviceFault::InDeviceFile),
        Err(_) => here(format!("the device file {name} is not UTF-8 text")),
    }
}

/// A scene's own box as keys.
fn box_keys(bounds: &SafetyBox) -> [(String, String); 2] {
    let text = |[low, high]: [f64; 2]| format!("[{low}, {high}]");
    [
        ("safety_box.x_m".into(), text(bounds.x)),
        ("safety_box.y_m".into(), text(bounds.y)),
    ]
}
