//! Several faces that push a sphere, as few contacts.
//!
//! Faces that meet at less than [`SHARP`] are one bent surface: a sphere in the bend is pushed along the shortest way
//! out of all of them, as by a surface without facets. Faces that meet at more are two surfaces, and each pushes by
//! itself, as two half-spaces do.

use crate::rigid::Vector3;

/// Cosine of the angle between two normals from which on their faces push apart from each other: 30 degrees.
pub(super) const SHARP: f64 = 0.866_025_403_784_438_6;
/// Most surfaces that are looked at for one sphere.
pub(super) const MOST_PUSHES: usize = 16;

/// A surface that a sphere overlaps, as a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Push {
    /// Unit vector out of the solid.
    pub normal: Vector3,
    /// By how much the sphere overlaps it `[m]`.
    pub depth: f64,
}

/// The shortest way out of all `pushes` `[m]`: the least d with n . d >= depth for every one. Of none, no way.
pub(super) fn way_out(pushes: &[Push]) -> Vector3 {
    let Some(deepest) = pushes.iter().max_by(|a, b| a.depth.total_cmp(&b.depth)) else {
        return Vector3::zeros();
    };
    let slack = 1e-12 * deepest.depth.abs();
    let mut active = [*deepest; 4];
    let mut count = 1;
    let mut way = deepest.normal * deepest.depth;
    // Each round makes the way longer, so none comes back; three surfaces hold a point.
    for _ in 0..MOST_PUSHES {
        let short = |push: &Push| push.depth - push.normal.dot(&way);
        let Some(next) = pushes.iter().max_by(|a, b| short(a).total_cmp(&short(b))) else {
            break;
        };
        if short(next) <= slack {
            break;
        }
        active[count] = *next;
        let Some((subset, longer)) = least_among(&active[..=count], slack) else {
            break;
        };
        way = longer;
        let kept = active;
        count = 0;
        for (place, push) in kept.iter().enumerate() {
            if subset >> place & 1 == 1 {
                active[count] = *push;
                count += 1;
            }
        }
    }
    way
}

/// The shortest way out of up to 4 surfaces, and which of them it touches, as bits. The last one is among those.
fn least_among(pushes: &[Push], slack: f64) -> Option<(u8, Vector3)> {
    let last = pushes.len() - 1;
    let mut best: Option<(u8, Vector3)> = None;
    for others in 0..1_u8 << last {
        let subset = others | 1 << last;
        if subset.count_ones() > 3 {
            continue;
        }
        let Some(way) = touching(pushes, subset) else {
            continue;
        };
        let is_out = |push: &Push| push.normal.dot(&way) >= push.depth - slack;
        let shorter = best.is_none_or(|(_, other)| way.norm_squared() < other.norm_squared());
        if shorter && pushes.iter().all(is_out) {
            best = Some((subset, way));
        }
    }
    best
}

/// The way that ends on all surfaces of the subset and that each of them pushes along.
fn touching(pushes: &[Push], subset: u8) -> Option<Vector3> {
    let mut of = [pushes[0]; 3];
    let mut count = 0;
    for (place, push) in pushes.iter().enumerate() {
        if subset >> place & 1 == 1 {
            of[count] = *push;
            count += 1;
        }
    }
    let [a, b, c] = of;
    match count {
        1 => Some(a.normal * a.depth),
        2 => {
            let cosine = a.normal.dot(&b.normal);
            let square = 1.0 - cosine * cosine;
            let shares = [a.depth - cosine * b.depth, b.depth - cosine * a.depth];
            (square > 1e-14 && shares.iter().all(|share| *share >= 0.0))
                .then(|| (a.normal * shares[0] + b.normal * shares[1]) / square)
        }
        _ => {
            let (bc, ca, ab) = (
                b.normal.cross(&c.normal),
                c.normal.cross(&a.normal),
                a.normal.cross(&b.normal),
            );
            let volume = a.normal.dot(&bc);
            if volume.abs() < 1e-12 {
                return None;
            }
            let way = (bc * a.depth + ca * b.depth + ab * c.depth) / volume;
            // Shares of the normals in the way.
            let shares = [bc, ca, ab].map(|across| across.dot(&way) / volume);
            shares.iter().all(|share| *share >= 0.0).then_some(way)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(x: f64, y: f64, z: f64, depth: f64) -> Push {
        Push {
            normal: Vector3::new(x, y, z).normalize(),
            depth,
        }
    }

    #[test]
    fn one_plane_twice_is_one_plane() {
        let one = push(0.0, 0.6, 0.8, 2e-4);
        let way = way_out(&[one, one, push(0.0, 0.6, 0.8, 1e-4)]);
        assert!((way - one.normal * 2e-4).norm() < 1e-18);
    }

    #[test]
    fn at_right_angles_every_plane_gives_its_depth() {
        let way = way_out(&[
            push(1.0, 0.0, 0.0, 1e-4),
            push(0.0, 1.0, 0.0, 2e-4),
            push(0.0, 0.0, 1.0, 3e-4),
        ]);
        assert!((way - Vector3::new(1e-4, 2e-4, 3e-4)).norm() < 1e-17);
    }

    /// Out of all, and no shorter way is: by comparison with the way that Hildreth's iteration finds.
    #[test]
    fn the_way_out_is_the_shortest() {
        for number in 0..300 {
            let part = |prime: f64| (f64::from(number + 1) * prime).fract() - 0.5;
            let pushes: Vec<Push> = (0..7)
                .map(|k| {
                    let k = 1.0 + f64::from(k);
                    push(
                        part(0.754_877 * k),
                        part(0.569_840 * k),
                        0.7 + part(0.430_160 * k),
                        1e-3 * (part(0.33 * k) + 0.6),
                    )
                })
                .collect();
            let way = way_out(&pushes);
            for push in &pushes {
                assert!(push.normal.dot(&way) >= push.depth - 1e-15);
            }
            let mut shares = vec![0.0_f64; pushes.len()];
            let mut iterated = Vector3::zeros();
            for _ in 0..20_000 {
                for (share, push) in shares.iter_mut().zip(&pushes) {
                    let more = (push.depth - push.normal.dot(&iterated)).max(-*share);
                    *share += more;
                    iterated += push.normal * more;
                }
            }
            assert!((way - iterated).norm() < 1e-9, "{number} {way} {iterated}");
        }
    }
}
