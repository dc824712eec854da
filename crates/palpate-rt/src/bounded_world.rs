//! A world between its renderer and whoever holds its forces: rendered, and bounded by the safety of each device.
//!
//! It is for a loop of somebody else's, which reads positions and sends wrenches by itself. [`ControlLoop`](crate::ControlLoop)
//! has its own way from a device to its motors.

use palpate::Actuation;
use palpate_device::Wrench;
use palpate_world::{
    BodyState, Effort, Limited, Sample, Vector, World, WorldError, WorldFault, WorldRenderer,
    WorldState,
};

use crate::created_energy::CreatedEnergy;
use crate::fade::Fade;
use crate::safety::{Bounded, Looked, Rendered, Safety, SafetyError, SafetyParams, Trip};

/// The safety of each device of a world.
#[derive(Clone, Debug)]
pub struct WorldSafety {
    /// As each begins.
    fresh: Safety,
    devices: Vec<Safety>,
    /// Result of the first round of a tick for each device.
    looked: Vec<Option<(Rendered, Looked)>>,
    created: CreatedEnergy,
}

/// What a renderer has answered, as far as safety looks at it.
#[derive(Clone, Copy, Debug)]
pub struct Answered<'a> {
    /// Time since the sample before `[s]`; `None` for the first.
    pub elapsed: Option<f64>,
    /// Where the tools were sampled `[m]`.
    pub positions: &'a [Vector],
    /// Whether the renderer refused the sample, and so asks for no force.
    pub refused: bool,
    /// Energy that held forces have created by the renderer's books, up to this sample `[J]`: of a world
    /// [`WorldState::created_at_ports`].
    pub created_energy: f64,
}

impl WorldSafety {
    /// The same limits for each of so many devices, in a loop of `period` `[s]`.
    ///
    /// # Errors
    /// The first parameter outside its range, by name, with what is allowed.
    pub fn new(devices: usize, params: SafetyParams, period: f64) -> Result<Self, SafetyError> {
        let fresh = Safety::new(params, period)?;
        Ok(Self {
            devices: vec![fresh.clone(); devices],
            fresh,
            looked: vec![None; devices],
            created: CreatedEnergy::default(),
        })
    }

    /// The same for this model of the actuator: the limits bound a command and the command times its gain.
    #[must_use]
    pub fn rendering(mut self, actuation: &Actuation<f64>) -> Self {
        for safety in self.devices.iter_mut().chain([&mut self.fresh]) {
            safety.follow(actuation, f64::INFINITY);
        }
        self
    }

    /// Begins anew: nothing sampled, nothing sent.
    pub fn restart(&mut self) {
        self.devices.fill(self.fresh.clone());
        self.created = CreatedEnergy::default();
    }

    /// Skips the interval up to the next sample: bodies were placed or replaced, which changes the energy from outside.
    pub fn skip_interval(&mut self) {
        self.created.skip_interval();
    }

    /// The safety stop that holds all forces at 0, if one does. [`restart`](Self::restart) ends it.
    #[must_use]
    pub fn trip(&self) -> Option<Trip> {
        self.devices.iter().find_map(Safety::trip)
    }

    /// Energy that held forces have created `[J]`, as of the last sample, without the intervals that begin or end at a sample that
    /// was refused, and without what contacts stored at the first one.
    #[must_use]
    pub fn created_energy(&self) -> f64 {
        self.created.counted()
    }

    /// The limits of each device.
    #[must_use]
    pub fn params(&self) -> &SafetyParams {
        self.fresh.params()
    }

    /// Puts each wrench through the safety of its device, in two rounds as [`ControlLoop`](crate::ControlLoop) does: a stop of
    /// one device takes the force off all. The limits that changed one of them.
    pub fn bound(&mut self, answered: &Answered<'_>, wrenches: &mut [Wrench]) -> Bounded {
        let was_off = self.trip().is_some();
        self.created
            .close(answered.created_energy, answered.refused, was_off);
        let comes_in = self.devices.iter().any(Safety::is_not_all_there);
        let mut created_energy = self.created.counted();
        let tools = wrenches.iter().zip(answered.positions);
        let devices = self.devices.iter_mut().zip(&mut self.looked);
        for ((safety, looked), (wrench, position)) in devices.zip(tools) {
            let rendered = Rendered {
                elapsed: answered.elapsed,
                // A position that the renderer has refused is not looked at.
                position: if answered.refused {
                    [0.0; 3]
                } else {
                    *position
                },
                coordinate: 0.0,
                wrench: *wrench,
                created_energy,
                refused: answered.refused,
                stalled: false,
            };
            *looked = Some((rendered, safety.look(&rendered, comes_in)));
            // The energy is that of the world: the first safety watches it.
            created_energy = 0.0;
        }
        let is_off = self.trip().is_some();
        let mut bounded = Bounded::default();
        let devices = self.devices.iter_mut().zip(&mut self.looked);
        for ((safety, looked), wrench) in devices.zip(wrenches) {
            let Some((rendered, looked)) = looked.take() else {
                continue;
            };
            let verdict = safety.answer(&rendered, looked, is_off);
            bounded.force |= verdict.bounded.force;
            bounded.slew |= verdict.bounded.slew;
            bounded.soft_start |= verdict.bounded.soft_start;
            bounded.stopped |= verdict.bounded.stopped;
            // A force of -0 that comes in softly is none.
            *wrench = verdict.wrench.each(|vector| vector.map(|x| x + 0.0));
        }
        bounded
    }
}

/// A world that is rendered for any number of devices, and what may reach them.
#[derive(Clone, Debug)]
pub struct BoundedWorld {
    renderer: WorldRenderer,
    state: WorldState,
    safety: WorldSafety,
    /// What is to be held, for each device.
    wrenches: Vec<Wrench>,
    /// What is left of what was held before a change.
    fade: Fade,
    /// The world before the last change, which says what would have been held; until the next one, since a tick frees nothing.
    before: Option<(WorldRenderer, WorldState)>,
    is_compared: bool,
    /// What it asks for.
    asked_before: Vec<Wrench>,
}

/// The answer to one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<'a> {
    /// What each device is to give to the hand, and to hold until the next sample; finite for any sample.
    pub wrenches: &'a [Wrench],
    /// Limits of the renderer that acted.
    pub limited: Limited,
    /// Limits of the safety that acted.
    pub bounded: Bounded,
    /// What the tick has cost, and what did not fit in it.
    pub effort: Effort,
    /// Why the sample was refused, if it was: every wrench is then none.
    pub fault: Option<WorldFault>,
}

impl BoundedWorld {
    /// A world at its start, with the same limits for each device.
    ///
    /// # Errors
    /// The first limit outside its range, by name, with what is allowed.
    pub fn new(renderer: WorldRenderer, limits: SafetyParams) -> Result<Self, SafetyError> {
        let state = renderer.start();
        let tools = state.tools().len();
        Ok(Self {
            safety: WorldSafety::new(tools, limits, renderer.in_loop().period)?
                .rendering(&renderer.in_loop().actuation),
            wrenches: vec![Wrench::NONE; tools],
            fade: Fade::none(tools),
            before: None,
            is_compared: false,
            asked_before: vec![Wrench::NONE; tools],
            state,
            renderer,
        })
    }

    /// One tick: a sample of all tools in, what each device is to hold out. It does not allocate, lock or wait. The
    /// renderer knows of what its limits and those of the safety have taken.
    pub fn step(&mut self, sample: &Sample<'_>) -> Held<'_> {
        let is_compared = self.is_compared && self.fade.is_settling() && self.ask_before(sample);
        let output = self.renderer.step(&mut self.state, sample);
        let (mut limited, effort, fault) = (output.limited, output.effort, output.fault);
        let asked = output.forces.iter().zip(output.torques);
        let asked = asked.map(|(&force, &torque)| Wrench { force, torque });
        if fault.is_some() {
            self.fade.end();
        }
        let elapsed = sample.elapsed.unwrap_or(self.renderer.in_loop().period);
        let before = is_compared.then_some(&*self.asked_before);
        let wrenches = &mut self.wrenches;
        if self.fade.answer(asked, before, elapsed, wrenches) {
            let within = self.renderer.keep_within(&self.state, wrenches, |wrench| {
                [&mut wrench.force, &mut wrench.torque]
            });
            limited = limited.and(within);
        }
        let answered = Answered {
            elapsed: sample.elapsed,
            positions: sample.positions,
            refused: fault.is_some(),
            created_energy: self.state.created_at_ports(),
        };
        let bounded = self.safety.bound(&answered, &mut self.wrenches);
        for (tool, wrench) in self.wrenches.iter().enumerate() {
            let (renderer, state) = (&self.renderer, &mut self.state);
            renderer.report_sent(state, tool, wrench.force);
            renderer.report_sent_torque(state, tool, wrench.torque);
        }
        Held {
            wrenches: &self.wrenches,
            limited,
            bounded,
            effort,
            fault,
        }
    }

    /// What the world before the last change would have asked for; `false` where it refuses the sample.
    fn ask_before(&mut self, sample: &Sample<'_>) -> bool {
        let Some((renderer, state)) = &mut self.before else {
            return false;
        };
        let output = renderer.step(state, sample);
        let asked = output.forces.iter().zip(output.torques);
        for (before, (&force, &torque)) in self.asked_before.iter_mut().zip(asked) {
            *before = Wrench { force, torque };
        }
        output.fault.is_none()
    }

    /// Begins anew: bodies at their start, or as they were at the last change, nothing sampled, nothing sent, the books empty.
    pub fn restart(&mut self) {
        self.state = self.renderer.start();
        self.safety.restart();
        self.wrenches.fill(Wrench::NONE);
        self.fade.end();
    }

    /// The safety stop that holds all forces at 0, if one does. [`restart`](Self::restart) ends it.
    #[must_use]
    pub fn trip(&self) -> Option<Trip> {
        self.safety.trip()
    }

    /// Energy that held forces have created `[J]`: see [`WorldSafety::created_energy`].
    #[must_use]
    pub fn created_energy(&self) -> f64 {
        self.safety.created_energy()
    }

    /// What each device was to hold by the last sample: as the last [`Held`] said.
    #[must_use]
    pub fn wrenches(&self) -> &[Wrench] {
        &self.wrenches
    }

    /// Says what was really sent to a device for the last sample, where something between has limited it.
    pub fn report_sent(&mut self, tool: usize, sent: Wrench) {
        self.renderer.report_sent(&mut self.state, tool, sent.force);
        self.renderer
            .report_sent_torque(&mut self.state, tool, sent.torque);
    }

    /// Goes on with another world between two ticks, as [`WorldRenderer::changed`] says: bodies, contacts and joints come,
    /// go and get other numbers, and all others go on. The devices are held as by the world before for three samples, which
    /// take twice as long, and what they are held by then passes over in [`CHANGE_DURATION`](crate::CHANGE_DURATION), without
    /// a step. It allocates, which a tick does not.
    ///
    /// # Errors
    /// Everything that is wrong with the new world; nothing is changed then.
    pub fn change(&mut self, world: &World) -> Result<(), Vec<WorldError>> {
        let (renderer, state) = self.renderer.changed(&self.state, world)?;
        let renderer = std::mem::replace(&mut self.renderer, renderer);
        let state = std::mem::replace(&mut self.state, state);
        self.before = Some((renderer, state));
        self.is_compared = true;
        self.safety.skip_interval();
        self.fade.begin();
        Ok(())
    }

    /// Puts a body elsewhere between two ticks, as [`WorldRenderer::place`] says. What the devices are held by stays for three
    /// samples and then passes over as after a [`change`](Self::change). It does not allocate.
    ///
    /// # Errors
    /// There is no such body, or it cannot be there; nothing is changed then.
    pub fn place(&mut self, body: usize, to: &BodyState) -> Result<(), WorldError> {
        self.renderer.place(&mut self.state, body, to)?;
        self.is_compared = false;
        self.safety.skip_interval();
        self.fade.begin();
        Ok(())
    }

    /// The world at the last sample.
    #[must_use]
    pub fn state(&self) -> &WorldState {
        &self.state
    }

    /// What renders it.
    #[must_use]
    pub fn renderer(&self) -> &WorldRenderer {
        &self.renderer
    }

    /// The limits of each device.
    #[must_use]
    pub fn limits(&self) -> &SafetyParams {
        self.safety.params()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, Motion, Party, Shape, Tool, World, WorldGuard,
        WorldGuardParams, WorldLoop,
    };

    const PERIOD: f64 = 1e-3;

    /// A point over a floor of 1 kN/m.
    fn world(limits: SafetyParams) -> BoundedWorld {
        let floor = Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        };
        let world = World {
            tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
            bodies: vec![Body::new("floor", floor, Motion::Fixed)],
            contacts: vec![Contact {
                between: [Party::Any, Party::Any],
                law: ContactLaw::spring(1000.0),
            }],
            joints: Vec::new(),
        };
        let in_loop = WorldLoop::new(PERIOD);
        let renderer =
            WorldRenderer::new(&world, in_loop, BasicParams::default()).expect("renderable");
        BoundedWorld::new(renderer, limits).expect("limits in their range")
    }

    fn held(world: &mut BoundedWorld, depth: f64) -> ([f64; 3], Held<'_>) {
        let held = world.step(&Sample::at(&[[0.0, 0.0, -depth]]));
        (held.wrenches[0].force, held)
    }

    #[test]
    fn a_force_is_bounded_and_the_renderer_knows() {
        let limits = SafetyParams {
            largest_force: 2.0,
            soft_start: 0.0,
            ..SafetyParams::default()
        };
        let mut world = world(limits);
        let (force, answer) = held(&mut world, 1e-3);
        assert_eq!(force, [0.0, 0.0, 1.0]);
        assert!(!answer.bounded.any());
        let (force, answer) = held(&mut world, 5e-3);
        assert_eq!(force, [0.0, 0.0, 2.0]);
        assert!(answer.bounded.force);
        // The books have the 2 N that were held over the next millimetre, and not 5 N.
        let _ = held(&mut world, 6e-3);
        let work = world.state().books().devices[0].port_work;
        // 1 N over 4 mm inwards, then 2 N over 1 mm.
        assert!((work + 4e-3 + 2e-3).abs() < 1e-12, "{work}");
    }

    #[test]
    fn a_force_comes_in_softly_and_a_sample_that_is_refused_gets_none() {
        let mut world = world(SafetyParams {
            soft_start: 4.0 * PERIOD,
            ..SafetyParams::default()
        });
        for expected in [0.0, 0.25, 0.5, 0.75, 1.0, 1.0] {
            let (force, answer) = held(&mut world, 1e-3);
            assert!((force[2] - expected).abs() < 1e-12);
            assert_eq!(answer.bounded.soft_start, expected < 1.0);
        }
        let (force, answer) = held(&mut world, f64::NAN);
        assert_eq!(force, [0.0; 3]);
        assert!(answer.fault.is_some());
        // Back, but not at once.
        assert!(held(&mut world, 1e-3).0[2] < 0.5);
        // Begun anew, it comes in as it did.
        world.restart();
        assert_eq!(world.state().books().devices[0].port_work, 0.0);
        assert_eq!(held(&mut world, 1e-3).0, [0.0; 3]);
        assert!((held(&mut world, 1e-3).0[2] - 0.25).abs() < 1e-12);
    }

    fn unbounded() -> SafetyParams {
        SafetyParams {
            soft_start: 0.0,
            ..SafetyParams::default()
        }
    }

    #[test]
    fn what_a_change_makes_of_the_force_comes_in_without_a_step() {
        let mut world = world(unbounded());
        for _ in 0..10 {
            assert_eq!(held(&mut world, 1e-3).0, [0.0, 0.0, 1.0]);
        }
        let mut stiffer = world.renderer().world().clone();
        stiffer.contacts[0].law = ContactLaw::spring(5000.0);
        world.change(&stiffer).expect("renderable");
        for _ in 0..3 {
            assert_eq!(held(&mut world, 1e-3).0[2], 1.0);
        }
        for tick in 1..=100 {
            let (force, answer) = held(&mut world, 1e-3);
            let expected = 1.0 + 4.0 * f64::from(tick) * PERIOD / crate::CHANGE_DURATION;
            assert!((force[2] - expected).abs() < 1e-9, "{tick}: {force:?}");
            assert!(answer.fault.is_none());
        }
        assert_eq!(held(&mut world, 1e-3).0[2], 5.0);
        // The books have what was held and what was asked for.
        let books = world.state().books();
        assert!(books.contacts[0].outside > 0.0);
    }

    #[test]
    fn a_floor_that_goes_lets_go_in_a_tenth_of_a_second_and_a_refused_sample_at_once() {
        for is_refused in [false, true] {
            let mut world = world(unbounded());
            held(&mut world, 2e-3);
            let mut empty = world.renderer().world().clone();
            empty.bodies.clear();
            world.change(&empty).expect("renderable");
            for _ in 0..3 {
                assert_eq!(held(&mut world, 2e-3).0[2], 2.0);
            }
            if is_refused {
                assert_eq!(held(&mut world, f64::NAN).0, [0.0; 3]);
                assert_eq!(held(&mut world, 2e-3).0, [0.0; 3]);
                continue;
            }
            for tick in 1..=100 {
                let force = held(&mut world, 2e-3).0[2];
                let expected = 2.0 * (1.0 - f64::from(tick) * 1e-2);
                assert!((force - expected).abs() < 1e-9, "{tick}: {force}");
            }
            assert_eq!(held(&mut world, 2e-3).0, [0.0; 3]);
        }
    }

    #[test]
    fn a_floor_that_is_put_elsewhere_does_not_strike() {
        let mut world = world(unbounded());
        held(&mut world, 0.0);
        let higher = BodyState {
            position: [0.0, 0.0, 1e-3],
            ..world.state().bodies()[0]
        };
        world.place(0, &higher).expect("a place");
        for _ in 0..3 {
            assert_eq!(held(&mut world, 0.0).0, [0.0; 3]);
        }
        assert!((held(&mut world, 0.0).0[2] - 0.01).abs() < 1e-9);
        assert!(world.place(1, &higher).is_err());
    }

    /// The limits of the world's loop, and not only those of the safety behind it, hold for what was held before a change.
    #[test]
    fn the_limits_and_the_guard_of_a_world_hold_in_every_tick_of_a_change() {
        let params = WorldGuardParams {
            largest_speed: 1.0,
            largest_turning: 1.0,
            allowance: 1e-3,
            late: 0,
        };
        // A millijoule that may be given out within a millisecond at 1 m/s: 1 N, too.
        for guard in [WorldGuard::Off, WorldGuard::Limit(params)] {
            let plain = world(unbounded()).renderer().world().clone();
            let mut in_loop = WorldLoop::new(PERIOD).with_guard(guard);
            if guard == WorldGuard::Off {
                in_loop = in_loop.with_force_limits(vec![1.0]);
            }
            let renderer =
                WorldRenderer::new(&plain, in_loop, BasicParams::default()).expect("renderable");
            let mut world =
                BoundedWorld::new(renderer, unbounded()).expect("limits in their range");
            // What a world before has left: 5 N.
            world.wrenches[0] = Wrench::of_force([0.0, 0.0, 5.0]);
            world.fade.begin();
            let mut acted = 0;
            for tick in 0..120 {
                let (force, answer) = held(&mut world, -1e-3);
                assert!(force[2] <= 1.0 + 1e-12, "{guard:?}, tick {tick}: {force:?}");
                acted += usize::from(answer.limited.any());
            }
            assert!(acted > 0, "{guard:?}");
            assert_eq!(held(&mut world, -1e-3).0, [0.0; 3]);
        }
    }

    /// Coupled rendering under a finger that rests: a change of stiffness is felt within 0.1 s, without a step.
    #[test]
    fn a_change_under_a_coupled_finger_does_not_step() {
        let stiff = world(unbounded()).renderer().world().clone();
        let method = palpate_world::CoupledParams::new(vec![[0.15; 3]]);
        let renderer =
            WorldRenderer::new(&stiff, WorldLoop::new(PERIOD), method).expect("renderable");
        let mut world = BoundedWorld::new(renderer, unbounded()).expect("limits in their range");
        for _ in 0..200 {
            held(&mut world, 4e-3);
        }
        let mut before = held(&mut world, 4e-3).0[2];
        assert!((before - 4.0).abs() < 0.1, "{before}");
        let mut softer = stiff;
        softer.contacts[0].law = ContactLaw::spring(100.0);
        world.change(&softer).expect("renderable");
        let mut steps: f64 = 0.0;
        for _ in 0..300 {
            let force = held(&mut world, 4e-3).0[2];
            steps = steps.max((force - before).abs());
            before = force;
        }
        assert!((before - 0.4).abs() < 0.02, "{before}");
        assert!(steps < 0.1, "a step of {steps} N");
    }

    #[test]
    fn a_change_far_away_is_not_felt() {
        let (mut world, mut beside) = (world(unbounded()), world(unbounded()));
        let mut more = world.renderer().world().clone();
        let ball = Shape::Sphere { radius: 0.01 };
        more.bodies.insert(
            0,
            Body::new("ball", ball, Motion::Fixed).at([1.0, 0.0, 0.0]),
        );
        for tick in 0..300 {
            if tick == 100 {
                world.change(&more).expect("renderable");
            }
            let depth = 1e-5 * f64::from(tick);
            assert_eq!(held(&mut world, depth).0, held(&mut beside, depth).0);
        }
    }
}
