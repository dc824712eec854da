//! `Worlds`: many worlds in a loop that Python owns, one sample of each at a time.

use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArray3, PyReadonlyArray1, PyReadonlyArray3, PyReadwriteArray3};
use palpate_world::BodyState;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{check_aligned, in_a_row};
use crate::bounded::{Now, Placed, Poses};
use crate::names::refused;
use crate::world::{PyWorld, PyWorldState};

/// Least number of worlds for a thread: waking a thread costs as much as some ticks.
const PER_THREAD: usize = 8;

/// Worlds with the same devices and bodies, each in its state.
#[pyclass(subclass, module = "palpate._palpate")]
pub struct Worlds {
    worlds: Vec<Now>,
    devices: usize,
    /// Length of a row of a sample, and of a row of a result.
    widths: [usize; 2],
}

/// States of worlds at a sample.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct WorldsState(Vec<Now>);

/// Number of a world, the world, its sample and the place of its result.
type Row<'a> = (usize, (&'a mut Now, (&'a [f64], &'a mut [f64])));

#[pymethods]
impl Worlds {
    /// Creates worlds in the states of `each`, or `count` in that of the only one.
    #[new]
    fn new(each: Vec<PyRef<'_, PyWorld>>, count: usize) -> PyResult<Self> {
        let (devices, widths) = match each.first() {
            Some(world) => {
                let width = if world.gives_torque() { 6 } else { 3 };
                (world.scene().world.tools.len(), [world.width(), width])
            }
            None => return Err(refused("there is no world, but at least one is needed")),
        };
        let mut worlds: Vec<Now> = each.iter().map(|world| world.now().clone()).collect();
        if let [one] = &worlds[..] {
            worlds = vec![one.clone(); count];
        }
        Ok(Self {
            worlds,
            devices,
            widths,
        })
    }

    /// Executes one tick of each world: takes a row for each device and writes its force or wrench to `out`.
    fn tick(
        &mut self,
        py: Python<'_>,
        poses: PyReadonlyArray3<'_, f64>,
        elapsed: Option<PyReadonlyArray1<'_, f64>>,
        mut out: PyReadwriteArray3<'_, f64>,
    ) -> PyResult<()> {
        let poses = in_a_row("positions", &poses)?;
        let elapsed = elapsed.as_ref().map(|of| in_a_row("elapsed", of));
        let elapsed = elapsed.transpose()?;
        check_aligned("out", &out, true)?;
        let out = out.as_slice_mut()?;
        let (count, [width, out_width]) = (self.worlds.len(), self.widths);
        let sizes = [self.devices * width, self.devices * out_width];
        let is_one_each = [poses.len(), out.len()] == sizes.map(|size| count * size);
        if !is_one_each || elapsed.is_some_and(|elapsed| elapsed.len() != count) {
            return Err(refused("an array does not have one entry for each world"));
        }
        let worlds = &mut self.worlds;
        let rows = poses.par_chunks(sizes[0]).zip(out.par_chunks_mut(sizes[1]));
        let each = worlds.par_iter_mut().zip(rows).enumerate();
        let tick = |buffer: &mut Poses, (world, (now, (poses, out))): Row<'_>| {
            buffer.take(poses.chunks_exact(width).map(ArrayView1::from), width);
            let answer = now.step(buffer, elapsed.map(|elapsed| elapsed[world]));
            for (wrench, out) in answer.wrenches.iter().zip(out.chunks_exact_mut(out_width)) {
                let numbers = wrench.force.iter().chain(&wrench.torque);
                out.iter_mut()
                    .zip(numbers)
                    .for_each(|(out, number)| *out = *number);
            }
        };
        py.detach(|| {
            each.with_min_len(PER_THREAD)
                .for_each_init(Poses::default, tick)
        });
        Ok(())
    }

    /// Resets all worlds, or those at which `mask` is true.
    fn restart(&mut self, mask: Option<PyReadonlyArray1<'_, bool>>) -> PyResult<()> {
        for world in self.chosen(mask.as_ref())? {
            self.worlds[world].reset();
        }
        Ok(())
    }

    /// Moves a body, by its number, in all worlds or in those at which `mask` is true. Each argument has one row of
    /// numbers for all worlds or one for each.
    #[pyo3(signature = (body, position, orientation, velocity, angular_velocity, mask))]
    fn place(
        &mut self,
        body: usize,
        position: Option<Vec<[f64; 3]>>,
        orientation: Option<Vec<[f64; 4]>>,
        velocity: Option<Vec<[f64; 3]>>,
        angular_velocity: Option<Vec<[f64; 3]>>,
        mask: Option<PyReadonlyArray1<'_, bool>>,
    ) -> PyResult<()> {
        let chosen = self.chosen(mask.as_ref())?;
        let to = |world: usize| {
            let given = Placed {
                position: of_row(position.as_deref(), world),
                orientation: of_row(orientation.as_deref(), world),
                velocity: of_row(velocity.as_deref(), world),
                angular_velocity: of_row(angular_velocity.as_deref(), world),
            };
            let moved = self.worlds[world].moved(body, &given);
            moved.map_err(|error| refused(format!("world {world}: {error}")))
        };
        // No body moves if one cannot.
        let states: Vec<BodyState> = chosen
            .iter()
            .map(|&world| to(world))
            .collect::<PyResult<_>>()?;
        for (world, to) in chosen.into_iter().zip(&states) {
            self.worlds[world]
                .bounded
                .place(body, to)
                .map_err(refused)?;
        }
        Ok(())
    }

    /// Returns position, orientation, velocity and angular velocity of each body in each world: 13 numbers.
    fn bodies_now<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let of_body = |body: &BodyState| {
            let BodyState {
                position,
                orientation,
                velocity,
                angular_velocity,
            } = *body;
            let parts = [&position[..], &orientation, &velocity, &angular_velocity];
            parts.concat()
        };
        let of_world = |world: &Now| world.bounded.state().bodies().iter().map(of_body).collect();
        let each: Vec<Vec<Vec<f64>>> = self.worlds.iter().map(of_world).collect();
        Ok(PyArray3::from_vec3(py, &each)?)
    }

    /// Returns the energy generated by the held forces in each world `[J]`.
    fn created<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let each = self
            .worlds
            .iter()
            .map(|world| world.bounded.created_energy());
        PyArray1::from_vec(py, each.collect())
    }

    /// Returns the reason for which each world has rejected the last sample, "" if there is none.
    fn faults_now(&self) -> Vec<&'static str> {
        let fault = |world: &Now| world.last.as_ref()?.fault.map(|fault| fault.fault.name());
        self.worlds
            .iter()
            .map(|world| fault(world).unwrap_or_default())
            .collect()
    }

    /// Returns the names of the active limits of each world.
    fn limits_now(&self) -> Vec<Vec<&'static str>> {
        let limits = |world: &Now| world.last.as_ref().map(|last| last.limits());
        self.worlds
            .iter()
            .map(|world| limits(world).unwrap_or_default())
            .collect()
    }

    /// Returns the state of one world.
    fn state_of(&self, world: usize) -> PyWorldState {
        PyWorldState(self.worlds[world].clone())
    }

    /// Returns the states at the last sample.
    fn held_state(&self) -> WorldsState {
        WorldsState(self.worlds.clone())
    }

    /// Continues from states of the same worlds.
    fn hold_state(&mut self, state: &WorldsState) {
        self.worlds.clone_from(&state.0);
    }
}

impl Worlds {
    /// Returns the numbers of all worlds, or of those at which `mask` is true.
    fn chosen(&self, mask: Option<&PyReadonlyArray1<'_, bool>>) -> PyResult<Vec<usize>> {
        let mask = mask.map(|mask| mask.as_slice()).transpose()?;
        if mask.is_some_and(|mask| mask.len() != self.worlds.len()) {
            return Err(refused("the mask does not have one value for each world"));
        }
        let all = 0..self.worlds.len();
        Ok(all
            .filter(|&world| mask.is_none_or(|mask| mask[world]))
            .collect())
    }
}

/// Returns the row of a world, of one for all or one for each.
fn of_row<T: Copy>(rows: Option<&[T]>, world: usize) -> Option<T> {
    match rows? {
        [all] => Some(*all),
        each => each.get(world).copied(),
    }
}
