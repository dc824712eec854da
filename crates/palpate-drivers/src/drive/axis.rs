//! The protocol of a drive.

use std::time::Duration;

use super::open::OpenError;
use super::text::Text;
use super::wire::Wire;

/// State of an axis, from an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisState {
    /// Position `[turns]`.
    pub position: f64,
    /// Condition of the drive.
    pub condition: Condition,
}

/// Condition of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// It holds the commanded torque.
    Ready,
    /// It starts, and holds no torque yet.
    Starting,
    /// Its watchdog has taken the torque off. [`Axis::resume`] ends this.
    TimedOut,
    /// It holds no torque, for a reason that lasts.
    Failed(&'static str),
}

/// Meaning of a received line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard {
    /// Part of an answer, or an acknowledgement.
    Part,
    /// Answer to the last request.
    State(AxisState),
    /// Answer to an earlier request.
    Late,
    /// No valid line.
    Unreadable,
}

/// Protocol of a motor drive with one axis.
///
/// Each line that commands a torque feeds the drive's watchdog: without one for [`watchdog`](Self::watchdog), the drive
/// takes the torque off by itself. No function but [`prepare`](Self::prepare) waits or allocates.
pub trait Axis: Send {
    /// Number of requests that may be without an answer. 1: answers do not state their request, so that the next request
    /// follows the answer.
    const MOST_UNANSWERED: u32;

    /// Returns the name of the drive with its number.
    fn name(&self) -> String;

    /// Prepares the drive for torques of at most `largest` `[N m]`, and sets its watchdog to `watchdog`. The torque is
    /// then zero.
    ///
    /// # Errors
    /// The drive does not answer, or lacks what a loop needs.
    fn prepare(
        &mut self,
        wire: &mut Wire,
        largest: f32,
        watchdog: Duration,
    ) -> Result<(), OpenError>;

    /// Returns the time without a command after which the drive takes its torque off.
    fn watchdog(&self) -> Duration;

    /// Writes a request for the state, which also commands `torque` `[N m]`.
    fn ask(&mut self, torque: f32, text: &mut Text);

    /// Writes a command of `torque` `[N m]`, which has no answer.
    fn command(&mut self, torque: f32, text: &mut Text);

    /// Writes what ends [`Condition::TimedOut`], with zero torque.
    fn resume(&mut self, text: &mut Text);

    /// Writes what switches the motor off.
    fn stop(&mut self, text: &mut Text);

    /// Takes a received line without its end.
    fn hear(&mut self, line: &[u8]) -> Heard;
}
