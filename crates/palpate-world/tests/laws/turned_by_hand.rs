//! Tools turned by their hands: the devices measure six axes and push along three. With the device known exactly,
//! each held force is the interval mean of the ideal one, in which no contact rotates the tool.

use palpate_world::{
    BasicParams, ContactLaw, ContactLedger, CoupledParams, DeviceLedger, EnergyLedger, HfcrParams,
    Limited, Prior, Quaternion, Sample, SubSteps, Tool, Vector, VirtualCouplingParams, World,
    WorldGuard, WorldGuardParams, WorldLoop, WorldMethod, WorldPart, WorldRenderer, WorldState,
};

use crate::ideal::dot;
use crate::six_axes::{self, Case, as_world, errors, errors_with, exact, fine, on_a_ball};

/// Returns the six-axis tools, each turned by its hand.
fn cases() -> Vec<Case> {
    let mut cases = six_axes::cases();
    for case in &mut cases {
        case.rigid.led = true;
    }
    cases
}

#[test]
fn with_a_device_known_exactly_each_held_force_is_the_mean_of_the_ideal_one() {
    for case in cases() {
        for period in [0.001, 0.004] {
            let [_, known, _] = errors(&case, period, fine(), exact(&case));
            let usual = errors(&case, period, SubSteps::default(), exact(&case))[1];
            let basic = errors(&case, period, SubSteps::default(), BasicParams::default())[1];
            println!(
                "{}, {period} s: E {known:.4} %, with the usual sub-steps {usual:.3} %, sampled spring {basic:.0} %",
                case.name
            );
            assert!(known < 0.06, "{known}");
            assert!(usual < 0.3, "{usual}");
            assert!(basic > 100.0 * known, "{basic}");
        }
    }
}

#[test]
fn model_mass_and_inertia_errors_keep_error_below_one_percent() {
    for case in cases() {
        let model = CoupledParams::new(vec![[1.5 * case.rigid.mass; 3]])
            .with_device_inertia(vec![case.rigid.moments.map(|moment| 0.7 * moment)]);
        let quanta = (2e-5, 4e-4);
        let coarse = model
            .clone()
            .with_encoder_quantum(quanta.0)
            .with_angle_quantum(quanta.1);
        let coarse = errors_with(&case, quanta, 0.001, SubSteps::default(), coarse)[1];
        let model = errors(&case, 0.001, SubSteps::default(), model)[1];
        println!(
            "{}: E told wrong {model:.3} %, with sensors of 20 um and 0.02 degrees {coarse:.2} %",
            case.name
        );
        assert!(model < 1.0, "{model}");
        assert!(coarse < 10.0, "{coarse}");
    }
}

/// Returns a virtual coupling of tools that feel no torque.
fn coupling() -> VirtualCouplingParams {
    VirtualCouplingParams {
        stiffness: vec![2000.0],
        damping: vec![4.0],
        mass: vec![0.1],
        ..VirtualCouplingParams::default()
    }
}

fn methods() -> [WorldMethod; 5] {
    let (mass, moments) = ([0.15; 3], [9.4e-5, 1.7e-4, 2e-4]);
    let model = CoupledParams::new(vec![mass.map(|m| 1.5 * m)])
        .with_device_inertia(vec![moments.map(|m| 0.7 * m)])
        .with_encoder_quantum(2e-6)
        .with_angle_quantum(3e-5);
    let known = CoupledParams::new(vec![mass])
        .with_device_inertia(vec![moments])
        .with_prior(Prior::of_a_known_mass());
    [
        BasicParams {
            damping: vec![1.0],
            rotational_damping: vec![0.01],
        }
        .into(),
        coupling().into(),
        HfcrParams::default().into(),
        model.into(),
        known.into(),
    ]
}

/// Returns the residuals of the ledger identities: of the world, of the port, and of the leak.
fn off(ledger: &EnergyLedger, at_start: f64) -> [f64; 3] {
    let sum = |of: fn(&ContactLedger) -> f64| -> f64 { ledger.contacts.iter().map(of).sum() };
    let bodies: f64 = ledger
        .bodies
        .iter()
        .map(|it| it.kinetic + it.potential)
        .sum();
    let step_errors =
        sum(|it| it.step_error) + ledger.bodies.iter().map(|it| it.step_error).sum::<f64>();
    let DeviceLedger {
        port_work,
        carried,
        held,
        unforeseen,
        offset,
        velocity_offset,
        unpaid,
        ..
    } = ledger.devices[0];
    let world = bodies - at_start + sum(|it| it.stored) + sum(|it| it.dissipated)
        - (sum(|it| it.observed) - sum(|it| it.work_on_proxy) + step_errors);
    let port = (held - sum(|it| it.held)).abs() + (port_work + carried - held - unforeseen).abs();
    let leak = sum(ContactLedger::leak) - (offset - velocity_offset + unpaid);
    [world, port, leak]
}

/// Four methods render a box that is pressed onto a ball and past it onto the floor, with friction, and rotated
/// there.
#[test]
fn ledger_closes_and_no_torque_is_sent() {
    for (number, method) in methods().into_iter().enumerate() {
        let name = method.name();
        let (mut world, mut device) = on_a_ball();
        world.tools[0].gives_torque = false;
        device.led = true;
        device.hand[1] = [0.002, 0.0015, 0.001];
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let at_start: f64 = state.ledger().bodies.iter().map(|it| it.kinetic).sum();
        for _ in 0..200 {
            let (position, orientation) = device.pose();
            let (position, orientation) = ([position], [orientation]);
            let sample = Sample::at(&position).turned(&orientation);
            let output = renderer.step(&mut state, &sample);
            assert_eq!(output.fault, None);
            assert_eq!(output.torques, [[0.0; 3]]);
            let held = [output.forces[0], [0.0; 3]];
            // A driver's report of a torque that was not commanded is ignored.
            renderer.report_sent_torque(&mut state, 0, [0.1, 0.2, 0.3]);
            device.interval(0.001, 64, Some(held));
        }
        let ledger = state.ledger();
        let each = ledger.contacts.iter();
        let turned_over: f64 = each.map(|it| it.work.abs() + it.held.abs()).sum();
        let off = off(ledger, at_start).map(|off| off / turned_over);
        let carried = ledger.devices[0].carried;
        println!(
            "{name}: of {turned_over:.4} J the books are off by [{:.1e}, {:.1e}, {:.1e}]; the hand's turning {:.4} J, leak {:.1e} J",
            off[0],
            off[1],
            off[2],
            -carried,
            ledger.created()
        );
        assert!(turned_over > 1e-3);
        // The hand really rotates the box against the touched bodies.
        assert!(carried.abs() > 1e-3 * turned_over, "{carried}");
        assert!(ledger.contacts.iter().all(|it| it.dissipated >= 0.0));
        assert!(off[0].abs() < 1e-12 && off[1].abs() < 1e-12, "{off:?}");
        if number >= 3 {
            assert!(off[2].abs() < 1e-12, "{off:?}");
        }
        assert_eq!(state.tools()[0].torque, [0.0; 3]);
        assert_eq!(state.tools()[0].inertia, None);
    }
}

/// Returns a bar with a ball at one end, held at the other end, which a hand turns down onto a floor and up again.
fn bar() -> World {
    let mut case = cases().swap_remove(2);
    case.shape = palpate_world::Shape::Spheres {
        spheres: vec![palpate_world::SphereAt {
            centre: [0.05, 0.0, 0.0],
            radius: 0.008,
        }],
    };
    let mut world = as_world(&case);
    world.contacts[0].law = ContactLaw::spring(2000.0);
    world
}

/// A hand that sets the bar's height and angle, and pulls the device up while the ball is pressed: it recovers by
/// lifting the energy that it put in by rotating. Returns the largest energy delivered to the hand, and how often the
/// guard acted.
fn taken(method: WorldMethod, guard: WorldGuard) -> (f64, u32, WorldState) {
    let loop_params = WorldLoop::new(0.001).with_guard(guard);
    let renderer = WorldRenderer::new(&bar(), loop_params, method).unwrap();
    let mut state = renderer.start();
    let (mut work, mut most, mut acted) = (0.0_f64, 0.0_f64, 0);
    let mut force: Vector = [0.0; 3];
    let mut before: Option<Vector> = None;
    for sample in 0..1000 {
        // It starts high. When low it is turned down; then it is lifted, turned back in the air, and lowered.
        let phase = std::f64::consts::TAU * (f64::from(sample) / 200.0 + 0.5);
        let place = [0.0, 0.0, 0.011 - 0.008 * phase.cos()];
        let turn = 0.15 * phase.sin();
        let orientation: Quaternion = [(0.5 * turn).cos(), 0.0, (0.5 * turn).sin(), 0.0];
        let (places, orientations) = ([place], [orientation]);
        let sample = Sample::at(&places).turned(&orientations);
        if let Some(before) = before {
            work += dot(force, [0, 1, 2].map(|i| place[i] - before[i]));
        }
        most = most.max(work);
        before = Some(place);
        let output = renderer.step(&mut state, &sample);
        let Limited { guard, .. } = output.limited;
        acted += u32::from(guard);
        assert_eq!(output.fault, None);
        force = output.forces[0];
    }
    (most, acted, state)
}

/// Energy that the hand puts in by rotating is not available for delivery: no motor opposed it.
#[test]
fn the_guard_does_not_count_what_the_hand_puts_in_by_turning() {
    let guard = |allowance| WorldGuard::Limit(WorldGuardParams::by_speed(0.3, 10.0, allowance));
    let coupled = CoupledParams::new(vec![[0.2; 3]]).with_device_inertia(vec![[2e-4; 3]]);
    for method in [BasicParams::default().into(), WorldMethod::from(coupled)] {
        let name = method.name();
        let (free, _, state) = taken(method.clone(), WorldGuard::Off);
        let put_in = -state.ledger().devices[0].carried;
        let (kept, acted, _) = taken(method, guard(0.02));
        println!(
            "{name}: {free:.3} J taken, {put_in:.3} J put in by turning; with 20 mJ {kept:.4} J, acting {acted} times"
        );
        assert!(free > 0.1 && put_in > 0.8 * free, "{free} {put_in}");
        assert!(kept <= 0.02 && acted > 0, "{kept} {acted}");
    }
}

#[test]
fn what_turns_is_refused_where_it_makes_no_sense() {
    let case = &cases()[0];
    let mut world = as_world(case);
    world.tools[0].turns = false;
    let refused = WorldRenderer::new(&world, WorldLoop::new(0.001), exact(case)).unwrap_err();
    assert_eq!(refused.iter().len(), 1, "{refused:?}");
    assert_eq!(refused.first().part, WorldPart::Tool(0));
    assert_eq!(refused.first().field.name(), "gives_torque");

    // A running world keeps its tools.
    let world = as_world(case);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), exact(case)).unwrap();
    let state = renderer.start();
    let mut other = world.clone();
    other.tools[0] = Tool::new("tool", case.shape.clone()).turning();
    let refused = renderer.changed(&state, &other).unwrap_err();
    let said = refused.first().to_string();
    assert!(said.contains("turns without torque"), "{said}");

    // A virtual coupling has no rotational spring without a torque output.
    let springs = VirtualCouplingParams {
        rotational_stiffness: vec![1.0, 1.0],
        ..coupling()
    };
    let refused = WorldRenderer::new(&world, WorldLoop::new(0.001), springs).unwrap_err();
    let said = refused.first().to_string();
    assert!(said.contains("no tool gives a torque"), "{said}");
}
