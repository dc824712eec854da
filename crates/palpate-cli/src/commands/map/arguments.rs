//! Arguments of `map`.

use std::convert::Infallible;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum, ValueHint};
use palpate_plot::map::Quantity;

use crate::arguments::{LookFlags, Overwriting};
use crate::values::{Methods, methods, number, periods};

/// Arguments of `map`.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct MapArguments {
    /// Action other than computing a map.
    #[command(subcommand)]
    pub action: Option<MapAction>,
    /// A scene, which is refused
    #[arg(value_name = "SCENE.toml", value_parser = no_scene, hide = true)]
    pub refused: Option<Infallible>,
    /// Scene of the map.
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Computation of the map.
    #[command(flatten)]
    pub work: WorkArguments,
    /// Output of the map.
    #[command(flatten)]
    pub results: MapResults,
}

/// Actions on maps.
#[derive(Subcommand, Debug)]
pub enum MapAction {
    /// Join the parts of a map, or draw a whole one again
    #[command(after_help = "\
Examples:
  palpate map merge map-1-of-3.csv map-2-of-3.csv map-3-of-3.csv --out map.csv
  palpate map merge map.csv --plot map.svg --show error,resting --method all --size page")]
    Merge(MergeArguments),
}

/// Arguments of `map merge`.
#[derive(Args, Debug)]
pub struct MergeArguments {
    /// Parts of one map, in any order, or a whole map
    #[arg(value_name = "PART.csv", required = true, value_hint = ValueHint::FilePath)]
    pub parts: Vec<PathBuf>,
    /// Methods in the figure, separated by commas, or all [default: basic, virtual-damper, hfcr and coupled if the map
    /// has more than four]
    #[arg(long, value_name = "NAME", value_parser = methods)]
    pub method: Option<Methods>,
    /// Output of the map.
    #[command(flatten)]
    pub results: MapResults,
}

/// The scene of every cell.
#[derive(Args, Debug)]
#[command(next_help_heading = "Scene")]
pub struct SceneArguments {
    /// Cells along each axis, from 0.001 to 10, in addition to a column of walls
    #[arg(long, value_name = "COUNT", default_value_t = 65,
          value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub cells: u16,
    /// Methods, separated by commas, or all [default: all; the figure then shows basic, virtual-damper,
    /// hfcr and coupled]
    #[arg(long, value_name = "NAME", value_parser = methods)]
    pub method: Option<Methods>,
    /// Viscous friction of the damped device [N s/m] [default: 0.0394, that of the virtual
    /// pantograph of fig4]
    #[arg(long, value_name = "N s/m", value_parser = number, allow_hyphen_values = true)]
    pub viscous_friction: Option<f64>,
    /// Quantum of the device's position sensor [m]
    #[arg(long, value_name = "m", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true)]
    pub encoder_quantum: f64,
    /// Time from a sample to the beginning of its force, in periods; may be fractional
    #[arg(long, value_name = "PERIODS", value_parser = periods, default_value = "0")]
    pub delay_periods: f64,
    /// Time constant of the actuator, a first-order lag after the delay, 0 to 100 periods; the renderer models both
    #[arg(long, value_name = "PERIODS", value_parser = number, default_value = "0",
          allow_hyphen_values = true)]
    pub lag_periods: f64,
    /// Model value of the standard deviation of the delay, at most 8 [periods]
    #[arg(long, value_name = "PERIODS", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true)]
    pub delay_deviation_periods: f64,
    /// Model value of the standard deviation of the lag, at most 8 [periods]
    #[arg(long, value_name = "PERIODS", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true)]
    pub lag_deviation_periods: f64,
    /// Model value of the device mass over the true one
    #[arg(long, value_name = "FACTOR", value_parser = number, default_value_t = 1.0,
          allow_hyphen_values = true)]
    pub model_mass: f64,
    /// Model value of the period over the true one
    #[arg(long, value_name = "FACTOR", value_parser = number, default_value_t = 1.0,
          allow_hyphen_values = true)]
    pub model_period: f64,
    /// Forces that drive device and object together
    #[arg(long, value_enum, default_value_t = ForcesName::Balanced)]
    pub forces: ForcesName,
}

/// Forces that drive device and object together.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForcesName {
    /// A hand that holds the weight: equal and opposite forces, approaching at 13.81 m/s²
    Balanced,
    /// A hand of 1 N and gravity, for all masses
    Weight,
}

/// Computation of a map.
#[derive(Args, Debug)]
#[command(next_help_heading = "Work")]
pub struct WorkArguments {
    /// Compute only part I of N; the parts are joined by `map merge`
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Resume an interrupted run, if there is one; a complete map is reported and not overwritten
    #[arg(long)]
    pub resume: bool,
    /// Threads [default: all cores]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// Output of a map.
#[derive(Args, Debug)]
#[command(next_help_heading = "Results")]
pub struct MapResults {
    /// The map, or the part [default: map.csv, or map-I-of-N.csv; none if `merge` redraws one whole map]
    #[arg(long, value_name = "MAP.csv", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
    /// The figure of a whole map, .svg or .pdf (or .png where built with the feature png) [default: the
    /// name of the map with .svg]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
    /// Size of the figure.
    #[command(flatten)]
    pub look: LookFlags,
    /// Quantities in the figure, separated by commas [default: growth,error; a page has no room for more]
    #[arg(long, value_parser = quantity(), value_delimiter = ',')]
    pub show: Vec<Quantity>,
    /// Write the map as Parquet too, if built with the feature parquet
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub parquet: Option<PathBuf>,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

fn no_scene(_: &str) -> Result<Infallible, String> {
    Err("a map has plants of its own; for a map of a scene: palpate sweep SCENE.toml --over stiffness --values 0.1,1,10 \
         --and mass --and-values 0.1,1,10"
        .into())
}

/// Parser of a quantity's name.
fn quantity() -> impl TypedValueParser<Value = Quantity> {
    let named = |quantity: Quantity| PossibleValue::new(quantity.name()).help(quantity.meaning());
    PossibleValuesParser::new(Quantity::ALL.map(named)).map(|name| {
        let is_named = |quantity: &Quantity| quantity.name() == name;
        Quantity::ALL
            .into_iter()
            .find(is_named)
            .expect("it is one of the possible values")
    })
}

/// Part `number` of `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index, from 1.
    pub number: usize,
    /// Number of parts.
    pub of: usize,
}

fn shard(text: &str) -> Result<Shard, String> {
    let parsed = text.split_once('/').and_then(|(number, of)| {
        let (number, of) = (number.parse().ok()?, of.parse().ok()?);
        (1 <= number && number <= of && of <= 10_000).then_some(Shard { number, of })
    });
    parsed
        .ok_or_else(|| "a part is written I/N, such as 2/3, with I from 1 to N up to 10000".into())
}
