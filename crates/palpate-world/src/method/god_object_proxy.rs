//! Position of a god-object's proxy: the point outside all solids that is nearest to the device.

use crate::geometry::rigid::Vector3;

/// Number of times that the surfaces are re-evaluated at the current position.
const LOOKS: usize = 12;
/// Number of sweeps over the constraints per evaluation.
const SWEEPS: usize = 60;
/// Displacement below which the iteration has converged `[m]`.
const NO_WAY: f64 = 1e-12;

/// Constraint of a contact point on the proxy: normal . x >= least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraint {
    pub normal: Vector3,
    least: f64,
    /// Displacement of the proxy from the device along the normal: force over stiffness `[m]`.
    pub push: f64,
}

impl Constraint {
    /// Returns a constraint that allows every position.
    pub fn none() -> Self {
        Self {
            normal: Vector3::x(),
            least: f64::NEG_INFINITY,
            push: 0.0,
        }
    }
}

/// Returns the allowed position nearest to `device`, and sets the push of each constraint for which `own` is true.
///
/// Each solid is replaced by its tangent plane below the current position. Hildreth's method finds the nearest
/// position in front of all planes: a sweep projects onto each plane in turn and corrects earlier overshoot. `seen`
/// returns distance and normal at a position; if it returns `None`, the previous plane applies.
pub(super) fn nearest_allowed(
    device: &Vector3,
    start: Vector3,
    constraints: &mut [Constraint],
    own: impl Fn(usize) -> bool,
    mut seen: impl FnMut(usize, &Vector3) -> Option<(f64, Vector3)>,
) -> Vector3 {
    for (number, constraint) in constraints.iter_mut().enumerate() {
        if own(number) {
            *constraint = Constraint::none();
        }
    }
    let mut place = start;
    for _ in 0..LOOKS {
        for (number, constraint) in constraints.iter_mut().enumerate() {
            if own(number) {
                constraint.push = 0.0;
                if let Some((distance, normal)) = seen(number, &place) {
                    constraint.normal = normal;
                    constraint.least = normal.dot(&place) - distance;
                }
            }
        }
        let mut next = *device;
        for _ in 0..SWEEPS {
            let mut most: f64 = 0.0;
            for (number, constraint) in constraints.iter_mut().enumerate() {
                if !own(number) || constraint.least == f64::NEG_INFINITY {
                    continue;
                }
                let short = constraint.least - constraint.normal.dot(&next);
                let change = short.max(-constraint.push);
                constraint.push += change;
                next += constraint.normal * change;
                most = most.max(change.abs());
            }
            if most < NO_WAY {
                break;
            }
        }
        let way = (next - place).norm();
        place = next;
        if way < NO_WAY {
            break;
        }
    }
    place
}

/// Proxy position relative to the nearest allowed position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proxy {
    /// Displacement of the proxy from the nearest allowed position `[m]`.
    pub stays: Vector3,
    /// Slip: the part of the displacement that friction could not hold `[m]`.
    pub slipped: f64,
}

/// Computes the proxy that friction holds up to `holds` `[m]` from the nearest allowed position, across all pushing
/// normals.
pub(super) fn limit_slip<'a>(
    wanted: &Vector3,
    constraints: impl Iterator<Item = &'a Constraint>,
    holds: f64,
) -> Proxy {
    let mut across = *wanted;
    let mut basis = [Vector3::zeros(); 3];
    let mut count = 0;
    for constraint in constraints.filter(|constraint| constraint.push > 0.0) {
        let mut axis = constraint.normal;
        for known in &basis[..count] {
            axis -= known * known.dot(&axis);
        }
        let length = axis.norm();
        if length > 1e-6 && count < 3 {
            basis[count] = axis / length;
            across -= basis[count] * basis[count].dot(&across);
            count += 1;
        }
    }
    let length = across.norm();
    if length <= holds || length == 0.0 {
        return Proxy {
            stays: across,
            slipped: 0.0,
        };
    }
    Proxy {
        stays: across * (holds / length),
        slipped: length - holds,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(normal: [f64; 3]) -> impl Fn(&Vector3) -> Option<(f64, Vector3)> {
        let normal = Vector3::from(normal).normalize();
        move |place: &Vector3| Some((normal.dot(place), normal))
    }

    #[test]
    fn in_a_groove_the_proxy_is_at_its_edge_and_above_a_ball_on_its_surface() {
        let walls = [plane([1.0, 0.0, 0.4]), plane([-1.0, 0.0, 0.4])];
        let mut constraints = [Constraint::none(); 2];
        let device = Vector3::new(0.001, 0.02, -0.005);
        let start = Vector3::new(0.01, 0.0, 0.05);
        let place = nearest_allowed(
            &device,
            start,
            &mut constraints,
            |_| true,
            |number, place| walls[number](place),
        );
        assert!(
            (place - Vector3::new(0.0, 0.02, 0.0)).norm() < 1e-9,
            "{place}"
        );
        // The sum of all pushes is the displacement from the device to the proxy.
        let sum: Vector3 = constraints.iter().map(|it| it.normal * it.push).sum();
        assert!((device + sum - place).norm() < 1e-9);
        assert!(constraints.iter().all(|it| it.push > 0.0));

        let ball = |place: &Vector3| Some((place.norm() - 0.02, place.normalize()));
        let device = Vector3::new(0.0, 0.003, 0.018);
        let start = Vector3::new(0.005, 0.0, 0.03);
        let place = nearest_allowed(
            &device,
            start,
            &mut constraints[..1],
            |_| true,
            |_, place| ball(place),
        );
        assert!((place - device.normalize() * 0.02).norm() < 1e-9, "{place}");
    }

    #[test]
    fn friction_holds_the_proxy_up_to_its_cone() {
        let pressing = Constraint {
            normal: Vector3::z(),
            least: 0.0,
            push: 0.002,
        };
        let wanted = Vector3::new(0.003, 0.0, 0.5);
        let held = limit_slip(&wanted, [pressing].iter(), 0.004);
        assert_eq!(
            (held.stays, held.slipped),
            (Vector3::new(0.003, 0.0, 0.0), 0.0)
        );
        let slips = limit_slip(&wanted, [pressing].iter(), 0.001);
        assert!((slips.stays.x - 0.001).abs() < 1e-15 && (slips.slipped - 0.002).abs() < 1e-15);
    }
}
