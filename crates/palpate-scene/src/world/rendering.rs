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
        match self.render.force_limit {
            Some(limit) => in_loop.with_force_limits(vec![limit; self.devices.len()]),
            None => in_loop,
        }
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
                Ok(VirtualCouplingParams {
                    stiffness: vec![stiffness; tools],
                    damping: vec![damping; tools],
                    mass: vec![mass; tools],
                }
                .into())
            }
            "coupled" => {
                let quanta = self.devices.iter().flat_map(|device| device.quantum);
                let quantum = quanta.fold(0.0, f64::max);
                let params = CoupledParams::new(self.render.device_mass.clone());
                Ok(params.with_encoder_quantum(quantum).into())
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
