//! Closed forms of the held force compared with the energy balance, Eq. (9) taken literally: `f = (V~ - V) / d`, with
//! the work of the virtual force in V.

use crate::common::Random;
use palpate_core::{
    AnyParams, Contact, HfcrParams, LoopParams, ObjectState, Output, Phase, Renderer, Sample,
};

/// A random interval with all quantities of Eq. (9).
struct Interval {
    stiffness: f64,
    mass: f64,
    period: f64,
    virtual_force: f64,
    device: f64,
    /// d, the predicted displacement of the device.
    d: f64,
    plan: Output<f64>,
}

impl Interval {
    fn random(random: &mut Random, params: HfcrParams<f64>) -> Self {
        let stiffness = 10f64.powf(random.between(1.5, 4.0));
        let mass = 10f64.powf(random.between(-2.0, 0.5));
        let period = 10f64.powf(random.between(-3.0, -1.5));
        let l = LoopParams {
            speed_limit: None,
            ..LoopParams::new(period)
        };
        let contact = Contact::object(stiffness, mass);
        let renderer = Renderer::new(contact, l, AnyParams::Hfcr(params)).unwrap();
        let object = ObjectState {
            position: random.between(-0.3, 0.3),
            velocity: random.between(-0.5, 0.5),
        };
        let mut state = renderer.start(object).unwrap();
        let virtual_force = random.between(-2.0, 2.0);
        let at = |xi: f64| Sample::at(xi).with_virtual_force(virtual_force);
        let before = object.position + random.between(-0.01, 0.01);
        renderer.step(&mut state, at(before));
        let device = before + random.between(-0.005, 0.005);
        Self {
            stiffness,
            mass,
            period,
            virtual_force,
            device,
            d: device - before,
            plan: renderer.step(&mut state, at(device)),
        }
    }

    fn start(&self) -> (f64, f64) {
        (self.plan.object_position, self.plan.object_velocity)
    }

    fn fly(&self, (eta, velocity): (f64, f64), h: f64) -> (f64, f64) {
        let alpha = self.virtual_force / self.mass;
        (
            eta + velocity * h + 0.5 * alpha * h * h,
            velocity + alpha * h,
        )
    }

    fn press(&self, (eta, velocity): (f64, f64), xi: f64, h: f64) -> (f64, f64) {
        let omega = (self.stiffness / self.mass).sqrt();
        let zeta = xi + self.virtual_force / self.stiffness;
        let (sin, cos) = (omega * h).sin_cos();
        (
            zeta + (eta - zeta) * cos + velocity / omega * sin,
            -omega * (eta - zeta) * sin + velocity * cos,
        )
    }

    /// Returns the stored energy with the potential of the virtual force; the spring is pressed by the device at `xi`
    /// if there is contact.
    fn energy(&self, (eta, velocity): (f64, f64), xi: f64) -> f64 {
        let pressed = (xi - eta).max(0.0);
        0.5 * self.mass * velocity * velocity + 0.5 * self.stiffness * pressed * pressed
            - self.virtual_force * eta
    }

    /// Returns Eq. (9) with the object's predicted end state.
    fn balance(&self, end: (f64, f64)) -> f64 {
        let predicted = self.energy(end, self.device + self.d);
        (predicted - self.energy(self.start(), self.device)) / self.d
    }
}

/// Returns balance and force over many random intervals of one row of the table.
fn agrees(params: HfcrParams<f64>, seed: u64, row: impl Fn(&Interval) -> Option<(f64, f64)>) {
    let mut random = Random(seed);
    let mut count = 0;
    while count < 2000 {
        let interval = Interval::random(&mut random, params);
        if interval.d.abs() < 1e-4 {
            continue;
        }
        let Some(end) = row(&interval) else { continue };
        count += 1;
        let balance = interval.balance(end);
        let force = interval.plan.force_on_object;
        // Rounding of energies and positions, magnified by the division that the closed form avoids.
        let energy = interval.energy(interval.start(), interval.device).abs()
            + interval.energy(end, interval.device).abs()
            + (interval.virtual_force * end.0).abs()
            + interval.stiffness * 1e-4;
        let tolerance = 1e-13 * energy / interval.d.abs();
        assert!(
            (force - balance).abs() <= tolerance + 1e-12 * force.abs(),
            "{force} N, not {balance} N within {tolerance}: {:?}",
            interval.plan
        );
    }
}

#[test]
fn sustained_contact_balances_the_predicted_energy() {
    agrees(HfcrParams::default(), 11, |interval| {
        (interval.plan.phase == Phase::Contact)
            .then(|| interval.press(interval.start(), interval.device, interval.period))
    });
}

#[test]
fn entering_contact_balances_the_predicted_energy() {
    agrees(HfcrParams::default(), 12, |interval| {
        if interval.plan.phase != Phase::Enters {
            return None;
        }
        let tau = interval.plan.transition_after;
        let held_at = interval.device + interval.d * tau / interval.period;
        let touch = interval.fly(interval.start(), tau);
        let end = interval.press(touch, held_at, interval.period - tau);
        // The literal balance has no pulling spring.
        (end.0 < interval.device + interval.d).then_some(end)
    });
}

#[test]
fn leaving_contact_balances_the_predicted_energy() {
    agrees(HfcrParams::default(), 13, |interval| {
        if interval.plan.phase != Phase::Leaves {
            return None;
        }
        let tau = interval.plan.transition_after;
        let apart = interval.press(interval.start(), interval.device, tau);
        let end = interval.fly(apart, interval.period - tau);
        // Nor a spring into which the object has flown back.
        (end.0 > interval.device + interval.d).then_some(end)
    });
}

#[test]
fn leaving_contact_without_smooth_transition_balances_the_predicted_energy() {
    agrees(HfcrParams::modified_force_only(), 14, |interval| {
        if interval.plan.phase != Phase::Contact {
            return None;
        }
        let end = interval.press(interval.start(), interval.device, interval.period);
        (end.0 >= interval.device + interval.d).then_some(end)
    });
}

/// Returns the force of a wall that the device leaves: p = `penetration` now, and `d` in the coming interval.
fn leaving_a_wall(penetration: f64, d: f64) -> f64 {
    let wall = Contact::wall(400.0);
    let params = AnyParams::Hfcr(HfcrParams::modified_force_only());
    let renderer = Renderer::new(wall, LoopParams::new(0.001), params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
    renderer.step(&mut state, Sample::at(penetration - d));
    let output = renderer.step(&mut state, Sample::at(penetration));
    output.force_on_object
}

#[test]
fn a_device_that_hardly_moves_gets_the_spring_force_and_not_a_quotient() {
    // Shorter than 1e-9 m: K max(xi - eta, 0).
    let force = leaving_a_wall(0.3e-9, -0.9e-9);
    assert!((force - 400.0 * 0.3e-9).abs() < 1e-20, "{force}");
    // From 1e-9 m on: -(K/2) p^2 / d.
    let force = leaving_a_wall(0.3e-9, -1.1e-9);
    let quotient = 0.5 * 400.0 * 0.3e-9 * (0.3 / 1.1);
    assert!((force - quotient).abs() < 1e-20, "{force}");
}

#[test]
fn a_device_at_rest_that_the_object_leaves_gets_no_force() {
    let contact = Contact::object(400.0, 0.1);
    let params = AnyParams::Hfcr(HfcrParams::modified_force_only());
    let renderer = Renderer::new(contact, LoopParams::new(0.001), params).unwrap();
    let away = ObjectState {
        position: 0.0,
        velocity: 1.0,
    };
    let mut state = renderer.start(away).unwrap();
    let output = renderer.step(&mut state, Sample::at(1e-5));
    assert_eq!(output.phase, Phase::Contact);
    assert_eq!(output.force_on_object, 0.0);
}
