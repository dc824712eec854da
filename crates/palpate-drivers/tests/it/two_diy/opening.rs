use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};

use palpate_drivers::emulator::two_diy::Wiring;
use palpate_drivers::two_diy::LARGEST_TORQUE;
use palpate_testbed::pantograph::kinematics::Geometry;

use super::*;

#[test]
fn every_generation_opens_on_every_board_and_makes_the_force_it_is_asked_for() {
    let _alone = alone();
    for generation in Generation::ALL {
        for board in Board::ALL {
            for strict in [true, false] {
                let what = format!("{generation:?} {board:?} strict {strict}");
                let emulator = Emulator::start(&on_a_socket(Settings {
                    strict,
                    ..Settings::new(generation, board)
                }))
                .unwrap();
                let options = Options {
                    board: Some(board),
                    ..Options::new(generation, Calibration::Retracted, SLOW).unwrap()
                };
                let mut device =
                    TwoDiy::open(&emulator.path(), &options, MonotonicClock::new()).unwrap();
                let quantum = board.quantum(&options.layout, 0);
                let reading = sample(&mut device);
                for (read, true_angle) in device.angles().into_iter().zip(emulator.angles()) {
                    let off = f64::from(read) - true_angle;
                    assert!(off.abs() <= 1.01 * quantum, "{what}: {off}");
                }
                // Kinematics of the testbed as reference solution, not the driver's.
                let links = options.layout.geometry;
                let reference = Geometry::new(links.proximal, links.distal, links.base).unwrap();
                let angles = device.angles().map(|angle| f64::from(angle).to_radians());
                let pose = reference.forward(angles).unwrap();
                for k in 0..2 {
                    assert!(
                        (reading.position[k] - pose.position[k]).abs() < 1e-9,
                        "{what}"
                    );
                }
                let force = [0.3, 0.2];
                let given = device
                    .write([force[0], force[1], 0.0].into())
                    .unwrap()
                    .force;
                for k in 0..2 {
                    assert!((given[k] - force[k]).abs() < 0.01, "{what}: {given:?}");
                }
                let asked = pose.torques(force);
                wait_until(&what, || !is_none(emulator.torques()));
                let step = f64::from(LARGEST_TORQUE) / board.duty_steps();
                for (held, asked) in emulator.torques().into_iter().zip(asked) {
                    assert!((held - asked).abs() < 1.01 * step, "{what}: {held} {asked}");
                }
                device.close().unwrap();
                assert!(is_none(emulator.torques()), "{what}");
                came_whole_and_without_torque_at_resets(&emulator.seen());
            }
        }
    }
}

#[test]
fn the_board_is_found_by_its_first_angles() {
    let _alone = alone();
    for (generation, board, found) in [
        (Generation::Three, Board::M0, Board::M0),
        (Generation::Three, Board::M3, Board::M3),
        // Identical to an M3 for the driver.
        (Generation::Three, Board::DevKit, Board::M3),
        (Generation::Two, Board::M0, Board::M0),
        (Generation::Two, Board::M3, Board::M3),
        // 180 and 0 degrees are whole counts of every board.
        (Generation::One, Board::M0, Board::M3),
    ] {
        let emulator = Emulator::start(&Settings::new(generation, board)).unwrap();
        let options = Options::new(generation, Calibration::Retracted, SLOW).unwrap();
        let device = open_on_a_terminal(&emulator.path(), &options);
        assert_eq!(device.board(), found, "{generation:?} {board:?}");
    }
}

#[test]
fn open_errors_name_wrong_board_and_missing_device() {
    let _alone = alone();
    let settings = on_a_socket(Settings::new(Generation::Three, Board::M3));
    let emulator = Emulator::start(&settings).unwrap();
    let options = Options {
        board: Some(Board::M0),
        ..Options::new(Generation::Three, Calibration::Retracted, SLOW).unwrap()
    };
    let open = |path: &std::path::Path, options: &Options| {
        TwoDiy::open(path, options, MonotonicClock::new()).unwrap_err()
    };
    let error = open(&emulator.path(), &options);
    assert!(
        matches!(
            error,
            OpenError::OtherBoard {
                found: Board::M3,
                ..
            }
        ),
        "{error}"
    );
    let missing = open("/dev/tty-no-such".as_ref(), &options);
    assert!(matches!(missing, OpenError::NotThere(_)), "{missing}");
    let file = open(env!("CARGO_MANIFEST_PATH").as_ref(), &options);
    assert!(matches!(file, OpenError::NotSerial(_)), "{file}");
    let extended = Options::new(Generation::Two, Calibration::Extended, SLOW).unwrap_err();
    assert!(matches!(extended, OpenError::NotPublished), "{extended}");
    let unreachable = Calibration::At([180.0, 10.0]);
    let pose = Options::new(Generation::One, unreachable, SLOW);
    assert!(pose.is_ok(), "{pose:?}");
    let singular = Options::new(Generation::Two, Calibration::At([90.0, 90.0]), SLOW);
    assert!(
        matches!(singular, Err(OpenError::StartPose(_))),
        "{singular:?}"
    );
}

/// A busy system delivers an answer from before the arm moved, and then a current one.
#[test]
fn the_first_angles_are_those_of_the_last_answer() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("port");
    let listener = UnixListener::bind(&port).unwrap();
    let [first, second] = MIDDLE;
    let moved = [first + 3.0, second];
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut stream = listener.accept().unwrap().0;
            let layout = Generation::Three.layout();
            let answer = |angles: [f32; 2]| {
                let [first, second] = layout.by_encoder_port(angles).map(f32::to_le_bytes);
                [&[layout.device_id][..], &first, &second].concat()
            };
            let answers = [answer(MIDDLE), answer(moved)].concat();
            let mut packets = [0; 64];
            // Until the driver disconnects.
            while stream.read(&mut packets).is_ok_and(|read| read > 0) {
                if stream.write_all(&answers).is_err() {
                    break;
                }
            }
        });
        let error = open_at(&port, SLOW).unwrap_err();
        let OpenError::NotInPose { angles, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(angles, moved);
    });
}

/// Incomplete answers still identify a board; another first byte does not.
#[test]
fn incomplete_answer_is_distinguished_from_answer_of_other_device() {
    let id = Generation::Three.layout().device_id;
    let said = |answer: &'static [u8]| {
        let folder = tempfile::tempdir().unwrap();
        let port = folder.path().join("port");
        let listener = UnixListener::bind(&port).unwrap();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let mut stream = listener.accept().unwrap().0;
                let mut packets = [0; 64];
                while stream.read(&mut packets).is_ok_and(|read| read > 0) {
                    if stream.write_all(answer).is_err() {
                        break;
                    }
                }
            });
            open_at(&port, SLOW).unwrap_err()
        })
    };
    assert_eq!(id, 5);
    let broken = said(&[5, 0]);
    assert!(matches!(broken, OpenError::BrokenAnswer(5)), "{broken}");
    let other = said(&[6, 0]);
    let is_another = matches!(other, OpenError::WrongAnswer { asked: 5, first: 6 });
    assert!(is_another, "{other}");
}

/// Also for a privileged user, whom the kernel alone would let in.
#[test]
fn a_port_belongs_to_one_program_at_a_time() {
    let _alone = alone();
    let emulator = Emulator::start(&in_the_middle(Hand::at(THERE))).unwrap();
    let options = Options::new(Generation::Three, Calibration::At(MIDDLE), SLOW).unwrap();
    let device = open_on_a_terminal(&emulator.path(), &options);
    let set_up = || {
        let seen = emulator.seen();
        seen.iter()
            .filter(|seen| matches!(seen.did, Did::Reset | Did::SetUp))
            .count()
    };
    let before = set_up();
    let error = open_at(&emulator.path(), SLOW).unwrap_err();
    assert!(matches!(error, OpenError::InUse(_)), "{error}");
    assert_eq!(set_up(), before, "the board was spoken to");
    // The port is free as soon as it is closed.
    device.close().unwrap();
    open_on_a_terminal(&emulator.path(), &options);
}

const PORT: &str = "PALPATE_TEST_PORT";

/// Program that the test below kills.
#[test]
#[ignore = "the body of a child process of another test"]
fn a_program_that_holds_a_torque() {
    let port = std::env::var_os(PORT).expect("the port to hold a torque on");
    let mut device = open_at(port.as_ref(), SLOW).unwrap();
    sample(&mut device);
    device.write([0.0, 1.0, 0.0].into()).unwrap();
    loop {
        std::thread::park();
    }
}

/// A program was killed while a torque was on, in the middle of a packet.
#[test]
fn a_board_left_with_a_torque_in_the_middle_of_a_packet_is_taken_over_without_one() {
    let _alone = alone();
    for cut in [0, 1, 3, 9] {
        let settings = on_a_socket(in_the_middle(Hand::at(THERE)));
        let emulator = Emulator::start(&settings).unwrap();
        let body = "two_diy::opening::a_program_that_holds_a_torque";
        let mut holder = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["--exact", body, "--ignored"])
            .env(PORT, emulator.path())
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        wait_until("the torque", || !is_none(emulator.torques()));
        holder.kill().unwrap();
        holder.wait().unwrap();
        let stray =
            palpate_drivers::two_diy::packet::state(&Generation::Three.layout(), [0.1, 0.1]);
        let mut left = UnixStream::connect(emulator.path()).unwrap();
        left.write_all(&stray[..cut]).unwrap();
        drop(left);
        std::thread::sleep(Duration::from_millis(50));
        let mut device = open_in_the_middle(&emulator, SLOW);
        sample(&mut device);
        assert!(is_none(emulator.torques()), "{cut}");
        let seen = emulator.seen();
        let resets = seen.iter().filter(|seen| seen.did == Did::Reset);
        if cut == 0 {
            assert!(resets.clone().count() > 0);
            for reset in resets {
                assert!(is_none(reset.torques), "{reset:?}");
            }
        }
    }
}

#[test]
fn a_wrong_start_pose_is_no_secret_of_the_wiring() {
    let _alone = alone();
    // The driver cannot detect an arm that is not in the declared pose. It does detect a hand that moves the arm
    // between SETUP and the first answer.
    let emulator = Emulator::start(&on_a_socket(Settings {
        wiring: Wiring::default(),
        ..in_the_middle(Hand::Push([30.0, 0.0]))
    }))
    .unwrap();
    let options = Options::new(Generation::Three, Calibration::At(MIDDLE), SLOW).unwrap();
    let error = TwoDiy::open(&emulator.path(), &options, MonotonicClock::new()).unwrap_err();
    assert!(matches!(error, OpenError::NotInPose { .. }), "{error}");
}
