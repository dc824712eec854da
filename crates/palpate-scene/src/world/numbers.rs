//! The numbers of a world's file, which are checked where they are read.

use palpate_core::Range;
use palpate_world::{Vector, out_of_range};
use toml::Spanned;

use super::file::Reading;
use super::per_axis::PerAxis;
use crate::fault::Span;

impl Reading {
    /// The numbers under a key, which are checked.
    pub(super) fn numbers(&mut self, key: &str, span: Span, values: &[f64], range: Range) {
        let mut wrong = values
            .iter()
            .filter_map(|value| out_of_range(key, *value, range));
        if let Some(message) = wrong.next() {
            self.fault(span, message);
        }
    }

    pub(super) fn number(&mut self, key: &str, value: Spanned<f64>, range: Range) -> f64 {
        self.numbers(key, value.span(), &[*value.get_ref()], range);
        value.into_inner()
    }

    /// Returns the value under a key along each axis of the world; `otherwise` along its missing axes.
    /// Without `axes`, the available axes are unknown.
    pub(super) fn per_axis(
        &mut self,
        key: &str,
        value: &Spanned<PerAxis>,
        range: Range,
        (axes, otherwise): (Option<[bool; 3]>, f64),
    ) -> Vector {
        let given = value.get_ref().given();
        self.numbers(key, value.span(), given, range);
        let Some(axes) = axes else {
            return [1.0; 3];
        };
        value.get_ref().along(axes, otherwise).unwrap_or_else(|| {
            let count = axes.iter().filter(|has| **has).count();
            let numbers = |count: usize| match count {
                1 => "1 number".to_owned(),
                many => format!("{many} numbers"),
            };
            let message = format!(
                "{key} has {}, and the device has {count} ax{}s; give one number for all axes, or {} in the order x, y, z",
                numbers(given.len()),
                if count == 1 { "i" } else { "e" },
                numbers(count)
            );
            self.fault(value.span(), message);
            axes.map(|has| if has { 1.0 } else { otherwise })
        })
    }

    /// Returns whether the axes of the device with this number were read without faults, including a misspelt key.
    pub(super) fn has_its_axes(&self, number: usize) -> bool {
        !self.is_removed(&format!("device.{number}.ax"))
    }

    /// Whether the inertia of the device of this number was at fault, or what it may have been misspelt as.
    pub(super) fn lost_its_inertia(&self, number: usize) -> bool {
        self.is_removed(&format!("device.{number}.inert"))
    }

    fn is_removed(&self, beginning: &str) -> bool {
        self.removed.iter().any(|key| key.starts_with(beginning))
    }

    pub(super) fn vector(
        &mut self,
        key: &str,
        value: Option<Spanned<Vector>>,
        default: Vector,
    ) -> Vector {
        value.map_or(default, |value| {
            self.numbers(key, value.span(), value.get_ref(), Range::Finite);
            value.into_inner()
        })
    }
}
