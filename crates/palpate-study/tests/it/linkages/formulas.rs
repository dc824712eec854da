//! Mass matrices of linkages by formula, and the tables that a file has of them.

/// Derivatives of a number by the coordinates, by central differences.
fn gradient<const N: usize>(place: [f64; N], of: impl Fn([f64; N]) -> f64) -> [f64; N] {
    let step = 1e-5;
    std::array::from_fn(|axis| {
        let moved = |by: f64| {
            let mut moved = place;
            moved[axis] += by;
            of(moved)
        };
        (moved(step) - moved(-step)) / (2.0 * step)
    })
}

/// Sum of inertias times the squares of the rates of coordinates, as a matrix of the place's.
fn mass<const N: usize>(rates: &[(f64, [f64; N])]) -> [[f64; N]; N] {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            rates
                .iter()
                .map(|(inertia, rate)| inertia * rate[row] * rate[column])
                .sum()
        })
    })
}

/// Distance of the two motors of the five-bar, its links from motor to elbow and from elbow to handle `[m]`.
const MOTORS: f64 = 0.038;
const UPPER: f64 = 0.07;
const LOWER: f64 = 0.09;

/// The elbow of the arm that begins at the motor on a side, -1 or 1, of a five-bar whose handle is at a place.
fn elbow(side: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let motor = [side * 0.5 * MOTORS, 0.0];
    let (dx, dy) = (x - motor[0], y - motor[1]);
    let far = dx.hypot(dy);
    let along = (UPPER * UPPER - LOWER * LOWER + far * far) / (2.0 * far);
    let out = (UPPER * UPPER - along * along).sqrt();
    // Both elbows are outside.
    [
        motor[0] + (along * dx + side * out * dy) / far,
        motor[1] + (along * dy - side * out * dx) / far,
    ]
}

/// A handle of 30 g, motors of 1.2e-4 kg m^2, links of 15 and 20 g whose mass is in their middle.
fn of_five_bar(place: [f64; 2]) -> [[f64; 2]; 2] {
    let mut rates = vec![(0.03, [1.0, 0.0]), (0.03, [0.0, 1.0])];
    for side in [-1.0, 1.0] {
        let motor = |place| {
            let [x, y] = elbow(side, place);
            y.atan2(x - side * 0.5 * MOTORS)
        };
        rates.push((
            1.2e-4 + 0.015 * 0.25 * UPPER * UPPER,
            gradient(place, motor),
        ));
        for axis in 0..2 {
            let middle = |place: [f64; 2]| 0.5 * (elbow(side, place)[axis] + place[axis]);
            rates.push((0.02, gradient(place, middle)));
        }
    }
    mass(&rates)
}

fn list(values: impl IntoIterator<Item = f64>) -> String {
    let values: Vec<_> = values
        .into_iter()
        .map(|value| format!("{value:.9}"))
        .collect();
    format!("[{}]", values.join(", "))
}

fn steps(from: f64, to: f64, count: u32) -> Vec<f64> {
    let step = (to - from) / f64::from(count - 1);
    (0..count).map(|n| from + step * f64::from(n)).collect()
}

/// The keys of a five-bar in the plane of its first two axes.
pub fn five_bar() -> String {
    let [x, y] = [steps(-0.06, 0.06, 13), steps(0.07, 0.13, 7)];
    let places = x.iter().flat_map(|&x| y.iter().map(move |&y| [x, y]));
    let masses = places
        .map(of_five_bar)
        .map(|m| list([m[0][0], m[1][1], m[0][1]]));
    let masses: Vec<_> = masses.collect();
    format!(
        "mass_table = {{ places_m = [{}, {}], mass_kg = [{}] }}",
        list(x.clone()),
        list(y.clone()),
        masses.join(", ")
    )
}

/// An arm that turns about an upright axis 0.14 m behind the origin, with two links of 0.14 m of which each has its
/// motor at the base: a handle of 45 g, and 1.3e-3, 1.6e-3 and 1.1e-3 kg m^2 about the three axes.
fn of_arm(place: [f64; 3]) -> [[f64; 3]; 3] {
    const LINK: f64 = 0.14;
    let reach = |[x, y, _]: [f64; 3]| (x + 0.14).hypot(y);
    let yaw = |[x, y, _]: [f64; 3]| y.atan2(x + 0.14);
    let links = |place: [f64; 3]| {
        let (r, z) = (reach(place), place[2] - 0.1);
        let far = r.hypot(z);
        let half = (far / (2.0 * LINK)).acos();
        [z.atan2(r) + half, z.atan2(r) - half]
    };
    let mut rates = vec![
        (0.045, [1.0, 0.0, 0.0]),
        (0.045, [0.0, 1.0, 0.0]),
        (0.045, [0.0, 0.0, 1.0]),
    ];
    rates.push((1.3e-3, gradient(place, yaw)));
    for (link, inertia) in [1.6e-3, 1.1e-3].into_iter().enumerate() {
        rates.push((inertia, gradient(place, |place| links(place)[link])));
    }
    mass(&rates)
}

/// The keys of that arm.
pub fn arm() -> String {
    let places = [
        steps(-0.08, 0.08, 17),
        steps(-0.05, 0.05, 9),
        steps(-0.01, 0.09, 9),
    ];
    let [x, y, z] = &places;
    let mut masses = Vec::new();
    for &x in x {
        for &y in y {
            for &z in z {
                let m = of_arm([x, y, z]);
                masses.push(list([m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]]));
            }
        }
    }
    format!(
        "mass_table = {{ places_m = [{}, {}, {}], mass_kg = [{}] }}",
        list(x.clone()),
        list(y.clone()),
        list(z.clone()),
        masses.join(", ")
    )
}
