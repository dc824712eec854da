//! Lines in a world: with devices known exactly they follow the ideal in position too, and reach the bound of lines.

use palpate_core::Actuation;
use palpate_world::{
    BasicParams, ContactLaw, CoupledParams, HfcrParams, Sample, Vector, WorldField, WorldGuard,
    WorldGuardParams, WorldLoop, WorldMethod, WorldRenderer,
};

use crate::floor::{Case, DEVICE, as_world, cases, exact, fine, free_ball, tool};
use crate::ideal::{Ideal, dot};

/// Parts of a period in which the reference forces are compared.
const PARTS: usize = 8;

fn minus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

/// Errors of a loop, in percent of the reference forces, and lengths in metres.
#[derive(Debug)]
struct Errors {
    /// Of the means over the periods.
    mean: f64,
    /// Of the forces over the parts of the periods.
    force: f64,
    /// The same of the best lines, or of the best constants.
    bound: f64,
    /// Largest distance of a device from that of the reference at a sample.
    off: f64,
    /// Port work of the ledger minus the work of the held forces, over the largest work.
    work: f64,
}

/// Moves devices under lines and returns the work on them.
fn hold(tools: &mut Ideal, forces: &[Vector], slopes: &[Vector], h: f64) -> f64 {
    const STEPS: usize = 40;
    let own: Vec<Vector> = tools.balls.iter().map(|ball| ball.force).collect();
    let step = h / STEPS as f64;
    let mut work = 0.0;
    for number in 0..STEPS {
        let since_middle = (number as f64 + 0.5) * step - 0.5 * h;
        let now: Vec<Vector> = (forces.iter().zip(slopes))
            .map(|(force, slope)| [0, 1, 2].map(|axis| force[axis] + slope[axis] * since_middle))
            .collect();
        let before: Vec<Vector> = tools.balls.iter().map(|ball| ball.position).collect();
        for ((ball, own), now) in tools.balls.iter_mut().zip(&own).zip(&now) {
            ball.force = [0, 1, 2].map(|axis| own[axis] + now[axis]);
        }
        tools.advance(step);
        for ((ball, before), now) in tools.balls.iter().zip(before).zip(&now) {
            work += dot(*now, minus(ball.position, before));
        }
    }
    for (ball, own) in tools.balls.iter_mut().zip(own) {
        ball.force = own;
    }
    work
}

fn errors(case: &Case, loop_params: WorldLoop, method: CoupledParams) -> Errors {
    let holds_lines = !loop_params.actuation.hold.is_constant();
    let (period, delay) = (loop_params.period, loop_params.actuation.delay);
    let waiting = (delay / period).round() as usize;
    let renderer =
        WorldRenderer::new(&as_world(&case.ideal, case.law), loop_params, method).unwrap();
    let mut state = renderer.start();
    let mut ideal = case.ideal.clone();
    let tools = ideal.balls.iter().filter(|ball| ball.is_tool).copied();
    let mut devices = Ideal::new(tools.collect(), Vec::new(), ideal.law);
    let count = devices.balls.len();
    let nothing = (vec![[0.0; 3]; count], vec![[0.0; 3]; count]);
    let mut queue = vec![nothing; waiting];
    let (mut mean, mut force, mut bound, mut all) = (0.0, 0.0, 0.0, 0.0);
    let (mut off, mut work, mut most) = (0.0_f64, 0.0, 0.0_f64);
    let h = period / PARTS as f64;
    for _ in 0..(f64::from(case.milliseconds) * 1e-3 / period) as usize {
        let positions: Vec<Vector> = devices.balls.iter().map(|ball| ball.position).collect();
        for (device, ideal) in positions.iter().zip(&ideal.balls) {
            let away = minus(*device, ideal.position);
            off = off.max(dot(away, away).sqrt());
        }
        let output = renderer.step(&mut state, &Sample::at(&positions));
        assert_eq!(output.fault, None);
        queue.push((output.forces.to_vec(), output.slopes.to_vec()));
        let (forces, slopes) = queue.remove(0);
        let parts: Vec<Vec<Vector>> = (0..PARTS)
            .map(|_| ideal.interval_in(h, 200 / PARTS).0)
            .collect();
        for tool in 0..count {
            for axis in 0..3 {
                let values: Vec<f64> = parts.iter().map(|forces| forces[tool][axis]).collect();
                let at = |part: usize| (part as f64 + 0.5) * h - 0.5 * period;
                let best = values.iter().sum::<f64>() / PARTS as f64;
                let moment: f64 = (0..PARTS).map(|part| values[part] * at(part)).sum();
                let square: f64 = (0..PARTS).map(|part| at(part) * at(part)).sum();
                let steepest = if holds_lines { moment / square } else { 0.0 };
                mean += (forces[tool][axis] - best).powi(2) * period;
                for (part, value) in values.iter().enumerate() {
                    let held = forces[tool][axis] + slopes[tool][axis] * at(part);
                    force += (held - value).powi(2) * h;
                    bound += (best + steepest * at(part) - value).powi(2) * h;
                    all += value * value * h;
                }
            }
        }
        work += hold(&mut devices, &forces, &slopes, period);
        most = most.max(work.abs());
    }
    let positions: Vec<Vector> = devices.balls.iter().map(|ball| ball.position).collect();
    let _ = renderer.step(&mut state, &Sample::at(&positions));
    let port: f64 = state
        .ledger()
        .devices
        .iter()
        .map(|entry| entry.port_work)
        .sum();
    let percent = |sum: f64| 100.0 * (sum / all).sqrt();
    Errors {
        mean: percent(mean),
        force: percent(force),
        bound: percent(bound),
        off,
        work: (port - work).abs() / most,
    }
}

/// The worlds of the bound of constants, and a ball between two devices.
fn all(law: ContactLaw) -> Vec<Case> {
    let mut all = Vec::from(cases(law));
    let law_of = all[0].ideal.law;
    let pressing = vec![
        tool([-0.03, 0.0, 0.0], [1.2, 0.0, 0.0]),
        tool([0.03, 0.001, 0.0], [-1.0, 0.0, 0.1]),
        free_ball([0.0, 0.0, 0.001], 0.06, 0.02, false),
    ];
    all.push(Case {
        ideal: Ideal::new(pressing, Vec::new(), law_of),
        law,
        milliseconds: 200,
    });
    all
}

fn tools(case: &Case) -> usize {
    case.ideal.balls.iter().filter(|ball| ball.is_tool).count()
}

/// Returns coupled rendering with exact knowledge of all devices.
fn known(case: &Case) -> CoupledParams {
    CoupledParams {
        device_mass: vec![DEVICE; tools(case)],
        ..exact()
    }
}

fn with_line(period: f64, delay: usize) -> WorldLoop {
    let actuation = Actuation::after_samples(delay, period).with_line();
    fine(WorldLoop::new(period).with_actuation(actuation))
}

// 10 s: the reference takes 200 steps in a period.
#[test]
fn lines_of_known_devices_reach_their_bound_and_the_ideals_positions() {
    let plain = ContactLaw::spring(4000.0);
    let smooth = plain.with_damping(1.0);
    for (name, law, loops) in [
        ("spring", plain, &[(0.004, 0)][..]),
        (
            "friction",
            smooth.with_friction(0.4),
            &[(0.001, 0), (0.001, 1)],
        ),
    ] {
        for &(period, delay) in loops {
            for (number, case) in all(law).iter().enumerate() {
                let line = errors(case, with_line(period, delay), known(case));
                let constant =
                    WorldLoop::new(period).with_actuation(Actuation::after_samples(delay, period));
                let constant = errors(case, fine(constant), known(case));
                println!(
                    "{name}, {period} s, delay {delay}, world {number}: line {line:.4?}, constant {constant:.4?}"
                );
                assert!(line.mean < 0.02, "{line:?}");
                assert!(line.force < line.bound + 0.002, "{line:?}");
                assert!(line.bound < 0.7 * constant.bound, "{line:?} {constant:?}");
                assert!(line.off < 0.05 * constant.off, "{line:?} {constant:?}");
                assert!(line.work < 1e-4, "{line:?}");
            }
        }
    }
}

#[test]
fn a_wrong_mass_costs_less_than_a_constant_hold() {
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    for factor in [1.5, 0.67] {
        for case in all(law) {
            let model = || CoupledParams::new(vec![DEVICE.map(|mass| factor * mass); tools(&case)]);
            let line = errors(&case, with_line(0.001, 0), model());
            let constant = errors(&case, fine(WorldLoop::new(0.001)), model());
            println!("{factor} times the mass: line {line:.3?}, constant {constant:.3?}");
            assert!(line.force < constant.force, "{line:?} {constant:?}");
        }
    }
}

#[test]
fn both_ends_of_a_line_are_within_the_force_limit() {
    let law = ContactLaw::spring(4000.0);
    let case = &cases(law)[0];
    let ends = |limit: f64| {
        let loop_params = with_line(0.004, 0).with_force_limits(vec![limit]);
        let world = as_world(&case.ideal, case.law);
        let renderer = WorldRenderer::new(&world, loop_params, exact()).unwrap();
        let mut state = renderer.start();
        let tools = case.ideal.balls.iter().filter(|ball| ball.is_tool).copied();
        let mut device = Ideal::new(tools.collect(), Vec::new(), case.ideal.law);
        let (mut most, mut sloped) = (0.0_f64, 0);
        for _ in 0..50 {
            let output = renderer.step(&mut state, &Sample::at(&[device.balls[0].position]));
            let (force, slope) = (output.forces[0], output.slopes[0]);
            for sign in [-0.002, 0.002] {
                let end = [0, 1, 2].map(|axis| force[axis] + sign * slope[axis]);
                most = most.max(dot(end, end).sqrt());
            }
            sloped += usize::from(slope != [0.0; 3]);
            hold(&mut device, &[force], &[slope], 0.004);
        }
        assert!(sloped > 5);
        most
    };
    let free = ends(1e3);
    let limited = ends(0.6 * free);
    println!("ends up to {free} N, limited {limited} N");
    assert!(limited <= 0.6 * free * (1.0 + 1e-9) && limited > 0.55 * free);
}

#[test]
fn what_a_line_excludes_in_a_world_is_refused_by_name() {
    let law = ContactLaw::spring(1000.0);
    let world = as_world(&cases(law)[0].ideal, law);
    let refused = |world: &palpate_world::World, loop_params: WorldLoop, method: WorldMethod| {
        let faults = WorldRenderer::new(world, loop_params, method).unwrap_err();
        let first = faults.first();
        assert_eq!(first.field, WorldField::Actuation, "{faults:?}");
        first.to_string()
    };
    let line = || with_line(0.001, 0);
    let damped = BasicParams {
        damping: vec![1.0],
        ..BasicParams::default()
    };
    let with_dissipation = HfcrParams {
        damping: vec![1.0],
        ..HfcrParams::default()
    };
    for (name, method) in [
        ("basic", WorldMethod::from(BasicParams::default())),
        ("virtual-damper", damped.into()),
        ("hfcr-mod", HfcrParams::modified_force_only().into()),
        ("hfcr-mod-st", HfcrParams::default().into()),
        ("hfcr", with_dissipation.into()),
    ] {
        let message = refused(&world, line(), method);
        assert!(
            message.contains(&format!("but {name} plans constants")),
            "{message}"
        );
    }
    let guarded = line().with_guard(WorldGuard::Report(WorldGuardParams::by_speed(
        1.0, 10.0, 0.05,
    )));
    let message = refused(&world, guarded, exact().into());
    assert!(message.contains("the guard bounds constants"), "{message}");
    let mut turning = world.clone();
    turning.tools[0].turns = true;
    let message = refused(&turning, line(), exact().into());
    assert!(
        message.contains("turns") && message.contains("loop.hold"),
        "{message}"
    );
    let late = line().with_actuation(Actuation::default().with_lag(1e-4).with_line());
    let message = refused(&world, late, exact().into());
    assert!(message.contains("0 with a line hold"), "{message}");
}
