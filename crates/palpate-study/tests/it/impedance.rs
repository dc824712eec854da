//! The impedance that a hand feels in a rendered contact, against closed forms.

use std::f64::consts::TAU;

use palpate_core::ParameterValue;
use palpate_scene::Model;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_study::impedance::FeltImpedance;
use palpate_study::map::{Bounce, BounceDevice, Forces};

const STIFFNESS: f64 = 1000.0;
const PERIOD: f64 = 1e-3;

fn wall() -> Bounce {
    Bounce {
        device: BounceDevice {
            mass: 0.3,
            viscous_friction: 0.5,
            coulomb_friction: 0.0,
            encoder_quantum: 0.0,
            model_mass: 1.0,
        },
        stiffness: STIFFNESS,
        object_mass: f64::INFINITY,
        forces: Forces::Balanced(1.0),
        gap: 0.01,
        period: PERIOD,
        model_period: 1.0,
        delay: 0.0,
        lag: 0.0,
        model: Model::default(),
    }
}

fn felt(bounce: Bounce, method: MethodName, settings: Settings, frequency: f64) -> FeltImpedance {
    let felt = bounce.impedance(method, settings, frequency).unwrap();
    felt.unwrap_or_else(|| panic!("{method} at {frequency} Hz does not settle"))
}

fn assert_near(found: f64, right: f64, tolerance: f64) {
    assert!((found - right).abs() <= tolerance, "{found}, not {right}");
}

/// A held spring has K e^(−jωT/2) sin(ωT/2)/(ωT/2): a damping of −K T/2 at low frequencies.
#[test]
fn a_sampled_spring_feels_as_its_hold_makes_it() {
    for frequency in [1.0, 10.0, 100.0] {
        let felt = felt(wall(), MethodName::Basic, Settings::default(), frequency);
        let omega = TAU * frequency;
        let half = 0.5 * omega * PERIOD;
        let magnitude = STIFFNESS * half.sin() / half;
        assert_near(felt.wanted.stiffness, STIFFNESS, 1e-9);
        assert_near(felt.wanted.damping, 0.0, 0.0);
        assert_near(felt.rendered.stiffness, magnitude * half.cos(), 1e-6);
        assert_near(felt.rendered.damping, -magnitude * half.sin() / omega, 1e-6);
        let with_device = felt.with_device;
        assert_near(
            with_device.stiffness,
            felt.rendered.stiffness - 0.3 * omega * omega,
            1e-6,
        );
        assert_near(with_device.damping, felt.rendered.damping + 0.5, 1e-9);
    }
}

/// Delay and lag add to the half period of the hold.
#[test]
fn delay_and_lag_take_damping_from_a_spring() {
    let late = Bounce {
        delay: 1.3,
        lag: 0.4e-3,
        ..wall()
    };
    let felt = felt(late, MethodName::Basic, Settings::default(), 1.0);
    let angle = TAU * 1.8e-3 + (TAU * 0.4e-3).atan();
    assert_near(felt.rendered.stiffness, STIFFNESS * angle.cos(), 0.01);
    assert_near(felt.rendered.damping, -STIFFNESS * 2.2e-3, 2e-3);
}

#[test]
fn a_damper_adds_its_damping() {
    let damped = Settings::default().with(SettingKey::DAMPING, ParameterValue::Number(0.8));
    let felt = felt(wall(), MethodName::VirtualDamper, damped, 1.0);
    assert_near(felt.rendered.damping, 0.8 - STIFFNESS * PERIOD / 2.0, 1e-3);
}

/// A light object is felt as its mass, a stiff wall as itself, by the method that knows the device.
#[test]
fn coupled_rendering_feels_like_the_contact() {
    let object = Bounce {
        object_mass: 0.1,
        ..wall()
    };
    for frequency in [1.0, 3.0, 10.0] {
        let felt = felt(object, MethodName::Coupled, Settings::default(), frequency);
        assert_near(felt.wanted.mass(frequency), 0.1, 0.1);
        assert_near(
            felt.rendered.mass(frequency) / felt.wanted.mass(frequency),
            1.0,
            0.02,
        );
    }
    let hold = STIFFNESS * PERIOD / 2.0;
    let felt = felt(wall(), MethodName::Coupled, Settings::default(), 3.0);
    assert_near(felt.rendered.stiffness, STIFFNESS, 0.02 * STIFFNESS);
    assert_near(felt.rendered.damping, 0.0, 0.2 * hold);
}
