//! Delay, lag and gain of a loop: told exactly, wrongly, or not at all.

use palpate::{Actuation, AnyParams, CoupledParams, LoopParams};

use crate::desk::{Desk, draw};

fn told(desk: &Desk, actuation: Actuation<f64>, mass_factor: f64) -> f64 {
    let periods = desk.window(600);
    let ideal = desk.ideal(periods);
    let loop_params = LoopParams {
        actuation,
        ..LoopParams::new(desk.period)
    };
    let params = AnyParams::Coupled(
        CoupledParams::new(desk.device_mass * mass_factor).with_encoder_quantum(desk.quantum),
    );
    let rendered = desk.rendered(loop_params, params, periods, 5);
    desk.error(&ideal, &rendered)
}

#[test]
fn table() {
    let t = 1e-3;
    let a = |d: f64, l: f64| Actuation::after(d * t).with_lag(l);
    let plain = |d: &mut Desk| d.quantum = 0.0;
    type Edit = Box<dyn Fn(&mut Desk)>;
    let rows: Vec<(&str, Edit, Actuation<f64>)> = vec![
        ("no delay", Box::new(plain), a(0.0, 0.0)),
        ("1 T told 1", Box::new(move |d| d.delay = t), a(1.0, 0.0)),
        (
            ".3 T untold",
            Box::new(move |d| d.delay = 0.3 * t),
            a(0.0, 0.0),
        ),
        (
            ".3 T told",
            Box::new(move |d| d.delay = 0.3 * t),
            a(0.3, 0.0),
        ),
        (
            ".3 T untold, 10 um",
            Box::new(move |d| {
                d.delay = 0.3 * t;
                d.quantum = 1e-5
            }),
            a(0.0, 0.0),
        ),
        (
            ".1 T untold",
            Box::new(move |d| d.delay = 0.1 * t),
            a(0.0, 0.0),
        ),
        (
            ".3 T told 1 T",
            Box::new(move |d| d.delay = 0.3 * t),
            a(1.0, 0.0),
        ),
        (
            ".5 T + .3 ms told",
            Box::new(move |d| {
                d.delay = 0.5 * t;
                d.lag = 3e-4
            }),
            a(0.5, 3e-4),
        ),
        (
            ".5 T + .3 ms untold",
            Box::new(move |d| {
                d.delay = 0.5 * t;
                d.lag = 3e-4
            }),
            a(0., 0.),
        ),
        (
            ".5 T + .3 ms told .52",
            Box::new(move |d| {
                d.delay = 0.5 * t;
                d.lag = 3e-4
            }),
            a(0.52, 3e-4),
        ),
        (
            ".5 T + .3 ms told .8",
            Box::new(move |d| {
                d.delay = 0.5 * t;
                d.lag = 3e-4
            }),
            a(0.8, 0.0),
        ),
        (
            ".5 T + .3 ms told, 10 um",
            Box::new(move |d| {
                d.delay = 0.5 * t;
                d.lag = 3e-4;
                d.quantum = 1e-5
            }),
            a(0.5, 3e-4),
        ),
        (
            "jitter .1 T, mean told",
            Box::new(move |d| d.jitter = 0.1 * t),
            a(0.05, 0.0),
        ),
        (
            "gain .9 untold",
            Box::new(move |d| d.gain = 0.9),
            a(0.0, 0.0),
        ),
        (
            "gain .9 told",
            Box::new(move |d| d.gain = 0.9),
            a(0.0, 0.0).with_gain(0.9),
        ),
    ];
    for (name, edit, actuation) in rows {
        for factor in [1.5] {
            let mut all: Vec<f64> = (0..30)
                .map(|seed| {
                    let mut desk = draw(seed);
                    edit(&mut desk);
                    told(&desk, actuation, factor)
                })
                .collect();
            all.sort_by(f64::total_cmp);
            println!(
                "{name:28} x{factor:3} {:7.2} {:7.2} {:7.2}",
                all[15], all[26], all[29]
            );
        }
    }
}

#[test]
fn pressed() {
    let t = 1e-3;
    for (name, delay, lag, quantum) in [
        ("0", 0.0, 0.0, 0.0),
        ("1", 1.0, 0.0, 0.0),
        (".5", 0.5, 0.0, 0.0),
        (".5 1um", 0.5, 0.0, 1e-6),
        (".5+.3", 0.5, 0.3, 0.0),
        (".5+.3 10um", 0.5, 0.3, 1e-5),
        ("1.5", 1.5, 0.0, 0.0),
    ] {
        for damping in [0.01, 1.0] {
            let mut line = String::new();
            for kappa in [0.1, 0.3, 1.0, 2.0, 4.0, 10.0] {
                let mut desk = draw(3);
                desk.device_mass = 0.2;
                desk.object_mass = f64::INFINITY;
                desk.stiffness = kappa * desk.device_mass / (t * t);
                desk.hand = (0.0, damping);
                desk.push = 2.0;
                desk.gap = 2e-4;
                desk.quantum = quantum;
                desk.delay = delay * t;
                desk.lag = lag * t;
                let actuation = Actuation::after(desk.delay).with_lag(desk.lag);
                let loop_params = LoopParams {
                    actuation,
                    ..LoopParams::new(desk.period)
                };
                let params = AnyParams::Coupled(
                    CoupledParams::new(desk.device_mass * 1.5).with_encoder_quantum(quantum),
                );
                let f = desk.rendered(loop_params, params, 6000, 5);
                let last = &f[f.len() - 1000 * 200..];
                let mean = last.iter().sum::<f64>() / last.len() as f64;
                let sd = (last.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / last.len() as f64)
                    .sqrt();
                line += &format!(" {kappa}: {:.2}({:.2})", 100.0 * sd / 2.0, mean);
            }
            println!("{name:10} b={damping} {line}");
        }
    }
}

#[test]
fn undamped_wall() {
    let t = 1e-3;
    for (delay, lag) in [
        (0.0, 0.0),
        (1.0, 0.0),
        (0.5, 0.0),
        (0.25, 0.0),
        (0.75, 0.0),
        (0.5, 0.3),
        (0.01, 0.0),
        (0.0, 0.3),
    ] {
        let mut line = String::new();
        for (kappa, b) in [
            (0.1, 0.01),
            (1.0, 0.01),
            (4.0, 0.01),
            (2.0, 1.0),
            (4.0, 1.0),
        ] {
            let mut desk = draw(3);
            desk.device_mass = 0.2;
            desk.object_mass = f64::INFINITY;
            desk.stiffness = kappa * desk.device_mass / (t * t);
            desk.hand = (0.0, b);
            desk.push = 2.0;
            desk.gap = 2e-4;
            desk.delay = delay * t;
            desk.lag = lag * t;
            let actuation = Actuation::after(desk.delay).with_lag(desk.lag);
            let loop_params = LoopParams {
                actuation,
                ..LoopParams::new(desk.period)
            };
            let params = AnyParams::Coupled(CoupledParams::new(desk.device_mass * 1.0));
            for n in [25, 50, 100, 200, 400] {
                let f = desk.rendered(loop_params, params, n, 5);
                let ideal = desk.ideal(n);
                line += &format!(" {kappa},{n}: {:.2}", desk.error(&ideal, &f));
            }
        }
        println!("{delay} {lag} {line}");
    }
}

#[test]
fn untold() {
    let t = 1e-3;
    for delay in [0.0, 0.1, 0.3, 0.5] {
        for (k, b) in [(0.0, 1.0), (300.0, 3.0)] {
            let mut line = String::new();
            for kappa in [0.02, 0.1, 0.3, 1.0, 2.0] {
                let mut desk = draw(3);
                desk.device_mass = 0.2;
                desk.object_mass = f64::INFINITY;
                desk.stiffness = kappa * desk.device_mass / (t * t);
                desk.hand = (k, b);
                desk.push = 2.0;
                desk.gap = 2e-4;
                desk.clip = 10.0;
                desk.quantum = 1e-6;
                desk.delay = delay * t;
                let loop_params = LoopParams {
                    ..LoopParams::new(desk.period)
                };
                let params = AnyParams::Coupled(
                    CoupledParams::new(desk.device_mass * 1.5).with_encoder_quantum(1e-6),
                );
                let f = desk.rendered(loop_params, params, 6000, 5);
                let last = &f[f.len() - 1000 * 200..];
                let mean = last.iter().sum::<f64>() / last.len() as f64;
                let sd = (last.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / last.len() as f64)
                    .sqrt();
                line += &format!(" {kappa}: {:.2}({:.2})", 100.0 * sd / 2.0, mean);
            }
            println!("untold {delay:10} hand={k},{b} {line}");
        }
    }
}
