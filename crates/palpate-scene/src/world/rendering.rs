//! From a world's scene to its renderer.

use palpate::Actuation;
use palpate_world::{
    BasicParams, CoupledParams, Place, VirtualCouplingParams, WorldError, WorldLoop, WorldMethod,
    WorldRenderer,
};

use super::{WorldActuator, WorldScene};
use crate::method::nearest;

impl WorldScene {
    /// Names of the methods that render worlds.
    pub const METHODS: [&str; 4] = ["basic", "virtual-damper", "virtual-coupling", "coupled"];

    /// The loop as a renderer is told it.
    #[must_use]
    pub fn in_loop(&self) -> WorldLoop {
        let WorldActuator { delay, lag, gain } = self.render.actuator;
        let actuation = Actuation {
            delay,
            lag,
            gain,
            ..Actuation::default()
        };
        let in_loop = WorldLoop::new(self.timing.period).with_actuation(actuation);
        let each =
            |limit: Option<f64>| limit.map_or(Vec::new(), |limit| vec![limit; self.devices.len()]);
        in_loop
            .with_force_limits(each(self.render.force_limit))
            .with_torque_limits(each(self.render.torque_limit))
    }

    /// The method of that name, with the scene's settings.
    ///
    /// # Errors
    /// There is no method of that name, or it lacks a setting.
    pub fn method(&self, name: &str) -> Result<WorldMethod, WorldError> {
        let tools = self.devices.len();
        match name {
            "basic" => Ok(BasicParams::default().into()),
            "virtual-damper" => match self.render.damping {
                Some(damping) => Ok(BasicParams {
                    damping: vec![damping; tools],
                    rotational_damping: vec![self.render.rotational_damping.unwrap_or(0.0); tools],
                }
                .into()),
                None => Err(fault("virtual-damper needs damping_n_s_per_m")),
            },
            "virtual-coupling" => {
                let coupling = self.render.coupling;
                let all = (self.render.damping, coupling.stiffness, coupling.mass);
                let (Some(damping), Some(stiffness), Some(mass)) = all else {
                    return Err(fault(
                        "virtual-coupling needs coupling_stiffness_n_per_m, coupling_mass_kg and damping_n_s_per_m",
                    ));
                };
                let mut params = VirtualCouplingParams {
                    stiffness: vec![stiffness; tools],
                    damping: vec![damping; tools],
                    mass: vec![mass; tools],
                    ..VirtualCouplingParams::default()
                };
                if self.devices.iter().any(|device| device.turning.is_some()) {
                    let damping = self.render.rotational_damping;
                    let all = (damping, coupling.rotational_stiffness, coupling.inertia);
                    let (Some(damping), Some(stiffness), Some(inertia)) = all else {
                        return Err(fault(
                            "virtual-coupling of a device of six axes needs \
                             coupling_rotational_stiffness_n_m_per_rad, coupling_inertia_kg_m2 and \
                             rotational_damping_n_m_s_per_rad",
                        ));
                    };
                    params.rotational_stiffness = vec![stiffness; tools];
                    params.rotational_damping = vec![damping; tools];
                    params.inertia = vec![inertia; tools];
                }
                Ok(params.into())
            }
            "coupled" => {
                let quanta = self.devices.iter().flat_map(|device| device.quantum);
                let quantum = quanta.fold(0.0, f64::max);
                let params = CoupledParams::new(self.render.device_mass.clone());
                let turnings = self.devices.iter().filter_map(|device| device.turning);
                let angle = turnings.map(|turning| turning.quantum).fold(0.0, f64::max);
                let inertia = self.render.device_inertia.iter();
                // What is said of a device of three axes is not looked at.
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

    /// The renderer of this world by the method of that name.
    ///
    /// # Errors
    /// Everything that is wrong with the method, or with the world for it: at least one fault.
    pub fn renderer(&self, method: &str) -> Result<WorldRenderer, Vec<WorldError>> {
        let method = self.method(method).map_err(|fault| vec![fault])?;
        WorldRenderer::new(&self.world, self.in_loop(), method)
    }
}

fn fault(message: &str) -> WorldError {
    WorldError::new(Place::Method, "method", "the method", message)
}
