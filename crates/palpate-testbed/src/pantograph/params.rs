//! What a pantograph is made of, and presets.

use super::kinematics::{Assembly, Geometry, Origin};
use crate::InvalidParameter;
use crate::error::{finite, positive};

/// One rigid link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass on the link's line, as a fraction of its length from the joint nearer to the
    /// motor; may lie outside 0 to 1 for a counterweight.
    pub centre: f64,
    /// Moment of inertia about the centre of mass \[kg m²\].
    pub inertia: f64,
}

impl Link {
    /// A uniform slender rod: centre in the middle, m s²/12 about it.
    #[must_use]
    pub const fn rod(mass: f64, length: f64) -> Self {
        Self {
            mass,
            centre: 0.5,
            inertia: mass * length * length / 12.0,
        }
    }
}

/// How forces at the end-point come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Actuation {
    /// The force itself acts on the end-point, exactly and without a limit.
    Ideal,
    /// Motor torques JᵀF from the true pose at the sample, limited and held.
    MotorsAtTruePose,
    /// Motor torques JᵀF from the pose that the encoders report at the sample, limited and held.
    #[default]
    MotorsAtMeasuredPose,
}

/// Mechanism, motors and encoders of a five-bar pantograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PantographParams {
    /// Lengths, assembly and origin.
    pub geometry: Geometry,
    /// Motor angles at the start \[rad\].
    pub home: [f64; 2],
    /// The links on motors 1 and 2.
    pub proximal: [Link; 2],
    /// The links from the elbows to the end-point.
    pub distal: [Link; 2],
    /// Moment of inertia of each rotor as felt at its joint (gear ratio squared) \[kg m²\].
    pub rotor_inertia: f64,
    /// Mass of handle and joint at the end-point \[kg\].
    pub end_point_mass: f64,
    /// Viscous friction of each motor joint \[N m s/rad\].
    pub viscous_friction: f64,
    /// Coulomb friction of each motor joint, sliding and sticking alike \[N m\].
    pub coulomb_friction: f64,
    /// Largest torque of each motor at its joint \[N m\]; infinite for no limit.
    pub max_torque: f64,
    /// Encoder counts per revolution of the joint; `None` measures exactly.
    pub counts_per_rev: Option<f64>,
    /// How forces come about.
    pub actuation: Actuation,
    /// Gravity \[m/s²\]; zero for a device that lies flat.
    pub gravity: [f64; 2],
}

impl PantographParams {
    /// The same parameters if every number is allowed. The home pose is checked by
    /// [`Pantograph::new`](super::Pantograph::new).
    ///
    /// # Errors
    ///
    /// The first number that is not allowed. A mass, an inertia or a friction may be zero, but
    /// some inertia must turn with each motor.
    pub fn checked(self) -> Result<Self, InvalidParameter> {
        self.geometry.checked()?;
        for angle in self.home {
            finite("home", angle, "finite [rad]")?;
        }
        for link in self.proximal.iter().chain(&self.distal) {
            at_least_zero("mass", link.mass, "finite and at least 0 kg")?;
            finite("centre", link.centre, "finite, a fraction of the length")?;
            at_least_zero("inertia", link.inertia, "finite and at least 0 kg m²")?;
        }
        at_least_zero(
            "rotor_inertia",
            self.rotor_inertia,
            "finite and at least 0 kg m²",
        )?;
        for link in self.proximal {
            let turning = self.rotor_inertia + link.inertia;
            positive(
                "rotor_inertia + inertia",
                turning,
                "above 0 kg m² for each motor",
            )?;
        }
        at_least_zero(
            "end_point_mass",
            self.end_point_mass,
            "finite and at least 0 kg",
        )?;
        at_least_zero(
            "viscous_friction",
            self.viscous_friction,
            "finite and at least 0 N m s/rad",
        )?;
        at_least_zero(
            "coulomb_friction",
            self.coulomb_friction,
            "finite and at least 0 N m",
        )?;
        InvalidParameter::unless(
            self.max_torque > 0.0,
            "max_torque",
            self.max_torque,
            "above 0 N m; infinite for no limit",
        )?;
        if let Some(counts) = self.counts_per_rev {
            positive("counts_per_rev", counts, "finite and above 0")?;
        }
        for g in self.gravity {
            finite("gravity", g, "finite [m/s²]")?;
        }
        Ok(self)
    }

    /// The same device without friction.
    #[must_use]
    pub fn frictionless(self) -> Self {
        Self {
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            ..self
        }
    }

    /// A desktop pantograph of 0.25 kg along y at its home pose, as in the experiments on
    /// coarsely sampled contact rendering.
    ///
    /// Only the 0.25 kg is published. Everything else is our choice: links of 0.12 m and 0.16 m
    /// with motors 0.05 m apart, at home with the proximal links at 130° and 50°; aluminium rods of
    /// 60 g and 50 g; rotors of 3e-5 kg m²; 20 000 counts/rev; 1 N m; little friction. The handle's
    /// mass is what is missing to 0.25 kg: in the symmetric pose it adds to the effective mass
    /// one for one.
    #[must_use]
    pub const fn paper_like() -> Self {
        let (l, distal) = (0.12, 0.16);
        Self {
            geometry: geometry(l, distal, 0.05, Origin::Centre),
            home: [degrees(130.0), degrees(50.0)],
            proximal: [Link::rod(0.060, l); 2],
            distal: [Link::rod(0.050, distal); 2],
            rotor_inertia: 3e-5,
            end_point_mass: 0.1525,
            viscous_friction: 5e-4,
            coulomb_friction: 1e-3,
            max_torque: 1.0,
            counts_per_rev: Some(20_000.0),
            actuation: Actuation::MotorsAtMeasuredPose,
            gravity: [0.0, 0.0],
        }
    }

    /// Haply 2DIY, first generation (kit of 2018), fully retracted.
    ///
    /// Published by the vendor's configuration code: l = 0.05 m, L = 0.07 m, d = 0.02 m, power-on
    /// angles 180° and 0°, 13 824 counts/rev, 0.123 N m. Masses and friction: see
    /// [`haply_gen3`](Self::haply_gen3).
    #[must_use]
    pub const fn haply_gen1() -> Self {
        haply(0.05, 0.07, 0.02, [180.0, 0.0], 13_824.0)
    }

    /// Haply 2DIY, second generation (motors on one axis), fully retracted.
    ///
    /// Published by the vendor's configuration code: l = 0.07 m, L = 0.09 m, d = 0, power-on angles
    /// 241° and −61°, 10 752 counts/rev, 0.123 N m. Masses and friction: see
    /// [`haply_gen3`](Self::haply_gen3).
    #[must_use]
    pub const fn haply_gen2() -> Self {
        haply(0.07, 0.09, 0.0, [241.0, -61.0], 10_752.0)
    }

    /// Haply 2DIY, generation 3, fully retracted, on its M0 board.
    ///
    /// Published by the vendor's configuration code: l = 0.07 m, L = 0.09 m, d = 0.038 m, power-on
    /// angles 168° and 12°, 0.123 N m, and 4880 counts/rev, of which the M0 board counts half.
    ///
    /// Masses and friction are not published. Ours are plausible for printed arms on direct-drive
    /// motors, and no more than that: rods of 0.3 kg/m, a handle of 15 g, rotors of 2e-6 kg m²,
    /// 2 mN m of Coulomb and 1e-4 N m s/rad of viscous friction.
    #[must_use]
    pub const fn haply_gen3() -> Self {
        haply(0.07, 0.09, 0.038, [168.0, 12.0], 2440.0)
    }
}

const fn haply(
    l: f64,
    distal: f64,
    base: f64,
    home_deg: [f64; 2],
    counts: f64,
) -> PantographParams {
    PantographParams {
        geometry: geometry(l, distal, base, Origin::Motor1),
        home: [degrees(home_deg[0]), degrees(home_deg[1])],
        proximal: [Link::rod(0.3 * l, l); 2],
        distal: [Link::rod(0.3 * distal, distal); 2],
        rotor_inertia: 2e-6,
        end_point_mass: 0.015,
        viscous_friction: 1e-4,
        coulomb_friction: 2e-3,
        max_torque: 0.123,
        counts_per_rev: Some(counts),
        actuation: Actuation::MotorsAtMeasuredPose,
        gravity: [0.0, 0.0],
    }
}

const fn geometry(proximal: f64, distal: f64, base: f64, origin: Origin) -> Geometry {
    Geometry {
        proximal,
        distal,
        base,
        assembly: Assembly::Far,
        origin,
    }
}

const fn degrees(angle: f64) -> f64 {
    angle * (std::f64::consts::PI / 180.0)
}

fn at_least_zero(
    name: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter> {
    InvalidParameter::unless(value.is_finite() && value >= 0.0, name, value, allowed)
}
