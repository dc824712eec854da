//! Validation of measured orientations.

use palpate_world::{CoupledParams, Sample, WorldLoop, WorldRenderer};

use crate::six_axes::on_a_ball;

#[test]
fn an_orientation_that_is_none_gives_no_wrench_and_a_fault() {
    let (world, device) = on_a_ball();
    let params = CoupledParams::new(vec![[0.15; 3]]).with_device_inertia(vec![[1e-4; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), params).unwrap();
    let (_, turned) = device.pose();
    let pressed = [[0.002, 0.0, 0.015]];
    let bad = [
        [0.0; 4],
        [f64::NAN, 0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0, 0.0],
        [1e300, 1e300, 0.0, 0.0],
        [f64::INFINITY, 0.0, 0.0, 0.0],
    ];
    for orientation in bad.map(Some).into_iter().chain([None]) {
        let mut state = renderer.start();
        for _ in 0..4 {
            let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&[turned]));
            assert_eq!(output.fault, None);
        }
        let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&[turned]));
        assert!(output.torques[0] != [0.0; 3] && output.forces[0] != [0.0; 3]);
        let given: Vec<_> = orientation.into_iter().collect();
        let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&given));
        let fault = output.fault.unwrap();
        assert_eq!(
            fault.fault,
            palpate_core::Fault::OrientationNotUnit,
            "{orientation:?}"
        );
        assert_eq!(fault.tool, Some(0));
        assert_eq!((output.forces[0], output.torques[0]), ([0.0; 3], [0.0; 3]));
        // An orientation of nearly length 1 is normalised, and its negative is equivalent.
        let near = turned.map(|part| -1.0005 * part);
        let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&[near]));
        assert_eq!(output.fault, None);
    }
    // A rotation by a radian within a sample is rejected until the next one confirms it.
    let mut state = renderer.start();
    for _ in 0..2 {
        let _ = renderer.step(&mut state, &Sample::at(&pressed).turned(&[turned]));
    }
    let half = 0.5_f64;
    let leapt = [[half.cos(), 0.0, 0.0, half.sin()]];
    let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&leapt));
    assert_eq!(
        output.fault.unwrap().fault,
        palpate_core::Fault::JumpTooFast
    );
    let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&leapt));
    assert_eq!(output.fault, None);
}

/// A tool that rotates by 0.15 rad per sample, more than the limit for a jump.
#[test]
fn a_tool_that_spins_is_pushed() {
    let (world, device) = on_a_ball();
    let params = CoupledParams::new(vec![[0.15; 3]]).with_device_inertia(vec![[1e-4; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), params).unwrap();
    let (_, turned) = device.pose();
    let pressed = [[0.002, 0.0, 0.015]];
    let mut state = renderer.start();
    let mut refused = 0;
    for sample in 0..100_u32 {
        // About the vertical axis, starting at 0.
        let half = 0.5 * 0.15 * f64::from(sample);
        let [w, x, y, z] = turned;
        let (s, c) = half.sin_cos();
        let spun = [[c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]];
        let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&spun));
        refused += u32::from(output.fault.is_some());
        assert!(
            sample < 10 || output.forces[0][2] > 0.0,
            "{sample}: {output:?}"
        );
    }
    // The first rotation is rejected; the second continues it by the same angle.
    assert_eq!(refused, 1);
    // A tool that shakes as fast does not continue its rotation.
    for sample in 0..8_u32 {
        let half = if sample % 2 == 0 { 0.5 } else { -0.5_f64 };
        let shaken = [[half.cos(), 0.0, 0.0, half.sin()]];
        let output = renderer.step(&mut state, &Sample::at(&pressed).turned(&shaken));
        let fault = output.fault.map(|fault| fault.fault);
        assert_eq!(fault, Some(palpate_core::Fault::JumpTooFast), "{sample}");
    }
}
