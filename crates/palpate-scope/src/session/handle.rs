//! A session on its thread, whatever it renders: what its owner holds.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use palpate_rt::StopFlag;
use palpate_rt::realtime::Answer;

use super::turns::{Turns, take_turns};
use super::{Command, SessionEnd, SessionError};
use crate::hub::Hub;

/// Most requests that wait.
const REQUESTS: usize = 256;

/// A session on its thread. Dropping it ends it, and waits until its devices are commanded no force
/// and its recordings are whole.
///
/// `End` is how it ends: [`SessionEnd`] on one contact, [`WorldSessionEnd`](crate::WorldSessionEnd) on a world.
pub struct Session<End = SessionEnd> {
    thread: Option<JoinHandle<End>>,
    stop: StopFlag,
    commands: SyncSender<Command>,
    hub: Arc<Hub>,
    answers: Vec<Answer>,
}

impl<End: Send + 'static> Session<End> {
    /// Begins what `begin` makes of the hub and a flag below `stop`, and its thread.
    ///
    /// # Errors
    /// It does not begin, or the system has no thread.
    pub(crate) fn begin<Running>(
        stop: &StopFlag,
        begin: impl FnOnce(Arc<Hub>, StopFlag) -> Result<Running, SessionError>,
    ) -> Result<Self, SessionError>
    where
        Running: Turns<End = End> + Send + 'static,
    {
        let stop = stop.below();
        let (commands, incoming): (_, Receiver<Command>) = sync_channel(REQUESTS);
        let hub = Arc::new(Hub::default());
        let running = begin(Arc::clone(&hub), stop.clone())?;
        let answers = running.answers();
        let told = stop.clone();
        let thread = Builder::new()
            .name("palpate scope".to_owned())
            .spawn(move || take_turns(running, &incoming, &told))
            .map_err(|error| format!("no thread for the scope: {error}"))?;
        Ok(Self {
            thread: Some(thread),
            stop,
            commands,
            hub,
            answers,
        })
    }

    /// Where clients join.
    #[must_use]
    pub fn hub(&self) -> Arc<Hub> {
        Arc::clone(&self.hub)
    }

    /// Where clients say what they ask for.
    #[must_use]
    pub fn commands(&self) -> SyncSender<Command> {
        self.commands.clone()
    }

    /// What the machine granted the first loop.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// Whether it is over.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for its end.
    ///
    /// # Panics
    /// The session's thread panicked; its loops have let go of their devices.
    #[must_use]
    pub fn join(mut self) -> End {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(end)) => end,
            Some(Err(payload)) => std::panic::resume_unwind(payload),
            None => unreachable!("only this takes it, and once"),
        }
    }
}

impl<End> Drop for Session<End> {
    fn drop(&mut self) {
        self.stop.raise();
        if let Some(thread) = self.thread.take() {
            // Nobody asks how it ended. If it panicked, its loops have let go of their devices.
            let _ = thread.join();
        }
    }
}
