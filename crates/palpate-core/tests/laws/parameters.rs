//! A parameter outside its range is rejected with its name, its value and the allowed range.

use palpate_core::{
    AnyParams, AnyRenderer, Contact, Difficulty, HfcrParams, LeakDissipation, LoopParams, Mass,
    Parameter, ParameterError, ParameterName as _, PopcParams, PopcRefParams, Renderer, Scalar,
    SettingKey, VirtualDamperParams,
};

fn contact<S: Scalar>() -> Contact<S> {
    Contact::object(S::from_f64(400.0), S::from_f64(0.1))
}

fn with_contact<S: Scalar>(contact: Contact<S>) -> Result<(), ParameterError> {
    let loop_params = LoopParams::new(S::from_f64(0.001));
    AnyRenderer::new(contact, loop_params, AnyParams::Basic).map(drop)
}

fn with_loop<S: Scalar>(change: impl Fn(&mut LoopParams<S>)) -> Result<(), ParameterError> {
    let mut loop_params = LoopParams::new(S::from_f64(0.001));
    change(&mut loop_params);
    AnyRenderer::new(contact(), loop_params, AnyParams::Basic).map(drop)
}

fn with_method<S: Scalar>(method: AnyParams<S>) -> Result<(), ParameterError> {
    Renderer::new(contact(), LoopParams::new(S::from_f64(0.001)), method).map(drop)
}

fn popc<S: Scalar>(change: impl Fn(&mut PopcParams<S>)) -> Result<(), ParameterError> {
    let mut params = PopcParams::new(S::from_f64(6.0));
    change(&mut params);
    with_method(AnyParams::Popc(params))
}

fn popc_ref<S: Scalar>(change: impl Fn(&mut PopcRefParams<S>)) -> Result<(), ParameterError> {
    let mut params = PopcRefParams::new(S::from_f64(6.0));
    change(&mut params);
    with_method(AnyParams::PopcRef(params))
}

fn hfcr<S: Scalar>(leak_dissipation: LeakDissipation<S>) -> Result<(), ParameterError> {
    with_method(AnyParams::Hfcr(HfcrParams {
        leak_dissipation,
        ..HfcrParams::default()
    }))
}

type Attempt<S> = fn(S) -> Result<(), ParameterError>;

/// Parameters that must be finite and greater than 0.
fn positive_parameters<S: Scalar>() -> Vec<(&'static str, &'static str, Attempt<S>)> {
    vec![
        ("stiffness", "N/m", |x| {
            with_contact(Contact::object(x, S::ONE))
        }),
        ("object_mass", "kg", |x| {
            with_contact(Contact {
                object_mass: Mass::Finite(x),
                ..contact()
            })
        }),
        ("period", "s", |x| with_loop(|l| l.period = x)),
        ("speed_limit", "m/s", |x| {
            with_loop(|l| l.speed_limit = Some(x))
        }),
        ("force_limit", "N", |x| {
            with_loop(|l| l.force_limit = Some(x))
        }),
        ("slew_limit", "N/s", |x| {
            with_loop(|l| l.slew_limit = Some(x))
        }),
        ("damping_cap", "N s/m", |x| popc(|p| p.damping_cap = x)),
        ("damping_cap", "N s/m", |x| popc_ref(|p| p.damping_cap = x)),
        ("device_mass", "kg", |device_mass| {
            hfcr(LeakDissipation::Auto { device_mass })
        }),
    ]
}

/// Parameters that must be finite and not below 0.
fn parameters_that_may_be_zero<S: Scalar>() -> Vec<(&'static str, &'static str, Attempt<S>)> {
    vec![
        ("damping", "N s/m", |damping| {
            with_method(AnyParams::VirtualDamper(VirtualDamperParams::new(damping)))
        }),
        ("damping", "N s/m", |b| hfcr(LeakDissipation::Damping(b))),
        ("speed_threshold", "m/s", |x| {
            popc(|p| p.speed_threshold = x)
        }),
        ("speed_threshold", "m/s", |x| {
            popc_ref(|p| p.speed_threshold = x)
        }),
        ("initial_energy", "J", |x| popc(|p| p.initial_energy = x)),
    ]
}

fn refused<S: Scalar>((name, unit, attempt): (&str, &str, Attempt<S>), bad: &[f64], allowed: &str) {
    for &bad in bad {
        let error = attempt(S::from_f64(bad)).unwrap_err();
        assert_eq!(error.parameter.name(), name);
        assert_eq!(error.parameter.unit(), unit, "{name}");
        assert!(error.value == bad || bad.is_nan() && error.value.is_nan());
        assert_eq!(
            error.to_string(),
            format!("{name} is {bad} {unit}, but must be {allowed}")
        );
    }
    attempt(S::from_f64(0.5)).unwrap();
}

fn every_parameter_is_checked<S: Scalar>() {
    let never = [-1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for case in positive_parameters::<S>() {
        refused(case, &never, "finite and greater than 0");
        refused(case, &[0.0, -0.0], "finite and greater than 0");
    }
    for case in parameters_that_may_be_zero::<S>() {
        refused(case, &never, "finite and not below 0");
        case.2(S::ZERO).unwrap();
    }
}

#[test]
fn every_parameter_outside_its_range_is_refused_by_name() {
    every_parameter_is_checked::<f64>();
    every_parameter_is_checked::<f32>();
}

#[test]
fn the_largest_gap_is_finite_and_at_least_one_period() {
    for bad in [0.0, -1.0, 0.000_999, f64::NAN, f64::INFINITY] {
        let error = with_loop::<f64>(|l| l.largest_gap = Some(bad)).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("largest_gap is {bad} s, but must be finite and at least one period")
        );
    }
    with_loop::<f64>(|l| l.largest_gap = Some(0.001)).unwrap();
}

#[test]
fn an_infinite_mass_is_a_wall_and_a_negative_infinite_one_is_refused() {
    assert_eq!(Contact::object(1.0, f64::INFINITY), Contact::wall(1.0));
    let error = with_contact(Contact::object(1.0, f64::NEG_INFINITY)).unwrap_err();
    assert_eq!(error.parameter, Parameter::ObjectMass);
}

#[test]
fn difficulty_refuses_what_has_no_meaning() {
    let of = |k, m, object, t| Difficulty::<f64>::new(k, m, object, t).unwrap_err();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(of(bad, 1.0, 1.0, 1.0).parameter, Parameter::Stiffness);
        assert_eq!(of(1.0, 1.0, 1.0, bad).parameter, Parameter::Period);
        let pair = Difficulty {
            kappa: bad,
            object_kappa: 1.0,
        };
        assert_eq!(
            pair.stiffness(1.0, 1.0).unwrap_err().parameter,
            Parameter::Kappa
        );
        assert_eq!(
            pair.object_mass(1.0).unwrap_err().parameter,
            Parameter::Kappa
        );
    }
    for bad in [0.0, -1.0, f64::NAN] {
        assert_eq!(of(1.0, bad, 1.0, 1.0).parameter, Parameter::DeviceMass);
        assert_eq!(of(1.0, 1.0, bad, 1.0).parameter, Parameter::ObjectMass);
    }
    let pair = Difficulty {
        kappa: 1.0,
        object_kappa: -1.0,
    };
    assert_eq!(
        pair.object_mass(1.0).unwrap_err().to_string(),
        "object_kappa is -1, but must be finite and not below 0"
    );
}

#[test]
fn a_key_of_a_setting_is_shown_as_files_have_it() {
    let key = SettingKey::DAMPING;
    assert_eq!(key.to_string(), "damping_n_s_per_m");
    assert_eq!(format!("{key:>20}|"), "   damping_n_s_per_m|");
}
