//! `Renderers`: many contacts in a loop that Python owns, one sample of each at a time.

use numpy::{PyArray1, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

use crate::arrays::{check_aligned, in_a_row};
use crate::columns::{Words, array, output_codes};
use crate::contact::{Contact, Now};
use crate::names::refused;
use crate::renderer::rendering;

/// Least number of contacts for a thread: waking a thread costs as much as some hundred ticks.
const PER_THREAD: usize = 1024;

/// Contacts with their states.
#[pyclass(subclass, module = "palpate._palpate")]
pub struct Renderers {
    contacts: Vec<Contact>,
}

/// States of contacts at a sample.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct RenderersState(Vec<Now>);

/// Arguments of a contact: parameters, soft-start time and settings of the method.
type Given<'py> = (Bound<'py, PyDict>, f64, Bound<'py, PyDict>);

#[pymethods]
impl Renderers {
    /// Creates `count` contacts, from one row of arguments each or one for all.
    #[new]
    fn new(method: &Bound<'_, PyAny>, count: usize, rows: Vec<Given<'_>>) -> PyResult<Self> {
        let each = rows
            .iter()
            .enumerate()
            .map(|(place, (parameters, soft_start, settings))| {
                let made = rendering(method, parameters, settings)
                    .and_then(|(setup, rendering)| Contact::new(&setup, &rendering, *soft_start));
                match made {
                    Err(error) if rows.len() > 1 => Err(refused(format!(
                        "row {place}: {}",
                        error.value(method.py())
                    ))),
                    made => made,
                }
            });
        let mut contacts: Vec<Contact> = each.collect::<PyResult<_>>()?;
        if let [one] = &contacts[..] {
            contacts = vec![one.clone(); count];
        }
        Ok(Self { contacts })
    }

    /// Executes one tick of each contact and writes the forces to `out`.
    #[pyo3(signature = (positions, elapsed, forces, out))]
    fn tick(
        &mut self,
        py: Python<'_>,
        positions: PyReadonlyArray1<'_, f64>,
        elapsed: Option<PyReadonlyArray1<'_, f64>>,
        forces: Option<PyReadonlyArray1<'_, f64>>,
        mut out: PyReadwriteArray1<'_, f64>,
    ) -> PyResult<()> {
        let positions = in_a_row("positions", &positions)?;
        let elapsed = elapsed.as_ref().map(|of| in_a_row("elapsed", of));
        let forces = forces.as_ref().map(|of| in_a_row("force", of));
        let (elapsed, forces) = (elapsed.transpose()?, forces.transpose()?);
        check_aligned("out", &out, true)?;
        let out = out.as_slice_mut()?;
        let contacts = &mut self.contacts;
        let lengths = [Some(positions), elapsed, forces, Some(&*out)];
        if lengths
            .into_iter()
            .flatten()
            .any(|of| of.len() != contacts.len())
        {
            return Err(refused(
                "an array does not have one number for each contact",
            ));
        }
        let each = contacts.par_iter_mut().zip(out).enumerate();
        let tick = |(row, (contact, out)): (usize, (&mut Contact, &mut f64))| {
            let [elapsed, force] = [elapsed, forces].map(|of| of.map(|of| of[row]));
            *out = contact.step(positions[row], elapsed, force);
        };
        py.detach(|| each.with_min_len(PER_THREAD).for_each(tick));
        Ok(())
    }

    /// Resets all contacts, or those at which `mask` is true.
    fn restart(&mut self, mask: Option<PyReadonlyArray1<'_, bool>>) -> PyResult<()> {
        let mask = mask.as_ref().map(|mask| mask.as_slice()).transpose()?;
        if mask.is_some_and(|mask| mask.len() != self.contacts.len()) {
            return Err(refused("the mask does not have one value for each contact"));
        }
        for (place, contact) in self.contacts.iter_mut().enumerate() {
            if mask.is_none_or(|mask| mask[place]) {
                contact.reset();
            }
        }
        Ok(())
    }

    /// Returns the results of the last sample: seven numbers and a word of codes for each contact. Without a sample
    /// the numbers are NaN.
    fn results<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        let mut words = Words::with_capacity(8 * self.contacts.len());
        for contact in &self.contacts {
            let Some(answer) = &contact.now.last else {
                words.extend([f64::NAN.to_bits(); 7]);
                words.push(0);
                continue;
            };
            let output = &answer.output;
            let numbers = [
                answer.force_on_device,
                answer.slope_on_device,
                output.object_position,
                output.object_velocity,
                output.penetration,
                output.transition_after,
                output.proxy_shift,
            ];
            words.extend(numbers.map(f64::to_bits));
            let [phase, limited, fault] = output_codes(output);
            let [softened, stopped] = [answer.softened, answer.stopped].map(u8::from);
            let codes = [phase, limited, fault, softened, stopped, 0, 0, 0];
            words.push(u64::from_ne_bytes(codes));
        }
        array(py, words)
    }

    /// Returns the energy generated by the held forces of each contact `[J]`.
    fn created<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let each = self
            .contacts
            .iter()
            .map(|contact| contact.ledger().1[1].accumulated);
        PyArray1::from_vec(py, each.collect())
    }

    /// Returns the states at the last sample.
    fn held_state(&self) -> RenderersState {
        RenderersState(
            self.contacts
                .iter()
                .map(|contact| contact.now.clone())
                .collect(),
        )
    }

    /// Continues from states of renderers with the same parameters.
    fn hold_state(&mut self, state: &RenderersState) {
        for (contact, now) in self.contacts.iter_mut().zip(&state.0) {
            contact.now = now.clone();
        }
    }
}
