//! Figure of an advice: the highest renderable contact stiffness over the object's mass, and the requested contact.

use crate::figure::{Grid, Kind, Limits, Panel, Role, Row, Series, Sheet};
use palpate_scene::method::MethodName;
use palpate_study::map::{Limit, MethodReach, Reach};

use crate::results::SHOWN;
use palpate_study::advise::{Advice, FAITHFUL_PERCENT, Verdict};
use palpate_study::text::digits;

/// Returns the methods that the figure shows.
#[must_use]
pub fn shown_of(methods: &[MethodName]) -> Vec<MethodName> {
    if methods.len() <= SHOWN.len() {
        return methods.to_vec();
    }
    SHOWN
        .into_iter()
        .filter(|method| methods.contains(method))
        .collect()
}

/// Returns the figure of an advice, with one panel per method.
#[must_use]
pub fn advice(advice: &Advice, reach: &Reach) -> Sheet {
    let masses: Vec<f64> = reach.masses.iter().map(|mass| mass.log10()).collect();
    let device = &advice.device;
    let asked = advice.contact.as_ref().map(|contact| {
        // A wall is drawn at the largest mass.
        let mass = device
            .object_mass_kg
            .map_or(masses[masses.len() - 1], f64::log10);
        (mass, contact.stiffness_n_per_m.log10())
    });
    let panel = |of: &MethodReach| {
        let limit = |name: String, role, limits: &[Option<Limit>]| Series {
            name,
            kind: Kind::Line,
            role,
            x: masses.clone(),
            y: limits.iter().map(|limit| height(*limit)).collect(),
        };
        let mut series = vec![
            limit("stable below".into(), Role::Compared(1), &of.stable),
            limit(
                format!("and E < {FAITHFUL_PERCENT} % below"),
                Role::Compared(0),
                &of.faithful,
            ),
        ];
        series.extend(asked.map(|(mass, stiffness)| Series {
            name: format!("requested: {}", wish(advice)),
            kind: Kind::Points,
            role: Role::Mark,
            x: vec![mass],
            y: vec![stiffness],
        }));
        Panel { series }
    };
    Sheet {
        title: finding(advice),
        subtitle: format!(
            "Stiffness against the object's mass, on a device of {} kg at {} s",
            device.mass_kg, device.period_s
        ),
        footnote: Some(format!(
            "From each of {} start heights, with the default settings of each method. Stable: no bounce gains more \
             than 1 % of energy. E: error of the mean force of each period. Panel without a line: even the softest \
             contact is unstable. Line at the top: end of the search, at kappa = 100. The lines ignore resting and \
             pressed contacts; the title includes them.",
            device.start_heights
        )),
        x_label: "object mass M [kg]".into(),
        x_decades: true,
        lines: vec![vec![Grid {
            columns: reach.methods.iter().map(|of| head(advice, of)).collect(),
            rows: vec![Row {
                y_label: "stiffness K [N/m]".into(),
                y_decades: true,
                limits: Limits::Data,
                panels: reach.methods.iter().map(panel).collect(),
            }],
            ..Grid::default()
        }]],
        ..Sheet::default()
    }
}

/// Returns the logarithm of a limit; NaN without a limit.
fn height(limit: Option<Limit>) -> f64 {
    match limit {
        Some(Limit::At(value) | Limit::Beyond(value)) => value.log10(),
        Some(Limit::None) | None => f64::NAN,
    }
}

fn wish(advice: &Advice) -> String {
    advice.contact.as_ref().map_or_else(String::new, |contact| {
        format!("{} N/m for {}", contact.stiffness_n_per_m, advice.object())
    })
}

/// Returns the name of a method and its result for the requested contact.
fn head(advice: &Advice, of: &MethodReach) -> String {
    let name = of.method.name();
    let found = advice.methods.iter().find(|one| one.method == name);
    found.and_then(|one| one.by_itself.as_ref()).map_or_else(
        || name.into(),
        |evaluated| format!("{name}: {}", evaluated.class),
    )
}

/// Returns the answer as one line.
fn finding(advice: &Advice) -> String {
    let wish = wish(advice);
    match advice.verdict {
        Verdict::Yes { method, .. } => format!("{wish}: yes, by {method}"),
        Verdict::Swings { method, .. } => {
            format!("{wish}: no, the force swings at rest or pressed, even by {method}")
        }
        Verdict::HoldTooCoarse { method, .. } => {
            format!("{wish}: stable by {method}, but the period is too long for the force")
        }
        Verdict::StableOnly { method, .. } => {
            format!("{wish}: stable by {method}, but its force is far from the ideal")
        }
        Verdict::TooFlexible { .. } => format!("{wish}: no, beyond the device's resonance"),
        Verdict::No { method, .. } => format!("{wish}: no, not even by {method}"),
        Verdict::NotAsked => {
            let limits = advice.methods.iter().filter_map(|of| {
                let limit = of.stiffest_n_per_m;
                Some((of.method, limit.value?, limit.or_beyond))
            });
            match limits.max_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((method, value, beyond)) => format!(
                    "Stiffest stable contact with {}: {} N/m{}, by {method}",
                    advice.object(),
                    digits(value),
                    if beyond { " or more" } else { "" }
                ),
                None => format!("No stable contact with {} by any method", advice.object()),
            }
        }
    }
}
