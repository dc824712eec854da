//! Changes of the rendering while the loop runs.

use palpate_core::{AnyParams, CoupledParams, HfcrParams, Mass, Side, VirtualDamperParams};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{ChangeError, Note, Rendering, tap};
use palpate_scene::method::MethodName;

use crate::{at, scene, scripted, simulated, wide};

/// A device held 1 mm deep in a wall of 1000 N/m.
fn pressed() -> crate::Scripted {
    let (mut control, _) = scripted(vec![at(1.0)], wide());
    for _ in 0..10 {
        control.tick();
    }
    control
}

#[test]
fn another_stiffness_comes_in_without_a_step_in_the_force() {
    let mut control = pressed();
    let mut parameters = control.parameters().unwrap();
    assert!(control.parameters().is_none());
    let mut stiffer = *parameters.current();
    stiffer.contact.stiffness = 4000.0;
    assert_eq!(parameters.change(stiffer), Ok(1));
    let before = control.tick();
    let mut last = before;
    let mut largest_step: f64 = 0.0;
    for _ in 0..150 {
        let tick = control.tick();
        assert!(tick.contact.force_on_object >= last.contact.force_on_object - 1e-12);
        largest_step =
            largest_step.max(tick.contact.force_on_object - last.contact.force_on_object);
        last = tick;
    }
    println!("largest step {largest_step:.4} N of 3 N");
    assert_eq!(before.tick.generation, 1);
    assert!(
        (before.contact.force_on_object - 1.0).abs() < 0.05,
        "{before:?}"
    );
    assert!(largest_step < 0.06, "{largest_step}");
    assert!(
        (last.contact.force_on_object - 4.0).abs() < 1e-9,
        "{last:?}"
    );
    // From 1000 to 4000 N/m at 1 mm: 1.5 mJ of outside work.
    assert!((last.contact.outside_work - before.contact.outside_work - 1.5e-3).abs() < 1e-4);
    assert!(
        (last.contact.outside_work - 1.5e-3).abs() < 1e-9,
        "{}",
        last.contact.outside_work
    );
    assert_eq!(last.contact.held_leak, 0.0);
}

#[test]
fn of_two_changes_the_second_goes_on_from_where_the_first_has_come() {
    let mut control = pressed();
    let mut parameters = control.parameters().unwrap();
    let first = *parameters.current();
    let mut stiffer = first;
    stiffer.contact.stiffness = 4000.0;
    parameters.change(stiffer).unwrap();
    for _ in 0..50 {
        control.tick();
    }
    let halfway = control.tick().contact.force_on_object;
    assert!(halfway > 1.9 && halfway < 2.2, "{halfway}");
    assert_eq!(parameters.change(first), Ok(2));
    let back = control.tick().contact.force_on_object;
    assert!((back - halfway).abs() < 0.05, "{halfway}, {back}");
    for _ in 0..100 {
        control.tick();
    }
    assert!((control.tick().contact.force_on_object - 1.0).abs() < 1e-9);
}

/// A mass pressed against the device by a virtual force, and a hand that holds the device.
#[test]
fn another_method_takes_over_at_the_force_of_the_one_before() {
    let mut held = scene("experiment1_in_a_hand.toml");
    held.loop_params.period = 0.001;
    let methods = [MethodName::Basic, MethodName::Hfcr, MethodName::Coupled];
    for from in methods {
        for to in methods {
            if from == to {
                continue;
            }
            let (mut control, _) = simulated(&held, from, wide());
            let mut parameters = control.parameters().unwrap();
            let mut last = control.tick();
            while last.contact.force_on_object < 0.3 {
                last = control.tick();
                assert!(last.tick.time < 5.0, "no contact");
            }
            parameters.change(held.rendering(to).unwrap()).unwrap();
            let steps: Vec<f64> = (0..20)
                .map(|_| {
                    let tick = control.tick();
                    let step = (tick.contact.force_on_object - last.contact.force_on_object).abs();
                    last = tick;
                    step
                })
                .collect();
            let at_change = steps[0];
            let after = steps[1..]
                .iter()
                .fold(0.0_f64, |most, step| most.max(*step));
            println!("{from} to {to}: {at_change:.4} N at the change, {after:.4} N after it");
            assert!(at_change <= 1.5 * after + 1e-3, "{from} to {to}: {steps:?}");
        }
    }
}

/// A device that moves in at 50 mm/s, so the force of the spring alone changes by 0.05 N per period. The 0.2 N of a
/// damper of 4 N s/m fade in and out.
#[test]
fn what_another_method_adds_fades_over_the_change() {
    let damper = AnyParams::VirtualDamper(VirtualDamperParams::new(4.0));
    for (from, to) in [(damper, AnyParams::Basic), (AnyParams::Basic, damper)] {
        let script = (-20..400).map(|period| at(0.05 * f64::from(period)));
        let (mut control, _) = scripted(script.collect(), wide());
        let mut parameters = control.parameters().unwrap();
        let basic = *parameters.current();
        parameters
            .change(Rendering {
                params: from,
                ..basic
            })
            .unwrap();
        let mut last = control.tick();
        for _ in 0..200 {
            last = control.tick();
        }
        parameters
            .change(Rendering {
                params: to,
                ..basic
            })
            .unwrap();
        let mut largest: f64 = 0.0;
        for _ in 0..150 {
            let tick = control.tick();
            let step = tick.contact.force_on_object - last.contact.force_on_object;
            largest = largest.max((step - 0.05).abs());
            last = tick;
        }
        println!("to {to:?}: {largest:.4} N beyond the spring in one period");
        assert!(largest < 0.01, "{from:?} to {to:?}: {largest} N");
        let added = last.contact.force_on_object - 1e3 * last.contact.penetration;
        let expected = if to == damper { 0.2 } else { 0.0 };
        assert!(
            (added - expected).abs() < 1e-9,
            "{from:?} to {to:?}: {added} N"
        );
    }
}

#[test]
fn method_change_removes_proxy_offset_of_wall() {
    let mut pressed = scene("coupled/wall-1000.toml");
    pressed.loop_params.period = 0.001;
    let (mut control, _) = simulated(&pressed, MethodName::Coupled, wide());
    let mut parameters = control.parameters().unwrap();
    for _ in 0..300 {
        control.tick();
    }
    let hfcr = Rendering {
        params: AnyParams::Hfcr(HfcrParams::default()),
        ..*parameters.current()
    };
    parameters.change(hfcr).unwrap();
    assert_eq!(
        control.tick().contact.object_position,
        pressed.object.position
    );
}

/// An object has flown off, and the device is 300 mm beyond the position of the new wall: 300 N.
#[test]
fn what_becomes_a_wall_touches_a_device_that_is_beyond_its_place() {
    let mut script = vec![at(300.0); 700];
    script.extend(vec![at(302.0); 200]);
    let (mut control, _) = scripted(script, wide());
    let mut parameters = control.parameters().unwrap();
    let wall = *parameters.current();
    let mut object = wall;
    object.contact.object_mass = Mass::Finite(0.1);
    parameters.change(object).unwrap();
    let last = (0..500).map(|_| control.tick()).last().unwrap();
    assert_eq!(last.contact.force_on_object, 0.0);
    parameters.change(wall).unwrap();
    for _ in 0..150 {
        let tick = control.tick();
        assert!(tick.contact.force_on_object.abs() < 1e-9, "{tick:?}");
    }
    // From there on it is a wall, and another method finds it at the same position.
    let damper = AnyParams::VirtualDamper(VirtualDamperParams::new(4.0));
    let params = Rendering {
        params: damper,
        ..wall
    };
    parameters.change(params).unwrap();
    let last = (0..220).map(|_| control.tick()).last().unwrap();
    assert_eq!(last.contact.object_position, 0.3);
    assert!(
        (last.contact.force_on_object - 2.0).abs() < 1e-6,
        "{last:?}"
    );
}

#[test]
fn what_cannot_change_is_refused_and_nothing_changes() {
    let mut control = pressed();
    let mut parameters = control.parameters().unwrap();
    let running = *parameters.current();
    let mut other = running;
    other.loop_params.period = 0.002;
    assert_eq!(
        parameters.change(other).unwrap_err().to_string(),
        "the period is 0.002 s, and the loop runs at 0.001 s; stop the loop to change its period"
    );
    let mut other = running;
    other.contact.side = Side::Negative;
    assert_eq!(parameters.change(other), Err(ChangeError::Side));
    let mut other = running;
    other.contact.stiffness = -1.0;
    let error = parameters.change(other).unwrap_err().to_string();
    assert!(
        error.contains("stiffness") && error.contains("-1"),
        "{error}"
    );
    let mut other = running;
    other.params = AnyParams::Coupled(CoupledParams::new(f64::NAN));
    assert!(parameters.change(other).is_err());
    let tick = control.tick();
    assert_eq!(
        (tick.tick.generation, tick.contact.force_on_object),
        (0, 1.0)
    );
}

/// Returns the largest force step with a damper on a device that moves in at 50 mm/s, with the given changes.
fn largest_step(changes: &[(usize, AnyParams<f64>, f64)]) -> f64 {
    let script = (0..200).map(|i| at(1.0 + 0.05 * f64::from(i))).collect();
    let (mut control, _) = scripted(script, wide());
    let mut parameters = control.parameters().unwrap();
    let mut last = 0.0;
    let mut largest: f64 = 0.0;
    for tick in 0..190 {
        for (when, params, stiffness) in changes {
            if tick == *when {
                let mut rendering = *parameters.current();
                rendering.params = *params;
                rendering.contact.stiffness = *stiffness;
                parameters.change(rendering).unwrap();
            }
        }
        let force = control.tick().contact.force_on_object;
        // The first tick of contact has a step of its own.
        if tick > 30 {
            largest = largest.max((force - last).abs());
        }
        last = force;
    }
    largest
}

#[test]
fn a_change_within_a_change_and_another_damping_are_no_steps() {
    let damper = |damping| AnyParams::VirtualDamper(VirtualDamperParams::new(damping));
    // The tick in which the device stops at the end of its script has a step too.
    let plain = largest_step(&[(0, damper(4.0), 1000.0)]);
    println!("without a change {plain:.3} N from tick to tick");
    for (what, changes) in [
        (
            "another damping",
            vec![(5, damper(4.0), 1000.0), (60, damper(40.0), 1000.0)],
        ),
        (
            "a slider within a change of method",
            vec![
                (5, damper(40.0), 1000.0),
                (60, AnyParams::Basic, 1000.0),
                (65, AnyParams::Basic, 1001.0),
            ],
        ),
        (
            "method and back",
            vec![
                (5, damper(40.0), 1000.0),
                (60, AnyParams::Basic, 1000.0),
                (65, damper(40.0), 1000.0),
            ],
        ),
    ] {
        let step = largest_step(&changes);
        println!("{what}: {step:.3} N at most from tick to tick, {plain:.3} without");
        assert!(step < 0.2, "{what}: {step} N");
    }
}

/// Renders a contact with a spring force that soon oscillates, and by another method after `ticks` ticks. Returns the
/// tick of the safety stop and the events.
fn said_after_a_switch(to: MethodName, ticks: usize) -> (Option<usize>, Vec<Note>) {
    let mut buzzing = scene("experiment2.toml");
    buzzing.contact.stiffness *= 4.0;
    let (control, _) = simulated(&buzzing, MethodName::Basic, SafetyParams::default());
    let (tap, listener) = tap(1 << 14);
    let mut control = control.tapped(tap);
    let mut parameters = control.parameters().unwrap();
    let mut stopped = None;
    for tick in 0..2000 {
        if tick == ticks {
            let rendering = buzzing.rendering(to).unwrap();
            parameters.change(rendering).unwrap();
        }
        control.tick();
        if control.safety_stop().is_some() {
            stopped = Some(tick);
            break;
        }
    }
    drop(control);
    let mut notes = Vec::new();
    for messages in listener {
        if let palpate_rt::Message::Note(noted) = messages {
            notes.push(noted.note);
        }
    }
    (stopped, notes)
}

#[test]
fn the_method_that_created_the_energy_is_named_and_not_the_one_that_renders_now() {
    let (stopped, notes) = said_after_a_switch(MethodName::Basic, usize::MAX);
    let stopped = stopped.expect("the spring force safety stops");
    let by_basic = Note::Oscillated {
        method: MethodName::Basic.name(),
        renders_now: MethodName::Basic.name(),
    };
    assert!(notes.contains(&by_basic), "{notes:?}");
    assert!(!notes.contains(&Note::Stopped(SafetyStop::Oscillation)));
    // The change arrives in the tick that stops: the interval that ends there belongs to the spring force.
    let (at, notes) = said_after_a_switch(MethodName::Coupled, stopped);
    assert_eq!(at, Some(stopped));
    let before_coupled = Note::Oscillated {
        method: MethodName::Basic.name(),
        renders_now: MethodName::Coupled.name(),
    };
    assert!(notes.contains(&before_coupled), "{notes:?}");
    // A method that oscillates itself long after the change is named.
    let (at, notes) = said_after_a_switch(MethodName::Seh, 0);
    assert!(at.is_some(), "sample-estimate-hold safety stops too");
    let by_seh = Note::Oscillated {
        method: MethodName::Seh.name(),
        renders_now: MethodName::Seh.name(),
    };
    assert!(notes.contains(&by_seh), "{notes:?}");
}

#[test]
fn what_is_rendered_is_said_in_words() {
    let scene = scene("experiment2.toml");
    for method in MethodName::ALL {
        let said = scene.rendering(method).unwrap().to_string();
        assert!(!said.contains(['{', '}', ':']), "{said}");
    }
    let said = scene.rendering(MethodName::Coupled).unwrap();
    let words =
        "by coupled (device_mass_kg 0.25, encoder_quantum_m 0, placement true, correction true)";
    assert!(said.to_string().ends_with(words), "{said}");
}
