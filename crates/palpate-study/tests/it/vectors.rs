//! Closed loops against reference results of an independent implementation: every column of every
//! file in `vectors/`, 80 samples each, with a point-mass device integrated exactly here.
//! Tolerances are those of `vectors/README.md`.

use palpate_core::{
    AnyParams, AnyRenderer, Contact, HfcrParams, LoopParams, ObjectState, PopcRefParams, Renderer,
    Sample, SehParams, Side, VirtualDamperParams,
};

struct Scene {
    name: &'static str,
    device_mass: f64,
    object_mass: f64,
    stiffness: f64,
    period: f64,
    virtual_force: f64,
    user_force: f64,
    device_start: f64,
    object_start: f64,
}

const SCENES: [Scene; 4] = [
    Scene {
        name: "fig2",
        device_mass: 0.1,
        object_mass: 0.1,
        stiffness: 100.0,
        period: 0.01,
        virtual_force: -0.981,
        user_force: 0.981,
        device_start: 0.0,
        object_start: 0.1,
    },
    Scene {
        name: "exp1",
        device_mass: 0.25,
        object_mass: 0.1,
        stiffness: 100.0,
        period: 0.02,
        virtual_force: -0.981,
        user_force: 1.0,
        device_start: 0.0,
        object_start: 0.05,
    },
    Scene {
        name: "exp2",
        device_mass: 0.25,
        object_mass: 0.1,
        stiffness: 400.0,
        period: 0.02,
        virtual_force: -0.981,
        user_force: 1.0,
        device_start: 0.0,
        object_start: 0.05,
    },
    Scene {
        name: "wall",
        device_mass: 0.25,
        object_mass: f64::INFINITY,
        stiffness: 1000.0,
        period: 0.001,
        virtual_force: 0.0,
        user_force: 2.0,
        device_start: -0.002,
        object_start: 0.0,
    },
];

fn methods() -> Vec<(&'static str, AnyParams<f64>)> {
    vec![
        ("basic", AnyParams::Basic),
        ("seh", AnyParams::Seh(SehParams::default())),
        (
            "virtual-damper",
            AnyParams::VirtualDamper(VirtualDamperParams::new(0.5)),
        ),
        ("popc-ref", AnyParams::PopcRef(PopcRefParams::new(6.0))),
        (
            "hfcr-mod",
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
        ),
        ("hfcr-mod-st", AnyParams::Hfcr(HfcrParams::default())),
        ("hfcr", AnyParams::Hfcr(HfcrParams::with_damping(0.02))),
    ]
}

/// All seven columns of the loop on either side of the device, in the frame of the files.
fn run(scene: &Scene, params: AnyParams<f64>, side: Side) -> Vec<[f64; 7]> {
    let sign: f64 = side.sign();
    let contact = Contact::object(scene.stiffness, scene.object_mass).on(side);
    let loop_params = LoopParams {
        speed_limit: None,
        ..LoopParams::new(scene.period)
    };
    let renderer: AnyRenderer<f64> = Renderer::new(contact, loop_params, params).unwrap();
    let mut state = renderer
        .start(ObjectState::at_rest(sign * scene.object_start))
        .unwrap();
    let (mut position, mut velocity) = (scene.device_start, 0.0);
    let mut rows = Vec::new();
    for i in 0..80 {
        let output = renderer.step(
            &mut state,
            Sample::at(sign * position).with_virtual_force(sign * scene.virtual_force),
        );
        assert_eq!(output.fault, None);
        assert_eq!(output.force_on_device, -output.force_on_object);
        let ledger = state.ledger();
        rows.push([
            f64::from(i) * scene.period,
            position,
            sign * output.object_position,
            sign * output.object_velocity,
            sign * output.force_on_object,
            ledger.original_leak.accumulated,
            ledger.held_leak.accumulated,
        ]);
        let acceleration = (scene.user_force + sign * output.force_on_device) / scene.device_mass;
        position += (velocity + 0.5 * acceleration * scene.period) * scene.period;
        velocity += acceleration * scene.period;
    }
    rows
}

#[test]
fn every_column_of_every_reference_file_agrees() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/vectors");
    let mut compared = 0;
    for scene in &SCENES {
        for (method, params) in methods() {
            let name = format!("{}_{method}.csv", scene.name);
            let text = std::fs::read_to_string(folder.join(&name)).unwrap();
            let relative = match name.as_str() {
                // These loops amplify rounding.
                "exp2_virtual-damper.csv" | "exp2_hfcr-mod.csv" => 1e-6,
                _ => 1e-9,
            };
            let rows = run(scene, params, Side::Positive);
            assert_eq!(text.lines().count(), rows.len() + 1, "{name}");
            let header: Vec<_> = text.lines().next().unwrap().split(',').collect();
            for (i, (line, row)) in text.lines().skip(1).zip(&rows).enumerate() {
                let expected: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
                assert_eq!(expected.len(), row.len(), "{name}, row {i}");
                for ((column, want), got) in header.iter().zip(&expected).zip(row) {
                    assert!(
                        (want - got).abs() <= 1e-12 + relative * want.abs(),
                        "{name}, row {i}, {column}: {got} instead of {want}"
                    );
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 4 * 7 * 80 * 7);
}

#[test]
fn the_mirrored_scene_gives_the_mirrored_run_bit_for_bit() {
    for scene in &SCENES {
        for (method, params) in methods() {
            let right = run(scene, params, Side::Positive);
            let left = run(scene, params, Side::Negative);
            assert!(right == left, "{} {method}", scene.name);
        }
    }
}
