//! A renderer fed sample by sample, for claims about single intervals.

use palpate_core::{
    AnyMemory, AnyParams, AnyRenderer, Contact, Ledger, LoopParams, ObjectState, Output, Renderer,
    Sample, State,
};

use crate::common::Random;

/// A loop that believes any speed: trials jump at will.
pub fn loop_params(period: f64) -> LoopParams<f64> {
    LoopParams {
        speed_limit: None,
        ..LoopParams::new(period)
    }
}

/// One renderer on its way through a motion that it cannot influence.
pub struct Trial {
    renderer: AnyRenderer<f64>,
    state: State<f64, AnyMemory<f64>>,
    virtual_force: f64,
}

impl Trial {
    pub fn new(case: &Case, params: AnyParams<f64>) -> Self {
        let renderer =
            Renderer::new(case.contact(), loop_params(case.period), params).expect("valid");
        let state = renderer.start(case.object).expect("finite");
        Self {
            renderer,
            state,
            virtual_force: case.virtual_force,
        }
    }

    /// The answer to the next sample.
    pub fn at(&mut self, device: f64) -> Output<f64> {
        let sample = Sample::at(device).with_virtual_force(self.virtual_force);
        let output = self.renderer.step(&mut self.state, sample);
        assert_eq!(output.fault, None);
        output
    }

    /// Returns the output for the next sample, without taking it.
    pub fn peek(&self, device: f64) -> (Output<f64>, Ledger<f64>) {
        let mut state = self.state;
        let sample = Sample::at(device).with_virtual_force(self.virtual_force);
        let output = self.renderer.step(&mut state, sample);
        (output, *state.ledger())
    }

    pub fn ledger(&self) -> &Ledger<f64> {
        self.state.ledger()
    }
}

/// A contact, and an object somewhere near the origin.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub stiffness: f64,
    /// Infinite for a wall.
    pub mass: f64,
    pub period: f64,
    pub virtual_force: f64,
    pub object: ObjectState<f64>,
}

impl Case {
    /// Periods of 0.1 to 100 ms, K T^2/M from 1e-4 to 100 or a wall, millimetres per period.
    pub fn random(random: &mut Random) -> Self {
        let period = random.decades(1e-4, 0.1);
        let stiffness = random.decades(10.0, 1e5);
        let wall = random.once_in(8);
        let mass = if wall {
            f64::INFINITY
        } else {
            stiffness * period * period / random.decades(1e-4, 100.0)
        };
        Self {
            stiffness,
            mass,
            period,
            // Moves the object by up to a millimetre per period.
            virtual_force: if wall {
                random.between(-1.0, 1.0)
            } else {
                random.between(-1e-3, 1e-3) * mass / (period * period)
            },
            object: ObjectState {
                position: random.between(-1e-3, 1e-3),
                velocity: if wall {
                    0.0
                } else {
                    random.between(-2e-3, 2e-3) / period
                },
            },
        }
    }

    pub fn contact(&self) -> Contact<f64> {
        Contact::object(self.stiffness, self.mass)
    }

    /// Stored energy of Eq. (8) with the work of f_V in it: kinetic, elastic, and -f_V eta. A
    /// wall has only the elastic part.
    pub fn stored(&self, device: f64, object: ObjectState<f64>) -> f64 {
        let pressed = (device - object.position).max(0.0);
        let elastic = 0.5 * self.stiffness * pressed * pressed;
        if self.mass.is_finite() {
            elastic + 0.5 * self.mass * object.velocity * object.velocity
                - self.virtual_force * object.position
        } else {
            elastic
        }
    }
}

/// The object as an answer shows it.
pub fn object(output: &Output<f64>) -> ObjectState<f64> {
    ObjectState {
        position: output.object_position,
        velocity: output.object_velocity,
    }
}
