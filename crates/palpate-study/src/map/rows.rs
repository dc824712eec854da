//! Conversion of results to the lines of a map.

use palpate_record::map::{Row, StaySwing};

use super::cell::{CellResult, MethodResult, Summary};
use super::grid::MapParams;

impl CellResult {
    /// Returns the lines of this cell in the map of `params`, per plant and method.
    #[must_use]
    pub fn rows(&self, params: &MapParams) -> Vec<Row> {
        let cell = params.cell(self.index);
        let both = |summary: Summary| [summary.median, summary.worst];
        self.methods
            .iter()
            .map(|MethodResult { bounce, stay }| Row {
                cell: cell.index as u64,
                kappa: cell.kappa,
                object_kappa: cell.object_kappa,
                stiffness: cell.bounce.stiffness,
                object_mass: cell.bounce.object_mass,
                plant: bounce.plant.name().to_owned(),
                method: bounce.method.name().to_owned(),
                growth: both(bounce.growth),
                error: both(bounce.error),
                error_over_bound: both(bounce.error_over_bound),
                hold_bound: both(bounce.hold_bound),
                classes: bounce.classes.map(|count| count as u64),
                stay: Some(StaySwing {
                    resting: stay.resting,
                    pressed: stay.pressed,
                }),
            })
            .collect()
    }
}
