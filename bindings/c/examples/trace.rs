//! Prints the output of tests/c/trace.c from the core without C: both must agree bit for bit. The parameters are the
//! doubles of the C program, rounded once.

use palpate_core::{
    Actuation, Basis, Contact, Fault, LoopParams, MethodName, ObjectState, Phase, Rendering,
    Running, Sample, Scalar, Settings, SettingsError,
};

const PERIOD: f64 = 0.01;
const DEVICE_MASS: f64 = 0.1;

fn rendering<S: Scalar>(
    method: MethodName,
    stiffness: f64,
    mass: f64,
    object_position: f64,
) -> Result<Rendering<S>, SettingsError> {
    let number = S::from_f64;
    let actuation = Actuation::after(number(0.005))
        .with_lag(number(0.0003))
        .with_gain(number(0.98));
    let loop_params = LoopParams {
        actuation: Actuation {
            delay_deviation: number(0.0005),
            ..actuation
        },
        ..LoopParams::new(number(PERIOD)).with_force_limit(number(20.0))
    };
    let basis = Basis {
        stiffness,
        period: PERIOD,
        device_mass: Some(DEVICE_MASS),
        encoder_quantum: 0.0,
        recorded: false,
        stored_energy: 0.0,
    };
    Ok(Rendering {
        contact: Contact::object(number(stiffness), number(mass)),
        loop_params,
        params: method.params(&Settings::default(), &basis)?,
        virtual_force: S::ZERO,
        object: ObjectState::at_rest(number(object_position)),
    })
}

fn run<S: Scalar>(
    method: MethodName,
    object_position: f64,
    positions: &[f64],
) -> Result<(), Box<dyn std::error::Error>> {
    let number = S::from_f64;
    let mut running = Running::<S>::new(rendering(method, 100.0, 0.1, object_position)?)?;
    for (tick, &position) in positions.iter().enumerate() {
        let position = if tick == 50 { f64::NAN } else { position };
        let mut sample = Sample::at(number(position)).with_virtual_force(number(-0.981));
        match tick {
            15 => running.change(rendering(method, 200.0, 0.2, object_position)?)?,
            30 => sample = sample.after(number(0.013)),
            60 => running.teleport(ObjectState {
                position: number(object_position - 0.001),
                velocity: number(-0.1),
            })?,
            70 => running.change(rendering(MethodName::Basic, 200.0, 0.2, object_position)?)?,
            _ => {}
        }
        let output = running.step(sample);
        let force = output.force_on_device;
        if tick % 7 == 3 {
            running.report_sent(-(number(0.5) * force));
        }
        if tick % 7 == 5 {
            running.report_held(-(number(0.9) * force));
        }
        let ledger = running.ledger();
        let numbers = [
            force,
            output.force_on_device,
            output.force_on_object,
            output.slope_on_device,
            output.object_position,
            output.object_velocity,
            output.penetration,
            output.transition_after,
            output.proxy_shift,
            ledger.stored,
            ledger.port_work,
            ledger.virtual_force_work,
            ledger.outside_work,
            ledger.held_leak.accumulated,
            ledger.held_leak.last,
            ledger.held_leak.absolute,
            ledger.original_leak.accumulated,
            ledger.original_leak.last,
            ledger.original_leak.absolute,
        ];
        print!("{method} {tick}");
        for number in numbers {
            print!(" {:016x}", number.to_f64().to_bits());
        }
        let phases = [
            Phase::Free,
            Phase::Contact,
            Phase::Enters,
            Phase::Leaves,
            Phase::Waiting,
        ];
        let phase = phases.iter().position(|phase| *phase == output.phase);
        let faults = [
            None,
            Some(Fault::PositionNotFinite),
            Some(Fault::VirtualForceNotFinite),
            Some(Fault::ElapsedNotPositive),
            Some(Fault::GapTooLong),
            Some(Fault::JumpTooFast),
            Some(Fault::Overflow),
        ];
        let fault = faults.iter().position(|fault| *fault == output.fault);
        let limited = output.limited;
        let limits = [limited.pull, limited.force, limited.slew, limited.guard];
        let bits: u32 = (0..)
            .zip(limits)
            .map(|(bit, set)| u32::from(set) << bit)
            .sum();
        println!(" {} {} {bits}", phase.unwrap(), fault.unwrap());
    }
    Ok(())
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: trace TABLE.csv OBJECT_POSITION double|float";
    let path = arguments.next().expect(usage);
    let object_position = arguments.next().expect(usage).parse().expect(usage);
    let run = match arguments.next().as_deref() {
        Some("double") => run::<f64>,
        Some("float") => run::<f32>,
        _ => panic!("{usage}"),
    };
    let table = std::fs::read_to_string(path).expect("the table can be read");
    let positions: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(1).unwrap().parse().unwrap())
        .collect();
    for method in MethodName::ALL {
        if let Err(error) = run(method, object_position, &positions) {
            println!("{method}: {error}");
        }
    }
}
