//! Content of recordings from C: the numbers of each tick, bit for bit, and the number of ticks.
#![cfg(feature = "worlds")]

use std::ffi::CString;
use std::mem::MaybeUninit;
use std::path::Path;
use std::ptr;

use palpate_c::*;
use palpate_record::recording::{Flags, Recording, Row};

/// A wall of 1 kN/m.
fn wall() -> *mut Contact<f64> {
    wall_in(|_| ())
}

/// The wall in a loop of 1 kHz with other settings.
fn wall_in(set: impl FnOnce(&mut LoopParams)) -> *mut Contact<f64> {
    let mut loop_params = MaybeUninit::<LoopParams>::uninit();
    let mut params = MaybeUninit::<ContactParams>::uninit();
    let mut contact = ptr::null_mut();
    // SAFETY: the stated number of bytes can be written, and all of them are written before they are read.
    unsafe {
        palpate_loop_params_init(loop_params.as_mut_ptr(), size_of::<LoopParams>());
        palpate_contact_params_init(params.as_mut_ptr(), size_of::<ContactParams>());
        let (mut loop_params, mut params) = (loop_params.assume_init(), params.assume_init());
        loop_params.period = 0.001;
        set(&mut loop_params);
        params.method = c"basic".as_ptr();
        params.stiffness = 1000.0;
        let status = palpate_contact_new(&params, &loop_params, &mut contact);
        assert_eq!(status, Status::Ok);
    }
    contact
}

fn in_c(path: &Path) -> CString {
    CString::new(path.to_str().unwrap()).unwrap()
}

fn sample(device_position: f64, elapsed: Option<f64>) -> Sample<f64> {
    Sample {
        struct_size: size_of::<Sample<f64>>(),
        device_position,
        elapsed: elapsed.unwrap_or(0.0),
        virtual_force: 0.0,
        has_elapsed: elapsed.is_some().into(),
        reserved: 0,
    }
}

fn rows(path: &Path) -> (Recording, Vec<Row>) {
    let recording = Recording::open(path).unwrap();
    let rows = recording.rows().unwrap().map(Result::unwrap).collect();
    (recording, rows)
}

#[test]
fn a_contact_is_recorded_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("contact.mcap");
    let contact = wall();
    let mut recorder = ptr::null_mut();
    // The third sample is rejected, the fourth is late, and half of the last force was sent.
    let ticks = [
        (-0.001, None, 1.0),
        (0.001, None, 1.0),
        (f64::NAN, None, 1.0),
        (0.002, Some(0.003), 1.0),
        (0.003, None, 0.5),
    ];
    let mut forces = Vec::new();
    // SAFETY: contact and recorder live until they are freed; each struct states its size.
    unsafe {
        let status =
            palpate_recorder_of_contact(contact, in_c(&path).as_ptr(), ptr::null(), &mut recorder);
        assert_eq!(status, Status::Ok);
        for (position, elapsed, share) in ticks {
            let sample = sample(position, elapsed);
            let mut output = Output {
                struct_size: size_of::<Output<f64>>(),
                ..std::mem::zeroed()
            };
            let force = palpate_contact_step(contact, &sample, &mut output);
            let sent = share * force;
            let status =
                palpate_recorder_contact_tick(recorder, contact, &sample, &output, sent, 0.0);
            assert_eq!(status, Status::Ok);
            forces.push((force, sent, output.penetration));
        }
        assert_eq!(
            palpate_recorder_close(recorder, ptr::null_mut()),
            Status::Ok
        );
        palpate_contact_free(contact);
    }
    let (recording, rows) = rows(&path);
    assert!(recording.is_complete());
    assert_eq!((recording.ticks_made(), recording.lost()), (Some(5), 0));
    assert!(recording.metadata.texts["contact"].contains("a wall of 1000 N/m"));
    assert_eq!(rows.len(), 5);
    let times = [0.0, 0.001, 0.002, 0.005, 0.006];
    for (number, (row, (force, sent, penetration))) in (0..).zip(rows.iter().zip(&forces)) {
        let (tick, contact) = (row.tick, row.contact);
        let is_refused = number == 2;
        assert_eq!(
            (tick.sequence, contact.sequence),
            (number as u64, number as u64)
        );
        assert!((tick.time - times[number]).abs() < 1e-15);
        let position = ticks[number].0;
        assert_eq!(tick.device_axes[0].to_bits(), position.to_bits());
        assert_eq!(tick.commanded_force, [*force, 0.0, 0.0]);
        assert_eq!(
            (tick.delivered_force[0], contact.force_on_device),
            (*sent, *sent)
        );
        assert_eq!(contact.penetration, *penetration);
        assert_eq!(tick.flags.has(Flags::FAULT), is_refused);
        assert_eq!(tick.flags.has(Flags::CONTACT), position > 0.0);
    }
    assert_eq!(forces[1], (-1.0, -1.0, 0.001));
    assert!(forces[4].1 < 0.0 && forces[4].1 == 0.5 * forces[4].0);
}

#[test]
fn an_interval_beyond_the_acceleration_of_the_guard_is_reported_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("contact.mcap");
    let contact = wall_in(|loop_params| {
        loop_params.guard = GuardKind::Report as u32;
        loop_params.guard_speed = 1.0;
        loop_params.guard_acceleration = 80.0;
        loop_params.guard_mass = 0.2;
    });
    let mut recorder = ptr::null_mut();
    let mut limited = Vec::new();
    // 0.2 mm more within a millisecond is 200 m/s^2.
    let positions = [-1e-3, -1e-3, -0.8e-3, -0.6e-3];
    // SAFETY: contact and recorder live until they are freed; each struct states its size.
    unsafe {
        let status =
            palpate_recorder_of_contact(contact, in_c(&path).as_ptr(), ptr::null(), &mut recorder);
        assert_eq!(status, Status::Ok);
        for position in positions {
            let sample = sample(position, None);
            let mut output = Output {
                struct_size: size_of::<Output<f64>>(),
                ..std::mem::zeroed()
            };
            let force = palpate_contact_step(contact, &sample, &mut output);
            let status =
                palpate_recorder_contact_tick(recorder, contact, &sample, &output, force, 0.0);
            assert_eq!((status, force), (Status::Ok, 0.0));
            limited.push(output.limited);
        }
        let status = palpate_recorder_close(recorder, ptr::null_mut());
        assert_eq!(status, Status::Ok);
        palpate_contact_free(contact);
    }
    assert_eq!(limited, [0, 0, Limit::BeyondGuard as u32, 0]);
    let recorded = rows(&path).1;
    let beyond = recorded
        .iter()
        .map(|row| row.tick.flags.has(Flags::BEYOND_GUARD));
    assert!(beyond.eq([false, false, true, false]));
}

#[test]
fn each_device_of_a_world_has_a_recording_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/worlds/pinch.toml");
    let paths = [
        folder.path().join("left.mcap"),
        folder.path().join("right.mcap"),
    ];
    let mut world = ptr::null_mut();
    let mut recorders = [ptr::null_mut(); 2];
    let mut model = Vec::new();
    // SAFETY: world and recorders live until they are freed; each struct states its size, and there is one pose and
    // wrench per device.
    unsafe {
        let status = palpate_world_open(in_c(&scene).as_ptr(), ptr::null(), &mut world);
        assert_eq!(status, Status::Ok);
        for (device, path) in paths.iter().enumerate() {
            let (path, recorder) = (in_c(path), &mut recorders[device]);
            let status =
                palpate_recorder_of_device(world, device, path.as_ptr(), ptr::null(), recorder);
            assert_eq!(status, Status::Ok);
        }
        for tick in 0..200 {
            let inwards = 2e-6 * f64::from(tick);
            let poses = [-1.0, 1.0].map(|side| Pose {
                position: [side * (0.0202 - inwards), 0.0, 0.016],
                orientation: [1.0, 0.0, 0.0, 0.0],
            });
            let sample = WorldSample {
                struct_size: size_of::<WorldSample>(),
                poses: poses.as_ptr(),
                pose_count: 2,
                ..std::mem::zeroed()
            };
            let mut output = WorldOutput {
                struct_size: size_of::<WorldOutput>(),
                ..std::mem::zeroed()
            };
            let mut wrenches: [Wrench; 2] = std::mem::zeroed();
            palpate_world_step(world, &sample, wrenches.as_mut_ptr(), 2, &mut output);
            for (recorder, wrench) in recorders.iter().zip(&wrenches) {
                // Half of the force is sent.
                let sent = Wrench {
                    force: wrench.force.map(|x| x / 2.0),
                    ..*wrench
                };
                let status = palpate_recorder_world_tick(*recorder, world, &sample, &output, &sent);
                assert_eq!(status, Status::Ok);
            }
            model.push((poses, wrenches));
        }
        for recorder in recorders {
            assert_eq!(
                palpate_recorder_close(recorder, ptr::null_mut()),
                Status::Ok
            );
        }
        palpate_world_free(world);
    }
    // Contacts and bodies are those of the world, for every recorded device.
    let rows = paths.each_ref().map(|path| rows(path));
    for (device, (recording, rows)) in rows.iter().enumerate() {
        let mut ticks: Vec<_> = rows.iter().map(|row| row.tick).collect();
        ticks.dedup_by_key(|tick| tick.sequence);
        assert_eq!(ticks.len(), model.len());
        for (tick, (poses, wrenches)) in ticks.iter().zip(&model) {
            assert_eq!(tick.device_axes, poses[device].position);
            assert_eq!(tick.commanded_force, wrenches[device].force);
            let half = wrenches[device].force.map(|x| x / 2.0);
            assert_eq!(tick.delivered_force, half);
        }
        let last = ticks.last().unwrap();
        // The fingers press inwards from both sides, and four corners of the cube rest on the table.
        let outwards = last.commanded_force[0] * [-1.0, 1.0][device];
        assert!(outwards > 0.01, "{outwards}");
        assert_eq!((last.contacts, last.bodies), (2 + 4, 1 + 2));
        let names = ["left", "right"];
        let which = format!("name = {:?}\nplace = {device}\nof = 2\n", names[device]);
        assert_eq!(recording.metadata.texts["device of the world"], which);
    }
}

#[test]
fn ticks_that_find_no_room_are_counted_and_missing_by_their_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.mcap");
    let contact = wall();
    let mut recorder = ptr::null_mut();
    let params = RecorderParams {
        struct_size: size_of::<RecorderParams>(),
        device: c"a knob".as_ptr(),
        scene: ptr::null(),
        room: 2,
    };
    let mut recorded = Recorded {
        struct_size: size_of::<Recorded>(),
        ticks_made: 0,
        ticks: 0,
        lost: 0,
    };
    let mut made = 0;
    // SAFETY: contact and recorder live until they are freed; each struct states its size.
    unsafe {
        let status =
            palpate_recorder_of_contact(contact, in_c(&path).as_ptr(), &params, &mut recorder);
        assert_eq!(status, Status::Ok);
        while palpate_recorder_lost(recorder) == 0 {
            let sample = sample(0.001, None);
            let mut output = Output {
                struct_size: size_of::<Output<f64>>(),
                ..std::mem::zeroed()
            };
            let force = palpate_contact_step(contact, &sample, &mut output);
            palpate_recorder_contact_tick(recorder, contact, &sample, &output, force, 0.0);
            made += 1;
        }
        assert_eq!(palpate_recorder_close(recorder, &mut recorded), Status::Ok);
        palpate_contact_free(contact);
    }
    assert_eq!((recorded.ticks_made, recorded.lost), (made, 1));
    let (recording, rows) = rows(&path);
    // The last tick was dropped, so only the loop's counter includes it.
    assert_eq!(rows.len() as u64, recorded.ticks);
    assert_eq!(recorded.ticks, made - 1);
    assert_eq!((recording.ticks_made(), recording.lost()), (Some(made), 1));
    assert!(!recording.is_complete());
    assert_eq!(recording.metadata.texts["device"], "name = \"a knob\"\n");
}
