//! Hands of a world.

use std::sync::Arc;

use palpate_core::Range;
use palpate_record::files::bounded::TABLE;
use palpate_record::trace::{self, LedDevice, Part};
use palpate_world::{Tool, Vector};
use toml::Spanned;

use super::file::Reading;
use super::per_axis::DeviceAxes;
use super::{LedPath, Swing, Tremor, WorldHand};
use crate::device_key::span;
use crate::hand_key::RawHand;

/// The axes of the world.
const WORLD: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

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

    /// Returns the hand, whose rest is by default the device's `position` `[m]`. Rejects forces and rests along the
    /// axes that the tool lacks.
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
        self.nothing_elsewhere("hand.swing_m", raw.swing_m.as_ref(), tool, [0.0; 3]);
        let mass = raw.mass_kg.map_or(0.0, |mass| {
            self.number("hand.mass_kg", mass, Range::NotNegative)
        });
        let release = raw.release_s;
        let release =
            release.map(|release| self.number("hand.release_s", release, Range::NotNegative));
        if raw.rest_file.is_some() {
            let beside = [span(&raw.rest_m), span(&raw.swing_m), span(&raw.swing_hz)];
            for key in beside.into_iter().flatten() {
                self.fault(key, "rest_file already sets where the hand pulls to");
            }
        }
        let path = raw
            .rest_file
            .and_then(|file| self.recorded_rest(&file, tool, position));
        WorldHand {
            force: self.vector("hand.force_n", raw.force_n, [0.0; 3]),
            stiffness,
            damping,
            rest: self.vector("hand.rest_m", raw.rest_m, position),
            swing: self.swing(raw.swing_m, raw.swing_hz),
            path,
            mass,
            release,
            tremor,
        }
    }

    /// Returns the swing of an amplitude `[m]` and a frequency `[Hz]`, both or neither.
    fn swing(
        &mut self,
        amplitude: Option<Spanned<Vector>>,
        frequency: Option<Spanned<f64>>,
    ) -> Option<Swing> {
        match (amplitude, frequency) {
            (None, None) => None,
            (Some(amplitude), Some(frequency)) => Some(Swing {
                amplitude: self.vector("hand.swing_m", Some(amplitude), [0.0; 3]),
                frequency_hz: self.number("hand.swing_hz", frequency, Range::Positive),
            }),
            (amplitude, frequency) => {
                let key = span(&amplitude).or(span(&frequency)).unwrap_or_default();
                self.fault(key, "a swing needs both swing_m and swing_hz");
                None
            }
        }
    }

    /// Returns the motion in a file beside the scene: along the axis of a device with one axis, which is elsewhere at
    /// its `position` `[m]`, or of x, y and z.
    fn recorded_rest(
        &mut self,
        name: &Spanned<String>,
        tool: &Tool,
        position: Vector,
    ) -> Option<Arc<LedPath>> {
        let file = name.get_ref();
        let read = || -> Result<LedPath, String> {
            let text = TABLE.text(&self.folder.join(file));
            let text = text.map_err(|error| format!("{file} cannot be read: {error}"))?;
            let own = tool.own_axes.unwrap_or(WORLD);
            let mut axes = own.into_iter().zip(tool.axes).filter(|(_, has)| *has);
            let (times, places) = if let (Some((axis, _)), None) = (axes.next(), axes.next()) {
                let trace =
                    trace::read(text.as_bytes(), file).map_err(|error| error.to_string())?;
                let along: f64 = axis.iter().zip(position).map(|(a, b)| a * b).sum();
                let place = |at: f64| std::array::from_fn(|i| position[i] + (at - along) * axis[i]);
                let start = trace.t_s.first().copied().unwrap_or(0.0);
                let times = trace.t_s.iter().map(|time| time - start).collect();
                (
                    times,
                    trace
                        .position_m
                        .into_iter()
                        .map(|at| vec![place(at)])
                        .collect(),
                )
            } else {
                let device = LedDevice {
                    name: tool.name.clone(),
                    turns: false,
                };
                let layout = trace::Layout::default();
                let read =
                    trace::read_world(text.as_bytes(), file, &Part::WHOLE, &layout, &[device]);
                let trace = read.map_err(|error| error.to_string())?;
                (trace.t_s, trace.positions_m)
            };
            LedPath::new(times, places).map_err(|wrong| format!("{file}: {wrong}"))
        };
        match read() {
            Ok(path) => Some(Arc::new(path)),
            Err(message) => {
                self.fault(name.span(), message);
                None
            }
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
