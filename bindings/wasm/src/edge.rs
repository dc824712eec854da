//! Functions for the host: numbers as arguments, and text through one input and one output buffer.
//!
//! A host calls [`palpate_input`] with the length of its text in bytes, writes the text to the returned address, and
//! calls a function. The function returns 0 on success and 1 on an error; the output has the result or the message.

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

/// Return code of a success.
const DONE: i32 = 0;
/// Return code of an error; the output is the message.
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

/// Calls `act` and stores its result in the output.
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

/// Returns an input buffer of this many bytes for the next call.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_input(bytes: usize) -> *mut u8 {
    EDGE.with_borrow_mut(|edge| {
        edge.input.clear();
        edge.input.resize(bytes, 0);
        edge.input.as_mut_ptr()
    })
}

/// Returns the address of the output, which is valid until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_output() -> *const u8 {
    EDGE.with_borrow(|edge| edge.output.as_ptr())
}

/// Returns the length of the output in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_output_bytes() -> usize {
    EDGE.with_borrow(|edge| edge.output.len())
}

/// Opens the scene in the input; the output is the greeting of [`palpate_live::message`].
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

/// Handles the message in the input; the output is the new state or the reason for rejecting the message.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_hear() -> i32 {
    with_playground(|playground, text| match playground.hear(text) {
        Ok(()) => Ok(playground.state().into_bytes()),
        Err(refused) => Err(refused.text()),
    })
}

/// Outputs the current rendering state.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_state() -> i32 {
    with_playground(|playground, _| Ok(playground.state().into_bytes()))
}

/// Advances all renderings to this time of their run `[s]` and returns the number of ticks. A limit of ticks per call
/// applies, so the time may not be reached.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_advance(until: f64) -> u32 {
    EDGE.with_borrow_mut(|edge| {
        edge.playground
            .as_mut()
            .map_or(0, |playground| playground.advance(until))
    })
}

/// Returns the time of the run that all renderings have reached `[s]`.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_time() -> f64 {
    EDGE.with_borrow(|edge| edge.playground.as_ref().map_or(0.0, Playground::time))
}

/// Outputs the new rows of a rendering as a frame of samples; empty if there are none.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_frame(lane: u32) -> i32 {
    with_playground(|playground, _| Ok(playground.frame(lane).unwrap_or_default()))
}

/// Outputs the messages since the last call, one per line.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_notes() -> i32 {
    with_playground(|playground, _| Ok(playground.take_notes().join("\n").into_bytes()))
}

/// Opens the world in the input with one rendering per method. The methods follow the text after a line with the
/// character 0. The output describes the objects to draw.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_open_world() -> i32 {
    answer(|edge| {
        edge.space = None;
        let (text, methods) = edge
            .text()?
            .split_once('\0')
            .ok_or("the list of methods after the world is missing")?;
        let methods: Vec<&str> = methods.split(',').collect();
        let space = Space::open(text, &methods)?;
        let drawn = space.drawn();
        edge.space = Some(space);
        Ok(drawn.into_bytes())
    })
}

/// Sets the target position of a device's hand in the world `[m]` for all renderings. Returns 1 if the device does not
/// exist or the position is invalid.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_lead(device: u32, x: f64, y: f64, z: f64) -> i32 {
    with_space(|space, _| space.lead(device, [x, y, z]).map(|()| Vec::new()))
}

/// Advances the world in all renderings to this time `[s]` and returns the number of ticks.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_advance_world(until: f64) -> u32 {
    EDGE.with_borrow_mut(|edge| edge.space.as_mut().map_or(0, |space| space.advance(until)))
}

/// Outputs the poses of all objects of the world.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_world() -> i32 {
    with_space(|space, _| Ok(space.now().into_bytes()))
}

/// Outputs the bits of every force that all methods command in the scene or world of the input.
#[cfg(feature = "numbers")]
#[unsafe(no_mangle)]
pub extern "C" fn palpate_numbers() -> i32 {
    answer(|edge| numbers(edge.text()?).map(String::into_bytes))
}
