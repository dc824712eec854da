//! Linkages that scenes can use by name.

use palpate_testbed::InvalidParameter;
use palpate_testbed::pantograph::kinematics::ELBOWS_OUT;
use palpate_testbed::pantograph::{Actuation, Pantograph, PantographParams, Pid};
use serde::Deserialize;

/// A five-bar pantograph that lies flat. The contact acts along its y axis, counted from its home
/// pose; a PID controller holds x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Linkage {
    /// As in the paper's experiments: 0.25 kg along y at home.
    #[serde(rename = "paper-like")]
    PaperLike,
    /// Haply 2DIY, first generation.
    #[serde(rename = "2diy-gen1")]
    Haply1,
    /// Haply 2DIY, second generation.
    #[serde(rename = "2diy-gen2")]
    Haply2,
    /// Haply 2DIY, third generation.
    #[serde(rename = "2diy-gen3")]
    Haply3,
}

/// Gains of the controller of x: with 0.25 kg stable from 50 Hz on.
const HOLD_X: Pid = Pid {
    target: 0.0,
    proportional: 100.0,
    integral: 50.0,
    derivative: 3.0,
    max_force: 5.0,
};

impl Linkage {
    /// Its name in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::PaperLike => "paper-like",
            Self::Haply1 => "2diy-gen1",
            Self::Haply2 => "2diy-gen2",
            Self::Haply3 => "2diy-gen3",
        }
    }

    fn params(self) -> PantographParams {
        match self {
            Self::PaperLike => PantographParams::paper_like(),
            Self::Haply1 => PantographParams::haply_gen1(),
            Self::Haply2 => PantographParams::haply_gen2(),
            Self::Haply3 => PantographParams::haply_gen3(),
        }
    }

    /// End-point in the home pose `[m]`.
    pub(crate) fn home(self) -> Result<[f64; 2], InvalidParameter> {
        Ok(Pantograph::new(self.params())?.end_point())
    }

    /// The device at rest, `offset` `[m]` along y from home, pushed along y by `user_force` `[N]`.
    /// `ideal` is without the limits of its motors.
    pub(crate) fn device(
        self,
        offset: f64,
        user_force: f64,
        ideal: bool,
    ) -> Result<Pantograph, InvalidParameter> {
        let mut params = self.params();
        if ideal {
            params.actuation = Actuation::Ideal;
        }
        let [x, y] = self.home()?;
        let no_pose = |_| InvalidParameter {
            name: "device position",
            value: offset,
            allowed: "within the linkage's reach",
        };
        let angles = params
            .geometry
            .inverse([x, y + offset], ELBOWS_OUT)
            .map_err(no_pose)?;
        Pantograph::new(params)?
            .starting_at(angles, [0.0, 0.0])?
            .with_pid(Pid {
                target: x,
                ..HOLD_X
            })?
            .with_user_force([0.0, user_force])
    }

    /// Effective mass along y `[kg]`, `offset` `[m]` along y from home.
    ///
    /// # Errors
    /// An offset that the linkage cannot reach.
    pub fn effective_mass(self, offset: f64) -> Result<f64, InvalidParameter> {
        Ok(self.device(offset, 0.0, true)?.effective_mass_y())
    }
}
