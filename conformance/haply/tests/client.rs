//! The vendor's client, an independent program, connects to the emulator, reads, sends forces and observes the device's
//! motion.

use std::time::Duration;

use haply::HaplyDevice;
use haply::device_model::{Config, DeviceType, Force, ForceInput, ProfileConfig, SessionConfigure};
use haply::events::EventChannel;
use haply::http::InverseHttpClient;
use palpate_drivers::emulator::inverse3::{Emulator, EmulatorOptions};
use palpate_drivers::inverse3::Form;

const ID: &str = "049D";

fn emulator(form: Form) -> Emulator {
    Emulator::start(&EmulatorOptions {
        form,
        ..EmulatorOptions::default()
    })
    .unwrap()
}

async fn client(emulator: &Emulator) -> HaplyDevice {
    let http = format!("http://{}", emulator.address());
    let device = HaplyDevice::new(&http, &emulator.url()).await.unwrap();
    // Its listener receives the first frame asynchronously.
    for _ in 0..500 {
        if !device.read_state().await.unwrap().inverse3.is_empty() {
            return device;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("the client has not understood the frame on connect");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_client_understands_the_frame_on_connect() {
    for form in [Form::V31, Form::V35] {
        let emulator = emulator(form);
        let device = client(&emulator).await;
        let state = device.read_state().await.unwrap();
        assert_eq!(state.session_id, 1);
        let inverse3 = &state.inverse3[0];
        assert_eq!(inverse3.device_id, ID);
        let config = inverse3.config.as_ref().unwrap();
        assert_eq!(config.type_, DeviceType::Inverse3);
        assert_eq!(config.device_info.device_type, DeviceType::Inverse3);
        assert_eq!(
            config.coordinate_system.as_ref().unwrap().permutation,
            "XYZ"
        );
        assert!(inverse3.status.calibrated && inverse3.status.ready);
        assert!(inverse3.status.power_supply && inverse3.status.started);
        assert!(!inverse3.status.in_use);
        assert_eq!(
            <[f32; 3]>::from(inverse3.state.cursor_position.unwrap()),
            [0.0; 3]
        );
        let Config::DeviceConfig(listed) = &device.get_devices().await.unwrap()[0] else {
            panic!("not listed as an Inverse3");
        };
        assert_eq!(listed, config);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_clients_force_moves_the_device() {
    let emulator = emulator(Form::V35);
    let mut device = client(&emulator).await;
    let profile = SessionConfigure {
        profile: Some(ProfileConfig {
            name: "conformance".into(),
            required_version: Some(">=3.5".into()),
        }),
        ..SessionConfigure::default()
    };
    device.configure_session(profile, Some(true)).await.unwrap();
    let mut position = [0.0; 3];
    // Against a hand of 100 N/m at the origin: 1.5 N end at 15 mm.
    for _ in 0..1000 {
        let force = ForceInput {
            device_id: ID.into(),
            forces: Force {
                x: 0.0,
                y: 0.0,
                z: 1.5,
            },
        };
        device
            .update_force(vec![force], Some(true), Some(true))
            .await
            .unwrap();
        tokio::time::sleep(Duration::from_millis(2)).await;
        let state = device.read_state().await.unwrap();
        position = state.inverse3[0].state.cursor_position.unwrap().into();
        if position[2] > 0.014 {
            break;
        }
    }
    assert!(position[2] > 0.014 && position[0] == 0.0, "{position:?}");
    let state = device.read_state().await.unwrap();
    let force: [f32; 3] = state.inverse3[0].state.current_cursor_force.unwrap().into();
    assert_eq!(force, [0.0, 0.0, 1.5]);
    assert_eq!(emulator.force(ID), Some([0.0, 0.0, 1.5]));
    let served = emulator.served();
    assert_eq!(served.configured, 1);
    // One answer to each message, except for one in transit.
    assert!(served.messages - served.replies <= 1, "{served:?}");
    device.shutdown().await.unwrap();
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(emulator.force(ID), Some([0.0; 3]), "it idles");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_clients_probes_and_pings_are_answered_and_command_nothing() {
    let emulator = emulator(Form::V35);
    let mut device = client(&emulator).await;
    device.send_ping().await.unwrap();
    device
        .probe_cursor_position(vec![ID.into()], Some(true))
        .await
        .unwrap();
    device
        .force_read_full_state(Some(Duration::from_secs(5)))
        .await
        .unwrap();
    for _ in 0..500 {
        if emulator.served().replies >= 3 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(
        (emulator.served().messages, emulator.served().replies),
        (3, 3)
    );
    assert!(
        emulator
            .received()
            .iter()
            .all(|message| message.force.is_none())
    );
    assert!(
        device.read_state().await.unwrap().inverse3[0]
            .config
            .is_some()
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_clients_requests_are_answered() {
    let emulator = emulator(Form::V35);
    let http = InverseHttpClient::new(&format!("http://{}", emulator.address()));
    let version = http.get_version().await.unwrap();
    assert!(version.project_name.contains("emulator"), "{version:?}");
    let devices = http.get_devices().await.unwrap();
    assert_eq!(devices.len(), 1);
    assert_eq!(devices[0].id(), ID);
    // Requests outside the emulation are rejected instead of answered wrongly.
    assert!(http.get_sessions().await.is_err());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_clients_events_are_ours() {
    let emulator = emulator(Form::V35);
    let mut events = EventChannel::new(&emulator.events_url()).await.unwrap();
    emulator.set_present(ID, false);
    emulator.set_present(ID, true);
    let mut names = Vec::new();
    for _ in 0..500 {
        names.extend(
            events
                .read_events()
                .await
                .iter()
                .map(|heard| heard.event.name()),
        );
        if names.len() >= 2 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(names, ["device-disconnected", "device-connected"]);
    let _ = tokio::time::timeout(Duration::from_secs(1), events.shutdown()).await;
}
