//! Linkages: pantographs that replace a point mass.

use palpate_testbed::InvalidParameter;
use palpate_testbed::pantograph::{Actuation, Pantograph, PantographParams, Pid, SafetyBox};

/// The committed devices by the names that scenes know them by.
const PRESETS: [(&str, &str); 4] = [
    ("paper-like", include_str!("../devices/paper-like.toml")),
    ("2diy-gen1", include_str!("../devices/haply-2diy-gen1.toml")),
    ("2diy-gen2", include_str!("../devices/haply-2diy-gen2.toml")),
    ("2diy-gen3", include_str!("../devices/haply-2diy-gen3.toml")),
];

/// Point of action of the hand's constant force on a pantograph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HandForceAt {
    /// The end-point itself, in continuous time.
    #[default]
    EndPoint,
    /// In the motors, as joint torques: by the Jacobian of the pose that the encoders report at a
    /// sample, held over the period, within the motors' range, and none outside the safety box.
    Motors,
}

impl HandForceAt {
    /// Its name in scene files and flags.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::EndPoint => "end-point",
            Self::Motors => "motors",
        }
    }
}

/// A five-bar pantograph as a device file describes it. The contact acts along its y axis, counted
/// from its home pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    /// A line for tables.
    pub title: String,
    /// Mechanism, motors and encoders.
    pub params: PantographParams,
    /// The controller that holds x; its target counts from home.
    pub hold_x: Option<Pid>,
    /// Region in which the motors stay connected, relative to the home position.
    pub safety_box: Option<SafetyBox>,
    /// Every key of its file and its value, as text.
    pub keys: Vec<(String, String)>,
}

impl Linkage {
    /// Names of the committed devices.
    pub fn presets() -> impl Iterator<Item = &'static str> {
        PRESETS.iter().map(|(name, _)| *name)
    }

    /// A committed device by its name.
    ///
    /// # Panics
    /// Never: the committed files are read in a test.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        let (name, source) = PRESETS.iter().find(|(known, _)| *known == name)?;
        Some(Self::parse(name, source).expect("the committed device files are good"))
    }

    /// Returns the same linkage with another safety box, relative to the home position.
    #[must_use]
    pub fn in_box(mut self, bounds: SafetyBox) -> Self {
        let text = |[low, high]: [f64; 2]| format!("[{low}, {high}]");
        self.keys.retain(|(key, _)| !key.starts_with("safety_box."));
        self.keys.push(("safety_box.x_m".into(), text(bounds.x)));
        self.keys.push(("safety_box.y_m".into(), text(bounds.y)));
        self.safety_box = Some(bounds);
        self
    }

    /// The committed device that this one is, by its name, if it is one but for its safety box; and
    /// that box if it is another.
    pub(crate) fn as_preset(&self) -> Option<(&'static str, Option<SafetyBox>)> {
        PRESETS.iter().find_map(|&(name, _)| {
            let preset = Self::preset(name)?;
            if preset == *self {
                return Some((name, None));
            }
            let bounds = self.safety_box?;
            (preset.in_box(bounds) == *self).then_some((name, Some(bounds)))
        })
    }

    /// End-point in the home pose `[m]`.
    pub fn home(&self) -> Result<[f64; 2], InvalidParameter> {
        Ok(Pantograph::new(self.params)?.end_point())
    }

    /// The device at rest, `offset` `[m]` along y from home, pushed along y by `user_force` `[N]`,
    /// which acts `at` a place. `ideal` is without the limits of its motors and without the safety box.
    pub fn device(
        &self,
        offset: f64,
        (user_force, at): (f64, HandForceAt),
        ideal: bool,
    ) -> Result<Pantograph, InvalidParameter> {
        let mut params = self.params;
        if ideal {
            params.actuation = Actuation::Ideal;
        }
        let [x, y] = self.home()?;
        let no_pose = |_| InvalidParameter {
            name: "device position",
            value: offset,
            allowed: "within the linkage's reach",
        };
        let at_home = Pantograph::new(params)?;
        let angles = if offset == 0.0 {
            params.home
        } else {
            let elbows = at_home.pose().elbows();
            let inverse = params.geometry.inverse([x, y + offset], elbows);
            inverse.map_err(no_pose)?
        };
        let at_rest = at_home.starting_at(angles, [0.0, 0.0])?;
        let mut device = match at {
            HandForceAt::EndPoint => at_rest.with_user_force([0.0, user_force])?,
            HandForceAt::Motors => at_rest.with_user_force_by_motors([0.0, user_force])?,
        };
        if let Some(pid) = self.hold_x {
            device = device.with_pid(Pid {
                target: x + pid.target,
                ..pid
            })?;
        }
        if let Some(about_home) = self.safety_box.filter(|_| !ideal) {
            device = device.with_safety_box(SafetyBox {
                x: about_home.x.map(|bound| x + bound),
                y: about_home.y.map(|bound| y + bound),
            })?;
        }
        Ok(device)
    }

    /// Effective mass along y `[kg]`, `offset` `[m]` along y from home.
    ///
    /// # Errors
    /// An offset that the linkage cannot reach.
    pub fn effective_mass(&self, offset: f64) -> Result<f64, InvalidParameter> {
        let unpushed = (0.0, HandForceAt::EndPoint);
        Ok(self.device(offset, unpushed, true)?.effective_mass_y())
    }
}
