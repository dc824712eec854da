//! Connections that have not become clients: there may be so many of them, and they have so long.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::task::AbortHandle;

/// How long a request may take from its connection to the end of its answer.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// How long its head may take.
pub const HEAD_PATIENCE: Duration = Duration::from_secs(5);
/// Most connections at once that have not become clients.
const MOST: usize = 128;

/// Those that are open. When there are too many, who has waited longest goes: a browser is served
/// within milliseconds, and who opens connections and says nothing stands in nobody's way but their
/// own.
#[derive(Debug, Default)]
pub struct Connections {
    open: VecDeque<AbortHandle>,
}

impl Connections {
    /// Adds one.
    pub fn add(&mut self, connection: AbortHandle) {
        self.open.retain(|open| !open.is_finished());
        self.make_room(MOST - 1);
        self.open.push_back(connection);
    }

    /// Leaves no more than `most`.
    pub fn make_room(&mut self, most: usize) {
        while self.open.len() > most {
            if let Some(oldest) = self.open.pop_front() {
                oldest.abort();
            }
        }
    }
}
