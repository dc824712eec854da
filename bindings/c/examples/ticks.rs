//! The ticks of ticks.c, run on the core without C: METHOD COUNT.

use palpate_core::{
    Basis, Contact, LoopParams, MethodName, ObjectState, Renderer, Sample, Settings,
};

const POSITION_COUNT: usize = 500;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: ticks METHOD COUNT";
    let method = arguments.next().expect(usage);
    let method = MethodName::named(&method).expect("a method");
    let count: usize = arguments.next().expect(usage).parse().expect(usage);
    let (stiffness, period) = (1000.0, 0.001);
    let basis = Basis {
        stiffness,
        period,
        device_mass: Some(0.25),
        encoder_quantum: 0.0,
        recorded: false,
        stored_energy: 0.0,
    };
    let params = method.params(&Settings::default(), &basis).unwrap();
    let loop_params = LoopParams::new(period).with_force_limit(20.0);
    let renderer = Renderer::new(Contact::object(stiffness, 0.1), loop_params, params).unwrap();
    let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();

    let (mut position, mut velocity) = (0.0, 0.001);
    let mut positions = [0.0; POSITION_COUNT];
    for (at, place) in positions.iter_mut().enumerate() {
        *place = position;
        velocity -= 0.004 * position;
        position += velocity;
        if at % 100 == 99 {
            (position, velocity) = (0.0, 0.001);
        }
    }
    let mut sum = 0.0;
    for tick in 0..count {
        let sample = Sample::at(positions[tick % POSITION_COUNT]).with_virtual_force(-0.981);
        let output = std::hint::black_box(renderer.step(&mut state, sample));
        sum += output.force_on_device + output.penetration;
    }
    println!("{sum}");
}
