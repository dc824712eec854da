//! Vectors and quaternions of the host.

pub type Vector = [f64; 3];

pub fn sum(one: Vector, other: Vector) -> Vector {
    std::array::from_fn(|axis| one[axis] + other[axis])
}

pub fn less(one: Vector, other: Vector) -> Vector {
    std::array::from_fn(|axis| one[axis] - other[axis])
}

pub fn times(vector: Vector, by: f64) -> Vector {
    vector.map(|x| x * by)
}

pub fn dot(one: Vector, other: Vector) -> f64 {
    (0..3).map(|axis| one[axis] * other[axis]).sum()
}

pub fn length(vector: Vector) -> f64 {
    dot(vector, vector).sqrt()
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `vector` turned by a unit quaternion `[w, x, y, z]`.
pub fn turned(q: [f64; 4], vector: Vector) -> Vector {
    let axis = [q[1], q[2], q[3]];
    let twice = times(cross(axis, vector), 2.0);
    sum(sum(vector, times(twice, q[0])), cross(axis, twice))
}

pub fn turned_back([w, x, y, z]: [f64; 4], vector: Vector) -> Vector {
    turned([w, -x, -y, -z], vector)
}

/// `q` after turning on with an angular velocity for `h`.
pub fn turned_on(q: [f64; 4], omega: Vector, h: f64) -> [f64; 4] {
    let [w, x, y, z] = q;
    let [a, b, c] = times(omega, 0.5 * h);
    let next = [
        w - a * x - b * y - c * z,
        x + a * w + b * z - c * y,
        y + b * w + c * x - a * z,
        z + c * w + a * y - b * x,
    ];
    let norm = next.iter().map(|q| q * q).sum::<f64>().sqrt();
    next.map(|q| q / norm)
}
