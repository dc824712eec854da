//! The body of a scene with one contact along one axis.

use palpate_core::{ObjectState, Parameter, Side};
use toml::Spanned;

use super::contact_file::Reading;
use super::fault::Places;
use super::parameter::SceneParameter::{self, self as Of};
use super::raw::RawBody;

/// A body as the closed form takes it.
pub(crate) struct ReadBody {
    /// Mass `[kg]`, infinite for a wall.
    pub mass: f64,
    pub side: Side,
    pub state: ObjectState<f64>,
    /// Distance of the centre behind the surface `[m]`.
    pub radius: f64,
    /// Virtual force `[N]`.
    pub force: f64,
}

impl Reading<'_> {
    /// Returns the body: an object or a wall.
    pub fn body(&mut self, raw: Spanned<RawBody>, places: &mut Places<SceneParameter>) -> ReadBody {
        let whole = raw.span();
        let raw = raw.into_inner();
        if raw.fixed {
            for (key, span) in raw.keys_of_motion() {
                if let Some(span) = span {
                    self.fault((span, format!("a fixed body has no {key}")));
                }
            }
        } else {
            let turning = [
                (
                    "body.inertia_kg_m2",
                    raw.inertia_kg_m2.as_ref().map(Spanned::span),
                ),
                (
                    "body.angular_velocity_rad_per_s",
                    raw.angular_velocity_rad_per_s.as_ref().map(Spanned::span),
                ),
            ];
            self.refuse(
                &turning,
                "is for a body that turns; one with `axes` does not",
            );
        }
        let mass = match raw.mass_kg {
            _ if raw.fixed => f64::INFINITY,
            Some(mass) => self.mass_of_object(mass, places),
            None => {
                let message = "a body needs either mass_kg or fixed = true";
                self.in_table("body.0", (whole, message.into()));
                1.0
            }
        };
        let normal = self.axis.normal;
        let side = if normal < 0.0 {
            Side::Positive
        } else {
            Side::Negative
        };
        places.take(Parameter::Side, raw.shape);
        let position = self.place("body.position_m", raw.position_m);
        let mut position = places.take_or(Parameter::ObjectPosition, position, 0.0);
        if self.axis.offset != 0.0 {
            position += normal * self.axis.offset;
        }
        let velocity = self.along("body.velocity_m_per_s", raw.velocity_m_per_s, [0.0; 3]);
        let force = self.along("body.force_n", raw.force_n, [0.0; 3]);
        let centre = self.along("body.centre_m", raw.centre_m, [0.0; 3]);
        // A product would make a negative zero of a zero.
        let depth = |centre: f64| if normal < 0.0 { centre } else { -centre };
        let radius = centre.map(|centre| {
            let (at, depth) = (centre.span(), depth(*centre.get_ref()));
            if depth < 0.0 {
                let message =
                    "body.centre_m must point into the solid, against the normal of the half_space";
                self.fault((at.clone(), message.into()));
            }
            Spanned::new(at, if depth < 0.0 { 0.0 } else { depth })
        });
        ReadBody {
            mass,
            side,
            state: ObjectState {
                position,
                velocity: places.take_or(Parameter::ObjectVelocity, velocity, 0.0),
            },
            force: places.take_or(Parameter::VirtualForce, force, 0.0),
            radius: places.take_or(Of::ObjectRadius, radius, 0.0),
        }
    }

    /// Returns the mass of a body that moves `[kg]`.
    fn mass_of_object(&mut self, mass: Spanned<f64>, places: &mut Places<SceneParameter>) -> f64 {
        let span = mass.span();
        let mass = places.take(Parameter::ObjectMass, mass);
        if mass == f64::INFINITY {
            let message = "body.mass_kg is inf kg, but must be finite; a body that does not move has fixed = true, and \
                           neither mass_kg nor axes";
            self.fault((span, message.into()));
            return 1.0;
        }
        mass
    }
}
