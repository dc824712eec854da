//! Testbed for contact rendering: virtual devices, exact ideal contact and error metrics.
//!
//! **This crate deliberately does not depend on the renderers' crate.** The evaluation shares no code with the
//! renderers, so an error in one cannot hide in the other. A closed form that both need is implemented twice; see
//! [`relative_motion`].
//!
//! # Frame and signs
//!
//! One contact direction, SI units, `f64`. The object lies on the device's positive side:
//!
//! | quantity | symbol | unit |
//! |---|---|---|
//! | device position | ξ | m |
//! | object position | η | m |
//! | penetration | p = ξ − η, contact while p > 0 | m |
//! | contact force **on the object** | f = K p in contact, otherwise 0 | N |
//!
//! The device receives −f. With the user's force `f_u` and the virtual force `f_V` (gravity, for
//! example):
//!
//! ```text
//! device   m ξ″ = f_u − f
//! object   M η″ = f_V + f        (a wall is M = ∞ and never moves)
//! ```
//!
//! A scene whose object lies on the other side is mirrored by the caller, who negates positions,
//! velocities and forces on the way in and out.
//!
//! [`world`] has several devices, bodies and contacts in space, with signs of its own.
//!
//! # From scene to evaluation
//!
//! ```
//! use palpate_testbed::ideal::{Ideal, PointMassScene};
//! use palpate_testbed::metrics::ForceEvaluation;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A 0.1 kg block falls by 0.1 m onto a device of the same mass that a hand pushes up by 0.981 N.
//! let ideal = Ideal::new(PointMassScene {
//!     stiffness: 100.0,
//!     device_mass: 0.1,
//!     object_mass: 0.1,
//!     user_force: 0.981,
//!     virtual_force: -0.981,
//!     device_position: 0.0,
//!     device_velocity: 0.0,
//!     object_position: 0.1,
//!     object_velocity: 0.0,
//! })?;
//! let period = 0.01;
//! let intervals = ideal.window(3, period).ok_or("fewer than three collisions")?;
//! let profile = ideal.profile(period, intervals)?;
//!
//! // The best any loop can hold at this period: the mean of the ideal force, interval by interval.
//! let held: Vec<f64> = profile.mean_forces().collect();
//! let evaluation = ForceEvaluation::new(&held, &profile)?;
//! let fidelity = evaluation.fidelity.ok_or("no contact")?;
//! assert_eq!(fidelity.mean_force_error, 0.0);
//! assert!((fidelity.force_rendering_error - fidelity.hold_bound).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```

pub mod actuator;
mod arc;
pub mod device;
pub mod driven;
pub mod drivetrain;
mod error;
pub mod grid;
pub mod hand;
pub mod held_mass;
pub mod hold;
pub mod ideal;
pub mod measure;
pub mod metrics;
pub mod pantograph;
mod power_series;
pub mod profile;
mod random;
pub mod recorded_hand;
pub mod recorded_path;
pub mod reference;
pub mod relative_motion;
pub mod schedule;
mod settling;
pub mod sprung_mass;
mod taps;
pub mod timeline;
pub mod viscous_ideal;
pub mod viscous_mass;
pub mod world;

pub use error::InvalidParameter;
pub use taps::taps;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
