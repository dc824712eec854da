//! Driver of the 2DIY.

use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_rt::watchdog::Unguarded;

use super::board::Board;
use super::force::torques;
use super::kinematics::{ArmPose, NoPose};
use super::layout::Layout;
use super::line::{Cutter, Line, Unsent};
use super::packet::{Heard, Replies};
use super::plausible::{Implausible, Plausible};
use super::start;

/// Maximum number of unanswered packets before the driver stops sending. A stalled board later processes every queued
/// packet, and the last one must hold the current command.
const MAX_UNANSWERED: u64 = 3;
/// An answer that is missing for longer than this is lost.
const LOST_AFTER: Duration = Duration::from_millis(50);
/// Silence required after an unrecognised answer before the next request.
const QUIET: Duration = Duration::from_millis(4);
/// The board is reported as gone after this time without an answer, and the encoder count as lost after this time with
/// implausible angles only. Both also require `GONE_AFTER_READS` requests, because this program may have stalled
/// itself.
const GONE_AFTER: Duration = Duration::from_secs(1);
const GONE_AFTER_READS: u32 = 20;

/// A 2DIY with its board on a serial port: two axes, x to the right and y away from the base, from the axis of motor 1.
///
/// Each [`read`](Device::read) sends a STATE that repeats the held torques, and takes the angles from the answer.
/// Packets carry no sequence number, so the driver counts requests and answers. It discards late, duplicate and
/// incomplete answers.
///
/// **The board has no watchdog: it holds its last torque until it receives another command.** The driver commands zero
/// torque on every exit path, and retries if the port is full. If the program is killed or stopped, only a [watchdog
/// process](Self::guarded_by) can do so. If the cable is pulled, software cannot: switch the motors off.
///
/// Neither [`read`](Device::read) nor [`write`](Device::write) allocates, waits for a lock or panics; `read` waits for
/// the board, no longer than [`Options::patience`](super::Options).
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
    /// Number of received answers, including abandoned ones.
    answered: u64,
    trust: Trust,
    plausible: Plausible,
    pose: Option<ArmPose>,
    /// Last commanded torques `[N m]`, and the force that they produce `[N]`.
    commanded: [f32; 2],
    given: [f64; 2],
    /// Number of zero-torque requests that were sent when `commanded` was set.
    cuts: u64,
    /// Number of cuts by the watchdog process at the last call of `was_cut`.
    reported_cuts: u64,
    closed: bool,
    /// Time since which answers are missing.
    behind: Option<Instant>,
    /// Time of the last good sample, and the number of failed reads since.
    heard: Instant,
    failures: u32,
    /// Number of answers with implausible angles since the last good sample.
    doubts: u32,
    counts: Counts,
}

/// State of the matching between requests and answers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trust {
    /// Each answer belongs to a request.
    Counters,
    /// An answer was incomplete, unreadable or unrequested. The line must become quiet; holds the time of the last
    /// byte.
    Astray(Instant),
    /// The line was quiet and one request was sent. If the next answer belongs to an older request, another answer
    /// follows it. Holds the time of the answer.
    Tried(Option<Instant>),
}

/// Counters of transmission faults that the driver tolerated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Answers that did not arrive in time.
    pub late: u64,
    /// Answers without a request.
    pub surplus: u64,
    /// Bytes that belong to no answer.
    pub stray: u64,
    /// Implausible angles.
    pub implausible: u64,
    /// Number of times that the watchdog process commanded zero torque.
    pub watchdog_cuts: u64,
}

fn nothing_new(what: &'static str) -> DeviceError {
    DeviceError::new(DeviceErrorKind::NothingNew, what)
}

/// Error for a serial port that has disappeared.
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
    what: "the serial port accepts no bytes; the board may hold its last torque until it accepts zero force",
};

/// Error for a lost watchdog process.
fn unguarded(how: Unguarded) -> DeviceError {
    DeviceError {
        kind: DeviceErrorKind::Refused,
        what: match how {
            Unguarded::Ended => {
                "the watchdog has ended; no force without it, because a killed program would leave the torque on"
            }
            Unguarded::NotListening => {
                "the watchdog does not respond; no force without it, because a killed program would leave the \
                 torque on"
            }
        },
    }
}

/// Serial line, mechanism and first sample of a device that has been set up.
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
            trust: Trust::Counters,
            failures: 0,
            doubts: 0,
            commanded: [0.0; 2],
            given: [0.0; 2],
            cuts: 0,
            reported_cuts: 0,
            closed: false,
            behind: None,
            heard: now,
            counts: Counts::default(),
        }
    }

    /// Returns the wiring and link lengths.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns the board.
    #[must_use]
    pub fn board(&self) -> Board {
        self.board
    }

    /// Returns the fault counters.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns the angles of joints 1 and 2 in the last good sample `[degrees]`.
    #[must_use]
    pub fn angles(&self) -> [f32; 2] {
        self.plausible.angles()
    }

    /// Returns the last pose, or `None` if the last good sample had none.
    #[must_use]
    pub fn pose(&self) -> Option<&ArmPose> {
        self.pose.as_ref()
    }

    /// Commands zero torque and waits for the board's answer. `Ok` means that the board holds zero torque.
    ///
    /// # Errors
    /// The port is gone, or the board did not answer within a second, not even after a second setup.
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
                // Another thread holds the line, probably to command zero torque. It may already have done so, with
                // torques sent since; request zero torque again.
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

    /// Requests zero torque from any thread that can send; it is the next packet on the line.
    fn cut(&mut self) {
        self.line.cutter().cut();
        self.commanded = [0.0; 2];
        self.given = [0.0; 2];
    }

    /// Returns the force that the board holds, as far as is known.
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
            // The board lost the beginning of a packet or its layout: set it up again.
            start::begin_anew(&self.line, &self.layout)?;
            self.start_over();
            self.hold_none()?;
            self.line.dismiss_watchdog();
            return Ok(());
        }
        // The board holds zero torque or is unreachable. In other cases the watchdog process keeps trying.
        self.line.dismiss_watchdog();
        done
    }

    /// Commands zero torque and waits for the answer.
    fn hold_none(&mut self) -> Result<(), DeviceError> {
        self.commanded = [0.0; 2];
        if let Err(unsent) = self.line.command_patiently([0.0; 2], GONE_AFTER) {
            // The line retries until it is closed.
            self.cut();
            return Err(unsent.into());
        }
        // Closing the port may discard unsent bytes; the answer proves that they were sent.
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

    /// Returns the number of unanswered requests.
    fn unanswered(&self) -> u64 {
        self.line.requests().saturating_sub(self.answered)
    }

    /// Reads all received bytes and returns the angles of the newest answer.
    fn listen(&mut self) -> Result<Option<[f32; 2]>, DeviceError> {
        let mut newest = None;
        let mut bytes = [0; 64];
        // Bounded by the size of all answers to the requests of one second, whatever the other end sends.
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

    /// Discards all input and considers every request answered.
    fn start_over(&mut self) {
        self.line.serial().forget_input();
        self.replies.forget();
        self.answered = self.line.requests();
        self.trust = Trust::Counters;
        self.behind = None;
    }

    /// Returns the error for a missing sample with the reason `what`.
    fn missing(&mut self, what: &'static str) -> DeviceError {
        self.failures = self.failures.saturating_add(1);
        if self.heard.elapsed() < GONE_AFTER || self.failures < GONE_AFTER_READS {
            nothing_new(what)
        } else {
            SILENT
        }
    }

    /// Records a good sample.
    fn is_heard(&mut self) {
        self.heard = Instant::now();
        self.failures = 0;
        self.doubts = 0;
    }

    /// Declares the encoder count lost after one second of implausible angles, even if no two of them agree.
    fn for_good(&mut self, implausible: Implausible) -> Implausible {
        self.doubts = self.doubts.saturating_add(1);
        if self.heard.elapsed() < GONE_AFTER || self.doubts < GONE_AFTER_READS {
            return implausible;
        }
        self.plausible.lose_count()
    }

    /// Requests the joint angles `[degrees]`. Not for use in the loop.
    pub(super) fn ask_angles(&mut self) -> Result<[f32; 2], DeviceError> {
        let angles = self.ask()?;
        self.is_heard();
        Ok(angles)
    }

    /// Resets the commanded torques if another thread or the watchdog process has commanded zero torque.
    fn mind_cuts(&mut self) {
        self.line.listen_to_watchdog();
        let watchdog_cuts = self.line.watchdog_cuts();
        if watchdog_cuts != self.counts.watchdog_cuts {
            self.counts.watchdog_cuts = watchdog_cuts;
            // Answers to its packets cannot be distinguished from answers to the driver's packets.
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
        // A partial answer without an open request is not an answer.
        let is_cut = self.unanswered() == 0 && self.replies.is_partial();
        match self.trust {
            Trust::Counters | Trust::Tried(_) if is_lost || is_cut => {
                self.go_astray();
                return Err(self.missing("an answer is missing; waiting for the board to be quiet"));
            }
            Trust::Counters => {}
            Trust::Astray(last_byte) if last_byte.elapsed() < QUIET => {
                return Err(self.missing("invalid answer; waiting for the board to be quiet"));
            }
            Trust::Astray(_) => {
                self.start_over();
                self.trust = Trust::Tried(None);
                self.line.ask().map_err(DeviceError::from)?;
                return Err(self.missing("the board is being tested"));
            }
            Trust::Tried(None) => {
                if self.unanswered() == 0 {
                    self.trust = Trust::Tried(Some(Instant::now()));
                } else {
                    self.behind.get_or_insert_with(Instant::now);
                }
                return Err(self.missing("the board is being tested"));
            }
            Trust::Tried(Some(answered)) if answered.elapsed() < QUIET => {
                return Err(self.missing("the board is being tested"));
            }
            Trust::Tried(Some(_)) => self.trust = Trust::Counters,
        }
        if self.unanswered() < MAX_UNANSWERED {
            match self.line.ask() {
                Ok(()) => {}
                Err(Unsent::Full) => return Err(self.missing("the serial port accepts no bytes")),
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
            if self.trust != Trust::Counters {
                return Err(self.missing("the board sent an invalid answer"));
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
            Unsent::Busy => nothing_new("another thread commands zero force"),
            Unsent::Full => FULL,
            Unsent::Gone => GONE,
            Unsent::Unguarded(how) => unguarded(how),
        }
    }
}

/// Returns the pose for the joint angles `[degrees]`.
fn pose(layout: &Layout, angles: [f32; 2]) -> Result<ArmPose, NoPose> {
    let angles = angles.map(|angle| f64::from(angle).to_radians());
    layout.geometry.pose(angles)
}

impl<C> Drop for TwoDiy<C> {
    fn drop(&mut self) {
        // `drop` cannot report an error.
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
            // The board answered, so it is not gone.
            self.failures = 0;
            return Err(match self.for_good(implausible) {
                Implausible::Once(what) => nothing_new(what),
                Implausible::Stays(what) => {
                    // The arm position is unknown until the device is opened again.
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
                    NoPose::Singular => "the arm is in a singular pose and cannot exert a force",
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
        let is_trusted = self.trust == Trust::Counters;
        if unanswered > 0 || !is_trusted {
            // A board that is behind gets neither a command that is already queued nor a new force: the arm position is
            // not known well enough.
            let is_on_its_way = torques == self.commanded && torques != [0.0; 2];
            let has_none = self.commanded == [0.0; 2];
            if is_on_its_way || has_none && (unanswered > MAX_UNANSWERED || !is_trusted) {
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
        let cuts = self.counts.watchdog_cuts;
        std::mem::replace(&mut self.reported_cuts, cuts) != cuts
    }
}

#[cfg(test)]
#[path = "driver_tests.rs"]
mod tests;
