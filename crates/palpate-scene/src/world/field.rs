//! The force fields of a world.

use palpate_world::{Field, FieldKind, Vector, WorldField, WorldPart};
use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use super::shape::unit;

/// `[[field]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawField {
    on: Spanned<String>,
    potential: RawPotential,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum RawPotential {
    Point {
        at_m: Spanned<Vector>,
        stiffness_n_per_m: Spanned<f64>,
        range_m: Spanned<f64>,
    },
    Line {
        at_m: Spanned<Vector>,
        axis: Spanned<Vector>,
        stiffness_n_per_m: Spanned<f64>,
        range_m: Spanned<f64>,
    },
    Plane {
        at_m: Spanned<Vector>,
        normal: Spanned<Vector>,
        stiffness_n_per_m: Spanned<f64>,
        range_m: Spanned<f64>,
    },
    Detents {
        at_m: Spanned<Vector>,
        axis: Spanned<Vector>,
        positions: Spanned<u32>,
        period_m: Spanned<f64>,
        amplitude_j: Spanned<f64>,
        stiffness_n_per_m: Option<Spanned<f64>>,
    },
    Constant {
        force_n: Spanned<Vector>,
    },
}

impl Reading {
    pub(crate) fn field(&mut self, index: usize, raw: Spanned<RawField>) -> Field {
        let place = WorldPart::Field(index);
        self.places.part(place, raw.span());
        let raw = raw.into_inner();
        let places = &mut self.places;
        let tool = places.take(place, WorldField::Tool, raw.on);
        let kind = match raw.potential {
            RawPotential::Point {
                at_m,
                stiffness_n_per_m,
                range_m,
            } => FieldKind::Point {
                at: places.take(place, WorldField::At, at_m),
                stiffness: places.take(place, WorldField::Stiffness, stiffness_n_per_m),
                range: places.take(place, WorldField::Range, range_m),
            },
            RawPotential::Line {
                at_m,
                axis,
                stiffness_n_per_m,
                range_m,
            } => FieldKind::Line {
                at: places.take(place, WorldField::At, at_m),
                axis: unit(places.take(place, WorldField::Axis, axis)),
                stiffness: places.take(place, WorldField::Stiffness, stiffness_n_per_m),
                range: places.take(place, WorldField::Range, range_m),
            },
            RawPotential::Plane {
                at_m,
                normal,
                stiffness_n_per_m,
                range_m,
            } => FieldKind::Plane {
                at: places.take(place, WorldField::At, at_m),
                normal: unit(places.take(place, WorldField::Normal, normal)),
                stiffness: places.take(place, WorldField::Stiffness, stiffness_n_per_m),
                range: places.take(place, WorldField::Range, range_m),
            },
            RawPotential::Detents {
                at_m,
                axis,
                positions,
                period_m,
                amplitude_j,
                stiffness_n_per_m,
            } => FieldKind::Detents {
                at: places.take(place, WorldField::At, at_m),
                axis: unit(places.take(place, WorldField::Axis, axis)),
                positions: places.take(place, WorldField::Positions, positions),
                period: places.take(place, WorldField::Period, period_m),
                amplitude: places.take(place, WorldField::Amplitude, amplitude_j),
                stiffness: stiffness_n_per_m.map_or(0.0, |stiffness| {
                    places.take(place, WorldField::Stiffness, stiffness)
                }),
            },
            RawPotential::Constant { force_n } => FieldKind::Constant {
                force: places.take(place, WorldField::Force, force_n),
            },
        };
        Field { tool, kind }
    }
}
