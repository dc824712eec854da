//! Forces and accelerations of the rigid links, from the Lagrangian.
//!
//! In the four absolute angles q = (θ1, θ2, φ1, φ2) of the links the kinetic energy is that of two
//! planar double pendulums,
//!
//! ```text
//! T = Σ_i  a_i θ_i′²/2 + d_i φ_i′²/2 + b_i cos(φ_i − θ_i) θ_i′ φ_i′
//! ```
//!
//! with constant a, b, d. The closed loop leaves two of the angles free: q′ = G θ′ with
//! G = (1; W), W = ∂φ/∂θ. Projecting Lagrange's equations on the motion that the loop allows gives
//!
//! ```text
//! M θ″ + c = τ + Jᵀ F + …       M = Gᵀ D G       c = Gᵀ (D G′ θ′ + h)
//! ```
//!
//! where h are the centrifugal terms of the pendulums and G′θ′ is what the distal links would
//! accelerate with if the motors turned steadily. All of it is closed form, so nothing but the time
//! integration can fail to conserve energy.

use super::kinematics::{ArmPose, Geometry, cross, dot, scaled};
use super::params::PantographParams;

/// The mechanism's constants, worked out once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    geometry: Geometry,
    /// Inertias a_i `[kg m²]` of the proximal links with all that hangs on their elbow.
    a: [f64; 2],
    /// Couplings b_i `[kg m²]`.
    b: [f64; 2],
    /// Inertias d_i `[kg m²]` of the distal links about their elbow.
    d: [f64; 2],
    /// First moments `[kg m]` along the proximal and the distal links.
    proximal_moment: [f64; 2],
    distal_moment: [f64; 2],
    gravity: [f64; 2],
}

impl Dynamics {
    /// The constants of checked parameters.
    pub(super) fn new(params: &PantographParams) -> Self {
        let (l, distal_length) = (params.geometry.proximal, params.geometry.distal);
        // The end-point's mass is assigned to arm 1; arm 2 ends in the same point.
        let tip = [params.end_point_mass, 0.0];
        let each = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
        let upper = params.proximal;
        let lower = params.distal;
        Self {
            geometry: params.geometry,
            a: each(&|i| {
                params.rotor_inertia
                    + upper[i].inertia
                    + upper[i].mass * (upper[i].centre * l).powi(2)
                    + (lower[i].mass + tip[i]) * l * l
            }),
            b: each(&|i| (lower[i].mass * lower[i].centre + tip[i]) * l * distal_length),
            d: each(&|i| {
                lower[i].inertia
                    + lower[i].mass * (lower[i].centre * distal_length).powi(2)
                    + tip[i] * distal_length * distal_length
            }),
            proximal_moment: each(&|i| {
                (upper[i].mass * upper[i].centre + lower[i].mass + tip[i]) * l
            }),
            distal_moment: each(&|i| (lower[i].mass * lower[i].centre + tip[i]) * distal_length),
            gravity: params.gravity,
        }
    }

    /// Mass matrix M(θ) `[kg m²]` seen by the motors.
    #[must_use]
    #[inline]
    pub fn mass_matrix(&self, pose: &ArmPose) -> [[f64; 2]; 2] {
        let w = pose.distal_rates();
        let coupling = [0, 1].map(|i| self.b[i] * dot(pose.proximal[i], pose.distal[i]));
        let distal = |r: usize, s: usize| [0, 1].map(|i| self.d[i] * w[i][r] * w[i][s]);
        let (first, both, second) = (distal(0, 0), distal(0, 1), distal(1, 1));
        let off = (both[0] + coupling[0] * w[0][1]) + (both[1] + coupling[1] * w[1][0]);
        [
            [
                self.a[0] + first[0] + coupling[0] * (2.0 * w[0][0]) + first[1],
                off,
            ],
            [
                off,
                second[0] + (self.a[1] + second[1] + coupling[1] * (2.0 * w[1][1])),
            ],
        ]
    }

    /// Centrifugal and Coriolis torques c(θ, θ′) `[N m]`, on the left of the equation of motion.
    #[must_use]
    #[inline]
    pub fn coriolis(&self, pose: &ArmPose, rates: [f64; 2]) -> [f64; 2] {
        let (l, distal_length) = (self.geometry.proximal, self.geometry.distal);
        let w = pose.distal_rates();
        let phi_rates = w.map(|row| dot(row, rates));
        // Remainder of the loop closure's second derivative for zero motor accelerations:
        // L t(φ1) φ1″ − L t(φ2) φ2″ = r.
        let pull = |i: usize| {
            let upper = scaled(l * rates[i] * rates[i], pose.proximal[i]);
            let lower = scaled(distal_length * phi_rates[i] * phi_rates[i], pose.distal[i]);
            [upper[0] + lower[0], upper[1] + lower[1]]
        };
        let (first, second) = (pull(0), pull(1));
        let r = [first[0] - second[0], first[1] - second[1]];
        let scale = 1.0 / (distal_length * pose.sine);
        let phi_bias = [
            scale * dot(pose.distal[1], r),
            scale * dot(pose.distal[0], r),
        ];

        let mut torque = [0.0; 2];
        for i in 0..2 {
            let cosine = dot(pose.proximal[i], pose.distal[i]);
            let sine = cross(pose.proximal[i], pose.distal[i]);
            let on_theta = self.b[i] * (cosine * phi_bias[i] - sine * phi_rates[i] * phi_rates[i]);
            let on_phi = self.d[i] * phi_bias[i] + self.b[i] * sine * rates[i] * rates[i];
            torque[i] += on_theta;
            torque[0] += w[i][0] * on_phi;
            torque[1] += w[i][1] * on_phi;
        }
        torque
    }

    /// Torques `[N m]` of gravity about the motors.
    #[must_use]
    #[inline]
    pub fn gravity_torques(&self, pose: &ArmPose) -> [f64; 2] {
        let w = pose.distal_rates();
        let mut torque = [0.0; 2];
        for i in 0..2 {
            // g · t with t the link's direction turned by 90°.
            torque[i] += self.proximal_moment[i] * cross(pose.proximal[i], self.gravity);
            let on_phi = self.distal_moment[i] * cross(pose.distal[i], self.gravity);
            torque[0] += w[i][0] * on_phi;
            torque[1] += w[i][1] * on_phi;
        }
        torque
    }

    /// Kinetic energy `[J]` at motor rates `[rad/s]`.
    #[must_use]
    pub fn kinetic_energy(&self, pose: &ArmPose, rates: [f64; 2]) -> f64 {
        let phi_rates = pose.distal_rates().map(|row| dot(row, rates));
        (0..2)
            .map(|i| {
                0.5 * self.a[i] * rates[i] * rates[i]
                    + 0.5 * self.d[i] * phi_rates[i] * phi_rates[i]
                    + self.b[i] * dot(pose.proximal[i], pose.distal[i]) * rates[i] * phi_rates[i]
            })
            .sum()
    }

    /// Potential energy `[J]` in gravity, zero with all centres of mass on their motor's axis.
    #[must_use]
    pub fn potential_energy(&self, pose: &ArmPose) -> f64 {
        -(0..2)
            .map(|i| {
                self.proximal_moment[i] * dot(pose.proximal[i], self.gravity)
                    + self.distal_moment[i] * dot(pose.distal[i], self.gravity)
            })
            .sum::<f64>()
    }

    /// Mass `[kg]` that a force along y feels at the end-point, 1 / (J M⁻¹ Jᵀ)_yy.
    ///
    /// The motors are free and x may give way. It is infinite where the end-point cannot move
    /// along y.
    #[must_use]
    pub fn effective_mass_y(&self, pose: &ArmPose) -> f64 {
        let row = pose.jacobian()[1];
        1.0 / dot(row, solved(self.mass_matrix(pose), row))
    }

    pub(super) fn geometry(&self) -> &Geometry {
        &self.geometry
    }
}

/// Solves a 2 × 2 symmetric positive definite system.
#[inline]
pub(super) fn solved(m: [[f64; 2]; 2], rhs: [f64; 2]) -> [f64; 2] {
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    [
        (m[1][1] * rhs[0] - m[0][1] * rhs[1]) / determinant,
        (m[0][0] * rhs[1] - m[1][0] * rhs[0]) / determinant,
    ]
}
