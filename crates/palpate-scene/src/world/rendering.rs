//! Construction of a world's renderer from its scene.

use palpate_world::{
    BasicParams, CoupledParams, GodObjectParams, HfcrParams, PopcParams, SehParams, Tool,
    VirtualCouplingParams, WorldError, WorldErrors, WorldField, WorldGuard, WorldLoop, WorldMethod,
    WorldPart, WorldRenderer,
};

use super::{Coupling, WorldScene};
use crate::method::nearest;

/// Settings of a method for comparison, the same for every device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSettings {
    /// Damping `[N s/m]`.
    pub damping: Option<f64>,
    /// Rotational damping `[N m s/rad]`.
    pub rotational_damping: Option<f64>,
    /// The virtual coupling.
    pub coupling: Coupling,
    /// Largest damping that a passivity controller injects `[N s/m]`.
    pub damping_cap: Option<f64>,
    /// Speed up to which a passivity controller does not act `[m/s]`.
    pub speed_threshold: Option<f64>,
    /// Energy that `popc` lets a device give out `[J]`.
    pub initial_energy: Option<f64>,
}

impl WorldSettings {
    /// Returns the method of that name for a number of tools; `feels_torque` states whether one of them gives a torque.
    /// `None`: these settings have no method of that name.
    ///
    /// # Errors
    /// The method lacks a setting.
    pub fn method(
        &self,
        name: &str,
        tools: usize,
        feels_torque: bool,
    ) -> Result<Option<WorldMethod>, WorldError> {
        let each = |value: f64| vec![value; tools];
        let coupling = self.coupling;
        Ok(Some(match name {
            "basic" => BasicParams::default().into(),
            "virtual-damper" => match self.damping {
                Some(damping) => BasicParams {
                    damping: each(damping),
                    rotational_damping: each(self.rotational_damping.unwrap_or(0.0)),
                }
                .into(),
                None => return Err(fault("virtual-damper needs damping_n_s_per_m")),
            },
            "seh" => SehParams.into(),
            "popc" | "popc-ref" => {
                let Some(cap) = self.damping_cap else {
                    return Err(fault(&format!("{name} needs damping_cap_n_s_per_m")));
                };
                let usual = PopcParams::new(each(cap));
                PopcParams {
                    speed_threshold: self.speed_threshold.unwrap_or(usual.speed_threshold),
                    initial_energy: self.initial_energy.unwrap_or(usual.initial_energy),
                    follows_reference: name == "popc-ref",
                    ..usual
                }
                .into()
            }
            "hfcr-mod" => HfcrParams::modified_force_only().into(),
            "hfcr-mod-st" => HfcrParams::default().into(),
            "hfcr" => HfcrParams {
                damping: self.damping.map(each).unwrap_or_default(),
                ..HfcrParams::default()
            }
            .into(),
            "virtual-coupling" => {
                let all = (self.damping, coupling.stiffness, coupling.mass);
                let (Some(damping), Some(stiffness), Some(mass)) = all else {
                    return Err(fault(
                        "virtual-coupling needs coupling_stiffness_n_per_m, coupling_mass_kg and damping_n_s_per_m",
                    ));
                };
                let mut params = VirtualCouplingParams {
                    stiffness: each(stiffness),
                    damping: each(damping),
                    mass: each(mass),
                    ..VirtualCouplingParams::default()
                };
                if feels_torque {
                    let damping = self.rotational_damping;
                    let all = (damping, coupling.rotational_stiffness, coupling.inertia);
                    let (Some(damping), Some(stiffness), Some(inertia)) = all else {
                        return Err(fault(
                            "virtual-coupling of a device of six axes needs \
                             coupling_rotational_stiffness_n_m_per_rad, coupling_inertia_kg_m2 and \
                             rotational_damping_n_m_s_per_rad",
                        ));
                    };
                    params.rotational_stiffness = each(stiffness);
                    params.rotational_damping = each(damping);
                    params.inertia = each(inertia);
                }
                params.into()
            }
            "god-object" => {
                let (Some(damping), Some(stiffness)) = (self.damping, coupling.stiffness) else {
                    return Err(fault(
                        "god-object needs coupling_stiffness_n_per_m and damping_n_s_per_m",
                    ));
                };
                GodObjectParams {
                    stiffness: each(stiffness),
                    damping: each(damping),
                }
                .into()
            }
            _ => return Ok(None),
        }))
    }
}

impl WorldScene {
    /// Sets the largest force `[N]` and the largest torque `[N m]` on each device: from `asked`, else from the scene,
    /// else from `usual` and the weakest motor. Infinity means unlimited. If neither `asked` nor the scene gives a
    /// torque, an unlimited force implies an unlimited torque.
    pub fn settle_limits(&mut self, asked: [Option<f64>; 2], usual: [f64; 2]) {
        let motors = self.devices.iter();
        let motors = motors.map(|device| device.drivetrain.largest_force);
        let usual_force = motors.fold(usual[0], f64::min);
        let render = &mut self.render;
        let [force, torque] = asked;
        let finite = |limit: &f64| *limit != f64::INFINITY;
        let force = force.or(render.force_limit).unwrap_or(usual_force);
        render.force_limit = Some(force).filter(finite);
        let usual = render.force_limit.map(|_| usual[1]);
        let torque = torque.or(render.torque_limit).or(usual);
        render.torque_limit = torque.filter(finite);
    }
}

/// Tolerance on the cosine between an axis of a device and an equal axis of the world.
const ALONG: f64 = 1e-9;

impl WorldScene {
    /// Names of the methods that render worlds.
    pub const METHODS: [&str; 11] = [
        "basic",
        "virtual-damper",
        "seh",
        "popc",
        "popc-ref",
        "hfcr-mod",
        "hfcr-mod-st",
        "hfcr",
        "virtual-coupling",
        "god-object",
        "coupled",
    ];

    /// Returns the settings of the method of that name; missing keys are `None`.
    #[must_use]
    pub fn settings(&self, method: &str) -> WorldSettings {
        self.render
            .settings
            .get(method)
            .copied()
            .unwrap_or_default()
    }

    /// Returns the scene with position-driven devices that follow a recorded motion. The renderer's model has infinite
    /// mass and inertia, and no guard.
    #[must_use]
    pub fn led(&self) -> Self {
        let mut scene = self.clone();
        for mass in &mut scene.render.device_mass {
            *mass = [f64::INFINITY; 3];
        }
        for inertia in scene.render.device_inertia.iter_mut().flatten() {
            *inertia = [f64::INFINITY; 3];
        }
        // A guard is not needed for position-driven devices.
        scene.render.guard = WorldGuard::Off;
        scene
    }

    /// Returns the scene with device `number` restricted to the given world axes; its mechanism holds the tool along
    /// the others. If the scene gives the device its own axes, each of the held axes must be one of them. Otherwise the
    /// tool is left without an axis, which every renderer rejects.
    #[must_use]
    pub fn with_axes(mut self, number: usize, axes: [bool; 3]) -> Self {
        let (tool, device) = (
            self.world.tools.get_mut(number),
            self.devices.get_mut(number),
        );
        let (Some(tool), Some(device)) = (tool, device) else {
            return self;
        };
        for (of_world, has) in axes.into_iter().enumerate() {
            let axis = tool.own_axes.map_or(Some(of_world), |own| {
                (0..3).find(|&axis| own[axis][of_world].abs() > 1.0 - ALONG)
            });
            if has {
                continue;
            }
            let Some(axis) = axis else {
                tool.axes = [false; 3];
                break;
            };
            tool.axes[axis] = false;
            device.mass[axis] = f64::INFINITY;
            device.velocity[of_world] = 0.0;
            if let Some(model) = self.render.device_mass.get_mut(number) {
                model[axis] = f64::INFINITY;
            }
        }
        self
    }

    /// Returns the renderer's model of the loop.
    #[must_use]
    pub fn loop_params(&self) -> WorldLoop {
        let usual = WorldLoop::new(self.timing.period).with_actuation(self.render.actuation);
        let loop_params = WorldLoop {
            speed_limit: self.render.speed_limit.or(usual.speed_limit),
            largest_gap: self.render.largest_gap.or(usual.largest_gap),
            ..usual
        };
        let each =
            |limit: Option<f64>| limit.map_or(Vec::new(), |limit| vec![limit; self.devices.len()]);
        loop_params
            .with_force_limits(each(self.render.force_limit))
            .with_torque_limits(each(self.render.torque_limit))
            .with_guard(self.guard_of_devices())
            .with_guard_masses(self.guard_masses())
    }

    /// The method of that name, with the scene's settings.
    ///
    /// # Errors
    /// There is no method of that name, it lacks a setting, or it renders no such tool or no force fields.
    pub fn method(&self, name: &str) -> Result<WorldMethod, WorldError> {
        let method = self.with_settings(name)?;
        method.can_render(&self.world.fields)?;
        Ok(method)
    }

    fn with_settings(&self, name: &str) -> Result<WorldMethod, WorldError> {
        if name == "god-object" {
            for tool in &self.world.tools {
                GodObjectParams::can_render(tool)?;
            }
        }
        let feels_torque = self.world.tools.iter().any(Tool::feels_torque);
        let mut settings = self.settings(name);
        let laws = self.world.contacts.iter().map(|contact| contact.law);
        let stiffness = laws.map(|law| law.stiffness).fold(0.0, f64::max);
        // 3 K T, as for one contact along one axis.
        let cap = 3.0 * stiffness * self.timing.period;
        settings.damping_cap = settings.damping_cap.or(Some(cap).filter(|cap| *cap > 0.0));
        if let Some(method) = settings.method(name, self.devices.len(), feels_torque)? {
            return Ok(method);
        }
        match name {
            "coupled" => {
                let quanta = self.devices.iter().flat_map(|device| device.quantum);
                let quantum = quanta.fold(0.0, f64::max);
                let quantum = self.render.sensor_quantum.unwrap_or(quantum);
                let params = CoupledParams::new(self.render.device_mass.clone());
                let turnings = self.devices.iter().filter_map(|device| device.turning);
                let angle = turnings.map(|turning| turning.quantum).fold(0.0, f64::max);
                let inertia = self.render.device_inertia.iter();
                // The inertia of a three-axis device is ignored.
                let inertia = inertia.map(|inertia| inertia.unwrap_or([1.0; 3])).collect();
                let params = params
                    .with_device_inertia(inertia)
                    .with_encoder_quantum(quantum)
                    .with_angle_quantum(angle);
                Ok(params.into())
            }
            _ => {
                let all = Self::METHODS.join(", ");
                let near = nearest(name, &Self::METHODS);
                let meant =
                    near.map_or_else(|| ".".into(), |near| format!(", did you mean {near}?"));
                let message =
                    format!("there is no method {name:?} for worlds{meant} Known here: {all}");
                Err(fault(&message))
            }
        }
    }

    /// Creates the renderer of this world by the method of that name.
    ///
    /// # Errors
    /// All errors of the method, and of the world for this method: at least one.
    pub fn renderer(&self, method: &str) -> Result<WorldRenderer, WorldErrors> {
        WorldRenderer::new(&self.world, self.loop_params(), self.method(method)?)
    }
}

fn fault(message: &str) -> WorldError {
    WorldError::new(WorldPart::Method, WorldField::Method, "the method", message)
}
