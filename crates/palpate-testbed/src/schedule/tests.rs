//! Tests of the schedule.

use super::*;

fn ticks(params: ScheduleParams, count: usize) -> Vec<Tick> {
    Schedule::new(params).unwrap().take(count).collect()
}

#[test]
fn a_perfect_loop_samples_at_multiples_and_holds_at_once() {
    for (i, tick) in ticks(ScheduleParams::perfect(1e-3), 10_000)
        .iter()
        .enumerate()
    {
        assert_eq!(tick.index, i as u64);
        assert_eq!(tick.sample_time, i as f64 * 1e-3);
        assert_eq!(tick.hold_from, tick.sample_time);
    }
}

#[test]
fn a_loop_begins_with_a_sample_at_0_however_imperfect() {
    for seed in 0..50 {
        let params = ScheduleParams {
            jitter: Jitter::Uniform { bound: 4e-4 },
            dropped: Dropped::Probability(0.9),
            seed,
            ..ScheduleParams::perfect(1e-3)
        };
        let first = ticks(params, 1)[0];
        assert_eq!((first.index, first.sample_time), (0, 0.0));
    }
}

#[test]
fn jitter_stays_in_its_bound_has_its_width_and_no_mean() {
    let bound = 2e-4;
    let third = bound / 3.0_f64.sqrt();
    for (jitter, deviation) in [
        (Jitter::Uniform { bound }, third),
        (
            Jitter::Normal {
                deviation: 5e-5,
                bound,
            },
            5e-5,
        ),
        // Far wider than its bound, a normal distribution is flat.
        (
            Jitter::Normal {
                deviation: 1.0,
                bound,
            },
            third,
        ),
    ] {
        let count = 20_000;
        let params = ScheduleParams {
            jitter,
            seed: 7,
            ..ScheduleParams::perfect(1e-3)
        };
        let late: Vec<f64> = ticks(params.clone(), count)
            .iter()
            .skip(1) // the first is at 0
            .map(|tick| tick.sample_time - tick.index as f64 * 1e-3)
            .collect();
        let n = late.len() as f64;
        let mean = late.iter().sum::<f64>() / n;
        let square = late.iter().map(|x| x * x).sum::<f64>() / n;
        assert!(late.iter().all(|x| x.abs() <= bound * (1.0 + 1e-9)));
        assert!(mean.abs() < 4.0 * deviation / n.sqrt(), "{mean}");
        assert!((square.sqrt() / deviation - 1.0).abs() < 0.03, "{square}");

        assert_eq!(ticks(params.clone(), 50), ticks(params.clone(), 50));
        let other = ScheduleParams {
            seed: 8,
            ..params.clone()
        };
        assert_ne!(ticks(other, 50)[1], ticks(params, 50)[1]);
    }
}

#[test]
fn drops_leave_gaps_and_do_not_move_the_other_samples() {
    let params = ScheduleParams {
        jitter: Jitter::Uniform { bound: 1e-4 },
        ..ScheduleParams::perfect(1e-3)
    };
    let whole = ticks(params.clone(), 20_000);
    let listed = ScheduleParams {
        dropped: Dropped::Listed(vec![1, 3, 4]),
        ..params.clone()
    };
    let kept: Vec<u64> = ticks(listed, 4).iter().map(|tick| tick.index).collect();
    assert_eq!(kept, [0, 2, 5, 6]);

    let some = ticks(
        ScheduleParams {
            dropped: Dropped::Probability(0.25),
            ..params
        },
        14_000,
    );
    for tick in &some {
        if let Some(same) = usize::try_from(tick.index).ok().and_then(|i| whole.get(i)) {
            assert_eq!(tick, same);
        }
    }
    // Early samples are dropped no more often than late ones.
    let late = |tick: &Tick| tick.sample_time - tick.index as f64 * 1e-3;
    let mean = some.iter().map(late).sum::<f64>() / 14_000.0;
    assert!(
        mean.abs() < 4.0 * 1e-4 / (3.0 * 14_000.0_f64).sqrt(),
        "{mean}"
    );
    let share = 14_000.0 / (some[13_999].index + 1) as f64;
    assert!((share - 0.75).abs() < 0.015, "{share}");
}

#[test]
fn a_collapse_changes_the_grid_where_it_is_and_nowhere_else() {
    let collapse = RateCollapse {
        from: 0.0025,
        until: 0.0125,
        period: 0.004,
    };
    let params = ScheduleParams {
        collapse: Some(collapse),
        ..ScheduleParams::perfect(0.001)
    };
    let expected = [0.0, 1.0, 2.0, 3.0, 7.0, 11.0, 15.0, 16.0, 17.0];
    for (tick, milliseconds) in ticks(params, 9).iter().zip(expected) {
        assert!((tick.sample_time - milliseconds * 1e-3).abs() < 1e-15);
    }
}

#[test]
fn commands_reach_the_motor_late_and_in_order() {
    let delay = ActuationDelay {
        samples: 2,
        fraction: 0.25,
        ..ActuationDelay::default()
    };
    let params = ScheduleParams {
        delay,
        ..ScheduleParams::perfect(0.001)
    };
    for tick in ticks(params.clone(), 100) {
        assert!((tick.hold_from - tick.sample_time - 0.00225).abs() < 1e-15);
    }
    // Back from a slow grid to a fast one, commands would overtake each other.
    let collapse = RateCollapse {
        from: 0.0,
        until: 0.01,
        period: 0.01,
    };
    let both = ticks(
        ScheduleParams {
            collapse: Some(collapse),
            ..params
        },
        40,
    );
    assert_eq!(both[0].hold_from, 0.0225);
    assert_eq!(both[1].hold_from, 0.0225);
    assert!(
        both.windows(2)
            .all(|pair| pair[0].hold_from <= pair[1].hold_from)
    );
    assert!((both[39].hold_from - both[39].sample_time - 0.00225).abs() < 1e-15);
}

#[test]
fn a_delay_in_seconds_does_not_follow_the_grid_and_jitter_of_commands_only_adds_to_it() {
    let slow = RateCollapse {
        from: 0.1,
        until: 0.2,
        period: 0.01,
    };
    let params = |jitter: f64| ScheduleParams {
        collapse: Some(slow),
        delay: ActuationDelay {
            seconds: 0.00137,
            jitter,
            ..ActuationDelay::default()
        },
        seed: 5,
        ..ScheduleParams::perfect(0.001)
    };
    let even = ticks(params(0.0), 500);
    for tick in &even {
        assert!((tick.hold_from - tick.sample_time - 0.00137).abs() < 1e-15);
    }
    let bound = 1e-4;
    let late: Vec<f64> = ticks(params(bound), 20_000)
        .iter()
        .map(|tick| tick.hold_from - tick.sample_time - 0.00137)
        .collect();
    assert!(
        late.iter()
            .all(|late| (-1e-12..bound + 1e-12).contains(late))
    );
    let mean = late.iter().sum::<f64>() / 20_000.0;
    println!("mean lateness {mean} s of a bound of {bound} s");
    let deviation = bound / 12.0_f64.sqrt();
    assert!((mean - 0.5 * bound).abs() < 4.0 * deviation / 20_000.0_f64.sqrt());
    // The samples are taken when they were.
    let times = |ticks: &[Tick]| {
        ticks
            .iter()
            .map(|tick| tick.sample_time)
            .collect::<Vec<_>>()
    };
    assert_eq!(times(&ticks(params(bound), 500)), times(&even));
}

#[test]
fn a_rejected_parameter_is_named() {
    let perfect = ScheduleParams::perfect(1e-3);
    let rejected = |params: ScheduleParams| Schedule::new(params).unwrap_err().name;
    assert_eq!(
        rejected(ScheduleParams::perfect(0.0)),
        ScheduleParameter::Period
    );
    let half = Jitter::Uniform { bound: 5e-4 };
    assert_eq!(
        rejected(ScheduleParams {
            jitter: half,
            ..perfect.clone()
        }),
        ScheduleParameter::JitterBound
    );
    assert_eq!(
        rejected(ScheduleParams {
            dropped: Dropped::Probability(1.0),
            ..perfect.clone()
        }),
        ScheduleParameter::Dropped
    );
    for indices in [vec![4, 4], vec![0, 4]] {
        assert_eq!(
            rejected(ScheduleParams {
                dropped: Dropped::Listed(indices),
                ..perfect.clone()
            }),
            ScheduleParameter::Dropped
        );
    }
    let delay = ActuationDelay {
        samples: 0,
        fraction: f64::NAN,
        ..ActuationDelay::default()
    };
    assert_eq!(
        rejected(ScheduleParams {
            delay,
            ..perfect.clone()
        }),
        ScheduleParameter::DelayFraction
    );
    for seconds in [-1e-9, 1.1, f64::NAN, f64::INFINITY] {
        let delay = ActuationDelay {
            seconds,
            ..ActuationDelay::default()
        };
        let late = ScheduleParams {
            delay,
            ..perfect.clone()
        };
        assert_eq!(rejected(late), ScheduleParameter::DelaySeconds);
        let delay = ActuationDelay {
            jitter: seconds,
            ..ActuationDelay::default()
        };
        let late = ScheduleParams {
            delay,
            ..perfect.clone()
        };
        assert_eq!(rejected(late), ScheduleParameter::CommandJitter);
    }
}
