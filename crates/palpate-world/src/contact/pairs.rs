//! Pairs of tools and bodies that can touch, and their contact points.

use std::sync::Arc;

use crate::contact::convex_pairs::Blocks;
use crate::contact::law::PointLaw;
use crate::contact::nearby::Patch;
use crate::geometry::convex::NoHull;
use crate::geometry::hull::{Corners, MAX_CORNERS};
use crate::geometry::mesh::{POINTS_PER_MESH, Surface};
use crate::geometry::rigid::{Mobility, Rigid, Vector3};
use crate::geometry::solid::Solid;
use crate::{
    ContactLaw, Mesh, Motion, PointShell, Shape, World, WorldError, WorldErrors, WorldField,
    WorldPart,
};

/// Maximum number of possible contact points of a world, without those of large shells. A tick evaluates all near ones
/// that are not at rest. Each possible point takes about 2.5 kB of memory.
pub const MAX_POSSIBLE_POINTS: usize = 1 << 16;

/// Maximum number of contact points of large shells in a world. A tick visits all of them a few times.
pub const MAX_SHELL_POINTS: usize = 4096;

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The tool with this index, from 0.
    Tool(usize),
    /// The body with this index, from 0.
    Body(usize),
}

impl Side {
    /// Returns the side for an index among tools and bodies, tools first.
    pub(crate) fn new(number: usize, tools: usize) -> Self {
        match number.checked_sub(tools) {
            None => Self::Tool(number),
            Some(body) => Self::Body(body),
        }
    }
}

/// A possible contact point of two tools or bodies: a sphere of the first (radius 0 for a corner) and the nearest
/// point of the second's solid.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// Indices of the two among tools and bodies, tools first.
    pub first: usize,
    pub second: usize,
    /// Whether the sphere's centre differs from the origin of the first.
    pub is_off_centre: bool,
    /// Centre of the sphere, in the axes of the first `[m]`.
    pub centre: Vector3,
    /// Distance of the centre from the mass centre of the first `[m]`.
    pub lever: f64,
    pub radius: f64,
    pub solid: Solid,
    pub law: PointLaw,
    /// Whether the method sets the contact force over an interval; the sub-steps then do not compute it.
    pub is_held: bool,
    /// For both sides, the largest squared lever of a tangential force times the inverse moment of inertia `[1/kg]`.
    pub across: [f64; 2],
    /// For both sides, the same quantity for a normal force: 0 for a sphere.
    pub along: [f64; 2],
}

impl Point {
    /// Returns the position of the sphere's centre `[m]`.
    #[inline]
    pub fn centre_of(&self, first: &Rigid) -> Vector3 {
        if self.is_off_centre {
            first.position + first.orientation * self.centre
        } else {
            first.position
        }
    }

    /// Returns 1 if the tool is the first of the two, on which the contact force acts, and -1 if it is the second, on
    /// which the opposite force acts.
    #[inline]
    pub fn sign_on(&self, tool: usize) -> Option<f64> {
        if self.first == tool {
            Some(1.0)
        } else if self.second == tool {
            Some(-1.0)
        } else {
            None
        }
    }

    /// Returns the tool of the pair, if any: two tools never collide.
    #[inline]
    pub fn tool(&self, tools: usize) -> Option<usize> {
        if self.first < tools {
            Some(self.first)
        } else if self.second < tools {
            Some(self.second)
        } else {
            None
        }
    }
}

/// A tool or body of a world.
struct Candidate<'a> {
    name: &'a str,
    shape: &'a Shape,
    place: WorldPart,
    is_tool: bool,
    is_free: bool,
}

impl Candidate<'_> {
    fn words(&self) -> &'static str {
        match self.shape {
            Shape::Sphere { .. } => "a sphere",
            Shape::Spheres { .. } => "several spheres",
            Shape::HalfSpace { .. } => "a half-space",
            Shape::Box { .. } => "a box",
            Shape::Capsule { .. } => "a capsule",
            Shape::Cylinder { .. } => "a cylinder",
            Shape::Mesh(_) => "a mesh",
            Shape::Hull(_) => "a hull",
        }
    }

    fn moves(&self) -> bool {
        self.is_tool || self.is_free
    }
}

/// Possible contacts between the tools and bodies of a world.
pub(crate) struct Contacts {
    pub points: Vec<Point>,
    /// Points of large shells.
    pub patches: Vec<Patch>,
    /// Meshes in contact with spheres.
    pub surfaces: Vec<Surface>,
    /// Pairs of boxes, hulls, capsules and cylinders.
    pub blocks: Vec<Blocks>,
}

/// Returns all contact points of a checked world, or a fault for every pair that cannot be rendered.
pub(crate) fn points(world: &World, mobilities: &[Mobility]) -> Result<Contacts, WorldErrors> {
    let parts = candidates(world);
    let mut collected = Collected::default();
    for (i, one) in parts.iter().enumerate() {
        for (j, other) in parts.iter().enumerate().skip(i + 1) {
            if (one.is_tool && other.is_tool) || !(one.moves() || other.moves()) {
                continue;
            }
            let Some(law) = world.law(one.name, other.name) else {
                continue;
            };
            let (shapes, numbers) = ([one.shape, other.shape], [i, j]);
            if !collected.add_spheres_on_mesh(shapes, numbers, law)
                && !collected.add_blocks(shapes, numbers, law)
            {
                collected.add_spheres_on_solid([one, other], numbers, law);
            }
            collected.drop_too_many();
        }
    }
    collected.check_count(collected.possible(), "", MAX_POSSIBLE_POINTS);
    collected.check_count(collected.in_patches, " of large shells", MAX_SHELL_POINTS);
    for point in &mut collected.points {
        set_levers(point, mobilities);
    }
    WorldErrors::check(collected.faults)?;
    Ok(Contacts {
        patches: collected.patches,
        points: collected.points,
        surfaces: collected.surfaces,
        blocks: collected.blocks,
    })
}

/// Returns the tools and bodies of a world, tools first.
fn candidates(world: &World) -> Vec<Candidate<'_>> {
    let tools = world.tools.iter().enumerate().map(|(i, tool)| Candidate {
        name: &tool.name,
        shape: &tool.shape,
        place: WorldPart::Tool(i),
        is_tool: true,
        is_free: false,
    });
    let bodies = world.bodies.iter().enumerate().map(|(i, body)| Candidate {
        name: &body.name,
        shape: &body.shape,
        place: WorldPart::Body(i),
        is_tool: false,
        is_free: matches!(body.motion, Motion::Free(_)),
    });
    tools.chain(bodies).collect()
}

/// Sets the bounds of the mobility that a contact point has through rotation, from the mobility of each tool and body.
fn set_levers(point: &mut Point, mobilities: &[Mobility]) {
    let far = point.centre.norm() + point.radius;
    let of_solid = point.solid.reach();
    let lever = |reach: f64, number: usize| {
        let most = mobilities.get(number).map_or(0.0, |m| m.angular.max());
        if most > 0.0 {
            reach * reach * most
        } else {
            0.0
        }
    };
    let [first, second] = [lever(far, point.first), lever(of_solid, point.second)];
    point.across = [first, second];
    let is_ball = matches!(point.solid, Solid::Ball { .. });
    point.along = [
        if point.is_off_centre { first } else { 0.0 },
        if is_ball { 0.0 } else { second },
    ];
}

/// Contacts of the visited pairs, and the errors of pairs without a contact model.
#[derive(Default)]
struct Collected {
    /// All contact points.
    points: Vec<Point>,
    /// Meshes in contact with spheres.
    surfaces: Vec<Surface>,
    /// Pairs of boxes, hulls, capsules and cylinders.
    blocks: Vec<Blocks>,
    /// Points of large shells.
    patches: Vec<Patch>,
    /// Number of points of large shells, including dropped ones.
    in_patches: usize,
    /// Number of dropped points.
    dropped: usize,
    /// Faults of pairs that cannot be rendered.
    faults: Vec<WorldError>,
}

impl Collected {
    /// Adds the contacts of a pair of spheres and a mesh. Returns whether the pair is one.
    fn add_spheres_on_mesh(
        &mut self,
        [one, other]: [&Shape; 2],
        [i, j]: [usize; 2],
        law: &ContactLaw,
    ) -> bool {
        let on_mesh = spheres_on_mesh(one, other).map(|found| (i, j, found));
        let on_mesh = on_mesh.or_else(|| spheres_on_mesh(other, one).map(|found| (j, i, found)));
        let Some((first, second, (spheres, mesh))) = on_mesh else {
            return false;
        };
        for sphere in spheres {
            // A mesh is evaluated once for all points of a sphere.
            self.points.extend((0..POINTS_PER_MESH).map(|point| {
                let solid = Solid::Mesh {
                    surface: self.surfaces.len(),
                    point,
                    reach: mesh.reach(),
                };
                sphere.on(first, second, solid, law)
            }));
            let Touching { centre, radius, .. } = sphere;
            self.surfaces
                .push(Surface::new(mesh.clone(), [first, second], centre, radius));
        }
        true
    }

    /// Adds the contacts of a pair of boxes, hulls, capsules or cylinders. Returns whether the pair is one.
    fn add_blocks(
        &mut self,
        [one, other]: [&Shape; 2],
        [i, j]: [usize; 2],
        law: &ContactLaw,
    ) -> bool {
        // An unbounded half-space has no bounding sphere, so it must be the second.
        let (shapes, sides) = match one {
            Shape::HalfSpace { .. } => ([other, one], [j, i]),
            _ => ([one, other], [i, j]),
        };
        let Some(pair) = Blocks::between(shapes, sides, self.points.len()) else {
            return false;
        };
        let [first, second] = pair.reaches();
        self.points.extend((0..pair.points()).map(|point| Point {
            first: sides[0],
            second: sides[1],
            is_off_centre: true,
            centre: Vector3::x() * first,
            lever: first,
            radius: 0.0,
            solid: Solid::Between {
                blocks: self.blocks.len(),
                point,
                reach: second,
            },
            law: pair.law(law),
            across: [0.0; 2],
            along: [0.0; 2],
            is_held: false,
        }));
        self.blocks.push(pair);
        true
    }

    /// Adds the contacts of any other pair: spheres or corners of one on the solid of the other, or a fault.
    fn add_spheres_on_solid(
        &mut self,
        [one, other]: [&Candidate<'_>; 2],
        [i, j]: [usize; 2],
        law: &ContactLaw,
    ) {
        let mut orders = [(i, j, one, other), (j, i, other, one)];
        if is_smaller_mesh(other.shape, one.shape) {
            orders.reverse();
        }
        let found = orders.into_iter().find_map(|(first, second, one, other)| {
            spheres_on(one.shape, other.shape).map(|found| (first, second, found))
        });
        match found {
            Some((first, second, Ok((spheres, solid)))) => {
                if spheres.len() > PointShell::MAX_ALWAYS {
                    let centres = spheres.iter().map(|sphere| sphere.centre);
                    let numbered = (self.points.len()..).zip(centres);
                    self.patches.extend(Patch::new(numbered.collect()));
                    self.in_patches += spheres.len();
                }
                let each = spheres.iter();
                let each = each.map(|sphere| sphere.on(first, second, solid.clone(), law));
                self.points.extend(each);
            }
            Some((first, _, Err(reason))) => {
                let [first, other] = if first == i {
                    [one, other]
                } else {
                    [other, one]
                };
                self.faults.push(no_corners(first, other, reason));
            }
            None => self.faults.push(no_contact(one, other)),
        }
    }

    /// Returns the number of points outside large shells, including dropped ones.
    fn possible(&self) -> usize {
        self.dropped + self.points.len() - self.in_patches
    }

    /// Drops all contacts if they are too many. The world is then refused, and only their number matters.
    fn drop_too_many(&mut self) {
        if self.possible() > MAX_POSSIBLE_POINTS || self.in_patches > MAX_SHELL_POINTS {
            self.dropped += self.points.len();
            self.points.clear();
            self.surfaces.clear();
            self.blocks.clear();
            self.patches.clear();
        }
    }

    /// Reports `count` contact points of a kind, if they are more than `most`.
    fn check_count(&mut self, count: usize, which: &str, most: usize) {
        if count > most {
            let why = format!(
                "there are {count} points{which} at which its tools and bodies may touch, and at most {most} are allowed; \
                 give laws to fewer pairs"
            );
            self.faults.push(WorldError::new(
                WorldPart::World,
                WorldField::Contacts,
                "the world",
                why,
            ));
        }
    }
}

/// Returns the fault of a pair of shapes without any kind of contact.
fn no_contact(one: &Candidate<'_>, other: &Candidate<'_>) -> WorldError {
    WorldError::new(
        one.place,
        WorldField::Shape,
        format!("{:?} and {:?}", one.name, other.name),
        format!(
            "there is no contact of {} with {} yet: edges can touch away from corners. A mesh can touch a \
             sphere, a tool of several spheres and a half-space; with a shell of points also a box, hull, \
             capsule, cylinder, and a mesh with a distance grid. Change one of the shapes, for example to \
             a hull, or remove the law of the pair",
            one.words(),
            other.words()
        ),
    )
}

/// A sphere of a shape for contacts, and its share of a contact's law.
struct Touching {
    centre: Vector3,
    radius: f64,
    share: f64,
}

/// Returns the fault of a shape whose corners cannot serve as contact points with `other`.
fn no_corners(shape: &Candidate<'_>, other: &Candidate<'_>, reason: NoHull) -> WorldError {
    let why = match reason {
        NoHull::TooMany => format!(
            "its convex hull has more than {MAX_CORNERS} corners, its contact points with a half-space; give it a shell \
             of points (`shell = {{ points = 60 }}` in its mesh), make it a hull (`hull` instead of `mesh`), or remove \
             the law of the pair"
        ),
        NoHull::Flat | NoHull::Broken => {
            "it is flat or nearly flat, so it has no convex hull whose corners could touch a half-space"
                .into()
        }
    };
    let subject = format!("{:?} and {:?}", shape.name, other.name);
    WorldError::new(shape.place, WorldField::Shape, subject, why)
}

/// Returns the spheres of a sphere shape; `None` for any other shape.
fn own_spheres(shape: &Shape) -> Option<Vec<Touching>> {
    let whole = |centre: crate::Vector, radius: f64| Touching {
        centre: centre.into(),
        radius,
        share: 1.0,
    };
    match shape {
        Shape::Sphere { radius } => Some(vec![whole([0.0; 3], *radius)]),
        Shape::Spheres { spheres } => {
            let each = spheres.iter();
            let each = each.map(|sphere| whole(sphere.centre, sphere.radius));
            Some(each.collect())
        }
        _ => None,
    }
}

/// Returns the spheres of a shape and the mesh that they can touch.
fn spheres_on_mesh<'a>(shape: &Shape, other: &'a Shape) -> Option<(Vec<Touching>, &'a Arc<Mesh>)> {
    let mesh = match other {
        Shape::Mesh(mesh) => mesh,
        Shape::Hull(hull) => hull.mesh(),
        _ => return None,
    };
    Some((own_spheres(shape)?, mesh))
}

/// Returns whether the first of two meshes is the smaller one, whose points are used for the contact.
fn is_smaller_mesh(shape: &Shape, other: &Shape) -> bool {
    match (shape, other) {
        (Shape::Mesh(one), Shape::Mesh(other)) => one.reach() < other.reach(),
        _ => false,
    }
}

/// Returns the spheres of a shape for contacts with `other`, and the other's solid, if any contact of the two
/// surfaces involves a sphere.
fn spheres_on(shape: &Shape, other: &Shape) -> Option<Result<(Vec<Touching>, Solid), NoHull>> {
    if let Shape::Mesh(mesh) = shape
        && let Some(shell) = mesh.shell()
        && let Some(solid) = Solid::under_points(other)
    {
        return Some(Ok((shell.touching(), solid)));
    }
    let spheres = match (shape, other) {
        (Shape::Sphere { .. } | Shape::Spheres { .. }, _) => own_spheres(shape)?,
        (Shape::Hull(hull), Shape::HalfSpace { .. }) => hull.by_corners().touching(),
        // A face that lies flat has four corners, each with a quarter of the law.
        (Shape::Box { half_extents }, Shape::HalfSpace { .. }) => (0..8_u8)
            .map(|corner| Touching {
                centre: Vector3::from_fn(|axis, _| {
                    let side = if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                    side * half_extents[axis]
                }),
                radius: 0.0,
                share: 4.0,
            })
            .collect(),
        // Only a corner of the convex hull can touch a plane first.
        (Shape::Mesh(mesh), Shape::HalfSpace { .. }) => match Corners::around(mesh.places(), 0.0) {
            Ok(corners) => corners.touching(),
            Err(reason) => return Some(Err(reason)),
        },
        // A capsule that lies flat has two ends.
        (
            Shape::Capsule {
                radius,
                half_length,
            },
            Shape::HalfSpace { .. },
        ) => [-1.0, 1.0]
            .map(|side| Touching {
                centre: Vector3::new(0.0, 0.0, side * half_length),
                radius: *radius,
                share: 2.0,
            })
            .into(),
        _ => return None,
    };
    Some(Ok((spheres, Solid::new(other)?)))
}

impl Corners {
    /// Returns each corner as a sphere of radius 0 with its share of the law.
    fn touching(&self) -> Vec<Touching> {
        let share = self.most_on_a_face() as f64;
        let each = self.places.iter();
        each.map(|&centre| Touching {
            centre,
            radius: 0.0,
            share,
        })
        .collect()
    }
}

impl PointShell {
    /// Returns each point as a sphere of radius 0 with its share of the law.
    fn touching(&self) -> Vec<Touching> {
        let share = self.sharers() as f64;
        let each = self.places().iter();
        each.map(|&centre| Touching {
            centre,
            radius: 0.0,
            share,
        })
        .collect()
    }
}

impl Touching {
    fn on(&self, first: usize, second: usize, solid: Solid, law: &crate::ContactLaw) -> Point {
        Point {
            first,
            second,
            is_off_centre: self.centre != Vector3::zeros(),
            centre: self.centre,
            lever: self.centre.norm(),
            radius: self.radius,
            solid,
            law: PointLaw::share(law, self.share),
            is_held: false,
            across: [0.0; 2],
            along: [0.0; 2],
        }
    }
}
