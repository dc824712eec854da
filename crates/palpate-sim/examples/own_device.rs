//! A device of one's own on the bench: a mass on a spring that pulls it home, as of a joystick.
//!
//! Anything that implements [`Device`] can stand where the point mass does. The bench integrates
//! the work through the port by itself, which checks the renderer's books from outside.
//!
//! `cargo run -p palpate-sim --example own_device`

#![allow(clippy::print_stdout)] // an example prints what it found

use palpate::{Contact, HfcrParams, LoopParams, ObjectState, Renderer, Sample};
use palpate_testbed::device::Device;

/// m x'' = hand - c x - f, solved exactly under a held force.
struct Joystick {
    mass: f64,
    centring_stiffness: f64,
    hand_force: f64,
    position: f64,
    velocity: f64,
}

impl Device for Joystick {
    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.velocity
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let rest = (self.hand_force - force_on_object) / self.centring_stiffness;
        let omega = (self.centring_stiffness / self.mass).sqrt();
        let (sin, cos) = (omega * duration).sin_cos();
        let (away, before) = (self.position - rest, self.position);
        self.position = rest + away * cos + self.velocity / omega * sin;
        self.velocity = self.velocity * cos - away * omega * sin;
        // The force is held, so its work needs no integral.
        force_on_object * (self.position - before)
    }

    fn stored_energy(&self) -> f64 {
        0.5 * (self.mass * self.velocity.powi(2) + self.centring_stiffness * self.position.powi(2))
            - self.hand_force * self.position
    }
}

fn main() -> Result<(), palpate::ParameterError> {
    let period = 0.005;
    let mut joystick = Joystick {
        mass: 0.2,
        centring_stiffness: 20.0,
        hand_force: 1.5,
        position: 0.0,
        velocity: 0.0,
    };
    let energy_before = joystick.stored_energy();
    let renderer = Renderer::new(
        Contact::object(800.0, 0.3),
        LoopParams::new(period),
        HfcrParams::default(),
    )?;
    let mut state = renderer.start(ObjectState::at_rest(0.03))?;
    let mut work_through_port = 0.0;
    for _ in 0..400 {
        let output = renderer.step(&mut state, Sample::at(joystick.position()));
        work_through_port += joystick.advance(output.force_on_object, period);
    }
    // One more sample closes the last interval.
    let output = renderer.step(&mut state, Sample::at(joystick.position()));
    let ledger = state.ledger();
    println!(
        "joystick at {:.1} mm, object at {:.1} mm moving at {:.2} m/s",
        1e3 * joystick.position(),
        1e3 * output.object_position,
        output.object_velocity,
    );
    println!(
        "work through the port: {:.6} J by the bench, {:.6} J in the renderer's books",
        work_through_port, ledger.port_work,
    );
    println!(
        "the joystick lost {:.6} J, the object stores {:.6} J, sampling created {:.6} J",
        energy_before - joystick.stored_energy(),
        ledger.stored,
        ledger.held_leak.accumulated,
    );
    Ok(())
}
