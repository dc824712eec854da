//! A tick allocates nothing, whatever the method and the sample.
//!
//! ```text
//! cargo test --manifest-path conformance/no_alloc/Cargo.toml
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use palpate::{
    Actuation, AnyParams, AnyRenderer, Contact, CoupledParams, DamperObject, EntryHold, HfcrParams,
    LoopParams, Mass, ObjectState, PopcParams, PopcRefParams, Prediction, Sample, SehParams,
    VirtualDamperParams,
};

/// The system's allocator, counting what each thread asks of it.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged; the counter is a constant-initialised thread-local
// without a destructor, so touching it allocates nothing. `alloc_zeroed` and `realloc` come
// through `alloc` by default.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises are those `System` asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(run: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.get();
    run();
    ALLOCATIONS.get() - before
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(black_box(Box::new(1)))), 1);
}

#[test]
fn a_renderer_is_made_started_and_stepped_without_allocating() {
    let methods = [
        AnyParams::Basic,
        AnyParams::VirtualDamper(VirtualDamperParams::new(0.5)),
        AnyParams::Seh(SehParams::default()),
        AnyParams::Popc(PopcParams::new(6.0)),
        AnyParams::PopcRef(PopcRefParams::new(6.0)),
        AnyParams::Hfcr(HfcrParams::modified_force_only()),
        AnyParams::Hfcr(HfcrParams::with_damping(0.02)),
        AnyParams::Hfcr(HfcrParams {
            prediction: Prediction::Observer {
                device_mass: Mass::Finite(0.25),
                encoder_quantum: 1e-5,
            },
            ..HfcrParams::default()
        }),
        AnyParams::Hfcr(HfcrParams {
            prediction: Prediction::FirstOrderAdaptiveWindow {
                noise_bound: 1e-5,
                longest_window: 0.15,
            },
            entry_hold: EntryHold::Midpoint,
            ..HfcrParams::default()
        }),
        AnyParams::VirtualDamper(VirtualDamperParams {
            object: DamperObject::HeldForce,
            prediction: Prediction::Extrapolation,
            ..VirtualDamperParams::new(0.5)
        }),
        AnyParams::Coupled(CoupledParams::new(0.25).with_encoder_quantum(1e-5)),
        AnyParams::Coupled(CoupledParams {
            placement: false,
            correction: false,
            ..CoupledParams::new(f64::INFINITY)
        }),
    ];
    let (mut forces, mut faults) = (0, 0);
    let count = allocations(|| {
        for method in methods {
            for (mass, delay) in [
                (0.1, 0.0),
                (0.1, 2.6),
                (f64::INFINITY, 0.5),
                (f64::INFINITY, 8.0),
            ] {
                let actuation = Actuation {
                    delay_deviation: 1e-4,
                    ..Actuation::after(delay * 0.01).with_lag(0.002)
                };
                let loop_params = LoopParams {
                    actuation,
                    ..LoopParams::new(0.01)
                };
                let contact = Contact::object(400.0, mass);
                let renderer = AnyRenderer::new(contact, loop_params, method).unwrap();
                let mut state = renderer.start(ObjectState::at_rest(0.005)).unwrap();
                for tick in 0..2000 {
                    let t = f64::from(tick) * 0.01;
                    let mut sample = Sample::at(0.01 * (11.0 * t).sin()).with_virtual_force(-1.0);
                    match tick % 50 {
                        10 => sample = sample.after(0.013),
                        20 => sample.device_position = f64::NAN,
                        30 => sample = sample.after(-1.0),
                        40 => sample.device_position = 1e300,
                        _ => {}
                    }
                    if tick == 1000 {
                        let there = ObjectState::at_rest(0.004);
                        renderer.teleport(&mut state, there).unwrap();
                        renderer.adopt(&mut state);
                    }
                    let output = black_box(renderer.step(&mut state, sample));
                    forces += usize::from(output.force_on_object != 0.0);
                    faults += usize::from(output.fault.is_some());
                }
            }
        }
    });
    assert!(forces > 1000 && faults > 1000, "{forces}, {faults}");
    assert_eq!(count, 0);
}

/// A world is made and started with room for everything; its ticks then allocate nothing.
#[test]
fn a_world_is_stepped_without_allocating() {
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Motion, Party, Sample, Shape,
        Tool, World, WorldLoop, WorldMethod, WorldRenderer,
    };
    let half_space = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let ball = Free::of_mass(0.1).pulled_by([0.0, 0.0, -1.0]);
    let world = World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.01 })],
        bodies: vec![
            Body::new("floor", half_space, Motion::Fixed),
            Body::new("ball", Shape::Sphere { radius: 0.02 }, Motion::Free(ball))
                .at([0.0, 0.0, 0.02]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(2000.0)
                .with_damping(1.0)
                .with_friction(0.5),
        }],
    };
    let methods: [WorldMethod; 2] = [
        BasicParams::default().into(),
        CoupledParams::new(vec![[0.1, 0.2, f64::INFINITY]]).into(),
    ];
    for method in methods {
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let (mut forces, mut faults) = (0, 0);
        let count = allocations(|| {
            for tick in 0..2000 {
                let t = f64::from(tick) * 0.001;
                let mut positions = [[0.002 * t, 0.0, 0.052 + 0.006 * (11.0 * t).sin()]];
                let mut elapsed = None;
                match tick % 50 {
                    10 => elapsed = Some(0.0013),
                    20 => positions[0][1] = f64::NAN,
                    30 => elapsed = Some(-1.0),
                    40 => positions[0][0] = 1e300,
                    _ => {}
                }
                let sample = Sample {
                    positions: &positions,
                    elapsed,
                };
                let output = renderer.step(&mut state, &sample);
                forces += usize::from(output.forces[0] != [0.0; 3]);
                faults += usize::from(output.fault.is_some());
            }
        });
        assert!(forces > 100 && faults > 100, "{forces}, {faults}");
        assert_eq!(count, 0);
    }
}
