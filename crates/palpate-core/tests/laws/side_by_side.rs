//! Several contacts on one device, each along its own axis: guarantees and limitations.

use palpate_core::{
    AlongAxis, Contact, Coupled, CoupledParams, LoopParams, ObjectState, Renderer, Sample, State,
};

type Method = Renderer<f64, Coupled<f64>>;
type Memory = State<f64, palpate_core::CoupledMemory<f64>>;

const DEVICE_MASS: f64 = 0.25;

/// A contact in space.
struct Placed {
    axis: AlongAxis<f64, 3>,
    renderer: Method,
    state: Memory,
    virtual_force: f64,
}

impl Placed {
    fn new(contact: Contact<f64>, period: f64, origin: [f64; 3], normal: [f64; 3]) -> Self {
        let device = CoupledParams::new(DEVICE_MASS);
        let renderer = Renderer::new(contact, LoopParams::new(period), device).unwrap();
        Self {
            axis: AlongAxis::new(origin, normal).unwrap(),
            state: renderer.start(ObjectState::at_rest(0.0)).unwrap(),
            renderer,
            virtual_force: 0.0,
        }
    }

    /// A wall of `stiffness` `[N/m]` through the origin, solid along `normal`.
    fn wall(stiffness: f64, period: f64, normal: [f64; 3]) -> Self {
        Self::new(
            Contact::object(stiffness, f64::INFINITY),
            period,
            [0.0; 3],
            normal,
        )
    }

    /// Returns the force on the device at `position` `[N]`, and the object's position along the axis `[m]`.
    fn force(&mut self, position: [f64; 3]) -> ([f64; 3], f64) {
        let sample =
            Sample::at(self.axis.coordinate(position)).with_virtual_force(self.virtual_force);
        let output = self.renderer.step(&mut self.state, sample);
        (
            self.axis.vector(output.force_on_device),
            output.object_position,
        )
    }
}

/// A point of [`DEVICE_MASS`] under held forces.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    position: [f64; 3],
    velocity: [f64; 3],
}

impl Point {
    fn advance(&mut self, force: [f64; 3], duration: f64) {
        for ((x, v), f) in self.position.iter_mut().zip(&mut self.velocity).zip(force) {
            let a = f / DEVICE_MASS;
            *x += *v * duration + 0.5 * a * duration * duration;
            *v += a * duration;
        }
    }

    fn energy(&self) -> f64 {
        0.5 * DEVICE_MASS * self.velocity.iter().map(|v| v * v).sum::<f64>()
    }
}

/// Runs one period of a loop with several contacts, whose forces are added.
fn tick(device: &mut Point, contacts: &mut [Placed], period: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for contact in contacts {
        for (total, part) in sum.iter_mut().zip(contact.force(device.position).0) {
            *total += part;
        }
    }
    device.advance(sum, period);
    sum
}

const PERIOD: f64 = 0.001;

/// Surface at z = 0, solid below it: the normal points down, into the solid.
fn floor() -> Placed {
    Placed::wall(2000.0, PERIOD, [0.0, 0.0, -1.0])
}

/// A block of 0.1 kg on the floor with its face at x = 50 mm, pushed along +x.
fn block() -> Placed {
    Placed::new(
        Contact::object(800.0, 0.1),
        PERIOD,
        [0.05, 0.0, 0.0],
        [1.0, 0.0, 0.0],
    )
}

#[test]
fn a_floor_pushes_up_below_its_surface_and_not_at_all_above_it() {
    let mut floor = floor();
    let mut held_at = |z: f64| {
        let last = (0..500).map(|_| floor.force([0.3, -0.2, z]).0).last();
        last.unwrap()
    };
    for z in [0.25, 0.1, 0.001] {
        assert_eq!(held_at(z), [0.0; 3], "at z = {z} m");
    }
    let force = held_at(-0.002);
    println!("2 mm below a floor of 2000 N/m: {force:?} N");
    assert_eq!((force[0], force[1]), (0.0, 0.0));
    // Coupled rendering shifts the wall slightly during contact, and returns it.
    assert!((force[2] - 4.0).abs() < 0.05, "{force:?}");
}

#[test]
fn contacts_at_right_angles_are_each_as_if_alone() {
    let start = Point {
        position: [0.02, 0.0, 0.01],
        velocity: [0.3, 0.0, -0.2],
    };
    let along = |axis: usize| Point {
        position: [0, 1, 2].map(|i| if i == axis { start.position[i] } else { 0.01 }),
        velocity: [0, 1, 2].map(|i| if i == axis { start.velocity[i] } else { 0.0 }),
    };
    let (mut both, mut on_floor, mut at_block) = (start, along(2), along(0));
    let mut contacts = [floor(), block()];
    let (mut alone_floor, mut alone_block) = ([floor()], [block()]);
    let (mut pushed_up, mut pushed_back) = (0.0_f64, 0.0_f64);
    for _ in 0..600 {
        let force = tick(&mut both, &mut contacts, PERIOD);
        let up = tick(&mut on_floor, &mut alone_floor, PERIOD);
        let back = tick(&mut at_block, &mut alone_block, PERIOD);
        assert_eq!((force[2], force[0]), (up[2], back[0]));
        (pushed_up, pushed_back) = (pushed_up.max(force[2]), pushed_back.min(force[0]));
    }
    println!("up to {pushed_up:.2} N up from the floor, {pushed_back:.2} N back from the block");
    assert!(pushed_up > 1.0 && pushed_back < -1.0);
    // The device has left the floor at its initial speed, and the block has the momentum that the device lost.
    assert!((both.velocity[2] - 0.2).abs() < 1e-3, "{both:?}");
    let (_, before) = contacts[1].force(both.position);
    both.advance([0.0; 3], PERIOD);
    let (_, after) = contacts[1].force(both.position);
    let block_speed = (after - before) / PERIOD;
    let momentum = DEVICE_MASS * both.velocity[0] + 0.1 * block_speed;
    assert!((momentum - DEVICE_MASS * 0.3).abs() < 1e-6, "{momentum}");
}

/// Returns the energy with which a device leaves `contacts`, relative to its energy on arrival straight down at 0.3
/// m/s.
fn bounce(contacts: &mut [Placed], period: f64) -> f64 {
    let mut device = Point {
        position: [0.0, 0.0, 0.0071],
        velocity: [0.0, 0.0, -0.3],
    };
    let before = device.energy();
    for _ in 0..2000 {
        let force = tick(&mut device, contacts, period);
        if device.velocity[2] > 0.0 && force == [0.0; 3] {
            break;
        }
    }
    device.energy() / before
}

/// Returns the same for a groove of two walls whose normals are `degrees` apart.
fn out_of_a_groove(degrees: f64, stiffness: f64, period: f64) -> f64 {
    let (sin, cos) = (0.5 * degrees).to_radians().sin_cos();
    let wall = |sign: f64| Placed::wall(stiffness, period, [sign * sin, 0.0, -cos]);
    bounce(&mut [wall(1.0), wall(-1.0)], period)
}

#[test]
fn contacts_that_share_an_axis_do_not_know_of_each_other() {
    let loops = [(2000.0, 0.001), (1000.0, 0.01)];
    println!("angle between the normals of two walls; energy after a bounce over energy before,");
    println!("each wall at kappa 0.008 and 0.4");
    let row = |degrees: f64| loops.map(|(k, period)| out_of_a_groove(degrees, k, period));
    let mut rows = Vec::new();
    for degrees in [90.0, 60.0, 30.0, 0.0] {
        let [easy, hard] = row(degrees);
        println!("{degrees:>5}  {easy:.3}  {hard:.3}");
        rows.push((easy, hard));
    }
    let one = loops.map(|(k, period)| {
        bounce(
            &mut [Placed::wall(2.0 * k, period, [0.0, 0.0, -1.0])],
            period,
        )
    });
    println!("one wall of both stiffnesses  {:.3}  {:.3}", one[0], one[1]);
    // No energy is generated at any angle; in a loop that is slow for the wall, shared contact loses energy.
    assert!(
        rows.iter()
            .all(|&(easy, hard)| easy < 1.0 + 1e-3 && hard < 1.0 + 1e-3)
    );
    assert!(rows.iter().all(|&(easy, _)| easy > 0.99));
    assert!(
        rows.windows(2).all(|pair| pair[1].1 < pair[0].1),
        "{rows:?}"
    );
    let (_, parallel) = rows[3];
    assert!((one[1] - 1.0).abs() < (parallel - 1.0).abs(), "{one:?}");
}
