//! Messages about a world: its shapes once, the poses sixty times a second.

use palpate_device::{Capabilities, Vector};
use palpate_record::recording::{BodyTick, ContactTick, Row, Tick};
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::SpatialHand;
use palpate_world::{Mesh, Motion, Shape};
use serde_json::{Value, json};

use super::coarse::coarse;
use super::hands::Hands;
use super::lane::Lane;
use crate::rows::{Frame, columns};

/// The columns that a world has a value for; the page draws no curve of another.
const KNOWN: [&str; 7] = [
    "lateness_s",
    "penetration_m",
    "force_on_device_n",
    "stored_energy_j",
    "leak_held_j",
    "tick_duration_s",
    "flags",
];

/// The column of the force on the first device, and of the others with their names behind it.
const FORCE: &str = "force_on_device_n";

/// Returns the greeting for new clients: the world with these devices.
pub fn hello(scene: &WorldScene, devices: &[Capabilities], hands: &Hands, lanes: usize) -> String {
    let further = scene.world.tools.iter().enumerate().skip(1);
    let further = further.map(|(number, tool)| {
        json!({ "name": format!("{FORCE} {}", tool.name), "unit": "N", "device": number })
    });
    let columns: Vec<Value> = columns()
        .map(|column| {
            let is_known = KNOWN.contains(&column.name);
            let unit = if column.unit == "1" { "" } else { column.unit };
            json!({ "name": if is_known { column.name } else { "" }, "unit": unit })
        })
        .chain(further)
        .collect();
    let tools = scene.world.tools.iter().zip(&scene.devices);
    let tools: Vec<Value> = tools
        .map(|(tool, device)| {
            let turning = device.turning.as_ref();
            json!({
                "name": tool.name,
                "shape": shape(&tool.shape),
                "position_m": device.position,
                "turns": turning.is_some(),
                "orientation": turning.map_or([1.0, 0.0, 0.0, 0.0], |turning| turning.orientation),
            })
        })
        .collect();
    let bodies: Vec<Value> = scene
        .world
        .bodies
        .iter()
        .map(|body| {
            json!({
                "name": body.name,
                "shape": shape(&body.shape),
                "fixed": matches!(body.motion, Motion::Fixed),
                "position_m": body.position,
                "orientation": body.orientation,
            })
        })
        .collect();
    let mut each = hands.iter().enumerate().map(|(number, hand)| {
        let device = devices.get(number);
        json!({
            "name": device.map_or("", |device| &device.name),
            "axes": device.map_or(3, |device| device.axes),
            "pointer": hand.is_some(),
            "largest_force_n": device.and_then(|device| device.largest_force),
        })
    });
    let mut first = each.next().unwrap_or_default();
    first["lanes"] = json!(lanes);
    let further: Vec<Value> = each.collect();
    let mut hello = json!({
        "type": "hello",
        "protocol": 1,
        "version": env!("CARGO_PKG_VERSION"),
        "title": scene.title,
        "columns": columns,
        "methods": [],
        "device": first,
        "world": { "tools": tools, "bodies": bodies },
    });
    // A single device has no additional fields.
    if !further.is_empty() {
        hello["further_devices"] = further.into();
    }
    hello.to_string()
}

/// Returns the state message, which is sent after every change.
pub fn state(scene: &WorldScene, lanes: &[Lane], hands: &Hands) -> String {
    let target = |hand: Option<&SpatialHand>| hand.and_then(SpatialHand::target);
    let orientation = |hand: Option<&SpatialHand>| hand.and_then(SpatialHand::orientation);
    let first = hands.iter().next().flatten();
    let further: Vec<Value> = hands
        .iter()
        .skip(1)
        .map(|hand| json!({ "hand_m": target(hand), "hand_orientation": orientation(hand) }))
        .collect();
    let lanes: Vec<Value> = lanes
        .iter()
        .map(|lane| {
            json!({
                "method": lane.method,
                "damping_n_s_per_m": null,
                "running": lane.is_running(),
                "safety_stop": lane.safety_stop(),
                "safety_stop_method": null,
            })
        })
        .collect();
    let mut state = json!({
        "type": "state",
        "period_s": scene.timing.period,
        "lanes": lanes,
        "recording": null,
        "hand_m": target(first),
        "hand_orientation": orientation(first),
    });
    if !further.is_empty() {
        state["further_hands"] = further.into();
    }
    state.to_string()
}

/// Most triangles of a mesh that the page draws, of a larger one fewer and larger triangles: without a GPU more of them
/// take most of its time.
const MAX_TRIANGLES: usize = 20_000;

/// A shape as a scene file has it, and a mesh by triangles.
fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Sphere { radius } => json!({ "sphere": { "radius_m": radius } }),
        Shape::HalfSpace { normal, offset } => {
            json!({ "half_space": { "normal": normal, "offset_m": offset } })
        }
        Shape::Box { half_extents } => {
            json!({ "box": { "size_m": half_extents.map(|half| 2.0 * half) } })
        }
        Shape::Capsule {
            radius,
            half_length,
        } => json!({ "capsule": { "radius_m": radius, "length_m": 2.0 * half_length } }),
        Shape::Cylinder {
            radius,
            half_length,
        } => json!({ "cylinder": { "radius_m": radius, "length_m": 2.0 * half_length } }),
        Shape::Mesh(mesh) => triangles(mesh),
        Shape::Hull(hull) => triangles(hull.mesh()),
        Shape::Spheres { spheres } => {
            let each = spheres
                .iter()
                .map(|sphere| json!({ "centre_m": sphere.centre, "radius_m": sphere.radius }));
            json!({ "spheres": each.collect::<Vec<_>>() })
        }
    }
}

/// The corners of a mesh, one behind the other [m], and each triangle by the numbers of its corners.
fn triangles(mesh: &Mesh) -> Value {
    let (vertices, faces) = coarse(&mesh.vertices(), mesh.faces(), MAX_TRIANGLES);
    let is_coarse = faces.len() < mesh.faces().len();
    json!({ "mesh": { "vertices_m": vertices, "faces": faces, "coarse": is_coarse } })
}

/// The length of a vector.
pub fn length(vector: Vector) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A tick of a world as a row of the charts: the length of the force on the first device, the deepest contact, the sum
/// of what contacts store, and what held forces created.
pub fn row(tick: &Tick, contacts: &[ContactTick]) -> Row {
    let deepest = contacts.iter().map(|contact| contact.penetration);
    let contact = ContactTick {
        force_on_device: length(tick.delivered_force),
        penetration: deepest.fold(0.0, f64::max),
        stored_energy: contacts.iter().map(|contact| contact.stored_energy).sum(),
        held_leak: tick.created_energy,
        ..ContactTick::UNKNOWN
    };
    Row {
        tick: *tick,
        contact,
        ..Row::UNKNOWN
    }
}

/// Kind of a frame that holds a world.
const WORLD: u8 = 2;

/// The newest state of a world, as `docs/reference/live-protocol.md` lays it out, with the `forces` on its devices
/// along the axes of the world.
pub fn frame(
    (lane, run): (u8, u32),
    tick: &Tick,
    (contacts, bodies): (&[ContactTick], &[BodyTick]),
    forces: &[Vector],
) -> Frame {
    let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let mut bytes = vec![WORLD, lane];
    let further = forces.get(1..).unwrap_or_default();
    bytes.extend(
        u16::try_from(further.len())
            .unwrap_or(u16::MAX)
            .to_le_bytes(),
    );
    bytes.extend(count(bodies.len()).to_le_bytes());
    // Position of the frame's number.
    bytes.extend(0_u32.to_le_bytes());
    bytes.extend(run.to_le_bytes());
    bytes.extend(tick.time.to_le_bytes());
    bytes.extend(count(contacts.len()).to_le_bytes());
    let mut put = |value: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "seven digits are shown")]
        let single = value as f32;
        bytes.extend(single.to_le_bytes());
    };
    let first = forces.first().copied().unwrap_or_default();
    first.into_iter().for_each(&mut put);
    for body in bodies {
        put(f64::from(body.body));
        body.position.into_iter().for_each(&mut put);
        body.orientation.into_iter().for_each(&mut put);
    }
    for contact in contacts {
        contact.point.into_iter().for_each(&mut put);
        contact.force.into_iter().for_each(&mut put);
    }
    further.iter().flatten().copied().for_each(&mut put);
    Frame::new(lane, bytes)
}

#[cfg(test)]
mod tests {
    use palpate_world::Hull;

    use super::*;

    #[test]
    fn hull_is_sent_as_surface_triangles() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let messages = shape(&Shape::Hull(Hull::around(&corners).unwrap().into()));
        let numbers = messages["mesh"]["vertices_m"].as_array().unwrap();
        let numbers: Vec<f64> = numbers.iter().map(|x| x.as_f64().unwrap()).collect();
        assert_eq!(numbers.len(), 12);
        for corner in corners {
            assert!(numbers.chunks(3).any(|place| place == corner), "{corner:?}");
        }
        assert_eq!(messages["mesh"]["faces"].as_array().unwrap().len(), 4);
    }

    #[test]
    fn world_frame_length_matches_its_header() {
        let body = BodyTick {
            body: 3,
            position: [1.0, 2.0, 3.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
            ..BodyTick::default()
        };
        let contact = ContactTick {
            point: [4.0, 5.0, 6.0],
            force: [7.0, 8.0, 9.0],
            ..ContactTick::default()
        };
        let tick = Tick {
            time: 0.5,
            ..Tick::default()
        };
        let forces = [[0.25, 0.5, 0.75], [-1.0, -2.0, -3.0]];
        let messages =
            |forces: &[Vector]| frame((1, 7), &tick, (&[contact; 2], &[body]), forces).numbered(5);
        let bytes = messages(&forces[..1]);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let single = |at: usize| f32::from_bits(word(at));
        assert_eq!(bytes[..2], [2, 1]);
        assert_eq!([word(4), word(8), word(12), word(24)], [1, 5, 7, 2]);
        assert_eq!(single(28), 0.25);
        assert_eq!([single(40), single(44)], [3.0, 1.0], "body and its x");
        assert_eq!(single(72), 4.0, "the first contact");
        assert_eq!(bytes.len(), 40 + 32 + 2 * 24);
        assert_eq!(bytes[2..4], [0, 0], "one device");
        // The force on a second device follows all data of the first.
        let of_two = messages(&forces);
        assert_eq!(of_two[2..4], [1, 0]);
        assert_eq!(of_two[4..bytes.len()], bytes[4..]);
        let last = of_two[bytes.len()..].chunks(4);
        let last: Vec<f32> = last
            .map(|single| f32::from_le_bytes(single.try_into().unwrap()))
            .collect();
        assert_eq!(last, [-1.0, -2.0, -3.0]);
    }
}
