//! The 2DIY as a device of a loop.

use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_rt::guardian::Unguarded;

use super::board::Board;
use super::force::torques;
use super::kinematics::{ArmPose, NoPose};
use super::layout::Layout;
use super::line::{Cutter, Line, Unsent};
use super::packet::{Heard, Replies};
use super::plausible::{Implausible, Plausible};
use super::start;

/// Packets that may be on their way unanswered before no more are sent: a board that stood still
/// works off all of them, and the last one has to be the one that counts.
const MOST_UNANSWERED: u64 = 3;
/// An answer that has not come after this long is lost.
const LOST_AFTER: Duration = Duration::from_millis(50);
/// After something that cannot be made out, nothing is asked until nothing has come for this long.
const QUIET: Duration = Duration::from_millis(4);
/// A board that has not answered for this long is gone, and one whose angles have all been impossible has lost their count,
/// if it was asked often enough meanwhile: it may have been us who stood still.
const GONE_AFTER: Duration = Duration::from_secs(1);
const GONE_AFTER_READS: u32 = 20;

/// A 2DIY with its board on a serial port: two axes, x to the right and y away from the base, from
/// the axis of motor 1.
///
/// Each [`read`](Device::read) sends a STATE that repeats the held torques, and takes the angles of
/// its answer. Nothing on the wire says which answer belongs to which question, so they are
/// counted: what comes late, or twice, or in pieces is thrown away.
///
/// **The board has no watchdog: it holds its last torque until it is told another one.** This
/// driver sends no torque on every way out, and as soon as the port takes it where it does not at
/// once. Where the program is killed or stopped a [guardian](Self::guarded_by) does, if there is one.
/// Where the cable is pulled nobody can: switch the motors off.
///
/// Neither [`read`](Device::read) nor [`write`](Device::write) allocates, waits for a lock or
/// panics; `read` waits for the board, no longer than [`Options::patience`](super::Options).
#[derive(Debug)]
pub struct TwoDiy<C> {
    clock: C,
    capabilities: Capabilities,
    pub(super) line: Line,
    layout: Layout,
    board: Board,
    patience: Duration,
    replies: Replies,
    /// Answers that came, those that were given up included.
    answered: u64,
    trust: Trust,
    plausible: Plausible,
    pose: Option<ArmPose>,
    /// Torques that were commanded last `[N m]`, and the force that they make `[N]`.
    commanded: [f32; 2],
    given: [f64; 2],
    /// How often none had been commanded because it was wanted, by then.
    cuts: u64,
    /// Times that a guardian had commanded none when the loop asked last.
    told_cuts: u64,
    closed: bool,
    /// Since when answers are missing.
    behind: Option<Instant>,
    /// When the last good sample came, and how often there was none since.
    heard: Instant,
    failures: u32,
    /// Answers since the last good sample whose angles cannot be.
    doubts: u32,
    counts: Counts,
}

/// Whether answers can be counted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trust {
    /// Each belongs to a question.
    Counted,
    /// What came was cut, misread or nobody's. The line has to be quiet; when the last byte came.
    Astray(Instant),
    /// It was quiet, and one question was asked. What comes is the answer to it, or to an older one
    /// after all: then there is another one behind it. When it came.
    Tried(Option<Instant>),
}

/// What a driver has put up with so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Answers that had not come in time.
    pub late: u64,
    /// Answers nobody had asked for.
    pub surplus: u64,
    /// Bytes that belonged to no answer.
    pub stray: u64,
    /// Angles that cannot be.
    pub implausible: u64,
    /// Times that a guardian has commanded no torque.
    pub guardian_cuts: u64,
}

fn nothing_new(what: &'static str) -> DeviceError {
    DeviceError::new(DeviceErrorKind::NothingNew, what)
}

/// What the loop is told when the port is gone.
const GONE: DeviceError = DeviceError {
    kind: DeviceErrorKind::Disconnected,
    what: "the serial port is gone; a board that still has power holds its last torque",
};
const SILENT: DeviceError = DeviceError {
    kind: DeviceErrorKind::Disconnected,
    what: "the board has not answered for a second; it may hold its last torque",
};
const FULL: DeviceError = DeviceError {
    kind: DeviceErrorKind::Refused,
    what: "the serial port takes no bytes; no force follows as soon as it does, until then the \
           board may hold its last torque",
};

/// What the loop is told when nobody would take the torque off for it.
fn unguarded(how: Unguarded) -> DeviceError {
    DeviceError {
        kind: DeviceErrorKind::Refused,
        what: match how {
            Unguarded::Ended => {
                "the guardian has ended, which takes the torque off if this program is killed: no \
                 force without it"
            }
            Unguarded::NotListening => {
                "the guardian is there and does not listen, which takes the torque off if this \
                 program is killed: no force without it"
            }
        },
    }
}

/// The line, the mechanism and the first sample of a device that has been set up.
pub(super) struct Ready<C> {
    pub clock: C,
    pub line: Line,
    pub layout: Layout,
    pub board: Board,
    pub patience: Duration,
    pub capabilities: Capabilities,
    /// Angles of the first answer `[degrees]`.
    pub angles: [f32; 2],
}

impl<C> TwoDiy<C> {
    pub(super) fn new(ready: Ready<C>) -> Self {
        let now = Instant::now();
        Self {
            answered: ready.line.requests(),
            replies: Replies::new(ready.layout),
            plausible: Plausible::starting_at(ready.angles, now),
            pose: pose(&ready.layout, ready.angles).ok(),
            clock: ready.clock,
            capabilities: ready.capabilities,
            line: ready.line,
            layout: ready.layout,
            board: ready.board,
            patience: ready.patience,
            trust: Trust::Counted,
            failures: 0,
            doubts: 0,
            commanded: [0.0; 2],
            given: [0.0; 2],
            cuts: 0,
            told_cuts: 0,
            closed: false,
            behind: None,
            heard: now,
            counts: Counts::default(),
        }
    }

    /// Wiring and links.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The board.
    #[must_use]
    pub fn board(&self) -> Board {
        self.board
    }

    /// What has been put up with so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Angles of joints 1 and 2 in the last good sample `[degrees]`.
    #[must_use]
    pub fn angles(&self) -> [f32; 2] {
        self.plausible.angles()
    }

    /// The last pose, if the last good sample had one.
    #[must_use]
    pub fn pose(&self) -> Option<&ArmPose> {
        self.pose.as_ref()
    }

    /// Commands no torque and waits until the board has answered: whether it is known to hold none.
    ///
    /// # Errors
    /// The port is gone, or the board did not answer within a second, and not even after
    /// it was set up anew.
    pub fn close(mut self) -> Result<(), DeviceError> {
        self.finish()
    }

    /// Commands torques `[N m]`.
    pub(super) fn command(&mut self, torques: [f32; 2]) -> Result<(), DeviceError> {
        match self.line.command(torques) {
            Ok(cuts) => {
                self.commanded = torques;
                self.cuts = cuts;
                Ok(())
            }
            Err(Unsent::Busy) => {
                // Somebody else was about to command none, but it may be that the line did that
                // for them, and that torques went out since.
                self.cut();
                Ok(())
            }
            Err(Unsent::Full) => {
                self.cut();
                Err(FULL)
            }
            Err(Unsent::Unguarded(how)) => {
                self.cut();
                Err(unguarded(how))
            }
            Err(Unsent::Gone) => Err(GONE),
        }
    }

    /// Has no torque sent, by whoever can: from here on it is the next thing that goes out.
    fn cut(&mut self) {
        self.line.cutter().cut();
        self.commanded = [0.0; 2];
        self.given = [0.0; 2];
    }

    /// What the board holds, as far as is known.
    fn held(&self) -> Wrench {
        let [x, y] = self.given;
        Wrench::of_force([x, y, 0.0])
    }

    fn finish(&mut self) -> Result<(), DeviceError> {
        if std::mem::replace(&mut self.closed, true) {
            return Ok(());
        }
        let done = self.hold_none();
        if matches!(done, Err(error) if error.kind != DeviceErrorKind::Disconnected || error == SILENT)
        {
            // A board that has lost the beginning of a packet, or its layout, is told from the start.
            start::begin_anew(&self.line, &self.layout)?;
            self.start_over();
            self.hold_none()?;
            self.line.dismiss_guardian();
            return Ok(());
        }
        // The board holds none, or cannot be told. Elsewhere the guardian tries on.
        self.line.dismiss_guardian();
        done
    }

    /// Commands no torque, and waits for an answer to that.
    fn hold_none(&mut self) -> Result<(), DeviceError> {
        self.commanded = [0.0; 2];
        if let Err(unsent) = self.line.command_patiently([0.0; 2], GONE_AFTER) {
            // Tried on, until the line has been closed.
            self.cut();
            return Err(unsent.into());
        }
        // What is still in the port when it is closed may be lost: an answer says that it is not.
        let begun = Instant::now();
        while self.unanswered() > 0 {
            if begun.elapsed() > GONE_AFTER {
                return Err(SILENT);
            }
            self.line.serial().wait_readable(Duration::from_millis(1));
            self.listen()?;
        }
        Ok(())
    }

    /// Questions without an answer.
    fn unanswered(&self) -> u64 {
        self.line.requests().saturating_sub(self.answered)
    }

    /// Takes in what has come; the angles of the newest answer.
    fn listen(&mut self) -> Result<Option<[f32; 2]>, DeviceError> {
        let mut newest = None;
        let mut bytes = [0; 64];
        // As much as an answer to everything that may be asked in a second: bounded, whoever sends.
        for _ in 0..32 {
            let read = self.line.serial().read(&mut bytes).map_err(|_| GONE)?;
            if read > 0 && matches!(self.trust, Trust::Astray(_)) {
                self.go_astray();
            }
            for byte in bytes.iter().take(read) {
                match self.replies.hear(*byte) {
                    Heard::Part => {}
                    Heard::Stray => {
                        self.counts.stray += 1;
                        self.go_astray();
                    }
                    Heard::Angles(angles) => {
                        if self.unanswered() == 0 {
                            self.counts.surplus += 1;
                            self.go_astray();
                        } else {
                            self.answered += 1;
                            newest = Some(angles);
                        }
                    }
                }
            }
            if read < bytes.len() {
                break;
            }
        }
        Ok(newest)
    }

    fn go_astray(&mut self) {
        self.trust = Trust::Astray(Instant::now());
    }

    /// Begins anew with an empty line: what was on its way is nobody's answer any more.
    fn start_over(&mut self) {
        self.line.serial().forget_input();
        self.replies.forget();
        self.answered = self.line.requests();
        self.trust = Trust::Counted;
        self.behind = None;
    }

    /// What to say of a sample that did not come, because of `what`.
    fn missing(&mut self, what: &'static str) -> DeviceError {
        self.failures = self.failures.saturating_add(1);
        if self.heard.elapsed() < GONE_AFTER || self.failures < GONE_AFTER_READS {
            nothing_new(what)
        } else {
            SILENT
        }
    }

    /// The board has given a good sample.
    fn is_heard(&mut self) {
        self.heard = Instant::now();
        self.failures = 0;
        self.doubts = 0;
    }

    /// What to make of angles that cannot be: after a second of them the count is lost, though no two agree.
    fn for_good(&mut self, implausible: Implausible) -> Implausible {
        self.doubts = self.doubts.saturating_add(1);
        if self.heard.elapsed() < GONE_AFTER || self.doubts < GONE_AFTER_READS {
            return implausible;
        }
        self.plausible.lose_count()
    }

    /// The angles of the joints `[degrees]`, for whoever asks outside a loop.
    pub(super) fn ask_angles(&mut self) -> Result<[f32; 2], DeviceError> {
        let angles = self.ask()?;
        self.is_heard();
        Ok(angles)
    }

    /// What was commanded does not hold any more where somebody else has commanded none.
    fn mind_cuts(&mut self) {
        self.line.listen_to_guardian();
        let guardian_cuts = self.line.guardian_cuts();
        if guardian_cuts != self.counts.guardian_cuts {
            self.counts.guardian_cuts = guardian_cuts;
            // Answers to its packets cannot be told from answers to ours.
            self.go_astray();
        }
        let cuts = self.line.cuts();
        if cuts != self.cuts {
            self.cuts = cuts;
            self.commanded = [0.0; 2];
            self.given = [0.0; 2];
        }
    }

    fn ask(&mut self) -> Result<[f32; 2], DeviceError> {
        self.mind_cuts();
        self.listen()?;
        if self.unanswered() == 0 {
            self.behind = None;
        }
        let is_lost = self
            .behind
            .is_some_and(|since| since.elapsed() > LOST_AFTER);
        // The beginning of an answer that nobody is waiting for is none.
        let is_cut = self.unanswered() == 0 && self.replies.is_partial();
        match self.trust {
            Trust::Counted | Trust::Tried(_) if is_lost || is_cut => {
                self.go_astray();
                return Err(self.missing("an answer is missing; waiting for the board to be quiet"));
            }
            Trust::Counted => {}
            Trust::Astray(last_byte) if last_byte.elapsed() < QUIET => {
                return Err(
                    self.missing("what came is no answer; waiting for the board to be quiet")
                );
            }
            Trust::Astray(_) => {
                self.start_over();
                self.trust = Trust::Tried(None);
                self.line.ask().map_err(DeviceError::from)?;
                return Err(self.missing("the board is being tried"));
            }
            Trust::Tried(None) => {
                if self.unanswered() == 0 {
                    self.trust = Trust::Tried(Some(Instant::now()));
                } else {
                    self.behind.get_or_insert_with(Instant::now);
                }
                return Err(self.missing("the board is being tried"));
            }
            Trust::Tried(Some(answered)) if answered.elapsed() < QUIET => {
                return Err(self.missing("the board is being tried"));
            }
            Trust::Tried(Some(_)) => self.trust = Trust::Counted,
        }
        if self.unanswered() < MOST_UNANSWERED {
            match self.line.ask() {
                Ok(()) => {}
                Err(Unsent::Full) => return Err(self.missing("the serial port takes no bytes")),
                Err(unsent) => return Err(unsent.into()),
            }
        }
        let begun = Instant::now();
        let mut newest = None;
        while self.unanswered() > 0 {
            let left = self.patience.saturating_sub(begun.elapsed());
            if left.is_zero() {
                self.counts.late += 1;
                self.behind.get_or_insert_with(Instant::now);
                if self.replies.is_partial() {
                    self.go_astray();
                }
                return Err(self.missing("the board did not answer in time"));
            }
            self.line.serial().wait_readable(left);
            newest = self.listen()?.or(newest);
            if self.trust != Trust::Counted {
                return Err(self.missing("what the board sent is no answer"));
            }
        }
        match newest {
            Some(angles) => Ok(angles),
            None => Err(self.missing("the board did not answer in time")),
        }
    }
}

impl From<Unsent> for DeviceError {
    fn from(unsent: Unsent) -> Self {
        match unsent {
            Unsent::Busy => nothing_new("somebody else is commanding no force"),
            Unsent::Full => FULL,
            Unsent::Gone => GONE,
            Unsent::Unguarded(how) => unguarded(how),
        }
    }
}

/// The pose for angles of the joints `[degrees]`.
fn pose(layout: &Layout, angles: [f32; 2]) -> Result<ArmPose, NoPose> {
    let angles = angles.map(|angle| f64::from(angle).to_radians());
    layout.geometry.pose(angles)
}

impl<C> Drop for TwoDiy<C> {
    fn drop(&mut self) {
        // Nobody is left to be told.
        let _ = self.finish();
    }
}

impl<C: Clock> Device for TwoDiy<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let asked = Instant::now();
        let angles = self.ask()?;
        if let Some(how) = self.line.unguarded() {
            return Err(unguarded(how));
        }
        let time = self.clock.now();
        let now = Instant::now();
        if let Err(implausible) = self.plausible.take(angles, asked, now) {
            self.counts.implausible += 1;
            // It has answered, so it is not gone.
            self.failures = 0;
            return Err(match self.for_good(implausible) {
                Implausible::Once(what) => nothing_new(what),
                Implausible::Stays(what) => {
                    // Where the arm is, is not known until the device is opened anew.
                    self.heard = Instant::now();
                    self.pose = None;
                    let _ = self.command([0.0; 2]);
                    DeviceError::new(DeviceErrorKind::Refused, what)
                }
            });
        }
        match pose(&self.layout, angles) {
            Ok(pose) => {
                self.is_heard();
                let [x, y] = pose.position;
                self.pose = Some(pose);
                Ok(Pose {
                    orientation: None,
                    position: [x, y, 0.0],
                    time,
                })
            }
            Err(no_pose) => {
                self.pose = None;
                self.is_heard();
                self.command([0.0; 2])?;
                Err(nothing_new(match no_pose {
                    NoPose::NotANumber => "an angle is not a number",
                    NoPose::OutOfReach => {
                        "angles outside the workspace; was the arm in its start pose?"
                    }
                    NoPose::Singular => "the arm is in a singular pose, where it can make no force",
                }))
            }
        }
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let [x, y, _] = wrench.force;
        let (torques, given) = match &self.pose {
            Some(pose) => torques(pose, self.board, [x, y]),
            None => ([0.0; 2], [0.0; 2]),
        };
        self.mind_cuts();
        let unanswered = self.unanswered();
        let is_trusted = self.trust == Trust::Counted;
        if unanswered > 0 || !is_trusted {
            // A board that is behind gets nothing that it has on its way already, and no other
            // force: where the arm is, is not known well enough for one.
            let is_on_its_way = torques == self.commanded && torques != [0.0; 2];
            let has_none = self.commanded == [0.0; 2];
            if is_on_its_way || has_none && (unanswered > MOST_UNANSWERED || !is_trusted) {
                return Ok(self.held());
            }
            self.given = [0.0; 2];
            return self.command([0.0; 2]).map(|()| Wrench::NONE);
        }
        self.given = given;
        self.command(torques)?;
        Ok(self.held())
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Cutter);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                self.0.cut();
            }
        }
        Some(Box::new(Zero(self.line.cutter())))
    }

    fn was_cut(&mut self) -> bool {
        self.mind_cuts();
        let cuts = self.counts.guardian_cuts;
        std::mem::replace(&mut self.told_cuts, cuts) != cuts
    }
}

#[cfg(test)]
#[path = "driver_tests.rs"]
mod tests;
