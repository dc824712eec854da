//! `palpate map`: which (kappa, Kc) each method can render.

mod arguments;
mod compute;
mod files;
mod merge;

pub use arguments::MapArguments;

use std::path::PathBuf;

use palpate_core::LARGEST_DELAY;
use palpate_record::map::Map;
use palpate_scene::method::MethodName;
use palpate_study::map::report::{MapReport, Speed};
use palpate_study::map::{Forces, MapParams};

use crate::failure::Failure;
use crate::results::print_report;
use crate::values::Methods;
use arguments::{ForcesName, MapAction, MapResults, SceneArguments, Shard};
use compute::unusable;
use files::Files;

/// The whole map as a single part.
const WHOLE: Shard = Shard { number: 1, of: 1 };

/// Computes a map, or performs the requested action on maps.
pub fn run(arguments: &MapArguments) -> Result<(), Failure> {
    if let Some(MapAction::Merge(merge)) = &arguments.action {
        return merge::run(merge);
    }
    let results = &arguments.results;
    let shard = arguments.work.shard.unwrap_or(WHOLE);
    if shard.of > 1 && results.plot.is_some() {
        return Err(Failure::Arguments(
            "--plot: a part of a map cannot be drawn; join all parts with map merge".into(),
        ));
    }
    let params = params(&arguments.scene)?;
    let out = results.out.clone().unwrap_or_else(|| {
        PathBuf::from(if shard.of == 1 {
            "map.csv".into()
        } else {
            format!("map-{}-of-{}.csv", shard.number, shard.of)
        })
    });
    let plot = results.plot.clone();
    let plot = (shard.of == 1).then(|| plot.unwrap_or_else(|| out.with_extension("svg")));
    let mut files = Files::new(results)?;
    files.compute(&out, arguments.work.resume)?;
    files.show(results, plot, arguments.work.resume)?;
    let methods = arguments.scene.method.as_ref();
    let done = compute::run(&params, shard, &arguments.work, &out, &files)?;
    deliver((results, methods), &done.map, &files, done.speed)?;
    done.journal
        .map_or(Ok(()), |journal| journal.remove().map_err(unusable))
}

/// Draws a whole map, and reports it.
fn deliver(
    (results, methods): (&MapResults, Option<&Methods>),
    map: &Map,
    files: &Files,
    speed: Option<Speed>,
) -> Result<(), Failure> {
    let mut report = MapReport::new(map, speed).map_err(Failure::input)?;
    files.deliver(map, (results, methods), speed.is_none(), &mut report)?;
    print_report(&report, results.json)
}

fn lag(periods: f64) -> Result<f64, Failure> {
    if (0.0..=100.0).contains(&periods) {
        return Ok(periods);
    }
    Err(Failure::Arguments(format!(
        "--lag-periods is {periods} periods; allowed: 0 to 100"
    )))
}

fn params(scene: &SceneArguments) -> Result<MapParams, Failure> {
    let defaults = MapParams::default();
    let not_negative = |flag: &str, value: f64, unit: &str| {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {value}{unit}, but must be finite and not below 0"
            )))
        }
    };
    let deviation = |flag: &str, periods: f64| {
        if (0.0..=LARGEST_DELAY as f64).contains(&periods) {
            Ok(periods)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {periods} periods, but must be 0 to {LARGEST_DELAY}"
            )))
        }
    };
    let factor = |flag: &str, value: f64| {
        if (1e-3..=1e3).contains(&value) {
            Ok(value)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {value}, but must be a factor from 0.001 to 1000"
            )))
        }
    };
    let mut device = defaults.device;
    if let Some(friction) = scene.viscous_friction {
        device.viscous_friction = not_negative("--viscous-friction", friction, " N s/m")?;
    }
    device.encoder_quantum = not_negative("--encoder-quantum", scene.encoder_quantum, " m")?;
    device.model_mass = factor("--model-mass", scene.model_mass)?;
    let named = scene.method.as_ref().map(|methods| &methods.0);
    let params = MapParams {
        cells: usize::from(scene.cells),
        // In their canonical order, so that the same methods give the same map.
        methods: MethodName::ALL
            .into_iter()
            .filter(|method| named.is_none_or(|named| named.contains(method)))
            .collect(),
        device,
        delay: scene.delay_periods,
        lag: lag(scene.lag_periods)?,
        delay_deviation: deviation("--delay-deviation-periods", scene.delay_deviation_periods)?,
        lag_deviation: deviation("--lag-deviation-periods", scene.lag_deviation_periods)?,
        model_period: factor("--model-period", scene.model_period)?,
        forces: match scene.forces {
            ForcesName::Balanced => defaults.forces,
            ForcesName::Weight => Forces::Weight {
                user_force: 1.0,
                gravity: 9.81,
            },
        },
        ..defaults
    };
    params
        .check()
        .map_err(|error| Failure::Arguments(error.to_string()))?;
    Ok(params)
}
