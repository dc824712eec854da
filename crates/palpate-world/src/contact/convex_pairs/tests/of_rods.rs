//! Tests of the pair laws for a capsule with a box, a capsule, a cylinder and a hull.

use super::*;

struct OnSolid(Rod);

impl Pair for OnSolid {
    fn placed(&self, first: &Rigid, second: &Rigid) -> impl Between {
        let mut rod = self.0.clone();
        rod.place([first, second]);
        rod
    }

    fn share(&self) -> usize {
        rods::ENDS
    }

    fn points(&self) -> usize {
        rods::ENDS
    }
}

const RADIUS: f64 = 0.1;

fn others() -> [Other; 4] {
    let hull = Corners::of_box(Vector3::new(0.5, 0.3, 0.4));
    let solids = [
        Solid::Block {
            half: HALF[0].into(),
        },
        Solid::Capsule {
            radius: 0.15,
            half_length: 0.6,
        },
        Solid::Cylinder {
            radius: 0.3,
            half_length: 0.4,
        },
    ];
    let [a, b, c] = solids.map(Other::Round);
    [a, b, c, Other::Flat(Arc::new(hull))]
}

fn rod(side: usize, other: Other) -> Rod {
    Rod::new(side, RADIUS, 0.4, other)
}

#[test]
fn force_and_torque_of_a_capsule_are_the_gradient_of_the_energy() {
    for (number, other) in others().into_iter().enumerate() {
        for side in [0, 1] {
            let mut seen = [0; 3];
            let pair = OnSolid(rod(side, other.clone()));
            assert_gradient(&pair, &mut Numbers(29), 6000, 0.06, &mut seen);
            assert!(seen[1 - side] > 100, "{number} {seen:?}");
        }
    }
}

/// From far apart to deep penetration.
#[test]
fn the_energy_of_a_capsule_has_no_jump() {
    for other in others() {
        let pair = OnSolid(rod(0, other));
        changes_without_a_jump(&pair, &mut Numbers(31), 40, 2.0, f64::INFINITY);
    }
}

/// No plane with the whole other solid behind it has lower energy than the selected plane, which also has it behind
/// it.
#[test]
fn no_plane_costs_less() {
    let mut numbers = Numbers(37);
    let (mut touching, mut closest) = (0, f64::INFINITY);
    let hull = Arc::new(Corners::of_box(HALF[0].into()));
    for _ in 0..20_000 {
        let first = rigid(numbers.vector() * 1.0, numbers.vector() * 3.0);
        let second = rigid(Vector3::zeros(), numbers.vector() * 3.0);
        let mut rod = rod(0, Other::Flat(hull.clone()));
        rod.place([&first, &second]);
        if !(1e-4..0.06).contains(&rod.depth) {
            continue;
        }
        touching += 1;
        let axis = first.orientation * Vector3::new(0.0, 0.0, rod.half_length);
        // E over K/2 of the plane normal to a direction.
        let cost = |out: Vector3| {
            let own = second.orientation.inverse_transform_vector(&out);
            let height = hull.places.iter().map(|place| own.dot(place));
            let height = height.fold(f64::NEG_INFINITY, f64::max) + out.dot(&second.position);
            let depth = |end: Vector3| (RADIUS + height - out.dot(&end)).max(0.0);
            let ends = [first.position - axis, first.position + axis].map(depth);
            0.5 * ends.iter().map(|depth| depth * depth).sum::<f64>()
        };
        let own = cost(rod.out);
        assert!(
            (own - rod.depth.powi(2)).abs() < 1e-12,
            "{own} {}",
            rod.depth
        );
        for size in [1.0, 0.1, 0.01, 0.001] {
            let other = cost((rod.out + numbers.vector() * size).normalize());
            closest = closest.min(other - own);
        }
    }
    assert!(touching > 300, "{touching}");
    assert!(closest > -1e-12, "{closest}");
}
