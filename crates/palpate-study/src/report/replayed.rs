//! The replayed motion or hand of a recording, and its accuracy.

use crate::sim::hand_replay::RecordedHand;
use palpate_scene::method::MethodName;
use serde::Serialize;

use crate::text::{counted, digits};

/// A recorded motion, or the hand that made it.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Replayed {
    /// The device follows its recorded path.
    Motion,
    /// The device moves under the new force.
    Hand(HandReport),
}

/// The estimate of a hand.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct HandReport {
    /// Whether the recording contains the held force.
    pub force_recorded: bool,
    /// Mass of the device that the hand moved.
    pub moved_mass_kg: f64,
    /// Number of samples without a recorded position.
    pub bridged_samples: usize,
    /// Bandwidth of the estimate of the hand's force `[Hz]`.
    pub hand_bandwidth_hz: f64,
    /// Standard deviation of the noise of the positions `[m]`.
    pub position_noise_m: f64,
    /// Root mean square of the hand's force `[N]`.
    pub hand_force_n: f64,
    /// Standard deviation of the estimate of the hand's force `[N]`.
    pub hand_force_deviation_n: f64,
    /// Maximum deviation of the recorded motion from its reproduction by the estimated force `[m]`.
    pub given_back_within_m: f64,
    /// Stiffness of the hand's grip on its motion `[N/m]`.
    pub hand_stiffness_n_per_m: f64,
    /// Damping of the hand's grip on its motion `[N s/m]`.
    pub hand_damping_n_s_per_m: f64,
    /// Whether stiffness or damping is assumed.
    pub hand_is_assumed: bool,
    /// Range of the recorded positions.
    pub recorded_span_m: f64,
    /// Largest distance of each method's device from its recorded motion.
    pub largest_departure_m: Vec<f64>,
    /// Methods, in the order of the distances.
    #[serde(skip)]
    methods: Vec<MethodName>,
}

impl Replayed {
    /// Creates the report of a hand, with the largest distance of the device from its recorded motion `[m]` per
    /// method.
    #[must_use]
    pub fn hand(
        hand: &RecordedHand,
        force_recorded: bool,
        is_assumed: bool,
        departures: Vec<(MethodName, f64)>,
    ) -> Self {
        let (known, model) = (hand.uncertainty(), hand.model());
        let (methods, departures) = departures.into_iter().unzip();
        Self::Hand(HandReport {
            force_recorded,
            moved_mass_kg: model.device_mass,
            bridged_samples: hand.unmeasured(),
            hand_bandwidth_hz: known.bandwidth,
            position_noise_m: known.position_noise,
            hand_force_n: known.force,
            hand_force_deviation_n: known.force_deviation,
            given_back_within_m: known.given_back_within,
            hand_stiffness_n_per_m: model.stiffness,
            hand_damping_n_s_per_m: model.damping,
            hand_is_assumed: is_assumed,
            recorded_span_m: hand.span(),
            largest_departure_m: departures,
            methods,
        })
    }

    /// Returns the kind of replay, as the start of a title.
    #[must_use]
    pub fn title(&self) -> &'static str {
        match self {
            Self::Motion => "Motion replay",
            Self::Hand(_) => "Hand replay",
        }
    }

    /// Returns the accuracy of the hand force in a few words.
    #[must_use]
    pub fn known_to(&self) -> Option<String> {
        match self {
            Self::Motion => None,
            Self::Hand(hand) => Some(format!("±{} N", digits(hand.hand_force_deviation_n))),
        }
    }

    /// Returns the text for a terminal.
    pub(super) fn in_words(&self) -> String {
        let hand = match self {
            Self::Motion => {
                return "motion replay: the device repeats its motion, whatever the force (1/m = 0)".into();
            }
            Self::Hand(hand) => hand,
        };
        let micrometres = |metres: f64| digits(1e6 * metres);
        let motor = if hand.force_recorded {
            "recorded force"
        } else {
            "motor off"
        };
        let holds_on = match (hand.hand_stiffness_n_per_m, hand.hand_damping_n_s_per_m) {
            (0.0, 0.0) => "its force does not depend on the device's motion".into(),
            (stiffness, damping) => {
                let assumed = if hand.hand_is_assumed {
                    " (assumed; change it with --hand-stiffness and --hand-damping)"
                } else {
                    ""
                };
                format!("its impedance is {stiffness} N/m and {damping} N s/m{assumed}")
            }
        };
        let bridged = match hand.bridged_samples {
            0 => String::new(),
            samples => format!(
                "{} without a position bridged; ",
                counted(samples, "sample")
            ),
        };
        let millimetres = |metres: f64| digits(1e3 * metres);
        let departures = hand.methods.iter().zip(&hand.largest_departure_m);
        let departed: Vec<String> = departures
            .map(|(method, by)| format!("{method} {} mm", millimetres(*by)))
            .collect();
        format!(
            "hand replay ({motor}): the hand's force on {} kg, {} N rms, is known to ±{} N (1 sigma, up to \
             {} Hz);\n\
             it reproduces the recorded motion within {} um;\n\
             {holds_on};\n\
             {bridged}the device leaves the recorded motion, which spans {} mm, by up to: {}",
            (hand.moved_mass_kg * 1e6).round() / 1e6,
            digits(hand.hand_force_n),
            digits(hand.hand_force_deviation_n),
            digits(hand.hand_bandwidth_hz),
            micrometres(hand.given_back_within_m),
            millimetres(hand.recorded_span_m),
            departed.join(", "),
        )
    }

    /// Returns the metadata for a run file.
    #[must_use]
    pub fn metadata(&self) -> Vec<(String, String)> {
        let hand = match self {
            Self::Motion => return vec![("replay".into(), "motion".into())],
            Self::Hand(hand) => hand,
        };
        let mut lines = vec![("replay".to_owned(), "hand".to_owned())];
        lines.extend(
            [
                ("force_recorded", hand.force_recorded.to_string()),
                ("moved_mass_kg", hand.moved_mass_kg.to_string()),
                ("bridged_samples", hand.bridged_samples.to_string()),
                ("hand_bandwidth_hz", hand.hand_bandwidth_hz.to_string()),
                (
                    "hand_force_deviation_n",
                    hand.hand_force_deviation_n.to_string(),
                ),
                (
                    "hand_stiffness_n_per_m",
                    hand.hand_stiffness_n_per_m.to_string(),
                ),
                (
                    "hand_damping_n_s_per_m",
                    hand.hand_damping_n_s_per_m.to_string(),
                ),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        lines
    }
}
