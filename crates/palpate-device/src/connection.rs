//! Statistics of the connection to a device.

use std::time::Duration;

/// Messages from a device since it was opened, for reports. A sample that is not in `samples` counts as missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Connection {
    /// Accepted samples.
    pub samples: u64,
    /// Samples that never arrived.
    pub lost: u64,
    /// Samples that arrived too late.
    pub late: u64,
    /// Samples that arrived after a newer one.
    pub reordered: u64,
    /// Samples that arrived again.
    pub duplicate: u64,
    /// Messages that are invalid.
    pub unreadable: u64,
    /// Commands that the device did not take.
    pub untaken: u64,
    /// Times from a command or a request to the answer of the device: median, 99 % and longest. `None`: not measured.
    pub round_trip: Option<[Duration; 3]>,
}
