//! Ticks for measurements: the paper's Fig. 2 scene, run once in closed loop with a point-mass device, with the state
//! and the sample of every tick.

use std::hint::black_box;

use palpate_core::{
    AnyMemory, AnyParams, AnyRenderer, Contact, CoupledParams, HfcrParams, LoopParams, ObjectState,
    Phase, PopcParams, PopcRefParams, Renderer, Sample, SehParams, State, VirtualDamperParams,
};

const PERIOD: f64 = 0.01;
const WEIGHT: f64 = -0.981;
/// Ten collisions and more.
const TICK_COUNT: usize = 300;

/// Class of a tick.
pub const CLASSES: [&str; 6] = ["free", "contact", "enters", "leaves", "late", "fault"];

pub const METHODS: [&str; 8] = [
    "basic",
    "virtual-damper",
    "seh",
    "popc",
    "popc-ref",
    "hfcr-mod",
    "hfcr",
    "coupled",
];

/// A tick that can be repeated.
#[derive(Clone, Copy)]
pub struct Tick {
    pub state: State<f64, AnyMemory<f64>>,
    pub sample: Sample<f64>,
}

impl Tick {
    /// Runs the tick. Only once: the state is afterwards that after the tick.
    #[inline(always)]
    pub fn take(&mut self, renderer: &AnyRenderer<f64>) {
        black_box(&renderer.step(&mut self.state, self.sample));
    }
}

/// A method's renderer and the ticks of its own closed loop.
pub struct Recorded {
    pub renderer: AnyRenderer<f64>,
    /// Every tick of the scene, in order.
    pub scene: Vec<Tick>,
    phases: Vec<Phase>,
}

impl Recorded {
    pub fn run(method: &str) -> Self {
        let params = match method {
            "basic" => AnyParams::Basic,
            "virtual-damper" => AnyParams::VirtualDamper(VirtualDamperParams::new(0.5)),
            "seh" => AnyParams::Seh(SehParams::default()),
            "popc" => AnyParams::Popc(PopcParams::new(6.0)),
            "popc-ref" => AnyParams::PopcRef(PopcRefParams::new(6.0)),
            "hfcr-mod" => AnyParams::Hfcr(HfcrParams::modified_force_only()),
            "hfcr" => AnyParams::Hfcr(HfcrParams::with_damping(0.02)),
            "coupled" => AnyParams::Coupled(CoupledParams::new(0.1)),
            other => panic!("no method {other}"),
        };
        let contact = Contact::object(100.0, 0.1);
        let renderer = Renderer::new(contact, LoopParams::new(PERIOD), params).unwrap();
        let mut state = renderer.start(ObjectState::at_rest(0.1)).unwrap();
        let (mut position, mut velocity) = (0.0, 0.0);
        let (mut scene, mut phases) = (Vec::new(), Vec::new());
        for _ in 0..TICK_COUNT {
            let sample = Sample::at(position).with_virtual_force(WEIGHT);
            scene.push(Tick { state, sample });
            let output = renderer.step(&mut state, sample);
            assert_eq!(output.fault, None);
            phases.push(output.phase);
            let acceleration = (0.981 + output.force_on_device) / 0.1;
            position += (velocity + 0.5 * acceleration * PERIOD) * PERIOD;
            velocity += acceleration * PERIOD;
        }
        Self {
            renderer,
            scene,
            phases,
        }
    }

    /// Returns the ticks of a class, empty if the method has no such ticks. A late tick is one of sustained contact
    /// whose sample came 1.3 periods after the last; a fault is one whose sample is NaN.
    pub fn of_class(&self, class: &str) -> Vec<Tick> {
        let phase = match class {
            "free" => Phase::Free,
            "enters" => Phase::Enters,
            "leaves" => Phase::Leaves,
            _ => Phase::Contact,
        };
        // The first tick ends no interval.
        (1..TICK_COUNT)
            .filter(|&tick| self.phases[tick] == phase)
            .filter(|&tick| class != "late" || self.phases[tick - 1] == phase)
            .map(|tick| {
                let Tick { state, mut sample } = self.scene[tick];
                match class {
                    "late" => sample.elapsed = Some(1.3 * PERIOD),
                    "fault" => sample.device_position = f64::NAN,
                    _ => {}
                }
                Tick { state, sample }
            })
            .collect()
    }
}
