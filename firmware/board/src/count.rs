#![no_std]
#![no_main]
//! Counts instructions and stack of every tick of the committed trace, by both methods on both contacts, and
//! of a knob's tick. Run it with `-icount shift=8`: see `clock`.
//!
//! Lines: `count NAME TICK PHASE INSTRUCTIONS STACK`, and `bytes NAME STATE RENDERER`.

mod clock;
mod emulator;
mod stack;

use core::fmt::{self, Write};
use core::hint::black_box;

use clock::Clock;
use cortex_m_rt::entry;
use emulator::{Lines, exit};
use palpate::{
    Contact, CoupledParams, HfcrParams, Method, MethodParams, Output, Renderer, Sample, State,
};
use palpate_firmware_knob::{Answer, Knob};
use palpate_firmware_trace as trace;

#[path = "example.rs"]
mod example;
#[path = "emulated/handle.rs"]
mod handle;

/// One tick, as called by a program without inlining.
#[inline(never)]
fn step<M: Method<f32>>(
    renderer: &Renderer<f32, M>,
    state: &mut State<f32, M::Memory>,
    sample: Sample<f32>,
) -> Output<f32> {
    renderer.step(state, sample)
}

fn count<P: MethodParams<f32>>(
    clock: &Clock,
    name: &str,
    contact: Contact<f32>,
    params: P,
    out: &mut Lines,
) -> fmt::Result {
    let renderer = Renderer::new(contact, trace::loop_params(), params).map_err(|_| fmt::Error)?;
    let mut state = renderer
        .start(trace::start(&contact))
        .map_err(|_| fmt::Error)?;
    writeln!(
        out,
        "bytes {name} {} {}",
        size_of_val(&state),
        size_of_val(&renderer)
    )?;
    for (tick, sample) in trace::samples().enumerate() {
        let mut again = state;
        let mut output = None;
        let sample = black_box(sample);
        let instructions = clock.instructions(|| {
            output = Some(step(&renderer, &mut again, sample));
        });
        let stack = stack::depth(&mut || {
            black_box(step(&renderer, &mut state, sample));
        });
        let phase = output.map_or("none", |output| output.phase.name());
        writeln!(out, "count {name} {tick} {phase} {instructions} {stack}")?;
    }
    Ok(())
}

#[inline(never)]
fn knob_tick<P: MethodParams<f32>>(knob: &mut Knob<P>, count: u16) -> Answer {
    knob.tick(count, false)
}

/// Counts the whole tick of a knob whose handle repeatedly hits its wall.
fn count_knob<P: MethodParams<f32> + Copy>(
    clock: &Clock,
    name: &str,
    method: P,
    out: &mut Lines,
) -> fmt::Result {
    let mut knob = Knob::new(example::PARAMS, method).map_err(|_| fmt::Error)?;
    let mut handle = handle::Handle::default();
    let mut duty = 0;
    for tick in 0..800 {
        let seen = black_box(handle.count());
        let mut again = Knob::clone(&knob);
        let mut answer = None;
        let instructions = clock.instructions(|| {
            answer = Some(knob_tick(&mut again, seen));
        });
        let stack = stack::depth(&mut || {
            black_box(knob_tick(&mut knob, seen));
        });
        let Some(answer) = answer else {
            return Err(fmt::Error);
        };
        let phase = if answer.duty == 0 { "free" } else { "contact" };
        writeln!(out, "count {name} {tick} {phase} {instructions} {stack}")?;
        // The duty acts from the next tick on.
        for _ in 0..5 {
            handle.resume(example::PARAMS.drive.force(duty), 1.0);
        }
        duty = answer.duty;
    }
    Ok(())
}

/// Error bound of a count: instructions that the compiler puts between two readings of the timer.
const WITHIN: u32 = 2;

/// Checks the clock and the paint against known counts and depths.
fn measures(clock: &Clock) -> bool {
    macro_rules! ten {
        ($call:expr) => {
            $call;
            $call;
            $call;
            $call;
            $call;
            $call;
            $call;
            $call;
            $call;
            $call;
        };
    }
    let hundred = clock.instructions(|| {
        ten!({
            ten!(cortex_m::asm::nop());
        });
    });
    let nothing = clock.instructions(|| {});
    let array = stack::depth(&mut || {
        black_box([0_u8; 3000]);
    });
    let known = (100 - WITHIN..=100 + WITHIN).contains(&hundred) && nothing <= WITHIN;
    known && (3000..3200).contains(&array)
}

fn all(clock: &Clock) -> fmt::Result {
    let mut out = Lines::default();
    let (hfcr, coupled) = (trace::hfcr(), trace::coupled());
    count(clock, "hfcr-block", trace::block(), hfcr, &mut out)?;
    count(clock, "hfcr-wall", trace::wall(), hfcr, &mut out)?;
    count(clock, "coupled-block", trace::block(), coupled, &mut out)?;
    count(clock, "coupled-wall", trace::wall(), coupled, &mut out)?;
    let knob_hfcr: HfcrParams<f32> = HfcrParams::default();
    let knob_coupled: CoupledParams<f32> = example::coupled();
    count_knob(clock, "hfcr-knob", knob_hfcr, &mut out)?;
    count_knob(clock, "coupled-knob", knob_coupled, &mut out)
}

#[entry]
fn main() -> ! {
    let Some(core) = cortex_m::Peripherals::take() else {
        exit(false)
    };
    let clock = Clock::start(core.SYST);
    exit(measures(&clock) && all(&clock).is_ok())
}
