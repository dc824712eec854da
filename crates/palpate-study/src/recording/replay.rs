//! Replay of a recording under another force, with its recorded motion or with its recorded hand in closed loop.

use crate::sim::hand_replay::{HandModel, Recording as OfAHand};
use crate::sim::replay::{Replay, ReplayError, ReplaySetup};
use crate::sim::run::{Reference, Run};
use palpate_record::recording::Recording;
use palpate_record::trace::Part;
use palpate_scene::Scene;
use palpate_scene::method::MethodName;

use super::{RecordedCurves, Ticks, TicksError};
use crate::hand_replay::{HandRecording, HandReplayError, HandReplayStep, ReplayRuns, close_loop};
use crate::report::{FromRecording, Replayed, Report, Subject, actuation_lines, metadata};

/// Replayed part of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReplayOf {
    /// The motion: the device follows its recorded path at any force.
    Motion,
    /// The hand: its force is estimated, and the device moves under the new force.
    Hand(StatedHand),
}

/// Stated parameters of a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StatedHand {
    /// Bandwidth of its force `[Hz]`; `None` selects the most likely one for the recording.
    pub bandwidth: Option<f64>,
    /// Stiffness of its grip on the recorded motion `[N/m]`; `None` selects the usual one.
    pub stiffness: Option<f64>,
    /// Damping of its grip on the recorded motion `[N s/m]`; `None` selects the usual one.
    pub damping: Option<f64>,
}

impl StatedHand {
    /// Returns the model of the hand on a device of `device_mass` `[kg]`, with the sensor's quantum `[m]`.
    #[must_use]
    pub fn model(&self, device_mass: f64, encoder_quantum: f64) -> HandModel {
        HandModel {
            encoder_quantum,
            bandwidth: self.bandwidth,
            stiffness: self.stiffness.unwrap_or(HandModel::USUAL_STIFFNESS),
            damping: self.damping.unwrap_or(HandModel::USUAL_DAMPING),
            ..HandModel::force_on(device_mass)
        }
    }

    /// Whether its stiffness or its damping is assumed.
    #[must_use]
    pub fn is_assumed(&self) -> bool {
        self.stiffness.is_none() || self.damping.is_none()
    }
}

/// A recording of one contact, and the parameters of its replay.
#[derive(Clone, Copy, Debug)]
pub struct RecordingReplay<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// The scene that it was made with.
    pub recorded: &'a Scene,
    /// The rendered scene: the recorded scene with its changes.
    pub scene: &'a Scene,
    /// Whether the object starts as in the scene; otherwise at its position in the first replayed tick.
    pub object_as_in_scene: bool,
    /// Replayed part of the recording.
    pub part: Part,
    /// Motion or hand.
    pub of: ReplayOf,
}

/// Results of a replay of a recording.
#[derive(Debug)]
pub struct ReplayedRecording {
    /// The report.
    pub report: Report,
    /// Metadata of a run file.
    pub metadata: Vec<(String, String)>,
    /// A line that names the replay.
    pub title: String,
    /// The ideal.
    pub reference: Reference,
    /// One run for each method.
    pub runs: Vec<Run>,
    /// The replayed motion or hand, and its accuracy.
    pub replayed: Replayed,
    /// Recorded curves.
    pub curves: RecordedCurves,
    /// Methods under which the device leaves the recorded motion farther than an arm reaches, with the distances
    /// `[m]`.
    pub beyond_reach: Vec<(MethodName, f64)>,
}

/// Reason why a recording was not replayed.
#[derive(Debug)]
pub enum RecordingReplayError {
    /// The ticks cannot be replayed.
    Ticks(TicksError),
    /// The motion cannot be replayed, or not by this method.
    Motion(MethodName, ReplayError),
    /// The hand cannot be replayed.
    Hand(HandReplayError),
}

impl RecordingReplay<'_> {
    /// Replays the recording by each of `methods`. Calls `begins` at the start of each step.
    ///
    /// # Errors
    /// The recording cannot be read or replayed, or a method cannot be set up.
    pub fn by(
        &self,
        methods: &[MethodName],
        mut begins: impl FnMut(HandReplayStep),
    ) -> Result<ReplayedRecording, RecordingReplayError> {
        let (recording, scene) = (self.recording, self.scene);
        let name = recording.path().display().to_string();
        let wrong = RecordingReplayError::Ticks;
        let mut ticks = Ticks::new(recording, &self.part).map_err(wrong)?;
        let mut setup = ReplaySetup::of_scene(scene);
        if !self.object_as_in_scene {
            ticks.place_object(&mut setup, matches!(self.of, ReplayOf::Hand(_)));
        }
        let (replayed, beyond_reach) = match self.of {
            ReplayOf::Motion => {
                let runs = motion(&ticks, setup, (scene, methods), &mut begins)
                    .map_err(|(method, error)| RecordingReplayError::Motion(method, error))?;
                (runs, Vec::new())
            }
            ReplayOf::Hand(stated) => {
                let recorded = self.recorded;
                let (delay, period) = (recorded.delay.whole_samples(), recorded.loop_params.period);
                let longest_gap = setup.loop_params.bridged_gap();
                let held = ticks.held_device(&name, delay, period, longest_gap);
                let held = held.map_err(wrong)?;
                if let Some(start) = held.times.first() {
                    ticks.curves.count_from(*start);
                }
                let of_a_hand = HandRecording {
                    recording: OfAHand {
                        times: &held.times,
                        positions: &held.positions,
                        forces_on_device: Some(&held.forces),
                    },
                    at_its_instants: true,
                };
                let model = stated.model(scene.device.mass(), setup.encoder_quantum);
                let model = (&setup, &model, stated.is_assumed());
                close_loop(&of_a_hand, model, (methods, &scene.settings), begins)
                    .map_err(RecordingReplayError::Hand)?
            }
        };
        Ok(self.evaluated(name, setup, ticks, (replayed, beyond_reach)))
    }

    /// Creates the report on the replay.
    fn evaluated(
        &self,
        name: String,
        setup: ReplaySetup,
        mut ticks: Ticks,
        (replayed, beyond_reach): (ReplayRuns, Vec<(MethodName, f64)>),
    ) -> ReplayedRecording {
        let ReplayRuns {
            reference,
            mut runs,
            replayed,
        } = replayed;
        // A recording contains the object's position; the scene contains the offset of the centre.
        let centre = self.scene.centre_offset();
        runs.iter_mut().for_each(|run| run.centre_offset = centre);
        let object = ticks.curves.object_position.iter_mut();
        object.for_each(|position| *position += centre);
        let title = format!("{}: {name}", replayed.title());
        let subject = Subject::of_replay(title.clone(), &setup);
        let mut report = Report::new(&subject, &reference, &runs);
        report.recorded(FromRecording {
            file: name.clone(),
            recorded_method: self.recorded.method.name(),
            complete: self.recording.is_complete(),
            ticks: self.recording.ticks,
            ticks_lost: self.recording.lost(),
            ticks_without_position: ticks.without_position,
            parameter_changes: self.recording.generation,
            recorded_peak_force_n: ticks.peak_force,
            recorded_leak_held_j: ticks.curves.held_leak.last().copied().unwrap_or(0.0),
        });
        let mut metadata = metadata(&subject, setup.object, setup.virtual_force, &runs);
        metadata.extend(replayed.metadata());
        let model = actuation_lines(
            &setup.actuation,
            setup.delay().whole_samples(),
            setup.loop_params.period,
        );
        let model: Vec<_> = model.collect();
        let lines = model.iter();
        metadata.extend(lines.map(|(key, value)| (format!("actuator_{key}"), value.to_string())));
        report.actuated(model);
        metadata.push(("recording".into(), name));
        let Part { from, to, .. } = self.part;
        let ends = [("recording_from_s", from), ("recording_to_s", to)].into_iter();
        let given = ends.filter(|(_, time)| time.is_finite());
        metadata.extend(given.map(|(key, time)| (key.to_owned(), time.to_string())));
        metadata.push(("ticks_lost".into(), self.recording.lost().to_string()));
        report.replayed(replayed.clone());
        ReplayedRecording {
            report,
            metadata,
            title,
            reference,
            runs,
            replayed,
            curves: ticks.curves,
            beyond_reach,
        }
    }
}

/// Renders the recorded motion by each of `methods` at the recorded sampling instants.
fn motion(
    ticks: &Ticks,
    setup: ReplaySetup,
    (scene, methods): (&Scene, &[MethodName]),
    begins: &mut impl FnMut(HandReplayStep),
) -> Result<ReplayRuns, (MethodName, ReplayError)> {
    begins(HandReplayStep::Ideal);
    let motion = &ticks.curves;
    let replay = Replay::at_recorded_instants(setup, &motion.time, &motion.device_position)
        .map_err(|error| (scene.method, error))?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        begins(HandReplayStep::Method(method));
        let settings = scene.settings.get(&method).copied().unwrap_or_default();
        let run = replay.run(method, &settings);
        runs.push(run.map_err(|error| (method, error))?);
        begins(HandReplayStep::Done);
    }
    Ok(ReplayRuns {
        reference: replay.reference().clone(),
        runs,
        replayed: Replayed::Motion,
    })
}
