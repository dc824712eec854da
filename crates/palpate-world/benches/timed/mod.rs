//! Times every tick of a run, and prints a summary line.

use std::time::Instant;

use palpate_world::{
    Output, Quaternion, Sample, Vector, WorldLoop, WorldMethod, WorldRenderer, WorldState,
};

/// Sample period of all benchmarks `[s]`.
pub const PERIOD: f64 = 0.001;
const TICKS: usize = 3000;
const RUNS: usize = 5;
/// Ticks and runs with `--count`, under a tool that counts instructions.
const COUNTED: (usize, usize) = (500, 1);
/// Quantum of the device's position sensor `[m]`.
const QUANTUM: f64 = 2e-6;

/// A device under held forces; each run has its own.
pub trait Held {
    /// Returns the tool position `[m]`, and its orientation if it is measured.
    fn place(&self) -> (Vector, Option<Quaternion>);
    /// Advances by a period under the commands of the renderer; `time` is the time of the tick `[s]`.
    fn hold(&mut self, output: &Output, time: f64);
}

/// Prints the column headings.
pub fn print_heading() {
    println!(
        "microseconds per tick: median, p99, max; sub-steps per tick: median, p99, max; ticks in contact; features left out; checksum of all ticks"
    );
}

/// Renders `world` by `method` on a device in several identical runs, and prints the minimum time of each tick.
pub fn print_ticks<D: Held>(
    name: &str,
    world: &palpate_world::World,
    method: &WorldMethod,
    start: impl Fn() -> D,
) {
    let renderer = match WorldRenderer::new(world, WorldLoop::new(PERIOD), method.clone()) {
        Ok(renderer) => renderer,
        Err(fault) => {
            println!("{name}: refused: {fault:?}");
            return;
        }
    };
    let is_counted = std::env::args().any(|argument| argument == "--count");
    let (ticks, runs) = if is_counted { COUNTED } else { (TICKS, RUNS) };
    let mut times = vec![f64::INFINITY; ticks];
    let mut steps = vec![0; ticks];
    let (mut touched, mut left_out) = (0, 0);
    let mut checksum = 0;
    for run in 0..runs {
        let mut state = renderer.start();
        let mut device = start();
        touched = 0;
        for (tick, (time, steps)) in times.iter_mut().zip(&mut steps).enumerate() {
            let (position, orientation) = device.place();
            let positions = [position.map(|x| (x / QUANTUM).round() * QUANTUM)];
            let orientations = [orientation.unwrap_or([1.0, 0.0, 0.0, 0.0])];
            let mut sample = Sample::at(&positions);
            if orientation.is_some() {
                sample = sample.turned(&orientations);
            }
            let before = Instant::now();
            let output = renderer.step(&mut state, &sample);
            *time = time.min(before.elapsed().as_secs_f64() * 1e6);
            *steps = output.effort.sub_steps;
            left_out = left_out.max(output.effort.left_out);
            touched += usize::from(output.forces[0] != [0.0; 3]);
            device.hold(&output, tick as f64 * PERIOD);
            if run == 0 {
                checksum = mixed(checksum, &state);
            }
        }
    }
    times.sort_by(f64::total_cmp);
    steps.sort_unstable();
    let at = |part: usize| (ticks - 1) * part / 100;
    println!(
        "{name:28} {:8.2} {:8.2} {:8.2}   {:5} {:5} {:5}   {:3} %   {left_out}   {checksum:016x}",
        times[at(50)],
        times[at(99)],
        times[at(100)],
        steps[at(50)],
        steps[at(99)],
        steps[at(100)],
        100 * touched / ticks
    );
}

/// Returns a checksum that includes the numbers of a state. Equal checksums show that a change altered no number.
fn mixed(checksum: u64, state: &WorldState) -> u64 {
    let tools = state
        .tools()
        .iter()
        .map(|tool| [tool.force, tool.torque, tool.offset]);
    let bodies = state
        .bodies()
        .iter()
        .map(|body| [body.position, body.velocity, body.angular_velocity]);
    let ledger = state.ledger();
    let contacts = state.near_contacts().iter().map(|&number| {
        let (contact, entry) = (&state.contacts()[number], &ledger.contacts[number]);
        let lost = [entry.dissipated, entry.held, entry.step_error];
        [contact.force, contact.bristle, lost]
    });
    let gained = ledger.bodies.iter();
    let gained = gained.map(|entry| [entry.work, entry.potential, entry.step_error]);
    let each = tools.chain(bodies).chain(contacts).flatten().chain(gained);
    // Adding 0 removes the sign of a zero. The mixing is FNV-1a with words in place of bytes.
    let bits = each.flatten().map(|number| (number + 0.0).to_bits());
    bits.fold(checksum, |sum, bits| {
        (sum ^ bits).wrapping_mul(0x0100_0000_01b3).rotate_left(29)
    })
}
