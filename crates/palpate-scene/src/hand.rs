//! `[hand]` of a scene file.

use std::ops::Range;
use std::sync::Arc;

use palpate_testbed::recorded_path::RecordedPath;
use serde::Deserialize;
use toml::Spanned;

use super::beside::Files;
use super::fault::Places;
use super::parameter::SceneParameter;
use super::{Grip, HandForceAt, Wave};

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
    #[serde(default)]
    kind: HandKind,
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

/// What a scene keeps of its hand.
#[derive(Default)]
pub(super) struct ReadHand {
    pub force: f64,
    pub force_at: HandForceAt,
    pub tremor: Option<Wave>,
    pub release: Option<f64>,
    pub grip: Option<Grip>,
}

impl RawHand {
    /// The hand; the place of a key that its kind has no use for, that stands alone, or that names a
    /// file without a motion.
    pub fn read(
        self,
        places: &mut Places<SceneParameter>,
        files: Files<'_>,
    ) -> Result<ReadHand, Fault> {
        let tremor = wave(
            places,
            [SceneParameter::Tremor, SceneParameter::TremorFrequency],
            [self.tremor_n, self.tremor_hz],
            "a tremor needs both tremor_n and tremor_hz",
        )?;
        let force = places.take_or(SceneParameter::HandForce, self.force_n, 0.0);
        let force_at = places.take_or(
            SceneParameter::HandForceAt,
            self.force_at,
            HandForceAt::default(),
        );
        let release = self
            .release_s
            .map(|release| places.take(SceneParameter::Release, release));
        let grip = match self.kind {
            HandKind::ConstantForce => {
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
                    let message = "a hand of kind constant-force has no use for this; \
                                   kind = \"impedance\" has";
                    return Err((span, message.into()));
                }
                None
            }
            HandKind::Impedance => {
                let beside_recording = [&self.position_m, &self.swing_m, &self.swing_hz];
                if let (Some(_), Some(key)) = (
                    &self.intention,
                    beside_recording.into_iter().flatten().next(),
                ) {
                    let message = "the recorded intention says where the hand wants to be";
                    return Err((key.span(), message.into()));
                }
                Some(Grip {
                    mass: places.take_or(SceneParameter::HandMass, self.mass_kg, 0.0),
                    stiffness: places.take_or(
                        SceneParameter::HandStiffness,
                        self.stiffness_n_per_m,
                        0.0,
                    ),
                    damping: places.take_or(
                        SceneParameter::HandDamping,
                        self.damping_n_s_per_m,
                        0.0,
                    ),
                    position: places.take_or(SceneParameter::HandPosition, self.position_m, 0.0),
                    swing: wave(
                        places,
                        [SceneParameter::Swing, SceneParameter::SwingFrequency],
                        [self.swing_m, self.swing_hz],
                        "a swing needs both swing_m and swing_hz",
                    )?,
                    intention: self
                        .intention
                        .map(|name| recorded(&name, files))
                        .transpose()?,
                })
            }
        };
        Ok(ReadHand {
            force,
            force_at,
            tremor,
            release,
            grip,
        })
    }
}

/// Amplitude and frequency, both or neither; the place of one that stands alone.
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
