//! Integration of a system in time: steps, events, and the recording of states and contacts.

use super::contact::WorldError;
use super::dormand_prince::Step;
use super::motion::{Condition, Instant, Mode, System, quaternion};
use super::record::{BodyState, ContactState, DeviceState, Encounter, ReferenceLedger, WorldState};
use super::scene::Vector;
use super::vector::{Rotation, Vec3};

/// Most steps and events within an interval of the grid.
const MAX_STEPS: usize = 200_000;
/// Number of sub-steps of a step; every contact is checked at the end of each.
const PARTS: u32 = 4;
/// An event is located to this time `[s]`.
const EVENT_WIDTH: f64 = 1e-15;
/// Shortest step of the error control `[s]`.
const SHORTEST_STEP: f64 = 1e-13;

/// A contact in progress.
#[derive(Debug, Clone)]
struct Open {
    encounter: usize,
    sums: [f64; 5],
}

/// A system on its way.
pub(super) struct Run<'a> {
    system: &'a System,
    tolerance: f64,
    scales: Vec<f64>,
    pub time: f64,
    pub state: Vec<f64>,
    conditions: Vec<Condition>,
    now: Instant,
    within: Vec<f64>,
    step: Step,
    first_is_known: bool,
    next_length: f64,
    /// Largest force on each tool since it was last set to 0.
    pub peaks: Vec<f64>,
    records: Vec<Encounter>,
    open: Vec<Option<Open>>,
    body_start: Vec<f64>,
    pub steps: usize,
    pub events: usize,
}

impl<'a> Run<'a> {
    pub fn new(system: &'a System, tolerance: f64) -> Self {
        let mut state = system.start();
        let mut now = system.instant();
        let conditions = system.first_conditions(&mut state, &mut now);
        let mut run = Self {
            system,
            tolerance,
            scales: system.scales(),
            time: 0.0,
            within: vec![0.0; system.layout.moving()],
            step: Step::of_size(system.layout.size()),
            first_is_known: false,
            next_length: 1e-5,
            peaks: vec![0.0; system.devices.len()],
            records: Vec::new(),
            open: vec![None; conditions.len()],
            body_start: state.clone(),
            state,
            conditions,
            now,
            steps: 0,
            events: 0,
        };
        run.note_changes();
        run
    }

    /// Puts a device to a place with a velocity; [`settle_anew`](Self::settle_anew) has to follow.
    pub fn lead(&mut self, device: usize, position: Vector, velocity: Vector) {
        let place = self.system.layout.device(device);
        self.state[place..place + 3].copy_from_slice(&position);
        self.state[place + 3..place + 6].copy_from_slice(&velocity);
    }

    /// Turns a device, if it is one that turns, to an orientation with an angular velocity in world axes `[rad/s]`;
    /// [`settle_anew`](Self::settle_anew) has to follow.
    pub fn lead_turning(&mut self, device: usize, orientation: [f64; 4], velocity: Vec3) {
        let Some(turning) = &self.system.devices[device].turning else {
            return;
        };
        let place = self.system.layout.device(device);
        let rotation = Rotation::of_quaternion(orientation);
        self.state[place + 6..place + 10].copy_from_slice(&orientation);
        let momentum = turning.angular_momentum(&rotation, velocity);
        momentum.write(&mut self.state[place + 10..]);
    }

    /// Re-evaluates all contacts after an external change of the state.
    pub fn settle_anew(&mut self) {
        self.first_is_known = false;
        // When a velocity jumps, the damping's part of N jumps, and so does the longest bristle, mu N/k_t. The length
        // of a bristle does not jump. A bristle that is now shorter than the longest sticks; a longer one is cut.
        for condition in &mut self.conditions {
            if condition.mode == Mode::Slip {
                condition.mode = Mode::Stick;
            }
        }
        self.settle();
    }

    fn settle(&mut self) {
        let time = self.time;
        self.system
            .settle(time, &mut self.state, &mut self.conditions, &mut self.now);
        self.note_changes();
    }

    /// Moves on to `end` `[s]`.
    pub fn advance(&mut self, end: f64) -> Result<(), WorldError> {
        loop {
            let events = self.now.grasps.iter().map(|grasp| grasp.until);
            let event = events.fold(f64::INFINITY, f64::min);
            if event <= self.time {
                self.go_on();
            } else if event < end {
                self.advance_within(event)?;
            } else {
                return self.advance_within(end);
            }
        }
    }

    /// Passes the events of the hands at the present time.
    fn go_on(&mut self) {
        let system = self.system;
        for (number, device) in system.devices.iter().enumerate() {
            let grasp = &mut self.now.grasps[number];
            if grasp.until > self.time {
                continue;
            }
            let held = grasp.holds;
            grasp.go_on(&device.hand, self.time);
            if held && !grasp.holds {
                // The hand leaves with the energy of its mass.
                let place = system.layout.device(number) + 3;
                let velocity = device.along_its_axes(Vec3::new(&self.state[place..]));
                let energy = 0.5 * device.hand.mass * velocity.dot(velocity);
                self.state[system.layout.device_sums(number) + 6] -= energy;
            }
        }
        self.first_is_known = false;
        self.settle();
    }

    /// Moves on to `end` `[s]`, with no event of a hand before it.
    fn advance_within(&mut self, end: f64) -> Result<(), WorldError> {
        let begin = self.time;
        // In time from the interval's begin, which has more digits.
        let duration = end - begin;
        let mut done = 0.0;
        for _ in 0..MAX_STEPS {
            let left = duration - done;
            let length = if self.next_length > 0.999 * left {
                left
            } else {
                self.next_length
            };
            let error = self.try_step(begin + done, length);
            let shrunk = length * (0.9 * error.powf(-0.2)).clamp(0.2, 4.0);
            if error > 1.0 && length > SHORTEST_STEP {
                self.next_length = shrunk;
                self.first_is_known = true; // the start has not moved
                continue;
            }
            let event = self.first_event(begin + done, length);
            let taken = match event {
                Some(fraction) if fraction < 1.0 => {
                    let to_event = fraction * length;
                    self.first_is_known = true;
                    self.try_step(begin + done, to_event);
                    to_event
                }
                _ => length,
            };
            self.steps += 1;
            self.state.copy_from_slice(self.step.end());
            done = if taken == left {
                duration
            } else {
                done + taken
            };
            self.time = begin + done;
            if event.is_some() {
                self.events += 1;
                self.first_is_known = false;
                self.settle();
            } else {
                self.step.hand_on();
                self.first_is_known = true;
                // A step shortened by the interval's end is not representative of the next one.
                self.next_length = if length < self.next_length {
                    self.next_length.max(shrunk)
                } else {
                    shrunk
                };
            }
            if done >= duration {
                self.time = end;
                return Ok(());
            }
        }
        Err(WorldError::TooManySteps {
            limit: MAX_STEPS,
            time: self.time,
        })
    }

    /// A step from here, and its error over the tolerance.
    fn try_step(&mut self, time: f64, length: f64) -> f64 {
        let (system, conditions, now) = (self.system, &self.conditions, &mut self.now);
        self.step.take(
            time,
            &self.state,
            length,
            self.first_is_known,
            |time, state, rates| system.rates(time, state, conditions, now, rates),
        );
        let mut largest = 1e-9_f64;
        for (i, scale) in self.scales.iter().enumerate() {
            largest = largest.max(self.step.error(i).abs() / (self.tolerance * scale));
        }
        if largest.is_nan() { 1e9 } else { largest }
    }

    /// The fraction of the step at which the first contact has just left its condition.
    fn first_event(&mut self, time: f64, length: f64) -> Option<f64> {
        let mut before = 0.0;
        self.look(time, length, 0.0);
        self.note_peaks();
        let mut rates_before = self.free_rates();
        for part in 1..=PARTS {
            let fraction = f64::from(part) / f64::from(PARTS);
            let holds = self.look(time, length, fraction);
            if !holds {
                return Some(self.bracket(time, length, before, fraction));
            }
            self.note_peaks();
            let rates = self.free_rates();
            for (number, (was, is)) in rates_before.iter().zip(&rates).enumerate() {
                if *was > 0.0
                    && *is < 0.0
                    && let Some(summit) = self.summit(time, length, number, before, fraction)
                {
                    return Some(self.bracket(time, length, before, summit));
                }
            }
            rates_before = rates;
            before = fraction;
        }
        None
    }

    /// p′ of every contact that is free, 0 of the others.
    fn free_rates(&self) -> Vec<f64> {
        self.conditions
            .iter()
            .zip(&self.now.touches)
            .map(|(condition, touch)| match condition.mode {
                Mode::Free => touch.growth,
                _ => 0.0,
            })
            .collect()
    }

    /// Evaluates the step at a fraction; whether all contacts are still in their conditions.
    fn look(&mut self, time: f64, length: f64, fraction: f64) -> bool {
        self.step.at(fraction, &mut self.within);
        let time = time + fraction * length;
        self.system
            .evaluate(time, &self.within, &self.conditions, &mut self.now);
        self.system.all_hold(time, &self.conditions, &self.now)
    }

    /// Returns the minimum of a free contact's gap between two fractions, if the contact has begun there.
    fn summit(&mut self, time: f64, length: f64, number: usize, from: f64, to: f64) -> Option<f64> {
        let gap = -self.now.touches[number].penetration;
        let reach = self.now.touches[number].growth.abs() * (to - from) * length;
        if gap > 2.0 * reach {
            return None; // too far to have been there
        }
        let (mut low, mut high) = (from, to);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if !self.look(time, length, middle) {
                return Some(middle);
            }
            if self.now.touches[number].growth > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        None
    }

    /// Closes in on the end of what holds at `low` and not at `high`; the side at which it no longer does.
    fn bracket(&mut self, time: f64, length: f64, mut low: f64, mut high: f64) -> f64 {
        while (high - low) * length > EVENT_WIDTH {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.look(time, length, middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// Updates the largest forces and depths with the present instant.
    fn note_peaks(&mut self) {
        for (number, open) in self.open.iter().enumerate() {
            if let Some(open) = open {
                let record = &mut self.records[open.encounter];
                record.peak_force = record.peak_force.max(self.now.normal_forces[number]);
                record.deepest = record.deepest.max(self.now.touches[number].penetration);
            }
        }
        let devices = self.peaks.iter_mut().zip(&self.system.devices);
        for (number, (peak, device)) in devices.enumerate() {
            let force = device.along_its_axes(self.now.contact_force(number));
            *peak = peak.max(force.norm());
        }
    }

    /// Begins and ends records after contacts have changed their modes.
    fn note_changes(&mut self) {
        for number in 0..self.conditions.len() {
            let is_free = self.conditions[number].mode == Mode::Free;
            let place = self.system.layout.contact_sums(number);
            let sums: [f64; 5] = std::array::from_fn(|i| self.state[place + i]);
            match (&self.open[number], is_free) {
                (None, false) => {
                    let contact = &self.system.contacts[number];
                    self.open[number] = Some(Open {
                        encounter: self.records.len(),
                        sums,
                    });
                    self.records.push(Encounter {
                        pair: contact.pair,
                        contact: number,
                        between: [contact.first, contact.second]
                            .map(|member| self.system.member(member)),
                        start: self.time,
                        end: None,
                        normal_impulse: 0.0,
                        impulse: [0.0; 3],
                        dissipated: 0.0,
                        peak_force: 0.0,
                        deepest: 0.0,
                    });
                }
                (Some(open), true) => {
                    let record = &mut self.records[open.encounter];
                    record.end = Some(self.time);
                    record.add(&open.sums, &sums);
                    self.open[number] = None;
                }
                _ => {}
            }
        }
        self.system
            .evaluate(self.time, &self.state, &self.conditions, &mut self.now);
        self.note_peaks();
    }

    /// Returns all records, including those in progress.
    pub fn encounters(&self) -> Vec<Encounter> {
        let mut records = self.records.clone();
        for (number, open) in self.open.iter().enumerate() {
            if let Some(open) = open {
                let place = self.system.layout.contact_sums(number);
                let sums = std::array::from_fn(|i| self.state[place + i]);
                records[open.encounter].add(&open.sums, &sums);
            }
        }
        records
    }

    pub fn world_state(&mut self) -> WorldState {
        let system = self.system;
        system.evaluate(self.time, &self.state, &self.conditions, &mut self.now);
        let now = &self.now;
        let devices = system
            .devices
            .iter()
            .enumerate()
            .map(|(number, device)| DeviceState {
                position: now.placed[number].position.0,
                velocity: now.placed[number].velocity.0,
                force: now.contact_force(number).0,
                hand_force: now.hand_force(system, number, self.time).0,
                orientation: match device.turning {
                    Some(_) => unit(quaternion(&self.state[system.layout.device(number) + 6..])),
                    None => [1.0, 0.0, 0.0, 0.0],
                },
                angular_velocity: now.placed[number].turning.0,
                torque: match device.turning {
                    Some(_) => now.contact_torque(number).0,
                    None => [0.0; 3],
                },
            })
            .collect();
        let contacts = (0..system.contacts.len())
            .map(|number| ContactState {
                penetration: now.touches[number].penetration,
                normal: now.touches[number].normal.0,
                normal_force: now.normal_forces[number],
                bristle: now.bristles[number].0,
            })
            .collect();
        WorldState {
            time: self.time,
            devices,
            bodies: self.body_states(),
            contacts,
            ledger: self.ledger(),
        }
    }

    fn body_states(&self) -> Vec<BodyState> {
        let system = self.system;
        let placed = &self.now.placed[system.devices.len()..];
        let mut bodies: Vec<BodyState> = placed
            .iter()
            .zip(system.orientations())
            .map(|(placed, orientation)| BodyState {
                position: placed.position.0,
                orientation,
                velocity: placed.velocity.0,
                angular_velocity: placed.turning.0,
                angular_momentum: [0.0; 3],
            })
            .collect();
        for (number, place, _) in system.free_bodies() {
            let q = quaternion(&self.state[place + 6..]);
            bodies[number].orientation = unit(q);
            bodies[number].angular_momentum = Vec3::new(&self.state[place + 10..]).0;
        }
        bodies
    }

    fn ledger(&self) -> ReferenceLedger {
        let system = self.system;
        let layout = &system.layout;
        let contacts = 0..system.contacts.len();
        ReferenceLedger {
            kinetic: self.now.kinetic_energy(system),
            stored: contacts
                .clone()
                .map(|number| self.now.stored_energy(system, number))
                .sum::<f64>()
                + self.now.holds.iter().map(|hold| hold.stored).sum::<f64>()
                + self.now.field_energy(system),
            dissipated: contacts
                .map(|number| self.state[layout.contact_sums(number) + 4])
                .sum::<f64>()
                + (0..system.joints.len())
                    .map(|number| self.state[layout.joint_sum(number)])
                    .sum::<f64>(),
            hand_work: (0..system.devices.len())
                .map(|number| self.state[layout.device_sums(number) + 6])
                .sum(),
            body_work: system
                .free_bodies()
                .map(|(_, place, motion)| {
                    let travel =
                        Vec3::new(&self.state[place..]) - Vec3::new(&self.body_start[place..]);
                    Vec3(motion.force).dot(travel)
                })
                .sum(),
        }
    }
}

/// Returns the same rotation by a quaternion of length 1.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = q.iter().map(|part| part * part).sum::<f64>().sqrt();
    q.map(|part| part / length)
}
