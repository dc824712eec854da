//! Reduction of the faces that push a sphere to few contacts.
//!
//! Faces form one curved surface if their normals differ by less than [`SHARP`] from one to the next, or if they
//! belong to one [hollow](super::hollow), which may surround the sphere, as in a conical hole. The sphere is pushed
//! along the shortest way out of all faces of the surface, as by a smooth surface. If that way is longer than
//! [`STEEP`] times the depth or does not exist, as in a narrow tube, only faces within [`SHARP`] of the deepest face
//! form one surface. Each surface pushes independently, like a half-space.

use super::hollow::Around;
use super::topology::SHARP;
use crate::geometry::rigid::Vector3;

/// Maximum length of the way out of a curved surface, relative to its largest depth. The value is that of a cone
/// whose side is 19.5 degrees from its axis.
const STEEP: f64 = 3.0;
/// Maximum number of faces considered for one sphere: the number of bits of a [`Chosen`].
const MAX_PUSHES: usize = 64;
/// Remaining overlap of a sphere that is lifted out of a curved surface, as a fraction of its depth.
const LIFTED: f64 = 1e-11;

/// A face that a sphere overlaps, treated as a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Push {
    /// Unit normal out of the solid.
    pub normal: Vector3,
    /// Overlap with the sphere `[m]`.
    pub depth: f64,
    /// Index of the triangle.
    pub triangle: u32,
    /// Whether the contact is on the face and not on an edge or a corner.
    pub is_face: bool,
}

/// Set of pushing faces, as bits.
pub(super) type Chosen = u64;

/// Faces that push a sphere at its current position.
#[derive(Clone, Debug)]
pub(super) struct Pushes {
    all: Box<[Push]>,
    count: usize,
    /// Faces that have been removed.
    gone: Chosen,
    /// Number of faces beyond the capacity.
    pub left_out: u32,
}

/// Iterates over the indices in the set.
fn numbers(chosen: Chosen) -> impl Iterator<Item = usize> {
    let mut rest = chosen;
    std::iter::from_fn(move || {
        let number = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
        rest &= rest - 1;
        Some(number)
    })
}

impl Pushes {
    pub fn none() -> Self {
        let nothing = Push {
            normal: Vector3::zeros(),
            depth: 0.0,
            triangle: 0,
            is_face: false,
        };
        Self {
            all: vec![nothing; MAX_PUSHES].into(),
            count: 0,
            gone: 0,
            left_out: 0,
        }
    }

    /// Removes all faces.
    pub fn clear(&mut self) {
        self.count = 0;
        self.gone = 0;
        self.left_out = 0;
    }

    /// Adds a face. If the capacity is exceeded, the deepest faces are kept.
    pub fn add(&mut self, push: Push) {
        if let Some(free) = self.all.get_mut(self.count) {
            *free = push;
            self.count += 1;
            return;
        }
        self.left_out += 1;
        let least = self
            .all
            .iter_mut()
            .min_by(|a, b| a.depth.total_cmp(&b.depth));
        if let Some(least) = least
            && least.depth < push.depth
        {
            *least = push;
        }
    }

    /// Returns the faces of the surface that contains the deepest face.
    pub fn deepest_surface(&self, around: Option<&mut Around>) -> Chosen {
        let all = self.left();
        self.deepest(all)
            .map_or(0, |deepest| self.joined(all, deepest, around))
    }

    /// Returns whether there is more than one face, so that one may hide another.
    pub fn are_several(&self) -> bool {
        self.count > 1
    }

    /// Removes the faces outside `surface` that are not visible.
    pub fn hide(&mut self, surface: Chosen, is_seen: impl Fn(&Push) -> bool) {
        for number in numbers(self.left() & !surface) {
            if !is_seen(&self.all[number]) {
                self.gone |= 1 << number;
            }
        }
    }

    /// Removes the surface that contains the deepest remaining face, and returns its depth `[m]` and normal.
    pub fn take_surface(&mut self, mut around: Option<&mut Around>) -> Option<(f64, Vector3)> {
        let all = self.left();
        let deepest = self.deepest(all)?;
        let joined = self.joined(all, deepest, around.as_deref_mut());
        let first = self.all[deepest];
        let whole = self.way_out_of_all(joined, &first, around);
        let (surface, way) = match whole {
            Some(way) => (joined, way),
            None => {
                let beside = numbers(joined)
                    .filter(|&other| self.all[other].normal.dot(&first.normal) > SHARP)
                    .fold(1 << deepest, |beside, other| beside | 1 << other);
                let way = way_out(self.of(beside), &first);
                (beside, way.unwrap_or(first.normal * first.depth))
            }
        };
        self.gone |= surface;
        let depth = way.norm();
        let is_one = way == first.normal * first.depth;
        let normal = if is_one || depth <= 0.0 {
            first.normal
        } else {
            way / depth
        };
        Some((depth, normal))
    }

    /// Returns the shortest way `[m]` out of a curved surface with a given deepest face, after which the sphere
    /// overlaps none of it. Returns `None` if there is none or it is too long.
    fn way_out_of_all(
        &mut self,
        surface: Chosen,
        first: &Push,
        around: Option<&mut Around>,
    ) -> Option<Vector3> {
        let near = first.depth * STEEP;
        let is_near = |way: &Vector3| way.norm() <= near;
        let mut way = if surface.is_power_of_two() {
            first.normal * first.depth
        } else {
            way_out(self.of(surface), first).filter(is_near)?
        };
        let Some(around) = around.filter(|around| around.is_hollow()) else {
            return Some(way);
        };
        let (count, mut pushing) = (self.count, surface);
        let slack = LIFTED * first.depth;
        while let Some(next) = around.in_the_way(self.faces_of(pushing), &way, slack) {
            let Some(free) = self.all.get_mut(self.count) else {
                self.left_out += 1;
                break;
            };
            *free = next;
            pushing |= 1 << self.count;
            self.count += 1;
            let longer = way_out(self.of(pushing), first).filter(is_near);
            let Some(longer) = longer else {
                self.count = count;
                return None;
            };
            way = longer;
        }
        self.count = count;
        Some(way)
    }

    /// Iterates over the triangles of those pushes that are faces.
    fn faces_of(&self, chosen: Chosen) -> impl Iterator<Item = u32> + Clone {
        self.of(chosen)
            .filter(|push| push.is_face)
            .map(|push| push.triangle)
    }

    /// Returns whether any face remains.
    pub fn are_left(&self) -> bool {
        self.left() != 0
    }

    fn left(&self) -> Chosen {
        let all = if self.count < MAX_PUSHES {
            (1 << self.count) - 1
        } else {
            Chosen::MAX
        };
        all & !self.gone
    }

    fn of(&self, chosen: Chosen) -> impl Iterator<Item = &Push> + Clone {
        let all = &self.all;
        (0..self.count)
            .filter(move |number| chosen >> number & 1 == 1)
            .map(|number| &all[number])
    }

    fn deepest(&self, among: Chosen) -> Option<usize> {
        numbers(among).max_by(|&a, &b| self.all[a].depth.total_cmp(&self.all[b].depth))
    }

    /// Returns the faces that form one curved surface with a given one.
    #[inline]
    fn joined(&self, among: Chosen, one: usize, around: Option<&mut Around>) -> Chosen {
        if among.is_power_of_two() {
            return among;
        }
        self.joined_of_several(among, one, around)
    }

    fn joined_of_several(&self, among: Chosen, one: usize, around: Option<&mut Around>) -> Chosen {
        let surface = self.alike(among, 1 << one);
        let others = among & !surface;
        let Some(around) = around else {
            return surface;
        };
        if self.faces_of(others).next().is_none() || !around.is_hollow() {
            return surface;
        }
        let reached = around.reached(self.faces_of(surface));
        let linked = numbers(others)
            .filter(|&other| self.all[other].is_face && reached(self.all[other].triangle))
            .fold(0, |linked, other| linked | 1 << other);
        self.alike(among, surface | linked)
    }

    /// Returns the faces connected to `some` by normals that differ by less than [`SHARP`] from one to the next.
    fn alike(&self, among: Chosen, some: Chosen) -> Chosen {
        let mut surface = some;
        let mut border = surface;
        while border != 0 {
            let reached = border.trailing_zeros() as usize;
            border &= border - 1;
            for other in numbers(among & !surface) {
                if self.all[other].normal.dot(&self.all[reached].normal) > SHARP {
                    surface |= 1 << other;
                    border |= 1 << other;
                }
            }
        }
        surface
    }
}

/// Returns the shortest way out of all `pushes` `[m]`: the shortest d with n . d >= depth for each of them. `deepest`
/// is one of them. Returns `None` if there is none.
fn way_out<'a>(pushes: impl Iterator<Item = &'a Push> + Clone, deepest: &Push) -> Option<Vector3> {
    let slack = 1e-12 * deepest.depth.abs();
    let mut active = [*deepest; 4];
    let mut count = 1;
    let mut way = deepest.normal * deepest.depth;
    // Each round lengthens the way, so no active set repeats. Three surfaces determine a point.
    for _ in 0..MAX_PUSHES {
        let short = |push: &Push| push.depth - push.normal.dot(&way);
        let next = pushes
            .clone()
            .max_by(|a, b| short(a).total_cmp(&short(b)))?;
        if short(next) <= slack {
            return Some(way);
        }
        active[count] = *next;
        let (subset, longer) = least_among(&active[..=count], slack)?;
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
    None
}

/// Returns the shortest way out of up to 4 surfaces, and the touched surfaces as bits. These include the last one.
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

/// Returns the way that ends on all surfaces of the subset, if each of them pushes along it.
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
            // Coefficients of the normals in the way.
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
            triangle: 0,
            is_face: true,
        }
    }

    /// Returns the shortest way out of some faces, of which the first need not be the deepest.
    fn shortest(pushes: &[Push]) -> Vector3 {
        let deepest = pushes.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        way_out(pushes.iter(), deepest.unwrap()).unwrap()
    }

    #[test]
    fn one_plane_twice_is_one_plane() {
        let one = push(0.0, 0.6, 0.8, 2e-4);
        let way = shortest(&[one, one, push(0.0, 0.6, 0.8, 1e-4)]);
        assert!((way - one.normal * 2e-4).norm() < 1e-18);
    }

    /// Returns faces all around an axis with an inclination `lean` [rad], and the depths for the way out of them.
    fn ring(count: u32, lean: f64, way: &Vector3) -> Pushes {
        let mut pushes = Pushes::none();
        for number in 0..count {
            let about = std::f64::consts::TAU * f64::from(number) / f64::from(count);
            let normal = Vector3::new(
                about.cos() * lean.cos(),
                about.sin() * lean.cos(),
                lean.sin(),
            );
            pushes.add(Push {
                normal,
                depth: normal.dot(way),
                triangle: number,
                is_face: true,
            });
        }
        pushes
    }

    #[test]
    fn a_cone_is_one_surface_and_its_way_out_leads_to_its_tip() {
        let way = Vector3::new(2e-5, -1e-5, 8e-4);
        for (count, lean) in [(12, 0.5), (24, 0.9), (64, 1.2)] {
            let mut pushes = ring(count, lean, &way);
            let (depth, normal) = pushes.take_surface(None).unwrap();
            assert!(
                (normal * depth - way).norm() < 1e-12,
                "{count} {normal} {depth}"
            );
            assert_eq!(pushes.take_surface(None), None);
        }
    }

    /// A cone whose tip is at 3.4 times the distance of its side, and a tube, push from several sides.
    #[test]
    fn what_is_too_narrow_is_several_surfaces() {
        let mut steep = ring(24, 0.3, &Vector3::new(0.0, 0.0, 1e-3));
        let (depth, _) = steep.take_surface(None).unwrap();
        assert!(
            depth < 5e-4 && steep.take_surface(None).is_some(),
            "{depth}"
        );
        let mut tube = Pushes::none();
        for side in [1.0, -1.0] {
            tube.add(push(side, 0.0, 0.0, 1e-4));
        }
        for side in [1.0, -1.0] {
            let (depth, normal) = tube.take_surface(None).unwrap();
            assert_eq!(
                (depth, normal.x),
                (1e-4, -side),
                "the later of equals comes first"
            );
        }
    }

    #[test]
    fn of_too_many_the_deepest_stay_and_the_others_are_counted() {
        let mut pushes = Pushes::none();
        for number in 0..70 {
            pushes.add(push(0.0, 0.0, 1.0, 1e-4 + 1e-6 * f64::from(number)));
        }
        assert_eq!(pushes.left_out, 6);
        assert_eq!(pushes.take_surface(None).unwrap().0, 1e-4 + 69e-6);
    }

    /// Faces of the deepest surface are not hidden by it; other faces push only if they are visible.
    #[test]
    fn what_is_not_seen_does_not_push() {
        let mut pushes = Pushes::none();
        pushes.add(push(0.0, 0.0, 1.0, 2e-4));
        pushes.add(push(0.3, 0.0, 1.0, 1e-4));
        pushes.add(push(1.0, 0.0, 0.0, 1e-4));
        let surface = pushes.deepest_surface(None);
        pushes.hide(surface, |_| false);
        assert!(pushes.take_surface(None).is_some());
        assert_eq!(pushes.take_surface(None), None);
    }

    #[test]
    fn at_right_angles_every_plane_gives_its_depth() {
        let way = shortest(&[
            push(1.0, 0.0, 0.0, 1e-4),
            push(0.0, 1.0, 0.0, 2e-4),
            push(0.0, 0.0, 1.0, 3e-4),
        ]);
        assert!((way - Vector3::new(1e-4, 2e-4, 3e-4)).norm() < 1e-17);
    }

    /// The result lies outside all faces and is the shortest way, in comparison with Hildreth's iteration.
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
            let way = shortest(&pushes);
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
