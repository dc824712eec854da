use super::*;
use crate::grid::Grid;
use crate::hand::Sinusoid;
use crate::world::{Tool, WorldDevice, WorldHand, WorldIdeal};

fn scene() -> WorldScene {
    let sine = |amplitude, frequency_hz, phase| Sinusoid {
        amplitude,
        frequency_hz,
        phase,
    };
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![WorldDevice {
            name: "tool".into(),
            own_axes: None,
            mass_table: None,
            drivetrain: crate::world::Drivetrain::default(),
            mass: [0.1, 0.16, 0.25],
            position: [0.01, -0.02, 0.05],
            velocity: [0.1, 0.0, -0.3],
            tool: Tool::sphere(0.005),
            turning: None,
            hand: WorldHand {
                force: [0.4, 0.0, -1.0],
                stiffness: 60.0,
                damping: 1.5,
                rest: [0.0, 0.01, 0.04],
                tremor: [
                    vec![sine(0.1, 9.0, 0.3), sine(0.04, 15.3, -1.0)],
                    vec![],
                    vec![sine(0.08, 11.0, 2.0)],
                ],
                ..WorldHand::default()
            },
            quantum: [0.0, 1e-5, 2e-6],
        }],
        ..WorldScene::default()
    }
}

#[test]
fn without_a_force_it_moves_as_the_ideal_does() {
    let scene = scene();
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 50)).unwrap();
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap();
    for state in &ideal.states {
        for axis in 0..3 {
            let [x, u] = [plant.positions()[0][axis], plant.velocities()[0][axis]];
            assert!((x - state.devices[0].position[axis]).abs() < 1e-11);
            assert!((u - state.devices[0].velocity[axis]).abs() < 1e-9);
        }
        plant.hold(&[[0.0; 3]]);
    }
}

#[test]
fn what_is_forgotten_changes_nothing_of_what_comes() {
    let actuated = PlantParams {
        actuator: ActuatorParams {
            lag: 0.002,
            gain: 0.9,
        },
        ..PlantParams::perfect(0.01)
    };
    let mut whole = WorldPlant::new(&scene(), actuated).unwrap();
    let mut forgetful = whole.clone();
    for sample in 0..20 {
        let force = [[f64::from(sample) * 0.1, 0.5, -2.0]];
        whole.hold(&force);
        forgetful.hold(&force);
        assert_eq!(whole.positions(), forgetful.positions());
        assert_eq!(
            whole.delivered(0).last(),
            forgetful.delivered(0).last(),
            "{sample}"
        );
        forgetful.forget_delivered();
        assert_eq!(forgetful.delivered(0).len(), 1);
    }
    assert_eq!(whole.delivered(0).len(), 20);
}

#[test]
fn a_held_force_is_a_constant_one_on_the_tool() {
    let mut pushed = scene();
    pushed.devices[0].hand.force = [1.4, 0.5, -3.0];
    let ideal = WorldIdeal::new(&pushed, Grid::even(0.0, 0.01, 20)).unwrap();
    let mut plant = WorldPlant::new(&scene(), PlantParams::perfect(0.01)).unwrap();
    for _ in 0..20 {
        plant.hold(&[[1.0, 0.5, -2.0]]);
    }
    let last = &ideal.states[20].devices[0];
    for axis in 0..3 {
        assert!((plant.positions()[0][axis] - last.position[axis]).abs() < 1e-11);
    }
    for mean in plant.delivered(0) {
        for (mean, held) in mean.iter().zip([1.0, 0.5, -2.0]) {
            assert!((mean - held).abs() < 1e-13);
        }
    }
}

#[test]
fn sensors_round_each_axis_to_its_own_quantum() {
    let mut scene = scene();
    scene.devices[0].position = [0.012_345_678_9; 3];
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap();
    let [x, y, z] = plant.measure()[0];
    assert_eq!(x, plant.positions()[0][0]);
    assert!((y - 0.01235).abs() < 1e-12 && (z - 0.012_346).abs() < 1e-12);
}

#[test]
fn an_interval_is_the_mean_over_its_stretches() {
    let mut plant = WorldPlant::new(&scene(), PlantParams::perfect(0.01)).unwrap();
    let mut whole = plant.clone();
    plant.begin_interval();
    plant.advance(&[[3.0, 0.0, 0.0]], &[], &[], 0.004);
    plant.advance(&[], &[], &[], 0.012);
    plant.begin_interval();
    plant.advance(&[[2.0, 0.0, 0.0]], &[], &[], 0.01);
    let means: Vec<f64> = plant.delivered(0).iter().map(|mean| mean[0]).collect();
    assert!((means[0] - 0.75).abs() < 1e-12 && (means[1] - 2.0).abs() < 1e-12);
    whole.hold(&[[0.0; 3]]);
    assert_ne!(plant.positions(), whole.positions());
}

/// A line moves the tool like small steps of constants, also if the hand releases the device within it.
#[test]
fn a_line_is_many_small_steps_in_any_stretches() {
    let mut released = scene();
    let hand = &mut released.devices[0].hand;
    (hand.release, hand.mass) = (Some(0.0137), 0.05);
    hand.tremor[0].truncate(1);
    let mut rubbing = released.clone();
    rubbing.devices[0].drivetrain.coulomb_friction = 0.05;
    for scene in [scene(), released, rubbing] {
        let (force, slope) = ([1.0, 0.5, -2.0], [300.0, -90.0, 150.0]);
        let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap();
        let mut steps = plant.clone();
        let count = 10_000;
        steps.begin_interval();
        for _ in 0..2 {
            plant.begin_interval();
            plant.advance(&[force], &[slope], &[], 0.004);
            plant.advance(&[force], &[slope], &[], 0.006);
            for i in 0..count {
                let since_middle = ((f64::from(i) + 0.5) / f64::from(count) - 0.5) * 0.01;
                let now = std::array::from_fn(|axis| force[axis] + slope[axis] * since_middle);
                steps.advance(&[now], &[], &[], 0.01 / f64::from(count));
            }
        }
        for axis in 0..3 {
            let off = plant.positions()[0][axis] - steps.positions()[0][axis];
            assert!(off.abs() < 1e-10, "axis {axis}: {off} m");
        }
        for (mean, delivered) in plant.delivered(0).iter().zip(plant.delivered_slopes(0)) {
            let off = |axis: usize| (mean[axis] - force[axis]).abs();
            assert!(off(0) < 1e-12 && off(1) < 1e-12 && off(2) < 1e-12);
            assert_eq!(*delivered, slope);
        }
    }
}

#[test]
fn an_actuator_with_gain_and_lag_gives_less_and_later() {
    let params = PlantParams {
        actuator: ActuatorParams {
            gain: 0.8,
            lag: 0.003,
        },
        ..PlantParams::perfect(0.01)
    };
    let mut plant = WorldPlant::new(&scene(), params).unwrap();
    plant.hold(&[[1.0, 0.0, 0.0]]);
    let settling: f64 = 0.003 * (1.0 - (-10.0_f64 / 3.0).exp());
    let expected = 0.8 * (1.0 - settling / 0.01);
    assert!((plant.delivered(0)[0][0] - expected).abs() < 1e-12);
}

#[test]
fn what_is_wrong_is_named() {
    let refused = |params| WorldPlant::new(&scene(), params).unwrap_err().to_string();
    let message = refused(PlantParams {
        actuator: ActuatorParams {
            gain: 1.0,
            lag: -0.1,
        },
        ..PlantParams::perfect(0.01)
    });
    assert!(message.starts_with("loop.lag = -0.1"), "{message}");
    assert!(refused(PlantParams::perfect(0.0)).contains("loop.period = 0"));
    let mut scene = scene();
    let hand = &mut scene.devices[0].hand;
    (hand.damping, hand.stiffness) = (0.0, 0.1 * (std::f64::consts::TAU * 9.0).powi(2));
    let message = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap_err();
    assert!(
        message
            .to_string()
            .starts_with("devices[0].hand.tremor = 9")
    );
}
