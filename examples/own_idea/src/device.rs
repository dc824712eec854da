//! User-defined device: a joystick, a mass on a spring that pulls it home.

use palpate_testbed::device::DevicePlant;

/// m x'' = hand - c x - f, solved exactly under a held force f.
#[derive(Clone, Debug)]
pub struct Joystick {
    /// Effective mass m `[kg]`.
    pub mass: f64,
    /// Stiffness c of the spring that pulls it home `[N/m]`.
    pub centring_stiffness: f64,
    /// Constant force of the hand `[N]`.
    pub hand_force: f64,
    /// Position x `[m]`.
    pub position: f64,
    /// Velocity x' `[m/s]`.
    pub velocity: f64,
}

impl DevicePlant for Joystick {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let rest = (self.hand_force - force_on_object) / self.centring_stiffness;
        let omega = (self.centring_stiffness / self.mass).sqrt();
        let (sin, cos) = (omega * duration).sin_cos();
        let (away, before) = (self.position - rest, self.position);
        self.position = rest + away * cos + self.velocity / omega * sin;
        self.velocity = self.velocity * cos - away * omega * sin;
        // The force is held, so its work needs no integral.
        force_on_object * (self.position - before)
    }

    fn stored_energy(&self) -> f64 {
        0.5 * (self.mass * self.velocity.powi(2) + self.centring_stiffness * self.position.powi(2))
            - self.hand_force * self.position
    }
}
