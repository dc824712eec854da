//! `[hand]` of a scene file.

use std::ops::Range;
use std::sync::Arc;

use palpate_testbed::recorded_path::RecordedPath;
use serde::Deserialize;
use toml::Spanned;

use super::beside::Files;
use super::fault::Places;
use super::parameter::SceneParameter;
use super::{Grip, Hand, HandForceAt, Intention, SceneDevice, Wave};

/// A fault and the place of the key that has it.
type Fault = (Range<usize>, String);

#[derive(Deserialize, Default)]
#[serde(rename_all = "kebab-case")]
enum HandKind {
    #[default]
    ConstantForce,
    Impedance,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHand {
    kind: Option<Spanned<HandKind>>,
    force_n: Option<Spanned<f64>>,
    force_at: Option<Spanned<HandForceAt>>,
    tremor_n: Option<Spanned<f64>>,
    tremor_hz: Option<Spanned<f64>>,
    release_s: Option<Spanned<f64>>,
    mass_kg: Option<Spanned<f64>>,
    stiffness_n_per_m: Option<Spanned<f64>>,
    damping_n_s_per_m: Option<Spanned<f64>>,
    position_m: Option<Spanned<f64>>,
    swing_m: Option<Spanned<f64>>,
    swing_hz: Option<Spanned<f64>>,
    intention: Option<Spanned<String>>,
}

/// Hand as read from a file, before its device is known.
#[derive(Default)]
pub(super) struct ReadHand {
    hand: Hand,
    force_at: HandForceAt,
    /// Spans of the keys that are valid only for a point mass's hand, each with its error.
    of_a_point_mass: Vec<(Range<usize>, &'static str)>,
    /// Span of the key that is valid only for a pantograph's hand.
    in_the_motors: Option<Range<usize>>,
}

impl ReadHand {
    /// Attaches the hand to `device`. Returns the faults of hand properties that the device does not support.
    pub fn hold(self, device: &mut SceneDevice) -> Vec<Fault> {
        match device {
            SceneDevice::PointMass(device) => {
                device.hand = self.hand;
                let fault = |span| {
                    let message = "force_at = \"motors\" is for a device of kind pantograph, whose motors give torques";
                    (span, message.to_owned())
                };
                self.in_the_motors.map(fault).into_iter().collect()
            }
            SceneDevice::Pantograph(device) => {
                device.force = self.hand.force;
                device.force_at = self.force_at;
                let fault = |(span, what)| {
                    let message = format!(
                        "the hand of a pantograph is a constant force; {what} is for a device of kind point-mass"
                    );
                    (span, message)
                };
                self.of_a_point_mass.into_iter().map(fault).collect()
            }
            // No scene file has one.
            SceneDevice::Recorded { .. } => Vec::new(),
        }
    }
}

impl RawHand {
    /// Returns the hand, or the span of a key that is invalid for its kind, lacks a required key, or names a file
    /// without a motion.
    pub fn read(
        mut self,
        places: &mut Places<SceneParameter>,
        files: Files<'_>,
    ) -> Result<ReadHand, Fault> {
        let of_a_point_mass = self.of_a_point_mass();
        let in_the_motors = self.force_at.as_ref();
        let in_the_motors = in_the_motors.filter(|at| *at.get_ref() == HandForceAt::Motors);
        let in_the_motors = in_the_motors.map(Spanned::span);
        let tremor = wave(
            places,
            [SceneParameter::Tremor, SceneParameter::TremorFrequency],
            [self.tremor_n.take(), self.tremor_hz.take()],
            "a tremor needs both tremor_n and tremor_hz",
        )?;
        let force = places.take_or(SceneParameter::HandForce, self.force_n.take(), 0.0);
        let force_at = self.force_at.take();
        let force_at = force_at.map(Spanned::into_inner).unwrap_or_default();
        let release = self.release_s.take();
        let release = release.map(|release| places.take(SceneParameter::Release, release));
        let kind = self.kind.take();
        let grip = match kind.map(Spanned::into_inner).unwrap_or_default() {
            HandKind::ConstantForce => {
                self.refuse_grip()?;
                None
            }
            HandKind::Impedance => Some(self.grip(places, files)?),
        };
        Ok(ReadHand {
            hand: Hand {
                force,
                tremor,
                grip,
                release,
            },
            force_at,
            of_a_point_mass,
            in_the_motors,
        })
    }

    /// Returns the spans of the keys that are valid only for a point mass's hand, each with its error.
    fn of_a_point_mass(&self) -> Vec<(Range<usize>, &'static str)> {
        let kind = self.kind.as_ref();
        let impedance = kind.filter(|kind| matches!(kind.get_ref(), HandKind::Impedance));
        [
            (impedance.map(Spanned::span), "kind = \"impedance\""),
            (self.tremor_n.as_ref().map(Spanned::span), "a tremor"),
            (self.release_s.as_ref().map(Spanned::span), "release_s"),
        ]
        .into_iter()
        .filter_map(|(span, what)| Some((span?, what)))
        .collect()
    }

    /// Rejects the first key of a grip, which a constant force lacks.
    fn refuse_grip(self) -> Result<(), Fault> {
        let of_a_grip = [
            self.mass_kg,
            self.stiffness_n_per_m,
            self.damping_n_s_per_m,
            self.position_m,
            self.swing_m,
            self.swing_hz,
        ];
        let numbers = of_a_grip.into_iter().flatten().map(|key| key.span());
        let intention = self.intention.map(|key| key.span());
        if let Some(span) = numbers.chain(intention).min_by_key(|span| span.start) {
            let message = "a hand of kind constant-force does not use this; \
                           kind = \"impedance\" does";
            return Err((span, message.into()));
        }
        Ok(())
    }

    /// Returns the grip of an impedance, or the span of a key that its intention excludes or lacks.
    fn grip(self, places: &mut Places<SceneParameter>, files: Files<'_>) -> Result<Grip, Fault> {
        let beside_recording = [&self.position_m, &self.swing_m, &self.swing_hz];
        if let (Some(_), Some(key)) = (
            &self.intention,
            beside_recording.into_iter().flatten().next(),
        ) {
            let message = "the recorded intention already sets the position of the hand";
            return Err((key.span(), message.into()));
        }
        Ok(Grip {
            mass: places.take_or(SceneParameter::HandMass, self.mass_kg, 0.0),
            stiffness: places.take_or(SceneParameter::HandStiffness, self.stiffness_n_per_m, 0.0),
            damping: places.take_or(SceneParameter::HandDamping, self.damping_n_s_per_m, 0.0),
            intention: match self.intention {
                Some(name) => Intention::Recorded(recorded(&name, files)?),
                None => Intention::Place {
                    position: places.take_or(SceneParameter::HandPosition, self.position_m, 0.0),
                    swing: wave(
                        places,
                        [SceneParameter::Swing, SceneParameter::SwingFrequency],
                        [self.swing_m, self.swing_hz],
                        "a swing needs both swing_m and swing_hz",
                    )?,
                },
            },
        })
    }
}

/// Returns amplitude and frequency, both or neither; if only one is given, its span.
fn wave(
    places: &mut Places<SceneParameter>,
    names: [SceneParameter; 2],
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

/// The motion in a file that the scene names, its times counted from its first sample.
fn recorded(name: &Spanned<String>, files: Files<'_>) -> Result<Arc<RecordedPath>, Fault> {
    let fault = |message: String| (name.span(), message);
    let file = name.get_ref();
    let text = files(file).map_err(|error| fault(format!("{file} cannot be read: {error}")))?;
    let trace = palpate_record::trace::read(text.as_bytes(), file)
        .map_err(|error| fault(error.to_string()))?;
    let start = trace.t_s.first().copied().unwrap_or(0.0);
    let times: Vec<f64> = trace.t_s.iter().map(|time| time - start).collect();
    RecordedPath::new(&times, &trace.position_m)
        .map(Arc::new)
        .map_err(|error| fault(format!("{file}: {error}")))
}
