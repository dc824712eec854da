//! The forces on their way to the devices.

use palpate::{Actuation, LARGEST_DELAY};

use crate::Vector;
use crate::rigid::Vector3;

/// A force for a tool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Command {
    /// What the method asked for `[N]`.
    pub intended: Vector3,
    /// What was sent: what limits and drivers left of it `[N]`.
    pub sent: Vector3,
}

impl Command {
    fn none() -> Self {
        Self {
            intended: Vector3::zeros(),
            sent: Vector3::zeros(),
        }
    }
}

/// Most commands of a tool that are remembered: those on their way, and the one that has just acted.
const MOST: usize = LARGEST_DELAY + 2;

/// The last commands of each tool.
#[derive(Clone, Debug)]
pub(crate) struct Commands {
    rings: Vec<[Command; MOST]>,
    newest: usize,
    /// Whole samples from a command to its beginning.
    delay: usize,
}

impl Commands {
    /// `actuation`: checked, of whole samples.
    pub fn new(tools: usize, actuation: &Actuation<f64>, period: f64) -> Self {
        let is_of = |&delay: &usize| actuation.delay < (delay as f64 + 0.5) * period;
        Self {
            rings: vec![[Command::none(); MOST]; tools],
            newest: 0,
            delay: (0..LARGEST_DELAY).find(is_of).unwrap_or(LARGEST_DELAY),
        }
    }

    /// Samples from a command to its beginning.
    pub fn delay(&self) -> usize {
        self.delay
    }

    pub fn send(&mut self, intended: &[Vector3], sent: &[Vector]) {
        self.newest = (self.newest + 1) % MOST;
        for (ring, (intended, sent)) in self.rings.iter_mut().zip(intended.iter().zip(sent)) {
            ring[self.newest] = Command {
                intended: *intended,
                sent: Vector3::from(*sent),
            };
        }
    }

    /// A driver has sent another force than the last `[N]`.
    pub fn correct(&mut self, tool: usize, sent: Vector3) {
        if let Some(ring) = self.rings.get_mut(tool) {
            ring[self.newest].sent = sent;
        }
    }

    /// What acted on a tool from the last sample until now.
    pub fn held(&self, tool: usize) -> Command {
        self.ago(tool, self.delay)
    }

    /// What is going to act on a tool over the interval that is `later` intervals from now, less than the delay: before
    /// the command of this sample is sent.
    pub fn coming(&self, tool: usize, later: usize) -> Command {
        self.ago(tool, self.delay.saturating_sub(later + 1))
    }

    fn ago(&self, tool: usize, samples: usize) -> Command {
        self.rings[tool][(self.newest + MOST - samples) % MOST]
    }
}
