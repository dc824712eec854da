//! All errors of a loop, its actuator and its transmission: position, message, and marked text.

use palpate_scene::ContactFile;

use crate::scene_files::GOOD;
use crate::scene_files::faults::assert_faults;

#[test]
fn the_imperfections_of_a_loop_have_ranges_and_belong_together() {
    assert_faults(
        r#"delay_samples = 0 -> delay_fraction = 1
  6:18: loop.delay_fraction is 1 periods, but must be from 0 to below 1 period
  1
delay_samples = 0 -> jitter_s = 0.01
  6:12: loop.jitter_s is 0.01 s, but must be from 0 s to below half of the shortest period
  0.01
delay_samples = 0 -> jitter_s = 0.005\njitter_deviation_s = 0
  7:22: loop.jitter_deviation_s is 0 s, but must be finite and above 0 s
  0
delay_samples = 0 -> jitter_deviation_s = 0.001
  6:22: jitter_deviation_s needs jitter_s, the bound that no sample exceeds
  0.001
delay_samples = 0 -> drop_probability = 1
  6:20: loop.drop_probability is 1, but must be a probability from 0 to below 1
  1
delay_samples = 0 -> dropped_samples = [3, 2]
  6:19: loop.dropped_samples is 2, but must be indices in rising order
  [3, 2]
delay_samples = 0 -> dropped_samples = [0]
  6:19: loop.dropped_samples is 0, but must be indices from 1 on: a loop begins with sample 0
  [0]
delay_samples = 0 -> drop_probability = 0.1\ndropped_samples = [3]
  7:19: either drop_probability or dropped_samples, not both
  [3]
delay_samples = 0 -> collapse = { from_s = 1, until_s = 0.5, period_s = 0.01 }
  6:36: loop.collapse.until_s is 0.5 s, but must be after the collapse begins [s]
  0.5
delay_samples = 0 -> collapse = { from_s = 1, until_s = 2, period_s = 0 }
  6:50: loop.collapse.period_s is 0 s, but must be finite and above 0 s
  0
delay_samples = 0 -> collapse = { from_s = nan, until_s = 2, period_s = 0.01 }
  6:23: loop.collapse.from_s is NaN s, but must be finite [s]
  nan
delay_samples = 0 -> collapse = { from_s = 1, until_s = 2 }
  6:12: the key period_s is missing
  { from_s = 1, until_s = 2 }
delay_samples = 0 -> seed = -1
  6:8: invalid value: integer `-1`, expected a whole number from 0 up
  -1
speed_limit_m_per_s = 10 -> largest_gap_s = 0.01
  37:17: render.largest_gap_s is 0.01 s, but must be finite and at least one period
  0.01"#,
        14,
    );
}

#[test]
fn guard_values_have_ranges_and_belong_together() {
    for (keys, words) in [
        (
            "acceleration_m_per_s2 = 0",
            "render.guard.acceleration_m_per_s2 is 0 m/s^2, but must be finite and greater than 0",
        ),
        (
            "acceleration_m_per_s2 = 80, least_mass_kg = 0",
            "render.guard.least_mass_kg is 0 kg, but must be finite and greater than 0",
        ),
        (
            "recovery_w = -1",
            "render.guard.recovery_w is -1 W, but must be finite and not below 0",
        ),
        (
            "least_mass_kg = 0.1",
            "render.guard.least_mass_kg needs acceleration_m_per_s2 or hand_force_n",
        ),
        (
            "learn_mass = true",
            "render.guard.learn_mass needs acceleration_m_per_s2 or hand_force_n",
        ),
        (
            "hand_force_n = -8",
            "render.guard.hand_force_n is -8 N, but must be finite and greater than 0",
        ),
        (
            "hand_force_n = 8, acceleration_m_per_s2 = 80",
            "render.guard.hand_force_n excludes acceleration_m_per_s2; remove one",
        ),
        (
            "hand_force_n = 8, hand_torque_n_m = 1",
            "render.guard.hand_torque_n_m needs a device of six axes",
        ),
        (
            "acceleration_m_per_s2 = 80, turning_acceleration_rad_per_s2 = 1000",
            "render.guard.turning_acceleration_rad_per_s2 needs a device of six axes",
        ),
    ] {
        let guard = format!("guard = {{ mode = \"limit\", {keys} }}");
        let text = GOOD.replace("unilateral = false", &guard);
        let error = ContactFile::parse("good", &text).unwrap_err().to_string();
        assert!(error.contains(words), "{keys}: {error}");
    }
}

#[test]
fn out_of_range_actuator_and_model_values_are_rejected() {
    assert_faults(
        r#"delay_samples = 0 -> delay_s = -0.001
  6:11: loop.delay_s is -0.001 s, but must be from 0 s to 1024 periods
  -0.001
delay_samples = 0 -> delay_samples = 1\ndelay_s = 0.01
  7:11: either delay_s, or delay_samples with delay_fraction; not both
  0.01
delay_samples = 0 -> command_jitter_s = -1
  6:20: loop.command_jitter_s is -1 s, but must be from 0 s to 1024 periods
  -1
delay_samples = 0 -> lag_s = -1e-4
  6:9: loop.lag_s is -0.0001 s, but must be finite and not below 0
  -1e-4
delay_samples = 0 -> lag_s = 1e13
  6:9: loop.lag_s is 10000000000000 s, but must be at most 1e12
  1e13
delay_samples = 0 -> gain = 0
  6:8: loop.gain is 0, but must be finite and greater than 0
  0
delay_samples = 0 -> hold = "ramp"
  6:8: unknown variant `ramp`, expected `constant` or `line`
  "ramp"
[measure] -> [model]\ngain = 0\n\n[measure]
  40:8: model.gain is 0, but must be finite and greater than 0
  0
[measure] -> [model]\ndelay_s = 0.2\n\n[measure]
  40:11: model.delay_s is 0.2 s, but must be from 0 s to 8 periods
  0.2
[measure] -> [model]\ndelay_deviation_s = -1e-5\n\n[measure]
  40:21: model.delay_deviation_s is -0.00001 s, but must be finite and not below 0
  -1e-5
[measure] -> [model]\ndelay_deviation_s = 0.5\n\n[measure]
  40:21: model.delay_deviation_s is 0.5 s, but must be 0 to 8 periods
  0.5
[measure] -> [model]\nlag_deviation_s = 0.5\n\n[measure]
  40:19: model.lag_deviation_s is 0.5 s, but must be 0 to 8 periods
  0.5
[measure] -> [model]\ngain_deviation = 1.5\n\n[measure]
  40:18: model.gain_deviation is 1.5, but must be from 0 to the gain
  1.5
[measure] -> [model]\nlag_s = nan\n\n[measure]
  40:9: model.lag_s is NaN s, but must be finite and not below 0
  nan
[measure] -> [model]\nsensor_noise_m = -1e-6\n\n[measure]
  40:18: model.sensor_noise_m is -0.000001 m, but must be finite and not below 0
  -1e-6
[measure] -> [model]\ndelay = 1\n\n[measure]
  40:1: unknown key delay, did you mean delay_s? Known here: delay_s, delay_deviation_s, lag_s, lag_deviation_s, gain, gain_deviation, sensor_quantum_m, sensor_noise_m, resonance_hz, resonance_damping_ratio, flexible_mass_fraction, device_mass_kg, device_mass_factor, device_inertia_kg_m2
  delay
[measure] -> [model]\nresonance_hz = 0\nresonance_damping_ratio = 0.1\nflexible_mass_fraction = 0.5\n\n[measure]
  40:16: model.resonance_hz is 0 Hz, but must be finite and greater than 0
  0
[measure] -> [model]\nresonance_hz = 9\nresonance_damping_ratio = 1.5\nflexible_mass_fraction = 0.5\n\n[measure]
  41:27: model.resonance_damping_ratio is 1.5, but must be from 0 to 1
  1.5
[measure] -> [model]\nresonance_hz = 9\nresonance_damping_ratio = 0.1\nflexible_mass_fraction = 1\n\n[measure]
  42:26: model.flexible_mass_fraction is 1, but must be from 0 to below 1
  1
[measure] -> [model]\nresonance_hz = 150\n\n[measure]
  40:16: a transmission model needs resonance_hz, resonance_damping_ratio and flexible_mass_fraction
  150"#,
        20,
    );
}

#[test]
fn a_transmission_cogging_and_noise_have_ranges_and_belong_together() {
    assert_faults(
        r#"quantum_m = 0 -> noise_m = -1e-6
  14:11: device.noise_m is -0.000001 m, but must be finite and not below 0
  -1e-6
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\nresonance_hz = 0\n
  17:16: device.drivetrain.resonance_hz is 0 Hz, but must be above 0 and at most 5000
  0
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\nresonance_hz = 150\nresonance_damping_ratio = 2\n
  18:27: device.drivetrain.resonance_damping_ratio is 2, but must be from 0 to 1
  2
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\nresonance_hz = 150\nmotor_mass_fraction = 1\n
  18:23: device.drivetrain.motor_mass_fraction is 1, but must be above 0 and below 1
  1
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\nresonance_hz = 150\nbacklash_m = -1\n
  18:14: device.drivetrain.backlash_m is -1 m, but must be finite and not below 0
  -1
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\nbacklash_m = 1e-4\n
  17:14: keys of a flexible transmission need resonance_hz
  1e-4
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\ncogging_n = 0.1\n
  17:13: cogging needs both cogging_n and cogging_pitch_m
  0.1
quantum_m = 0\n -> quantum_m = 0\n\n[device.drivetrain]\ncogging_n = 0.1\ncogging_pitch_m = 0\n
  18:19: device.drivetrain.cogging_pitch_m is 0 m, but must be finite and greater than 0
  0"#,
        8,
    );
}
