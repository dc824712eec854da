//! Methods by name, and the settings each of them takes.

use std::fmt;
use std::str::FromStr;

use palpate::{
    AnyMethod, AnyParams, AnyRenderer, CoupledParams, DamperObject, EntryHold, HfcrParams,
    LeakDissipation, Mass, PopcParams, PopcRefParams, Prediction, SehEstimate, SehParams,
    VirtualDamperParams,
};
use serde::Deserialize;

/// A rendering method of the program, by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MethodName {
    /// Spring force of the sampled penetration.
    Basic,
    /// Spring and damper.
    VirtualDamper,
    /// Sample-estimate-hold.
    Seh,
    /// Passivity observer and controller.
    Popc,
    /// Reference energy following.
    PopcRef,
    /// HFCR's modified force alone: a step of the method, to compare with. Where the object is
    /// leaving while the device turns round, its force is not bounded.
    HfcrMod,
    /// HFCR's modified force with smooth transitions.
    HfcrModSt,
    /// HFCR with leak dissipation.
    Hfcr,
    /// Device and object predicted together, the mean of the contact force held: what renders where
    /// no method is named.
    #[default]
    Coupled,
}

impl MethodName {
    /// Every method, in the order of tables and figures.
    pub const ALL: [Self; 9] = [
        Self::Basic,
        Self::Seh,
        Self::VirtualDamper,
        Self::Popc,
        Self::PopcRef,
        Self::HfcrMod,
        Self::HfcrModSt,
        Self::Hfcr,
        Self::Coupled,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Basic => "basic",
            Self::VirtualDamper => "virtual-damper",
            Self::Seh => "seh",
            Self::Popc => "popc",
            Self::PopcRef => "popc-ref",
            Self::HfcrMod => "hfcr-mod",
            Self::HfcrModSt => "hfcr-mod-st",
            Self::Hfcr => "hfcr",
            Self::Coupled => "coupled",
        }
    }

    /// What it is, in a few words.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Basic => "spring force of the sampled penetration",
            Self::VirtualDamper => "spring and damper, the classic virtual coupling",
            Self::Seh => "sample-estimate-hold: extrapolated mean force",
            Self::Popc => "passivity observer and controller",
            Self::PopcRef => "passivity controller that follows a reference energy",
            Self::HfcrMod => "energy-consistent force",
            Self::HfcrModSt => "energy-consistent force, smooth transitions",
            Self::Hfcr => "energy-consistent force, smooth transitions, leak dissipation",
            Self::Coupled => "device and object predicted together, mean force held",
        }
    }

    /// Settings this method can use.
    pub fn uses(self, setting: Setting) -> bool {
        match setting {
            Setting::Damping => matches!(self, Self::VirtualDamper | Self::Hfcr),
            Setting::DampingCap | Setting::SpeedThreshold => {
                matches!(self, Self::Popc | Self::PopcRef)
            }
            Setting::InitialEnergy => self == Self::Popc,
            Setting::Estimate => self == Self::Seh,
            Setting::Prediction | Setting::LongestWindow => {
                matches!(self, Self::VirtualDamper | Self::Hfcr)
            }
            Setting::DamperObject => self == Self::VirtualDamper,
            Setting::EntryHold => matches!(self, Self::HfcrModSt | Self::Hfcr),
            Setting::Placement | Setting::Correction => self == Self::Coupled,
        }
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called \"{name}\"; {}", suggestion(.name))]
pub struct UnknownMethod {
    /// The name that was given.
    pub name: String,
}

fn suggestion(name: &str) -> String {
    let all = MethodName::ALL.map(MethodName::name);
    match nearest(name, &all) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("the methods are {}", all.join(", ")),
    }
}

/// The candidate that `name` most likely meant, if any is near.
pub fn nearest<'a>(name: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), *candidate))
        .filter(|(similarity, _)| *similarity > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

impl FromStr for MethodName {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Self::ALL
            .into_iter()
            .find(|method| method.name() == name)
            .ok_or_else(|| UnknownMethod { name: name.into() })
    }
}

/// A setting that some methods take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// B of the virtual damper, b of HFCR.
    Damping,
    /// alpha_max of the passivity controllers.
    DampingCap,
    /// v_eps of the passivity controllers.
    SpeedThreshold,
    /// E_0 of the passivity controller.
    InitialEnergy,
    /// Member of the SEH family.
    Estimate,
    /// How the virtual damper and HFCR predict the device.
    Prediction,
    /// Longest window of a prediction that has one.
    LongestWindow,
    /// What moves the object of the virtual damper.
    DamperObject,
    /// Where HFCR holds the device after an entry.
    EntryHold,
    /// Whether coupled rendering places the object.
    Placement,
    /// Whether coupled rendering predicts an interval anew when it has ended.
    Correction,
}

impl Setting {
    /// Every setting.
    pub const ALL: [Self; 11] = [
        Self::Damping,
        Self::DampingCap,
        Self::SpeedThreshold,
        Self::InitialEnergy,
        Self::Estimate,
        Self::Prediction,
        Self::LongestWindow,
        Self::DamperObject,
        Self::EntryHold,
        Self::Placement,
        Self::Correction,
    ];

    /// Its key in a scene file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Damping => "damping_n_s_per_m",
            Self::DampingCap => "damping_cap_n_s_per_m",
            Self::SpeedThreshold => "speed_threshold_m_per_s",
            Self::InitialEnergy => "initial_energy_j",
            Self::Estimate => "estimate",
            Self::Prediction => "prediction",
            Self::LongestWindow => "longest_window_s",
            Self::DamperObject => "damper_object",
            Self::EntryHold => "entry_hold",
            Self::Placement => "placement",
            Self::Correction => "correction",
        }
    }

    /// Names of the methods that take it, joined by commas.
    pub fn users(self) -> String {
        let users: Vec<_> = MethodName::ALL
            .into_iter()
            .filter(|method| method.uses(self))
            .map(MethodName::name)
            .collect();
        users.join(", ")
    }
}

/// A damping `[N s/m]`, or the choice to derive it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// A given value `[N s/m]`.
    Value(f64),
    /// Derived from stiffness, period and masses; HFCR only.
    Auto,
}

/// Settings of a method; what is `None` takes its default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(from = "crate::file::RawSettings")]
pub struct Settings {
    /// B of the virtual damper (default K T/2, which makes up for the half period the hold lags
    /// on a wall), or b of HFCR (default 0) `[N s/m]`.
    pub damping: Option<Damping>,
    /// alpha_max of the passivity controllers `[N s/m]`; default 3 K T.
    pub damping_cap: Option<f64>,
    /// v_eps of the passivity controllers `[m/s]`; default 1e-4.
    pub speed_threshold: Option<f64>,
    /// E_0 of the passivity controller `[J]`; default: what the object stores at the start.
    pub initial_energy: Option<f64>,
    /// Member of the SEH family; default AB2.
    pub estimate: Option<SehEstimate>,
    /// How the virtual damper and HFCR predict the device; default by its last step.
    pub prediction: Option<Predictor>,
    /// Longest window of first-order adaptive windowing `[s]`; default 15 periods.
    pub longest_window: Option<f64>,
    /// What moves the object of the virtual damper; default spring and damper.
    pub damper_object: Option<DamperObject>,
    /// Where HFCR holds the device after an entry; default at the crossing.
    pub entry_hold: Option<EntryHold>,
    /// Whether coupled rendering places the object; default yes.
    pub placement: Option<bool>,
    /// Whether coupled rendering predicts an interval anew when it has ended; default yes.
    pub correction: Option<bool>,
}

/// How the virtual damper and HFCR predict the device: a [`Prediction`] without what it is derived
/// from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Predictor {
    /// At the velocity of its last step, as in the paper.
    #[serde(alias = "constant-velocity")]
    LastStep,
    /// At the velocity of first-order adaptive windowing, whose noise bound is the sensor's quantum.
    FirstOrderAdaptiveWindow,
    /// At constant acceleration, through the last three samples.
    Extrapolation,
    /// By the observer of coupled rendering.
    Observer,
}

impl Predictor {
    /// Every choice.
    pub const ALL: [Self; 4] = [
        Self::LastStep,
        Self::FirstOrderAdaptiveWindow,
        Self::Extrapolation,
        Self::Observer,
    ];

    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::LastStep => "last-step",
            Self::FirstOrderAdaptiveWindow => "first-order-adaptive-window",
            Self::Extrapolation => "extrapolation",
            Self::Observer => "observer",
        }
    }
}

/// Periods in the longest window of first-order adaptive windowing where nothing is said.
const PERIODS_OF_WINDOW: f64 = 15.0;

impl Settings {
    /// Whether a value was given for `setting`.
    pub fn has(&self, setting: Setting) -> bool {
        match setting {
            Setting::Damping => self.damping.is_some(),
            Setting::DampingCap => self.damping_cap.is_some(),
            Setting::SpeedThreshold => self.speed_threshold.is_some(),
            Setting::InitialEnergy => self.initial_energy.is_some(),
            Setting::Estimate => self.estimate.is_some(),
            Setting::Prediction => self.prediction.is_some(),
            Setting::LongestWindow => self.longest_window.is_some(),
            Setting::DamperObject => self.damper_object.is_some(),
            Setting::EntryHold => self.entry_hold.is_some(),
            Setting::Placement => self.placement.is_some(),
            Setting::Correction => self.correction.is_some(),
        }
    }

    /// These settings, and where one is missing, that of `others`.
    pub fn or(self, others: Self) -> Self {
        Self {
            damping: self.damping.or(others.damping),
            damping_cap: self.damping_cap.or(others.damping_cap),
            speed_threshold: self.speed_threshold.or(others.speed_threshold),
            initial_energy: self.initial_energy.or(others.initial_energy),
            estimate: self.estimate.or(others.estimate),
            prediction: self.prediction.or(others.prediction),
            longest_window: self.longest_window.or(others.longest_window),
            damper_object: self.damper_object.or(others.damper_object),
            entry_hold: self.entry_hold.or(others.entry_hold),
            placement: self.placement.or(others.placement),
            correction: self.correction.or(others.correction),
        }
    }
}

/// What the parameters of a method are derived from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Contact stiffness `[N/m]`.
    pub stiffness: f64,
    /// Loop period `[s]`.
    pub period: f64,
    /// Effective mass of the device, if known `[kg]`.
    pub device_mass: Option<f64>,
    /// Quantum of the device's position sensor, 0 if it is not known to have one `[m]`.
    pub encoder_quantum: f64,
    /// Whether a recording moves the device, so that no force can.
    pub recorded: bool,
    /// Energy the object stores at the start `[J]`.
    pub stored_energy: f64,
}

impl Basis {
    /// The mass that the contact force has to move.
    fn pushed_mass(&self, method: MethodName) -> Result<Mass<f64>, SettingsError> {
        match self.device_mass {
            _ if self.recorded => Ok(Mass::Infinite),
            Some(mass) => Ok(Mass::Finite(mass)),
            None => Err(SettingsError::NoPushedMass(method)),
        }
    }
}

/// Settings that do not make a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    /// The method has no use for a setting.
    #[error("{method} cannot use it")]
    Unused {
        /// The method.
        method: MethodName,
        /// The setting it cannot use.
        setting: Setting,
    },
    /// Derived damping, but of a method that has no rule for it.
    #[error("only hfcr derives its damping; give {0} a number")]
    NoAutomaticDamping(MethodName),
    /// Derived damping without the device's mass.
    #[error("deriving the damping needs the device's effective mass")]
    NoDeviceMass,
    /// A method that predicts the device, without the device's mass.
    #[error("{0} needs the device's effective mass, within a factor of 2")]
    NoPushedMass(MethodName),
    /// A longest window for a prediction that has no window.
    #[error(
        "longest_window_s is for prediction first-order-adaptive-window, but that of {0} is {name}",
        name = .1.name()
    )]
    NoWindow(MethodName, Predictor),
}

impl MethodName {
    /// The first of the settings that this method has no use for.
    pub fn unused(self, settings: &Settings) -> Option<Setting> {
        Setting::ALL
            .into_iter()
            .find(|setting| settings.has(*setting) && !self.uses(*setting))
    }

    /// The method's parameters, with defaults for all settings that are missing.
    ///
    /// # Errors
    /// A setting the method cannot use; a damping to be derived without a rule or a device mass.
    pub fn params(
        self,
        settings: &Settings,
        basis: &Basis,
    ) -> Result<AnyParams<f64>, SettingsError> {
        if let Some(setting) = self.unused(settings) {
            return Err(SettingsError::Unused {
                method: self,
                setting,
            });
        }
        let impedance = basis.stiffness * basis.period;
        let cap = settings.damping_cap.unwrap_or(3.0 * impedance);
        Ok(match self {
            Self::Basic => AnyParams::Basic,
            Self::VirtualDamper => AnyParams::VirtualDamper(VirtualDamperParams {
                object: settings.damper_object.unwrap_or_default(),
                prediction: self.prediction(settings, basis)?,
                damping: match settings.damping {
                    None => 0.5 * impedance,
                    Some(Damping::Value(damping)) => damping,
                    Some(Damping::Auto) => return Err(SettingsError::NoAutomaticDamping(self)),
                },
            }),
            Self::Seh => AnyParams::Seh(SehParams {
                estimate: settings.estimate.unwrap_or_default(),
            }),
            Self::Popc => {
                let defaults = PopcParams::new(cap);
                AnyParams::Popc(PopcParams {
                    speed_threshold: settings.speed_threshold.unwrap_or(defaults.speed_threshold),
                    initial_energy: settings.initial_energy.unwrap_or(basis.stored_energy),
                    ..defaults
                })
            }
            Self::PopcRef => {
                let defaults = PopcRefParams::new(cap);
                AnyParams::PopcRef(PopcRefParams {
                    speed_threshold: settings.speed_threshold.unwrap_or(defaults.speed_threshold),
                    ..defaults
                })
            }
            Self::HfcrMod => AnyParams::Hfcr(HfcrParams::modified_force_only()),
            Self::HfcrModSt => AnyParams::Hfcr(HfcrParams {
                entry_hold: settings.entry_hold.unwrap_or_default(),
                ..HfcrParams::default()
            }),
            Self::Hfcr => AnyParams::Hfcr(HfcrParams {
                leak_dissipation: match settings.damping {
                    None => LeakDissipation::Off,
                    Some(Damping::Value(damping)) => LeakDissipation::Damping(damping),
                    Some(Damping::Auto) => LeakDissipation::Auto {
                        device_mass: basis.device_mass.ok_or(SettingsError::NoDeviceMass)?,
                    },
                },
                prediction: self.prediction(settings, basis)?,
                entry_hold: settings.entry_hold.unwrap_or_default(),
                ..HfcrParams::default()
            }),
            Self::Coupled => AnyParams::Coupled(CoupledParams {
                device_mass: basis.pushed_mass(self)?,
                encoder_quantum: basis.encoder_quantum,
                placement: settings.placement.unwrap_or(true),
                correction: settings.correction.unwrap_or(true),
            }),
        })
    }
}

impl MethodName {
    /// How this method predicts the device.
    fn prediction(
        self,
        settings: &Settings,
        basis: &Basis,
    ) -> Result<Prediction<f64>, SettingsError> {
        let predictor = settings.prediction.unwrap_or(Predictor::LastStep);
        if settings.longest_window.is_some() && predictor != Predictor::FirstOrderAdaptiveWindow {
            return Err(SettingsError::NoWindow(self, predictor));
        }
        Ok(match predictor {
            Predictor::LastStep => Prediction::LastStep,
            Predictor::FirstOrderAdaptiveWindow => Prediction::FirstOrderAdaptiveWindow {
                noise_bound: basis.encoder_quantum,
                longest_window: settings
                    .longest_window
                    .unwrap_or(PERIODS_OF_WINDOW * basis.period),
            },
            Predictor::Extrapolation => Prediction::Extrapolation,
            Predictor::Observer => Prediction::Observer {
                device_mass: basis.pushed_mass(self)?,
                encoder_quantum: basis.encoder_quantum,
            },
        })
    }
}

/// Parameters of a renderer with the value in place of a choice to derive it.
pub fn with_derived_values(params: AnyParams<f64>, renderer: &AnyRenderer<f64>) -> AnyParams<f64> {
    match (params, renderer.method()) {
        (AnyParams::Hfcr(hfcr), AnyMethod::Hfcr(method))
            if hfcr.leak_dissipation != LeakDissipation::Off =>
        {
            AnyParams::Hfcr(HfcrParams {
                leak_dissipation: LeakDissipation::Damping(method.damping()),
                ..hfcr
            })
        }
        (params, _) => params,
    }
}

impl<'de> Deserialize<'de> for MethodName {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}
