//! One tick of the knob.

use palpate::{
    Actuation, Contact, LoopParams, MethodParams, ObjectState, ParameterError, Phase, Renderer,
    Sample, State,
};

use crate::{Drive, Sensor};

/// Behaviour of the loop if its host is silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhenSilent {
    /// The loop continues: the knob needs no host.
    GoOn,
    /// The loop disables its output after this many ticks without a message, and until the host has sent one.
    DisableOutput {
        /// Ticks without a message.
        after: u32,
    },
}

/// Parameters of a knob.
#[derive(Clone, Copy, Debug)]
pub struct KnobParams {
    /// Period of the loop `[s]`.
    pub period: f32,
    /// Displacement of the rim per count of the sensor `[m]`.
    pub metres_per_count: f32,
    /// Position of the wall's surface `[m]`.
    pub wall_at: f32,
    /// Stiffness of the wall `[N/m]`.
    pub stiffness: f32,
    /// Largest plausible speed of the rim `[m/s]`.
    pub speed_limit: f32,
    /// Duration of the soft start `[s]`, greater than 0.
    pub soft_start: f32,
    /// The motor driver.
    pub drive: Drive,
    /// Behaviour if the host is silent.
    pub when_silent: WhenSilent,
}

/// Status of the force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No force: the rim has not been free since the start, or since the output was disabled.
    Waiting,
    /// The force is in its soft start.
    ComingIn,
    /// The whole force.
    Rendering,
    /// No force: the sample was rejected, for example because the sensor jumped.
    SampleRefused,
    /// No force: the host is silent.
    HostSilent,
}

/// Result of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Duty of the motor driver for the next period.
    pub duty: i16,
    /// Status of the force.
    pub status: Status,
}

/// The loop of a knob, with a wall rendered by `P`.
#[derive(Clone, Copy, Debug)]
pub struct Knob<P: MethodParams<f32>> {
    params: KnobParams,
    renderer: Renderer<f32, P::Method>,
    state: State<f32, <P::Method as palpate::Method<f32>>::Memory>,
    sensor: Sensor,
    /// Factor of the soft start on the force, 0 to 1.
    share: f32,
    is_free: bool,
    silent_for: Option<u32>,
}

impl<P: MethodParams<f32>> Knob<P> {
    /// Creates a knob without a force. The duty of a tick has to act from the next tick on, as in a PWM timer with a
    /// preload register. Therefore the model value of the method's delay is one period.
    ///
    /// # Errors
    /// The first parameter of the contact, the loop or the method that is outside its range.
    pub fn new(params: KnobParams, method: P) -> Result<Self, ParameterError> {
        let period = params.period;
        let loop_params = LoopParams {
            speed_limit: Some(params.speed_limit),
            actuation: Actuation::after_samples(1, period),
            ..LoopParams::new(period).with_force_limit(params.drive.full_force)
        };
        let renderer = Renderer::new(Contact::wall(params.stiffness), loop_params, method)?;
        let state = renderer.start(ObjectState::at_rest(params.wall_at))?;
        Ok(Self {
            params,
            renderer,
            state,
            sensor: Sensor::new(params.metres_per_count),
            share: 0.0,
            is_free: false,
            silent_for: None,
        })
    }

    /// Performs one tick for the sensor's count and whether the host has sent a message since the last tick. It does
    /// not panic, allocate or wait.
    pub fn tick(&mut self, count: u16, host_spoke: bool) -> Answer {
        let position = self.sensor.position(count);
        let output = self.renderer.step(&mut self.state, Sample::at(position));
        let is_silent = self.is_silent(host_spoke);
        let status = if output.fault.is_some() {
            Status::SampleRefused
        } else if is_silent {
            Status::HostSilent
        } else {
            self.come_in(output.phase)
        };
        if matches!(status, Status::SampleRefused | Status::HostSilent) {
            self.share = 0.0;
            self.is_free = false;
        }
        let duty = self.params.drive.duty(output.force_on_device * self.share);
        // Prediction and energy ledger use the commanded duty.
        self.renderer
            .report_sent(&mut self.state, -self.params.drive.force(duty));
        Answer { duty, status }
    }

    /// Applies the soft start, which begins once the rim has been free, never inside the wall.
    fn come_in(&mut self, phase: Phase) -> Status {
        self.is_free |= phase == Phase::Free;
        if !self.is_free {
            return Status::Waiting;
        }
        if self.share >= 1.0 {
            return Status::Rendering;
        }
        self.share = (self.share + self.params.period / self.params.soft_start).min(1.0);
        Status::ComingIn
    }

    fn is_silent(&mut self, host_spoke: bool) -> bool {
        self.silent_for = match self.silent_for {
            _ if host_spoke => Some(0),
            silent_for => silent_for.map(|ticks| ticks.saturating_add(1)),
        };
        match self.params.when_silent {
            WhenSilent::GoOn => false,
            WhenSilent::DisableOutput { after } => {
                self.silent_for.is_none_or(|ticks| ticks >= after)
            }
        }
    }

    /// Returns the energy generated by the held forces, from the renderer's energy ledger `[J]`.
    pub fn created(&self) -> f32 {
        self.state.ledger().held_leak.accumulated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::CoupledParams;

    fn knob(when_silent: WhenSilent) -> Knob<CoupledParams<f32>> {
        let params = KnobParams {
            period: 0.00025,
            metres_per_count: 5e-6,
            wall_at: 0.0,
            stiffness: 5000.0,
            speed_limit: 2.0,
            soft_start: 0.01,
            drive: Drive {
                full_force: 20.0,
                full_duty: 1000,
            },
            when_silent,
        };
        Knob::new(params, CoupledParams::new(0.05)).unwrap()
    }

    /// Ticks at one count. Returns the last answer.
    fn rest(knob: &mut Knob<CoupledParams<f32>>, count: u16, ticks: u32, spoke: bool) -> Answer {
        let mut answer = knob.tick(count, spoke);
        for _ in 1..ticks {
            answer = knob.tick(count, spoke);
        }
        answer
    }

    #[test]
    fn a_knob_that_starts_inside_the_wall_gives_no_force_until_it_has_been_free() {
        let mut knob = knob(WhenSilent::GoOn);
        for _ in 0..1000 {
            let answer = knob.tick(200, false);
            assert_eq!((answer.duty, answer.status), (0, Status::Waiting));
        }
        for count in (0..200_u16).rev().step_by(10) {
            assert_eq!(knob.tick(count, false).duty, 0);
        }
        rest(&mut knob, 65_500, 100, false);
        for count in (0..200).step_by(10) {
            knob.tick(count, false);
        }
        let answer = rest(&mut knob, 200, 400, false);
        // 1 mm into 5000 N/m: 5 N of 20.
        assert_eq!(answer.status, Status::Rendering);
        assert!((-260..=-240).contains(&answer.duty), "{answer:?}");
    }

    #[test]
    fn the_force_comes_in_over_the_soft_start() {
        let mut knob = knob(WhenSilent::GoOn);
        let ticks = (0..100)
            .take_while(|_| knob.tick(65_500, false).status == Status::ComingIn)
            .count();
        // 10 ms at 4 kHz, and one tick more if the rounded shares do not sum to 1.
        assert!((40..=41).contains(&ticks), "{ticks}");
    }

    #[test]
    fn a_count_that_jumps_takes_the_force_off_at_once() {
        let mut knob = knob(WhenSilent::GoOn);
        rest(&mut knob, 65_500, 100, false);
        for count in (0..200).step_by(10) {
            knob.tick(count, false);
        }
        assert!(rest(&mut knob, 200, 100, false).duty < -200);
        let answer = knob.tick(200 + 3000, false);
        assert_eq!((answer.duty, answer.status), (0, Status::SampleRefused));
        // Back at the correct count, inside the wall, it waits for a free rim.
        for _ in 0..1000 {
            assert_eq!(knob.tick(200, false).duty, 0);
        }
    }

    #[test]
    fn a_silent_host_is_obeyed_as_configured() {
        let mut alone = knob(WhenSilent::GoOn);
        assert_eq!(
            rest(&mut alone, 65_500, 100, false).status,
            Status::Rendering
        );
        let mut led = knob(WhenSilent::DisableOutput { after: 50 });
        assert_eq!(
            rest(&mut led, 65_500, 100, false).status,
            Status::HostSilent
        );
        assert_eq!(rest(&mut led, 65_500, 100, true).status, Status::Rendering);
        assert_eq!(rest(&mut led, 65_500, 49, false).status, Status::Rendering);
        assert_eq!(
            led.tick(65_500, false),
            Answer {
                duty: 0,
                status: Status::HostSilent
            }
        );
        assert_eq!(led.tick(65_500, true).status, Status::ComingIn);
    }
}
