//! Hands with an intention, a mass and a release, and devices with friction. The exact motion of the plant is that of
//! the ideal, and the energy of the ideal is conserved.

use std::sync::Arc;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::{
    Drivetrain, LedPath, PlantParams, Swing, Tool, Turning, TurningHand, WorldDevice, WorldHand,
    WorldIdeal, WorldPlant, WorldScene,
};

const PERIOD: f64 = 0.004;
const PERIODS: usize = 100;
const AXES: [[f64; 3]; 3] = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];

fn held(hand: WorldHand, drivetrain: Drivetrain) -> WorldScene {
    WorldScene {
        devices: vec![WorldDevice {
            name: "tool".into(),
            own_axes: Some(AXES),
            mass_table: None,
            drivetrain,
            mass: [0.1, 0.16, 0.25],
            position: [0.01, -0.02, 0.05],
            velocity: [0.1, 0.0, -0.3],
            tool: Tool::sphere(0.005),
            turning: None,
            hand,
            quantum: [0.0; 3],
        }],
        ..WorldScene::default()
    }
}

fn hand() -> WorldHand {
    WorldHand {
        force: [0.1, 0.2, -0.3],
        stiffness: 60.0,
        damping: 1.5,
        rest: [0.0, 0.01, 0.04],
        mass: 0.2,
        ..WorldHand::default()
    }
}

fn swinging() -> WorldHand {
    WorldHand {
        swing: Some(Swing {
            amplitude: [0.02, -0.01, 0.03],
            frequency_hz: 2.3,
        }),
        ..hand()
    }
}

fn led() -> WorldHand {
    let places = [
        [0.0, 0.0, 0.0],
        [0.02, 0.01, 0.06],
        [0.0, 0.03, 0.02],
        [0.01, 0.0, 0.03],
    ];
    let path = LedPath::new(
        vec![0.0, 0.0513, 0.12, 0.3],
        places.map(|place| vec![place]).to_vec(),
    );
    WorldHand {
        path: Some(Arc::new(path.unwrap())),
        ..hand()
    }
}

fn released(hand: WorldHand) -> WorldHand {
    WorldHand {
        release: Some(0.1537),
        ..hand
    }
}

fn rubbing(coulomb_friction: f64) -> Drivetrain {
    Drivetrain {
        viscous_friction: 0.4,
        coulomb_friction,
        ..Drivetrain::default()
    }
}

/// Largest distance between plant and ideal `[m]`, and imbalance of the ideal's books `[J]`.
fn apart(scene: &WorldScene) -> [f64; 2] {
    let ideal = WorldIdeal::new(scene, Grid::even(0.0, PERIOD, PERIODS)).unwrap();
    let mut plant = WorldPlant::new(scene, PlantParams::perfect(PERIOD)).unwrap();
    let mut apart = [0.0_f64; 2];
    let start = ideal.states[0].ledger;
    for state in &ideal.states {
        for axis in 0..3 {
            let off = plant.positions()[0][axis] - state.devices[0].position[axis];
            apart[0] = apart[0].max(off.abs());
        }
        let gained = state.ledger.kinetic - start.kinetic;
        apart[1] = apart[1].max((gained - state.ledger.hand_work).abs());
        plant.hold(&[[0.0; 3]]);
    }
    apart
}

#[test]
fn plant_and_ideal_move_alike_in_every_hand() {
    let none = Drivetrain::default();
    for (name, hand, drivetrain) in [
        ("mass", hand(), none),
        ("swing", swinging(), none),
        ("path", led(), none),
        ("release", released(hand()), none),
        ("released swing", released(swinging()), none),
        ("released path", released(led()), none),
        ("viscous", swinging(), rubbing(0.0)),
        ("rough", swinging(), rubbing(0.3)),
        ("rough path", released(led()), rubbing(0.3)),
        ("stuck", hand(), rubbing(5.0)),
    ] {
        let [off, books] = apart(&held(hand, drivetrain));
        println!("{name}: {off:.1e} m apart, books {books:.1e} J");
        assert!(off < 1e-9, "{name}: {off}");
        assert!(books < 1e-8, "{name}: {books}");
    }
}

/// Each quantity above changes the motion.
#[test]
fn every_part_of_a_hand_moves_its_device() {
    let of = |hand: WorldHand, drivetrain| {
        let scene = held(hand, drivetrain);
        let ideal = WorldIdeal::new(&scene, Grid::even(0.0, PERIOD, PERIODS)).unwrap();
        ideal.states[PERIODS].devices[0].position
    };
    let none = Drivetrain::default();
    let bare = of(
        WorldHand {
            mass: 0.0,
            ..hand()
        },
        none,
    );
    for (name, hand, drivetrain) in [
        ("mass", hand(), none),
        ("swing", swinging(), none),
        ("path", led(), none),
        ("release", released(hand()), none),
        ("viscous", hand(), rubbing(0.0)),
        ("rough", hand(), rubbing(0.3)),
    ] {
        let moved = of(hand, drivetrain);
        let off = (0..3).map(|axis| (moved[axis] - bare[axis]).abs());
        assert!(off.fold(0.0, f64::max) > 1e-6, "{name}");
    }
}

/// The angular momentum of a released device is constant.
#[test]
fn a_released_device_turns_freely() {
    let mut scene = held(released(hand()), Drivetrain::default());
    scene.devices[0].own_axes = None;
    scene.devices[0].turning = Some(Turning {
        inertia: [1e-4; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: [0.4, 0.0, 0.0],
        gives_torque: true,
        quantum: 0.0,
        hand: TurningHand {
            torque: [0.0, 0.002, 0.0],
            stiffness: 0.01,
            damping: 1e-4,
            rest: [1.0, 0.0, 0.0, 0.0],
            tremor: Default::default(),
        },
    });
    let [off, books] = apart(&scene);
    assert!(off < 1e-9 && books < 1e-8, "{off} {books}");
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, PERIOD, PERIODS)).unwrap();
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(PERIOD)).unwrap();
    for _ in 0..PERIODS {
        plant.hold_wrenches(&[[0.0; 3]], &[]);
    }
    let of = |period: usize| ideal.states[period].devices[0].angular_velocity;
    for (axis, turning) in plant.angular_velocities()[0].into_iter().enumerate() {
        assert!((turning - of(PERIODS)[axis]).abs() < 1e-8);
        assert!((of(PERIODS)[axis] - of(40)[axis]).abs() < 1e-9);
    }
    assert!((of(40)[1] - of(30)[1]).abs() > 1e-3);
}

#[test]
fn a_limited_motor_and_a_noisy_sensor_are_those_of_the_loop_alone() {
    let limited = Drivetrain {
        largest_force: 0.5,
        noise: 1e-5,
        ..Drivetrain::default()
    };
    let scene = held(WorldHand::default(), limited);
    let bare = held(WorldHand::default(), Drivetrain::default());
    let grid = || Grid::even(0.0, PERIOD, 3);
    assert_eq!(
        WorldIdeal::new(&scene, grid()).unwrap().states,
        WorldIdeal::new(&bare, grid()).unwrap().states
    );
    let params = |seed| PlantParams {
        seed,
        ..PlantParams::perfect(PERIOD)
    };
    let mut plants = [(&scene, 1), (&scene, 1), (&scene, 2), (&bare, 1)]
        .map(|(scene, seed)| WorldPlant::new(scene, params(seed)).unwrap());
    let [first, same, other, exact] = plants.each_mut().map(|plant| plant.measure()[0]);
    assert_eq!(first, same);
    assert_ne!(first, other);
    for axis in 0..3 {
        let noise = (first[axis] - exact[axis]).abs();
        assert!(noise > 0.0 && noise < 6e-5, "{noise}");
    }
    plants[0].hold(&[[0.0, 0.0, 2.0]]);
    assert!((plants[0].delivered(0)[0][2] - 0.5).abs() < 1e-12);
    assert_eq!(plants[0].given_force(0, [0.0, 0.0, -2.0]), [0.0, 0.0, -0.5]);
    assert!(plants[0].has_limits() && !plants[3].has_limits());
}

#[test]
fn what_is_wrong_with_a_hand_is_named() {
    for (hand, drivetrain, says) in [
        (
            WorldHand {
                mass: -1.0,
                ..hand()
            },
            Drivetrain::default(),
            "devices[0].hand.mass = -1",
        ),
        (
            WorldHand {
                release: Some(f64::NAN),
                ..hand()
            },
            Drivetrain::default(),
            "devices[0].hand.release",
        ),
        (
            hand(),
            rubbing(-0.1),
            "devices[0].drivetrain.friction = -0.1",
        ),
    ] {
        let scene = held(hand, drivetrain);
        let said = WorldPlant::new(&scene, PlantParams::perfect(PERIOD))
            .unwrap_err()
            .to_string();
        assert!(said.starts_with(says), "{said}");
    }
}
