//! Random scenes of a sphere tool in a hand, with many randomly chosen contacts.

use super::contact::WorldError;
use super::hand::WorldHand;
use super::ideal::WorldIdeal;
use super::scene::{
    ContactLaw, FreeMotion, Member, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldScene,
};
use super::self_check::CheckedIdeal;
use super::vector::Vec3;
use crate::grid::Grid;
use crate::hand::Sinusoid;
use crate::random::SplitMix64;

/// Type of a random scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WorldKind {
    /// A ball falls on the tool.
    Juggle,
    /// The tool presses on a ball that lies on a floor.
    Floor,
    /// The tool falls into a groove.
    Groove,
    /// The tool is pressed into a corner of three walls.
    Corner,
    /// The tool pushes a row of two balls against a wall.
    Row,
    /// The tool is pressed on a rough floor and pulled along it.
    Slide,
}

impl WorldKind {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Juggle,
        Self::Floor,
        Self::Groove,
        Self::Corner,
        Self::Row,
        Self::Slide,
    ];
}

/// Hands of the tools in random scenes, and the errors of a renderer's model masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RandomHands {
    /// Springs of 60 N/m and 300 N/m in turn, with damping, a push and a tremor. Of every four model masses, two are
    /// 1.5 times and two are 0.67 times the true mass.
    Springs,
    /// A constant push only, so that a device moves freely. Every model mass is 1.5 times the true mass.
    Pushes,
}

/// A random scene with its window and its ideal.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomWorld {
    /// Type of the scene.
    pub kind: WorldKind,
    /// The scene; its sensors have no quantum, set one where it is wanted.
    pub scene: WorldScene,
    /// Stiffness K of the tool's contacts `[N/m]`; the second wall of a groove has another.
    pub stiffness: f64,
    /// Model masses for a renderer, see [`RandomHands`] `[kg]`.
    pub model_mass: Vector,
    /// The ideal over the window.
    pub ideal: WorldIdeal,
}

/// Longest window `[s]`.
const LONGEST: f64 = 0.3;
/// A window ends after this touch.
const TOUCHES: usize = 4;
/// Fewest intervals of a window.
const FEWEST: usize = 6;
/// A scene with a larger mean force is left out `[N]`.
const LARGEST_FORCE: f64 = 200.0;
/// g `[m/s²]`
const GRAVITY: f64 = 9.81;
/// Material damping B over 2 √(K m), m about the tool's mass: so little that a bounce keeps 97 % of its speed.
const DAMPING_RATIO: f64 = 0.01;

/// Creates random scenes for a loop of a period `[s]`; the same seed gives the same scenes.
///
/// The window is at most 0.3 s, ends soon after the fourth touch, and ends before the ideal's motion depends on its
/// numerical solution. Scenes are redrawn if they have no touch, a touch at the start, mean forces above 200 N, or less
/// than half a period of touch.
///
/// # Errors
///
/// A scene has no ideal, see [`WorldIdeal::new`]; or the period is not finite and positive.
pub fn random_worlds(
    hands: RandomHands,
    count: usize,
    period: f64,
    seed: u64,
) -> Result<Vec<RandomWorld>, WorldError> {
    crate::error::positive("period".to_owned(), period, "finite and above 0 s")?;
    let mut numbers = Numbers(SplitMix64::new(seed));
    let mut worlds = Vec::with_capacity(count);
    while worlds.len() < count {
        let hand_stiffness = match hands {
            RandomHands::Springs => Some([60.0, 300.0][worlds.len() % 2]),
            RandomHands::Pushes => None,
        };
        let drawn = draw(&mut numbers, period, hand_stiffness);
        let Some(ideal) = accepted(&drawn.scene, period)? else {
            continue;
        };
        let model = match hands {
            RandomHands::Springs => [1.5, 0.67][worlds.len() / 2 % 2],
            RandomHands::Pushes => 1.5,
        };
        worlds.push(RandomWorld {
            kind: drawn.kind,
            model_mass: drawn.scene.devices[0].mass.map(|mass| model * mass),
            scene: drawn.scene,
            stiffness: drawn.stiffness,
            ideal,
        });
    }
    Ok(worlds)
}

/// The ideal over the scene's window; `None` if the scene is to be drawn again.
fn accepted(scene: &WorldScene, period: f64) -> Result<Option<WorldIdeal>, WorldError> {
    let longest = whole(LONGEST / period).max(12);
    let first = WorldIdeal::new(scene, Grid::even(0.0, period, longest))?;
    let touches = first.touches_of(0);
    if touches.first().is_none_or(|(start, _)| *start <= 0.0) {
        return Ok(None);
    }
    let intervals = match touches.get(TOUCHES - 1).and_then(|(_, end)| *end) {
        Some(end) => longest.min((whole((end / period).ceil()) + 1).max(FEWEST)),
        None => longest,
    };
    let ideal = match CheckedIdeal::new(scene, Grid::even(0.0, period, intervals)) {
        Ok(checked) => checked.ideal,
        Err(WorldError::Chaotic { .. }) => return Ok(None),
        Err(error) => return Err(error),
    };
    let end = ideal.grid.end();
    let touched: f64 = ideal
        .touches_of(0)
        .iter()
        .map(|(start, until)| until.unwrap_or(end) - start)
        .sum();
    let largest = ideal.devices[0]
        .mean_forces(&ideal.grid)
        .iter()
        .flatten()
        .fold(0.0_f64, |largest, force| largest.max(force.abs()));
    let fits =
        ideal.grid.intervals() >= FEWEST && touched >= 0.5 * period && largest <= LARGEST_FORCE;
    Ok(fits.then_some(ideal))
}

fn whole(number: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the range of u32"
    )]
    let whole = (number * (1.0 + 1e-12)).clamp(0.0, f64::from(u32::MAX)) as usize;
    whole
}

struct Numbers(SplitMix64);

impl Numbers {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    /// To both sides of 0.
    fn about_zero(&mut self, reach: f64) -> f64 {
        self.between(-reach, reach)
    }

    fn kind(&mut self) -> WorldKind {
        WorldKind::ALL[whole(6.0 * self.0.unit()).min(5)]
    }
}

struct Drawn {
    kind: WorldKind,
    scene: WorldScene,
    stiffness: f64,
}

/// The parts of a scene under way.
struct Parts {
    push: Vector,
    tool: Vector,
    /// Mass, radius, place and whether it has weight.
    balls: Vec<(f64, f64, Vector, bool)>,
    /// Normal, offset and K.
    walls: Vec<(Vector, f64, f64)>,
    friction: f64,
    bristle: f64,
}

fn draw(numbers: &mut Numbers, period: f64, hand_stiffness: Option<f64>) -> Drawn {
    let mass = numbers.between(0.1, 0.4);
    let stiffness = 10_f64.powf(numbers.between(-1.7, -0.2)) * mass / (period * period);
    let tool_radius = numbers.between(0.004, 0.012);
    let kind = numbers.kind();
    let parts = parts(numbers, kind, mass, stiffness, tool_radius);
    let masses = [(); 3].map(|()| mass * numbers.between(0.7, 1.6));
    let hand = match hand_stiffness {
        Some(stiffness) => hand(numbers, &parts, stiffness),
        None => WorldHand {
            force: parts.push,
            ..WorldHand::default()
        },
    };
    let device = WorldDevice {
        name: "tool".into(),
        own_axes: None,
        mass_table: None,
        drivetrain: crate::world::Drivetrain::default(),
        mass: masses,
        position: parts.tool,
        velocity: [0.0; 3],
        tool: Tool::sphere(tool_radius),
        turning: None,
        hand,
        quantum: [0.0; 3],
    };
    Drawn {
        kind,
        scene: scene(device, &parts, stiffness, mass),
        stiffness,
    }
}

/// Draws the parts of a scene with a tool of a mass `[kg]`, contact stiffness `[N/m]` and radius `[m]`.
fn parts(
    numbers: &mut Numbers,
    kind: WorldKind,
    mass: f64,
    stiffness: f64,
    tool_radius: f64,
) -> Parts {
    let sizes = Sizes {
        mass,
        stiffness,
        tool_radius,
        ball_mass: numbers.between(0.03, 0.4),
        radius: numbers.between(0.015, 0.04),
    };
    let mut parts = Parts {
        push: [0.0; 3],
        tool: [0.0; 3],
        balls: Vec::new(),
        walls: Vec::new(),
        friction: 0.0,
        bristle: stiffness,
    };
    match kind {
        WorldKind::Juggle => parts.juggle(numbers, &sizes),
        WorldKind::Floor => parts.floor(numbers, &sizes),
        WorldKind::Groove => parts.groove(numbers, &sizes),
        WorldKind::Corner => parts.corner(numbers, &sizes),
        WorldKind::Row => parts.row(numbers, &sizes),
        WorldKind::Slide => parts.slide(numbers, &sizes),
    }
    parts
}

/// Sizes of the tool and of the balls in a scene.
struct Sizes {
    /// Mass of the tool `[kg]`.
    mass: f64,
    /// Stiffness K of the tool's contacts `[N/m]`.
    stiffness: f64,
    /// Radius of the tool `[m]`.
    tool_radius: f64,
    /// Mass of the first ball `[kg]`.
    ball_mass: f64,
    /// Radius of the balls `[m]`.
    radius: f64,
}

/// Upward direction.
const UP: Vector = [0.0, 0.0, 1.0];

impl Parts {
    /// Places a ball above the tool.
    fn juggle(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            mass,
            tool_radius,
            ball_mass,
            radius,
            ..
        } = sizes;
        self.push = [0.0, 0.0, mass * numbers.between(2.0, 6.0)];
        let place = [
            numbers.about_zero(0.15 * radius),
            numbers.about_zero(0.15 * radius),
            radius + tool_radius + numbers.between(0.01, 0.03),
        ];
        self.balls = vec![(ball_mass, radius, place, true)];
    }

    /// Places a ball on a floor, below the tool.
    fn floor(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            mass,
            stiffness,
            tool_radius,
            ball_mass,
            radius,
        } = sizes;
        let floor = stiffness * numbers.between(1.0, 4.0);
        self.push = [
            numbers.about_zero(0.2),
            numbers.about_zero(0.2),
            -mass * numbers.between(2.0, 6.0),
        ];
        let sunk = ball_mass * GRAVITY / floor;
        self.balls = vec![(ball_mass, radius, [0.0, 0.0, radius - sunk], true)];
        self.walls = vec![(UP, 0.0, floor)];
        self.tool = [
            numbers.about_zero(0.2 * radius),
            numbers.about_zero(0.2 * radius),
            2.0 * radius + tool_radius + numbers.between(0.005, 0.02),
        ];
    }

    /// Places the tool above a groove of two walls.
    fn groove(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            mass,
            stiffness,
            tool_radius,
            ..
        } = sizes;
        let slope = numbers.between(25.0, 65.0).to_radians();
        let (sine, cosine) = slope.sin_cos();
        self.push = [
            numbers.about_zero(0.5),
            numbers.about_zero(0.3),
            -mass * numbers.between(3.0, 8.0),
        ];
        let other = stiffness * numbers.between(0.5, 2.0);
        self.walls = vec![
            ([sine, 0.0, cosine], 0.0, stiffness),
            ([-sine, 0.0, cosine], 0.0, other),
        ];
        let height = tool_radius / cosine + numbers.between(0.01, 0.03);
        self.tool = [numbers.about_zero(0.01), 0.0, height];
    }

    /// Places the tool in front of a corner of three walls.
    fn corner(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            stiffness,
            tool_radius,
            ..
        } = sizes;
        self.push = [
            -numbers.between(0.5, 1.5),
            -numbers.between(0.5, 1.5),
            -numbers.between(0.5, 2.0),
        ];
        self.walls = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], UP]
            .map(|normal| (normal, 0.0, stiffness))
            .to_vec();
        self.tool = [(); 3].map(|()| tool_radius + numbers.between(0.005, 0.02));
    }

    /// Places a row of two balls between the tool and a wall.
    fn row(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            mass,
            stiffness,
            tool_radius,
            ball_mass,
            radius,
        } = sizes;
        self.push = [mass * numbers.between(2.0, 6.0), 0.0, 0.0];
        let gap = numbers.between(0.005, 0.02);
        let off = 0.05 * radius;
        let first = [radius + tool_radius + gap, numbers.about_zero(off), 0.0];
        let second = [
            3.0 * radius + tool_radius + 0.03,
            numbers.about_zero(off),
            numbers.about_zero(off),
        ];
        self.balls = vec![
            (ball_mass, radius, first, false),
            (numbers.between(0.03, 0.4), radius, second, false),
        ];
        let wall = -(5.0 * radius + tool_radius + 0.06);
        self.walls = vec![([-1.0, 0.0, 0.0], wall, stiffness)];
    }

    /// Places the tool above a rough floor.
    fn slide(&mut self, numbers: &mut Numbers, sizes: &Sizes) {
        let &Sizes {
            mass,
            stiffness,
            tool_radius,
            ..
        } = sizes;
        self.push = [
            numbers.about_zero(1.0),
            numbers.about_zero(1.0),
            -mass * numbers.between(3.0, 8.0),
        ];
        self.walls = vec![(UP, 0.0, stiffness)];
        self.tool = [0.0, 0.0, tool_radius + numbers.between(0.003, 0.015)];
        self.friction = numbers.between(0.1, 0.8);
        self.bristle = stiffness * numbers.between(0.5, 1.0);
    }
}

/// A hand whose spring is stretched by 8 mm at the start, along its push.
fn hand(numbers: &mut Numbers, parts: &Parts, stiffness: f64) -> WorldHand {
    let ahead = Vec3(parts.push).direction().unwrap_or(Vec3::ZERO) * 0.008;
    let damping = numbers.between(1.5, 5.0);
    let tremor = [(); 3].map(|()| {
        let first = Sinusoid {
            amplitude: 0.1 * numbers.between(0.5, 1.5),
            frequency_hz: numbers.between(8.0, 12.0),
            phase: numbers.about_zero(3.0),
        };
        let second = Sinusoid {
            amplitude: 0.4 * first.amplitude,
            frequency_hz: 1.7 * first.frequency_hz,
            phase: numbers.about_zero(3.0),
        };
        vec![first, second]
    });
    WorldHand {
        force: parts.push,
        stiffness,
        damping,
        rest: (Vec3(parts.tool) + ahead).0,
        tremor,
        ..WorldHand::default()
    }
}

fn scene(device: WorldDevice, parts: &Parts, stiffness: f64, mass: f64) -> WorldScene {
    let law = |stiffness: f64| {
        ContactLaw::spring(stiffness).damped(2.0 * DAMPING_RATIO * (stiffness * mass).sqrt())
    };
    let body = |name: String, shape: Shape| WorldBody {
        name,
        shape,
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        motion: None,
    };
    let mut bodies = Vec::new();
    for (number, &(mass, radius, position, has_weight)) in parts.balls.iter().enumerate() {
        let shape = Shape::Sphere { radius };
        let weight = if has_weight { mass * GRAVITY } else { 0.0 };
        bodies.push(WorldBody {
            position,
            motion: Some(FreeMotion::new(&shape, mass).pulled_by([0.0, 0.0, -weight])),
            ..body(format!("ball-{}", number + 1), shape)
        });
    }
    for (number, &(normal, offset, _)) in parts.walls.iter().enumerate() {
        let shape = Shape::HalfSpace { normal, offset };
        bodies.push(body(format!("wall-{}", number + 1), shape));
    }
    let spheres: Vec<Member> = [Member::Device(0)]
        .into_iter()
        .chain((0..parts.balls.len()).map(Member::Body))
        .collect();
    let mut pairs = Vec::new();
    for (number, &one) in spheres.iter().enumerate() {
        for &other in &spheres[number + 1..] {
            pairs.push(Pair {
                between: [one, other],
                law: law(stiffness),
            });
        }
        for (wall, &(_, _, of_wall)) in parts.walls.iter().enumerate() {
            let law = law(of_wall);
            pairs.push(Pair {
                between: [one, Member::Body(parts.balls.len() + wall)],
                law: if number == 0 && parts.friction > 0.0 {
                    law.rough(parts.friction, parts.bristle)
                } else {
                    law
                },
            });
        }
    }
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device],
        bodies,
        pairs,
    }
}
