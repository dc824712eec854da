//! The exact ideal contact of a point-mass device and an object, both free to move.
//!
//! A renderer approximates this contact at a finite loop rate; here it is solved in continuous time. The centre of mass
//! moves on a parabola, and the [relative motion](crate::relative_motion) is solved piece by piece. No time step is
//! involved.

use crate::InvalidParameter;
use crate::error::{finite, positive};
use crate::grid::Grid;
use crate::profile::{Collision, ForceProfile, Snapshot};
use crate::relative_motion::{RelativeMotion, RelativeState};

/// A point-mass device, an object, constant forces on both, and where they are at t = 0.
///
/// See the [crate's page](crate) for frame and signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMassScene {
    /// Contact stiffness K `[N/m]`, finite and above 0.
    pub stiffness: f64,
    /// Device mass m `[kg]`, finite and above 0.
    pub device_mass: f64,
    /// Object mass M `[kg]`, above 0; infinite for a wall.
    pub object_mass: f64,
    /// Constant force f_u of the user on the device `[N]`.
    pub user_force: f64,
    /// Constant force f_V on the object `[N]`; it has no effect on a wall.
    pub virtual_force: f64,
    /// Device position at t = 0 `[m]`.
    pub device_position: f64,
    /// Device velocity at t = 0 `[m/s]`.
    pub device_velocity: f64,
    /// Object position at t = 0 `[m]`.
    pub object_position: f64,
    /// Object velocity at t = 0 `[m/s]`; 0 for a wall.
    pub object_velocity: f64,
}

/// The ideal contact of a [`PointMassScene`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ideal {
    scene: PointMassScene,
    motion: RelativeMotion,
}

impl Ideal {
    /// Checks the scene.
    ///
    /// # Errors
    ///
    /// A field of `scene` is outside the range in its description, or the numbers are so far apart
    /// that an acceleration or the contact's frequency is not finite.
    pub fn new(scene: PointMassScene) -> Result<Self, InvalidParameter> {
        positive("device_mass", scene.device_mass, "finite and above 0 kg")?;
        object_mass(scene.object_mass)?;
        finite("user_force", scene.user_force, "finite [N]")?;
        finite("virtual_force", scene.virtual_force, "finite [N]")?;
        finite("device_position", scene.device_position, "finite [m]")?;
        finite("device_velocity", scene.device_velocity, "finite [m/s]")?;
        finite("object_position", scene.object_position, "finite [m]")?;
        object_velocity(scene.object_velocity, scene.object_mass)?;
        let motion = RelativeMotion::new(
            scene.stiffness,
            1.0 / scene.device_mass + 1.0 / scene.object_mass,
            scene.user_force / scene.device_mass - scene.virtual_force / scene.object_mass,
        )?;
        Ok(Self { scene, motion })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &PointMassScene {
        &self.scene
    }

    /// Instant at which the `n`-th collision ends `[s]`, counted from 1.
    ///
    /// `None` if there is no such collision, or it never ends. A contact present at t = 0 is the
    /// first collision.
    #[must_use]
    pub fn end_of_collision(&self, n: usize) -> Option<f64> {
        self.motion.end_of_contact(self.at_start(), n)
    }

    /// Window of `collisions` collisions in whole periods: ⌈(t_n + T/2)/T⌉, t_n the end of the last.
    ///
    /// `None` where [`end_of_collision`](Self::end_of_collision) is, or if `period` `[s]` is not
    /// positive or too short for the window to be counted.
    #[must_use]
    pub fn window(&self, collisions: usize, period: f64) -> Option<usize> {
        let end = self.end_of_collision(collisions)?;
        let intervals = ((end + 0.5 * period) / period).ceil();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "used only as a whole number between 1 and 2^32"
        )]
        (period > 0.0 && (1.0..=f64::from(u32::MAX)).contains(&intervals))
            .then_some(intervals as usize)
    }

    /// The ideal force over `intervals` periods `[s]` from t = 0.
    ///
    /// # Errors
    ///
    /// `period` is not finite and positive, or the window holds more than 10⁷ half oscillations of
    /// the contact.
    pub fn profile(&self, period: f64, intervals: usize) -> Result<ForceProfile, InvalidParameter> {
        positive("period", period, "finite and above 0 s")?;
        self.profile_on(Grid::even(0.0, period, intervals))
    }

    /// The ideal force over a window that begins at 0 or later, cut by `grid`.
    ///
    /// # Errors
    ///
    /// The window holds more than 10⁷ half oscillations of the contact.
    pub fn profile_on(&self, grid: Grid) -> Result<ForceProfile, InvalidParameter> {
        let arcs = self.motion.arcs(self.at_start(), 0.0, grid.end())?;
        Ok(ForceProfile::from_arcs(&arcs, grid))
    }

    /// Device, object and force at a time `[s]` from 0 on; before it, and where `time` is not
    /// finite, those at 0.
    ///
    /// The work does not depend on `time`.
    #[must_use]
    pub fn at(&self, time: f64) -> Snapshot {
        let time = if time.is_finite() { time.max(0.0) } else { 0.0 };
        let scene = &self.scene;
        let arc = self.motion.arc_at(self.at_start(), time);
        let RelativeState {
            penetration,
            velocity,
        } = arc.state(time);
        let (object_position, object_velocity) = if scene.object_mass.is_finite() {
            let (m, big_m) = (scene.device_mass, scene.object_mass);
            let share = m / (m + big_m);
            let of_both = |device: f64, object: f64| object + share * (device - object);
            let centre = of_both(scene.device_position, scene.object_position);
            let drift = of_both(scene.device_velocity, scene.object_velocity);
            let acceleration = (scene.user_force + scene.virtual_force) / (m + big_m);
            (
                centre + time * (drift + 0.5 * acceleration * time) - share * penetration,
                drift + acceleration * time - share * velocity,
            )
        } else {
            (scene.object_position, 0.0)
        };
        Snapshot {
            time,
            device_position: object_position + penetration,
            device_velocity: object_velocity + velocity,
            object_position,
            object_velocity,
            force_on_object: arc.force(time),
        }
    }

    /// Total energy `[J]` at a `snapshot`: kinetic energy of device and object, potential of the
    /// constant forces, and the spring's K p²/2 while p > 0.
    ///
    /// For a wall the object's terms are absent. In the ideal it never changes.
    #[must_use]
    pub fn energy(&self, snapshot: &Snapshot) -> f64 {
        let p = snapshot.penetration().max(0.0);
        self.energy_without_spring(snapshot) + 0.5 * self.scene.stiffness * p * p
    }

    /// [`energy`](Self::energy) less the spring's `[J]`.
    #[must_use]
    pub fn energy_without_spring(&self, snapshot: &Snapshot) -> f64 {
        let scene = &self.scene;
        let u = snapshot.device_velocity;
        let device = 0.5 * scene.device_mass * u * u - scene.user_force * snapshot.device_position;
        if scene.object_mass.is_finite() {
            let w = snapshot.object_velocity;
            device + 0.5 * scene.object_mass * w * w
                - scene.virtual_force * snapshot.object_position
        } else {
            device
        }
    }

    /// Kinetic energy of the relative motion at the impact of a `collision` of this scene `[J]`:
    /// μ v²/2 with 1/μ = 1/m + 1/M.
    #[must_use]
    pub fn impact_energy(&self, collision: &Collision) -> f64 {
        let scene = &self.scene;
        let reduced_mass = 1.0 / (1.0 / scene.device_mass + 1.0 / scene.object_mass);
        0.5 * reduced_mass * collision.impact_speed * collision.impact_speed
    }

    fn at_start(&self) -> RelativeState {
        RelativeState {
            penetration: self.scene.device_position - self.scene.object_position,
            velocity: self.scene.device_velocity - self.scene.object_velocity,
        }
    }
}

/// Accepts the mass of an object or a wall.
pub(crate) fn object_mass(mass: f64) -> Result<f64, InvalidParameter> {
    InvalidParameter::unless(
        mass > 0.0,
        "object_mass",
        mass,
        "above 0 kg, infinite for a wall",
    )
}

/// Accepts the velocity of an object, or the rest of a wall.
pub(crate) fn object_velocity(velocity: f64, mass: f64) -> Result<f64, InvalidParameter> {
    InvalidParameter::unless(
        velocity.is_finite() && (mass.is_finite() || velocity == 0.0),
        "object_velocity",
        velocity,
        "finite [m/s], and 0 for a wall",
    )
}
