//! The device and the hand of a scene with one contact along one axis.

use std::ops::Range;

use palpate_core::Parameter;
use toml::Spanned;

use super::beside::{Files, beside_scene};
use super::contact_file::Reading;
use super::device_key::{RawDevice, RawLinkage, TurningKeys, span};
use super::fault::{Places, SceneError};
use super::hand_key::{RawHand, recorded_rest};
use super::linkage::Linkage;
use super::parameter::SceneParameter as Of;
use super::recover::Fault;
use super::{Grip, Hand, Intention, PantographDevice, PointMassDevice, SceneDevice, Wave};
use crate::method::nearest;
use crate::world::per_axis::DeviceAxes;

/// Error in the device of a scene.
enum DeviceFault {
    /// In the scene file, with its span.
    Here(Range<usize>, String),
    /// In the device file.
    InDeviceFile(SceneError),
}

impl Reading<'_> {
    /// Returns the device with its hand.
    pub fn held_device(
        &mut self,
        raw: Spanned<RawDevice>,
        places: &mut Places<Of>,
        files: Files<'_>,
    ) -> SceneDevice {
        let whole = raw.span();
        let mut raw = raw.into_inner();
        for fault in TurningKeys::take(&mut raw).refused() {
            self.fault(fault);
        }
        match raw.linkage.take() {
            Some(linkage) => self.pantograph(linkage, raw, places, files),
            None => SceneDevice::PointMass(self.point_mass(whole, raw, places, files)),
        }
    }

    /// Returns a point mass in its hand; `whole` is the span of the device.
    fn point_mass(
        &mut self,
        whole: Range<usize>,
        mut raw: RawDevice,
        places: &mut Places<Of>,
        files: Files<'_>,
    ) -> PointMassDevice {
        let of_a_linkage = [
            ("device.safety_box", span(&raw.safety_box)),
            ("device.hand.force_at", span(&raw.hand.force_at)),
        ];
        self.refuse(&of_a_linkage, "is for a device with a linkage");
        let mass = match &raw.mass_kg {
            Some(mass) => self.one_number("device.mass_kg", mass),
            None => {
                let message = "a device needs mass_kg, mass_table or linkage";
                self.in_table("device.0", (whole, message.into()));
                None
            }
        };
        let quantum = raw.quantum_m.as_ref();
        let quantum = quantum.and_then(|quantum| self.one_number("device.quantum_m", quantum));
        let start = raw.position_m.as_ref().map_or([0.0; 3], |at| *at.get_ref());
        let position = self.place("device.position_m", raw.position_m.take());
        let velocity = raw.velocity_m_per_s.take();
        let velocity = self.along("device.velocity_m_per_s", velocity, [0.0; 3]);
        if let Some((span, message)) = raw.drivetrain.alone() {
            self.in_table("device.0.drivetrain", (span, message.into()));
        }
        let hand = self.hand(raw.hand, start, places, files);
        let hand = self.or("device.0.hand", hand, Hand::default());
        let device = PointMassDevice {
            mass: places.take_or(Parameter::DeviceMass, mass, 1.0),
            position: places.take_or(Of::DevicePosition, position, 0.0),
            velocity: places.take_or(Of::DeviceVelocity, velocity, 0.0),
            encoder_quantum: places.take_or(Parameter::EncoderQuantum, quantum, 0.0),
            noise: places.take_or(Of::SensorNoise, raw.noise_m, 0.0),
            hand,
            ..PointMassDevice::default()
        };
        raw.drivetrain.on(device, places)
    }

    /// Returns the hand of a point mass that starts at `start` `[m]`.
    fn hand(
        &mut self,
        mut raw: RawHand,
        start: [f64; 3],
        places: &mut Places<Of>,
        files: Files<'_>,
    ) -> Result<Hand, Fault> {
        let tremor = wave(
            places,
            [Of::Tremor, Of::TremorFrequency],
            [raw.tremor_n.take(), raw.tremor_hz.take()],
            "a tremor needs both tremor_n and tremor_hz",
        )?;
        let force = self.along("device.hand.force_n", raw.force_n.take(), [0.0; 3]);
        let release = raw.release_s.take();
        Ok(Hand {
            force: places.take_or(Of::HandForce, force, 0.0),
            tremor,
            release: release.map(|release| places.take(Of::Release, release)),
            grip: if raw.has_grip() {
                Some(self.grip(raw, start, places, files)?)
            } else {
                None
            },
        })
    }

    /// Returns mass, spring and damper of the hand, or the span of a key that its recorded rest excludes.
    fn grip(
        &mut self,
        raw: RawHand,
        start: [f64; 3],
        places: &mut Places<Of>,
        files: Files<'_>,
    ) -> Result<Grip, Fault> {
        let beside_recording = [span(&raw.rest_m), span(&raw.swing_m), span(&raw.swing_hz)];
        if let (Some(_), Some(key)) = (
            &raw.rest_file,
            beside_recording.into_iter().flatten().next(),
        ) {
            let message = "rest_file already sets where the hand pulls to";
            return Err((key, message.into()));
        }
        let at_start = self.axis.along(start);
        let rest = self.along("device.hand.rest_m", raw.rest_m, start);
        let swing = self.along("device.hand.swing_m", raw.swing_m, [0.0; 3]);
        Ok(Grip {
            mass: places.take_or(Of::HandMass, raw.mass_kg, 0.0),
            stiffness: places.take_or(Of::HandStiffness, raw.stiffness_n_per_m, 0.0),
            damping: places.take_or(Of::HandDamping, raw.damping_n_s_per_m, 0.0),
            intention: match raw.rest_file {
                Some(name) => Intention::Recorded(recorded_rest(&name, files)?),
                None => Intention::Place {
                    position: places.take_or(Of::HandPosition, rest, at_start),
                    swing: wave(
                        places,
                        [Of::Swing, Of::SwingFrequency],
                        [swing, raw.swing_hz],
                        "a swing needs both swing_m and swing_hz",
                    )?,
                },
            },
        })
    }

    /// Returns a pantograph along y that a hand pushes.
    fn pantograph(
        &mut self,
        linkage: Spanned<RawLinkage>,
        mut raw: RawDevice,
        places: &mut Places<Of>,
        files: Files<'_>,
    ) -> SceneDevice {
        let at = linkage.span();
        if self.axis.axes != DeviceAxes::Y {
            let message = "a device with a linkage moves along y: axes = [\"y\"]";
            self.fault((span(&raw.axes).unwrap_or(at.clone()), message.into()));
        }
        self.refuse_beside_linkage(&raw);
        let position = self.place("device.position_m", raw.position_m.take());
        let force = self.along("device.hand.force_n", raw.hand.force_n.take(), [0.0; 3]);
        let force = places.take_or(Of::HandForce, force, 0.0);
        let force_at = raw.hand.force_at.map(Spanned::into_inner);
        let start = position.as_ref().map_or(at.clone(), Spanned::span);
        let position = places.take_or(Of::DevicePosition, position, 0.0);
        let linkage = named_linkage(&linkage, &self.source.name, files).and_then(|linkage| {
            let Some(bounds) = raw.safety_box else {
                return Ok(linkage);
            };
            let bounds = bounds.into_inner().read();
            let bounds = bounds.map_err(|(span, message)| DeviceFault::Here(span, message))?;
            Ok(linkage.in_box(bounds))
        });
        let linkage = match linkage {
            Ok(linkage) => linkage,
            Err(fault) => {
                match fault {
                    DeviceFault::Here(span, message) => self.in_table("device.0", (span, message)),
                    DeviceFault::InDeviceFile(error) => self.faults.push(error),
                }
                // With a valid mass, the remaining keys can be checked.
                return SceneDevice::PointMass(PointMassDevice {
                    mass: 1.0,
                    ..PointMassDevice::default()
                });
            }
        };
        let mass = linkage.effective_mass(position);
        let mass = mass.map_err(|error| (start, error.to_string()));
        SceneDevice::Pantograph(PantographDevice {
            mass: self.or("device.0", mass, 1.0),
            linkage,
            position,
            encoder_quantum: 0.0,
            force,
            force_at: force_at.unwrap_or_default(),
        })
    }

    /// Rejects the keys of a device that a linkage sets, and those of a hand that only pushes.
    fn refuse_beside_linkage(&mut self, raw: &RawDevice) {
        let set_by_it = [
            ("device.mass_kg", span(&raw.mass_kg)),
            ("device.velocity_m_per_s", span(&raw.velocity_m_per_s)),
            ("device.quantum_m", span(&raw.quantum_m)),
            ("device.noise_m", span(&raw.noise_m)),
        ];
        self.refuse(&set_by_it, "is set by the linkage");
        self.refuse(&raw.drivetrain.spans(), "is set by the linkage");
        self.refuse(
            &raw.hand.spans_of_grip(),
            "is for the hand of a point mass; that of a linkage only pushes",
        );
        let others = [
            ("device.hand.tremor_n", span(&raw.hand.tremor_n)),
            ("device.hand.tremor_hz", span(&raw.hand.tremor_hz)),
            ("device.hand.release_s", span(&raw.hand.release_s)),
        ];
        self.refuse(
            &others,
            "is for the hand of a point mass; that of a linkage only pushes",
        );
    }
}

/// Returns amplitude and frequency, both or neither; if only one is given, its span.
fn wave(
    places: &mut Places<Of>,
    names: [Of; 2],
    values: [Option<Spanned<f64>>; 2],
    alone: &str,
) -> Result<Option<Wave>, Fault> {
    match values {
        [Some(amplitude), Some(frequency)] => Ok(Some(Wave {
            amplitude: places.take(names[0], amplitude),
            frequency_hz: places.take(names[1], frequency),
        })),
        [None, None] => Ok(None),
        [Some(key), None] | [None, Some(key)] => Err((key.span(), alone.into())),
    }
}

fn here<T>(span: Range<usize>, message: &str) -> Result<T, DeviceFault> {
    Err(DeviceFault::Here(span, message.into()))
}

/// Returns the linkage of a device in the scene file called `scene`; `files` returns the text of its own file.
fn named_linkage(
    raw: &Spanned<RawLinkage>,
    scene: &str,
    files: Files<'_>,
) -> Result<Linkage, DeviceFault> {
    match (&raw.get_ref().preset, &raw.get_ref().file) {
        (None, None) => here(
            raw.span(),
            &format!("a linkage needs a preset, one of {}, or a file", presets()),
        ),
        (Some(_), Some(file)) => here(file.span(), "a linkage has a preset or a file, not both"),
        (Some(preset), None) => by_name(preset),
        (None, Some(file)) => from_file(file, scene, files),
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
