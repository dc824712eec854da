//! The part of a wrench that a device can hold.

use palpate_device::{Capabilities, Vector, Wrench};

/// Returns the part of `wrench` along the axes of `device`, shortened to its largest force and torque; zero if a
/// component is not finite.
#[must_use]
pub fn on_axes(device: &Capabilities, wrench: Wrench) -> Wrench {
    if !wrench.is_finite() {
        return Wrench::NONE;
    }
    Wrench {
        force: shortened(wrench.force, device.axes, device.largest_force),
        torque: shortened(wrench.torque, device.torque_axes, device.largest_torque),
    }
}

fn shortened(vector: Vector, axes: usize, longest: Option<f64>) -> Vector {
    let mut kept = [0.0; 3];
    for (place, part) in kept.iter_mut().zip(vector).take(axes) {
        *place = part;
    }
    let most = kept.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    let Some(longest) = longest.filter(|_| most > 0.0) else {
        return kept;
    };
    // Scale first: the square of a large number overflows.
    let square: f64 = kept.iter().map(|part| (part / most).powi(2)).sum();
    let part = (longest / (most * square.sqrt())).min(1.0);
    kept.map(|force| force * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrench_keeps_its_direction_and_the_axes_of_the_device() {
        let plane = Capabilities {
            largest_force: Some(5.0),
            ..Capabilities::unknown("plane", 2)
        };
        let held = |force| on_axes(&plane, Wrench::of_force(force)).force;
        assert_eq!(held([1.0, -2.0, 9.0]), [1.0, -2.0, 0.0]);
        let [x, y, z] = held([30.0, -40.0, 1.0]);
        assert!((x - 3.0).abs() < 1e-12 && (y + 4.0).abs() < 1e-12 && z == 0.0);
        let [x, y, _] = held([1e308, 1e308, 0.0]);
        assert!((x.hypot(y) - 5.0).abs() < 1e-9);
        assert_eq!(held([f64::NAN, 1.0, 0.0]), [0.0; 3]);
        assert_eq!(held([0.0; 3]), [0.0; 3]);
    }
}
