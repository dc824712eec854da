//! God-object: a massless proxy on the surface, coupled to its device by a spring and a damper.
//!
//! Zilles and Salisbury, "A constraint-based god-object method for haptic display", IROS 1995; Ruspini, Kolarov and
//! Khatib, SIGGRAPH 1997, for a proxy with a radius.

use palpate_core::Range;

use super::god_object_proxy::{Constraint, Proxy, limit_slip, nearest_allowed};
use crate::contact::pairs::Point;
use crate::contact::point::Held;
use crate::dynamics::moving_body::Drive;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::geometry::solid::Solid;
use crate::integration::interval::{Reach, advance};
use crate::method::state::{Progress, show_contacts};
use crate::{
    Effort, Shape, Tool, Vector, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer,
};

/// Parameters of god-object rendering.
///
/// At a sample the proxy of a tool moves to the point outside all solids that is nearest to the device, unless
/// friction holds it back. A spring and a damper between the two give the force on the device. The opposite force is
/// held on the touched bodies until the next sample. The contacts of tools have no stiffness of their own in this
/// method.
///
/// The proxy of a device that lacks an axis may leave the device's plane, as if the device had that axis. The spring
/// represents the contact stiffness; only the force along the device's axes is commanded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GodObjectParams {
    /// Stiffness of each tool's spring, above 0 `[N/m]`. Use the contact stiffness for a wall of equal stiffness.
    pub stiffness: Vec<f64>,
    /// Damping of each tool's damper, at least 0 `[N s/m]`. It acts while the tool touches something.
    pub damping: Vec<f64>,
}

impl GodObjectParams {
    /// Checks whether god-object rendering supports this tool.
    ///
    /// # Errors
    /// The tool turns, or its shape is not a sphere, a point or a set of spheres.
    pub fn can_render(tool: &Tool) -> Result<(), WorldError> {
        let is_made_of_spheres = matches!(tool.shape, Shape::Sphere { .. } | Shape::Spheres { .. });
        if is_made_of_spheres && !tool.turns {
            return Ok(());
        }
        let why = if tool.turns {
            "turns"
        } else {
            "has another shape"
        };
        Err(WorldError::new(
            WorldPart::Method,
            WorldField::Method,
            "the method",
            format!(
                "god-object renders tools that are a sphere, a point or several spheres and do not turn; {:?} {why}",
                tool.name
            ),
        ))
    }

    pub(super) fn check(self, tools: &[Tool]) -> Result<GodObject, WorldErrors> {
        let mut faults = Vec::new();
        for (field, list, range) in [
            (WorldField::Stiffness, &self.stiffness, Range::Positive),
            (WorldField::Damping, &self.damping, Range::NotNegative),
        ] {
            let mut fault = |message: String| {
                faults.push(WorldError::new(
                    WorldPart::Method,
                    field,
                    "the method",
                    message,
                ));
            };
            if list.len() != tools.len() {
                let (given, tools) = (list.len(), tools.len());
                fault(format!(
                    "{field} has {given} entries for {tools} tools; give one for each"
                ));
            }
            let wrong = list
                .iter()
                .filter_map(|value| out_of_range(field, *value, range));
            wrong.for_each(&mut fault);
        }
        faults.extend(tools.iter().filter_map(|tool| Self::can_render(tool).err()));
        WorldErrors::check(faults)?;
        let couplings = self.stiffness.into_iter().zip(self.damping);
        Ok(GodObject {
            couplings: couplings
                .map(|(stiffness, damping)| Coupling { stiffness, damping })
                .collect(),
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Coupling {
    stiffness: f64,
    damping: f64,
}

/// God-object rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct GodObject {
    couplings: Vec<Coupling>,
}

/// State of god-object rendering.
#[derive(Clone, Debug)]
pub(crate) struct GodObjectMemory {
    devices: Vec<LastSample>,
    /// Latest constraint on the proxy of each contact point.
    constraints: Vec<Constraint>,
    /// Friction anchor of each point that pressed at the last sample: proxy position in the axes of the touched body
    /// `[m]`, and the point's share of the friction.
    anchors: Vec<Option<(Vector3, f64)>>,
}

/// State of a device at the last sample, and the coupling force on its tool.
#[derive(Clone, Copy, Debug)]
struct LastSample {
    position: Vector3,
    velocity: Vector3,
    force: Vector3,
}

impl GodObjectMemory {
    pub fn new(tools: usize, points: usize) -> Self {
        let none = Vector3::zeros();
        let device = LastSample {
            position: none,
            velocity: none,
            force: none,
        };
        Self {
            devices: vec![device; tools],
            constraints: vec![Constraint::none(); points],
            anchors: vec![None; points],
        }
    }

    /// Continues from another world. `points` maps this world's contact points to the previous indices.
    pub fn goes_on_from(&mut self, before: &Self, points: &[Option<usize>]) {
        self.devices.copy_from_slice(&before.devices);
        let own = self.constraints.iter_mut().zip(&mut self.anchors);
        for ((constraint, anchor), was) in own.zip(points) {
            *constraint = was.map_or_else(Constraint::none, |was| before.constraints[was]);
            *anchor = was.and_then(|was| before.anchors[was]);
        }
    }

    /// Writes the estimated state of the tools.
    pub fn publish(&self, state: &mut Progress) {
        let parts = self.devices.iter().zip(&state.now.parts);
        for (tool, (device, part)) in state.tools.iter_mut().zip(parts) {
            tool.position = device.position.into();
            tool.velocity = device.velocity.into();
            tool.proxy_position = part.rigid.position.into();
            tool.proxy_velocity = tool.velocity;
            tool.offset = (part.rigid.position - device.position).into();
        }
    }
}

impl GodObject {
    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut GodObjectMemory,
        positions: &[Vector],
    ) {
        memory.anchors.fill(None);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            device.position = Vector3::from(positions[tool]);
            device.velocity = Vector3::zeros();
            let part = &mut state.now.parts[tool];
            part.rigid.position = device.position;
            part.rigid.velocity = Vector3::zeros();
            part.drive = Drive::constant(Vector3::zeros());
        }
        state.now.begin();
        for tool in 0..renderer.tools {
            self.press(renderer, state, memory, tool, None);
        }
        state.now.look(&renderer.points);
        state.ledger.observe(&state.now, &renderer.points);
    }

    pub fn conclude(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut GodObjectMemory,
        positions: &[Vector],
        elapsed: f64,
    ) -> Effort {
        let points = &renderer.points;
        state.now.begin();
        let sub_steps = &renderer.loop_params.sub_steps;
        let effort = advance(
            &mut state.now,
            &mut state.room,
            points,
            sub_steps,
            Reach::All,
            elapsed,
        );
        state.ledger.pass(&state.now, points, renderer.tools);
        for (tool, position) in positions.iter().enumerate().take(renderer.tools) {
            let device = &mut memory.devices[tool];
            let way = Vector3::from(*position) - device.position;
            let axes = renderer.axes[tool];
            device.position += way;
            device.velocity = way / elapsed;
            let entry = &mut state.ledger.devices[tool];
            for (number, point) in points[..renderer.tool_points].iter().enumerate() {
                if point.first == tool {
                    let force = state.now.touches[number].force;
                    let held = force.dot(&way);
                    entry.carried += axes.across(&force).dot(&way);
                    state.ledger.contacts[number].held += held;
                    entry.held += held;
                }
            }
            entry.port_work += state.commands.passed(tool).sent.dot(&way);
            entry.unforeseen = entry.port_work + entry.carried - entry.held;
            self.press(renderer, state, memory, tool, Some(elapsed));
        }
        state.now.begin();
        state.now.look(points);
        effort
    }

    pub fn plan(&self, state: &mut Progress, memory: &GodObjectMemory) -> Effort {
        show_contacts(&mut state.contacts, &mut state.shown, &state.now);
        for (intended, device) in state.intended.iter_mut().zip(&memory.devices) {
            *intended = state.commands.for_force(&device.force);
        }
        Effort::default()
    }

    /// Places a tool's proxy and sets the forces that its contacts hold until the next sample. `elapsed` is the time
    /// since the last sample `[s]`, `None` at the first.
    fn press(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut GodObjectMemory,
        tool: usize,
        elapsed: Option<f64>,
    ) {
        let points = &renderer.points;
        let Coupling { stiffness, damping } = self.couplings[tool];
        let before = state.now.parts[tool].rigid.position;
        let device = memory.devices[tool];
        let anchor = friction_anchor(points, state, memory, tool);
        let start = anchor.unwrap_or(before);
        let parts = &mut state.now;
        let proxy = nearest_allowed(
            &device.position,
            start,
            &mut memory.constraints,
            |number| points[number].first == tool,
            |number, place| seen(parts, &points[number], *place),
        );
        let (mut holds, mut normals) = (0.0, 0.0);
        for (point, constraint) in points.iter().zip(&memory.constraints) {
            if point.first == tool {
                holds += point.law.friction * constraint.push;
                normals += constraint.push;
            }
        }
        let wanted = anchor.map_or(Vector3::zeros(), |anchor| anchor - proxy);
        let of_tool = points
            .iter()
            .zip(&memory.constraints)
            .filter_map(|(point, constraint)| (point.first == tool).then_some(constraint));
        let Proxy { stays, slipped } = limit_slip(&wanted, of_tool, holds);
        let place = proxy + stays;
        let step = place - before;
        let damper = elapsed.map_or(Vector3::zeros(), |elapsed| {
            (step / elapsed - device.velocity) * damping
        });
        state.now.parts[tool].rigid.position = place;
        let pressed = Pressed {
            tool,
            place,
            step,
            stays,
            slipped,
            holds,
            normals,
            stiffness,
            damper,
        };
        memory.devices[tool].force = pressed.hold_contacts(points, state, memory);
    }
}

/// Returns the friction anchor of a tool: the mean of the positions to which its contacts have carried the proxy `[m]`.
#[inline]
fn friction_anchor(
    points: &[Point],
    state: &Progress,
    memory: &GodObjectMemory,
    tool: usize,
) -> Option<Vector3> {
    let (mut anchor, mut all) = (Vector3::zeros(), 0.0);
    for (point, held) in points.iter().zip(&memory.anchors) {
        if let Some((place, share)) = held
            && point.first == tool
        {
            let body = &state.now.parts[point.second].rigid;
            anchor += (body.position + body.orientation * place) * *share;
            all += share;
        }
    }
    (all > 0.0).then(|| anchor / all)
}

/// A tool's proxy at a sample, pressed against its contacts.
struct Pressed {
    tool: usize,
    /// Position of the proxy `[m]`.
    place: Vector3,
    /// Displacement of the proxy since the last sample `[m]`.
    step: Vector3,
    /// Displacement of the proxy from the nearest allowed position `[m]`.
    stays: Vector3,
    /// Slip `[m]`.
    slipped: f64,
    /// Displacement up to which friction holds the proxy `[m]`.
    holds: f64,
    /// Sum of the pushes of all constraints `[m]`.
    normals: f64,
    /// Stiffness of the spring `[N/m]`.
    stiffness: f64,
    /// Force of the damper `[N]`.
    damper: Vector3,
}

impl Pressed {
    /// Sets the forces that the contacts hold until the next sample, and adds their energies. Returns their sum `[N]`.
    #[inline]
    fn hold_contacts(
        &self,
        points: &[Point],
        state: &mut Progress,
        memory: &mut GodObjectMemory,
    ) -> Vector3 {
        let &Self {
            tool,
            place,
            step,
            stays,
            slipped,
            holds,
            normals,
            stiffness,
            damper,
        } = self;
        let mut sum = Vector3::zeros();
        let of_tools = memory.constraints.len();
        for (number, point) in points.iter().enumerate().take(of_tools) {
            if point.first != tool {
                continue;
            }
            let touch = &mut state.now.touches[number];
            let constraint = &memory.constraints[number];
            let entry = &mut state.ledger.contacts[number];
            // The proxy moves under the held force; the contact stores no energy.
            let work = touch.force.dot(&step);
            let part = if holds > 0.0 {
                point.law.friction * constraint.push / holds
            } else {
                0.0
            };
            let lost = stiffness * stays.norm() * slipped * part;
            entry.work += work;
            entry.work_on_proxy += work;
            entry.dissipated += lost;
            entry.observed += work + lost;
            if constraint.push <= 0.0 {
                touch.disable_output();
                memory.anchors[number] = None;
                continue;
            }
            let normal = constraint.normal;
            let force = (normal * constraint.push + stays * part) * stiffness
                + damper * (constraint.push / normals);
            sum += force;
            let centre = point.centre_of(&state.now.parts[tool].rigid);
            touch.hold(Held {
                place: centre - normal * point.radius,
                normal,
                normal_force: stiffness * constraint.push,
                force,
                slides: slipped > 0.0 && part > 0.0,
            });
            let body = &state.now.parts[point.second].rigid;
            let own = body
                .orientation
                .inverse_transform_vector(&(place - body.position));
            let share = if holds > 0.0 { part } else { constraint.push };
            memory.anchors[number] = (share > 0.0).then_some((own, share));
        }
        sum
    }
}

/// Returns the distance and normal of a contact point, with the tool at `place` `[m]`, or `None` if no surface is
/// near.
fn seen(
    moving: &mut crate::integration::moving::Moving,
    point: &Point,
    place: Vector3,
) -> Option<(f64, Vector3)> {
    let mut first = moving.parts[point.first].rigid;
    first.position = place;
    let second = moving.parts[point.second].rigid;
    match &point.solid {
        &Solid::Mesh {
            surface, point: of, ..
        } => {
            if of == 0 {
                moving.surfaces[surface].look(&first, &second);
            }
            let found = moving.surfaces[surface].found(of)?;
            let normal = second.orientation * found.normal;
            Some((found.distance - point.radius, normal))
        }
        solid => {
            let nearest = solid.nearest(&second, &point.centre_of(&first));
            Some((nearest.distance - point.radius, nearest.normal))
        }
    }
}
