//! Limits on the number and duration of connections that are not clients yet.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::task::AbortHandle;

/// Longest duration of a request, from its connection to the end of its answer.
pub const PATIENCE: Duration = Duration::from_secs(10);
/// Longest duration of its head.
pub const HEAD_PATIENCE: Duration = Duration::from_secs(5);
/// Most connections at once that have not become clients.
const MOST: usize = 128;

/// Open connections. If there are too many, the longest waiting one is closed. A browser is served within milliseconds,
/// so idle connections only displace each other.
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
