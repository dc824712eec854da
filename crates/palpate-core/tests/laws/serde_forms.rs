//! Parameters as JSON and TOML.

use std::fmt::Debug;

use crate::common::methods;
use palpate_core::{
    Actuation, AnyParams, Contact, EntryHold, Guard, GuardParams, HandBound, HfcrParams,
    LeakDissipation, LoopParams, Mass, ObjectState, PopcParams, PopcRefParams, SehEstimate,
    SehParams, Side, VirtualDamperParams,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: T) {
    let json = serde_json::to_string(&value).unwrap();
    assert_eq!(serde_json::from_str::<T>(&json).unwrap(), value, "{json}");
    // A bare word or number is not a TOML document, so it needs a key.
    #[derive(Serialize, serde::Deserialize)]
    struct Under<T> {
        key: T,
    }
    let toml = toml::to_string(&Under { key: &value }).unwrap();
    let read: Under<T> = toml::from_str(&toml).unwrap();
    assert_eq!(read.key, value, "{toml}");
}

fn json<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}

#[test]
fn every_parameter_type_comes_back_from_json_and_toml() {
    for contact in [Contact::object(400.0, 0.1), Contact::wall(1e3)] {
        comes_back(contact);
        comes_back(contact.on(Side::Negative).pushing_only());
    }
    comes_back(Contact::object(400.0_f32, 0.1));
    comes_back(LoopParams::new(0.001));
    comes_back(LoopParams {
        period: 0.001,
        largest_gap: Some(0.01),
        speed_limit: None,
        force_limit: Some(5.0),
        slew_limit: Some(1e3),
        actuation: Actuation {
            delay_deviation: 1e-5,
            ..Actuation::after(0.0005).with_lag(0.0003).with_gain(0.98)
        },
        guard: Guard::Limit(GuardParams {
            largest_speed: 1.0,
            allowance: 1e-3,
            quantum: 1e-5,
            recovery: 0.01,
            hand: Some(HandBound::from_force(8.0, 0.1)),
        }),
    });
    comes_back(Actuation::after(0.0005).with_line());
    for mass in [Mass::Finite(0.1), Mass::Infinite] {
        comes_back(mass);
    }
    comes_back(ObjectState {
        position: 0.1,
        velocity: -0.5,
    });
    for (_, method) in methods::<f64>() {
        comes_back(method);
    }
    for (_, method) in methods::<f32>() {
        comes_back(method);
    }
    comes_back(AnyParams::Hfcr(HfcrParams {
        modified_force: false,
        smooth_transition: true,
        leak_dissipation: LeakDissipation::Auto { device_mass: 0.25 },
        ..HfcrParams::default()
    }));
}

#[test]
fn the_forms_are_the_documented_ones() {
    fn written(value: &impl Serialize) -> String {
        serde_json::to_string(value).unwrap()
    }
    assert_eq!(written(&Mass::Finite(0.5)), "0.5");
    assert_eq!(written(&Mass::<f64>::Infinite), "\"inf\"");
    assert_eq!(written(&AnyParams::<f64>::Basic), "\"basic\"");
    assert_eq!(written(&SehEstimate::Ab3), "\"ab3\"");
    assert_eq!(written(&Side::Negative), "\"negative\"");
    assert_eq!(
        written(&AnyParams::VirtualDamper(VirtualDamperParams::new(2.0))),
        r#"{"virtual-damper":{"damping":2.0,"object":"spring-and-damper","prediction":"last-step"}}"#
    );
    assert_eq!(written(&EntryHold::Midpoint), "\"midpoint\"");
}

#[test]
fn a_mass_is_any_number_or_inf_and_nothing_else() {
    assert_eq!(json::<Mass<f64>>("2").unwrap(), Mass::Finite(2.0));
    assert_eq!(json::<Mass<f64>>("-2").unwrap(), Mass::Finite(-2.0));
    let toml: Contact<f64> = toml::from_str("stiffness = 1.0\nobject_mass = inf").unwrap();
    assert_eq!(toml, Contact::wall(1.0));
    for wrong in ["\"heavy\"", "null", "true", "[1.0]"] {
        let error = json::<Mass<f64>>(wrong).unwrap_err();
        assert!(error.contains("a mass in kilograms or \"inf\""), "{error}");
    }
}

#[test]
fn what_is_left_out_is_as_the_paper_has_it() {
    let contact: Contact<f64> = json(r#"{"stiffness": 400.0, "object_mass": 0.1}"#).unwrap();
    assert_eq!(contact, Contact::object(400.0, 0.1));
    let hfcr: HfcrParams<f64> = json("{}").unwrap();
    assert_eq!(hfcr, HfcrParams::default());
    assert_eq!(json::<SehParams>("{}").unwrap(), SehParams::default());
    let damper: VirtualDamperParams<f64> = json(r#"{"damping": 2.0}"#).unwrap();
    assert_eq!(damper, VirtualDamperParams::new(2.0));
}

/// Files from before there were other predictions at constant velocity, and other interpretations.
#[test]
fn parameters_of_before_the_readings_are_read_as_they_were() {
    let hfcr: HfcrParams<f64> = json(
        r#"{"modified_force":true,"smooth_transition":true,"leak_dissipation":"off",
            "prediction":"constant-velocity"}"#,
    )
    .unwrap();
    assert_eq!(hfcr, HfcrParams::default());
}

#[test]
fn an_unknown_field_is_refused_by_every_parameter_type() {
    fn refuses<T: DeserializeOwned + Debug>(known: &str) {
        json::<T>(&format!("{{{known}}}")).unwrap();
        let comma = if known.is_empty() { "" } else { "," };
        let error = json::<T>(&format!("{{{known}{comma}\"stifness\":1.0}}")).unwrap_err();
        assert!(error.contains("stifness"), "{error}");
    }
    refuses::<Contact<f64>>(r#""stiffness":1.0,"object_mass":1.0"#);
    refuses::<LoopParams<f64>>(r#""period":0.001"#);
    refuses::<ObjectState<f64>>(r#""position":0.0,"velocity":0.0"#);
    refuses::<VirtualDamperParams<f64>>(r#""damping":1.0"#);
    refuses::<SehParams>("");
    refuses::<PopcParams<f64>>(r#""damping_cap":1.0,"speed_threshold":0.0,"initial_energy":0.0"#);
    refuses::<PopcRefParams<f64>>(r#""damping_cap":1.0,"speed_threshold":0.0"#);
    refuses::<HfcrParams<f64>>("");
    assert!(json::<AnyParams<f64>>("\"basics\"").is_err());
}
