//! Sender thread. It sends the loop's last order at once. Between orders it repeats a message, so that the next sample
//! is fresh and the service does not idle.

use std::net::Shutdown;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use palpate_device::Vector;
use palpate_device::clock::Clock;
use triple_buffer::Output;
use tungstenite::{Message, WebSocket};

use super::super::command::Commands;
use super::Pace;
use super::address::Half;
use super::link::{AtomicCounts, Cause, Link, Order};

const NONE: Vector = [0.0; 3];

/// Interval of position requests while the loop is inactive.
const AT_REST: Duration = Duration::from_millis(5);

/// Time limit for the last answers.
const FAREWELL: Duration = Duration::from_millis(100);

/// Sender of the loop's last order.
pub(super) struct Writer<C> {
    socket: WebSocket<Half>,
    clock: C,
    commands: Commands,
    pace: Pace,
    link: Arc<Link>,
    orders: Output<Order>,
    /// Last sent message: the order's number, the force if one was commanded, and the time.
    order: u64,
    force: Option<Vector>,
    at: Instant,
    stall: Option<Stall>,
}

/// Stall of the service.
#[derive(Clone, Copy)]
struct Stall {
    since: Instant,
    /// Number of answers at its beginning.
    heard: u64,
}

/// Returns the loop's last order, and whether the force must be zero. The order is read last: otherwise an order from
/// before a cut could pass for the order that ended it.
fn look(link: &Link, read: impl FnOnce() -> Order) -> (Order, bool) {
    // A reason that ends by being reported has set the cut before.
    let is_unfit = link.unfit().is_some();
    let is_cut = link.is_cut();
    (read(), is_unfit || is_cut)
}

/// Message to send.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Probe,
    Force(Vector),
}

impl<C: Clock> Writer<C> {
    pub fn new(
        half: Half,
        clock: C,
        commands: Commands,
        pace: Pace,
        link: Arc<Link>,
        orders: Output<Order>,
    ) -> Self {
        Self {
            socket: half.into_writer(),
            clock,
            commands,
            pace,
            link,
            orders,
            order: 0,
            force: None,
            at: Instant::now(),
            stall: None,
        }
    }

    /// Sends until the device is released or the connection is lost. In each case the last message commands zero force,
    /// and the connection is closed.
    pub fn run(mut self) {
        while !self.link.is_ending() && !self.link.is_lost() {
            let wait = self.step(Instant::now());
            if !wait.is_zero() {
                thread::park_timeout(wait);
            }
        }
        if self.force.is_some_and(|force| force != NONE) || self.link.is_ending() {
            self.send(Wanted::Force(NONE), Instant::now());
        }
        self.wait_for_answers();
    }

    /// Sends a due message, and returns the time until the next one unless this thread is woken.
    fn step(&mut self, now: Instant) -> Duration {
        let (order, is_held_back) = look(&self.link, || *self.orders.read());
        let wanted = self.wanted(&order, is_held_back);
        let (owed, age) = self.link.owed(now);
        if owed == 0 {
            self.stall = None;
            let is_new = order.number != self.order || self.differs(wanted);
            let due = self.at + self.every(&order);
            if is_new || now >= due {
                self.order = order.number;
                self.send(wanted, now);
                return self.pace.reply_timeout;
            }
            return due - now;
        }
        // Zero force does not wait for an answer.
        if wanted == Wanted::Force(NONE) && self.force.is_some_and(|force| force != NONE) {
            self.send(wanted, now);
            return self.pace.reply_timeout;
        }
        if age <= self.pace.reply_timeout {
            return self.pace.reply_timeout - age + Duration::from_micros(1);
        }
        self.stalled(now, order.number > 0)
    }

    /// Handles an overdue answer. One more message, without a force, waits in the connection until the service
    /// continues. Afterwards nothing is sent until all answers have arrived or the missing ones are given up.
    fn stalled(&mut self, now: Instant, commanded: bool) -> Duration {
        let (heard, quiet) = self.link.heard(now);
        let Some(stall) = self.stall else {
            AtomicCounts::add(&self.link.counts.stalls);
            self.stall = Some(Stall { since: now, heard });
            let nothing = if commanded {
                Wanted::Force(NONE)
            } else {
                Wanted::Probe
            };
            self.send(nothing, now);
            return self.pace.reply_timeout;
        };
        let stood = now.saturating_duration_since(stall.since);
        if heard > stall.heard && quiet > self.pace.reply_timeout {
            self.link.write_off(heard);
            return Duration::ZERO;
        }
        if stood > self.pace.give_up_after {
            self.link.lose(Cause::Silent);
            return Duration::ZERO;
        }
        self.pace.reply_timeout
    }

    fn wanted(&self, order: &Order, is_held_back: bool) -> Wanted {
        if order.number == 0 {
            return Wanted::Probe;
        }
        let none = is_held_back || self.stall.is_some() || self.is_forsaken(order);
        Wanted::Force(if none { NONE } else { order.force })
    }

    /// Returns whether the loop has been silent for so long that its last order is no longer valid.
    fn is_forsaken(&self, order: &Order) -> bool {
        self.clock.now().saturating_sub(order.at) > self.pace.hold
    }

    fn differs(&self, wanted: Wanted) -> bool {
        match wanted {
            Wanted::Probe => false,
            Wanted::Force(force) => self.force != Some(force),
        }
    }

    /// Returns the interval of repeated messages.
    fn every(&self, order: &Order) -> Duration {
        if order.number == 0 || self.is_forsaken(order) {
            AT_REST
        } else {
            self.pace.exchange_every
        }
    }

    fn send(&mut self, wanted: Wanted, now: Instant) {
        let message = match wanted {
            Wanted::Probe => self.commands.probe(),
            Wanted::Force(force) => {
                self.force = Some(force);
                // Earlier checks reject non-finite forces; one that passed them must not become a command.
                self.commands
                    .force(force)
                    .unwrap_or_else(|_| self.commands.probe())
            }
        };
        self.at = now;
        self.link.sends(now);
        if self.socket.send(Message::text(message)).is_err() {
            self.link.lose(Cause::Cut);
        }
    }

    fn wait_for_answers(&mut self) {
        let until = Instant::now() + FAREWELL;
        while !self.link.is_lost() && self.link.owed(Instant::now()).0 > 0 {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            thread::park_timeout(left);
        }
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
    }
}

impl<C> Drop for Writer<C> {
    /// Closes the connection however the thread ends: without a connection the service releases the device.
    fn drop(&mut self) {
        let _ = self.socket.get_ref().stream().shutdown(Shutdown::Both);
        self.link.lose(Cause::Cut);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE: Order = Order {
        number: 1,
        force: [1.0, 0.0, 0.0],
        at: Duration::ZERO,
    };

    /// The loop's next order arrives, and ends the cut, just after the previous one was read.
    #[test]
    fn a_force_that_was_cut_is_not_put_on_again_by_the_order_behind_it() {
        let link = Link::new();
        link.cut();
        let read = || {
            link.uncut();
            FORCE
        };
        assert!(look(&link, read).1);
        assert!(!look(&link, || FORCE).1);
        // The same applies if the loop has just received the reason of a cut.
        link.was_unfit(Cause::Safety);
        let read = || {
            assert!(link.tell().is_some());
            link.uncut();
            FORCE
        };
        assert!(look(&link, read).1);
        assert!(!look(&link, || FORCE).1);
    }
}
