//! Hands of a world.

use palpate_core::Range;
use palpate_world::{Tool, Vector};
use toml::Spanned;

use super::file::Reading;
use super::per_axis::DeviceAxes;
use super::{Tremor, WorldHand};
use crate::hand_key::RawHand;

impl Reading {
    /// Returns the tremor of an amplitude `[N]` and a frequency `[Hz]`; the latter may be alone if the tremor has a
    /// torque.
    pub(super) fn tremor(&mut self, given: [Option<Spanned<f64>>; 2], has_torque: bool) -> Tremor {
        match given.into() {
            (None, Some(frequency)) if has_torque => Tremor {
                amplitude: 0.0,
                frequency_hz: self.number("hand.tremor_hz", frequency, Range::Positive),
            },
            (Some(amplitude), Some(frequency)) => Tremor {
                amplitude: self.number("hand.tremor_n", amplitude, Range::NotNegative),
                frequency_hz: self.number("hand.tremor_hz", frequency, Range::Positive),
            },
            (None, None) => Tremor::default(),
            (Some(key), None) | (None, Some(key)) => {
                self.fault(key.span(), "a tremor needs both tremor_n and tremor_hz");
                Tremor::default()
            }
        }
    }

    /// Returns the hand, whose rest is by default the device's `position` `[m]`. Rejects forces and rests along the axes
    /// that the tool lacks.
    pub(super) fn hand(
        &mut self,
        raw: RawHand,
        tool: &Tool,
        position: Vector,
        tremor: Tremor,
    ) -> WorldHand {
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand.stiffness_n_per_m", raw.stiffness_n_per_m);
        let damping = at_least_0("hand.damping_n_s_per_m", raw.damping_n_s_per_m);
        self.nothing_elsewhere("hand.force_n", raw.force_n.as_ref(), tool, [0.0; 3]);
        self.nothing_elsewhere("hand.rest_m", raw.rest_m.as_ref(), tool, position);
        WorldHand {
            force: self.vector("hand.force_n", raw.force_n, [0.0; 3]),
            stiffness,
            damping,
            rest: self.vector("hand.rest_m", raw.rest_m, position),
            tremor,
        }
    }

    /// Rejects a value that would move a tool along an axis that its device lacks. `held` is the value that is allowed
    /// there.
    pub(super) fn nothing_elsewhere(
        &mut self,
        key: &str,
        value: Option<&Spanned<Vector>>,
        tool: &Tool,
        held: Vector,
    ) {
        let axes = DeviceAxes {
            has: tool.axes,
            own: tool.own_axes,
        };
        if let Some(value) = value
            && let Some(message) = axes.refused(key, *value.get_ref(), held)
        {
            self.fault(value.span(), message);
        }
    }
}
