//! Capabilities of a device.

use super::Vector;

/// Capabilities of a device, from its data sheet or from a measurement. `None` means unknown and imposes no limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Capabilities {
    /// The device's name, for reports and recordings.
    pub name: String,
    /// Number of axes with a position and a force, 1 to 3.
    pub axes: usize,
    /// Number of axes with a torque, 0 to 3.
    pub torque_axes: usize,
    /// Whether poses have an orientation about three axes. Devices with a stylus often measure it without giving
    /// torque.
    pub measures_orientation: bool,
    /// Largest force in every pose `[N]`.
    pub largest_force: Option<f64>,
    /// Largest torque in every pose `[N m]`.
    pub largest_torque: Option<f64>,
    /// Largest stiffness recommended by the manufacturer `[N/m]`.
    pub largest_stiffness: Option<f64>,
    /// Largest damping recommended by the manufacturer `[N s/m]`.
    pub largest_damping: Option<f64>,
    /// Corners of the workspace `[m]`, lower and upper on each axis.
    pub workspace: Option<[Vector; 2]>,
    /// Effective mass at the end-point `[kg]`.
    pub effective_mass: Option<f64>,
    /// Quantum of the position `[m]`; 0: continuous sensor.
    pub encoder_quantum: Option<f64>,
    /// Whether the device holds the last commanded force until the next command. If the commanding program is killed,
    /// only another process can remove that force: the watchdog process of `palpate-rt`.
    pub holds_last_force: bool,
    /// Whether the device holds a straight line over a period ([`Line`](super::Line)). A loop rejects a rendering with
    /// lines on a device without it.
    pub holds_lines: bool,
}

impl Capabilities {
    /// Creates capabilities of which only the name and the number of axes are known.
    ///
    /// # Panics
    /// The number of axes is not 1, 2 or 3.
    #[must_use]
    pub fn unknown(name: &str, axes: usize) -> Self {
        assert!((1..=3).contains(&axes), "{axes} axes; allowed: 1 to 3");
        Self {
            name: name.to_owned(),
            axes,
            torque_axes: 0,
            measures_orientation: false,
            largest_force: None,
            largest_torque: None,
            largest_stiffness: None,
            largest_damping: None,
            workspace: None,
            effective_mass: None,
            encoder_quantum: None,
            holds_last_force: false,
            holds_lines: false,
        }
    }
}
