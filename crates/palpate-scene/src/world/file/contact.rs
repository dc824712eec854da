//! The table `[[contact]]` of a world.

use palpate_core::Range;
use palpate_world::{Contact, ContactLaw, WorldField as Field, WorldPart, out_of_range};
use toml::Spanned;

use super::Reading;
use crate::raw::RawContact;
use crate::world::pair::Pair;

impl Reading {
    pub(super) fn contact(&mut self, index: usize, raw: Spanned<RawContact>) -> Contact {
        let place = WorldPart::Contact(index);
        self.places.part(place, raw.span());
        let raw = raw.into_inner();
        let Pair(between) = self.places.take(place, Field::Between, raw.between);
        let stiffness = self
            .places
            .take(place, Field::Stiffness, raw.stiffness_n_per_m);
        // Report a wrong stiffness only once.
        let is_wrong = out_of_range("", stiffness, Range::Positive).is_some();
        let usual = if is_wrong { 1.0 } else { stiffness };
        let mut or = |field, value: Option<Spanned<f64>>, default: f64| {
            value.map_or(default, |value| self.places.take(place, field, value))
        };
        let damping = or(Field::Damping, raw.damping_n_s_per_m, 0.0);
        let friction = or(Field::Friction, raw.friction, 0.0);
        let friction_stiffness = or(
            Field::FrictionStiffness,
            raw.friction_stiffness_n_per_m,
            usual,
        );
        let usual = ContactLaw::usual_friction_damping(stiffness, damping, friction_stiffness);
        // The damping itself or a stiffness is wrong, and is reported by its own key.
        let usual = if out_of_range("", usual, Range::NotNegative).is_some() {
            0.0
        } else {
            usual
        };
        Contact {
            between,
            law: ContactLaw {
                stiffness,
                damping,
                friction,
                friction_stiffness,
                friction_damping: or(
                    Field::FrictionDamping,
                    raw.friction_damping_n_s_per_m,
                    usual,
                ),
            },
        }
    }
}
