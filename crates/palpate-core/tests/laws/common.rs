//! Shared test code: every method, a device, a random source, and an independent energy ledger.

use palpate_core::{
    AnyParams, Contact, CoupledParams, DamperObject, EnergyCorrectedParams, EnergyTankParams,
    EntryHold, ForceBoundingParams, HfcrParams, LeakDissipation, Ledger, Mass, MidpointDevice,
    Output, PmiParams, PopcParams, PopcRefParams, Prediction, Sample, Scalar, SehEstimate,
    SehParams, VirtualCouplingParams, VirtualDamperParams,
};

/// Every method, in the settings that differ in kind.
pub fn methods<S: Scalar>() -> Vec<(&'static str, AnyParams<S>)> {
    let of = S::from_f64;
    let seh = |estimate| AnyParams::Seh(SehParams { estimate });
    let damper = |damping| AnyParams::VirtualDamper(VirtualDamperParams::new(damping));
    vec![
        ("basic", AnyParams::Basic),
        ("damper", damper(of(0.5))),
        ("damper, over-damped", damper(of(80.0))),
        ("seh ab2", seh(SehEstimate::Ab2)),
        ("seh differences", seh(SehEstimate::Differences)),
        ("seh ab3", seh(SehEstimate::Ab3)),
        ("popc", AnyParams::Popc(PopcParams::new(of(6.0)))),
        ("popc-ref", AnyParams::PopcRef(PopcRefParams::new(of(6.0)))),
        (
            "energy-corrected",
            AnyParams::EnergyCorrected(EnergyCorrectedParams {}),
        ),
        (
            "force-bounding",
            AnyParams::ForceBounding(ForceBoundingParams {
                device_damping: of(0.5),
            }),
        ),
        (
            "pmi",
            AnyParams::Pmi(PmiParams {
                device: MidpointDevice::Sample,
            }),
        ),
        (
            "pmi, extrapolated",
            AnyParams::Pmi(PmiParams {
                device: MidpointDevice::Extrapolated,
            }),
        ),
        ("energy-tank", AnyParams::EnergyTank(tank())),
        (
            "virtual-coupling",
            AnyParams::VirtualCoupling(coupling(of(100.0), of(0.01))),
        ),
        (
            "hfcr, adaptive",
            AnyParams::Hfcr(HfcrParams {
                leak_dissipation: LeakDissipation::Adaptive,
                ..HfcrParams::default()
            }),
        ),
        (
            "hfcr-mod",
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
        ),
        ("hfcr-mod-st", AnyParams::Hfcr(HfcrParams::default())),
        ("hfcr", AnyParams::Hfcr(HfcrParams::with_damping(of(0.02)))),
        (
            "hfcr-st",
            AnyParams::Hfcr(HfcrParams {
                modified_force: false,
                smooth_transition: true,
                leak_dissipation: LeakDissipation::Damping(of(0.02)),
                ..HfcrParams::default()
            }),
        ),
        (
            "damper, spring moves the object, extrapolation",
            AnyParams::VirtualDamper(VirtualDamperParams {
                object: DamperObject::Spring,
                prediction: Prediction::Extrapolation,
                ..VirtualDamperParams::new(of(0.5))
            }),
        ),
        (
            "damper, held force moves the object, adaptive window",
            AnyParams::VirtualDamper(VirtualDamperParams {
                object: DamperObject::HeldForce,
                prediction: Prediction::FirstOrderAdaptiveWindow {
                    noise_bound: of(1e-5),
                    longest_window: of(0.008),
                },
                ..VirtualDamperParams::new(of(0.5))
            }),
        ),
        (
            "damper, observer",
            AnyParams::VirtualDamper(VirtualDamperParams {
                prediction: Prediction::Observer {
                    device_mass: Mass::Finite(of(0.25)),
                    encoder_quantum: of(0.0),
                },
                ..VirtualDamperParams::new(of(0.5))
            }),
        ),
        (
            "hfcr, held at the sample, adaptive window",
            AnyParams::Hfcr(HfcrParams {
                prediction: Prediction::FirstOrderAdaptiveWindow {
                    noise_bound: of(1e-5),
                    longest_window: of(0.008),
                },
                entry_hold: EntryHold::Sample,
                ..HfcrParams::default()
            }),
        ),
        (
            "hfcr, held at the midpoint, extrapolation",
            AnyParams::Hfcr(HfcrParams {
                prediction: Prediction::Extrapolation,
                entry_hold: EntryHold::Midpoint,
                ..HfcrParams::default()
            }),
        ),
        (
            "hfcr, observer",
            AnyParams::Hfcr(HfcrParams {
                prediction: Prediction::Observer {
                    device_mass: Mass::Finite(of(0.25)),
                    encoder_quantum: of(0.0),
                },
                ..HfcrParams::default()
            }),
        ),
        (
            "coupled",
            AnyParams::Coupled(CoupledParams::new(of(0.25)).with_encoder_quantum(of(1e-6))),
        ),
        (
            "coupled, no placement",
            AnyParams::Coupled(CoupledParams {
                placement: false,
                ..CoupledParams::new(of(0.1))
            }),
        ),
        (
            "coupled, recorded device",
            AnyParams::Coupled(CoupledParams {
                correction: false,
                ..CoupledParams::new(of(f64::INFINITY))
            }),
        ),
    ]
}

/// A tank of 0.1 J.
pub fn tank<S: Scalar>() -> EnergyTankParams<S> {
    EnergyTankParams {
        damping: S::ONE,
        damping_cap: S::from_f64(3.0),
        initial_energy: S::from_f64(0.1),
        desired_energy: S::from_f64(0.1),
    }
}

/// A coupling with a damping ratio of a half and a natural frequency of one radian in `period` `[s]`.
pub fn coupling<S: Scalar>(stiffness: S, period: S) -> VirtualCouplingParams<S> {
    VirtualCouplingParams {
        stiffness,
        damping: stiffness * period,
        mass: stiffness * period * period,
    }
}

/// The device as a point mass, moved exactly while the force is held.
#[derive(Clone, Copy)]
pub struct PointMass {
    pub mass: f64,
    pub user_force: f64,
    pub position: f64,
    pub velocity: f64,
}

impl PointMass {
    pub fn hold(&mut self, force_on_device: f64, time: f64) {
        let acceleration = (self.user_force + force_on_device) / self.mass;
        self.position += (self.velocity + 0.5 * acceleration * time) * time;
        self.velocity += acceleration * time;
    }

    /// Holds a line of this mean over `time` and returns the work of the force on the object through the port.
    pub fn hold_line(&mut self, force_on_device: f64, slope: f64, time: f64) -> f64 {
        let (from, speed) = (self.position, self.velocity);
        self.hold(force_on_device, time);
        self.position -= slope * time.powi(3) / (12.0 * self.mass);
        // The slope does work on the linear part of the velocity only.
        let accelerated = (self.velocity - speed) / time;
        let of_slope = slope * time.powi(3) / 12.0 * accelerated;
        -(force_on_device * (self.position - from) + of_slope)
    }
}

/// SplitMix64: a known, small, platform-independent generator.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        let index = self.bits() % u64::try_from(of.len()).unwrap();
        of[usize::try_from(index).unwrap()]
    }
}

pub fn every_number_is_finite<S: Scalar>(output: &Output<S>) -> bool {
    [
        output.force_on_device,
        output.force_on_object,
        output.object_position,
        output.object_velocity,
        output.penetration,
        output.transition_after,
        output.slope_on_device,
    ]
    .iter()
    .all(|number| number.is_finite())
}

pub fn entries<S: Scalar>(ledger: &Ledger<S>) -> [S; 10] {
    let (original, held) = (&ledger.original_leak, &ledger.held_leak);
    [
        ledger.stored,
        ledger.port_work,
        ledger.virtual_force_work,
        ledger.outside_work,
        original.last,
        original.accumulated,
        original.absolute,
        held.last,
        held.accumulated,
        held.absolute,
    ]
}

/// Right-hand side of the ledger equation: the change of the stored energy by the entries.
pub fn explained<S: Scalar>(ledger: &Ledger<S>) -> f64 {
    [
        ledger.port_work,
        ledger.virtual_force_work,
        ledger.outside_work,
        ledger.held_leak.accumulated,
    ]
    .iter()
    .map(|entry| entry.to_f64())
    .sum()
}

/// Independent energy ledger, computed from samples and outputs only.
pub struct Auditor {
    stiffness: f64,
    /// Largest force of the contact, at which it yields `[N]`.
    largest: f64,
    mass: f64,
    last: Option<(Sample<f64>, Output<f64>)>,
    pub stored: f64,
    pub port_work: f64,
    pub virtual_force_work: f64,
    pub held_leak: f64,
    pub held_leak_absolute: f64,
    pub original_leak: f64,
    /// Sum of the absolute values of all entries.
    pub turned_over: f64,
    /// Error of the auditor's own sums by the rounding of the positions.
    rounding: f64,
}

impl Auditor {
    pub fn new(contact: &Contact<f64>) -> Self {
        let mass = match contact.object_mass {
            Mass::Finite(mass) => mass,
            Mass::Infinite => 0.0,
        };
        Self {
            stiffness: contact.stiffness,
            largest: f64::INFINITY,
            mass,
            last: None,
            stored: 0.0,
            port_work: 0.0,
            virtual_force_work: 0.0,
            held_leak: 0.0,
            held_leak_absolute: 0.0,
            original_leak: 0.0,
            turned_over: 0.0,
            rounding: 0.0,
        }
    }

    /// Returns the auditor of a contact that yields to a force limit, as a wall and any object of coupled rendering do.
    pub fn yielding_to(self, largest: f64) -> Self {
        Self { largest, ..self }
    }

    /// Returns the spring's force at a penetration, and its stored energy.
    fn spring(&self, penetration: f64) -> (f64, f64) {
        let force = (self.stiffness * penetration.max(0.0)).min(self.largest);
        // The area below the force, a rectangle beyond the penetration of the largest force.
        let beyond = (penetration.max(0.0) - force / self.stiffness).max(0.0);
        (force, 0.5 * force * force / self.stiffness + force * beyond)
    }

    /// Records a sample. Valid for the positive side without faults.
    pub fn observe(&mut self, sample: Sample<f64>, output: Output<f64>) {
        assert_eq!(output.fault, None);
        let penetration = sample.device_position - output.object_position;
        let (_, elastic) = self.spring(penetration);
        let stored = 0.5 * self.mass * output.object_velocity.powi(2) + elastic;
        if let Some((before, held)) = self.last {
            let moved = sample.device_position - before.device_position;
            let port = held.force_on_object * moved;
            // No force moves a wall, although a method may shift it.
            let moves = f64::from(self.mass > 0.0);
            let virtual_work =
                moves * before.virtual_force * (output.object_position - held.object_position);
            let (spring, _) = self.spring(before.device_position - held.object_position);
            let leak = stored - self.stored - virtual_work - port;
            self.port_work += port;
            self.virtual_force_work += virtual_work;
            self.held_leak += leak;
            self.held_leak_absolute += leak.abs();
            self.original_leak += stored - self.stored - virtual_work - spring * moved;
            self.rounding += f64::EPSILON
                * (sample.device_position.abs() + output.object_position.abs())
                * (held.force_on_object.abs() + before.virtual_force.abs() + spring);
            self.turned_over += port.abs() + virtual_work.abs() + (stored - self.stored).abs();
        }
        self.turned_over = self.turned_over.max(stored);
        self.stored = stored;
        self.last = Some((sample, output));
    }

    /// Checks that every entry of the ledger equals the audited one within `tolerance` of the energy turned over.
    pub fn agrees_with(&self, ledger: &Ledger<f64>, tolerance: f64) {
        for (name, audited, recorded) in [
            ("stored", self.stored, ledger.stored),
            ("port work", self.port_work, ledger.port_work),
            (
                "virtual work",
                self.virtual_force_work,
                ledger.virtual_force_work,
            ),
            ("held leak", self.held_leak, ledger.held_leak.accumulated),
            (
                "absolute held leak",
                self.held_leak_absolute,
                ledger.held_leak.absolute,
            ),
            (
                "original leak",
                self.original_leak,
                ledger.original_leak.accumulated,
            ),
        ] {
            assert!(
                (audited - recorded).abs() <= tolerance * self.turned_over + 4.0 * self.rounding,
                "{name}: booked {recorded}, audited {audited}, turned over {}",
                self.turned_over
            );
        }
    }
}
