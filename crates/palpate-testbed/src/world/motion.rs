//! The equations of motion of a scene, for contacts of given modes.

mod hand;
mod rates;

use super::contact::{Acceleration, Contact, Placed, Touch, WorldError};
use super::force_field::ForceField;
use super::joints::{Bearing, Hold};
use super::layout::Layout;
use super::scene::{ContactLaw, FreeMotion, Member, WorldDevice, WorldScene};
use super::surface::Feature;
use super::turning::Turning;
use super::vector::{Rotation, Vec3};

pub(super) use hand::Grasp;

/// State of a contact. Within a mode, the equations are smooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// The surfaces are apart.
    Free,
    /// Overlap with K p + B p′ < 0: no force.
    Clipped,
    /// Pushing, without friction.
    Smooth,
    /// Pushing; the bristle follows the motion.
    Stick,
    /// Pushing; the bristle has its largest deflection μ N/k_t.
    Slip,
}

/// Mode and feature of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Condition {
    pub mode: Mode,
    pub feature: Feature,
}

/// A free body's constants.
#[derive(Debug, Clone)]
struct Rigid {
    motion: FreeMotion,
    /// Its number among the free bodies.
    free: usize,
}

/// A scene made ready to be moved.
#[derive(Debug, Clone)]
pub(super) struct System {
    pub devices: Vec<WorldDevice>,
    bodies: Vec<Option<Rigid>>,
    pub contacts: Vec<Contact>,
    pub joints: Vec<Bearing>,
    pub fields: Vec<ForceField>,
    pub layout: Layout,
    orientations: Vec<[f64; 4]>,
    start: Vec<Placed>,
    start_state: Vec<f64>,
}

/// Quantities derived from a state at one instant; reused to avoid allocation.
#[derive(Debug, Clone)]
pub(super) struct Instant {
    pub placed: Vec<Placed>,
    pub touches: Vec<Touch>,
    /// N of each contact `[N]`.
    pub normal_forces: Vec<f64>,
    /// Deflection of each bristle that acts `[m]`.
    pub bristles: Vec<Vec3>,
    /// Damping force added to that of each bristle, on the first member `[N]`.
    pub bristle_dampers: Vec<Vec3>,
    /// Slip of each bristle, e · v_t − (μ N/k_t)′; 0 unless it slips `[m/s]`.
    pub slips: Vec<f64>,
    /// States of the joints.
    pub holds: Vec<Hold>,
    /// How each device is held.
    pub grasps: Vec<Grasp>,
    accelerations: Vec<Acceleration>,
    forces: Vec<Vec3>,
    torques: Vec<Vec3>,
}

impl System {
    /// Checks `scene` and lists its contacts.
    pub fn new(scene: &WorldScene) -> Result<Self, WorldError> {
        scene.check()?;
        let contacts = Contact::of_scene(scene)?;
        let mut free = 0;
        let bodies: Vec<Option<Rigid>> = scene
            .bodies
            .iter()
            .map(|body| {
                body.motion.map(|motion| {
                    free += 1;
                    Rigid {
                        motion,
                        free: free - 1,
                    }
                })
            })
            .collect();
        let layout = Layout {
            devices: scene.devices.len(),
            turns: scene.devices.iter().any(|device| device.turning.is_some()),
            free_bodies: free,
            contacts: contacts.len(),
            joints: scene.joints.len(),
        };
        let mut start_state = vec![0.0; layout.size()];
        let mut start = Vec::new();
        for (number, device) in scene.devices.iter().enumerate() {
            let place = layout.device(number);
            start_state[place..place + 3].copy_from_slice(&device.position);
            start_state[place + 3..place + 6].copy_from_slice(&device.velocity);
            let orientation = device
                .turning
                .as_ref()
                .map_or([1.0, 0.0, 0.0, 0.0], |turning| turning.orientation);
            let placed = placed(device.position, orientation);
            start.push(placed);
            if layout.turns {
                start_state[place + 6..place + 10].copy_from_slice(&orientation);
            }
            if let Some(turning) = &device.turning {
                let omega = Vec3(turning.angular_velocity);
                let momentum = turning.angular_momentum(&placed.rotation, omega);
                momentum.write(&mut start_state[place + 10..]);
            }
        }
        for (body, rigid) in scene.bodies.iter().zip(&bodies) {
            let placed = placed(body.position, body.orientation);
            start.push(placed);
            let Some(Rigid { motion, free }) = rigid else {
                continue;
            };
            let place = layout.body(*free);
            start_state[place..place + 3].copy_from_slice(&body.position);
            start_state[place + 3..place + 6].copy_from_slice(&motion.velocity);
            start_state[place + 6..place + 10].copy_from_slice(&body.orientation);
            let turning = Vec3(motion.angular_velocity);
            angular_momentum(&placed.rotation, motion, turning)
                .write(&mut start_state[place + 10..]);
        }
        let devices = scene.devices.len();
        let joints = scene.joints.iter();
        let joints = joints
            .map(|joint| Bearing::new(joint, devices, &start))
            .collect();
        Ok(Self {
            devices: scene.devices.clone(),
            bodies,
            contacts,
            joints,
            fields: scene.fields.clone(),
            layout,
            orientations: scene.bodies.iter().map(|body| body.orientation).collect(),
            start,
            start_state,
        })
    }

    /// Returns the initial pose of every member.
    pub fn start_places(&self) -> Vec<Placed> {
        self.start.clone()
    }

    /// The state at t = 0, all integrals 0.
    pub fn start(&self) -> Vec<f64> {
        self.start_state.clone()
    }

    pub fn instant(&self) -> Instant {
        let members = self.start.len();
        let contacts = self.contacts.len();
        let touch = Touch::none();
        Instant {
            placed: self.start.clone(),
            touches: vec![touch; contacts],
            normal_forces: vec![0.0; contacts],
            bristles: vec![Vec3::ZERO; contacts],
            bristle_dampers: vec![Vec3::ZERO; contacts],
            slips: vec![0.0; contacts],
            holds: vec![Hold::default(); self.joints.len()],
            grasps: (self.devices.iter())
                .map(|device| Grasp::new(&device.hand, 0.0))
                .collect(),
            accelerations: vec![Acceleration::default(); members],
            forces: vec![Vec3::ZERO; members],
            torques: vec![Vec3::ZERO; members],
        }
    }

    /// Size of each number that moves against which its error counts.
    pub fn scales(&self) -> Vec<f64> {
        let mut scales = vec![LENGTH; self.layout.moving()];
        for device in 0..self.devices.len() {
            let place = self.layout.device(device) + 3;
            scales[place..place + 3].fill(SPEED);
            if self.layout.turns {
                scales[place + 3..place + 10].fill(1.0);
            }
            if let Some(turning) = &self.devices[device].turning {
                let largest = turning.inertia.iter().fold(0.0_f64, |a, b| a.max(*b));
                let masses = self.devices[device].mass;
                let finite = masses.into_iter().find(|mass| mass.is_finite());
                let mass = finite.unwrap_or(1.0);
                let reach = (largest / mass).sqrt();
                scales[place + 3..place + 7].fill(LENGTH / reach);
                scales[place + 7..place + 10].fill(mass * reach * SPEED);
            }
        }
        for Rigid { motion, free } in self.bodies.iter().flatten() {
            let place = self.layout.body(*free);
            let largest = motion.inertia.iter().fold(0.0_f64, |a, b| a.max(*b));
            let reach = (largest / motion.mass).sqrt();
            scales[place + 3..place + 6].fill(SPEED);
            scales[place + 6..place + 10].fill(LENGTH / reach);
            scales[place + 10..place + 13].fill(motion.mass * reach * SPEED);
        }
        scales
    }

    /// Computes pose and velocity of every member.
    pub fn place(&self, state: &[f64], placed: &mut [Placed]) {
        let devices = self.devices.len();
        for (device, placed) in placed[..devices].iter_mut().enumerate() {
            let place = self.layout.device(device);
            placed.position = Vec3::new(&state[place..]);
            placed.velocity = Vec3::new(&state[place + 3..]);
            if let Some(turning) = &self.devices[device].turning {
                placed.rotation = Rotation::of_quaternion(quaternion(&state[place + 6..]));
                let momentum = Vec3::new(&state[place + 10..]);
                placed.turning = turning.angular_velocity(&placed.rotation, momentum);
            }
        }
        for (rigid, placed) in self.bodies.iter().zip(&mut placed[devices..]) {
            let Some(Rigid { motion, free }) = rigid else {
                continue;
            };
            let place = self.layout.body(*free);
            placed.position = Vec3::new(&state[place..]);
            placed.velocity = Vec3::new(&state[place + 3..]);
            placed.rotation = Rotation::of_quaternion(quaternion(&state[place + 6..]));
            let momentum = Vec3::new(&state[place + 10..]);
            placed.turning = angular_velocity(&placed.rotation, motion, momentum);
        }
    }

    /// Computes all quantities that follow from a state, for contacts in these `conditions`.
    pub fn evaluate(&self, time: f64, state: &[f64], conditions: &[Condition], now: &mut Instant) {
        self.place(state, &mut now.placed);
        now.forces.fill(Vec3::ZERO);
        now.torques.fill(Vec3::ZERO);
        for (number, (contact, condition)) in self.contacts.iter().zip(conditions).enumerate() {
            let found = &mut now.touches[number..];
            if !contact.touch_all(condition.feature, &now.placed, found) {
                found[0] = contact.touch(condition.feature, &now.placed);
            }
            let touch = now.touches[number];
            let (normal_force, bristle) = self.push(number, condition.mode, &touch, state);
            now.normal_forces[number] = normal_force;
            now.bristles[number] = bristle;
            let damper = damper(&contact.law, condition.mode, &touch, normal_force, bristle);
            now.bristle_dampers[number] = damper;
            let force =
                touch.normal * normal_force - bristle * contact.law.friction_stiffness + damper;
            for (member, force) in [(contact.first, force), (contact.second, -force)] {
                now.forces[member] += force;
                let arm = touch.point - now.placed[member].position;
                now.torques[member] += arm.cross(force);
            }
        }
        for (joint, hold) in self.joints.iter().zip(&mut now.holds) {
            *hold = joint.hold(&now.placed);
            for (member, force, torque) in &hold.wrenches {
                now.forces[*member] += *force;
                now.torques[*member] += *torque;
            }
        }
        for field in &self.fields {
            now.forces[field.device] += field.pull(now.placed[field.device].position).0;
        }
        self.accelerate(time, state, now);
        for (number, (contact, condition)) in self.contacts.iter().zip(conditions).enumerate() {
            now.slips[number] = if condition.mode == Mode::Slip {
                let touch = &now.touches[number];
                let direction =
                    slip_direction(Vec3::new(&state[self.layout.bristle(number)..]), touch);
                direction.dot(touch.tangential())
                    - self.largest_deflection_rate(contact, touch, now)
            } else {
                0.0
            };
        }
    }

    /// N `[N]` and the deflection of the bristle `[m]`.
    fn push(&self, number: usize, mode: Mode, touch: &Touch, state: &[f64]) -> (f64, Vec3) {
        let law = &self.contacts[number].law;
        if matches!(mode, Mode::Free | Mode::Clipped) {
            return (0.0, Vec3::ZERO);
        }
        let normal_force = touch.slope * self.raw_normal_force(number, touch).max(0.0);
        let bristle = Vec3::new(&state[self.layout.bristle(number)..]);
        let bristle = match mode {
            Mode::Stick => bristle,
            Mode::Slip => {
                let largest = law.friction * normal_force / law.friction_stiffness;
                slip_direction(bristle, touch) * largest
            }
            Mode::Free | Mode::Clipped | Mode::Smooth => Vec3::ZERO,
        };
        (normal_force, bristle)
    }

    /// K p + B p′ `[N]`, of any sign: what pushes p. The normal force is the slope of p times as large.
    pub fn raw_normal_force(&self, number: usize, touch: &Touch) -> f64 {
        let law = &self.contacts[number].law;
        law.stiffness * touch.penetration + law.damping * touch.rate
    }

    /// (μ N/k_t)′ `[m/s]`
    fn largest_deflection_rate(&self, contact: &Contact, touch: &Touch, now: &Instant) -> f64 {
        let law = &contact.law;
        let mut rate = law.stiffness * touch.growth;
        if law.damping > 0.0 {
            let members = [contact.first, contact.second];
            let second_rate = touch.second_rate(
                members.map(|member| &now.placed[member]),
                members.map(|member| &now.accelerations[member]),
            );
            rate += law.damping * second_rate;
        }
        let push = law.stiffness * touch.penetration + law.damping * touch.rate;
        law.friction / law.friction_stiffness * (touch.slope * rate + touch.slope_rate * push)
    }

    fn accelerate(&self, time: f64, state: &[f64], now: &mut Instant) {
        let devices = self.devices.len();
        for (number, device) in self.devices.iter().enumerate() {
            let placed = &now.placed[number];
            let (grasp, contact) = (&now.grasps[number], now.forces[number]);
            let push = contact + grasp.force(device, time, placed, contact);
            now.accelerations[number].linear = if let Some(table) = &device.mass_table {
                table.acceleration(device, [placed.position, placed.velocity, push])
            } else {
                let push = device.own(push);
                let linear = std::array::from_fn(|axis| push.0[axis] / grasp.mass(device, axis));
                device.out(Vec3(linear))
            };
            if let Some(turning) = &device.turning {
                let q = quaternion(&state[self.layout.device(number) + 6..]);
                let omega = placed.turning;
                let momentum = turning.angular_momentum(&placed.rotation, omega);
                let torque = turning.of_contacts(now.torques[number])
                    + now.hand_torque(number, turning, (time, q))
                    - omega.cross(momentum);
                now.accelerations[number].angular =
                    turning.angular_velocity(&placed.rotation, torque);
            }
        }
        for (number, rigid) in self.bodies.iter().enumerate() {
            let Some(Rigid { motion, .. }) = rigid else {
                continue;
            };
            let member = devices + number;
            let placed = &now.placed[member];
            let momentum = angular_momentum(&placed.rotation, motion, placed.turning);
            let torque = now.torques[member] - placed.turning.cross(momentum);
            now.accelerations[member] = Acceleration {
                linear: (now.forces[member] + Vec3(motion.force)) * (1.0 / motion.mass),
                angular: angular_velocity(&placed.rotation, motion, torque),
            };
        }
    }

    /// μ N/k_t `[m]`, for a pushing contact.
    pub fn largest_deflection(&self, number: usize, touch: &Touch) -> f64 {
        let law = &self.contacts[number].law;
        let normal_force = touch.slope * self.raw_normal_force(number, touch).max(0.0);
        law.friction * normal_force / law.friction_stiffness
    }

    /// The member with that place among all members.
    pub fn member(&self, place: usize) -> Member {
        match place.checked_sub(self.devices.len()) {
            None => Member::Device(place),
            Some(body) => Member::Body(body),
        }
    }

    /// The quaternions of all bodies at the start.
    pub fn orientations(&self) -> impl Iterator<Item = [f64; 4]> {
        self.orientations.iter().copied()
    }

    /// Numbers of the free bodies among all bodies, each with its place in the state and its motion.
    pub fn free_bodies(&self) -> impl Iterator<Item = (usize, usize, &FreeMotion)> {
        self.bodies
            .iter()
            .enumerate()
            .filter_map(|(number, rigid)| {
                let rigid = rigid.as_ref()?;
                Some((number, self.layout.body(rigid.free), &rigid.motion))
            })
    }
}

/// A length `[m]` and a speed `[m/s]` of haptic contact, against which errors count.
const LENGTH: f64 = 1e-3;
const SPEED: f64 = 0.1;

/// Distance over which the bristle of a sliding contact turns into the direction of motion, if its own length is
/// smaller `[m]`. A contact force that begins at 0 has a bristle of zero length, which would make the equations
/// arbitrarily stiff. A bristle of this length holds k_t times as much `[N]`, 0.2 mN at 2 kN/m. Energy does not depend
/// on its direction.
const TURNED_WITHIN: f64 = 1e-7;

/// Returns the damping force in addition to the bristle force -k_t z on the first member `[N]`: their sum is limited to
/// μ N.
fn damper(law: &ContactLaw, mode: Mode, touch: &Touch, normal_force: f64, bristle: Vec3) -> Vec3 {
    if law.friction_damping == 0.0 || !matches!(mode, Mode::Stick | Mode::Slip) {
        return Vec3::ZERO;
    }
    let elastic = bristle * -law.friction_stiffness;
    let both = elastic - touch.tangential() * law.friction_damping;
    let (size, largest) = (both.norm(), law.friction * normal_force);
    if size > largest {
        both * (largest / size) - elastic
    } else {
        both - elastic
    }
}

/// Returns the bristle direction of a sliding contact; for a bristle of zero length, the direction of the motion.
pub(super) fn slip_direction(bristle: Vec3, touch: &Touch) -> Vec3 {
    bristle
        .across(touch.normal)
        .direction()
        .or_else(|| touch.tangential().direction())
        .unwrap_or(Vec3::ZERO)
}

fn placed(position: [f64; 3], orientation: [f64; 4]) -> Placed {
    Placed {
        position: Vec3(position),
        rotation: Rotation::of_quaternion(orientation),
        velocity: Vec3::ZERO,
        turning: Vec3::ZERO,
    }
}

pub(super) fn quaternion(state: &[f64]) -> [f64; 4] {
    [state[0], state[1], state[2], state[3]]
}

fn angular_momentum(rotation: &Rotation, motion: &FreeMotion, turning: Vec3) -> Vec3 {
    let local = rotation.back(turning);
    rotation.out(Vec3(std::array::from_fn(|i| {
        local.0[i] * motion.inertia[i]
    })))
}

/// R I⁻¹ Rᵀ v: the angular velocity of an angular momentum.
fn angular_velocity(rotation: &Rotation, motion: &FreeMotion, v: Vec3) -> Vec3 {
    let local = rotation.back(v);
    rotation.out(Vec3(std::array::from_fn(|i| {
        local.0[i] / motion.inertia[i]
    })))
}

impl Instant {
    /// Kinetic energy of devices and free bodies `[J]`.
    pub fn kinetic_energy(&self, system: &System) -> f64 {
        let devices = system
            .devices
            .iter()
            .zip(self.placed.iter().zip(&self.grasps))
            .map(|(device, (placed, grasp))| {
                let of_turning = device.turning.as_ref().map_or(0.0, |turning| {
                    let momentum = turning.angular_momentum(&placed.rotation, placed.turning);
                    0.5 * momentum.dot(placed.turning)
                });
                if let Some(table) = &device.mass_table {
                    return of_turning + table.kinetic_energy(placed.position, placed.velocity);
                }
                let velocity = device.own(placed.velocity);
                (0..3)
                    .filter(|&axis| device.moves_along(axis))
                    .map(|axis| 0.5 * grasp.mass(device, axis) * velocity.0[axis].powi(2))
                    .sum::<f64>()
                    + of_turning
            });
        let bodies = system.free_bodies().map(|(number, _, motion)| {
            let placed = &self.placed[system.devices.len() + number];
            let momentum = angular_momentum(&placed.rotation, motion, placed.turning);
            0.5 * motion.mass * placed.velocity.dot(placed.velocity)
                + 0.5 * momentum.dot(placed.turning)
        });
        devices.sum::<f64>() + bodies.sum::<f64>()
    }

    /// Torque of the hand on a device with the orientation `q` at a time `[s]`; 0 after its release `[N m]`.
    fn hand_torque(&self, device: usize, turning: &Turning, (time, q): (f64, [f64; 4])) -> Vec3 {
        if self.grasps[device].holds {
            turning.hand_torque(time, q, self.placed[device].turning)
        } else {
            Vec3::ZERO
        }
    }

    /// Force of the hand on a device `[N]`.
    pub fn hand_force(&self, system: &System, number: usize, time: f64) -> Vec3 {
        let placed = &self.placed[number];
        let motion = [placed.position, placed.velocity];
        self.grasps[number].hand_force(&system.devices[number], time, motion)
    }

    /// Force of hand and contacts on a device `[N]`.
    pub fn push(&self, system: &System, number: usize, time: f64) -> Vec3 {
        self.hand_force(system, number, time) + self.forces[number]
    }

    /// Energy of the force fields `[J]`.
    pub fn field_energy(&self, system: &System) -> f64 {
        let fields = system.fields.iter();
        let each = fields.map(|field| field.pull(self.placed[field.device].position).1);
        each.sum()
    }

    /// Sum of the contact and field forces on the tool of a device `[N]`.
    pub fn contact_force(&self, device: usize) -> Vec3 {
        self.forces[device]
    }

    /// Sum of the contact torques on the tool of a device about its mass centre `[N m]`.
    pub fn contact_torque(&self, device: usize) -> Vec3 {
        self.torques[device]
    }

    /// Returns the stored energy of a contact, K p²/2 + k_t |z|²/2 `[J]`.
    pub fn stored_energy(&self, system: &System, number: usize) -> f64 {
        let law = &system.contacts[number].law;
        let p = self.touches[number].penetration.max(0.0);
        let z = self.bristles[number];
        0.5 * law.stiffness * p * p + 0.5 * law.friction_stiffness * z.dot(z)
    }
}
