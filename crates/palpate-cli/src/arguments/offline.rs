//! Arguments of the commands without a real-time loop.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use palpate_scene::HandForceAt;
use palpate_study::suite::MAX_PLANTS;

use super::{
    EditFlags, Flags, Given, LookFlags, Overwriting, PartFlags, PlotFlags, ReplayFlags, TimeFlags,
    TimingFlags, TraceFlags,
};
use crate::values::{
    AnyMethods, Numbers, Over, PlantSet, any_methods, force_place, number, numbers, over,
    plant_set, whole,
};

/// Arguments of `render`.
#[derive(Args, Debug)]
pub struct RenderArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Recorded motion: CSV with the columns t_s,position_m; - for standard input. With --input: the scene file of a
    /// world
    #[arg(value_name = "TRACE.csv", value_hint = ValueHint::FilePath)]
    pub trace: PathBuf,
    /// Recorded motion of the devices of a world: CSV with the columns t,x,y,z; x,y,z again for each further device, or
    /// --columns
    #[arg(long, value_name = "RECORDING.csv", value_hint = ValueHint::FilePath)]
    pub input: Option<PathBuf>,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
    /// Motion or hand.
    #[command(flatten)]
    pub replay: ReplayFlags,
    /// Layout of the trace.
    #[command(flatten, next_help_heading = "Trace")]
    pub table: TraceFlags,
    /// Selected part of the trace.
    #[command(flatten)]
    pub part: PartFlags,
    /// Output of the results.
    #[command(flatten)]
    pub results: Results,
}

/// Arguments of `simulate`.
#[derive(Args, Debug)]
pub struct SimulateArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Scene file (TOML); experiments/ has the paper's
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
    /// Point of action of the hand's force on a pantograph: at its end-point, or in its motors as torques held over
    /// each period [default: end-point, or the scene's]
    #[arg(long, value_name = "end-point|motors", value_parser = force_place,
          help_heading = "Device")]
    pub hand_force_at: Option<HandForceAt>,
    /// Timing imperfections of the loop.
    #[command(flatten)]
    pub timing: TimingFlags,
    /// Several seeds.
    #[command(flatten)]
    pub several: SeedFlags,
    /// Output of the results.
    #[command(flatten)]
    pub results: Results,
}

/// Several seeds of a scene.
#[derive(Args, Debug, Default, Clone, Copy)]
pub struct SeedFlags {
    /// Number of seeds, starting at the scene's: median, range and mean of each value over the seeds, with intervals,
    /// and the differences of the methods
    #[arg(long, value_name = "COUNT", default_value_t = 1, help_heading = "Loop",
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub seeds: u32,
    /// Each seed also changes the start of each device by up to this much along each of its axes [m], so that a touch
    /// falls on another part of a period; a scene without random values needs it
    #[arg(long, value_name = "m", value_parser = number, allow_hyphen_values = true, requires = "seeds",
          help_heading = "Loop")]
    pub start_range: Option<f64>,
}

/// Arguments of `sweep`.
#[derive(Args, Debug)]
pub struct SweepArguments {
    /// Scene file (TOML); experiments/ has the paper's
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Edits of the scene.
    #[command(flatten)]
    pub edits: EditFlags,
    /// Quantity to vary: stiffness, mass or friction, as factors on those of the scene; box, the half-width of a
    /// pantograph's safety box along y [m]; damping, B, b or cap of the methods [N s/m]. Or a key of the scene: a path
    /// as of --set, such as body.0.mass_kg or model.device_mass_factor
    #[arg(long, value_name = "QUANTITY|KEY", value_parser = over)]
    pub over: Over,
    /// Values of the quantity or the key, separated by commas
    #[arg(long, value_name = "NUMBERS", value_parser = numbers, allow_hyphen_values = true,
          required_unless_present = "from", conflicts_with = "from")]
    pub values: Option<Numbers>,
    /// Second quantity or key, for a map: every value of --over with every one of --and-values
    #[arg(long, value_name = "QUANTITY|KEY", value_parser = over, requires = "and_values")]
    pub and: Option<Over>,
    /// Values of the second quantity or key
    #[arg(long, value_name = "NUMBERS", value_parser = numbers, allow_hyphen_values = true, requires = "and")]
    pub and_values: Option<Numbers>,
    /// First value of a range, instead of --values
    #[arg(long, value_name = "NUMBER", value_parser = number, allow_hyphen_values = true, requires_all = ["to", "steps"])]
    pub from: Option<f64>,
    /// Last value of the range
    #[arg(long, value_name = "NUMBER", value_parser = number, allow_hyphen_values = true, requires = "from")]
    pub to: Option<f64>,
    /// Number of values of the range, evenly spaced
    #[arg(long, value_name = "COUNT", requires = "from",
          value_parser = clap::value_parser!(u32).range(2..=10_000))]
    pub steps: Option<u32>,
    /// Space the values of the range by equal ratios
    #[arg(long, requires = "from")]
    pub log: bool,
    /// Number of collisions of the ideal that define the window of the methods [default: the scene's window]
    #[arg(long, value_name = "COUNT", value_parser = whole::<usize>)]
    pub collisions: Option<usize>,
    /// Evaluate 21 start heights too: median and worst FRE, and the numbers of runs that are almost stable and that
    /// leave the box
    #[arg(long)]
    pub heights: bool,
    /// Compared methods.
    #[command(flatten)]
    pub compared: Compared,
    /// Write a row for each value and method to a table (.csv; .md and .tex round it)
    #[arg(long, value_name = "FILE.csv|md|tex", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// The figure of the errors over the values.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

/// Arguments of `paper claims`.
#[derive(Args, Debug)]
pub struct ClaimsArguments {
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

/// Arguments of `compare`.
#[derive(Args, Debug)]
pub struct CompareArguments {
    /// Scene files (TOML); experiments/ has the paper's, experiments/users/ those of typical users
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath, required = true)]
    pub scenes: Vec<PathBuf>,
    /// Edits of each scene.
    #[command(flatten)]
    pub edits: EditFlags,
    /// Methods: all, or one or more, separated by commas [default: all]
    #[arg(long, value_name = "NAMES", value_parser = any_methods)]
    pub method: Option<AnyMethods>,
    /// Add the sampled spring with an object moved by each integrator: exact, midpoint, explicit, semi-implicit, implicit
    #[arg(long)]
    pub integrators: bool,
    /// Several seeds.
    #[command(flatten)]
    pub several: SeedFlags,
    /// Write the table to a file (.csv; .md and .tex round it)
    #[arg(long, value_name = "TABLE.csv|md|tex", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
    /// The figure of the force errors.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the table as JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tune`.
#[derive(Args, Debug)]
pub struct TuneArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Scene file (TOML); experiments/ has the paper's
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
    /// Timing imperfections of the loop.
    #[command(flatten)]
    pub timing: TimingFlags,
    /// The curve.
    #[command(flatten)]
    pub curve: CurveArguments,
    /// Write a row for each tried value to a table (.csv; .md and .tex round it)
    #[arg(long, value_name = "FILE.csv|md|tex", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// The figure of the curve.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report, with the whole curve, as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

/// Tried values and objective.
#[derive(Args, Debug)]
#[command(next_help_heading = "Curve")]
pub struct CurveArguments {
    /// Smallest value [N s/m] [default: 0; for a cap, the first step]
    #[arg(long, value_name = "N s/m", value_parser = number, allow_hyphen_values = true)]
    pub from: Option<f64>,
    /// Largest value [N s/m] [default: 4 K T for B, K T for b, 8 K T for a cap]
    #[arg(long, value_name = "N s/m", value_parser = number, allow_hyphen_values = true)]
    pub to: Option<f64>,
    /// Number of values, evenly spaced [default: 400; in a world 25]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub steps: Option<u32>,
    /// Quantity to minimise
    #[arg(long, value_enum, default_value_t = Least::Error)]
    pub least: Least,
}

/// Objective of the tuning.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Least {
    /// The mean-force error E
    Error,
    /// The sum of absolute leaks
    Leak,
}

/// Arguments of `suite`.
#[derive(Args, Debug)]
pub struct SuiteArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Family of plants: paper, desk, real, calibrated or steps; several bodies in space: worlds, held by a hand, or
    /// worlds-free
    #[arg(long, value_name = "NAME", default_value = "paper", value_parser = plant_set)]
    pub set: PlantSet,
    /// Number of plants
    #[arg(long, value_name = "COUNT", default_value_t = 200,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_PLANTS)))]
    pub plants: u32,
    /// Seed of the random numbers
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = whole::<u64>)]
    pub seed: u64,
    /// Number of seeds, starting at --seed, each with that many plants: the report has the median and the range over
    /// the seeds
    #[arg(long, value_name = "COUNT", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub seeds: u32,
    /// Compared methods.
    #[command(flatten)]
    pub compared: Compared,
    /// Write every plant as a scene file into a folder, which is created if it is missing
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, help_heading = "Results")]
    pub write_scenes: Option<PathBuf>,
    /// Write a row for each plant, delay and method to a CSV file
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// The figure of the distribution of the error.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

/// Arguments of `paper heights`.
#[derive(Args, Debug)]
pub struct HeightsArguments {
    /// Scene files (TOML); experiments/ has the paper's
    #[arg(value_name = "SCENE.toml", required = true, value_hint = ValueHint::FilePath)]
    pub scenes: Vec<PathBuf>,
    /// Edits of each scene.
    #[command(flatten)]
    pub edits: EditFlags,
    /// Factor on the renderer's model value of the device mass, relative to the effective mass
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = number,
          allow_hyphen_values = true)]
    pub model_mass_factor: f64,
    /// Compared methods.
    #[command(flatten)]
    pub compared: Compared,
    /// Write a row for each scene and method to a table (.csv; .md and .tex round it)
    #[arg(long, value_name = "FILE.csv|md|tex", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

/// Methods of a study.
#[derive(Args, Debug)]
pub struct Compared {
    /// Methods: all, or one or more, separated by commas [default: all]
    #[arg(long, value_name = "NAMES", value_parser = any_methods)]
    pub method: Option<AnyMethods>,
    /// Variants of methods, from a TOML file, instead of --method
    #[arg(long, value_name = "FILE.toml", conflicts_with = "method",
          value_hint = ValueHint::FilePath)]
    pub columns: Option<PathBuf>,
}

/// Arguments of `paper figure`.
#[derive(Args, Debug)]
pub struct FigureArguments {
    /// Name of the figure
    #[arg(value_enum)]
    pub figure: FigureName,
    /// File to draw into, .svg or .pdf (or .png where built with the feature png) [default: its name
    /// with .svg]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub plot: Option<PathBuf>,
    /// Size and words of the figure.
    #[command(flatten)]
    pub look: LookFlags,
    /// Time range of a figure over time.
    #[command(flatten)]
    pub time: TimeFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Figures of the paper.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
pub enum FigureName {
    /// The two modes, free motion and contact: a drawing
    Fig1,
    /// HFCR step by step: basic, modified force, smooth transitions, leak dissipation
    Fig2,
    /// The scene of Fig. 2 over 10 collisions: HFCR with four dampings
    Fig2Long,
    /// The pantograph, its frame and its joints: a drawing
    Fig3,
    /// Experiment 1 on a virtual pantograph, 100 N/m at 50 Hz: six methods beside each other
    Fig4,
    /// Experiment 2 on a virtual pantograph, 400 N/m at 50 Hz: six methods beside each other
    Fig5,
    /// Fig. 5 in the safety box that the paper's text fits best, with the ball's centre
    Fig5Box,
}

/// Arguments of `demo`.
#[derive(Args, Debug)]
pub struct DemoArguments {
    /// Folder for the figures and the hand trace; created if it is missing. Files of an earlier demo are replaced,
    /// others are kept
    #[arg(long, value_name = "DIR", default_value = "palpate-demo", value_hint = ValueHint::DirPath)]
    pub out_dir: PathBuf,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `completions`.
#[derive(Args, Debug)]
pub struct CompletionArguments {
    /// The shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

impl Results {
    /// Field names, for the list of flags that a command takes.
    pub const NAMES: [&str; 9] = [
        "out",
        "plot",
        "size",
        "title",
        "caption",
        "plot_from",
        "plot_to",
        "overwrite",
        "json",
    ];
}

/// Output of the results of a run.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Results")]
pub struct Results {
    /// Write every tick to a CSV file; - for standard output
    #[arg(long, value_name = "RUN.csv", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
    /// The figure of the runs.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Time range of the figure.
    #[command(flatten)]
    pub time: TimeFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}
