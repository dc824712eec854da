//! The vendor's types and this project's types parse each other's text.

use haply::device_model::{
    ControlDomain, ControlMode, DeviceConfig, DeviceMode, DeviceType, Inverse3Device,
    Inverse3Message, Inverse3OutMsg, Inverse3State, Inverse3Status, ServiceData, ServiceState,
    SessionMsg, Transform, Vec3D,
};
use palpate_drivers::inverse3::{Commands, Form, Frame, Model, Unfit};

fn state(position: [f32; 3], velocity: [f32; 3]) -> Inverse3State {
    Inverse3State {
        cursor_position: Some(position.into()),
        cursor_velocity: Some(velocity.into()),
        mode: DeviceMode::Idle,
        control_domain: Some(ControlDomain::Cartesian),
        control_mode: Some(ControlMode::Force),
        transform: Some(Transform::default()),
        current_cursor_force: Some(Vec3D {
            x: 0.5,
            y: 0.0,
            z: -0.25,
        }),
        ..Inverse3State::default()
    }
}

const READY: Inverse3Status = Inverse3Status {
    calibrated: true,
    in_use: false,
    power_supply: true,
    ready: true,
    started: true,
    navigation: None,
};

fn near(ours: [f64; 3], theirs: [f32; 3]) {
    for (ours, theirs) in ours.into_iter().zip(theirs) {
        assert!((ours - f64::from(theirs)).abs() < 1e-7, "{ours} {theirs}");
    }
}

#[test]
fn a_full_frame_of_their_types_is_read() {
    let (position, velocity) = ([0.02, -0.0276, 0.199], [0.0, 1e-3, -0.25]);
    let data = ServiceData {
        session_id: 9,
        inverse3: vec![Inverse3Device {
            device_id: "04BA".into(),
            config: Some(DeviceConfig {
                type_: DeviceType::Inverse3x,
                ..DeviceConfig::default()
            }),
            state: state(position, velocity),
            status: READY,
        }],
        ..ServiceData::default()
    };
    let frame = Frame::parse(&serde_json::to_string(&data).unwrap()).unwrap();
    assert_eq!(frame.session_id, Some(9));
    let device = frame.device("04BA").unwrap();
    assert_eq!(device.model(), Some(&Model::Inverse3x));
    assert_eq!(Unfit::at_first(device), None);
    let sample = device.sample().unwrap();
    near(sample.position, position);
    near(sample.velocity.unwrap(), velocity);
    near(sample.force.unwrap(), [0.5, 0.0, -0.25]);
}

#[test]
fn a_state_frame_of_their_types_is_read() {
    let data = ServiceState {
        inverse3: vec![Inverse3Message {
            device_id: "04BA".into(),
            state: state([0.1, 0.2, 0.3], [0.0; 3]),
            status: Inverse3Status {
                power_supply: false,
                ..READY
            },
        }],
        ..ServiceState::default()
    };
    let frame = Frame::parse(&serde_json::to_string(&data).unwrap()).unwrap();
    let device = frame.device("04BA").unwrap();
    assert!(device.is_of_3_5());
    near(device.sample().unwrap().position, [0.1, 0.2, 0.3]);
    assert_eq!(Unfit::new(&device.status), Some(Unfit::NoPower));
}

#[test]
fn our_messages_are_read_by_their_types() {
    let mut commands = Commands::new("04BA", Form::V35);
    let message = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let first = message(commands.force([0.5, -1.0, 2.0]).unwrap());
    let session: SessionMsg = serde_json::from_value(first["session"].clone()).unwrap();
    assert!(
        session
            .configure
            .unwrap()
            .profile
            .unwrap()
            .name
            .contains("palpate")
    );
    let sent: Inverse3OutMsg = serde_json::from_value(first["inverse3"][0].clone()).unwrap();
    assert_eq!(sent.device_id, "04BA");
    assert!(sent.configure.is_none());
    let force = sent.commands.unwrap().set_cursor_force.unwrap();
    assert!(force.execute);
    assert_eq!(<[f32; 3]>::from(force.vector), [0.5, -1.0, 2.0]);
    let probe = message(commands.probe());
    let sent: Inverse3OutMsg = serde_json::from_value(probe["inverse3"][0].clone()).unwrap();
    let asked = sent.commands.unwrap();
    assert!(asked.probe_position.is_some() && asked.set_cursor_force.is_none());
}
