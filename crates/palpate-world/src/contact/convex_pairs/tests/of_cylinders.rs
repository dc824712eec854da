//! Tests of the pair laws for a cylinder with a half-space, a box, a hull and another cylinder.

use super::cylinders::{Cylinders, Form};
use super::rims::Cylinder;
use super::*;

/// The cylinder pair, and the number of points that share the law.
pub(super) struct OnForm(pub(super) Cylinders, usize);

impl OnForm {
    /// Returns `None` for shapes without a separating-plane search.
    pub(super) fn between(shapes: [&crate::Shape; 2]) -> Option<Self> {
        let blocks = Blocks::between(shapes, [0, 1], 0)?;
        match blocks.solids {
            Solids::Cylinders(pair) => Some(Self(pair, blocks.share)),
            _ => None,
        }
    }
}

impl Pair for OnForm {
    fn placed(&self, first: &Rigid, second: &Rigid) -> impl Between {
        let mut pair = self.0.clone();
        pair.place([first, second], None);
        pair
    }

    fn share(&self) -> usize {
        self.1
    }

    fn points(&self) -> usize {
        self.0.points()
    }
}

/// Returns an upright prism with five sides.
fn prism() -> Arc<Corners> {
    let corners: Vec<Vector3> = (0..10)
        .map(|number| {
            let angle = std::f64::consts::TAU * f64::from(number % 5) / 5.0;
            let side = if number < 5 { -0.3 } else { 0.08 };
            Vector3::new(0.5 * angle.cos(), 0.4 * angle.sin(), side)
        })
        .collect();
    Arc::new(Corners::around(&corners, 0.0).unwrap())
}

const KINDS: [&str; 4] = ["half-space", "box", "hull", "cylinder"];

fn pair(kind: &str, is_first: bool) -> OnForm {
    let share = if kind == "hull" { 5 } else { 4 };
    let cylinder = |radius, half_length| Cylinder::new(radius, half_length, share);
    let other = match kind {
        "half-space" => Form::half_space(Vector3::new(0.6, 0.0, 0.8), 0.1),
        "box" => Form::flat(Arc::new(Corners::of_box(HALF[0].into()))),
        "hull" => Form::flat(prism()),
        _ => Form::Cylinder(cylinder(0.4, 0.5)),
    };
    let own = cylinder(0.3, 0.45);
    let side = usize::from(!is_first);
    OnForm(Cylinders::new(side, own, other, share), share)
}

#[test]
fn force_and_torque_of_a_cylinder_are_the_gradient_of_the_energy() {
    for kind in KINDS {
        for is_first in [true, false] {
            let mut seen = [0; 3];
            let pair = pair(kind, is_first);
            assert_gradient(&pair, &mut Numbers(41), 8000, 0.06, &mut seen);
            let [first, second, edges] = seen;
            assert!(first + second > 100, "{kind} {seen:?}");
            assert!((edges > 10) == (kind != "half-space"), "{kind} {seen:?}");
        }
    }
}

#[test]
fn the_energy_of_a_cylinder_has_no_jump() {
    for kind in KINDS {
        // For an overlap of more than half of the thinner solid, other local minima are nearer.
        let within = if kind == "half-space" {
            f64::INFINITY
        } else {
            0.08
        };
        let changes = changes_without_a_jump(&pair(kind, true), &mut Numbers(43), 100, 2.0, within);
        assert!((changes > 20) == (kind != "half-space"), "{kind} {changes}");
    }
}

/// Returns the point of a cylinder nearest to `own`.
fn into_cylinder(cylinder: &Cylinder, own: Vector3) -> Vector3 {
    let across = own.xy() * (cylinder.radius / own.xy().norm()).min(1.0);
    let (low, high) = (-cylinder.half_length, cylinder.half_length);
    Vector3::new(across.x, across.y, own.z.clamp(low, high))
}

/// Returns the point of a solid nearest to `own`.
fn into(form: &Form, own: Vector3) -> Vector3 {
    match form {
        Form::Cylinder(cylinder) => into_cylinder(cylinder, own),
        Form::Flat(flat) => {
            let nearest = flat.own.nearest(&own);
            own - nearest.normal * nearest.distance.max(0.0)
        }
        Form::HalfSpace { own: bound, .. } => own + bound.normal * bound.depth(&own).min(0.0),
    }
}

/// Separated solids have no energy, and solids with a common point have some.
#[test]
fn cylinders_push_if_and_only_if_they_overlap() {
    for kind in KINDS {
        let mut numbers = Numbers(47);
        let (mut apart, mut together) = (0, 0);
        for _ in 0..1000 {
            let rigids = [
                rigid(Vector3::zeros(), numbers.vector()),
                rigid(numbers.vector() * 1.3, numbers.vector() * 3.0),
            ];
            let [first, second] = &rigids;
            let mut here = pair(kind, true).0;
            here.place([first, second], None);
            let (plane, depth) = here.least(None);
            let normal = here.normal(plane);
            // Alternating projection between the solids converges to a common point, if there is one.
            let (cylinder, other) = here.solids();
            let from = |rigid: &Rigid, place: Vector3| {
                rigid.orientation.inverse() * (place - rigid.position)
            };
            let out = |rigid: &Rigid, own: Vector3| rigid.position + rigid.orientation * own;
            let mut place = second.position;
            let mut ends = [place; 2];
            let mut way = f64::INFINITY;
            for _ in 0..20_000 {
                let in_first = out(first, into_cylinder(cylinder, from(first, place)));
                place = out(second, into(other, from(second, in_first)));
                ends = [in_first, place];
                way = (place - in_first).norm();
                if way < 1e-9 {
                    break;
                }
            }
            if depth < 0.0 {
                // The plane separates the two by the depth.
                let gap = normal.dot(&(ends[0] - ends[1]));
                assert!(gap > -depth - 1e-9, "{kind} {plane:?} {depth} {gap}");
                apart += 1;
            } else {
                together += 1;
            }
            // Convergence is slow for small overlaps.
            assert!(way < 1e-5 || depth < 0.01, "{kind} {plane:?} {depth} {way}");
            assert!(way > 1e-9 || depth > 0.0, "{kind} {plane:?} {depth}");
        }
        assert!(apart > 100 && together > 100, "{kind} {apart} {together}");
    }
}

/// For crossing rims, only the plane tangent to both separates the cylinders, and for small overlaps it has the
/// lowest energy.
#[test]
fn rims_that_cross_are_apart_by_the_plane_that_touches_both() {
    let mut pair = pair("cylinder", true).0;
    let first = rigid(Vector3::zeros(), Vector3::zeros());
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    // Normal of the first at its upper rim, and axis and radius of the second, which extends upwards and sideways
    // from there.
    let out = (x + z).normalize();
    for lean in [0.3, 0.8, 1.3_f64] {
        let (sine, cosine) = lean.sin_cos();
        let axis = y * sine - out * cosine;
        let radius = -y * cosine - out * sine;
        let orientation = nalgebra::Matrix3::from_columns(&[radius, axis.cross(&radius), axis]);
        let rim = x * 0.3 + z * 0.45;
        let on_second = axis * 0.5 + radius * 0.4;
        for gap in [0.01, 1e-6, -1e-6, -0.005] {
            let second = Rigid {
                orientation: Rotation::from_matrix(&orientation),
                ..rigid(rim + out * gap - on_second, Vector3::zeros())
            };
            pair.place([&first, &second], None);
            let (plane, depth) = pair.least(None);
            assert_eq!(plane, Plane::Edges([3, 0]), "{lean} {gap}");
            if gap > 0.0 {
                // Any separating plane is acceptable.
                assert!(depth < 0.0 && depth > -gap - 1e-12, "{lean} {gap} {depth}");
                continue;
            }
            assert!((depth + gap).abs() < 1e-12, "{lean} {gap} {depth}");
            assert!((pair.normal(plane) + out).norm() < 1e-9, "{lean} {gap}");
            let mut found = vec![Found::none(); pair.points()];
            Between::points(&pair, plane, &mut found);
            let touching = found.iter().filter(|found| found.penetration > 0.0);
            assert_eq!(touching.count(), 4);
            assert!((found[0].place - rim - out * (0.5 * gap)).norm() < 1e-9);
        }
    }
}

/// Skipping the plane at the side of a cylinder where it cannot have the lowest energy leaves the result
/// bit-identical.
#[test]
fn a_plane_that_is_not_looked_for_would_not_be_taken() {
    let at_side = Plane::Edges([2, 0]);
    for kind in ["box", "hull"] {
        let mut numbers = Numbers(53);
        let (mut together, mut taken) = (0, 0);
        for _ in 0..4000 {
            let first = rigid(numbers.vector() * 0.1, numbers.vector() * 3.0);
            let second = rigid(numbers.vector(), numbers.vector() * 3.0);
            let [some, all] = [None, Some(at_side)].map(|before| {
                let mut here = pair(kind, true).0;
                here.place([&first, &second], before);
                here.least(None)
            });
            assert_eq!(some, all);
            together += u32::from(all.1 > 0.0);
            taken += u32::from(all.1 > 0.0 && all.0 == at_side);
        }
        assert!(together > 500 && taken > 5, "{kind} {together} {taken}");
    }
}
