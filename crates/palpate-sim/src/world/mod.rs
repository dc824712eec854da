//! Worlds in closed loop: a scene of several devices, bodies and contacts, rendered by a method and judged by
//! its ideal.

mod judged;
mod rendered;

use palpate_scene::ActuatorParams;
use palpate_scene::world::{WorldActuator, WorldScene};
use palpate_testbed::world::{
    CheckedIdeal, Decisive, JudgementError, LedPath, PlantParams, WorldError as IdealError,
    WorldIdeal, WorldJudgement, WorldPlant,
};
use palpate_world::{
    Books, Limited, Output, Quaternion, Sample, Vector, WorldError, WorldFault, WorldGuard,
    WorldRenderer,
};

pub use judged::as_judged;
pub(crate) use judged::judged_turning;
pub use rendered::as_rendered;

/// Most periods of a window.
const MOST_PERIODS: f64 = 1e6;

/// A scene with its ideal, for any number of runs.
#[derive(Clone, Debug)]
pub struct WorldBench {
    judged: palpate_testbed::world::WorldScene,
    params: PlantParams,
    ideal: WorldIdeal,
    check: Option<SelfCheck>,
    /// The motion along which the devices are led, if they are.
    path: Option<LedPath>,
}

/// What the ideal says of itself, computed twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfCheck {
    /// Mean-force error of the coarser solution against the finer one `[%]`.
    pub error: f64,
    /// From when on the two part: the window ends there. `None`: they agree over the whole window `[s]`.
    pub chaotic_from: Option<f64>,
}

/// What a method made of a scene.
#[derive(Clone, Debug)]
pub struct WorldRun {
    /// Name of the method.
    pub method: String,
    /// Force on each tool that was commanded at each sample: `[sample][device]` `[N]`.
    pub commanded: Vec<Vec<Vector>>,
    /// Torque on each tool likewise `[N m]`.
    pub commanded_torques: Vec<Vec<Vector>>,
    /// Force on each tool over each interval of the ideal's grid, as its actuator gave it: `[device][interval]` `[N]`.
    pub delivered: Vec<Vec<Vector>>,
    /// Torque on each tool likewise `[N m]`.
    pub delivered_torques: Vec<Vec<Vector>>,
    /// Position of each device at each sample: `[sample][device]` `[m]`.
    pub positions: Vec<Vec<Vector>>,
    /// How each device is turned at each sample likewise, unit quaternions `[w, x, y, z]`.
    pub orientations: Vec<Vec<Quaternion>>,
    /// How the delivered forces compare with the ideal's.
    pub judgement: WorldJudgement,
    /// The renderer's books of energy at the end.
    pub books: Books,
    /// Energy that contacts have by their overlap at the first sample `[J]`: nobody created it.
    pub found_at_start: f64,
    /// Created energy at the end, with the energy found at the start `[J]`:
    /// [`palpate_world::WorldState::created_at_ports`].
    booked: f64,
    /// Samples that the renderer refused.
    pub refused: usize,
    /// The first of them, and why.
    pub first_refusal: Option<Refusal>,
    /// Samples at which a limit changed a force. A guard that only reports is none.
    pub limited: usize,
    /// Samples at which forces exceeded the guard's bound.
    pub guarded: usize,
    /// Intervals in which a contact changed its mode more often than the tick could follow at its finest.
    pub coarse: usize,
    /// Samples at which more of what may touch was near than the renderer has room for.
    pub crowded: usize,
    /// Samples at which the fastest contact or joint asked for more sub-steps than a tick has: see
    /// [`Effort::too_fast`](palpate_world::Effort::too_fast).
    pub too_fast: usize,
    /// How often a tool or body went through a solid and came out of its far side.
    pub went_through: usize,
    /// The first time.
    pub first_through: Option<Through>,
}

/// A tool or body that went through a solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Through {
    /// When it was found on the far side `[s]`.
    pub time: f64,
    /// Names of the tool or body that went through, and of the solid.
    pub names: [String; 2],
}

/// A sample that the renderer refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refusal {
    /// When it was taken `[s]`.
    pub time: f64,
    /// What was wrong.
    pub fault: WorldFault,
    /// Whether a contact or joint is too fast for the finest sub-steps: see [`Effort::unstable`](palpate_world::Effort::unstable).
    pub too_fast: bool,
}

impl Refusal {
    fn of(output: &Output<'_>, time: f64) -> Option<Self> {
        output.fault.map(|fault| Self {
            time,
            fault,
            too_fast: output.effort.unstable,
        })
    }
}

/// Why a world cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldBenchError {
    /// The world, its loop or its method cannot be rendered: at least one fault.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Rendering(Vec<WorldError>),
    /// There is no ideal to judge by.
    #[error("the ideal: {0}")]
    Ideal(#[from] IdealError),
    /// The window has more periods than are run.
    #[error(
        "the window has {0} periods, and at most 1e6 are run: shorten `duration_s`, or the motion that is rendered"
    )]
    TooLong(f64),
    /// The run and its ideal do not fit.
    #[error(transparent)]
    Judgement(#[from] JudgementError),
}

impl WorldRun {
    /// Energy that held forces created `[J]`: what [`palpate_world::WorldState::created_at_ports`] says, without the energy of contacts that
    /// overlap at the first sample.
    #[must_use]
    pub fn created(&self) -> f64 {
        self.booked - self.found_at_start
    }
}

impl WorldBench {
    /// Solves the scene's ideal over its window.
    ///
    /// # Errors
    /// The window is too long, or the scene has no ideal.
    pub fn new(scene: &WorldScene) -> Result<Self, WorldBenchError> {
        Self::solved(scene, scene.duration / scene.timing.period, None)
    }

    /// Solves the ideal of a scene whose devices are led along a recorded motion, over as many whole periods as it
    /// lasts. What the renderers command goes through the scene's actuators and moves no device.
    ///
    /// # Errors
    /// The motion is too long, has another number of devices, or the scene has no ideal; a device of six axes, and a motion
    /// without orientations.
    pub fn led(scene: &WorldScene, path: LedPath) -> Result<Self, WorldBenchError> {
        let periods = (path.end() / scene.timing.period * (1.0 + 1e-9)).floor();
        // What is still on its way when the motion ends is not judged.
        let late = scene.timing.actuator.delay / scene.timing.period;
        Self::solved(scene, periods - late.ceil(), Some(path))
    }

    fn solved(
        scene: &WorldScene,
        periods: f64,
        path: Option<LedPath>,
    ) -> Result<Self, WorldBenchError> {
        let judged = as_judged(scene);
        if periods.is_nan() || periods > MOST_PERIODS {
            return Err(WorldBenchError::TooLong(periods));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most a million, and at least 1"
        )]
        let periods = (periods * (1.0 - 1e-12)).ceil().max(1.0) as usize;
        let WorldActuator { delay, lag, gain } = scene.timing.actuator;
        let params = PlantParams {
            period: scene.timing.period,
            delay,
            actuator: ActuatorParams { lag, gain },
        };
        let plant = WorldPlant::new(&judged, params)?;
        let grid = plant.grid(periods).map_err(|invalid| {
            IdealError::Parameter(palpate_testbed::InvalidParameter {
                name: format!("loop.{}", invalid.name),
                value: invalid.value,
                allowed: invalid.allowed,
            })
        })?;
        let checked = match &path {
            Some(path) => CheckedIdeal::led(&judged, grid, path)?,
            None => CheckedIdeal::new(&judged, grid)?,
        };
        Ok(Self {
            judged,
            params,
            check: Some(SelfCheck {
                error: checked.error,
                chaotic_from: checked.chaotic_from,
            }),
            ideal: checked.ideal,
            path,
        })
    }

    /// A bench of a scene as its judge has it, in a loop, with an ideal that is already known.
    #[must_use]
    pub fn of(
        judged: palpate_testbed::world::WorldScene,
        params: PlantParams,
        ideal: WorldIdeal,
    ) -> Self {
        Self {
            judged,
            params,
            ideal,
            check: None,
            path: None,
        }
    }

    /// The ideal, over the part of the window for which it is one.
    #[must_use]
    pub fn ideal(&self) -> &WorldIdeal {
        &self.ideal
    }

    /// How much the sensor and the hand of each device decide about the error of its force.
    #[must_use]
    pub fn decisive(&self) -> Vec<Decisive> {
        Decisive::of(&self.judged, &self.ideal)
    }

    /// How well the ideal agrees with itself, where this bench has computed it.
    #[must_use]
    pub fn self_check(&self) -> Option<SelfCheck> {
        self.check
    }

    /// Runs the loop by a renderer of this world; `method` names it in reports.
    ///
    /// # Errors
    /// The renderer has another number of tools.
    pub fn run(&self, method: &str, renderer: &WorldRenderer) -> Result<WorldRun, WorldBenchError> {
        let mut plant = match &self.path {
            Some(path) => WorldPlant::new(&path.unmoved(&self.judged), self.params)?,
            None => WorldPlant::new(&self.judged, self.params)?,
        };
        let mut state = renderer.start();
        let grid = &self.ideal.grid;
        let mut run = WorldRun {
            method: method.to_owned(),
            commanded: Vec::new(),
            commanded_torques: Vec::new(),
            delivered: Vec::new(),
            delivered_torques: Vec::new(),
            positions: Vec::new(),
            orientations: Vec::new(),
            judgement: WorldJudgement {
                sum: None,
                devices: Vec::new(),
            },
            books: Books::default(),
            refused: 0,
            first_refusal: None,
            limited: 0,
            guarded: 0,
            found_at_start: 0.0,
            booked: 0.0,
            coarse: 0,
            crowded: 0,
            too_fast: 0,
            went_through: 0,
            first_through: None,
        };
        let end = grid.edge(grid.intervals());
        let period = self.params.period;
        let guard_limits = matches!(renderer.in_loop().guard, WorldGuard::Limit(_));
        while plant.time() < end - 0.5 * period {
            let (mut measured, mut turned) = (plant.measure(), plant.measure_orientations());
            let (mut positions, mut orientations) = (plant.positions(), plant.orientations());
            if let Some(path) = &self.path {
                measured = path.at(plant.time());
                positions.clone_from(&measured);
                if path.turns() {
                    turned = path.orientations_at(plant.time());
                    orientations.clone_from(&turned);
                }
            }
            run.positions.push(positions);
            run.orientations.push(orientations);
            let sample = Sample::at(&measured).turned(&turned);
            let is_first = run.positions.len() == 1;
            let time = plant.time();
            let output = renderer.step(&mut state, &sample);
            run.refused += usize::from(output.fault.is_some());
            run.first_refusal = run.first_refusal.or(Refusal::of(&output, time));
            let changed = Limited {
                guard: output.limited.guard && guard_limits,
                ..output.limited
            };
            run.limited += usize::from(changed.any());
            run.guarded += usize::from(output.limited.guard);
            run.coarse += usize::from(output.effort.unrefined > 0);
            run.crowded += usize::from(output.effort.left_out > 0);
            run.too_fast += usize::from(output.effort.too_fast);
            run.commanded.push(output.forces.to_vec());
            run.commanded_torques.push(output.torques.to_vec());
            plant.hold_wrenches(output.forces, output.torques);
            for pair in state.gone_through() {
                run.went_through += 1;
                run.first_through.get_or_insert_with(|| Through {
                    time,
                    names: pair.map(|side| renderer.name_of(side).to_owned()),
                });
            }
            if is_first {
                run.found_at_start = state.created_at_ports();
            }
        }
        let devices = 0..self.judged.devices.len();
        let within = |mut delivered: Vec<Vector>| {
            delivered.truncate(grid.intervals());
            delivered
        };
        for device in devices {
            run.delivered.push(within(plant.delivered(device)));
            let torques = within(plant.delivered_torque(device));
            run.delivered_torques.push(torques);
        }
        let (forces, torques) = (&run.delivered, &run.delivered_torques);
        run.judgement = WorldJudgement::of_wrenches(&self.judged, &self.ideal, forces, torques)?;
        run.booked = state.created_at_ports();
        run.books = state.books().clone();
        Ok(run)
    }
}
