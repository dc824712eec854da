//! Template for a user-defined method (`method.rs`) and device (`device.rs`), compared with all built-in methods in one
//! table and one figure.
//!
//! `cargo run --release` prints the table and writes `own_idea.svg`.

mod device;
mod method;

use std::error::Error;

use palpate_plot::figure::{Figure, Kind, Panel, Role, Row, Series, Size, svg};
use palpate_scene::ContactFile;
use palpate_scene::method::MethodName;
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::{Reference, Run};

use device::Joystick;
use method::LookAheadParams;

/// A block of 0.3 kg on the joystick, at 200 Hz. The joystick replaces the scene's device; its mass is the model value
/// of `coupled`.
const SCENE: &str = r#"
format = 2
title = "A block on a joystick, 200 Hz"

[loop]
period_s = 0.005

[[device]]
name = "device"
axes = ["x"]
mass_kg = 0.2

[device.hand]
force_n = [1.0, 0.0, 0.0]

[[body]]
name = "object"
axes = ["x"]
mass_kg = 0.3
position_m = [0.03, 0.0, 0.0]
force_n = [-1.0, 0.0, 0.0]
shape = { half_space = { normal = [-1.0, 0.0, 0.0] } }

[[contact]]
between = ["device", "object"]
stiffness_n_per_m = 800.0

[measure]
duration_s = 1.5
"#;

/// The ideal, and the runs of all built-in methods and of the one of this example.
fn runs() -> Result<(Reference, Vec<Run>), Box<dyn Error>> {
    let scene = ContactFile::parse("own_idea.toml", SCENE)?.scene;
    let joystick = Joystick {
        mass: 0.2,
        centring_stiffness: 20.0,
        hand_force: 1.5,
        position: 0.0,
        velocity: 0.0,
    };
    let bench = Bench::with_device(&scene, joystick)?;
    let mut runs = Vec::new();
    for method in MethodName::ALL {
        runs.push(bench.run(method)?);
    }
    runs.push(bench.run_own(LookAheadParams { periods: 0.5 })?);
    Ok((bench.reference().clone(), runs))
}

/// The held forces of a few methods against the ideal force.
fn figure(reference: &Reference, runs: &[Run]) -> Figure {
    let shown = ["basic", "coupled", "look-ahead"];
    let row = |name: &str, index: usize| {
        let run = runs.iter().find(|run| run.method.name() == name);
        let ideal = Series {
            name: "ideal".into(),
            kind: Kind::Line,
            role: Role::Reference,
            x: reference.curve.iter().map(|point| point.time).collect(),
            y: reference
                .curve
                .iter()
                .map(|point| point.force_on_object)
                .collect(),
        };
        let held = run.map(|run| Series {
            name: name.into(),
            kind: Kind::Step,
            role: Role::Compared(index),
            x: run.ticks.iter().map(|tick| tick.time).collect(),
            y: run
                .ticks
                .iter()
                .map(|tick| tick.held_force_on_object)
                .collect(),
        });
        Row {
            y_label: "force [N]".into(),
            panels: vec![Panel {
                series: [Some(ideal), held].into_iter().flatten().collect(),
            }],
            ..Row::default()
        }
    };
    Figure {
        title: "Look-ahead of half a period, spring force and coupled rendering".into(),
        x_label: "time [s]".into(),
        rows: shown
            .iter()
            .enumerate()
            .map(|(index, name)| row(name, index))
            .collect(),
        ..Figure::default()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (reference, runs) = runs()?;
    println!(
        "{:<16} {:>8} {:>8} {:>12}",
        "method", "E %", "FRE %", "leak mJ"
    );
    for run in &runs {
        let fidelity = run.force.fidelity.ok_or("no contact")?;
        println!(
            "{:<16} {:>8.1} {:>8.1} {:>12.2}",
            run.method.name(),
            fidelity.mean_force_error,
            fidelity.force_rendering_error,
            1e3 * run.last().ledger.held_leak.accumulated,
        );
    }
    let picture = svg(&figure(&reference, &runs), Size::NATURAL)?;
    std::fs::write("own_idea.svg", picture)?;
    println!("wrote own_idea.svg");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::ParameterValue;

    fn error_of(runs: &[Run], name: &str) -> f64 {
        let run = runs.iter().find(|run| run.method.name() == name).unwrap();
        run.force.fidelity.unwrap().mean_force_error
    }

    #[test]
    fn custom_method_on_custom_device_is_evaluated_like_built_in_methods() {
        let (reference, runs) = runs().unwrap();
        assert_eq!(runs.len(), MethodName::ALL.len() + 1);
        let own = runs.last().unwrap();
        assert_eq!(own.method.name(), "look-ahead");
        assert_eq!(own.parameters, [("periods", ParameterValue::Number(0.5))]);
        // The energy that the bench integrates at the port is what the renderer's books say.
        for run in &runs {
            let ledger = run.last().ledger.port_work;
            let bench = run.bench_port_work.unwrap();
            assert!(
                (ledger - bench).abs() < 1e-9 * (1.0 + ledger.abs()),
                "{}",
                run.method
            );
        }
        // It looks ahead, so it is nearer to the ideal than the spring force of the sample is; the
        // prediction that knows the force about to be held is nearer still.
        let (basic, own) = (error_of(&runs, "basic"), error_of(&runs, "look-ahead"));
        let coupled = error_of(&runs, "coupled");
        assert!(coupled < own && own < basic, "{coupled} {own} {basic}");
        assert!(reference.error < 1e-3, "{}", reference.error);
    }

    #[test]
    fn an_ahead_of_nothing_is_the_basic_method_bit_for_bit() {
        let scene = ContactFile::parse("own_idea.toml", SCENE).unwrap().scene;
        let bench = Bench::new(&scene).unwrap();
        let own = bench.run_own(LookAheadParams { periods: 0.0 }).unwrap();
        let basic = bench.run(MethodName::Basic).unwrap();
        assert_eq!(own.ticks, basic.ticks);
    }

    #[test]
    fn a_parameter_outside_its_range_is_named() {
        let scene = ContactFile::parse("own_idea.toml", SCENE).unwrap().scene;
        let bench = Bench::new(&scene).unwrap();
        let refused = bench.run_own(LookAheadParams { periods: 2.0 }).unwrap_err();
        assert_eq!(refused.to_string(), "periods is 2, but must be from 0 to 1");
    }
}
