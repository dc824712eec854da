//! Eq. (9) as a quotient, and the closed forms that replace it.

use palpate_core::{
    AnyParams, Contact, EnergyBalance, EntryHold, HfcrParams, LoopParams, Method, MethodParams,
    ObjectMotion, ObjectState, ParameterError, Phase, Plan, Renderer, Rule, Sample, Situation,
};
use palpate_study::sim::closed_loop::Bench;
use palpate_testbed::device::{DevicePlant, PointMass};

use crate::common::{PAPER_SCENES, Random, scene};
use crate::paper::trial::{Case, Trial, loop_params, object};

const CASES: usize = 80_000;

/// Every reading of where the device is held after an entry, and no transitions at all.
const TRANSITIONS: [Option<EntryHold>; 4] = [
    Some(EntryHold::Crossing),
    Some(EntryHold::Sample),
    Some(EntryHold::Midpoint),
    None,
];

fn params(smooth_transition: Option<EntryHold>) -> AnyParams<f64> {
    AnyParams::Hfcr(HfcrParams {
        smooth_transition: smooth_transition.is_some(),
        entry_hold: smooth_transition.unwrap_or_default(),
        ..HfcrParams::default()
    })
}

/// Source: Eq. (9), `f_i = (V~_{i+1} - V_i) / (xi~ - xi_i)`, xi~ = 2 xi_i - xi_{i-1}.
///
/// DIFFERENCE: V carries the work of the virtual force, -f_V eta, which the paper's Eq. (8)
/// leaves out; Eq. (10) follows.
/// DIFFERENCE: the renderer has closed forms in place of the quotient. They are the same number,
/// interval by interval, and need no division that fails when the device turns round.
#[test]
fn every_closed_form_is_the_quotient_of_eq_9() {
    let mut random = Random(9);
    let mut met = std::collections::BTreeMap::<String, (usize, f64)>::new();
    for case_number in 0..CASES {
        let case = Case::random(&mut random);
        let transitions = TRANSITIONS[case_number % TRANSITIONS.len()];
        let smooth = transitions.is_some();
        let mut trial = Trial::new(&case, params(transitions));
        let before = random.between(-2e-3, 2e-3);
        let now = before + random.between(-2e-3, 2e-3);
        trial.at(before);
        let output = trial.at(now);
        let predicted = 2.0 * now - before;
        let (next, ledger) = trial.peek(predicted);
        let mut change = case.stored(predicted, object(&next)) - case.stored(now, object(&output));
        let work = output.force_on_object * (predicted - now);
        let turned_over = case.stored(predicted, object(&next)).abs()
            + case.stored(now, object(&output)).abs()
            + (case.virtual_force * next.object_position).abs()
            + (case.virtual_force * output.object_position).abs()
            + work.abs();
        let row = match output.phase {
            Phase::Contact if next.penetration > 0.0 => "sustained contact",
            Phase::Contact if smooth => "sustained contact, lost by rounding",
            Phase::Contact => "predicted out, no smooth transition",
            Phase::Free if next.penetration > 0.0 => "predicted in, no smooth transition",
            Phase::Free => "free",
            Phase::Enters if next.penetration > 0.0 => "free -> contact",
            Phase::Enters => {
                // A stiff spring throws the object out again within the interval. At most one
                // transition is made, so the closed form follows the spring into tension.
                change += 0.5 * case.stiffness * next.penetration * next.penetration;
                "free -> contact, out again"
            }
            Phase::Leaves => "contact -> free",
            Phase::Waiting => unreachable!("no sample is refused"),
        };
        // Multiplied by the displacement, so that the comparison does not divide either.
        let error = (change - work).abs() / turned_over.max(1e-300);
        if row == "predicted in, no smooth transition" {
            // The two-mode object of this variant stays free: Eq. (9) is not used, and the force
            // is 0.
            assert_eq!(output.force_on_object, 0.0);
        } else {
            assert!(
                error < 1e-13,
                "{row}: off by {error:e} of {turned_over} J: force {} for a change of {change} J over {} m, {case:?}",
                output.force_on_object,
                predicted - now,
            );
            // The renderer's own books agree: as predicted means no leak.
            let leak = ledger.held_leak.last.abs() / turned_over.max(1e-300);
            assert!(
                leak < 1e-13 || row.ends_with("out again"),
                "{row}: leak {leak:e}"
            );
        }
        let (count, worst) = met
            .entry(match transitions {
                Some(hold) => format!("{row}, st, {hold:?}"),
                None => row.to_owned(),
            })
            .or_default();
        *count += 1;
        *worst = worst.max(error);
    }
    for (row, (count, worst)) in &met {
        eprintln!("{row}: {count} intervals, largest relative error {worst:.1e}");
        assert!(*count >= 50, "{row} was met only {count} times");
    }
}

/// HFCR with Eq. (9) as printed: a quotient, with or without the work of f_V in Eq. (8). If the device has not moved,
/// the quotient is undefined and the spring force is used.
#[derive(Clone, Copy, Debug)]
struct Printed {
    smooth_transition: bool,
    work_of_virtual_force: bool,
}

impl MethodParams<f64> for Printed {
    type Method = Self;

    fn check(self, _: &Contact<f64>, _: &LoopParams<f64>) -> Result<Self, ParameterError> {
        Ok(self)
    }

    fn name(&self) -> &'static str {
        "hfcr as printed"
    }
}

impl Method<f64> for Printed {
    type Memory = ();

    fn plan(&self, motion: &ObjectMotion<f64>, now: &Situation<f64>, (): &mut ()) -> Plan<f64> {
        let (start, period) = (&now.start, motion.period());
        let p = start.penetration;
        let d = start.device_velocity * period;
        let pressed = motion.press(start);
        let rule = if now.in_contact() {
            if self.smooth_transition && p + d - pressed.by <= 0.0 {
                Rule::Leaves(motion.release(start))
            } else {
                Rule::Contact
            }
        } else {
            match motion.entry(start) {
                Some(after) if self.smooth_transition => Rule::Enters {
                    after,
                    held_at: start.device_velocity * after,
                },
                _ => Rule::Free,
            }
        };
        let moved = motion.advance(rule, start, period);
        let work = if self.work_of_virtual_force {
            start.virtual_force * moved.by
        } else {
            0.0
        };
        let change = motion.stored_energy(p + d - moved.by, moved.velocity)
            - motion.stored_energy(p, start.object_velocity)
            - work;
        let force = if rule == Rule::Free {
            0.0
        } else if d.abs() < 1e-9 {
            now.spring_force(motion)
        } else {
            change / d
        };
        Plan { force, rule, moved }
    }
}

/// Forces on the object that the scene's loop holds over `samples` samples.
fn closed_loop(name: &str, method: impl MethodParams<f64>, samples: usize) -> Vec<f64> {
    let scene = scene(name);
    let period = scene.loop_params.period;
    let renderer = Renderer::new(scene.contact, loop_params(period), method).unwrap();
    let mut state = renderer.start(scene.object).unwrap();
    let mut device = PointMass::new(scene.device.mass(), scene.device.hand_force()).unwrap();
    (0..samples)
        .map(|_| {
            let sample = Sample::at(device.position()).with_virtual_force(scene.virtual_force);
            let force = renderer.step(&mut state, sample).force_on_object;
            device.advance(force, period);
            force
        })
        .collect()
}

fn peak(forces: &[f64]) -> f64 {
    forces.iter().fold(0.0, |peak, force| force.abs().max(peak))
}

/// Source: Eq. (9); what happens at d -> 0 is derived here.
///
/// DIFFERENCE: with Eq. (8) as printed the numerator does not vanish with the denominator: the
/// force is off by `f_V (eta_{i+1} - eta_i) / d`, without bound as the device turns round.
#[test]
fn without_the_work_of_f_v_the_force_of_eq_9_has_no_bound_as_the_device_turns_round() {
    let mut peaks = Vec::new();
    for displacement in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let scene = scene("experiment1");
        let held = |method: Printed| {
            let renderer = Renderer::new(scene.contact, scene.loop_params, method).unwrap();
            let mut state = renderer.start(ObjectState::at_rest(0.0)).unwrap();
            // 20 mm inside, 2 N of spring force, while the object falls back onto the device.
            [0.02, 0.02 + displacement].map(|device| {
                let sample = Sample::at(device).with_virtual_force(scene.virtual_force);
                renderer.step(&mut state, sample).force_on_object
            })[1]
        };
        let [printed, consistent] = [false, true].map(|work_of_virtual_force| {
            held(Printed {
                smooth_transition: true,
                work_of_virtual_force,
            })
        });
        eprintln!(
            "device moves {displacement:.0e} m: {printed:.2} N as printed, {consistent:.3} N with the work of f_V"
        );
        assert!((0.0..2.0).contains(&consistent));
        peaks.push((printed - consistent).abs());
    }
    // Ten times less displacement, ten times the error.
    for pair in peaks.windows(2) {
        assert!((pair[1] / pair[0] / 10.0 - 1.0).abs() < 0.1, "{peaks:?}");
    }
}

/// Source: Eqs. (8) and (9) on the paper's scenes; the factor is measured here.
///
/// DIFFERENCE: as above. How large the largest peak is depends on how near to standstill a sample
/// falls: 200 samples reach factors of 15 and more, the paper's windows 2 to 19.
#[test]
fn without_the_work_of_f_v_closed_loops_reach_many_times_the_ideal_force() {
    let mut factors = Vec::new();
    for name in PAPER_SCENES {
        let scene = scene(name);
        let bench = Bench::new(&scene).unwrap();
        let collisions = bench.reference().profile.collisions();
        let ideal = collisions.iter().map(|c| c.peak_force).fold(0.0, f64::max);
        let window = bench.reference().profile.intervals();
        for smooth_transition in [false, true] {
            let held = |work_of_virtual_force| {
                let method = Printed {
                    smooth_transition,
                    work_of_virtual_force,
                };
                closed_loop(name, method, 200)
            };
            let (printed, consistent) = (held(false), held(true));
            let transitions = smooth_transition.then_some(EntryHold::Crossing);
            let closed = closed_loop(name, params(transitions), window);
            let closed_as_printed = AnyParams::Hfcr(HfcrParams {
                smooth_transition,
                balance: EnergyBalance::AsPrinted,
                ..HfcrParams::default()
            });
            let closed_as_printed = closed_loop(name, closed_as_printed, window);
            // The quotient is the closed form in a loop, too.
            for (quotients, closed) in [(&consistent, &closed), (&printed, &closed_as_printed)] {
                for (quotient, closed) in quotients.iter().zip(closed) {
                    assert!((quotient - closed).abs() < 1e-6 * ideal, "{name}");
                }
            }
            let factor = |forces: &[f64]| peak(forces) / ideal;
            eprintln!(
                "{name}, smooth transition {smooth_transition}: peak over the ideal's {ideal:.2} N: \
                 as printed {:.1} (200 samples; {:.1} in the window), with the work of f_V {:.1} ({:.1})",
                factor(&printed),
                factor(&printed[..window]),
                factor(&consistent),
                factor(&consistent[..window]),
            );
            factors.push((factor(&printed), factor(&consistent)));
        }
    }
    let [_, fig2, _, experiment1, experiment2_without_st, experiment2] = factors[..] else {
        panic!("six loops expected")
    };
    for (printed, expected) in [
        (fig2.0, 15.2),
        (experiment1.0, 26.4),
        (experiment2_without_st.0, 22.5),
    ] {
        assert!(
            (printed / expected - 1.0).abs() < 0.05,
            "{printed} for {expected}"
        );
    }
    for consistent in [fig2.1, experiment1.1, experiment2.1] {
        assert!((1.0..2.5).contains(&consistent), "{consistent}");
    }
}

/// Source: the table's last row, its limit for d -> 0: derived here.
#[test]
fn a_device_that_stands_still_gets_the_spring_force_at_the_interval_s_end() {
    let mut random = Random(4);
    let (mut pressed, mut lost) = (0, 0);
    for _ in 0..4000 {
        let case = Case::random(&mut random);
        let device = random.between(-2e-3, 2e-3);
        for (smooth_transition, moved) in [(true, 0.0), (false, 0.0), (false, 0.9e-9)] {
            let transitions = smooth_transition.then_some(EntryHold::Crossing);
            let mut trial = Trial::new(&case, params(transitions));
            trial.at(device);
            let output = trial.at(device + moved);
            if output.phase != Phase::Contact {
                continue;
            }
            let (next, _) = trial.peek(device);
            let expected = case.stiffness * next.penetration.max(0.0);
            assert!(
                (output.force_on_object - expected).abs() <= case.stiffness * 2e-9,
                "{} N instead of {expected} N",
                output.force_on_object
            );
            if next.penetration > 0.0 {
                pressed += 1
            } else {
                lost += 1
            }
        }
    }
    eprintln!("{pressed} intervals end in contact, {lost} out of it");
    assert!(pressed > 500 && lost > 500);
}
