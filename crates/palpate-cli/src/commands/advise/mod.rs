//! `palpate advise`: whether a device can render a contact, and by which method.

mod arguments;

pub use arguments::AdviseArguments;

use palpate_core::LARGEST_DELAY;
use palpate_plot::shown_of;
use palpate_scene::SetupError;
use palpate_study::advise::{Advice, FAITHFUL_PERCENT, Question};
use palpate_study::calibrate::{Calibration, Quantity};
use palpate_study::map::{Bounce, BounceError};

use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use crate::setup::{read_calibration, tell_too_long, wrong_flag, wrong_on_bench};

/// Evaluates the contact and prints the advice.
pub fn run(arguments: &AdviseArguments) -> Result<(), Failure> {
    let file = arguments.device_file.as_deref();
    let file = file.map(read_calibration).transpose()?;
    let bounce = bounce(arguments, file.as_ref())?;
    let methods = &arguments.method.0;
    let mut outputs = arguments.overwriting.outputs();
    arguments.picture.plan(&mut outputs)?;
    let progress = Progress::new(methods.len());
    progress.begin("searching limits");
    let mut advice = Advice::on(&bounce, arguments.stiffness.is_some(), methods, || {
        progress.advance();
    })
    .map_err(|error| refused(&error))?;
    drop(progress);
    let known = file.unwrap_or_default().stating([
        (Quantity::DeviceMass, arguments.device_mass),
        (Quantity::Resonance, arguments.resonance),
        (
            Quantity::FlexibleMassFraction,
            arguments.flexible_mass_fraction,
        ),
    ]);
    if let Some(stiffest) = known.stiffest_contact(bounce.object_mass, bounce.period) {
        advice.bounded_by_a_resonance(stiffest);
    }
    if let Some(path) = &arguments.picture.plot {
        let shown = shown_of(methods);
        let progress = Progress::new(shown.len());
        progress.begin("searching renderable contacts");
        let reach = bounce.reach(&shown, FAITHFUL_PERCENT, || {});
        let reach = reach.map_err(|error| refused(&error))?;
        drop(progress);
        let look = &arguments.picture.look;
        draw(&outputs, path, &palpate_plot::advice(&advice, &reach), look)?;
        advice.wrote(path);
    }
    print_report(&advice, arguments.json)
}

/// Returns the scene of the contact on the device of flags and `file`.
fn bounce(arguments: &AdviseArguments, file: Option<&Calibration>) -> Result<Bounce, Failure> {
    let asked = Question {
        file,
        device_mass: arguments.device_mass,
        viscous_friction: arguments.viscous_friction,
        coulomb_friction: arguments.coulomb_friction,
        encoder_quantum: arguments.encoder_quantum,
        period: arguments.period,
        delay: arguments.delay.or(arguments
            .delay_periods
            .map(|periods| periods * arguments.period)),
        lag: arguments.lag,
        delay_deviation: arguments.delay_deviation,
        lag_deviation: arguments.lag_deviation,
        stiffness: arguments.stiffness,
        object_mass: arguments.mass.unwrap_or(f64::INFINITY),
    };
    let bounce = asked.bounce().ok_or_else(|| {
        Failure::Arguments("the device file has no device_mass_kg: --device-mass is needed".into())
    })?;
    check_positive("--device-mass", bounce.device.mass, "kg")?;
    check_positive("--period", bounce.period, "s")?;
    if bounce.object_mass != f64::INFINITY {
        check_positive("--mass", bounce.object_mass, "kg")?;
    }
    if let Some(stiffness) = arguments.stiffness {
        check_positive("--stiffness", stiffness, "N/m")?;
    }
    check_resonance(arguments, file)?;
    let device = &bounce.device;
    check_not_negative("--viscous-friction", device.viscous_friction, "N s/m")?;
    check_not_negative("--coulomb-friction", device.coulomb_friction, "N")?;
    check_not_negative("--encoder-quantum", device.encoder_quantum, "m")?;
    check_not_negative("--lag", bounce.lag, "s")?;
    for (flag, deviation, unit) in [
        ("--delay", arguments.delay, "s"),
        ("--delay-deviation", arguments.delay_deviation, "s"),
        ("--lag-deviation", arguments.lag_deviation, "s"),
    ] {
        if let Some(deviation) = deviation {
            check_not_negative(flag, deviation, unit)?;
        }
    }
    if bounce.delay > LARGEST_DELAY as f64 {
        tell_too_long(arguments.delay.map(|_| "--delay"), bounce.delay);
    }
    Ok(bounce)
}

/// Rejects a resonance out of its range, or a flexible fraction of the mass without a resonance.
fn check_resonance(arguments: &AdviseArguments, file: Option<&Calibration>) -> Result<(), Failure> {
    if let Some(resonance) = arguments.resonance {
        check_positive("--resonance", resonance, "Hz")?;
    }
    if let Some(fraction) = arguments.flexible_mass_fraction
        && !(0.0..1.0).contains(&fraction)
    {
        return Err(Failure::Arguments(format!(
            "--flexible-mass-fraction is {fraction}, but must be from 0 to below 1"
        )));
    }
    if arguments.flexible_mass_fraction.is_some()
        && arguments.resonance.is_none()
        && file.is_none_or(|file| file.value(Quantity::Resonance).is_none())
    {
        return Err(Failure::Arguments(
            "--flexible-mass-fraction is for a device with a resonance: --resonance is missing"
                .into(),
        ));
    }
    Ok(())
}

/// Rejects a value of a flag that is not finite and greater than 0.
fn check_positive(flag: &str, value: f64, unit: &str) -> Result<(), Failure> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Failure::Arguments(format!(
            "{flag} is {value} {unit}, but must be finite and greater than 0"
        )))
    }
}

/// Rejects a value of a flag that is not finite or is below 0.
fn check_not_negative(flag: &str, value: f64, unit: &str) -> Result<(), Failure> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(Failure::Arguments(format!(
            "{flag} is {value} {unit}, but must be finite and not below 0"
        )))
    }
}

fn refused(error: &BounceError) -> Failure {
    match error {
        BounceError::Bench(error) => wrong_on_bench(error),
        BounceError::Method {
            error: SetupError::Parameter(error),
            ..
        } => wrong_flag(error),
        BounceError::TooLong(_) => Failure::Arguments(format!(
            "--stiffness: {error}; a stiffer contact or a longer period is needed"
        )),
        other => Failure::Arguments(other.to_string()),
    }
}
