//! From a line to its answer: renderer, limits, energy ledger and messages, in the order of the lines.

use std::io::{self, Write};

use palpate_core::{Fault, Output, Sample};
use palpate_device::Wrench;
use palpate_record::recording::{self, ContactTick, Tick};
use palpate_record::unit::HandMotion;
use palpate_rt::safety::{self, Safety, SafetyStop, Verdict};
use palpate_rt::{CHANGE_DURATION, Rendered, answered};

use crate::pipe::change::{Change, Changeable};
use crate::pipe::columns::{Answer, Columns};
use crate::pipe::line::{Format, Line, Refusal, is_word, word_in_words};
use crate::pipe::messages::Messages;
use crate::pipe::mistake::Mistakes;
use crate::pipe::serving::{Answering, Stopped};
use crate::pipe::summary::{BEYOND_GUARD, PipeSummary, stop_in_words};

/// Number of rejected lines that are reported one by one; beyond it each doubling is reported. A dead sensor at 1 kHz
/// would flood standard error.
const REPORTED_EACH: u64 = 8;

/// A renderer between two streams, with its state between two lines.
pub struct Stream {
    /// Parameters that a line can change.
    pub changeable: Changeable,
    /// The renderer, its object and its energy ledger.
    pub rendered: Rendered,
    /// Limits of the forces.
    pub safety: Safety,
    /// Format of the input lines.
    pub format: Format,
    /// Columns of the output.
    pub columns: Columns,
    /// Whether the output begins with a header.
    pub is_header_asked: bool,
    /// Output of the answers, flushed after each.
    pub output: Box<dyn Write + Send>,
    /// `None` once the end has been reported.
    pub messages: Option<Messages>,
    /// Wording of likely mistakes.
    pub mistakes: Mistakes,
    /// Summary so far.
    pub summary: PipeSummary,
    /// State from the previous lines.
    pub memory: Memory,
}

/// State from the previous lines.
#[derive(Default)]
pub struct Memory {
    /// Time of the last line that had one `[s]`.
    last_time: Option<f64>,
    /// Number of samples, including lost ones.
    samples: u64,
    /// Sum of the times between samples that were used `[s]`.
    followed: f64,
    /// Range and path of the motion.
    motion: HandMotion,
    /// Whether a sample has been used.
    is_begun: bool,
    /// Whether a force has been limited.
    is_limited: bool,
    /// The last answer.
    last: Option<Answer>,
    /// Buffer of the output line.
    text: String,
    /// Whether the last line of the output has been written.
    is_ended: bool,
}

impl Stream {
    /// Writes a message to standard error.
    pub fn tell(&mut self, message: impl std::fmt::Display) {
        if let Some(messages) = &mut self.messages {
            messages.tell(message);
        }
    }

    fn change(&mut self, number: u64, change: Result<Change, String>) {
        match change.and_then(|change| self.changeable.make(&change).map(|()| change)) {
            Ok(change) => {
                self.summary.changes += 1;
                self.tell(format_args!(
                    "line {number}: set {change}, reached over {CHANGE_DURATION} s"
                ));
            }
            Err(why) => self.tell(format_args!(
                "line {number}: set is refused and has no effect: {why}"
            )),
        }
    }

    /// Renders a sample, or a line without one.
    fn render(
        &mut self,
        number: u64,
        sample: Option<(Option<f64>, f64, f64)>,
        unread: Option<String>,
    ) -> Result<Answer, Stopped> {
        let period = self.changeable.setup.loop_params.period;
        // NaN informs the renderer of a lost sample.
        let (time, position, virtual_force) = sample.unwrap_or((None, f64::NAN, 0.0));
        let elapsed = match (time, self.memory.last_time) {
            (Some(now), Some(last)) => Some(now - last),
            _ => None,
        };
        let _ = self.rendered.take_change();
        let mut output = self.rendered.step(Sample {
            elapsed,
            ..Sample::at(position).with_virtual_force(virtual_force)
        });
        let is_used = output.fault.is_none();
        if is_used {
            self.follow(number, position, elapsed.unwrap_or(period))?;
        }
        let verdict = self.limit(&output, position, elapsed);
        output.limited.force |= verdict.bounded.force;
        output.limited.slew |= verdict.bounded.slew;
        let [force, ..] = verdict.wrench.force;
        let [slope, ..] = verdict.slope;
        self.rendered.report_sent_line(-force, -slope);
        // Keep the time of a rejected line. If it is wrong, only the next line is rejected too; otherwise a clock that
        // was set would cause all following lines to be rejected.
        self.memory.last_time = time.or(self.memory.last_time);
        let counted = self.memory.samples as f64 * period;
        self.memory.samples += 1;

        if is_used && !self.memory.is_begun {
            self.memory.is_begun = true;
            self.tell_if_inside(number, position);
        }
        let fault = unread
            .as_ref()
            .map_or_else(|| output.fault.map_or("", Fault::name), |_| "unreadable");
        if let Some(why) = unread.or_else(|| output.fault.map(|fault| fault.to_string())) {
            self.tell_refused(number, &why);
        }
        self.report_limits(number, &output, &verdict);
        Ok(Answer {
            values: recording::Row {
                tick: Tick {
                    time: if self.format.time {
                        time.unwrap_or(f64::NAN)
                    } else {
                        counted
                    },
                    ..Tick::UNKNOWN
                },
                contact: ContactTick {
                    device_position: position,
                    force_on_device: force,
                    ..answered(&output, self.rendered.ledger())
                },
                ..recording::Row::UNKNOWN
            },
            slope,
            softened: verdict.bounded.soft_start,
            stopped: verdict.bounded.stopped,
            fault,
            ended: false,
        })
    }

    /// Limits the force of a renderer's output at `position` `[m]`, `elapsed` `[s]` after the last line.
    fn limit(&mut self, output: &Output<f64>, position: f64, elapsed: Option<f64>) -> Verdict {
        let is_used = output.fault.is_none();
        self.safety.evaluate(&safety::Rendered {
            elapsed,
            // A position that the renderer rejected is not checked.
            position: [if is_used { position } else { 0.0 }, 0.0, 0.0],
            coordinate: if is_used { position } else { 0.0 },
            wrench: Wrench::of_force([output.force_on_device, 0.0, 0.0]),
            slope: [output.slope_on_device, 0.0, 0.0],
            created_energy: self.rendered.ledger().created(),
            refused: !is_used,
            stalled: false,
        })
    }

    /// Counts a sample with its active limits. Reports a safety stop, the first limited force and the first interval
    /// beyond the guard's acceleration.
    fn report_limits(&mut self, number: u64, output: &Output<f64>, verdict: &Verdict) {
        self.summary.samples += 1;
        self.summary.limited += u64::from(output.limited.any());
        self.summary.beyond_guard += u64::from(output.limited.beyond_guard);
        if output.limited.beyond_guard && self.summary.beyond_guard == 1 {
            self.tell(format_args!("line {number}: {BEYOND_GUARD}"));
        }
        self.summary.softened += u64::from(verdict.bounded.soft_start);
        if let Some(safety_stop) = verdict
            .stopped
            .filter(|safety_stop| !safety_stop.is_passing())
        {
            self.summary.safety_stop = Some(safety_stop.name());
            self.tell(format_args!(
                "line {number}: {}",
                stop_in_words(self.safety.params(), safety_stop)
            ));
        }
        if output.limited.force && !self.memory.is_limited {
            self.memory.is_limited = true;
            let limit = self.safety.params().largest_force;
            self.tell(format_args!(
                "line {number}: the contact force exceeds the limit of {limit} N; further limited forces are only \
                 counted in the summary"
            ));
        }
    }

    /// Rejects an implausible motion, unless a flag set the unit.
    fn follow(&mut self, number: u64, position: f64, elapsed: f64) -> Result<(), Stopped> {
        self.memory.followed += elapsed;
        if self.format.is_unit_given {
            return Ok(());
        }
        let motion = &mut self.memory.motion;
        motion.add(self.memory.followed, position);
        match motion.excess() {
            Some(excess) => Err(Stopped::at_line(
                number,
                &(self.mistakes.not_a_hand)(&excess),
            )),
            None => Ok(()),
        }
    }

    fn tell_if_inside(&mut self, number: u64, position: f64) {
        let (setup, is_unit_given) = (&self.changeable.setup, self.format.is_unit_given);
        let Some(inside) = (self.mistakes.inside)(setup, position, is_unit_given) else {
            return;
        };
        let soft = self.safety.params().soft_start;
        let comes_in = if soft > 0.0 {
            format!("; the force ramps up over {soft} s")
        } else {
            String::new()
        };
        self.tell(format_args!("line {number}: {inside}{comes_in}"));
    }

    fn tell_refused(&mut self, number: u64, why: &str) {
        self.summary.refused += 1;
        let refused = self.summary.refused;
        if refused <= REPORTED_EACH {
            self.tell(format_args!("line {number}: {why}; the force is 0"));
        } else if refused.is_power_of_two() {
            self.tell(format_args!(
                "line {number}: {why}; the force is 0 (refused so far: {refused}; next message at {})",
                refused.saturating_mul(2)
            ));
        }
    }

    fn write_text(&mut self) -> Result<(), Stopped> {
        self.output
            .write_all(self.memory.text.as_bytes())
            .and_then(|()| self.output.flush())
            .map_err(Stopped::Unwritten)
    }
}

impl Answering for Stream {
    type Summary = PipeSummary;

    fn is_ended(&self) -> bool {
        self.memory.is_ended
    }

    fn safety_stop(&self) -> Option<SafetyStop> {
        self.safety
            .safety_stop()
            .filter(|safety_stop| !safety_stop.is_passing())
    }

    fn has_refused_all(&self) -> bool {
        self.summary.samples > 0 && self.summary.refused == self.summary.samples
    }

    fn write_header(&mut self) -> io::Result<()> {
        if !self.is_header_asked {
            return Ok(());
        }
        self.output.write_all(self.columns.header().as_bytes())?;
        self.output.flush()
    }

    fn take(&mut self, number: u64, text: Result<&str, String>) -> Result<(), Stopped> {
        let mut text = text;
        if number == 1
            && let Ok(first) = &mut text
        {
            // Spreadsheets write a byte order mark before the first line.
            *first = first.trim_start_matches('\u{feff}');
            let header = self.format.with_header(first);
            if let Some(format) = header.map_err(|why| Stopped::at_line(number, &why))? {
                self.format = format;
                if is_word(first) {
                    self.tell(word_in_words(first, &format.shape()));
                }
                return Ok(());
            }
        }
        let line = match text {
            Ok(text) => self.format.parse(text),
            Err(why) => Err(Refusal::Line(why)),
        };
        let (sample, unread) = match line {
            Ok(Line::Sample {
                time,
                position,
                virtual_force,
            }) => (Some((time, position, virtual_force)), None),
            Ok(Line::Set(change)) => {
                self.change(number, change);
                return Ok(());
            }
            Err(Refusal::Line(why)) => (None, Some(why)),
            Err(Refusal::Stream(why)) => return Err(Stopped::at_line(number, &why)),
        };
        let row = self.render(number, sample, unread)?;
        self.columns.write(&row, &mut self.memory.text);
        self.memory.last = Some(row);
        self.write_text()
    }

    fn end(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.memory.is_ended, true) {
            return Ok(());
        }
        let Some(last) = self.memory.last.take() else {
            return Ok(());
        };
        self.columns.write(&last.end(), &mut self.memory.text);
        self.output.write_all(self.memory.text.as_bytes())?;
        self.output.flush()
    }

    fn finish(&mut self) -> (PipeSummary, Option<Messages>) {
        let summary = self.summary.with_ledger(self.rendered.ledger());
        let checks_timing = self.rendered.rendering().checks_timing();
        let summary =
            summary.with_learned_lateness(self.rendered.learned_lateness(), checks_timing);
        (summary, self.messages.take())
    }
}
