//! Keys that only the closed form honours.

use palpate_core::Hold;
use toml::Spanned;

use super::Reading;
use crate::device_key::{RawDevice, span};
use crate::fault::Span;
use crate::guard::GuardMode;
use crate::one_contact::NotOneContact;
use crate::raw::RawScene;

impl Reading {
    /// Rejects keys that only the closed form honours. `why` is the reason why the closed form does not render the
    /// scene; `None` if it does, and the caller asked for a world. Reports nothing in a file with other faults, because
    /// the reason may be one of these.
    pub fn refuse(&mut self, raw: &RawScene, why: Option<&NotOneContact>) {
        if !self.damaged.is_empty() {
            return;
        }
        let why = why.map_or("it is rendered as a world here", |why| &why.reason);
        let mut keys = Keys::new();
        for device in &raw.device {
            keys.extend(of_device(device.get_ref()));
        }
        for body in &raw.body {
            keys.push(("body.centre_m", span(&body.get_ref().centre_m)));
        }
        let (model, render) = (&raw.model, &raw.render);
        let unilateral = render.unilateral.as_ref().filter(|only| *only.get_ref());
        keys.extend([
            ("model.resonance_hz", span(&model.resonance_hz)),
            (
                "model.resonance_damping_ratio",
                span(&model.resonance_damping_ratio),
            ),
            (
                "model.flexible_mass_fraction",
                span(&model.flexible_mass_fraction),
            ),
            ("render.unilateral", unilateral.map(Spanned::span)),
            (
                "render.slew_limit_n_per_s",
                span(&render.slew_limit_n_per_s),
            ),
            ("measure.collisions", span(&raw.measure.collisions)),
        ]);
        for (key, span) in keys {
            if let Some(span) = span {
                let message = format!("{key} is for one contact along one axis only, but {why}");
                self.fault(span, message);
            }
        }
        for body in &raw.body {
            let body = body.get_ref();
            if let (Some(axes), false) = (&body.axes, body.fixed) {
                let message = format!(
                    "a body with `axes` is rendered in a scene of one contact along one axis only, but {why}"
                );
                self.fault(axes.span(), message);
            }
        }
    }
}

impl Reading {
    /// Rejects what a line hold excludes: a line lasts one nominal period, without a lag, and no motor limits it.
    /// Guards bound constants, and torques are constants, of motors too.
    pub fn refuse_beside_lines(&mut self, raw: &RawScene) {
        let timing = &raw.r#loop;
        if timing.hold.as_ref().map(Spanned::get_ref) != Some(&Hold::Line) {
            return;
        }
        let given = |value: &Option<Spanned<f64>>| {
            let value = value.as_ref().filter(|value| *value.get_ref() != 0.0);
            value.map(Spanned::span)
        };
        let dropped = timing.dropped_samples.as_ref();
        let dropped = dropped.filter(|samples| !samples.get_ref().is_empty());
        let mut keys = vec![
            ("loop.lag_s", given(&timing.lag_s)),
            ("loop.command_jitter_s", given(&timing.command_jitter_s)),
            ("loop.jitter_s", given(&timing.jitter_s)),
            ("loop.drop_probability", given(&timing.drop_probability)),
            ("loop.dropped_samples", dropped.map(Spanned::span)),
            ("loop.collapse", span(&timing.collapse)),
        ];
        let guard = raw.render.guard.as_ref().map(|guard| &guard.mode);
        let guard = guard.filter(|mode| *mode.get_ref() != GuardMode::Off);
        keys.push(("render.guard.mode", guard.map(Spanned::span)));
        for device in &raw.device {
            let device = device.get_ref();
            let [_, _, limit, ..] = device.drivetrain.spans();
            keys.extend([
                limit,
                ("device.inertia_kg_m2", span(&device.inertia_kg_m2)),
                ("device.mass_table", span(&device.mass_table)),
            ]);
        }
        for (key, span) in keys {
            if let Some(span) = span {
                let message = format!(
                    "{key} excludes lines in a world; omit it, or set loop.hold = \"constant\""
                );
                self.fault(span, message);
            }
        }
    }
}

type Keys = Vec<(&'static str, Option<Span>)>;

fn of_device(raw: &RawDevice) -> Keys {
    let mut keys = vec![
        ("device.linkage", span(&raw.linkage)),
        ("device.safety_box", span(&raw.safety_box)),
        ("device.hand.force_at", span(&raw.hand.force_at)),
    ];
    // Friction and the limit of the motors come first.
    let of_drivetrain = raw.drivetrain.spans().into_iter().skip(3);
    keys.extend(of_drivetrain);
    keys
}
