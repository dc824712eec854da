//! Tests of the map: its loop against the bench, its classes against classical results, and its independence of
//! threads.
#![allow(clippy::print_stdout)]

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use palpate_core::ParameterValue;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use palpate_scene::{Linkage, Measure};
use palpate_study::map::{
    Bounce, CellResult, Class, Done, Entry, Forces, Limit, MapParams, PHASES, Plant, RESTS_BELOW,
    Stay, bounds, compute, default_settings,
};
use palpate_study::sim::closed_loop::Bench;
use palpate_testbed::device::DevicePlant;
use palpate_testbed::pantograph::Pantograph;
use palpate_testbed::sprung_mass::SprungMass;

fn params(cells: usize) -> MapParams {
    MapParams {
        cells,
        ..MapParams::default()
    }
}

fn all_cells(params: &MapParams, threads: usize) -> Vec<CellResult> {
    let mut results = Vec::new();
    let never = AtomicBool::new(false);
    let done = compute(params, &params.shard(1, 1), threads, &never, |result| {
        results.push(result);
        ControlFlow::Continue(())
    });
    assert_eq!(done, Ok(Done::All));
    results.sort_by_key(|result| result.index);
    results
}

/// Runs the bench, which records every tick, in one phase of a bounce; its window is that of the lossless bounce, as
/// in the map.
fn on_the_bench<T>(bounce: &Bounce, phase: usize, then: impl FnOnce(&Bench) -> T) -> T {
    let height = 0.05 * (2.0 * phase as f64 / (PHASES - 1) as f64 - 1.0);
    let mut lossless = bounce.on(Plant::Undamped).scene(height, 1);
    lossless.measure = Measure::Collisions(3);
    let window = Bench::new(&lossless)
        .unwrap()
        .reference()
        .profile
        .intervals();
    let scene = bounce.scene(height, window);
    then(&Bench::new(&scene).unwrap())
}

#[test]
fn the_lean_loop_gives_the_numbers_of_the_bench_to_the_bit() {
    for delay in [0.0, 2.0] {
        let params = MapParams { delay, ..params(5) };
        for index in [0, 9, 14, 16, 20, 29] {
            let bounce = params.cell(index).bounce.on(Plant::Undamped);
            let cell = params.run_cell(index).unwrap();
            let entries = cell.methods.iter().map(|result| result.bounce);
            let mut errors = vec![Vec::new(); params.methods.len()];
            for phase in 0..PHASES {
                on_the_bench(&bounce, phase, |bench| {
                    for (method, errors) in params.methods.iter().zip(&mut errors) {
                        let run = bench.run(*method).unwrap();
                        errors.push(run.force.fidelity.unwrap().mean_force_error);
                    }
                });
            }
            for (errors, entry) in errors.iter_mut().zip(entries) {
                errors.sort_by(f64::total_cmp);
                let expected = (errors[PHASES / 2], errors[PHASES - 1]);
                let found = (entry.error.median, entry.error.worst);
                assert_eq!(found, expected, "cell {index}, {entry:?}");
            }
        }
    }
}

#[test]
fn with_friction_the_lean_loop_gives_the_numbers_of_the_bench_s_integrated_ideal() {
    // Experiment 1 with the friction of the pantograph. An unstable loop amplifies differences, so only stable loops
    // can agree.
    let mut bounce = params(5).cell(0).bounce;
    (bounce.stiffness, bounce.object_mass) = (100.0, 0.1);
    let methods = [MethodName::HfcrModSt, MethodName::VirtualDamper];
    let settings = methods.map(|method| (method, Settings::default()));
    let (entries, _) = bounce.evaluate(Plant::Damped, &settings).unwrap();
    let mut errors = [const { Vec::new() }; 2];
    for phase in 0..PHASES {
        on_the_bench(&bounce, phase, |bench| {
            for (method, errors) in methods.iter().zip(&mut errors) {
                let run = bench.run(*method).unwrap();
                errors.push(run.force.fidelity.unwrap().mean_force_error);
            }
        });
    }
    for (errors, entry) in errors.iter_mut().zip(&entries) {
        errors.sort_by(f64::total_cmp);
        println!(
            "{}: {:?}, bench worst {}",
            entry.method,
            entry.error,
            errors[PHASES - 1]
        );
        assert!(
            (errors[PHASES / 2] - entry.error.median).abs() < 1e-3,
            "{entry:?}"
        );
        assert!(
            (errors[PHASES - 1] - entry.error.worst).abs() < 1e-3,
            "{entry:?}"
        );
    }
}

#[test]
fn a_map_is_the_same_on_any_number_of_threads() {
    let params = params(5);
    let one = all_cells(&params, 1);
    assert_eq!(one.len(), params.len());
    for threads in [2, 5] {
        let bits = |results: &[CellResult]| format!("{results:?}");
        assert_eq!(bits(&one), bits(&all_cells(&params, threads)), "{threads}");
    }
}

#[test]
fn map_stops_on_request() {
    let params = params(5);
    let stop = AtomicBool::new(false);
    let mut taken = 0;
    let done = compute(&params, &params.shard(1, 1), 2, &stop, |_| {
        taken += 1;
        stop.store(true, Ordering::Relaxed);
        ControlFlow::Continue(())
    });
    assert_eq!(done, Ok(Done::Stopped));
    assert!(0 < taken && taken < params.len(), "{taken}");
    let mut first = 0;
    let never = AtomicBool::new(false);
    let done = compute(&params, &params.shard(1, 1), 2, &never, |_| {
        first += 1;
        ControlFlow::Break(())
    });
    assert_eq!((done, first), (Ok(Done::Stopped), 1));
}

#[test]
fn wrong_model_mass_and_period_leave_the_plant_unchanged() {
    let of = |model_mass: f64, model_period: f64, method| {
        let mut params = MapParams {
            model_period,
            ..params(5)
        };
        params.device.model_mass = model_mass;
        let results = params.run_cell(15).unwrap().methods;
        let mut entries = results.iter().map(|result| result.bounce);
        entries.find(|entry| entry.method == method).unwrap()
    };
    let right = of(1.0, 1.0, MethodName::Hfcr);
    // A wrong model mass affects only methods that derive their damping from it.
    assert_ne!(of(0.2, 1.0, MethodName::Hfcr), right);
    let modelled_right = of(1.0, 1.0, MethodName::Coupled);
    assert_ne!(of(0.2, 1.0, MethodName::Coupled), modelled_right);
    assert_eq!(
        of(0.2, 1.0, MethodName::HfcrModSt),
        of(1.0, 1.0, MethodName::HfcrModSt)
    );
    // A wrong model period does not change the ideal.
    let wrong = of(1.0, 1.2, MethodName::Hfcr);
    assert_eq!(wrong.hold_bound, right.hold_bound);
    assert!(wrong.error.median > right.error.median + 1.0, "{wrong:?}");
}

/// A device file changes the loop, so it must affect a map, an advice and a page.
#[test]
fn a_deviation_of_the_model_reaches_the_renderer_of_every_cell() {
    let of = |delay_deviation: f64, lag_deviation: f64, method| {
        let params = MapParams {
            delay: 1.0,
            lag: 0.3,
            delay_deviation,
            lag_deviation,
            methods: vec![method],
            ..params(5)
        };
        // kappa and Kc of 1.
        let bounce = params.cell(22).bounce;
        let model = bounce.scene(0.0, 1).model;
        assert_eq!(model.delay_deviation, None, "the plant has none");
        let (entries, _) = bounce
            .evaluate(Plant::Damped, &[(method, default_settings(method))])
            .unwrap();
        (entries[0], bounce.stay(method, default_settings(method)))
    };
    let exact = of(0.0, 0.0, MethodName::Coupled);
    assert_ne!(of(0.1, 0.0, MethodName::Coupled), exact);
    assert_ne!(of(0.0, 0.1, MethodName::Coupled), exact);
    // Other methods do not predict the device motion.
    let exact = of(0.0, 0.0, MethodName::HfcrModSt);
    assert_eq!(of(0.1, 0.1, MethodName::HfcrModSt), exact);
}

fn wall(kappa: f64, friction: f64) -> Bounce {
    let mut bounce = params(2).cell(0).bounce;
    bounce.stiffness = kappa * bounce.device.mass / (bounce.period * bounce.period);
    bounce.device.viscous_friction = friction * bounce.device.mass / bounce.period;
    bounce
}

fn evaluated(bounce: &Bounce, method: MethodName, damping: Option<f64>) -> Entry {
    let mut settings = Settings::default();
    settings.set(SettingKey::DAMPING, damping.map(ParameterValue::Number));
    let (entries, _) = bounce
        .evaluate(Plant::Damped, &[(method, settings)])
        .unwrap();
    entries[0]
}

#[test]
fn below_the_colgate_schenkel_bound_no_wall_gains_energy() {
    let mut checked = 0;
    for friction in [0.02, 0.1, 0.4, 1.0] {
        let most = bounds::colgate_schenkel(friction, 0.0);
        for share in [0.05, 0.3, 0.6, 0.95] {
            let entry = evaluated(&wall(share * most, friction), MethodName::Basic, None);
            assert!(entry.growth.worst <= 1.0, "{friction}, {share}: {entry:?}");
            checked += 1;
        }
        // The bound is sharp in order of magnitude: far above it the wall oscillates.
        let entry = evaluated(&wall(8.0 * most, friction), MethodName::Basic, None);
        assert_ne!(entry.class(), Class::Stable, "{friction}: {entry:?}");
    }
    assert_eq!(checked, 16);
}

#[test]
fn an_undamped_wall_with_the_plain_spring_gains_energy_at_every_stiffness() {
    for kappa in [1e-3, 1e-2, 0.1, 1.0, 10.0] {
        let entry = evaluated(&wall(kappa, 0.0), MethodName::Basic, None);
        println!("kappa {kappa}: {:?}", entry.growth);
        assert!(entry.growth.median > 1.02, "{kappa}: {entry:?}");
        assert_eq!(entry.classes[Class::Stable as usize], 0);
    }
}

#[test]
fn the_best_damper_on_an_undamped_wall_holds_up_to_its_bound() {
    // beta = B T/m of the maximum; B = beta m/T
    let beta = 2.0 * (2.0_f64.sqrt() - 1.0);
    let most = bounds::stiffest_undamped_wall();
    let at = |kappa: f64| {
        let bounce = wall(kappa, 0.0);
        let damping = beta * bounce.device.mass / bounce.period;
        evaluated(&bounce, MethodName::VirtualDamper, Some(damping))
    };
    for share in [0.2, 0.5, 0.9] {
        let entry = at(share * most);
        println!("{share} of the bound: {:?}", entry.growth);
        assert_eq!(entry.class(), Class::Stable, "{share}: {entry:?}");
    }
    let beyond = at(1.5 * most);
    println!("1.5 of the bound: {:?}", beyond.growth);
    assert_ne!(beyond.class(), Class::Stable, "{beyond:?}");
}

#[test]
fn a_bounce_that_never_meets_is_refused() {
    let mut bounce = params(2).cell(4).bounce;
    bounce.forces = Forces::Balanced(-1.0);
    let error = bounce.evaluate(Plant::Undamped, &[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the object never meets the device: no force drives them together"
    );
}

#[test]
fn the_stiffest_wall_of_the_best_damper_is_near_the_classical_one_and_not_above() {
    let bounce = wall(0.1, 0.0);
    let beta = 2.0 * (2.0_f64.sqrt() - 1.0);
    let damping = beta * bounce.device.mass / bounce.period;
    let settings = Settings::default().with(SettingKey::DAMPING, damping);
    let found = bounce
        .stiffest(MethodName::VirtualDamper, settings)
        .unwrap();
    let most = bounds::stiffest_undamped_wall() * bounce.device.mass / bounce.period.powi(2);
    println!("found {found:?}, classical {most} N/m");
    let Limit::At(found) = found else {
        panic!("{found:?}");
    };
    assert!(found > 0.8 * most && found < 1.1 * most, "{found} {most}");
}

#[test]
fn limits_agree_with_the_cells_of_the_map() {
    let params = params(9);
    let settings = Settings::default();
    let method = MethodName::HfcrModSt;
    let bounce = params
        .cell(2 * params.columns() + 5)
        .bounce
        .on(Plant::Undamped);
    let stable = |stiffness: f64, object_mass: f64| {
        let bounce = Bounce {
            stiffness,
            object_mass,
            ..bounce
        };
        let (entries, _) = bounce
            .evaluate(Plant::Undamped, &[(method, settings)])
            .unwrap();
        entries[0].class() == Class::Stable
    };
    let Limit::At(stiffest) = bounce.stiffest(method, settings).unwrap() else {
        panic!("no limit");
    };
    assert!(stable(stiffest, bounce.object_mass));
    assert!(!stable(1.02 * stiffest, bounce.object_mass));
    let hard = Bounce {
        stiffness: 0.1 * bounce.device.mass / bounce.period.powi(2),
        ..bounce
    };
    let lightest = hard.lightest(MethodName::Seh, settings).unwrap();
    assert_eq!(lightest, Limit::None);
    let Limit::At(lightest) = hard
        .on(Plant::Undamped)
        .lightest(MethodName::PopcRef, settings)
        .unwrap()
    else {
        panic!("no limit");
    };
    assert!(lightest > 0.0);
}

#[test]
fn coulomb_friction_takes_energy_and_has_an_ideal() {
    let mut bounce = params(5).cell(0).bounce;
    (bounce.stiffness, bounce.object_mass) = (100.0, 0.1);
    bounce.device.viscous_friction = 0.0;
    let settings = [(MethodName::HfcrModSt, Settings::default())];
    let without = bounce.evaluate(Plant::Damped, &settings).unwrap().0[0];
    bounce.device.coulomb_friction = 0.1;
    let with = bounce.evaluate(Plant::Damped, &settings).unwrap().0[0];
    println!("without {:?}, with {:?}", without.growth, with.growth);
    assert!(with.growth.worst < without.growth.worst - 0.02);
    // Against the ideal with friction, its error is not larger than without friction.
    assert!(with.error.worst < without.error.worst + 3.0, "{with:?}");
}

#[test]
fn the_damped_device_has_the_friction_of_the_virtual_pantograph_along_y() {
    let params = Linkage::preset("paper-like").unwrap().params;
    let home = Pantograph::new(params).unwrap();
    let [[a, b], [c, d]] = home.pose().jacobian();
    // Rates of the motors for 1 m/s along y and none along x.
    let determinant = a * d - b * c;
    let rates = [-b / determinant, a / determinant];
    let friction = params.viscous_friction * (rates[0].powi(2) + rates[1].powi(2));
    let ours = MapParams::default().device.viscous_friction;
    println!("{friction} N s/m at the home pose; the map has {ours}");
    assert!((friction / ours - 1.0).abs() < 2e-3, "{friction}");
}

/// kappa and Kc on the device of the map.
fn object(kappa: f64, object_kappa: f64) -> Bounce {
    let bounce = wall(kappa, 0.0);
    Bounce {
        object_mass: bounce.device.mass * kappa / object_kappa,
        ..bounce
    }
}

fn stay(bounce: &Bounce, method: MethodName) -> Stay {
    bounce.stay(method, default_settings(method)).unwrap().0
}

/// Returns the stiffness limit of a device in a hand with the sampled spring of a wall: both eigenvalues of the step
/// from sample to sample are inside the unit circle (Jury).
fn stiffest_wall_in_a_hand(device: f64, hand: (f64, f64, f64), period: f64) -> f64 {
    let (mass, stiffness, damping) = hand;
    let from = |position, velocity, force| {
        let mut held = SprungMass::new(device + mass, stiffness, damping, 0.0)
            .and_then(|held| held.starting_at(position, velocity))
            .unwrap();
        held.advance(force, period);
        (held.position(), held.velocity())
    };
    let ((a, c), (b, d)) = (from(1.0, 0.0, 0.0), from(0.0, 1.0, 0.0));
    let (p, v) = from(0.0, 0.0, 1.0);
    let is_stable = |wall: f64| {
        let (a, c) = (a + wall * p, c + wall * v);
        let (trace, determinant) = (a + d, a * d - b * c);
        determinant < 1.0 && trace.abs() < 1.0 + determinant
    };
    let (mut stable, mut unstable) = (0.0, 1e6);
    for _ in 0..60 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(middle) {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    stable
}

#[test]
fn a_wall_that_is_pressed_with_the_plain_spring_is_steady_up_to_the_bound_of_linear_theory() {
    let mut bounce = wall(0.1, 0.0);
    for period in [0.02, 0.005] {
        bounce.period = period;
        let most = [(0.05, 300.0, 3.0), (0.1, 400.0, 20.0)]
            .map(|hand| stiffest_wall_in_a_hand(bounce.device.mass, hand, period))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        for (share, is_steady) in [(0.3, true), (0.8, true), (1.25, false), (4.0, false)] {
            bounce.stiffness = share * most;
            let stay = stay(&bounce, MethodName::Basic);
            println!("{period} s, {share} of {most:.0} N/m: {stay:?}");
            assert_eq!(stay.is_steady_pressed(), is_steady, "{share}: {stay:?}");
            assert_eq!(stay.resting, None);
            assert!(stay.rests());
        }
    }
}

#[test]
fn what_rests_and_what_does_not() {
    for (method, kappa, object_kappa, rests) in [
        // The object hardly moves the device, so the hand's damping does not affect its oscillation.
        (MethodName::Basic, 0.01, 1.0, false),
        (MethodName::Basic, 1.0, 0.1, false),
        (MethodName::Basic, 0.1, 0.1, true),
        (MethodName::VirtualDamper, 0.01, 1.0, true),
        (MethodName::VirtualDamper, 3.0, 0.1, false),
        (MethodName::Hfcr, 1.0, 1.0, false),
        (MethodName::Coupled, 0.01, 1.0, true),
        (MethodName::Coupled, 1.0, 0.1, true),
        (MethodName::Coupled, 1.0, 4.0, true),
        (MethodName::Coupled, 3.0, 4.0, true),
        (MethodName::Coupled, 0.1, 4.0, true),
    ] {
        let stay = stay(&object(kappa, object_kappa), method);
        println!("{method}, kappa {kappa}, Kc {object_kappa}: {stay:?}");
        assert_eq!(stay.rests(), rests, "{method}, {kappa}, {object_kappa}");
        assert_eq!(stay.is_steady_pressed(), rests, "{stay:?}");
    }
}

#[test]
fn an_object_that_is_lost_does_not_rest() {
    // The force is 0 while the object flies, so there is no oscillation.
    let stay = stay(&object(3.1622776601683795, 0.001), MethodName::Basic);
    assert_eq!(stay.resting, Some(f64::INFINITY), "{stay:?}");
    assert!(!stay.rests());
}

#[test]
fn without_an_encoder_the_plain_spring_swings_as_much_whatever_presses() {
    for (kappa, object_kappa) in [(0.01, 0.01), (0.1, 0.1), (0.001, 1.0)] {
        let stay = stay(&object(kappa, object_kappa), MethodName::Basic);
        let resting = stay.resting.unwrap();
        assert!((resting - stay.pressed).abs() < 1e-6, "{stay:?}");
        // An ideal contact keeps its initial 10 %, a standard deviation of 7.07 %.
        assert!(resting > 0.0 && resting < 2.0 * RESTS_BELOW);
    }
}

#[test]
fn a_cell_has_the_contacts_that_stay_of_its_scene() {
    let params = params(5);
    for index in [0, 9, 15, 22] {
        let cell = params.run_cell(index).unwrap();
        let bounce = params.cell(index).bounce;
        for result in &cell.methods {
            let scene = bounce.on(result.bounce.plant);
            assert_eq!(result.stay, stay(&scene, result.bounce.method));
            assert_eq!(result.stay.resting.is_none(), bounce.is_wall());
        }
    }
}

/// A delay slightly below or above a whole number of periods, with a small lag, is nearly equivalent to that number.
#[test]
fn a_fraction_of_delay_and_a_lag_come_on_without_a_jump() {
    let bounce = params(5).cell(9).bounce.on(Plant::Undamped);
    let methods = [MethodName::HfcrModSt, MethodName::Coupled];
    let settings = methods.map(|method| (method, Settings::default()));
    let evaluated = |delay: f64, lag: f64| {
        let bounce = Bounce {
            delay,
            lag: lag * bounce.period,
            ..bounce
        };
        bounce.evaluate(Plant::Undamped, &settings).unwrap().0
    };
    let mut halves = Vec::new();
    for (whole, near, lag) in [(0.0, 1e-5, 0.0), (1.0, 1.0 - 1e-5, 0.0), (1.0, 1.0, 1e-5)] {
        for (whole, near) in evaluated(whole, 0.0).iter().zip(evaluated(near, lag)) {
            let (expected, found) = (whole.error.median, near.error.median);
            println!("{}: {expected} {found}", whole.method);
            assert!(
                (found - expected).abs() < 1e-3 + 0.01 * expected,
                "{near:?}"
            );
        }
        halves.push(evaluated(whole, 0.0)[0].error.median);
    }
    // Half a period differs from both.
    let half = evaluated(0.5, 0.2)[0].error.median;
    println!("hfcr-mod-st at half a period and a lag: {half}");
    assert!((half - halves[0]).abs() > 0.1 * halves[0]);
    assert!((half - halves[1]).abs() > 0.1 * halves[1]);
}

/// A renderer with a modelled delay of half a period and a modelled lag is stable where an unmodelled one is not.
#[test]
fn coupled_rendering_holds_at_half_a_period_of_delay_and_a_lag() {
    let bounce = Bounce {
        delay: 0.5,
        lag: 0.2 * params(5).period,
        ..params(5).cell(14).bounce.on(Plant::Undamped)
    };
    let methods = [MethodName::Coupled, MethodName::Basic];
    let settings = methods.map(|method| (method, Settings::default()));
    let (entries, _) = bounce.evaluate(Plant::Undamped, &settings).unwrap();
    for entry in &entries {
        println!("{}: {:?} {:?}", entry.method, entry.growth, entry.error);
    }
    assert!(entries[0].growth.worst < 1.05, "{:?}", entries[0]);
    assert!(entries[1].growth.median > 1.05, "{:?}", entries[1]);
}
