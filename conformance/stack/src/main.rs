//! Memory of a tick: the stack of a step and of a report, and the sizes of state and renderer, with a method known at
//! compile time and with any method.
//!
//! ```text
//! cargo run --release --manifest-path conformance/stack/Cargo.toml
//! ```
//!
//! The stack below the caller is painted before each tick; the lowest changed byte gives the depth. Ticks are those of
//! the paper's Fig. 2 loop: free, entering, in contact, leaving, with late samples, rejected samples and the longest
//! supported delay. Exits with 1 if a tick needs more than `MOST`.

use std::hint::black_box;
use std::process::ExitCode;
use std::thread;

use palpate::{
    Actuation, AnyParams, BasicParams, Contact, CoupledParams, Guard, GuardParams, HandBound,
    HfcrParams, LARGEST_DELAY, LoopParams, MethodParams, ObjectState, Phase, Renderer, Sample,
    Scalar,
};

/// Largest allowed stack of a tick [bytes].
const MOST: usize = 4608;
/// Painted depth [bytes], far more than a tick needs.
const PAINTED: usize = 64 * 1024;
/// Distance between a caller's own frame and the paint [bytes]: the frame of the painter.
const MARGIN: usize = 256;
/// Stack of the measuring thread [bytes].
const THREAD: usize = 1 << 20;
const COLOUR: u8 = 0xA5;

/// Returns the stack depth of `call` below its caller [bytes], at least [`MARGIN`].
#[inline(never)]
fn depth(call: &mut dyn FnMut()) -> usize {
    let here = black_box(0_u8);
    let base = std::ptr::from_ref(&here).expose_provenance();
    paint(base);
    call();
    base - lowest(base)
}

/// Paints the stack below `base`.
#[inline(never)]
fn paint(base: usize) {
    for address in base - PAINTED..base - MARGIN {
        let byte = std::ptr::with_exposed_provenance_mut::<u8>(address);
        // SAFETY: inside the stack of this thread, which has THREAD bytes and is almost unused, and below every live
        // frame: the frame of this function is smaller than MARGIN.
        unsafe { byte.write_volatile(COLOUR) };
    }
}

/// Returns the lowest address below `base` whose paint has changed.
#[inline(never)]
fn lowest(base: usize) -> usize {
    (base - PAINTED..base - MARGIN)
        .find(|&address| {
            let byte = std::ptr::with_exposed_provenance::<u8>(address);
            // SAFETY: as above, and painted, so initialised.
            unsafe { byte.read_volatile() != COLOUR }
        })
        .unwrap_or(base - MARGIN)
}

/// Memory of a renderer [bytes].
#[derive(Default)]
struct Needs {
    step: usize,
    report: usize,
    state: usize,
    renderer: usize,
    /// Whether free, contact, entering and leaving ticks occurred, so that the measurement is complete.
    seen: [bool; 4],
    /// Whether the method predicts entering and leaving.
    foresees: bool,
}

/// Runs a closed loop with a light device, and measures the memory of its ticks.
fn measured<S: Scalar, P: MethodParams<S> + Copy>(params: P, delay: f64, needs: &mut Needs) {
    let of = S::from_f64;
    let loop_params = LoopParams {
        actuation: Actuation {
            delay_deviation: of(1e-4),
            ..Actuation::after(of(delay * 0.01)).with_lag(of(1e-3))
        },
        guard: Guard::Report(GuardParams {
            recovery: of(0.01),
            hand: Some(HandBound::from_force(of(20.0), of(0.1))),
            ..GuardParams::by_speed(of(1.0), of(1e-3))
        }),
        ..LoopParams::new(of(0.01))
    };
    let contact = Contact::object(of(100.0), of(0.1));
    let renderer = Renderer::new(contact, loop_params, params).expect("the scene is sound");
    let mut state = renderer
        .start(ObjectState::at_rest(of(0.1)))
        .expect("the scene is sound");
    needs.state = size_of_val(&state);
    needs.renderer = size_of_val(&renderer);
    let (mut position, mut velocity) = (0.0, 0.0);
    for tick in 0..120 {
        let elapsed = if tick % 7 == 3 { 0.013 } else { 0.01 };
        let read = if tick == 60 { f64::NAN } else { position };
        let sample = Sample {
            device_position: of(read),
            elapsed: (tick > 0).then(|| of(elapsed)),
            virtual_force: of(-0.981),
        };
        let mut output = None;
        let step = depth(&mut || output = Some(renderer.step(&mut state, black_box(sample))));
        let output = output.expect("a step was taken");
        let report =
            depth(&mut || renderer.report_held(&mut state, black_box(output.force_on_object)));
        needs.step = needs.step.max(step);
        needs.report = needs.report.max(report);
        match output.phase {
            Phase::Free => needs.seen[0] = true,
            Phase::Contact => needs.seen[1] = true,
            Phase::Enters => needs.seen[2] = true,
            Phase::Leaves => needs.seen[3] = true,
            _ => {}
        }
        let acceleration = (0.981 + output.force_on_device.to_f64()) / 0.1;
        position += (velocity + 0.5 * acceleration * elapsed) * elapsed;
        velocity += acceleration * elapsed;
    }
}

impl Needs {
    fn are_of_every_phase(&self) -> bool {
        let seen = if self.foresees {
            &self.seen[..]
        } else {
            &self.seen[..2]
        };
        seen.iter().all(|seen| *seen)
    }
}

fn row<S: Scalar, P: MethodParams<S> + Copy>(name: &str, foresees: bool, params: P) -> Needs {
    let mut needs = Needs {
        foresees,
        ..Needs::default()
    };
    for delay in [0.0, 2.6, LARGEST_DELAY as f64] {
        measured::<S, P>(params, delay, &mut needs);
    }
    let stack = |depth: usize| match depth {
        0..=MARGIN => format!("up to {MARGIN}"),
        deeper => deeper.to_string(),
    };
    println!(
        "| {name} | {} | {} | {} | {} |",
        stack(needs.step),
        stack(needs.report),
        needs.state,
        needs.renderer
    );
    needs
}

fn both<S: Scalar>(precision: &str) -> Vec<Needs> {
    let hfcr = HfcrParams::with_damping(S::from_f64(0.02));
    let coupled = CoupledParams::new(S::from_f64(0.1));
    vec![
        row::<S, _>(&format!("basic, {precision}"), false, BasicParams),
        row::<S, _>(&format!("hfcr, {precision}"), true, hfcr),
        row::<S, _>(&format!("coupled, {precision}"), true, coupled),
        row::<S, _>(
            &format!("hfcr of any method, {precision}"),
            true,
            AnyParams::Hfcr(hfcr),
        ),
        row::<S, _>(
            &format!("coupled of any method, {precision}"),
            true,
            AnyParams::Coupled(coupled),
        ),
    ]
}

fn measure() -> ExitCode {
    let nothing = depth(&mut || {
        black_box(());
    });
    let known = depth(&mut || {
        black_box([0_u8; 3000]);
    });
    println!(
        "painted from {MARGIN} bytes down: nothing {nothing}, an array of 3000 bytes {known}\n"
    );
    println!("| bytes | step, stack | report_held, stack | state | renderer |");
    println!("|---|---:|---:|---:|---:|");
    let all: Vec<Needs> = both::<f64>("f64")
        .into_iter()
        .chain(both::<f32>("f32"))
        .collect();
    let deepest = all.iter().map(|needs| needs.step.max(needs.report)).max();
    let sound = nothing <= 2 * MARGIN
        && (3000..3000 + 4 * MARGIN).contains(&known)
        && all.iter().all(Needs::are_of_every_phase);
    if !sound {
        println!("\nFAILED: the measurement does not measure, or a phase was left out");
        return ExitCode::FAILURE;
    }
    match deepest {
        Some(deepest) if deepest <= MOST => ExitCode::SUCCESS,
        _ => {
            println!("\nFAILED: a tick needs more than {MOST} bytes of stack");
            ExitCode::FAILURE
        }
    }
}

fn main() -> ExitCode {
    thread::Builder::new()
        .stack_size(THREAD)
        .spawn(measure)
        .ok()
        .and_then(|thread| thread.join().ok())
        .unwrap_or(ExitCode::FAILURE)
}
