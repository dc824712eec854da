//! The masses of a device by the place of its tool, as a file gives them.

use palpate_core::Range;
use palpate_world::{MassTableError, Tool, Vector};
use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMassTable {
    places_m: Spanned<Vec<Vec<f64>>>,
    mass_kg: Spanned<Vec<Vec<f64>>>,
}

impl Reading {
    /// The tool, moved by a device with that table, and the masses along its axes at the start.
    pub(crate) fn with_mass_table(
        &mut self,
        tool: Tool,
        raw: RawMassTable,
        start: Vector,
    ) -> (Tool, Vector) {
        let RawMassTable { places_m, mass_kg } = raw;
        for (key, lists) in [("places_m", &places_m), ("mass_kg", &mass_kg)] {
            let all = lists.get_ref().concat();
            self.numbers(key, lists.span(), &all, Range::Finite);
        }
        let masses = tool.axes.map(|has| if has { 1.0 } else { f64::INFINITY });
        let (places, matrices) = (places_m.get_ref(), mass_kg.get_ref());
        match tool.clone().with_mass_table(places, matrices, start) {
            Ok(of_table) => {
                let table = of_table.mass_table.as_ref();
                let masses = table.map_or(masses, |table| table.masses_at_reference());
                (of_table, masses)
            }
            Err(wrong) => {
                let span = match wrong {
                    MassTableError::Axes { .. } | MassTableError::Places { .. } => places_m.span(),
                    _ => mass_kg.span(),
                };
                self.fault(span, format!("mass_table: {wrong}"));
                (tool, masses)
            }
        }
    }
}
