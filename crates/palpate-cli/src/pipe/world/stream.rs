//! From a line to its answer in a world: renderer, limits and messages, in the order of the lines.

use std::io::{self, Write};

use palpate_core::Fault;
use palpate_device::Wrench;
use palpate_record::unit::HandMotion;
use palpate_rt::BoundedWorld;
use palpate_rt::safety::SafetyStop;
use palpate_world::{ContactState, IDENTITY, Sample, Vector};

use super::line::{self, WorldFormat};
use super::names::Names;
use super::summary::WorldSummary;
use crate::pipe::line::{Refusal, is_word, word_in_words};
use crate::pipe::messages::Messages;
use crate::pipe::mistake::Mistakes;
use crate::pipe::number;
use crate::pipe::serving::{Answering, Stopped};
use crate::pipe::summary::{BEYOND_GUARD, stop_in_words};

/// Number of rejected lines that are reported one by one; beyond it each doubling is reported.
const REPORTED_EACH: u64 = 8;

/// The renderer of a world between two streams, with its state between two lines.
pub struct WorldStream {
    /// Renderer, state and limits.
    pub world: BoundedWorld,
    /// Names of tools and bodies.
    pub names: Names,
    /// Nominal time from line to line `[s]`.
    pub period: f64,
    /// Format of the input lines.
    pub format: WorldFormat,
    /// Whether the output begins with a header.
    pub is_header_asked: bool,
    /// Output of the answers, flushed after each.
    pub output: Box<dyn Write + Send>,
    /// `None` once the end has been reported.
    pub messages: Option<Messages>,
    /// Wording of likely mistakes.
    pub mistakes: Mistakes,
    /// Summary so far.
    pub summary: WorldSummary,
    /// State from the previous lines.
    pub memory: WorldMemory,
}

/// State from the previous lines.
#[derive(Default)]
pub struct WorldMemory {
    /// Time of the last line that had one `[s]`.
    last_time: Option<f64>,
    /// Sum of the times between samples that were used `[s]`.
    followed: f64,
    /// Range and path of each device's motion along each axis.
    motion: Vec<[HandMotion; 3]>,
    /// Whether a line has been answered.
    is_begun: bool,
    /// Whether a force has been limited.
    is_limited: bool,
    /// Whether a proxy reached its largest distance from its device.
    is_far: bool,
    /// Whether the last line of the output has been written.
    is_ended: bool,
    /// Buffer of the output line.
    text: String,
}

impl WorldStream {
    fn tell(&mut self, message: impl std::fmt::Display) {
        if let Some(messages) = &mut self.messages {
            messages.tell(message);
        }
    }

    /// Renders a sample, or a line without one.
    fn render(
        &mut self,
        number: u64,
        sample: Option<line::WorldSample>,
        unread: Option<String>,
    ) -> Result<(), Stopped> {
        // NaN informs the renderer of a lost sample.
        let devices = self.format.devices.len();
        let (time, positions, orientations) = sample.map_or_else(
            || (None, vec![[f64::NAN; 3]; devices], vec![IDENTITY; devices]),
            |sample| (sample.time, sample.positions, sample.orientations),
        );
        let elapsed = match (time, self.memory.last_time) {
            (Some(now), Some(last)) => Some(now - last),
            _ => None,
        };
        let sample = Sample {
            positions: &positions,
            orientations: &orientations,
            elapsed,
        };
        let held = self.world.step(&sample);
        let (fault, limited, bounded) = (held.fault, held.limited, held.bounded);
        let is_crowded = held.effort.left_out > 0;
        answer(
            &mut self.memory.text,
            (held.wrenches, held.slopes),
            &self.format,
        );
        self.summary.leak_held_j = self.world.created_energy();
        if fault.is_none() {
            self.follow(number, &positions, elapsed.unwrap_or(self.period))?;
        }
        let shortened = limited.force || limited.torque || bounded.force;
        // Keep the time of a rejected line, or all lines after a clock that was set would be rejected.
        self.memory.last_time = time.or(self.memory.last_time);
        if let Some(why) = unread.or_else(|| fault.map(|fault| self.in_words(&fault))) {
            self.tell_refused(number, &why);
        }
        self.summary.samples += 1;
        self.summary.limited += u64::from(shortened);
        self.summary.crowded += u64::from(is_crowded);
        if is_crowded && self.summary.crowded == 1 {
            self.tell(format_args!(
                "line {number}: more triangles or shell points are near than the renderer can hold; it ignores the \
                 furthest. Further lines are only counted in the summary"
            ));
        }
        self.summary.guarded += u64::from(limited.guard);
        if limited.guard && self.summary.guarded == 1 {
            self.tell(format_args!(
                "line {number}: the forces exceed the bound of the passivity guard; further lines are only counted \
                 in the summary"
            ));
        }
        self.summary.beyond_guard += u64::from(limited.beyond_guard);
        if limited.beyond_guard && self.summary.beyond_guard == 1 {
            self.tell(format_args!("line {number}: {BEYOND_GUARD}"));
        }
        self.summary.softened += u64::from(bounded.soft_start);
        if bounded.stopped
            && self.summary.safety_stop.is_none()
            && let Some(safety_stop) = self.world.safety_stop()
        {
            self.summary.safety_stop = Some(safety_stop.name());
            self.tell(format_args!(
                "line {number}: {}",
                stop_in_words(self.world.limits(), safety_stop)
            ));
        }
        if shortened && !self.memory.is_limited {
            self.memory.is_limited = true;
            let limit = self.limit_in_words();
            self.tell(format_args!(
                "line {number}: a contact force exceeds the limit of {limit}; further limited forces are only \
                 counted in the summary"
            ));
        }
        if limited.offset && !self.memory.is_far {
            self.memory.is_far = true;
            self.tell(format_args!(
                "line {number}: a proxy offset is at its limit of 10 mm or 0.3 rad: touched objects feel displaced \
                 until the offset has decayed"
            ));
        }
        if fault.is_none() && !self.memory.is_begun {
            self.memory.is_begun = true;
            self.tell_if_inside(number);
        }
        self.tell_if_through(number);
        Ok(())
    }

    /// Reports tools and bodies that have come out of the far side of a solid.
    fn tell_if_through(&mut self, number: u64) {
        let through = self.world.state().gone_through();
        let through: Vec<String> = through.map(|pair| self.names.through(pair)).collect();
        for words in through {
            self.summary.went_through += 1;
            if self.summary.went_through <= REPORTED_EACH {
                self.tell(format_args!("line {number}: {words}"));
            }
        }
    }

    /// Describes the limits of each device.
    fn limit_in_words(&self) -> String {
        let limits = self.world.limits();
        let gives_torque = self.format.devices.iter().any(|device| device.gives_torque);
        if gives_torque {
            format!(
                "{} N or {} N m",
                limits.largest_force, limits.largest_torque
            )
        } else {
            format!("{} N", limits.largest_force)
        }
    }

    /// Rejects an implausible motion, unless a flag set the unit.
    fn follow(&mut self, number: u64, positions: &[Vector], elapsed: f64) -> Result<(), Stopped> {
        let memory = &mut self.memory;
        memory.followed += elapsed;
        if self.format.is_unit_given {
            return Ok(());
        }
        memory.motion.resize_with(positions.len(), Default::default);
        for (motions, position) in memory.motion.iter_mut().zip(positions) {
            for (motion, coordinate) in motions.iter_mut().zip(position) {
                motion.add(memory.followed, *coordinate);
                if let Some(excess) = motion.excess() {
                    return Err(Stopped::at_line(
                        number,
                        &(self.mistakes.not_a_hand)(&excess),
                    ));
                }
            }
        }
        Ok(())
    }

    fn in_words(&self, fault: &palpate_world::WorldFault) -> String {
        match fault.tool {
            Some(tool) => format!("{}: {}", self.format.devices[tool].name, fault.fault),
            None => match fault.fault {
                Fault::Overflow => {
                    "the world cannot be computed: a contact or joint is too stiff or too damped for its masses at this \
                     period, or a body falls for ever"
                        .into()
                }
                fault => fault.to_string(),
            },
        }
    }

    /// Reports tools that begin inside a body.
    fn tell_if_inside(&mut self, number: u64) {
        // A box has a contact at each of its corners; report the deepest one.
        let mut deepest: Vec<ContactState> = Vec::new();
        for contact in self.world.state().contacts() {
            match deepest
                .iter_mut()
                .find(|known| known.between == contact.between)
            {
                _ if contact.penetration <= 0.0 => {}
                Some(known) if known.penetration >= contact.penetration => {}
                Some(known) => *known = *contact,
                None => deepest.push(*contact),
            }
        }
        let overlaps = deepest.iter().map(|contact| self.names.overlap(contact));
        for overlap in overlaps.collect::<Vec<_>>() {
            self.tell(format_args!("line {number}: {overlap} at the start"));
        }
        let in_meshes = self.world.state().inside_meshes();
        let in_meshes: Vec<String> = in_meshes.map(|pair| self.names.inside(pair)).collect();
        for inside in in_meshes {
            self.tell(format_args!("line {number}: {inside}"));
        }
    }

    fn tell_refused(&mut self, number: u64, why: &str) {
        self.summary.refused += 1;
        let refused = self.summary.refused;
        if refused <= REPORTED_EACH {
            self.tell(format_args!("line {number}: {why}; all forces are 0"));
        } else if refused.is_power_of_two() {
            let next = refused.saturating_mul(2);
            self.tell(format_args!(
                "line {number}: {why}; all forces are 0 (refused so far: {refused}; next message at {next})"
            ));
        }
    }

    fn write_text(&mut self) -> io::Result<()> {
        self.output.write_all(self.memory.text.as_bytes())?;
        self.output.flush()
    }
}

/// Formats the forces, and their slopes or the torques of devices with a torque output, into the output line.
fn answer(text: &mut String, lines: (&[Wrench], &[Vector]), format: &WorldFormat) {
    text.clear();
    let (wrenches, slopes) = lines;
    let devices = wrenches.iter().zip(slopes).zip(&format.devices);
    let numbers = devices.flat_map(|((wrench, slope), device)| {
        let slope = slope.iter().copied().filter(|_| format.slopes);
        let torque = wrench.torque.into_iter().filter(|_| device.gives_torque);
        wrench.force.into_iter().chain(slope).chain(torque)
    });
    for (place, force) in numbers.enumerate() {
        if place > 0 {
            text.push(',');
        }
        number::push(text, force);
    }
    text.push('\n');
}

impl Answering for WorldStream {
    type Summary = WorldSummary;

    fn write_header(&mut self) -> io::Result<()> {
        if !self.is_header_asked {
            return Ok(());
        }
        let header = self.format.forces().join(",");
        writeln!(self.output, "{header}")?;
        self.output.flush()
    }

    fn take(&mut self, number: u64, text: Result<&str, String>) -> Result<(), Stopped> {
        let mut text = text;
        if number == 1
            && let Ok(first) = &mut text
        {
            // Spreadsheets write a byte order mark before the first line.
            *first = first.trim_start_matches('\u{feff}');
            let header = self.format.is_header(first);
            if header.map_err(|why| Stopped::at_line(number, &why))? {
                if is_word(first) {
                    let columns = self.format.columns().join(",");
                    self.tell(word_in_words(first, &format!("`{columns}`")));
                }
                return Ok(());
            }
        }
        let sample = match text {
            Ok(text) => self.format.parse(text),
            Err(why) => Err(Refusal::Line(why)),
        };
        match sample {
            Ok(sample) => self.render(number, Some(sample), None)?,
            Err(Refusal::Line(why)) => self.render(number, None, Some(why))?,
            Err(Refusal::Stream(why)) => return Err(Stopped::at_line(number, &why)),
        }
        self.write_text().map_err(Stopped::Unwritten)
    }

    fn is_ended(&self) -> bool {
        self.memory.is_ended
    }

    fn safety_stop(&self) -> Option<SafetyStop> {
        self.world
            .safety_stop()
            .filter(|safety_stop| !safety_stop.is_passing())
    }

    fn has_refused_all(&self) -> bool {
        self.summary.samples > 0 && self.summary.refused == self.summary.samples
    }

    fn end(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.memory.is_ended, true) || self.summary.samples == 0 {
            return Ok(());
        }
        let devices = self.format.devices.len();
        let none = (vec![Wrench::NONE; devices], vec![[0.0; 3]; devices]);
        answer(&mut self.memory.text, (&none.0, &none.1), &self.format);
        self.write_text()
    }

    fn finish(&mut self) -> (WorldSummary, Option<Messages>) {
        let summary = self.summary.with_ledger(self.world.state().ledger());
        (summary, self.messages.take())
    }
}
