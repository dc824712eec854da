//! The joints of a world.

use palpate_world::{Body, Joint, JointKind, JointLaw, Vector, WorldField, WorldPart};
use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use super::shape::unit;

/// Name of the world as a joint's counterpart.
const WORLD: &str = "world";

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawKind {
    Hinge,
    Slider,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawJoint {
    kind: RawKind,
    between: Spanned<[String; 2]>,
    point_m: Option<Spanned<Vector>>,
    axis: Spanned<Vector>,
    stiffness_n_per_m: Spanned<f64>,
    damping_n_s_per_m: Option<Spanned<f64>>,
    span_m: Spanned<f64>,
    spring_n_per_m: Option<Spanned<f64>>,
    spring_n_m_per_rad: Option<Spanned<f64>>,
    rest_m: Option<Spanned<f64>>,
    rest_rad: Option<Spanned<f64>>,
    along_damping_n_s_per_m: Option<Spanned<f64>>,
    along_damping_n_m_s_per_rad: Option<Spanned<f64>>,
    limits_m: Option<Spanned<[f64; 2]>>,
    limits_rad: Option<Spanned<[f64; 2]>>,
}

impl Reading {
    pub(crate) fn joint(&mut self, index: usize, raw: Spanned<RawJoint>, bodies: &[Body]) -> Joint {
        let place = WorldPart::Joint(index);
        self.places.part(place, raw.span());
        let raw = raw.into_inner();
        let (kind, word) = match raw.kind {
            RawKind::Hinge => (JointKind::Hinge, "hinge"),
            RawKind::Slider => (JointKind::Slider, "slider"),
        };
        let span = raw.between.span();
        let [body, against] = self.places.take(place, WorldField::Between, raw.between);
        if body == WORLD {
            let message = "the first name must be a moving body; \"world\" may be the second";
            self.fault(span, message);
        } else if bodies.iter().any(|body| body.name == WORLD) {
            let message = "\"world\" is the fixed world, but a body has that name; rename the body";
            self.fault(span, message);
        }
        let mut of_kind = OfKind {
            reading: self,
            place,
            word,
            is_hinge: kind == JointKind::Hinge,
        };
        let law = JointLaw {
            spring: of_kind
                .one(
                    WorldField::Spring,
                    ["spring_n_per_m", "spring_n_m_per_rad"],
                    [raw.spring_n_per_m, raw.spring_n_m_per_rad],
                )
                .unwrap_or(0.0),
            rest: of_kind
                .one(
                    WorldField::Rest,
                    ["rest_m", "rest_rad"],
                    [raw.rest_m, raw.rest_rad],
                )
                .unwrap_or(0.0),
            along_damping: of_kind
                .one(
                    WorldField::AlongDamping,
                    ["along_damping_n_s_per_m", "along_damping_n_m_s_per_rad"],
                    [raw.along_damping_n_s_per_m, raw.along_damping_n_m_s_per_rad],
                )
                .unwrap_or(0.0),
            limits: of_kind.one(
                WorldField::Limits,
                ["limits_m", "limits_rad"],
                [raw.limits_m, raw.limits_rad],
            ),
            stiffness: self
                .places
                .take(place, WorldField::Stiffness, raw.stiffness_n_per_m),
            damping: raw.damping_n_s_per_m.map_or(0.0, |damping| {
                self.places.take(place, WorldField::Damping, damping)
            }),
            span: self.places.take(place, WorldField::Span, raw.span_m),
        };
        let middle = bodies.iter().find(|other| other.name == body);
        Joint {
            point: raw
                .point_m
                .map_or(middle.map_or([0.0; 3], |body| body.position), |point| {
                    self.places.take(place, WorldField::Point, point)
                }),
            axis: unit(self.places.take(place, WorldField::Axis, raw.axis)),
            against: (against != WORLD).then_some(against),
            body,
            kind,
            law,
        }
    }
}

/// Keys of which a slider has one and a hinge the other.
struct OfKind<'a> {
    reading: &'a mut Reading,
    place: WorldPart,
    word: &'static str,
    is_hinge: bool,
}

impl OfKind<'_> {
    /// The value that is of this kind, in the order slider, hinge; the other one is a fault.
    fn one<T>(
        &mut self,
        field: WorldField,
        keys: [&str; 2],
        values: [Option<Spanned<T>>; 2],
    ) -> Option<T> {
        let [of_slider, of_hinge] = values;
        let (own, other, own_key, other_key) = if self.is_hinge {
            (of_hinge, of_slider, keys[1], keys[0])
        } else {
            (of_slider, of_hinge, keys[0], keys[1])
        };
        if let Some(other) = other {
            let message = format!("a {} has {own_key}, not {other_key}", self.word);
            self.reading.fault(other.span(), message);
        }
        own.map(|own| self.reading.places.take(self.place, field, own))
    }
}
