//! Arguments shared by commands, and arguments of the commands without a device.

mod actuation;
mod files;
mod flags;
mod given;
mod offline;
mod replay;
mod setting_flags;

pub use actuation::ActuationFlags;
pub use files::{Overwriting, PartFlags, PlotFlags, SizeFlag, TimeFlags, TraceFlags};
pub use flags::{Flags, TimingFlags};
pub use given::Given;
pub use offline::{
    ClaimsArguments, CompareArguments, Compared, CompletionArguments, CurveArguments,
    DemoArguments, FigureArguments, FigureName, HeightsArguments, Least, RenderArguments, Results,
    SimulateArguments, SuiteArguments, SweepArguments, TuneArguments,
};
pub use replay::{ReplayFlags, ReplayKind};
pub use setting_flags::flag_of_setting;
