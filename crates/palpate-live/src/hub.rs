//! Distribution of the session's messages to its clients: one queue per client, without blocking.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::mpsc;
use tokio_tungstenite::tungstenite::Utf8Bytes;

use crate::rows::Frame;

/// Most messages that wait for one client: two seconds of two lanes.
const QUEUE: usize = 256;
/// Places in it that samples leave to texts.
const KEPT_FOR_TEXT: usize = 64;

/// A client, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientId(u64);

/// Pending message to a client.
#[derive(Clone, Debug)]
pub enum Outgoing {
    /// A text message.
    Text(Utf8Bytes),
    /// A frame of samples and its number.
    Samples(u32, Arc<Frame>),
}

/// Receiving end of a client: its messages, and whether the hub has dropped it for being too slow.
#[derive(Debug)]
pub struct Seat {
    /// Identity of the client.
    pub id: ClientId,
    /// Pending messages.
    pub queue: mpsc::Receiver<Outgoing>,
    /// Raised when not even a text finds room any more.
    pub is_given_up: Arc<AtomicBool>,
}

#[derive(Debug)]
struct Client {
    id: ClientId,
    queue: mpsc::Sender<Outgoing>,
    /// Number of the next frame of each rendering.
    frames: [u32; 2],
    is_given_up: Arc<AtomicBool>,
}

#[derive(Debug, Default)]
struct Inner {
    clients: Vec<Client>,
    hello: Utf8Bytes,
    state: Utf8Bytes,
}

/// All connected clients.
#[derive(Debug, Default)]
pub struct Hub {
    inner: Mutex<Inner>,
    next: AtomicU64,
}

impl Hub {
    /// Adds a client; its first messages are the greeting and the state.
    pub fn join(&self) -> Seat {
        let (queue, receiver) = mpsc::channel(QUEUE);
        let id = ClientId(self.next.fetch_add(1, Ordering::Relaxed));
        let is_given_up = Arc::new(AtomicBool::new(false));
        let mut inner = self.lock();
        for text in [&inner.hello, &inner.state] {
            if !text.is_empty() {
                // The queue is empty yet.
                let _ = queue.try_send(Outgoing::Text(text.clone()));
            }
        }
        inner.clients.push(Client {
            id,
            queue,
            frames: [0; 2],
            is_given_up: Arc::clone(&is_given_up),
        });
        Seat {
            id,
            queue: receiver,
            is_given_up,
        }
    }

    /// Removes a client.
    pub fn leave(&self, id: ClientId) {
        self.lock().clients.retain(|client| client.id != id);
    }

    /// Sets the greeting for new clients, and sends it to the present ones.
    pub fn set_hello(&self, text: String) {
        let mut inner = self.lock();
        if inner.hello.as_str() != text {
            inner.hello = text.into();
            let hello = inner.hello.clone();
            inner.tell_all(&hello);
        }
    }

    /// Sets the state for new clients, and sends it to the present ones.
    pub fn set_state(&self, text: String) {
        let mut inner = self.lock();
        if inner.state.as_str() != text {
            inner.state = text.into();
            let state = inner.state.clone();
            inner.tell_all(&state);
        }
    }

    /// A text for all.
    pub fn tell_all(&self, text: String) {
        self.lock().tell_all(&text.into());
    }

    /// Sends a text that contains the number of clients. The number includes dropped clients that have not left yet.
    /// The lock is held meanwhile, so every recipient is counted.
    pub fn tell_all_counted(&self, text: impl FnOnce(usize) -> String) {
        let inner = self.lock();
        inner.tell_all(&text(inner.clients.len()).into());
    }

    /// A text for one.
    pub fn tell(&self, id: ClientId, text: String) {
        let text = Utf8Bytes::from(text);
        for client in self.lock().clients.iter().filter(|client| client.id == id) {
            client.tell(&text);
        }
    }

    /// Sends a frame to all clients. A client without space in its queue detects the gap in the frame numbers.
    pub fn show(&self, frame: Frame) {
        let frame = Arc::new(frame);
        for client in &mut self.lock().clients {
            let Some(next) = client.frames.get_mut(usize::from(frame.lane)) else {
                continue;
            };
            let number = *next;
            *next = next.wrapping_add(1);
            if client.queue.capacity() > KEPT_FOR_TEXT {
                let frame = Arc::clone(&frame);
                let _ = client.queue.try_send(Outgoing::Samples(number, frame));
            }
        }
    }

    /// Closes all clients' queues.
    pub fn close(&self) {
        self.lock().clients.clear();
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Inner> {
        // A panic leaves the list of clients valid.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn tell_all(&self, text: &Utf8Bytes) {
        for client in &self.clients {
            client.tell(text);
        }
    }
}

impl Client {
    /// A client that misses a text would show what is not so: it is given up.
    fn tell(&self, text: &Utf8Bytes) {
        if self.queue.try_send(Outgoing::Text(text.clone())).is_err() {
            self.is_given_up.store(true, Ordering::Release);
        }
    }
}

#[cfg(test)]
mod tests {
    use palpate_record::recording::Row;

    use super::*;
    use crate::rows::Rows;

    fn clients(hub: &Hub) -> usize {
        hub.lock().clients.len()
    }

    fn frame() -> Frame {
        let mut rows = Rows::new(0.001);
        rows.add(&Row::default());
        rows.take_frame(0, 0).unwrap()
    }

    /// A slow client loses samples, detectable by their numbers, and no text; the others lose nothing.
    #[test]
    fn a_slow_client_loses_frames_by_number_and_never_a_text() {
        let hub = Hub::default();
        hub.set_hello("hello".into());
        let (mut slow, mut quick) = (hub.join(), hub.join());
        for _ in 0..1000 {
            hub.show(frame());
            while quick.queue.try_recv().is_ok() {}
        }
        for number in 0..40 {
            hub.tell_all(format!("text {number}"));
        }
        assert_eq!(clients(&hub), 2);
        let (mut texts, mut numbers) = (Vec::new(), Vec::new());
        while let Ok(message) = slow.queue.try_recv() {
            match message {
                Outgoing::Text(text) => texts.push(text.to_string()),
                Outgoing::Samples(number, _) => numbers.push(number),
            }
        }
        assert_eq!(texts.len(), 41, "{texts:?}");
        assert_eq!(numbers, (0..191).collect::<Vec<_>>());
        hub.show(frame());
        let next = slow.queue.try_recv().unwrap();
        assert!(matches!(next, Outgoing::Samples(1000, _)), "{next:?}");
    }

    #[test]
    fn a_client_without_room_for_a_text_is_given_up() {
        let hub = Hub::default();
        let (slow, mut quick) = (hub.join(), hub.join());
        for number in 0..=QUEUE {
            assert!(!slow.is_given_up.load(Ordering::Acquire), "{number}");
            hub.tell_all("note".into());
            assert!(quick.queue.try_recv().is_ok());
        }
        assert!(slow.is_given_up.load(Ordering::Acquire));
        assert!(!quick.is_given_up.load(Ordering::Acquire));
        assert_eq!(clients(&hub), 2);
        hub.leave(slow.id);
        assert_eq!(clients(&hub), 1);
    }

    /// A client that receives the number of clients is counted, even if it joins at that moment.
    #[test]
    fn client_that_receives_the_count_is_included_in_it() {
        let hub = Hub::default();
        let is_over = AtomicBool::new(false);
        let heard: Vec<_> = std::thread::scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(Ordering::Acquire) {
                    hub.tell_all_counted(|count| count.to_string());
                }
            });
            let come_and_go = |_| {
                let mut seat = hub.join();
                let heard = seat.queue.blocking_recv();
                hub.leave(seat.id);
                heard
            };
            let heard = (0..300).map(come_and_go).collect();
            is_over.store(true, Ordering::Release);
            heard
        });
        for message in heard {
            assert!(
                matches!(&message, Some(Outgoing::Text(text)) if text.as_str() == "1"),
                "{message:?}"
            );
        }
    }

    #[test]
    fn late_client_receives_the_current_state() {
        let hub = Hub::default();
        hub.set_hello("hello".into());
        hub.set_state("first".into());
        hub.set_state("second".into());
        let mut late = hub.join();
        hub.set_state("second".into());
        let mut texts = Vec::new();
        while let Ok(Outgoing::Text(text)) = late.queue.try_recv() {
            texts.push(text.to_string());
        }
        assert_eq!(texts, ["hello", "second"]);
    }
}
