//! What a host calls: numbers, and text through one buffer in and one out.
//!
//! A host asks for [`palpate_input`] of as many bytes as its text has, writes the text there, and calls. A call returns
//! 0 if it has done what was asked and 1 if not; what it has to say stands in the output then, in both cases.

#![allow(
    unsafe_code,
    reason = "names that a host finds are not mangled; there is no other unsafe code"
)]

use std::cell::RefCell;

#[cfg(feature = "numbers")]
use crate::numbers;
use crate::{Playground, Space};

#[derive(Default)]
struct Edge {
    input: Vec<u8>,
    output: Vec<u8>,
    playground: Option<Playground>,
    space: Option<Space>,
}

thread_local! {
    static EDGE: RefCell<Edge> = RefCell::default();
}

/// It did what was asked.
const DONE: i32 = 0;
/// It did not: the output says why.
const REFUSED: i32 = 1;

const NOTHING_OPEN: &str = "nothing is open: open a scene first";

impl Edge {
    fn answer(&mut self, answer: Result<Vec<u8>, String>) -> i32 {
        match answer {
            Ok(bytes) => {
                self.output = bytes;
                DONE
            }
            Err(text) => {
                self.output = text.into_bytes();
                REFUSED
            }
        }
    }

    fn text(&self) -> Result<&str, String> {
        std::str::from_utf8(&self.input).map_err(|error| format!("the text is not UTF-8: {error}"))
    }
}

/// Calls `act`, and keeps its answer for the host.
fn answer(act: impl FnOnce(&mut Edge) -> Result<Vec<u8>, String>) -> i32 {
    EDGE.with_borrow_mut(|edge| {
        let answered = act(edge);
        edge.answer(answered)
    })
}

fn with_playground(act: impl FnOnce(&mut Playground, &str) -> Result<Vec<u8>, String>) -> i32 {
    answer(|edge| {
        let text = edge.text()?.to_owned();
        act(edge.playground.as_mut().ok_or(NOTHING_OPEN)?, &text)
    })
}

fn with_space(act: impl FnOnce(&mut Space, &str) -> Result<Vec<u8>, String>) -> i32 {
    answer(|edge| {
        let text = edge.text()?.to_owned();
        act(edge.space.as_mut().ok_or(NOTHING_OPEN)?, &text)
    })
}

/// Room for a text of so many bytes, for the next call.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_input(bytes: usize) -> *mut u8 {
    EDGE.with_borrow_mut(|edge| {
        edge.input.clear();
        edge.input.resize(bytes, 0);
        edge.input.as_mut_ptr()
    })
}

/// Where the answer of the last call stands, until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_output() -> *const u8 {
    EDGE.with_borrow(|edge| edge.output.as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_output_bytes() -> usize {
    EDGE.with_borrow(|edge| edge.output.len())
}

/// Opens the scene whose text is the input; the answer is the greeting, as [`palpate_scope::message`] has it.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_open() -> i32 {
    answer(|edge| {
        edge.playground = None;
        let playground = Playground::open(edge.text()?)?;
        let hello = playground.hello();
        edge.playground = Some(playground);
        Ok(hello.into_bytes())
    })
}

/// Does what the message in the input asks for; the answer is the state then, or a refusal.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_hear() -> i32 {
    with_playground(|playground, text| match playground.hear(text) {
        Ok(()) => Ok(playground.state().into_bytes()),
        Err(refused) => Err(refused.text()),
    })
}

/// What is rendered now.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_state() -> i32 {
    with_playground(|playground, _| Ok(playground.state().into_bytes()))
}

/// Ticks all lanes until they have reached this time of their run `[s]`; how many ticks that took. Less is reached
/// where more ticks would be needed than one call makes.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_advance(until: f64) -> u32 {
    EDGE.with_borrow_mut(|edge| {
        edge.playground
            .as_mut()
            .map_or(0, |playground| playground.advance(until))
    })
}

/// Time of the run that all lanes have reached `[s]`.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_time() -> f64 {
    EDGE.with_borrow(|edge| edge.playground.as_ref().map_or(0.0, Playground::time))
}

/// The rows of a lane that have not been taken yet, as a frame of samples; none if there are none.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_frame(lane: u32) -> i32 {
    with_playground(|playground, _| Ok(playground.frame(lane).unwrap_or_default()))
}

/// What has happened since this was asked last: messages, one on a line.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_notes() -> i32 {
    with_playground(|playground, _| Ok(playground.take_notes().join("\n").into_bytes()))
}

/// Opens the world whose text is the input, with a lane for each of the methods that follow the text after a line of
/// the character 0; the answer says what there is to draw.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_open_world() -> i32 {
    answer(|edge| {
        edge.space = None;
        let (text, methods) = edge
            .text()?
            .split_once('\0')
            .ok_or("after the world there is no list of methods")?;
        let methods: Vec<&str> = methods.split(',').collect();
        let space = Space::open(text, &methods)?;
        let drawn = space.drawn();
        edge.space = Some(space);
        Ok(drawn.into_bytes())
    })
}

/// Leads the hand of a device to a place of the world `[m]`, in all lanes. Returns 1 if there is no such device or the
/// place is none.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_lead(device: u32, x: f64, y: f64, z: f64) -> i32 {
    with_space(|space, _| space.lead(device, [x, y, z]).map(|()| Vec::new()))
}

/// Ticks the world in all lanes until this time `[s]`; how many ticks that took.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_advance_world(until: f64) -> u32 {
    EDGE.with_borrow_mut(|edge| edge.space.as_mut().map_or(0, |space| space.advance(until)))
}

/// Where everything in the world is.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world() -> i32 {
    with_space(|space, _| Ok(space.now().into_bytes()))
}

/// Every force that all methods command in the scene or the world of the input, as bits.
#[cfg(feature = "numbers")]
#[unsafe(no_mangle)]
pub extern "C" fn palpate_numbers() -> i32 {
    answer(|edge| numbers(edge.text()?).map(String::into_bytes))
}
