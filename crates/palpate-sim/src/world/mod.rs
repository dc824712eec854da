//! Worlds in closed loop: a scene of several devices, bodies and contacts, rendered by a method and judged by
//! its ideal.

mod judged;

use palpate_scene::world::WorldScene;
use palpate_testbed::world::{
    CheckedIdeal, JudgementError, PlantParams, WorldError as IdealError, WorldJudgement, WorldPlant,
};
use palpate_world::{Books, Sample, Vector, WorldError};

pub use judged::as_judged;

/// Most periods of a window.
const MOST_PERIODS: f64 = 1e6;

/// A scene with its ideal, for any number of runs.
#[derive(Clone, Debug)]
pub struct WorldBench<'a> {
    scene: &'a WorldScene,
    judged: palpate_testbed::world::WorldScene,
    ideal: CheckedIdeal,
}

/// What a method made of a scene.
#[derive(Clone, Debug)]
pub struct WorldRun {
    /// Name of the method.
    pub method: String,
    /// Force on each tool over each interval of the ideal's grid, as its actuator gave it: `[device][interval]` `[N]`.
    pub delivered: Vec<Vec<Vector>>,
    /// Position of each device at each sample: `[sample][device]` `[m]`.
    pub positions: Vec<Vec<Vector>>,
    /// How the delivered forces compare with the ideal's.
    pub judgement: WorldJudgement,
    /// The renderer's books of energy at the end.
    pub books: Books,
    /// Samples that the renderer refused.
    pub refused: usize,
    /// Samples at which a limit changed a force.
    pub limited: usize,
    /// Intervals in which a contact changed its mode more often than the tick could follow at its finest.
    pub coarse: usize,
}

/// Why a world cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldBenchError {
    /// The world, its loop or its method cannot be rendered: at least one fault.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Rendering(Vec<WorldError>),
    /// There is no ideal to judge by.
    #[error("the ideal: {0}")]
    Ideal(#[from] IdealError),
    /// The window has more periods than are run.
    #[error("duration_s is {0} periods, and at most 1e6 are run")]
    TooLong(f64),
    /// The run and its ideal do not fit.
    #[error(transparent)]
    Judgement(#[from] JudgementError),
}

impl<'a> WorldBench<'a> {
    /// Solves the scene's ideal over its window.
    ///
    /// # Errors
    /// The window is too long, or the scene has no ideal.
    pub fn new(scene: &'a WorldScene) -> Result<Self, WorldBenchError> {
        let judged = as_judged(scene);
        let periods = scene.duration / scene.timing.period;
        if !(periods <= MOST_PERIODS) {
            return Err(WorldBenchError::TooLong(periods));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most a million, and at least 1"
        )]
        let periods = (periods * (1.0 - 1e-12)).ceil().max(1.0) as usize;
        let plant = WorldPlant::new(&judged, params(scene))?;
        let grid = plant.grid(periods).map_err(|invalid| {
            IdealError::Parameter(palpate_testbed::InvalidParameter {
                name: format!("loop.{}", invalid.name),
                value: invalid.value,
                allowed: invalid.allowed,
            })
        })?;
        let ideal = CheckedIdeal::new(&judged, grid)?;
        Ok(Self {
            scene,
            judged,
            ideal,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &'a WorldScene {
        self.scene
    }

    /// The ideal and how well it agrees with itself.
    pub fn ideal(&self) -> &CheckedIdeal {
        &self.ideal
    }

    /// Runs the loop by the method of that name.
    ///
    /// # Errors
    /// The method cannot render this world.
    pub fn run(&self, method: &str) -> Result<WorldRun, WorldBenchError> {
        let renderer = self.scene.renderer(method);
        let renderer = renderer.map_err(WorldBenchError::Rendering)?;
        let mut plant = WorldPlant::new(&self.judged, params(self.scene))?;
        let mut state = renderer.start();
        let grid = &self.ideal.ideal.grid;
        let mut run = WorldRun {
            method: method.to_owned(),
            delivered: Vec::new(),
            positions: Vec::new(),
            judgement: WorldJudgement {
                sum: None,
                devices: Vec::new(),
            },
            books: Books::default(),
            refused: 0,
            limited: 0,
            coarse: 0,
        };
        let end = grid.edge(grid.intervals());
        let period = self.scene.timing.period;
        while plant.time() < end - 0.5 * period {
            run.positions.push(plant.positions());
            let measured = plant.measure();
            let output = renderer.step(&mut state, &Sample::at(&measured));
            run.refused += usize::from(output.fault.is_some());
            run.limited += usize::from(output.limited.any());
            run.coarse += usize::from(output.effort.unrefined > 0);
            plant.hold(output.forces);
        }
        let devices = 0..self.judged.devices.len();
        run.delivered = devices
            .map(|device| {
                let mut delivered = plant.delivered(device);
                delivered.truncate(grid.intervals());
                delivered
            })
            .collect();
        run.judgement = WorldJudgement::of(&self.judged, &self.ideal.ideal, &run.delivered)?;
        run.books = state.books().clone();
        Ok(run)
    }
}

fn params(scene: &WorldScene) -> PlantParams {
    PlantParams {
        delay: scene.timing.delay,
        ..PlantParams::perfect(scene.timing.period)
    }
}
