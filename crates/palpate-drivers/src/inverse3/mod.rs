//! Haply Inverse3: a three-axis device, connected through the JSON WebSocket of its service.

mod command;
mod driver;
mod fitness;
mod frame;

pub use command::{CommandError, Commands, Form, PROFILE};
pub use driver::{
    ConnectError, Counts, Found, Inspector, Inverse3, Inverse3Options, LARGEST_FORCE, OpenError,
    Pace, SERVICE, devices,
};
pub use fitness::Unfit;
pub use frame::{
    Config, DeviceFrame, FARTHEST, FASTEST, Frame, FrameError, Model, Sample, State, Status,
};
