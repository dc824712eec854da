//! Analytic meshes, and a device in a hand that is held between samples.

use std::sync::Arc;

use palpate_world::{
    Body, Contact, ContactLaw, CoupledParams, Mesh, Motion, Output, Party, Sample, Shape, Tool,
    Vector, World, WorldLoop, WorldRenderer, WorldState,
};

pub const PERIOD: f64 = 0.001;

/// Returns a surface patch over a square of half side `half`, with `cells` by `cells` squares of two triangles each.
/// The diagonals alternate between squares, so all kinds of corners occur.
pub fn patch(half: f64, cells: u32, place: impl Fn(f64, f64) -> Vector) -> Mesh {
    let at = |k: u32| half * (2.0 * f64::from(k) / f64::from(cells) - 1.0);
    let row = cells + 1;
    let vertices: Vec<Vector> = (0..row * row)
        .map(|k| place(at(k % row), at(k / row)))
        .collect();
    let mut faces = Vec::new();
    for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
        let [a, b] = [j * row + i, j * row + i + 1];
        let [c, d] = [b + row, a + row];
        if (i + j) % 2 == 0 {
            faces.extend([[a, b, c], [a, c, d]]);
        } else {
            faces.extend([[a, b, d], [b, c, d]]);
        }
    }
    Mesh::new(&vertices, &faces).unwrap()
}

/// Merges two meshes.
pub fn both(one: &Mesh, other: &Mesh) -> Mesh {
    let mut vertices = one.vertices();
    let first = u32::try_from(vertices.len()).unwrap();
    vertices.extend(other.vertices());
    let mut faces = one.faces().to_vec();
    faces.extend(
        other
            .faces()
            .iter()
            .map(|face| face.map(|corner| corner + first)),
    );
    Mesh::new(&vertices, &faces).unwrap()
}

/// Returns an axis-aligned block with each face divided into `cells` by `cells` squares.
pub fn block(half: Vector, cells: u32) -> Mesh {
    let mut all: Option<Mesh> = None;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let face = patch(1.0, cells, |u, v| {
                let mut place = [0.0; 3];
                place[axis] = side * half[axis];
                // Outward normal.
                let [one, other] = if side > 0.0 { [u, v] } else { [v, u] };
                place[(axis + 1) % 3] = one * half[(axis + 1) % 3];
                place[(axis + 2) % 3] = other * half[(axis + 2) % 3];
                place
            });
            all = Some(all.map_or(face.clone(), |all| both(&all, &face)));
        }
    }
    all.unwrap()
}

pub fn fixed(name: &str, mesh: Mesh) -> Body {
    Body::new(name, Shape::Mesh(Arc::new(mesh)), Motion::Fixed)
}

pub fn plane(name: &str, normal: Vector, offset: f64) -> Body {
    Body::new(name, Shape::HalfSpace { normal, offset }, Motion::Fixed)
}

pub fn world(radius: f64, bodies: Vec<Body>, law: ContactLaw) -> World {
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius })],
        bodies,
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law,
        }],
    }
}

/// A device of 0.15 kg moved by a hand.
pub struct Hand {
    pub position: Vector,
    pub velocity: Vector,
    /// Rest position of its spring at a time `[m]`.
    pub rest: Box<dyn Fn(f64) -> Vector>,
}

pub const MASS: f64 = 0.15;

impl Hand {
    pub fn at(position: Vector, rest: impl Fn(f64) -> Vector + 'static) -> Self {
        Self {
            position,
            velocity: [0.0; 3],
            rest: Box::new(rest),
        }
    }

    fn hold(&mut self, force: Vector, time: f64) {
        let rest = (self.rest)(time);
        for _ in 0..20 {
            for axis in 0..3 {
                let pull = 300.0 * (rest[axis] - self.position[axis]) - 6.0 * self.velocity[axis];
                self.velocity[axis] += (force[axis] + pull) / MASS * PERIOD / 20.0;
                self.position[axis] += self.velocity[axis] * PERIOD / 20.0;
            }
        }
    }
}

pub fn coupled(world: &World) -> WorldRenderer {
    let method = CoupledParams::new(vec![[MASS; 3]]);
    WorldRenderer::new(world, WorldLoop::new(PERIOD), method).unwrap()
}

/// Runs a loop for a number of samples; `look` is called with each output.
pub fn run(
    renderer: &WorldRenderer,
    mut hand: Hand,
    samples: u32,
    mut look: impl FnMut(u32, &Hand, &Output<'_>),
) -> WorldState {
    let mut state = renderer.start();
    for sample in 0..samples {
        let output = renderer.step(&mut state, &Sample::at(&[hand.position]));
        assert_eq!(output.fault, None);
        look(sample, &hand, &output);
        let force = output.forces[0];
        hand.hold(force, f64::from(sample) * PERIOD);
    }
    state
}

/// Returns the largest force of the same hand in two worlds, and the largest difference between the forces `[N]`.
pub fn compare(one: &World, other: &World, hand: impl Fn() -> Hand, samples: u32) -> (f64, f64) {
    let mut forces = Vec::new();
    let mut largest = 0.0_f64;
    run(&coupled(one), hand(), samples, |_, _, output| {
        forces.push(output.forces[0]);
    });
    let mut apart = 0.0_f64;
    run(&coupled(other), hand(), samples, |sample, _, output| {
        let force = output.forces[0];
        for axis in 0..3 {
            largest = largest.max(force[axis].abs());
            apart = apart.max((force[axis] - forces[sample as usize][axis]).abs());
        }
        assert_eq!(output.effort.left_out, 0);
    });
    (largest, apart)
}

/// Extrudes an outline along z from -`half` to `half`. The outline is in the xy plane, counter-clockwise and divided
/// into `triangles`.
pub fn drawn_out(outline: &[[f64; 2]], triangles: &[[u32; 3]], half: f64) -> Mesh {
    let count = u32::try_from(outline.len()).unwrap();
    let at = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let vertices: Vec<Vector> = at(-half).chain(at(half)).collect();
    let mut faces = Vec::new();
    for &[a, b, c] in triangles {
        faces.extend([[a, c, b], [a + count, b + count, c + count]]);
    }
    for corner in 0..count {
        let next = (corner + 1) % count;
        faces.push([corner, next, next + count]);
        faces.push([corner, next + count, corner + count]);
    }
    Mesh::new(&vertices, &faces).unwrap()
}
