//! Figure of the runs of one scene or recording: a few share a panel, many have a panel each.

use crate::figure::Sheet;
use palpate_study::sim::run::Run;

use crate::results::runs::{Devices, RunsFigure};
use crate::results::{finding, multiples, overlay};

/// Maximum number of runs in one panel; more are hard to distinguish.
pub const MAX_IN_A_PANEL: usize = 4;

impl RunsFigure<'_> {
    /// Returns position, force and energy of all runs in one panel each; with more than four runs, one panel per run.
    #[must_use]
    pub fn sheet(&self) -> Sheet {
        let (lines, note) = if self.runs.len() > MAX_IN_A_PANEL {
            multiples::lines(self)
        } else {
            overlay::lines(self)
        };
        let named = self.runs.iter().map(|run| (run.method.name(), run));
        let (names, runs): (Vec<&str>, Vec<&Run>) = named.unzip();
        let ideal = match self.devices {
            Devices::Recorded => {
                "Motion replay: the device moves as recorded, whatever the force. Ideal: the object in \
                 continuous time, on that motion."
            }
            Devices::InARecordedHand => {
                "Hand replay: the device moves under the new force and the hand's, as estimated from the \
                 recording. Ideal: object and device in continuous time, in that hand."
            }
            Devices::OfEachRun => "Ideal: object and device in continuous time.",
        };
        let recorded = match self.recorded {
            Some(_) => " Recorded, behind the methods: curves of the recorded loop.",
            None => "",
        };
        Sheet {
            title: finding::of_runs(&runs, &names).unwrap_or_default(),
            subtitle: self.of.clone(),
            footnote: Some(format!("{ideal}{recorded} {note}")),
            x_label: "time [s]".into(),
            same_scales: true,
            lines,
            ..Sheet::default()
        }
    }
}
