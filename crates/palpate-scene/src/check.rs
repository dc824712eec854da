//! Ranges of what a scene states.

use palpate::{Mass, ParameterError, Side};
use palpate_testbed::hold::DelayedHold;

use super::hand::FORCE_AT;
use super::{HandForceAt, Measure, Scene};

/// Longest delay `[samples]`, that of the bench's hold.
const MOST_DELAY: usize = DelayedHold::LONGEST_DELAY;

impl Scene {
    /// Checks what no renderer looks at.
    ///
    /// # Errors
    /// The first value outside its range, under the name the file reader knows it by.
    pub fn check(&self) -> Result<(), ParameterError> {
        let out_of_range = |parameter, unit, value: f64, allowed| {
            Err(ParameterError {
                parameter,
                value,
                unit,
                allowed,
            })
        };
        for (parameter, unit, value) in [
            ("object position", "m", self.object.position),
            ("object velocity", "m/s", self.object.velocity),
            ("virtual force", "N", self.virtual_force),
            ("device position", "m", self.device.position),
            ("device velocity", "m/s", self.device.velocity),
            ("user force", "N", self.user_force),
            (
                "hand position",
                "m",
                self.grip.as_ref().map_or(0.0, |grip| grip.position),
            ),
            (
                "tremor",
                "N",
                self.tremor.map_or(0.0, |wave| wave.amplitude),
            ),
            (
                "swing",
                "m",
                self.swing().map_or(0.0, |wave| wave.amplitude),
            ),
        ] {
            if !value.is_finite() {
                return out_of_range(parameter, unit, value, "finite");
            }
        }
        if !(self.object_radius.is_finite() && self.object_radius >= 0.0) {
            let allowed = "finite and not below 0";
            return out_of_range("object radius", "m", self.object_radius, allowed);
        }
        if self.user_force_at == HandForceAt::Motors && self.linkage.is_none() {
            let allowed = "that of a pantograph, whose motors give torques";
            return out_of_range(FORCE_AT, "N", self.user_force, allowed);
        }
        let is_wall = self.contact.object_mass == Mass::Infinite;
        if is_wall && self.object.velocity != 0.0 {
            return out_of_range(
                "object velocity",
                "m/s",
                self.object.velocity,
                "0 for a wall",
            );
        }
        if let Some(linkage) = &self.linkage {
            let position = self.device.position;
            let inside = |[low, high]: [f64; 2]| (low..=high).contains(&position);
            if linkage.safety_box.is_some_and(|bounds| !inside(bounds.y)) {
                let allowed = "inside the safety box of the device";
                return out_of_range("device position", "m", position, allowed);
            }
            if self.contact.side != Side::Positive {
                return out_of_range("side", "", -1.0, "positive for a pantograph");
            }
            if self.grip.is_some() || self.tremor.is_some() {
                return out_of_range(
                    "user force",
                    "N",
                    self.user_force,
                    "all of the hand of a pantograph",
                );
            }
        }
        if self.recorded_hand.is_some() {
            let amplitude = |wave: super::Wave| wave.amplitude;
            let other_hand = [
                ("user force", "N", self.user_force),
                ("viscous friction", "N s/m", self.device.viscous_friction),
                ("Coulomb friction", "N", self.device.coulomb_friction),
                ("motor limit", "N", self.device.largest_force.unwrap_or(0.0)),
                ("tremor", "N", self.tremor.map_or(0.0, amplitude)),
                ("release", "s", self.release.map_or(0.0, f64::abs)),
                (
                    "hand stiffness",
                    "N/m",
                    self.grip.as_ref().map_or(0.0, |grip| grip.stiffness),
                ),
            ];
            for (parameter, unit, value) in other_hand {
                if value != 0.0 {
                    return out_of_range(parameter, unit, value, "left out beside a recorded hand");
                }
            }
            if self.linkage.is_some() {
                let allowed = "that of a point mass beside a recorded hand";
                return out_of_range("device_mass", "kg", self.device.mass, allowed);
            }
        }
        if let Some(release) = self.release {
            if self.linkage.is_some() {
                let allowed = "left out for a pantograph";
                return out_of_range("release", "s", release, allowed);
            }
            if !(release.is_finite() && release >= 0.0) {
                return out_of_range("release", "s", release, "finite and not below 0");
            }
        }
        let mass = self.device.mass;
        if !(mass.is_finite() && mass > 0.0) {
            return out_of_range("device_mass", "kg", mass, "finite and greater than 0");
        }
        for (parameter, unit, value) in [
            ("encoder_quantum", "m", self.device.encoder_quantum),
            ("viscous friction", "N s/m", self.device.viscous_friction),
            ("Coulomb friction", "N", self.device.coulomb_friction),
            (
                "hand mass",
                "kg",
                self.grip.as_ref().map_or(0.0, |grip| grip.mass),
            ),
            (
                "hand stiffness",
                "N/m",
                self.grip.as_ref().map_or(0.0, |grip| grip.stiffness),
            ),
            (
                "hand damping",
                "N s/m",
                self.grip.as_ref().map_or(0.0, |grip| grip.damping),
            ),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return out_of_range(parameter, unit, value, "finite and not below 0");
            }
        }
        for (parameter, unit, value) in [
            ("told device_mass", "kg", self.told_device_mass),
            ("motor limit", "N", self.device.largest_force),
            (
                "tremor frequency",
                "Hz",
                self.tremor.map(|wave| wave.frequency_hz),
            ),
            (
                "swing frequency",
                "Hz",
                self.swing().map(|wave| wave.frequency_hz),
            ),
        ] {
            if let Some(value) = value
                && !(value.is_finite() && value > 0.0)
            {
                return out_of_range(parameter, unit, value, "finite and greater than 0");
            }
        }
        if self.delay > MOST_DELAY {
            return out_of_range("delay", "samples", self.delay as f64, "at most 1024");
        }
        // A bad period is the renderer's to refuse.
        if self.loop_params.period.is_finite() && self.loop_params.period > 0.0 {
            self.check_timing()?;
        }
        match self.measure {
            Measure::Collisions(0) => out_of_range("measured collisions", "", 0.0, "at least 1"),
            Measure::Duration(duration) if !(duration.is_finite() && duration > 0.0) => {
                out_of_range("duration", "s", duration, "finite and greater than 0")
            }
            _ => Ok(()),
        }
    }

    /// Swing of the hand's intended position.
    fn swing(&self) -> Option<super::Wave> {
        self.grip.as_ref().and_then(|grip| grip.swing)
    }
}
