//! Tests of the pair laws for hulls.

use super::*;

/// Returns a tetrahedron, a box, and solids with random corners, roughly centred at their centres of mass.
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
    let mut hulls = Hulls::new(pair.clone(), pair.share());
    hulls.place([first, second]);
    hulls
}

/// Returns pairs of all solids with each other.
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

impl Pair for [Arc<Corners>; 2] {
    fn placed(&self, first: &Rigid, second: &Rigid) -> impl Between {
        placed(self, first, second)
    }

    fn share(&self) -> usize {
        self[0].most_on_a_face().max(self[1].most_on_a_face())
    }

    fn points(&self) -> usize {
        self[0].places.len().max(self[1].places.len())
    }
}

#[test]
fn force_and_torque_of_hulls_are_the_gradient_of_the_energy() {
    let mut numbers = Numbers(19);
    let mut seen = [0; 3];
    for pair in pairs(&mut numbers) {
        assert_gradient(&pair, &mut numbers, 400, 0.06, &mut seen);
    }
    assert!(seen.iter().all(|&seen| seen > 50), "{seen:?}");
}

/// Valid as long as the number of corners behind a face is at most the number that shares the law.
#[test]
fn the_energy_of_hulls_has_no_jump_where_they_overlap_little() {
    let mut numbers = Numbers(5);
    let pairs = pairs(&mut numbers);
    let each = pairs.iter();
    let changes: u32 = each
        .map(|pair| changes_without_a_jump(pair, &mut numbers, 8, 4.0, 0.05))
        .sum();
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
        // For separated boxes the gap of a distant edge can exceed that of a face, and that of a corner can be
        // smaller.
        assert_eq!(of_boxes > 0.0, of_hulls > 0.0, "{of_boxes} {of_hulls}");
        if of_boxes > 0.0 {
            assert!((of_boxes - of_hulls).abs() < 1e-9, "{of_boxes} {of_hulls}");
            together += 1;
        }
    }
    assert!(together > 500, "{together}");
}
