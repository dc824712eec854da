//! The same laws of hulls.

use super::*;

/// A tetrahedron, a box, and solids of some random corners; about their centres of mass, more or less.
fn solids(numbers: &mut Numbers) -> Vec<Arc<Corners>> {
    let mut all = vec![Corners::of_box(Vector3::new(0.5, 0.3, 0.4))];
    for count in [4, 8, 12, 16] {
        let points: Vec<Vector3> = (0..count)
            .map(|_| numbers.vector().normalize() * 0.5)
            .collect();
        all.extend(Corners::around(&points, 0.0));
    }
    assert_eq!(all.len(), 5, "random points around a sphere have a hull");
    all.into_iter().map(Arc::new).collect()
}

fn placed(pair: &[Arc<Corners>; 2], first: &Rigid, second: &Rigid) -> Hulls {
    let share = pair[0].most_on_a_face().max(pair[1].most_on_a_face());
    let mut hulls = Hulls::new(pair.clone(), share);
    hulls.place([first, second]);
    hulls
}

/// Pairs of all solids with each other.
fn pairs(numbers: &mut Numbers) -> Vec<[Arc<Corners>; 2]> {
    let all = solids(numbers);
    let each = |one: &Arc<Corners>| {
        let one = one.clone();
        all.clone()
            .into_iter()
            .map(move |other| [one.clone(), other])
    };
    all.iter().flat_map(each).collect()
}

#[test]
fn force_and_torque_of_hulls_are_the_gradient_of_the_energy() {
    let mut numbers = Numbers(19);
    let mut seen = [0; 3];
    for pair in pairs(&mut numbers) {
        for _ in 0..400 {
            let first = rigid(numbers.vector() * 0.1, numbers.vector() * 3.0);
            let second = rigid(numbers.vector() * 1.2, numbers.vector() * 3.0);
            let here = placed(&pair, &first, &second);
            let (plane, depth) = here.least(None);
            if !(0.0..0.06).contains(&depth) {
                continue;
            }
            let energy = |first: &Rigid, second: &Rigid| {
                let (at, depth) = placed(&pair, first, second).least(Some(plane));
                (at == plane).then_some(0.5 * depth * depth)
            };
            let law = PointLaw::share(&ContactLaw::spring(1.0), here.share as f64);
            let normal = here.normal(plane);
            let (way, turn) = (numbers.vector(), numbers.vector());
            let mut powers = [0.0; 2];
            let mut points = vec![Found::none(); 16];
            here.points(plane, &mut points);
            for found in points.iter().filter(|found| found.penetration > 0.0) {
                let force = normal * law.normal_force(found.penetration, 0.0);
                for (power, (rigid, sign)) in
                    powers.iter_mut().zip([(&first, 1.0), (&second, -1.0)])
                {
                    let velocity = way + turn.cross(&(found.place - rigid.position));
                    *power += sign * force.dot(&velocity);
                }
            }
            let h = 1e-6;
            let [of_first, of_second] = [-h, h].map(|h| {
                let by = |rigid| moved(rigid, way * h, turn * h);
                (energy(&by(&first), &second), energy(&first, &by(&second)))
            });
            let changes = [of_second.0.zip(of_first.0), of_second.1.zip(of_first.1)];
            for (change, power) in changes.into_iter().zip(powers) {
                let Some((up, down)) = change else { continue };
                let slope = (up - down) / (2.0 * h);
                assert!((slope + power).abs() < 1e-7, "{plane:?} {slope} {power}");
            }
            seen[match plane {
                Plane::Face { of, .. } => of,
                Plane::Edges(_) => 2,
            }] += 1;
        }
    }
    assert!(seen.iter().all(|&seen| seen > 50), "{seen:?}");
}

/// On a straight way of one through the other the energy has no jump, as long as no more corners are behind a face than share
/// the law.
#[test]
fn the_energy_of_hulls_has_no_jump_where_they_overlap_little() {
    let mut numbers = Numbers(5);
    let mut changes = 0;
    for pair in pairs(&mut numbers) {
        for _ in 0..8 {
            let (from, to) = (numbers.vector(), numbers.vector());
            let (turned, turn) = (numbers.vector() * 3.0, numbers.vector());
            let steps = 2000;
            let h = 1.0 / f64::from(steps);
            let first = rigid(Vector3::zeros(), Vector3::zeros());
            let mut before: Option<(Plane, f64)> = None;
            for step in 0..steps {
                let along = h * f64::from(step);
                let second = rigid(from + (to - from) * along, turned);
                let second = moved(&second, Vector3::zeros(), turn * along);
                let here = placed(&pair, &first, &second);
                let (plane, depth) = here.least(before.map(|(plane, _)| plane));
                if let Some((old, was)) = before
                    && was < 0.05
                {
                    let most = 4.0 * ((to - from).norm() + turn.norm()) * h;
                    assert!(
                        (depth.max(0.0) - was.max(0.0)).abs() < most,
                        "{old:?} {plane:?} {was} {depth}"
                    );
                    changes += u32::from(old != plane && depth > 0.0);
                }
                before = Some((plane, depth));
            }
        }
    }
    assert!(changes > 50, "{changes}");
}

/// A box as a hull has the planes of a box.
#[test]
fn a_box_is_a_hull() {
    let mut numbers = Numbers(23);
    let pair = HALF.map(|half| Arc::new(Corners::of_box(half.into())));
    let mut together = 0;
    for _ in 0..4000 {
        let first = rigid(numbers.vector() * 0.1, numbers.vector() * 3.0);
        let second = rigid(numbers.vector() * 1.2, numbers.vector() * 3.0);
        let (_, of_boxes) = super::placed(&first, &second).least(None);
        let (_, of_hulls) = placed(&pair, &first, &second).least(None);
        // Apart, an edge that is not nearest may say a larger gap than a face, or a corner a smaller one.
        assert_eq!(of_boxes > 0.0, of_hulls > 0.0, "{of_boxes} {of_hulls}");
        if of_boxes > 0.0 {
            assert!((of_boxes - of_hulls).abs() < 1e-9, "{of_boxes} {of_hulls}");
            together += 1;
        }
    }
    assert!(together > 500, "{together}");
}
