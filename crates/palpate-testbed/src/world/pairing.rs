//! Selection of the contact points and surfaces of a pair of members.

use std::sync::Arc;

use super::between::{Flat, Pair as Solids};
use super::contact::{Contact, MAX_CORNERS};
use super::cylinder::Cylinder;
use super::mesh::MAX_CONTACTS;
use super::rod::{Base, Faces, Rod};
use super::scene::{ContactLaw, Member, Pair, Shape, SphereAt, Tool, WorldScene};
use super::vector::Vec3;
use super::wrapping::Wrapped;

/// One side of a pair.
struct Side {
    member: usize,
    /// `None` for several spheres.
    shape: Option<Shape>,
    spheres: Vec<SphereAt>,
    is_device: bool,
    moves: bool,
    name: String,
}

impl Side {
    fn touches_by_spheres(&self) -> bool {
        matches!(self.shape, None | Some(Shape::Sphere { .. }))
    }

    fn new(scene: &WorldScene, member: Member) -> Self {
        match member {
            Member::Device(number) => {
                let device = &scene.devices[number];
                Self {
                    member: number,
                    shape: match &device.tool {
                        Tool::Solid(shape) => Some(shape.clone()),
                        Tool::Spheres(_) => None,
                    },
                    spheres: match &device.tool {
                        Tool::Solid(_) => Vec::new(),
                        Tool::Spheres(spheres) => spheres.clone(),
                    },
                    is_device: true,
                    moves: true,
                    name: format!("the tool of {:?}", device.name),
                }
            }
            Member::Body(number) => {
                let body = &scene.bodies[number];
                Self {
                    member: scene.devices.len() + number,
                    shape: Some(body.shape.clone()),
                    spheres: Vec::new(),
                    is_device: false,
                    moves: body.motion.is_some(),
                    name: format!("the {} {:?}", kind(&body.shape), body.name),
                }
            }
        }
    }
}

fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::HalfSpace { .. } => "half-space",
        Shape::Box { .. } => "box",
        Shape::Capsule { .. } => "capsule",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Mesh(_) => "mesh",
        Shape::Hull(_) => "hull",
    }
}

/// A box or a hull by its flat faces.
fn flat(shape: &Shape) -> Option<Flat> {
    match shape {
        Shape::Box { half_extents } => Flat::of_box(*half_extents),
        Shape::Hull(hull) => Some(Flat::of(hull.wrapped())),
        _ => None,
    }
}

/// Builds the contact of a capsule on another convex solid. Of two capsules the shorter one is the rod; ties go to the
/// first.
fn rod(shapes: [&Shape; 2]) -> Option<Rod> {
    let capsule = |side: usize| match *shapes[side] {
        Shape::Capsule {
            radius,
            half_length,
        } => Some((radius, half_length)),
        _ => None,
    };
    let is_first = match [capsule(0), capsule(1)] {
        [Some((_, one)), Some((_, other))] => one <= other,
        [one, _] => one.is_some(),
    };
    let (radius, half_length) = capsule(usize::from(!is_first))?;
    let base = match shapes[usize::from(is_first)] {
        Shape::Hull(hull) => Base::Flat(Faces::of(hull.wrapped())),
        shape @ (Shape::Box { .. } | Shape::Capsule { .. } | Shape::Cylinder { .. }) => {
            Base::Round(shape.clone())
        }
        _ => return None,
    };
    Some(Rod {
        is_first,
        radius,
        half_length,
        base,
    })
}

/// Builds the contact of a cylinder on a solid with flat faces or on another cylinder. Of two cylinders the shorter one
/// is chosen; ties go to the first.
fn cylinder(shapes: [&Shape; 2]) -> Option<Cylinder> {
    let size = |shape: &Shape| match *shape {
        Shape::Cylinder {
            radius,
            half_length,
        } => Some([radius, half_length]),
        _ => None,
    };
    let on = |is_first: bool, one: [f64; 2], other: &Shape| {
        let flat = match other {
            &Shape::HalfSpace { normal, offset } => Flat::half_space(Vec3(normal), offset),
            solid => flat(solid)?,
        };
        Some(Cylinder::new(is_first, one, flat))
    };
    match shapes.map(size) {
        [Some(one), Some(other)] => Some(if one[1] <= other[1] {
            Cylinder::on_another(true, one, other)
        } else {
            Cylinder::on_another(false, other, one)
        }),
        [Some(one), None] => on(true, one, shapes[1]),
        [None, Some(one)] => on(false, one, shapes[0]),
        [None, None] => None,
    }
}

/// Returns the share of a law for one of `count` contacts that lie flat together.
fn shared(law: &ContactLaw, count: f64) -> ContactLaw {
    ContactLaw {
        stiffness: law.stiffness / count,
        damping: law.damping / count,
        friction_stiffness: law.friction_stiffness / count,
        friction_damping: law.friction_damping / count,
        ..*law
    }
}

/// Builds the point contacts of a mesh that has points, if one of the two is such a mesh and the other one can be
/// touched by points. Of two such meshes the smaller one provides the points if possible.
fn by_points(number: usize, pair: &Pair, sides: [&Side; 2]) -> Option<Vec<Contact>> {
    let mesh = |side: &Side| match &side.shape {
        Some(Shape::Mesh(mesh)) => Some(mesh.clone()),
        _ => None,
    };
    let [one, other] = sides;
    let is_swapped = match (mesh(one), mesh(other)) {
        (Some(one), Some(other)) => other.reach() < one.reach(),
        _ => false,
    };
    let orders = if is_swapped {
        [[other, one], [one, other]]
    } else {
        [[one, other], [other, one]]
    };
    orders.into_iter().find_map(|[first, second]| {
        let with_points = mesh(first)?;
        let (points, sharers) = with_points.points()?;
        let field = match second.shape.as_ref()? {
            Shape::Mesh(mesh) => Some(mesh.field()?.clone()),
            Shape::HalfSpace { .. }
            | Shape::Box { .. }
            | Shape::Hull(_)
            | Shape::Capsule { .. }
            | Shape::Cylinder { .. } => None,
            Shape::Sphere { .. } => return None,
        };
        let each = points.iter().map(|&on_first| Contact {
            pair: number,
            first: first.member,
            second: second.member,
            on_first,
            radius: 0.0,
            surface: second
                .shape
                .clone()
                .unwrap_or(Shape::Sphere { radius: 0.0 }),
            solids: None,
            rod: None,
            cylinder: None,
            field: field.clone(),
            law: shared(&pair.law, sharers as f64),
        });
        Some(each.collect())
    })
}

/// The contacts of a pair of a checked scene, or why there are none.
pub(super) fn of_pair(
    scene: &WorldScene,
    number: usize,
    pair: &Pair,
) -> Result<Vec<Contact>, String> {
    let [one, other] = pair.between.map(|member| Side::new(scene, member));
    if one.member == other.member {
        return Err(format!("{} cannot touch itself", one.name));
    }
    if one.is_device && other.is_device {
        return Err(format!(
            "{} and {} are both tools, which do not touch each other",
            one.name, other.name
        ));
    }
    if !one.moves && !other.moves {
        return Ok(Vec::new()); // nothing changes between two fixed bodies
    }
    if let Some(contacts) = by_points(number, pair, [&one, &other]) {
        return Ok(contacts);
    }
    let [first, second] = ordered(one, other);
    let no_contact = || {
        format!(
            "there is no contact between {} and {}",
            first.name, second.name
        )
    };
    let surface = match second.shape.as_ref().ok_or_else(no_contact)? {
        // A sphere touches its triangles.
        Shape::Hull(hull) if first.touches_by_spheres() => &Shape::Mesh(hull.mesh().clone()),
        other => other,
    };
    let pairing = Pairing {
        number,
        law: pair.law,
        first: &first,
        second: second.member,
        surface,
    };
    pairing.contacts().ok_or_else(no_contact)
}

/// Returns the two sides in the order of their contacts.
fn ordered(one: Side, other: Side) -> [Side; 2] {
    // The tool comes first, then a free sphere, so the sphere is the first member.
    let rank = |side: &Side| match side.shape {
        Some(Shape::Sphere { .. }) => 2 + u8::from(side.is_device),
        None => 3,
        Some(Shape::HalfSpace { .. }) => 0,
        Some(_) => 1,
    };
    if rank(&one) >= rank(&other) {
        [one, other]
    } else {
        [other, one]
    }
}

/// A pair whose first side touches a surface of the second.
struct Pairing<'a> {
    /// Number of the pair.
    number: usize,
    /// Law of the pair.
    law: ContactLaw,
    /// The side with the contact points.
    first: &'a Side,
    /// Number of the second member.
    second: usize,
    /// Surface of the second side.
    surface: &'a Shape,
}

impl Pairing<'_> {
    /// Returns the contacts of the pair; `None` if there is no contact between such shapes.
    fn contacts(&self) -> Option<Vec<Contact>> {
        if let Some(contacts) = self.by_rod().or_else(|| self.by_cylinder()) {
            return Some(contacts);
        }
        let first = self.first;
        match (&first.shape, self.surface) {
            (&Some(Shape::Sphere { radius }), Shape::Mesh(_)) => {
                let one = self.contact(Vec3::ZERO, radius, self.law);
                Some(vec![one; MAX_CONTACTS])
            }
            (None, Shape::Mesh(_)) => Some(
                first
                    .spheres
                    .iter()
                    .flat_map(|sphere| {
                        let one = self.contact(Vec3(sphere.centre), sphere.radius, self.law);
                        vec![one; MAX_CONTACTS]
                    })
                    .collect(),
            ),
            (None, _) => Some(
                first
                    .spheres
                    .iter()
                    .map(|sphere| self.contact(Vec3(sphere.centre), sphere.radius, self.law))
                    .collect(),
            ),
            (&Some(Shape::Sphere { radius }), _) => {
                Some(vec![self.contact(Vec3::ZERO, radius, self.law)])
            }
            (
                Some(one @ (Shape::Box { .. } | Shape::Hull(_))),
                other @ (Shape::Box { .. } | Shape::Hull(_)),
            ) => self.by_flat_faces([one, other]),
            (Some(one), Shape::HalfSpace { .. }) => self.on_half_space(one),
            _ => None,
        }
    }

    /// Creates a contact of a sphere of `radius` `[m]` at a place in the axes of the first side `[m]`.
    fn contact(&self, on_first: Vec3, radius: f64, law: ContactLaw) -> Contact {
        Contact {
            pair: self.number,
            first: self.first.member,
            second: self.second,
            on_first,
            radius,
            surface: self.surface.clone(),
            solids: None,
            rod: None,
            cylinder: None,
            field: None,
            law,
        }
    }

    /// Returns the contacts of the two ends of a capsule on another convex solid.
    fn by_rod(&self) -> Option<Vec<Contact>> {
        let one = self.first.shape.as_ref()?;
        let rod = Arc::new(rod([one, self.surface])?);
        let end = |end: usize| Contact {
            rod: Some((rod.clone(), end)),
            ..self.contact(Vec3::ZERO, 0.0, shared(&self.law, 2.0))
        };
        Some(vec![end(0), end(1)])
    }

    /// Returns the contacts of a cylinder on a solid with flat faces or on another cylinder.
    fn by_cylinder(&self) -> Option<Vec<Contact>> {
        let one = self.first.shape.as_ref()?;
        let cylinder = Arc::new(cylinder([one, self.surface])?);
        let law = shared(&self.law, cylinder.share() as f64);
        let each = (0..cylinder.contacts()).map(|number| Contact {
            cylinder: Some((cylinder.clone(), number)),
            ..self.contact(Vec3::ZERO, 0.0, law)
        });
        Some(each.collect())
    }

    /// Returns the contacts of two boxes or hulls.
    fn by_flat_faces(&self, [one, other]: [&Shape; 2]) -> Option<Vec<Contact>> {
        let two = [flat(one), flat(other)];
        let [Some(one), Some(other)] = two else {
            return None;
        };
        let solids = Arc::new(Solids([one, other]));
        let law = shared(&self.law, solids.share() as f64);
        let each = (0..solids.contacts()).map(|number| Contact {
            solids: Some((solids.clone(), number)),
            ..self.contact(Vec3::ZERO, 0.0, law)
        });
        Some(each.collect())
    }

    /// Returns the contacts of a box, capsule, mesh or hull on a half-space.
    fn on_half_space(&self, shape: &Shape) -> Option<Vec<Contact>> {
        match shape {
            Shape::Box { half_extents } => {
                let law = shared(&self.law, 4.0);
                let corner = |index: usize| {
                    Vec3(std::array::from_fn(|axis| {
                        let sign = if index >> axis & 1 == 0 { -1.0 } else { 1.0 };
                        sign * half_extents[axis]
                    }))
                };
                let corners = (0..8).map(|index| self.contact(corner(index), 0.0, law));
                Some(corners.collect())
            }
            &Shape::Capsule {
                radius,
                half_length,
            } => {
                let law = shared(&self.law, 2.0);
                let end =
                    |side: f64| self.contact(Vec3([0.0, 0.0, side * half_length]), radius, law);
                Some(vec![end(-1.0), end(1.0)])
            }
            Shape::Mesh(mesh) => {
                let places: Vec<Vec3> = mesh.vertices().into_iter().map(Vec3).collect();
                Some(self.by_corners(&Wrapped::around(&places, MAX_CORNERS)?))
            }
            Shape::Hull(hull) => Some(self.by_corners(hull.wrapped())),
            _ => None,
        }
    }

    /// Returns the contacts of the corners of a convex hull.
    fn by_corners(&self, hull: &Wrapped) -> Vec<Contact> {
        let law = shared(&self.law, hull.most_corners() as f64);
        let each = hull.corners.iter();
        each.map(|corner| self.contact(*corner, 0.0, law)).collect()
    }
}
