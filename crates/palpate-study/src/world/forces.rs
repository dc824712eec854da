//! Forces of a world's devices as CSV.

use std::io::Write;

use crate::sim::world::WorldRun;
use palpate_scene::world::WorldScene;
use palpate_world::Tool;

/// Writes a row per method, sample and device: its position and the commanded force, also its orientation if it
/// rotates, and its torque if it has one.
///
/// # Errors
/// The writer fails.
pub fn write(writer: &mut dyn Write, scene: &WorldScene, runs: &[WorldRun]) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let turns = scene.devices.iter().any(|device| device.turning.is_some());
    let mut header = vec![
        "method", "device", "t_s", "x_m", "y_m", "z_m", "fx_n", "fy_n", "fz_n",
    ];
    if turns {
        header.extend(["qw", "qx", "qy", "qz"]);
    }
    let gives_torque = scene.world.tools.iter().any(Tool::feels_torque);
    if gives_torque {
        header.extend(["tx_n_m", "ty_n_m", "tz_n_m"]);
    }
    csv.write_record(header)?;
    for run in runs {
        for (sample, positions) in run.positions.iter().enumerate() {
            let time = sample as f64 * scene.timing.period;
            for (device, (tool, position)) in scene.world.tools.iter().zip(positions).enumerate() {
                let forces = &run.commanded[sample][device];
                let mut row = vec![run.method.clone(), tool.name.clone(), time.to_string()];
                row.extend(position.iter().chain(forces).map(ToString::to_string));
                if turns {
                    let orientation = &run.orientations[sample][device];
                    row.extend(orientation.iter().map(ToString::to_string));
                }
                if gives_torque {
                    let torques = &run.commanded_torques[sample][device];
                    row.extend(torques.iter().map(ToString::to_string));
                }
                csv.write_record(row)?;
            }
        }
    }
    csv.flush()
}
