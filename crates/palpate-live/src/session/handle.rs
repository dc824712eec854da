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
    /// Starts the session that `begin` creates from the hub and a child of the flag `stop`, and its thread.
    ///
    /// # Errors
    /// The session does not start, or the system cannot create a thread.
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
        let model = stop.clone();
        let thread = Builder::new()
            .name("palpate scope".to_owned())
            .spawn(move || take_turns(running, &incoming, &model))
            .map_err(|error| format!("no thread for the live view: {error}"))?;
        Ok(Self {
            thread: Some(thread),
            stop,
            commands,
            hub,
            answers,
        })
    }

    /// Returns the hub, which clients join.
    #[must_use]
    pub fn hub(&self) -> Arc<Hub> {
        Arc::clone(&self.hub)
    }

    /// Returns the sender for requests of clients.
    #[must_use]
    pub fn commands(&self) -> SyncSender<Command> {
        self.commands.clone()
    }

    /// Returns the scheduling that the system granted to the first loop.
    #[must_use]
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// Whether it is over.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the end of the session.
    ///
    /// # Panics
    /// The session's thread panicked; its loops have disabled the outputs of their devices.
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
            // The result is discarded. After a panic the loops have disabled the outputs of their devices.
            let _ = thread.join();
        }
    }
}
