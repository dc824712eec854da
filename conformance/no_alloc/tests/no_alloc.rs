//! A tick allocates nothing, for every method and sample.
//!
//! ```text
//! cargo test --release -p palpate-conformance-no-alloc
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use palpate_core::{
    Actuation, AnyParams, AnyRenderer, Contact, CoupledParams, DamperObject, EntryHold, HfcrParams,
    LoopParams, Mass, ObjectState, PopcParams, PopcRefParams, Prediction, Sample, SehParams,
    VirtualDamperParams,
};

#[path = "no_alloc/many_bodies.rs"]
mod many_bodies;

/// The system's allocator, with a count of each thread's calls.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is forwarded unchanged; the counter is a constant-initialised thread-local without a destructor,
// so accessing it allocates nothing. `alloc_zeroed` and `realloc` call `alloc` by default.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller guarantees the requirements of `System`.
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

/// Nor does a tick on a mesh: triangles are collected in a preallocated buffer.
#[test]
fn a_mesh_is_touched_without_allocating() {
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, CoupledParams, GodObjectParams, HfcrParams, Mesh,
        Motion, Party, Sample, Shape, Tool, World, WorldLoop, WorldMethod, WorldRenderer,
    };
    // Egg box of 2 mm on 100 mm, with triangles of 1 mm.
    let cells = 100;
    let vertices: Vec<[f64; 3]> = (0..=cells)
        .flat_map(|i| (0..=cells).map(move |j| [0.001 * f64::from(i), 0.001 * f64::from(j)]))
        .map(|[x, y]| [x, y, 0.001 * (300.0 * x).sin() * (300.0 * y).sin()])
        .collect();
    let row = u32::try_from(cells).unwrap() + 1;
    let faces: Vec<[u32; 3]> = (0..row - 1)
        .flat_map(|i| (0..row - 1).map(move |j| i * row + j))
        .flat_map(|a| [[a, a + row, a + row + 1], [a, a + row + 1, a + 1]])
        .collect();
    let mesh = std::sync::Arc::new(Mesh::new(&vertices, &faces).unwrap());
    // For the large ball the maximum number of triangles is checked, which is slow in an unoptimised build.
    for (radius, ticks) in [(0.0, 3000), (0.004, 3000), (1.0, 200)] {
        let world = World {
            joints: Vec::new(),
            fields: Vec::new(),
            tools: vec![Tool::new("tool", Shape::Sphere { radius })],
            bodies: vec![Body::new("bumps", Shape::Mesh(mesh.clone()), Motion::Fixed)],
            contacts: vec![Contact {
                between: [Party::Any, Party::Any],
                law: ContactLaw::spring(2000.0)
                    .with_damping(1.0)
                    .with_friction(0.5),
            }],
        };
        let methods: [WorldMethod; 4] = [
            HfcrParams::default().into(),
            BasicParams::default().into(),
            GodObjectParams {
                stiffness: vec![2000.0],
                damping: vec![1.0],
            }
            .into(),
            CoupledParams::new(vec![[0.15; 3]]).into(),
        ];
        for method in methods {
            let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
            let mut state = renderer.start();
            let (mut forces, mut left_out) = (0, 0);
            let count = allocations(|| {
                for tick in 0..ticks {
                    let t = f64::from(tick) * 0.001;
                    let height = radius + 0.0008 + 0.001 * (40.0 * t).sin();
                    let mut positions =
                        [[0.05 + 0.04 * t.sin(), 0.05 + 0.03 * (1.7 * t).sin(), height]];
                    if tick % 300 == 299 {
                        positions[0][1] = f64::NAN;
                    }
                    let output = renderer.step(&mut state, &Sample::at(&positions));
                    forces += usize::from(output.forces[0] != [0.0; 3]);
                    left_out += usize::from(output.effort.left_out > 0);
                }
            });
            assert!(forces > 50, "{radius}: {forces}");
            // A ball of 1 m has more triangles nearby than are checked, which is reported.
            assert_eq!(left_out > 0, radius > 0.02, "{radius}: {left_out}");
            assert_eq!(count, 0);
        }
    }
}

/// Nor does a tick of points on a distance grid.
#[test]
fn points_touch_a_grid_without_allocating() {
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, CoupledParams, DistanceGrid, HfcrParams, Mesh,
        Motion, Party, PointShell, Sample, Shape, Tool, VirtualCouplingParams, World, WorldLoop,
        WorldMethod, WorldRenderer,
    };
    use std::sync::Arc;
    let block = |half: f64| {
        let corner =
            |number: u32| [0, 1, 2].map(|axis| if number >> axis & 1 == 0 { -half } else { half });
        let vertices: Vec<[f64; 3]> = (0..8).map(corner).collect();
        Mesh::convex(&vertices).unwrap()
    };
    let (slab, die) = (block(0.05), block(0.01));
    let grid = DistanceGrid::new(&slab, 0.005).unwrap();
    let shell = PointShell::over(&die, 32).unwrap();
    let world = World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Mesh(Arc::new(die.with_shell(shell)))).turning()],
        bodies: vec![Body::new(
            "slab",
            Shape::Mesh(Arc::new(slab.with_grid(grid).unwrap())),
            Motion::Fixed,
        )],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(2000.0)
                .with_damping(1.0)
                .with_friction(0.5),
        }],
    };
    let methods: [WorldMethod; 4] = [
        HfcrParams::default().into(),
        BasicParams::default().into(),
        VirtualCouplingParams {
            stiffness: vec![1000.0],
            damping: vec![2.0],
            mass: vec![0.05],
            rotational_stiffness: vec![0.5],
            rotational_damping: vec![1e-3],
            inertia: vec![1e-5],
        }
        .into(),
        CoupledParams::new(vec![[0.15; 3]])
            .with_device_inertia(vec![[4e-5; 3]])
            .into(),
    ];
    for method in methods {
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let mut forces = 0;
        let count = allocations(|| {
            for tick in 0..400 {
                let t = f64::from(tick) * 0.001;
                let half: f64 = 0.2 * (11.0 * t).sin();
                let orientations = [[half.cos(), half.sin(), 0.0, 0.0]];
                let positions = [[0.02 * t, 0.0, 0.0605 - 0.002 * (40.0 * t).sin()]];
                let sample = Sample::at(&positions).turned(&orientations);
                let output = renderer.step(&mut state, &sample);
                forces += usize::from(output.forces[0] != [0.0; 3]);
            }
        });
        assert!(forces > 50, "{forces}");
        assert_eq!(count, 0);
    }
}

/// A world allocates all memory at its creation and start; its ticks allocate nothing.
#[test]
fn a_world_is_stepped_without_allocating() {
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, HfcrParams, Joint, JointKind,
        JointLaw, Motion, Party, Sample, Shape, Tool, VirtualCouplingParams, World, WorldLoop,
        WorldMethod, WorldRenderer,
    };
    let half_space = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let ball = Free::of_mass(0.1).pulled_by([0.0, 0.0, -1.0]);
    // In addition to the ball, a block falls on another one on a slider with a spring.
    let block = Shape::Box {
        half_extents: [0.02; 3],
    };
    let slider = Joint {
        body: "lower".into(),
        against: None,
        kind: JointKind::Slider,
        point: [0.2, 0.0, 0.06],
        axis: [0.0, 0.0, 1.0],
        law: JointLaw {
            spring: 100.0,
            limits: Some([-0.01, 0.0]),
            ..JointLaw::new(5000.0, 0.04)
        },
    };
    let mut world = World {
        joints: vec![slider],
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.01 })],
        bodies: vec![
            Body::new("floor", half_space, Motion::Fixed),
            Body::new("ball", Shape::Sphere { radius: 0.02 }, Motion::Free(ball))
                .at([0.0, 0.0, 0.02]),
            Body::new("lower", block.clone(), Motion::Free(ball)).at([0.2, 0.0, 0.06]),
            Body::new("upper", block, Motion::Free(ball))
                .at([0.205, 0.003, 0.103])
                .turned([0.8, 0.0, 0.6, 0.0]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(2000.0)
                .with_damping(1.0)
                .with_friction(0.5),
        }],
    };
    let coupling = VirtualCouplingParams {
        stiffness: vec![2000.0],
        damping: vec![2.0],
        mass: vec![0.05],
        ..VirtualCouplingParams::default()
    };
    let methods: [WorldMethod; 4] = [
        HfcrParams::default().into(),
        BasicParams::default().into(),
        coupling.into(),
        CoupledParams::new(vec![[0.1, 0.2, f64::INFINITY]]).into(),
    ];
    // A device without y has a position-driven y axis.
    let axes = [[true; 3], [true, false, true]];
    for (axes, method) in axes
        .into_iter()
        .flat_map(|axes| methods.clone().map(|method| (axes, method)))
    {
        world.tools[0].axes = axes;
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
                    elapsed,
                    ..Sample::at(&positions)
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

/// Nor does a tick of cylinders: a tool and bodies on a table, one on another, and beside a hull.
#[test]
fn cylinders_are_touched_without_allocating() {
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, HfcrParams, Hull, Motion,
        Party, Sample, Shape, Tool, World, WorldLoop, WorldMethod, WorldRenderer,
    };
    use std::sync::Arc;
    let half_space = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let can = |half_length: f64| Shape::Cylinder {
        radius: 0.02,
        half_length,
    };
    let corners: Vec<[f64; 3]> = (0..8)
        .map(|number| {
            [0, 1, 2].map(|axis| {
                if number >> axis & 1 == 0 {
                    -0.02
                } else {
                    0.025
                }
            })
        })
        .collect();
    let stone = Shape::Hull(Arc::new(Hull::around(&corners).unwrap()));
    let free = Free::of_mass(0.1).pulled_by([0.0, 0.0, -1.0]);
    let named = |name: &str| Party::Named(name.into());
    let law = ContactLaw::spring(2000.0)
        .with_damping(1.0)
        .with_friction(0.5);
    let pairs = [
        ["tool", "upper"],
        ["tool", "stone"],
        ["lower", "table"],
        ["lower", "upper"],
        ["lower", "stone"],
    ];
    let world = World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", can(0.02)).turning()],
        bodies: vec![
            Body::new("table", half_space, Motion::Fixed),
            Body::new("lower", can(0.03), Motion::Free(free)).at([0.0, 0.0, 0.03]),
            Body::new("upper", can(0.01), Motion::Free(free))
                .at([0.003, 0.0, 0.072])
                .turned([0.96, 0.0, 0.28, 0.0]),
            Body::new("stone", stone, Motion::Fixed).at([0.043, 0.0, 0.03]),
        ],
        contacts: pairs
            .map(|pair| Contact {
                between: pair.map(named),
                law,
            })
            .into(),
    };
    let methods: [WorldMethod; 3] = [
        HfcrParams::default().into(),
        BasicParams::default().into(),
        CoupledParams::new(vec![[0.15; 3]])
            .with_device_inertia(vec![[4e-5; 3]])
            .into(),
    ];
    for method in methods {
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let mut forces = 0;
        let count = allocations(|| {
            for tick in 0..400 {
                let t = f64::from(tick) * 0.001;
                let half: f64 = 0.8 * (11.0 * t).sin();
                let orientations = [[half.cos(), half.sin(), 0.0, 0.0]];
                let positions = [[0.05 * t, 0.0, 0.1 - 0.01 * (40.0 * t).sin()]];
                let sample = Sample::at(&positions).turned(&orientations);
                let output = renderer.step(&mut state, &sample);
                forces += usize::from(output.forces[0] != [0.0; 3]);
            }
        });
        assert!(forces > 50, "{forces}");
        assert_eq!(count, 0);
    }
}

/// Nor does contact with the bodies of another engine.
#[test]
fn contact_with_an_engine_s_body_allocates_nothing() {
    use palpate_world::engine::{
        BodyNow, BodyWrench, EngineBody, EngineRenderer, PlacedShape, Stepping,
    };
    use palpate_world::{ContactLaw, CoupledParams, IDENTITY, Sample, Shape, Tool, WorldLoop};
    let body = EngineBody {
        name: "block".into(),
        shapes: vec![PlacedShape {
            shape: Shape::Box {
                half_extents: [0.02; 3],
            },
            position: [0.0; 3],
            orientation: IDENTITY,
        }],
        law: ContactLaw::spring(2000.0).with_friction(0.5),
    };
    let tools = [Tool::new("tool", Shape::Sphere { radius: 0.01 })];
    let params = CoupledParams::new(vec![[0.1, 0.2, f64::INFINITY]]);
    let loop_params = WorldLoop::new(0.001);
    let renderer =
        EngineRenderer::new(&tools, &[body], Stepping::EndVelocity, loop_params, params).unwrap();
    let mut state = renderer.start();
    let mut now = BodyNow::fixed([0.0; 3]);
    for axis in 0..6 {
        now.mobility[axis][axis] = if axis < 3 { 10.0 } else { 1e5 };
    }
    let (mut forces, mut faults) = (0, 0);
    let count = allocations(|| {
        for tick in 0..2000 {
            let t = f64::from(tick) * 0.001;
            let mut positions = [[0.002 * t, 0.0, 0.031 + 0.003 * (11.0 * t).sin()]];
            now.velocity[0] = 0.01 * t;
            now.position[2] = 0.0;
            match tick % 50 {
                20 => positions[0][1] = f64::NAN,
                40 => now.position[2] = f64::NAN,
                _ => {}
            }
            renderer.sample(&mut state, &Sample::at(&positions));
            let mut wrenches = [BodyWrench::default()];
            for _ in 0..2 {
                renderer.advance(&mut state, 0.0005, &[now], &mut wrenches);
            }
            let output = renderer.hold(&mut state);
            forces += usize::from(output.forces[0] != [0.0; 3]);
            faults += usize::from(output.fault.is_some());
        }
    });
    assert!(forces > 100 && faults >= 80, "{forces}, {faults}");
    assert_eq!(count, 0);
}

/// Nor does contact by the local models of a low-rate simulator, whether a model arrives, is rejected, is missing or
/// expires.
#[test]
fn contact_by_a_local_model_allocates_nothing() {
    use palpate_world::engine::BodyNow;
    use palpate_world::engine::local::{LocalContact, LocalParams, LocalProgress, LocalRenderer};
    use palpate_world::{ContactLaw, CoupledParams, Sample, Shape, Tool, WorldLoop};
    let tools = [Tool::new("tool", Shape::Sphere { radius: 0.01 })];
    let room = LocalParams {
        stale_after: 0.05,
        fade: 0.02,
        ..LocalParams::new(1, 4)
    };
    let params = CoupledParams::new(vec![[0.1, 0.2, f64::INFINITY]]);
    let renderer = LocalRenderer::new(&tools, room, WorldLoop::new(0.001), params).unwrap();
    let mut state = renderer.start();
    let mut now = BodyNow::fixed([0.0; 3]);
    for axis in 0..6 {
        now.mobility[axis][axis] = if axis < 3 { 10.0 } else { 1e5 };
    }
    let up = [0.0, 0.0, 1.0];
    let law = ContactLaw::spring(2000.0).with_friction(0.5);
    let ball = LocalContact::of_tool(0, Some(0), [0.0, 0.0, 0.02], up, law).curved(50.0);
    let floor = LocalContact::of_body((0, [0.0; 3], 0.02), None, [0.0, 0.0, -0.02], up, law);
    let model = |tick| {
        let contacts = [Some(ball), Some(floor), (tick % 40 != 0).then_some(ball)];
        renderer.model(tick, &[now], &contacts).unwrap()
    };
    let models: Vec<_> = (0..2000).map(model).collect();
    let mut progress = LocalProgress::default();
    progress.copy_from(state.progress());
    let (mut forces, mut faults, mut refusals, mut stale) = (0, 0, 0, 0);
    let count = allocations(|| {
        for tick in 0..2000_usize {
            let t = tick as f64 * 0.001;
            let mut positions = [[0.002 * t, 0.0, 0.031 + 0.003 * (11.0 * t).sin()]];
            if tick % 50 == 20 {
                positions[0][1] = f64::NAN;
            }
            // Every 20 ticks, ten ticks late; after a second the simulator hangs for 0.2 s.
            let is_there = tick % 20 == 10 && !(1000..1200).contains(&tick);
            let model = is_there.then(|| &models[tick - 10]);
            // Occasionally a model from the future.
            let model = if tick % 100 == 55 {
                models.last()
            } else {
                model
            };
            let output = renderer.step(&mut state, &Sample::at(&positions), model);
            forces += usize::from(output.forces[0] != [0.0; 3]);
            faults += usize::from(output.fault.is_some());
            refusals += usize::from(output.refusal.is_some());
            stale += usize::from(output.is_stale);
            progress.copy_from(state.progress());
        }
    });
    assert!(forces > 100 && faults >= 40, "{forces}, {faults}");
    assert!(refusals >= 19 && stale > 100, "{refusals}, {stale}");
    assert_eq!(count, 0);
}
