//! Commands that act in an interval.

use super::{Command, MAX_COMMANDS};
use crate::Scalar;

/// Commands that act in an interval.
pub(super) struct Schedule<S> {
    /// The last to begin first.
    begun: [Begun<S>; MAX_COMMANDS],
    count: usize,
}

/// The begin of a command.
#[derive(Clone, Copy)]
pub(super) struct Begun<S> {
    /// Its time after the interval's beginning `[s]`; negative if the command began before.
    pub begins: S,
    pub command: Command<S>,
    /// Its change of the previous command, if it begins in the interval `[N]`.
    pub step: S,
}

/// A part of an interval in which one command acts.
pub(super) struct Part<S> {
    pub begins: S,
    pub ends: S,
    /// Time from the command's own begin to that of the part `[s]`.
    pub age: S,
    pub command: Command<S>,
    /// Change of the force, if the command begins with this part `[N]`.
    pub step: S,
}

impl<S: Scalar> Schedule<S> {
    pub fn empty() -> Self {
        let none = Begun {
            begins: S::ZERO,
            command: Command::default(),
            step: S::ZERO,
        };
        Self {
            begun: [none; MAX_COMMANDS],
            count: 0,
        }
    }

    /// Returns the schedule of one part alone.
    pub fn of(part: &Part<S>) -> Self {
        let mut alone = Self::empty();
        alone.add(Begun {
            begins: S::ZERO - part.age,
            command: part.command,
            step: part.step,
        });
        alone
    }

    pub fn add(&mut self, begun: Begun<S>) {
        if let Some(place) = self.begun.get_mut(self.count) {
            *place = begun;
            self.count += 1;
        }
    }

    /// Returns the begins of the commands, the last to begin first.
    pub fn begun(&self) -> &[Begun<S>] {
        self.begun.get(..self.count).unwrap_or_default()
    }

    /// Returns the parts in temporal order, to the interval's end at `h` `[s]`.
    pub fn parts(&self, h: S) -> impl Iterator<Item = Part<S>> {
        let begun = self.begun();
        let ends = move |place: usize| match place.checked_sub(1).and_then(|next| begun.get(next)) {
            Some(next) => next.begins,
            None => h,
        };
        begun.iter().enumerate().rev().map(move |(place, begun)| {
            let begins = begun.begins.max(S::ZERO);
            Part {
                begins,
                ends: ends(place),
                age: begins - begun.begins,
                command: begun.command,
                step: begun.step,
            }
        })
    }
}
