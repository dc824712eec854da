//! Lines: forces with a slope, for devices that hold one over a period.
//!
//! Of all lines the nearest to a force f over an interval of h has its impulse J and its first moment:
//!
//! ```text
//! f0 = J/h,   s = 12 (integral of f t - J h/2)/h^3
//! ```
//!
//! Device and proxy then end the interval at the same position, so no offset arises. The slope is along all axes of the
//! device; torques stay constants.

use palpate_core::Hold;

use super::WorldMethod;
use super::coupled_impulse::Impulse;
use crate::geometry::rigid::Vector3;
use crate::{Tool, Vector, WorldError, WorldField, WorldGuard, WorldLoop, WorldPart};

/// Slopes of the forces on the tools `[N/s]`; 0 with a constant hold.
#[derive(Clone, Debug)]
pub(crate) struct Slopes {
    holds_lines: bool,
    /// Slopes of the method's commands.
    pub intended: Vec<Vector3>,
    /// Slopes with both ends within the limits.
    pub sent: Vec<Vector>,
}

impl Slopes {
    pub fn new(tools: usize, loop_params: &WorldLoop) -> Self {
        Self {
            holds_lines: loop_params.actuation.hold == Hold::Line,
            intended: vec![Vector3::zeros(); tools],
            sent: vec![[0.0; 3]; tools],
        }
    }

    /// Copies the slopes of `other`, which has the same number of tools and the same hold.
    pub fn copy_from(&mut self, other: &Self) {
        self.intended.copy_from_slice(&other.intended);
        self.sent.copy_from_slice(&other.sent);
    }

    /// Sets all slopes to 0.
    pub fn clear(&mut self) {
        self.intended.fill(Vector3::zeros());
        self.sent.fill([0.0; 3]);
    }

    /// Sets the slope of a tool's command for the contacts' impulse over an interval of `h` `[s]`, with an actuator of
    /// this `gain`.
    #[inline]
    pub(super) fn plan(&mut self, tool: usize, impulse: &Impulse, gain: f64, h: f64) {
        if self.holds_lines {
            self.intended[tool] = impulse.lead(h) * (-12.0 / (gain * h * h * h));
        }
    }

    /// Bounds the slopes such that both ends of each line are no longer than the limit of its tool. `forces` are the
    /// limited means. Returns whether a slope was bounded.
    pub fn limit(&mut self, forces: &[Vector], loop_params: &WorldLoop) -> bool {
        if !self.holds_lines {
            return false;
        }
        let mut acted = false;
        let tools = self.sent.iter_mut().zip(&self.intended).zip(forces);
        for (tool, ((sent, intended), force)) in tools.enumerate() {
            *sent = (*intended).into();
            acted |= bound_slope(tool, force, sent, loop_params);
        }
        acted
    }
}

/// Bounds the `slope` `[N/s]` of a line such that both ends are no longer than the limit of its tool. `mean` `[N]` is
/// within the limit. Returns whether it was bounded.
pub(super) fn bound_slope(
    tool: usize,
    mean: &Vector,
    slope: &mut Vector,
    loop_params: &WorldLoop,
) -> bool {
    let Some(most) = loop_params.force_limits.get(tool) else {
        return false;
    };
    let most = most / loop_params.actuation.limit_gain();
    let intended = Vector3::from(*slope);
    let rise = intended * (0.5 * loop_params.period);
    let part = within(&Vector3::from(*mean), &rise, most);
    *slope = (intended * part).into();
    part < 1.0
}

/// Returns the part of a `rise` to both sides of a `mean` with which the ends are no longer than `most`, 0 to 1.
fn within(mean: &Vector3, rise: &Vector3, most: f64) -> f64 {
    let mut part = 1.0_f64;
    // No longer rise fits, and the square of a huge number overflows.
    let largest = rise.amax();
    let scale = if largest > 4.0 * most {
        4.0 * most / largest
    } else {
        1.0
    };
    for step in [rise * scale, rise * -scale] {
        let (a, b) = (step.norm_squared(), mean.dot(&step));
        let c = (mean.norm_squared() - most * most).min(0.0);
        if a + 2.0 * b + c > 0.0 {
            let root = (b * b - a * c).max(0.0).sqrt();
            let longest = if b > 0.0 {
                -c / (root + b)
            } else {
                (root - b) / a
            };
            part = part.min(longest.clamp(0.0, 1.0));
        }
    }
    scale * part
}

/// Returns what excludes a line hold.
pub(super) fn faults(
    tools: &[Tool],
    loop_params: &WorldLoop,
    method: &WorldMethod,
) -> Vec<WorldError> {
    if loop_params.actuation.hold != Hold::Line {
        return Vec::new();
    }
    let mut faults = Vec::new();
    let mut refuse = |message: String| {
        let (part, field) = (WorldPart::Loop, WorldField::Actuation);
        faults.push(WorldError::new(part, field, "the loop", message));
    };
    const INSTEAD: &str = "hold constants, loop.hold = \"constant\"";
    if !matches!(method, WorldMethod::Coupled(_)) {
        let name = method.name();
        refuse(format!(
            "the actuation holds a line, but {name} plans constants; only coupled plans lines: use it, or {INSTEAD}"
        ));
    }
    if loop_params.guard != WorldGuard::Off {
        refuse(format!(
            "the actuation holds a line, but the guard bounds constants; turn it off, or {INSTEAD}"
        ));
    }
    for tool in tools {
        let name = &tool.name;
        if tool.turns {
            refuse(format!(
                "the actuation holds a line, but the device {name} turns, and its torque is a constant; {INSTEAD}"
            ));
        }
        if tool.mass_table.is_some() {
            refuse(format!(
                "the actuation holds a line, but the motors of the linkage {name} hold torques; {INSTEAD}"
            ));
        }
    }
    faults
}
