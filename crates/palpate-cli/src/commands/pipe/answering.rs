//! A stream between standard input and standard output, with its exit codes.

use std::io;

use crate::pipe::{Answering, Ended, Messages, Mistakes, ServeError, Stopped, answer_all};
use palpate_rt::StopFlag;

use crate::failure::{Failure, tell};
use crate::inside;
use crate::results::written;

/// Messages for a device inside the object at the start and for an implausible motion.
pub const MISTAKES: Mistakes = Mistakes {
    inside: inside::at_start,
    not_a_hand: inside::not_a_hand,
};

/// Starts the messages to standard error.
pub fn messages() -> Result<Messages, Failure> {
    Messages::start(tell)
        .map_err(|error| Failure::System(format!("cannot start the message thread: {error}")))
}

/// Answers every line of standard input until it ends or a signal arrives. Prints the summary at the end, as JSON on
/// request.
pub fn answer<S: Answering>(
    set_up: impl FnOnce() -> Result<S, Failure>,
    as_json: bool,
) -> Result<(), Failure> {
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let served = answer_all(set_up()?, || io::stdin().lock(), &stop)?;
    if let Some(messages) = served.messages {
        if as_json {
            let summary = serde_json::to_string(&served.summary);
            messages.finish(summary.expect("a summary has string keys only"));
        } else {
            messages.finish(served.summary);
        }
    }
    outcome(served.ended)?;
    if let Some(safety_stop) = served.safety_stop {
        return Err(Failure::MotorsOff(format!(
            "safety stop until the end: {safety_stop}; there was no force"
        )));
    }
    if served.has_refused_all {
        return Err(Failure::MotorsOff(
            "every line was rejected: there was no force".into(),
        ));
    }
    Ok(())
}

impl From<ServeError> for Failure {
    fn from(error: ServeError) -> Self {
        Self::System(error.to_string())
    }
}

/// Converts the end of a stream to an exit code.
fn outcome(ended: Ended) -> Result<(), Failure> {
    match ended {
        Ended::Done => Ok(()),
        Ended::Stopped(Stopped::Refused(why)) => Err(Failure::input(why)),
        Ended::Stopped(Stopped::Unwritten(error)) => written(Err(error)),
        Ended::Unread(error) => Err(Failure::System(format!(
            "standard input cannot be read: {error}"
        ))),
        Ended::Signalled => Err(Failure::Interrupted(
            "stopped by a signal; the last line sets the force to 0".into(),
        )),
    }
}
