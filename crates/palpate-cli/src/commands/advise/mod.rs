//! `palpate advise`: can this be rendered, and by what?

mod arguments;

pub use arguments::AdviseArguments;

use palpate_calibrate::{Calibration, Known, Quantity};
use palpate_plot::shown_of;
use palpate_scene::SetupError;
use palpate_study::advise::{Advice, FAITHFUL_PERCENT};
use palpate_study::map::{Bounce, BounceDevice, BounceError, MapParams};

use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::{draw, print_report};
use crate::setup::{read_calibration, wrong_flag, wrong_on_bench};

/// Looks, and answers.
pub fn run(arguments: &AdviseArguments) -> Result<(), Failure> {
    let file = arguments.device_file.as_deref();
    let file = file.map(read_calibration).transpose()?;
    let bounce = bounce(arguments, file.as_ref())?;
    let methods = &arguments.method.0;
    let mut outputs = arguments.overwriting.outputs();
    arguments.picture.plan(&mut outputs)?;
    let progress = Progress::new(methods.len());
    progress.begin("looking for limits");
    let mut advice = Advice::on(&bounce, arguments.stiffness.is_some(), methods, || {
        progress.advance();
    })
    .map_err(|error| refused(&error))?;
    drop(progress);
    let stiffest = stiffest_by_resonance(arguments, file.unwrap_or_default(), &bounce);
    if let Some(stiffest) = stiffest {
        advice.bounded_by_a_resonance(stiffest);
    }
    if let Some(path) = &arguments.picture.plot {
        let shown = shown_of(methods);
        let progress = Progress::new(shown.len());
        progress.begin("looking for the reach");
        let reach = bounce.reach(&shown, FAITHFUL_PERCENT, || {});
        let reach = reach.map_err(|error| refused(&error))?;
        drop(progress);
        let size = arguments.picture.size;
        draw(&outputs, path, &palpate_plot::advice(&advice, &reach), size)?;
        advice.wrote(path);
    }
    print_report(&advice, arguments.json)
}

/// Stiffest contact that the first resonance of flags or `file` allows `[N/m]`; none where none is known.
fn stiffest_by_resonance(
    arguments: &AdviseArguments,
    file: Calibration,
    bounce: &Bounce,
) -> Option<f64> {
    let mut known = file;
    for (quantity, given) in [
        (Quantity::DeviceMass, arguments.device_mass),
        (Quantity::Resonance, arguments.resonance),
        (
            Quantity::FlexibleMassFraction,
            arguments.flexible_mass_fraction,
        ),
    ] {
        if let Some(value) = given {
            known.set(quantity, Known::given(value, "given"));
        }
    }
    known.stiffest_contact(bounce.object_mass, bounce.period)
}

/// The scene that is asked about, on the device of flags and `file`; a softest stiffness stands in where
/// none is.
fn bounce(arguments: &AdviseArguments, file: Option<&Calibration>) -> Result<Bounce, Failure> {
    let known = |quantity| file.and_then(|file| file.value(quantity));
    let positive = |flag: &str, value: f64, unit: &str| {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {value} {unit}, but must be finite and greater than 0"
            )))
        }
    };
    let not_negative = |flag: &str, value: f64, unit: &str| {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {value} {unit}, but must be finite and not below 0"
            )))
        }
    };
    let defaults = MapParams::default();
    let mass = arguments.device_mass.or(known(Quantity::DeviceMass));
    let mass = mass.ok_or_else(|| {
        Failure::Arguments("the device file has no device_mass_kg: --device-mass is needed".into())
    })?;
    let mass = positive("--device-mass", mass, "kg")?;
    let period = positive("--period", arguments.period, "s")?;
    let object_mass = match arguments.mass {
        None => f64::INFINITY,
        Some(mass) if mass == f64::INFINITY => mass,
        Some(mass) => positive("--mass", mass, "kg")?,
    };
    let stiffness = match arguments.stiffness {
        Some(stiffness) => positive("--stiffness", stiffness, "N/m")?,
        None => palpate_study::map::SEARCHED.0 * mass / (period * period),
    };
    let quantum = known(Quantity::SensorQuantum);
    let quantum = arguments.encoder_quantum.or(quantum).unwrap_or(0.0);
    // Where the two are known only together, the sum is the better delay.
    let of_file = known(Quantity::Delay).or(known(Quantity::DelayPlusLag));
    let of_file = of_file.map(|seconds| seconds / period);
    let delay = arguments.delay.or(of_file).unwrap_or(0.0);
    let lag = arguments.lag.or(known(Quantity::Lag)).unwrap_or(0.0);
    if let Some(resonance) = arguments.resonance {
        positive("--resonance", resonance, "Hz")?;
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
        && known(Quantity::Resonance).is_none()
    {
        return Err(Failure::Arguments(
            "--flexible-mass-fraction is for a device with a resonance, and none is known: --resonance is missing"
                .into(),
        ));
    }
    Ok(Bounce {
        device: BounceDevice {
            mass,
            viscous_friction: not_negative(
                "--viscous-friction",
                arguments.viscous_friction,
                "N s/m",
            )?,
            coulomb_friction: not_negative("--coulomb-friction", arguments.coulomb_friction, "N")?,
            encoder_quantum: not_negative("--encoder-quantum", quantum, "m")?,
            told_mass: 1.0,
        },
        stiffness,
        object_mass,
        forces: defaults.forces,
        gap: defaults.gap,
        period,
        told_period: 1.0,
        delay,
        lag: not_negative("--lag", lag, "s")?,
    })
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
