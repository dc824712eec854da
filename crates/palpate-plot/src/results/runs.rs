//! Figure of runs, with recorded curves beside them.

use crate::figure::{Kind, Role, Series};
use palpate_study::report::Replayed;
use palpate_study::sim::run::{Reference, Run};

use crate::results::series::{
    JOULE_TO_MILLIJOULE, METRE_TO_MILLIMETRE, ideal_device, ideal_object,
};
use palpate_study::recording::RecordedCurves;

/// Source of the device motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Devices {
    /// Recorded motion: the same for all runs, and for the ideal.
    Recorded,
    /// Simulated motion of each run, under its own force and the force of a recorded hand.
    InARecordedHand,
    /// Simulated motion of each run, under its own force.
    OfEachRun,
}

/// Runs of one scene or recording, to be drawn.
#[derive(Debug)]
pub struct RunsFigure<'a> {
    /// Title of the scene or recording.
    pub of: String,
    /// Ideal of the runs.
    pub reference: &'a Reference,
    /// One run per method.
    pub runs: &'a [Run],
    /// Source of the device motion.
    pub devices: Devices,
    /// Recorded curves.
    pub recorded: Option<&'a RecordedCurves>,
}

impl<'a> RunsFigure<'a> {
    /// Creates the figure of a replay, with the `recorded` curves.
    #[must_use]
    pub fn of_replay(
        replayed: &Replayed,
        title: &str,
        (reference, runs): (&'a Reference, &'a [Run]),
        recorded: Option<&'a RecordedCurves>,
    ) -> Self {
        let (of, devices) = match replayed.known_to() {
            None => (title.to_owned(), Devices::Recorded),
            Some(known) => (
                format!("{title}, hand force known to {known}"),
                Devices::InARecordedHand,
            ),
        };
        Self {
            of,
            reference,
            runs,
            devices,
            recorded,
        }
    }
}

impl RunsFigure<'_> {
    /// Returns the offset of the object's centre from its position `[m]`.
    fn centre(&self) -> f64 {
        self.runs.first().map_or(0.0, |run| run.centre_offset)
    }

    /// Returns the ideal's positions, and the device if it is the same for all runs.
    pub(super) fn ideal_positions(&self) -> Vec<Series> {
        let object = ideal_object(self.reference, self.centre());
        let mut device = ideal_device(self.reference);
        if self.devices == Devices::Recorded {
            device.name = "device, as recorded".into();
            device.role = Role::Device;
        }
        vec![object, device]
    }

    /// Returns the recorded object position.
    pub(super) fn recorded_object(&self) -> Option<Series> {
        let positions = |recorded: &RecordedCurves| {
            let places = &recorded.object_position;
            curve(
                recorded,
                "recorded",
                places,
                METRE_TO_MILLIMETRE,
                Kind::Line,
            )
        };
        self.recorded.map(positions)
    }

    /// Returns the recorded device position if the runs have other device motions.
    pub(super) fn recorded_device(&self) -> Option<Series> {
        let positions = |recorded: &RecordedCurves| {
            let places = &recorded.device_position;
            curve(recorded, "", places, METRE_TO_MILLIMETRE, Kind::Line)
        };
        let has_own = self.devices != Devices::Recorded;
        self.recorded.filter(|_| has_own).map(positions)
    }

    /// Returns the recorded force.
    pub(super) fn recorded_force(&self) -> Option<Series> {
        let forces = |recorded: &RecordedCurves| {
            curve(
                recorded,
                "recorded",
                &recorded.force_on_object,
                1.0,
                Kind::Step,
            )
        };
        self.recorded.map(forces)
    }

    /// Returns the generated energy of the recorded force.
    pub(super) fn recorded_leak(&self) -> Option<Series> {
        let leaks = |recorded: &RecordedCurves| {
            let leaks = &recorded.held_leak;
            curve(recorded, "recorded", leaks, JOULE_TO_MILLIJOULE, Kind::Line)
        };
        self.recorded.map(leaks)
    }
}

fn curve(recorded: &RecordedCurves, name: &str, values: &[f64], scale: f64, kind: Kind) -> Series {
    Series {
        name: name.into(),
        kind,
        role: Role::Recorded,
        x: recorded.time.clone(),
        y: values.iter().map(|value| scale * value).collect(),
    }
}
