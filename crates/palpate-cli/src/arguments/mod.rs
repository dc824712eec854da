//! Arguments shared by commands, and arguments of the commands without a device.

mod actuation;
mod edits;
mod files;
mod flags;
mod given;
mod offline;
mod replay;
mod setting_flags;

pub use actuation::ActuationFlags;
pub use edits::EditFlags;
pub use files::{LookFlags, Overwriting, PartFlags, PlotFlags, TimeFlags, TraceFlags};
pub use flags::{Flags, TimingFlags};
pub use given::Given;
pub use offline::{
    ClaimsArguments, CompareArguments, Compared, CompletionArguments, CurveArguments,
    DemoArguments, FigureArguments, FigureName, HeightsArguments, Least, RenderArguments, Results,
    SeedFlags, SimulateArguments, SuiteArguments, SweepArguments, TuneArguments,
};
pub use replay::{ReplayFlags, ReplayKind};
pub use setting_flags::flag_of_setting;
