//! A recording of one rendering that starts and ends while its loop runs.

use std::path::{Path, PathBuf};

use palpate_record::files::atomic::WriteError;
use palpate_record::recording::{ContactTick, RecordingMetadata, Tick};
use palpate_rt::{Counters, LoopEvent, Note, Recorder, Tap};

use super::Written;

/// A recording of the received ticks of a loop. Its first tick has the number 0, independently of the loop's count. A
/// tick that was lost before it was received leaves a gap in the numbers.
#[derive(Debug)]
pub struct LaneRecording {
    tap: Tap,
    recorder: Recorder,
    path: PathBuf,
    /// Generation of the parameters in the metadata.
    generation: u32,
    first: Option<u64>,
    /// Newest change that took effect before the first tick and is not in the metadata.
    changed: Option<LoopEvent>,
    /// Number of ticks since the first.
    known: u64,
    messages: u64,
    /// Number of ticks that were dropped because the disk queue was full.
    dropped: u64,
}

impl LaneRecording {
    /// Starts a recording at `path` with the first tick that is rendered by the parameters of this generation.
    ///
    /// # Errors
    /// The file exists or cannot be written, or the system cannot create a thread.
    pub fn begin(
        path: PathBuf,
        metadata: &RecordingMetadata,
        generation: u32,
    ) -> Result<Self, WriteError> {
        let (tap, recorder) = Recorder::begin(&path, metadata)?;
        Ok(Self {
            tap,
            recorder,
            path,
            generation,
            first: None,
            changed: None,
            known: 0,
            messages: 0,
            dropped: 0,
        })
    }

    /// Returns the same recording for a loop that has not started: its first tick is that of the loop, even if it is
    /// lost before it is received.
    pub fn with_the_first_tick(self) -> Self {
        Self {
            first: Some(0),
            ..self
        }
    }

    /// Passes on a tick and its contacts.
    pub fn tick(&mut self, tick: &Tick, contacts: &[ContactTick]) {
        let first = match self.first {
            Some(first) => first,
            // Ticks of earlier parameters do not match the metadata.
            None if tick.generation < self.generation => return,
            None => *self.first.insert(tick.sequence),
        };
        if let Some(changed) = self.changed.take() {
            self.note(&LoopEvent {
                sequence: tick.sequence,
                ..changed
            });
        }
        let sequence = tick.sequence - first;
        self.known = sequence + 1;
        self.messages += 1;
        let lost = self.tap.lost();
        let renumbered = Tick {
            sequence,
            generation: tick.generation.saturating_sub(self.generation),
            ..*tick
        };
        self.tap.tick(&renumbered, contacts);
        self.dropped += self.tap.lost() - lost;
    }

    /// Passes on something that happened.
    pub fn note(&mut self, noted: &LoopEvent) {
        if self.first.is_none()
            && let Note::Changed { generation, .. } = noted.note
            && generation > self.generation
        {
            self.changed = Some(*noted);
        }
        let Some(sequence) = self
            .first
            .and_then(|first| noted.sequence.checked_sub(first))
        else {
            return;
        };
        let note = match noted.note {
            Note::Changed {
                generation,
                rendering,
            } => Note::Changed {
                generation: generation.saturating_sub(self.generation),
                rendering,
            },
            other => other,
        };
        self.tap.note(&LoopEvent {
            sequence,
            note,
            ..*noted
        });
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Ticks that were passed on.
    pub fn ticks(&self) -> u64 {
        self.messages
    }

    /// Ticks that are missing, on the way here or to the disk, as far as is known: the loop may have
    /// made more since.
    pub fn lost(&self) -> u64 {
        self.known - self.messages + self.dropped
    }

    /// Size of its file so far.
    pub fn bytes(&self) -> u64 {
        let mut part = self.path.clone().into_os_string();
        part.push(".part");
        std::fs::metadata(part).map_or(0, |file| file.len())
    }

    /// Whether nothing more is written although it has not been ended.
    pub fn has_failed(&self) -> bool {
        self.recorder.has_ended()
    }

    /// Ends the recording of a loop that has ended with these counters.
    pub fn end_with_loop(mut self, counted: &Counters) -> Ending {
        if let Some(first) = self.first {
            let here = match first {
                0 => *counted,
                _ => Counters {
                    ticks: counted.ticks.saturating_sub(first),
                    ..self.tap.counted()
                },
            };
            self.tap.count(&here);
        }
        if let Some(ending) = counted.ending {
            self.tap.end(ending);
        }
        Ending {
            recorder: self.recorder,
            path: self.path,
        }
    }

    /// Ends the input; the remaining data is written while the loop continues.
    pub fn end(self) -> Ending {
        Ending {
            recorder: self.recorder,
            path: self.path,
        }
    }
}

/// A recording that is being brought to its end.
#[derive(Debug)]
pub struct Ending {
    recorder: Recorder,
    path: PathBuf,
}

impl Ending {
    /// Whether all is written.
    pub fn is_over(&self) -> bool {
        self.recorder.has_ended()
    }

    /// Waits until all is written, or the system has refused to.
    pub fn finish(self) -> Written {
        let (account, unwritten) = self.recorder.finish();
        let held = account.recording.map_or(0, |written| written.ticks);
        Written {
            path: self.path,
            lost: account.lost_ticks(),
            ticks: unwritten.map_or(Ok(held), Err),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use palpate_record::recording::{Entry, LoopTime, Recording};

    use super::*;

    /// Passes on a tick of a loop with one contact.
    fn tell(recording: &mut LaneRecording, tick: Tick) {
        recording.tick(&tick, &[ContactTick::default()]);
    }

    /// A recording begins with the parameters of its metadata, counts from 0, and has gaps for lost ticks.
    #[test]
    fn a_recording_counts_from_its_own_beginning() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("middle.mcap");
        let mut recording =
            LaneRecording::begin(path.clone(), &RecordingMetadata::new("test"), 3).unwrap();
        for (sequence, generation) in [(10, 2), (11, 3), (12, 3), (14, 4)] {
            tell(
                &mut recording,
                Tick {
                    sequence,
                    generation,
                    ..Tick::default()
                },
            );
        }
        assert_eq!((recording.ticks(), recording.lost()), (3, 1));
        assert_eq!(recording.end().finish().ticks.unwrap(), 3);
        let read = Recording::open(&path).unwrap();
        assert_eq!(read.lost(), 1);
        let ticks: Vec<(u64, u32)> = read
            .entries()
            .unwrap()
            .filter_map(|entry| match entry.unwrap() {
                Entry::Tick(tick, ..) => Some((tick.sequence, tick.generation)),
                Entry::Event(_) => None,
            })
            .collect();
        assert_eq!(ticks, [(0, 0), (1, 0), (3, 1)]);
    }

    /// The first ticks and the last, and the event of the end, got lost on their way to the scope.
    #[test]
    fn what_the_loop_counted_stands_in_its_recording() {
        let folder = tempfile::tempdir().unwrap();
        let counted = Counters {
            ticks: 12,
            notes: 1,
            lost: 6,
            motors_off: 3,
            time: LoopTime {
                lasted: Duration::from_millis(12),
                motors_off: Duration::from_millis(3),
            },
            ending: Some(palpate_rt::Ending::Complete),
        };
        for (name, from_the_start, made, missing) in
            [("start", true, 12, 6), ("middle", false, 8, 2)]
        {
            let path = folder.path().join(format!("{name}.mcap"));
            let mut recording =
                LaneRecording::begin(path.clone(), &RecordingMetadata::new("test"), 0).unwrap();
            if from_the_start {
                recording = recording.with_the_first_tick();
            }
            for sequence in 4..10 {
                tell(
                    &mut recording,
                    Tick {
                        sequence,
                        ..Tick::default()
                    },
                );
            }
            let written = recording.end_with_loop(&counted).finish();
            assert_eq!(
                (written.ticks.unwrap(), written.lost),
                (6, missing),
                "{name}"
            );
            let read = Recording::open(&path).unwrap();
            assert_eq!(
                (read.ticks_made(), read.lost()),
                (Some(made), missing),
                "{name}"
            );
            let here = read.counted.unwrap();
            assert_eq!(
                here.ending.as_deref(),
                Some("the duration is over"),
                "{name}"
            );
            // The loop's times are not those of a part of it.
            assert_eq!(here.time, from_the_start.then_some(counted.time), "{name}");
        }
    }

    /// The file contains the newest change between metadata and first tick.
    #[test]
    fn what_changed_before_the_first_tick_is_written_with_it() {
        let text = include_str!("../../../../experiments/live.toml");
        let scene = palpate_scene::ContactFile::parse("live.toml", text).unwrap();
        let rendering = scene.scene.rendering(scene.scene.method).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("changed.mcap");
        let mut recording =
            LaneRecording::begin(path.clone(), &RecordingMetadata::new("test"), 3).unwrap();
        for generation in [3, 4, 5] {
            recording.note(&LoopEvent {
                sequence: 10,
                time: 0.1,
                device: None,
                note: Note::Changed {
                    generation,
                    rendering,
                },
            });
        }
        for sequence in [11, 12] {
            tell(
                &mut recording,
                Tick {
                    sequence,
                    generation: 5,
                    ..Tick::default()
                },
            );
        }
        assert_eq!(recording.end().finish().ticks.unwrap(), 2);
        let events: Vec<(u64, String)> = Recording::open(&path)
            .unwrap()
            .entries()
            .unwrap()
            .filter_map(|entry| match entry.unwrap() {
                Entry::Event(event) => Some((event.sequence, event.text)),
                Entry::Tick(..) => None,
            })
            .collect();
        assert_eq!(events.len(), 1, "{events:?}");
        assert_eq!(events[0].0, 0);
        assert!(events[0].1.contains("parameters number 2"), "{events:?}");
    }
}
