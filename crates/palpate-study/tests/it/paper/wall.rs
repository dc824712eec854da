//! On a wall, methods that look different are the same.

use palpate_core::{AnyParams, HfcrParams, ObjectState, Phase, SehParams, VirtualDamperParams};
use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::closed_loop::Bench;
use palpate_study::sim::run::Run;

use crate::common::{Random, damping, scene, with};
use crate::paper::trial::{Case, Trial};

/// Source: derived here from Eqs. (3) and (9).
#[test]
fn in_contact_with_a_wall_modified_force_seh_and_a_damper_of_half_kt_are_one() {
    let mut random = Random(3);
    let (mut compared, mut worst) = (0, 0.0_f64);
    for _ in 0..5000 {
        let case = Case {
            mass: f64::INFINITY,
            object: ObjectState::default(),
            ..Case::random(&mut random)
        };
        let (before, now) = (random.between(1e-6, 2e-3), random.between(1e-6, 2e-3));
        let held = [
            AnyParams::Hfcr(HfcrParams::modified_force_only()),
            AnyParams::Hfcr(HfcrParams::default()),
            AnyParams::Seh(SehParams::default()),
            AnyParams::VirtualDamper(VirtualDamperParams::new(0.5 * case.stiffness * case.period)),
        ]
        .map(|params| {
            let mut trial = Trial::new(&case, params);
            trial.at(before);
            trial.at(now)
        });
        if 2.0 * now - before <= 0.0 {
            continue; // predicted to leave
        }
        assert_eq!(held[1].phase, Phase::Contact);
        for other in &held[1..] {
            let error =
                (other.force_on_object - held[0].force_on_object).abs() / (case.stiffness * 4e-3);
            worst = worst.max(error);
            assert!(error < 1e-14, "{held:?}");
        }
        compared += 1;
    }
    eprintln!("{compared} pairs of samples, largest difference {worst:.1e} of the full force");
    assert!(compared > 3000);
}

/// First tick at which two runs hold different forces.
fn parting(one: &Run, other: &Run) -> usize {
    let scale = one.force.peak_force;
    one.ticks
        .iter()
        .zip(&other.ticks)
        .position(|(a, b)| (a.held_force_on_object - b.held_force_on_object).abs() > 1e-9 * scale)
        .expect("the loops part")
}

/// Source: derived here from Eqs. (3), (9) and the transition rule.
#[test]
fn in_a_closed_loop_only_modified_force_and_that_damper_stay_one_until_release() {
    let mut wall = scene("wall");
    let half_kt = 0.5 * wall.contact.stiffness * wall.loop_params.period;
    wall = with(wall, MethodName::VirtualDamper, damping(half_kt));
    wall = with(wall, MethodName::Seh, Settings::default());
    let bench = Bench::new(&wall).unwrap();
    let run = |method| bench.run(method).unwrap();
    let modified = run(MethodName::HfcrMod);
    let first_contact = |run: &Run| {
        run.ticks
            .iter()
            .position(|t| t.output.penetration > 0.0)
            .unwrap()
    };
    let contact = first_contact(&modified);
    let released = contact
        + modified.ticks[contact..]
            .iter()
            .position(|t| t.output.penetration <= 0.0)
            .unwrap();
    let damper = parting(&modified, &run(MethodName::VirtualDamper));
    let seh = parting(&modified, &run(MethodName::Seh));
    let smooth = parting(&modified, &run(MethodName::HfcrModSt));
    eprintln!(
        "contact at sample {contact}, release by {released}; the damper parts at {damper}, \
         SEH at {seh}, smooth transition at {smooth}"
    );
    // The modified force departs in the interval it predicts to leave in, the last in contact.
    assert_eq!(damper, released - 1);
    assert_eq!(seh, contact);
    // The transition holds a force already in the interval before the first sample in contact.
    assert_eq!(smooth, contact - 1);
}
