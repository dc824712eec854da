//! Scenes of both renderers as the subjects of one study: one contact along one axis, and worlds.

use palpate_scene::Scene;
use palpate_scene::world::WorldScene;
use palpate_testbed::metrics::Fidelity;
use palpate_testbed::world::Member;
use palpate_world::Motion;

use crate::sim::closed_loop::{Bench, LoopError};
use crate::sim::run::Run;
use crate::sim::world::{WorldBench, WorldBenchError, WorldRun};
use crate::suite::{Chance, Column};
use crate::sweep::{Quantity, Stability, SweepError, largest_rebound_energy, with_damping};
use crate::tune::{HEIGHTS, at_height, height_share, tunable};

/// Stream of the random start of a seed, beside the streams of plants.
const STARTS: u64 = u64::MAX;

/// Energy that held forces generate or lose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leak {
    /// Sum of the absolute leaks, of one contact `[J]`.
    Absolute(f64),
    /// Generated energy, of a world `[J]`.
    Created(f64),
}

/// Result of a column on a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Errors over all devices and axes; `None` without contact of the ideal.
    pub fidelity: Option<Fidelity>,
    /// Strongest held force on a device `[N]`.
    pub peak_force: f64,
    /// Strongest force of the ideal on a device `[N]`.
    pub ideal_peak_force: f64,
    /// Leak of the held forces.
    pub leak: Leak,
    /// Number of samples that the renderer rejected.
    pub refused: usize,
    /// Whether the loop diverged.
    pub diverged: bool,
    /// Bounce of one contact.
    pub bounce: Option<Bounce>,
}

/// Bounce of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Largest rebound energy relative to the ideal's first rebound; `None` without a rebound.
    pub rebound_energy: Option<f64>,
    /// Its class.
    pub stability: Stability,
    /// Time at which the device left its safety box `[s]`.
    pub left_box_at: Option<f64>,
}

/// Reason why a column cannot be evaluated on a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The ideal has no contact, so there is no error.
    #[error("the ideal has no contact in the window, so there is no error")]
    NoContact,
    /// No device moves to a first contact, so there is no start height.
    #[error(
        "no device moves to its first contact in the ideal, so there is no start height to vary; start one apart from \
         the body that it touches"
    )]
    NoHeight,
    /// One contact cannot be run.
    #[error(transparent)]
    Contact(#[from] LoopError),
    /// A world cannot be run.
    #[error(transparent)]
    World(#[from] WorldBenchError),
    /// A column cannot be run.
    #[error("column {column}: {error}")]
    Column {
        /// Name of the column.
        column: String,
        /// Cause of the error.
        error: Box<Self>,
    },
}

impl StudyError {
    fn of_column(column: &impl Compared, error: impl Into<Self>) -> Self {
        Self::Column {
            column: column.name().into(),
            error: Box::new(error.into()),
        }
    }
}

/// A column of a study: a method with settings.
pub trait Compared: Clone + Sync {
    /// Returns the name in tables.
    fn name(&self) -> &str;
    /// Returns the name of the method.
    fn method(&self) -> &'static str;
}

impl Compared for Column {
    fn name(&self) -> &str {
        &self.name
    }

    fn method(&self) -> &'static str {
        self.method.name()
    }
}

/// A method of worlds, with the settings of the scene.
impl Compared for &'static str {
    fn name(&self) -> &str {
        self
    }

    fn method(&self) -> &'static str {
        self
    }
}

/// A scene on which studies evaluate columns.
pub trait Studied: Clone + Send + Sync {
    /// Type of its columns.
    type Column: Compared;

    /// Returns its title.
    fn title(&self) -> &str;
    /// Returns the seed of its random numbers; `None` if nothing is random.
    fn random_seed(&self) -> Option<u64>;
    /// Returns the seed, also of a scene in which nothing is random.
    fn seed(&self) -> u64;

    /// Returns the scene with a seed. `range` `[m]` changes the start of each device along each of its axes by up to
    /// that much, uniformly; the random values of the loop are those of the seed in any case.
    #[must_use]
    fn with_seed(&self, seed: u64, range: Option<f64>) -> Self;

    /// Returns the scene with a model value of each device's mass that is `factor` times the true one.
    #[must_use]
    fn with_model_mass_factor(&self, factor: f64) -> Self;

    /// Returns the scene from each of [`HEIGHTS`] start heights within ±[`HEIGHT_RANGE`](crate::tune::HEIGHT_RANGE); the middle one is the scene
    /// itself.
    ///
    /// # Errors
    /// A world cannot be run, or no device of it moves to its first contact.
    fn start_heights(&self) -> Result<Vec<Self>, StudyError>;

    /// Returns the scene and the columns at a value of a quantity.
    ///
    /// # Errors
    /// The scene or a column lacks the quantity, or the value is not allowed.
    fn at(
        &self,
        columns: &[Self::Column],
        quantity: Quantity,
        value: f64,
    ) -> Result<(Self, Vec<Self::Column>), SweepError>;

    /// Returns the dampings between which each column chooses `[N s/m]`; a single `None` where there is no choice.
    fn choices(&self, columns: &[Self::Column]) -> Vec<Vec<Option<f64>>>;

    /// Evaluates each of the [choices](Self::choices) of every column.
    ///
    /// # Errors
    /// The scene or a column cannot be run.
    fn evaluate(&self, columns: &[Self::Column]) -> Result<Vec<Vec<Outcome>>, StudyError>;
}

impl Studied for Scene {
    type Column = Column;

    fn title(&self) -> &str {
        &self.title
    }

    fn random_seed(&self) -> Option<u64> {
        self.random_seed()
    }

    fn seed(&self) -> u64 {
        self.timing.seed
    }

    fn with_seed(&self, seed: u64, range: Option<f64>) -> Self {
        let mut scene = self.clone();
        scene.timing.seed = seed;
        if let Some(range) = range {
            scene.object.position += Chance::new(seed, STARTS).between(-range, range);
        }
        scene
    }

    fn with_model_mass_factor(&self, factor: f64) -> Self {
        let mut scene = self.clone();
        if factor != 1.0 {
            scene.model_device_mass = Some(factor * self.device.mass());
        }
        scene
    }

    fn start_heights(&self) -> Result<Vec<Self>, StudyError> {
        Ok((0..HEIGHTS).map(|height| at_height(self, height)).collect())
    }

    fn at(
        &self,
        columns: &[Column],
        quantity: Quantity,
        value: f64,
    ) -> Result<(Self, Vec<Column>), SweepError> {
        if quantity == Quantity::Damping {
            let lacking = columns.iter().find(|it| tunable(it.method).is_none());
            if let Some(column) = lacking {
                return Err(SweepError::NoDamping(column.name.clone()));
            }
        }
        let varied = crate::sweep::with(self, quantity, value)?;
        let columns = columns.iter().map(|column| match quantity {
            Quantity::Damping => with_damping(column, value),
            _ => column.clone(),
        });
        Ok((varied, columns.collect()))
    }

    fn choices(&self, columns: &[Column]) -> Vec<Vec<Option<f64>>> {
        let of = |column: &Column| column.candidates(self).into_iter();
        let each = columns.iter();
        each.map(|column| of(column).map(|(damping, _)| damping).collect())
            .collect()
    }

    fn evaluate(&self, columns: &[Column]) -> Result<Vec<Vec<Outcome>>, StudyError> {
        let bench = Bench::new(self)?;
        let curve = bench.reference().curve.iter();
        let ideal_peak_force = curve
            .map(|point| point.force_on_object.abs())
            .fold(0.0, f64::max);
        let one = |column: &Column, varied: &Self| {
            let run = bench.run_varied(varied, column.method);
            let run = run.map_err(|error| StudyError::of_column(column, error))?;
            Ok(Outcome::of_contact(&run, ideal_peak_force))
        };
        let all = |column: &Column| {
            let candidates = column.candidates(self);
            let runs = candidates.iter().map(|(_, varied)| one(column, varied));
            runs.collect()
        };
        columns.iter().map(all).collect()
    }
}

impl Studied for WorldScene {
    type Column = &'static str;

    fn title(&self) -> &str {
        &self.title
    }

    fn random_seed(&self) -> Option<u64> {
        self.random_seed()
    }

    fn seed(&self) -> u64 {
        self.timing.imperfections.seed
    }

    fn with_seed(&self, seed: u64, range: Option<f64>) -> Self {
        let mut world = self.clone();
        world.timing.imperfections.seed = seed;
        let Some(range) = range else {
            return world;
        };
        let mut chance = Chance::new(seed, STARTS);
        for device in &mut world.devices {
            let own =
                device
                    .own_axes
                    .unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            for (axis, mass) in own.into_iter().zip(device.mass) {
                let shift = chance.between(-range, range);
                // The mass is infinite along an axis that the device lacks.
                if mass.is_finite() {
                    for (place, part) in device.position.iter_mut().zip(axis) {
                        *place += shift * part;
                    }
                }
            }
        }
        world
    }

    fn with_model_mass_factor(&self, factor: f64) -> Self {
        let mut world = self.clone();
        if factor != 1.0 {
            let masses = self.devices.iter().map(|device| device.mass);
            world.render.device_mass = masses.map(|it| it.map(|mass| factor * mass)).collect();
        }
        world
    }

    fn start_heights(&self) -> Result<Vec<Self>, StudyError> {
        let bench = WorldBench::new(self)?;
        let ideal = bench.ideal();
        let ways: Vec<_> = (0..self.devices.len())
            .map(|number| {
                let touches = |member: &Member| *member == Member::Device(number);
                let mut encounters = ideal.encounters.iter();
                let first = encounters.find(|it| it.between.iter().any(touches));
                let start = first.map_or(0.0, |encounter| encounter.start);
                let grid = &ideal.grid;
                let before = (0..=grid.intervals()).take_while(|at| grid.edge(*at) <= start);
                let last = &ideal.states[before.last().unwrap_or(0)];
                let [from, to] = [&ideal.states[0], last].map(|at| at.devices[number].position);
                [0, 1, 2].map(|axis| to[axis] - from[axis])
            })
            .collect();
        if ways.iter().flatten().all(|part| *part == 0.0) {
            return Err(StudyError::NoHeight);
        }
        let at = |height| {
            let mut world = self.clone();
            for (device, way) in world.devices.iter_mut().zip(&ways) {
                for (place, part) in device.position.iter_mut().zip(way) {
                    *place -= height_share(height) * part;
                }
            }
            world
        };
        Ok((0..HEIGHTS).map(at).collect())
    }

    fn at(
        &self,
        methods: &[&'static str],
        quantity: Quantity,
        value: f64,
    ) -> Result<(Self, Vec<&'static str>), SweepError> {
        quantity.check(value)?;
        let mut world = self.clone();
        match quantity {
            Quantity::Stiffness => {
                for contact in &mut world.world.contacts {
                    let law = &mut contact.law;
                    law.stiffness *= value;
                    law.friction_stiffness *= value;
                }
            }
            Quantity::Mass => {
                let bodies = world.world.bodies.iter_mut();
                let mut free = bodies.filter_map(|body| match &mut body.motion {
                    Motion::Free(free) => Some(free),
                    Motion::Fixed => None,
                });
                let mut moves = false;
                for free in &mut free {
                    moves = true;
                    free.mass *= value;
                    free.inertia = free.inertia.map(|it| it.map(|moment| moment * value));
                }
                if !moves {
                    return Err(SweepError::NO_MASS);
                }
            }
            Quantity::Friction => {
                let drivetrains = world
                    .devices
                    .iter_mut()
                    .map(|device| &mut device.drivetrain);
                let frictions =
                    drivetrains.flat_map(|it| [&mut it.viscous_friction, &mut it.coulomb_friction]);
                let mut has_friction = false;
                for friction in frictions {
                    has_friction |= *friction != 0.0;
                    *friction *= value;
                }
                if !has_friction {
                    return Err(SweepError::NO_FRICTION);
                }
            }
            Quantity::SafetyBox => return Err(SweepError::NO_BOX),
            Quantity::Damping => {
                for method in methods {
                    let settings = world.render.settings.entry(method).or_default();
                    *match *method {
                        "popc" | "popc-ref" => &mut settings.damping_cap,
                        "virtual-damper" | "hfcr" | "virtual-coupling" | "god-object" => {
                            &mut settings.damping
                        }
                        _ => return Err(SweepError::NoDamping((*method).into())),
                    } = Some(value);
                }
            }
        }
        Ok((world, methods.to_vec()))
    }

    fn choices(&self, methods: &[&'static str]) -> Vec<Vec<Option<f64>>> {
        vec![vec![None]; methods.len()]
    }

    fn evaluate(&self, methods: &[&'static str]) -> Result<Vec<Vec<Outcome>>, StudyError> {
        let bench = WorldBench::new(self)?;
        let ideal = bench.ideal().devices.iter();
        let peaks = ideal.flat_map(|device| device.peaks.iter().copied());
        let ideal_peak_force = peaks.fold(0.0, f64::max);
        let one = |method: &&'static str| {
            let renderer = self.renderer(method).map_err(WorldBenchError::from);
            let run = renderer.and_then(|renderer| bench.run(method, &renderer));
            let run = run.map_err(|error| StudyError::of_column(method, error))?;
            Ok(vec![Outcome::of_world(&run, ideal_peak_force)])
        };
        methods.iter().map(one).collect()
    }
}

impl Outcome {
    fn of_contact(run: &Run, ideal_peak_force: f64) -> Self {
        let diverged = run.diverged == Some(true);
        let rebound_energy = largest_rebound_energy(run);
        Self {
            fidelity: run.force.fidelity,
            peak_force: run.force.peak_force,
            ideal_peak_force,
            leak: Leak::Absolute(run.last().ledger.held_leak.absolute),
            refused: run.faults(),
            diverged,
            bounce: Some(Bounce {
                rebound_energy,
                stability: Stability::new(diverged, rebound_energy),
                left_box_at: run.left_box_at,
            }),
        }
    }

    fn of_world(run: &WorldRun, ideal_peak_force: f64) -> Self {
        let fidelity = run.evaluation.sum;
        let peaks = run.evaluation.devices.iter().map(|it| it.peak_force);
        Self {
            fidelity,
            peak_force: peaks.fold(0.0, f64::max),
            ideal_peak_force,
            leak: Leak::Created(run.created()),
            refused: run.refused,
            diverged: fidelity.is_some_and(|it| !it.mean_force_error.is_finite()),
            bounce: None,
        }
    }

    /// Returns the errors.
    ///
    /// # Errors
    /// There is no contact.
    pub fn fidelity(&self) -> Result<Fidelity, StudyError> {
        self.fidelity.ok_or(StudyError::NoContact)
    }
}
