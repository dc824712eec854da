//! Changes of the rendering at run time: limits hold in every tick, and a wall keeps the object's position.

use palpate_core::{
    Actuation, AnyParams, Contact, CoupledParams, Guard, GuardParams, LoopParams, ObjectState,
    Rendering, Running, Sample, Side, VirtualDamperParams,
};

use crate::common::{PointMass, methods};

const PERIOD: f64 = 0.001;

fn pressed(params: AnyParams<f64>) -> Rendering<f64> {
    Rendering {
        contact: Contact::wall(1000.0),
        loop_params: LoopParams::new(PERIOD),
        params,
        virtual_force: 0.0,
        object: ObjectState::at_rest(0.0),
    }
}

/// A slew limit may not maintain a force that the new force limit forbids.
#[test]
fn a_new_force_limit_holds_in_every_tick_of_a_change() {
    for (name, method) in methods() {
        for (side, slew_limit) in [
            (Side::Positive, None),
            (Side::Positive, Some(10.0)),
            (Side::Negative, Some(10.0)),
        ] {
            let sign = if side == Side::Positive { 1.0 } else { -1.0 };
            let before = pressed(AnyParams::VirtualDamper(VirtualDamperParams::new(2.0)));
            let before = Rendering {
                contact: before.contact.on(side),
                ..before
            };
            let mut running = Running::new(before).unwrap();
            let at = |running: &mut Running<f64>, tick: i32| {
                running.step(Sample::at(sign * (0.005 + 1e-5 * f64::from(tick % 7))))
            };
            for tick in 0..20 {
                at(&mut running, tick);
            }
            let after = Rendering {
                params: method,
                loop_params: LoopParams {
                    slew_limit,
                    ..LoopParams::new(PERIOD).with_force_limit(1.0)
                },
                ..before
            };
            running.change(after).unwrap();
            for tick in 20..220 {
                let output = at(&mut running, tick);
                let force = output.force_on_object.abs();
                assert!(force <= 1.0, "{name}, {side:?}, tick {tick}: {force} N");
                assert_eq!(output.force_on_device, -output.force_on_object);
            }
        }
    }
}

/// A wall with a damper pulls; after the change it must not pull, not even as long as the slew limit would allow.
#[test]
fn a_contact_that_is_to_push_only_pulls_in_no_tick_of_a_change() {
    let before = pressed(AnyParams::VirtualDamper(VirtualDamperParams::new(100.0)));
    let mut running = Running::new(before).unwrap();
    running.step(Sample::at(0.003));
    let pulls = running.step(Sample::at(0.002)).force_on_object;
    assert!(pulls < -50.0, "{pulls} N");
    let after = Rendering {
        contact: before.contact.pushing_only(),
        loop_params: LoopParams {
            slew_limit: Some(10.0),
            ..before.loop_params
        },
        params: AnyParams::Basic,
        ..before
    };
    running.change(after).unwrap();
    for tick in 0..150 {
        let force = running.step(Sample::at(0.001)).force_on_object;
        assert!(force >= 0.0, "tick {tick}: {force} N");
    }
}

/// The bound of `guard.rs` in the core, by the ledger at the sample.
#[test]
fn the_guard_holds_in_every_tick_of_a_change() {
    let guard = GuardParams::by_speed(1.0, 1e-4);
    // The device strikes, and a damper without a guard responds with 84 N.
    const CHANGE: i32 = 3;
    for (name, method) in methods() {
        let before = Rendering {
            contact: Contact::object(1000.0, 0.1),
            ..pressed(AnyParams::VirtualDamper(VirtualDamperParams::new(20.0)))
        };
        let mut running = Running::new(before).unwrap();
        let mut acted = 0;
        for tick in 0..160_i32 {
            if tick == CHANGE {
                let after = Rendering {
                    params: method,
                    loop_params: LoopParams {
                        guard: Guard::Limit(guard),
                        ..before.loop_params
                    },
                    ..before
                };
                running.change(after).unwrap();
            }
            // In and out again.
            let depth = 0.004 * f64::from((tick / 3) % 2);
            let output = running.step(Sample::at(depth).with_virtual_force(-1.0));
            assert_eq!(output.fault, None);
            if tick >= CHANGE {
                let free = running.ledger().balance() + guard.allowance;
                let bound = free.max(0.0) / (guard.largest_speed * PERIOD);
                let force = output.force_on_object.abs();
                assert!(
                    force <= bound * (1.0 + 1e-12),
                    "{name}, tick {tick}: {force} N, and {bound} N are allowed"
                );
                acted += usize::from(output.limited.guard);
            }
        }
        assert!(acted > 0, "{name}");
    }
}

/// A device presses an object against a virtual force, then the object becomes a wall.
#[test]
fn an_object_that_becomes_a_wall_keeps_its_place_and_its_force() {
    for (name, method) in methods() {
        // A device at rest dissipates nothing, so force bounding allows no force.
        if name == "force-bounding" {
            continue;
        }
        let object = Rendering {
            contact: Contact::object(1000.0, 0.1),
            virtual_force: -1.5,
            object: ObjectState::at_rest(0.01),
            ..pressed(method)
        };
        let mut running = Running::new(object).unwrap();
        let device = 0.012;
        let mut last = running.step(Sample::at(device));
        let place = last.object_position;
        for _ in 0..4 {
            last = running.step(Sample::at(device));
        }
        assert!(last.force_on_object > 0.1, "{name}: {last:?}");
        let moved = (last.object_position - place).abs();
        assert!(moved > 1e-6, "{name}: {moved} m");
        // Its position and force at the next sample.
        let next = running.clone().step(Sample::at(device));
        let wall = Rendering {
            contact: Contact::wall(1000.0),
            ..object
        };
        running.change(wall).unwrap();
        let first = running.step(Sample::at(device));
        let moved = (first.object_position - next.object_position).abs();
        assert!(moved < 1e-12, "{name}: {moved} m");
        let step = (first.force_on_object - next.force_on_object).abs();
        assert!(step < 1e-9, "{name}: {step} N");
        for _ in 0..300 {
            last = running.step(Sample::at(device));
        }
        let moved = (last.object_position - first.object_position).abs();
        let expected = 1000.0 * (device - last.object_position);
        let off = (last.force_on_object - expected).abs();
        println!("{name}: off by {off:.2e} N, moved {moved:.2e} m");
    }
}

/// A hand presses the device against an object that becomes a wall. The wall keeps the object's position, and responds
/// as a spring as soon as the change is complete.
#[test]
fn coupled_goes_over_to_the_law_of_a_wall_at_once() {
    for (model_mass, delay, stiffness) in [
        (0.25, 0.0, 1000.0),
        (0.5, 0.0, 1000.0),
        (0.25, 0.0007, 1000.0),
        (0.25, 0.001, 4000.0),
    ] {
        let object = Rendering {
            contact: Contact::object(stiffness, 0.5),
            virtual_force: -2.0,
            loop_params: LoopParams {
                actuation: Actuation {
                    delay,
                    ..Actuation::default()
                },
                ..LoopParams::new(PERIOD)
            },
            ..pressed(AnyParams::Coupled(CoupledParams::new(model_mass)))
        };
        let mut running = Running::new(object).unwrap();
        let mut device = PointMass {
            mass: 0.25,
            user_force: 0.0,
            position: -0.002,
            velocity: 0.0,
        };
        let mut sent = 0.0;
        let mut tick = |running: &mut Running<f64>, target: f64| {
            let output = running.step(Sample::at(device.position));
            device.user_force = 200.0 * (target - device.position) - 6.0 * device.velocity;
            device.hold(sent, delay);
            sent = output.force_on_device;
            device.hold(sent, PERIOD - delay);
            output
        };
        for _ in 0..500 {
            tick(&mut running, 0.01);
        }
        let wall = Rendering {
            contact: Contact::wall(stiffness),
            ..object
        };
        running.change(wall).unwrap();
        let place = tick(&mut running, 0.01).object_position;
        let mut worst = 0.0_f64;
        for late in 1..3000 {
            // Alternately harder and softer.
            let target = if (late / 700) % 2 == 0 { 0.01 } else { 0.012 };
            let output = tick(&mut running, target);
            let off = output.force_on_object / (stiffness * output.penetration) - 1.0;
            if late % 700 > 400 {
                worst = worst.max(off.abs());
            }
            let moved = (output.object_position - place).abs();
            assert!(moved < 3e-4, "{late}: {moved} m from where it stood");
        }
        println!("told {model_mass} kg, {delay} s, {stiffness} N/m: off by {worst:.1e}");
        assert!(
            worst < 1e-3,
            "{model_mass} kg, {delay} s, {stiffness} N/m: {worst}"
        );
    }
}
