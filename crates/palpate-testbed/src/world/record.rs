//! Results of an ideal: forces over intervals, states at their edges, contacts from begin to end.

use super::scene::{Member, Vector};

/// The contact force on the tool of one device, along each axis that the device has, cut into the intervals of a grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DeviceProfile {
    /// ∫ f dt over each interval `[N s]`.
    pub impulses: Vec<Vector>,
    /// ∫ f² dt along each axis over each interval `[N² s]`.
    pub squares: Vec<Vector>,
    /// ∫ f (t − t₀) dt about the middle of each interval `[N s²]`.
    pub moments: Vec<Vector>,
    /// Largest |f| in each interval `[N]`.
    pub peaks: Vec<f64>,
    /// ∫ τ dt over each interval of the torque about the tool's mass centre; empty for a device that does not turn
    /// `[N m s]`.
    pub torque_impulses: Vec<Vector>,
    /// ∫ τ² dt about each axis over each interval; empty for a device that does not turn `[N² m² s]`.
    pub torque_squares: Vec<Vector>,
}

/// One contact of a scene, from the time it begins to the time it ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Encounter {
    /// Number of its pair in the scene.
    pub pair: usize,
    /// Number of the contact; those of a box on a half-space have one for each corner.
    pub contact: usize,
    /// The two members; the one with the sphere or the corner comes first.
    pub between: [Member; 2],
    /// Start `[s]`; 0 for an initial contact.
    pub start: f64,
    /// End `[s]`, `None` if the contact lasts beyond the window.
    pub end: Option<f64>,
    /// ∫ N dt `[N s]`.
    pub normal_impulse: f64,
    /// ∫ of the force on the first of the two `[N s]`.
    pub impulse: Vector,
    /// Energy dissipated in it `[J]`.
    pub dissipated: f64,
    /// Largest N `[N]`.
    pub peak_force: f64,
    /// Largest penetration `[m]`.
    pub deepest: f64,
}

/// Position of a device, with its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceState {
    /// `[m]`
    pub position: Vector,
    /// `[m/s]`
    pub velocity: Vector,
    /// Contact force on its tool `[N]`.
    pub force: Vector,
    /// Force of the hand on it `[N]`.
    pub hand_force: Vector,
    /// Unit quaternion `[w, x, y, z]`; not turned for a device that does not turn.
    pub orientation: [f64; 4],
    /// In world axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// Contact torque on its tool about the mass centre, in world axes `[N m]`.
    pub torque: Vector,
}

/// Pose of a body, with its velocities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState {
    /// Centre of mass `[m]`.
    pub position: Vector,
    /// Unit quaternion `[w, x, y, z]`.
    pub orientation: [f64; 4],
    /// `[m/s]`
    pub velocity: Vector,
    /// In world axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// About the centre of mass, in world axes `[kg m²/s]`; 0 for a fixed body.
    pub angular_momentum: Vector,
}

/// State of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactState {
    /// p `[m]`, negative where there is a gap.
    pub penetration: f64,
    /// Unit vector from the second member to the first.
    pub normal: Vector,
    /// N `[N]`.
    pub normal_force: f64,
    /// Deflection z of the bristle `[m]`.
    pub bristle: Vector,
}

/// Energy ledger of a scene since t = 0.
///
/// kinetic + stored + dissipated = initial kinetic + initial stored + hand work + work of the bodies' forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceLedger {
    /// Kinetic energy of devices and bodies `[J]`.
    pub kinetic: f64,
    /// In the contacts' springs and bristles `[J]`.
    pub stored: f64,
    /// Energy dissipated by the contacts, never decreasing `[J]`.
    pub dissipated: f64,
    /// Work of the hands on their devices, including their springs and dampers `[J]`.
    pub hand_work: f64,
    /// Work of the constant forces on the bodies `[J]`.
    pub body_work: f64,
}

impl ReferenceLedger {
    /// Returns the conserved quantity: kinetic + stored + dissipated − hand work − work of the bodies' forces `[J]`.
    #[must_use]
    pub fn balance(&self) -> f64 {
        self.kinetic + self.stored + self.dissipated - self.hand_work - self.body_work
    }
}

/// State at one edge of the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldState {
    /// `[s]`
    pub time: f64,
    /// In the order of the scene.
    pub devices: Vec<DeviceState>,
    /// In the order of the scene.
    pub bodies: Vec<BodyState>,
    /// All contacts; a pair of spheres has one, a box on a half-space eight.
    pub contacts: Vec<ContactState>,
    /// The energies.
    pub ledger: ReferenceLedger,
}

impl Encounter {
    pub(super) fn add(&mut self, from: &[f64; 5], to: &[f64; 5]) {
        self.normal_impulse = to[0] - from[0];
        self.impulse = std::array::from_fn(|axis| to[1 + axis] - from[1 + axis]);
        self.dissipated = to[4] - from[4];
    }

    /// Whether the tool of a device takes part.
    #[must_use]
    pub fn is_of_device(&self, device: usize) -> bool {
        self.between.contains(&Member::Device(device))
    }
}
