//! Device files: a linkage as a user describes it.

use std::ops::Range;

use palpate_testbed::InvalidParameter;
use palpate_testbed::pantograph::kinematics::{Assembly, Origin};
use palpate_testbed::pantograph::{
    Actuation, Geometry, Link, Pantograph, PantographParameter as Parameter, PantographParams, Pid,
    SafetyBox,
};
use serde::de::{Error as _, Expected, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::fault::{Places, SceneError, in_plain_words};
use super::linkage::Linkage;
use super::toml_reader;

/// The version of device files this crate reads.
const FORMAT: i64 = 1;

/// The version alone: a file of another version may have keys this one does not know.
#[derive(Deserialize)]
struct RawVersion {
    device_format: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDeviceFile {
    #[serde(rename = "device_format")]
    _device_format: i64,
    title: String,
    geometry: RawGeometry,
    home: RawHome,
    proximal: RawLinks,
    distal: RawLinks,
    end_point: RawEndPoint,
    motors: RawMotors,
    #[serde(default)]
    friction: RawFriction,
    gravity_m_per_s2: Option<Spanned<Pair>>,
    hold_x: Option<RawHoldX>,
    safety_box: Option<RawBox>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGeometry {
    proximal_m: Spanned<f64>,
    distal_m: Spanned<f64>,
    base_m: Spanned<f64>,
    #[serde(default)]
    assembly: RawAssembly,
    #[serde(default)]
    origin: RawOrigin,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
enum RawAssembly {
    #[default]
    Far,
    Near,
}

#[derive(Deserialize, Default)]
enum RawOrigin {
    #[default]
    #[serde(rename = "motor-1")]
    Motor1,
    #[serde(rename = "centre")]
    Centre,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHome {
    angles_deg: Spanned<Pair>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLinks {
    mass_kg: Spanned<OnArms>,
    centre: Option<Spanned<OnArms>>,
    inertia_kg_m2: Option<Spanned<OnArms>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEndPoint {
    mass_kg: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMotors {
    rotor_inertia_kg_m2: Spanned<f64>,
    torque_limit_n_m: Option<Spanned<f64>>,
    counts_per_rev: Option<Spanned<f64>>,
    #[serde(default)]
    actuation: RawActuation,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
enum RawActuation {
    Ideal,
    TruePose,
    #[default]
    MeasuredPose,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawFriction {
    coulomb_n_m: Option<Spanned<f64>>,
    viscous_n_m_s_per_rad: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHoldX {
    proportional_n_per_m: Spanned<f64>,
    integral_n_per_m_s: Spanned<f64>,
    derivative_n_s_per_m: Spanned<f64>,
    limit_n: Spanned<f64>,
}

/// The bounds of a safety box, counted from home; without one there is no bound.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBox {
    x_m: Option<Spanned<Pair>>,
    y_m: Option<Spanned<Pair>>,
}

/// Two numbers.
#[derive(Clone, Copy)]
struct Pair([f64; 2]);

/// A value of the links on both arms: one number, or one for each arm.
#[derive(Clone, Copy)]
struct OnArms([f64; 2]);

impl RawBox {
    /// The box, or the place and the fault of a bound.
    pub(super) fn read(self) -> Result<SafetyBox, (Range<usize>, String)> {
        let bounds = |value: Option<Spanned<Pair>>, key: &str| match value {
            None => Ok([f64::NEG_INFINITY, f64::INFINITY]),
            Some(bounds) => {
                let Pair([low, high]) = *bounds.get_ref();
                // Home is where the device can always be put.
                if low < 0.0 && high > 0.0 {
                    Ok([low, high])
                } else {
                    Err((
                        bounds.span(),
                        format!(
                            "{key} is [{low}, {high}], but must be one bound below 0 and one above: \
                             bounds are relative to home, which is inside"
                        ),
                    ))
                }
            }
        };
        Ok(SafetyBox {
            x: bounds(self.x_m, "x_m")?,
            y: bounds(self.y_m, "y_m")?,
        })
    }
}

/// The links of both arms; where the file is silent they are uniform rods.
fn links(
    places: &mut Places<Parameter>,
    names: [Parameter; 3],
    raw: RawLinks,
    length: f64,
) -> [Link; 2] {
    let mass = places.take(names[0], raw.mass_kg).0;
    let centre = raw.centre.map(|centre| places.take(names[1], centre).0);
    let inertia = raw
        .inertia_kg_m2
        .map(|value| places.take(names[2], value).0);
    [0, 1].map(|arm| {
        let rod = Link::rod(mass[arm], length);
        Link {
            mass: rod.mass,
            centre: centre.map_or(rod.centre, |centre| centre[arm]),
            inertia: inertia.map_or(rod.inertia, |inertia| inertia[arm]),
        }
    })
}

impl Linkage {
    /// Reads a linkage from the text of a device file called `name`.
    ///
    /// # Errors
    /// The first error, with its line, its column and the allowed values.
    pub fn parse(name: &str, source: &str) -> Result<Self, SceneError> {
        let fault =
            |span: Range<usize>, message: String| SceneError::at(name, source, span, message);
        check_format(source).map_err(|(span, message)| fault(span, message))?;
        let mut raw: RawDeviceFile = toml_reader::from_text(source).map_err(|error| {
            fault(
                error.span().unwrap_or(0..0),
                in_plain_words(error.message()),
            )
        })?;
        let title = std::mem::take(&mut raw.title);
        let (raw_hold_x, raw_box) = (raw.hold_x.take(), raw.safety_box.take());
        let mut places = Places::<Parameter>::default();
        let params = params(&mut places, raw);
        let hold_x = raw_hold_x.map(|raw| pid(&mut places, raw));
        let safety_box = raw_box
            .map(RawBox::read)
            .transpose()
            .map_err(|(span, message)| fault(span, message))?;
        let out_of_range = |error: InvalidParameter<Parameter>| {
            let (span, message) = out_of_range(&places, error);
            fault(span, message)
        };
        let device = Pantograph::new(params).map_err(out_of_range)?;
        if let Some(pid) = hold_x {
            device.with_pid(pid).map_err(out_of_range)?;
        }
        Ok(Self {
            title,
            params,
            hold_x,
            safety_box,
            keys: listed(source),
        })
    }
}

/// Rejects a file of another version, with the span and the message of the fault.
fn check_format(source: &str) -> Result<(), (Range<usize>, String)> {
    if let Ok(RawVersion { device_format }) = toml_reader::from_text(source)
        && *device_format.get_ref() != FORMAT
    {
        return Err((
            device_format.span(),
            format!(
                "device_format is {}, but this version reads {FORMAT} only",
                device_format.get_ref()
            ),
        ));
    }
    Ok(())
}

/// Returns the lengths of the links and the base, with the assembly and the origin.
fn geometry(places: &mut Places<Parameter>, raw: RawGeometry) -> Geometry {
    Geometry {
        proximal: places.take(Parameter::Proximal, raw.proximal_m),
        distal: places.take(Parameter::Distal, raw.distal_m),
        base: places.take(Parameter::Base, raw.base_m),
        assembly: match raw.assembly {
            RawAssembly::Far => Assembly::Far,
            RawAssembly::Near => Assembly::Near,
        },
        origin: match raw.origin {
            RawOrigin::Motor1 => Origin::Motor1,
            RawOrigin::Centre => Origin::Centre,
        },
    }
}

/// Returns the parameters of the linkage, unchecked.
fn params(places: &mut Places<Parameter>, raw: RawDeviceFile) -> PantographParams {
    let geometry = geometry(places, raw.geometry);
    PantographParams {
        geometry,
        home: places
            .take(Parameter::Home, raw.home.angles_deg)
            .0
            .map(f64::to_radians),
        proximal: links(
            places,
            [
                Parameter::ProximalMass,
                Parameter::ProximalCentre,
                Parameter::ProximalInertia,
            ],
            raw.proximal,
            geometry.proximal,
        ),
        distal: links(
            places,
            [
                Parameter::DistalMass,
                Parameter::DistalCentre,
                Parameter::DistalInertia,
            ],
            raw.distal,
            geometry.distal,
        ),
        rotor_inertia: places.take(Parameter::RotorInertia, raw.motors.rotor_inertia_kg_m2),
        end_point_mass: places.take(Parameter::EndPointMass, raw.end_point.mass_kg),
        viscous_friction: places.take_or(
            Parameter::ViscousFriction,
            raw.friction.viscous_n_m_s_per_rad,
            0.0,
        ),
        coulomb_friction: places.take_or(Parameter::CoulombFriction, raw.friction.coulomb_n_m, 0.0),
        max_torque: places.take_or(
            Parameter::MaxTorque,
            raw.motors.torque_limit_n_m,
            f64::INFINITY,
        ),
        counts_per_rev: raw
            .motors
            .counts_per_rev
            .map(|counts| places.take(Parameter::CountsPerRev, counts)),
        actuation: match raw.motors.actuation {
            RawActuation::Ideal => Actuation::Ideal,
            RawActuation::TruePose => Actuation::MotorsAtTruePose,
            RawActuation::MeasuredPose => Actuation::MotorsAtMeasuredPose,
        },
        gravity: places
            .take_or(Parameter::Gravity, raw.gravity_m_per_s2, Pair([0.0, 0.0]))
            .0,
    }
}

/// Returns the controller that holds x at home.
fn pid(places: &mut Places<Parameter>, raw: RawHoldX) -> Pid {
    Pid {
        target: 0.0,
        proportional: places.take(Parameter::Proportional, raw.proportional_n_per_m),
        integral: places.take(Parameter::Integral, raw.integral_n_per_m_s),
        derivative: places.take(Parameter::Derivative, raw.derivative_n_s_per_m),
        max_force: places.take(Parameter::MaxForce, raw.limit_n),
    }
}

/// Returns the span and the message of a parameter that is out of range.
fn out_of_range(
    places: &Places<Parameter>,
    error: InvalidParameter<Parameter>,
) -> (Range<usize>, String) {
    let (place, key) = key_of(error.name);
    let span = places.0.get(&place).cloned().unwrap_or(0..0);
    // Angles are written in degrees.
    let value = if place == Parameter::Home {
        String::new()
    } else {
        format!(" is {}, but", error.value)
    };
    (span, format!("{key}{value} must be {}", error.allowed))
}

/// Returns the file parameter that corresponds to a testbed parameter, and its name in the file.
fn key_of(parameter: Parameter) -> (Parameter, &'static str) {
    let key = match parameter {
        // A rotor's inertia may be 0 if its link turns with it.
        Parameter::TurningInertia => {
            return (
                Parameter::RotorInertia,
                "rotor_inertia_kg_m2 together with the inertia of the proximal link",
            );
        }
        Parameter::Proximal => "proximal_m",
        Parameter::Distal => "distal_m",
        Parameter::Base => "base_m",
        Parameter::Home => "angles_deg",
        Parameter::ProximalMass => "mass_kg",
        Parameter::ProximalCentre => "centre",
        Parameter::ProximalInertia => "inertia_kg_m2",
        Parameter::DistalMass => "mass_kg",
        Parameter::DistalCentre => "centre",
        Parameter::DistalInertia => "inertia_kg_m2",
        Parameter::RotorInertia => "rotor_inertia_kg_m2",
        Parameter::EndPointMass => "mass_kg",
        Parameter::ViscousFriction => "viscous_n_m_s_per_rad",
        Parameter::CoulombFriction => "coulomb_n_m",
        Parameter::MaxTorque => "torque_limit_n_m",
        Parameter::CountsPerRev => "counts_per_rev",
        Parameter::Gravity => "gravity_m_per_s2",
        Parameter::Proportional => "proportional_n_per_m",
        Parameter::Integral => "integral_n_per_m_s",
        Parameter::Derivative => "derivative_n_s_per_m",
        Parameter::MaxForce => "limit_n",
        // No key of a file gives these.
        Parameter::Angles
        | Parameter::Rates
        | Parameter::UserForce
        | Parameter::SafetyBox
        | Parameter::Target => parameter.name(),
    };
    (parameter, key)
}

/// Every key of a file that has been read, with the names of its tables, and its value.
fn listed(source: &str) -> Vec<(String, String)> {
    let mut keys = Vec::new();
    for (name, value) in source.parse::<toml::Table>().unwrap_or_default() {
        match value {
            toml::Value::Table(table) => keys.extend(
                table
                    .into_iter()
                    .map(|(key, value)| (format!("{name}.{key}"), value.to_string())),
            ),
            value => keys.push((name, value.to_string())),
        }
    }
    keys
}

/// Reads exactly two numbers; `visitor` describes the expected value.
fn two<'de, A: SeqAccess<'de>>(mut seq: A, visitor: &dyn Expected) -> Result<[f64; 2], A::Error> {
    let mut values = [0.0; 2];
    for (index, value) in values.iter_mut().enumerate() {
        *value = seq
            .next_element()?
            .ok_or_else(|| A::Error::invalid_length(index, visitor))?;
    }
    let mut length = 2;
    while seq.next_element::<IgnoredAny>()?.is_some() {
        length += 1;
    }
    if length == 2 {
        Ok(values)
    } else {
        Err(A::Error::invalid_length(length, visitor))
    }
}

impl<'de> Deserialize<'de> for Pair {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Two;
        impl<'de> Visitor<'de> for Two {
            type Value = Pair;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a list of two numbers")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Pair, A::Error> {
                two(seq, &self).map(Pair)
            }
        }
        deserializer.deserialize_seq(Two)
    }
}

impl<'de> Deserialize<'de> for OnArms {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrTwo;
        impl<'de> Visitor<'de> for NumberOrTwo {
            type Value = OnArms;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a number, or a list of two, one for each arm")
            }
            fn visit_f64<E>(self, value: f64) -> Result<OnArms, E> {
                Ok(OnArms([value; 2]))
            }
            fn visit_i64<E>(self, value: i64) -> Result<OnArms, E> {
                Ok(OnArms([value as f64; 2]))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<OnArms, A::Error> {
                two(seq, &self).map(OnArms)
            }
        }
        deserializer.deserialize_any(NumberOrTwo)
    }
}
