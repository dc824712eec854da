//! Map figures: a column per method, a row per quantity and plant.

use palpate_record::map::{Format, Map, Row};
use palpate_scene::method::MethodName;
use palpate_study::map::{Plant, RESTS_BELOW, STABLE_UP_TO, bounds};

use crate::figure::{Bound, FieldFigure, FieldPanel, FieldRow, Scale};
use crate::results::SHOWN;
use palpate_study::map::metadata::{self, NoNumber};
use palpate_study::map::report::{FAITHFUL_PERCENT, is_faithful, is_stable, stay};

/// A quantity of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Growth of the energy per collision.
    Growth,
    /// Mean-force error E.
    Error,
    /// Force rendering error relative to the zero-order-hold bound.
    OverFloor,
    /// Force oscillation of an object that rests on the device under its weight.
    Resting,
    /// Force oscillation of a pressed contact.
    Pressed,
}

impl Quantity {
    /// All quantities, in listing order.
    pub const ALL: [Self; 5] = [
        Self::Growth,
        Self::Error,
        Self::OverFloor,
        Self::Resting,
        Self::Pressed,
    ];

    /// Returns the name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Growth => "growth",
            Self::Error => "error",
            Self::OverFloor => "over-floor",
            Self::Resting => "resting",
            Self::Pressed => "pressed",
        }
    }

    /// Returns a one-line description.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Growth => "Growth of the energy per collision",
            Self::Error => "Mean-force error E",
            Self::OverFloor => "Force rendering error over the hold bound",
            Self::Resting => "Force swing of an object that rests on the device by its weight",
            Self::Pressed => "Force swing of a pressed contact",
        }
    }
}

/// Requested content of a map figure that the map does not contain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotInTheMap {
    /// A quantity of sustained contacts, for a map that contains only bounces.
    #[error("{}: the map was made by an older version and has only bounces; compute it again", .0.name())]
    Quantity(Quantity),
    /// A method.
    #[error("{method} is not in the map, which has {has}")]
    Method {
        /// The method.
        method: MethodName,
        /// The methods that the map has, separated by commas.
        has: String,
    },
    /// A number of the metadata.
    #[error(transparent)]
    Number(#[from] NoNumber),
}

/// Length of the bounds of walls on the axis of Kc.
const NEARLY_A_WALL: f64 = 0.03;

/// Returns the quantities that a figure of this map shows: the `asked` ones, or by default growth and error, which
/// fit on a page.
///
/// # Errors
/// The map does not contain a requested quantity.
pub fn quantities(map: &Map, asked: &[Quantity]) -> Result<Vec<Quantity>, NotInTheMap> {
    let has_stays = map.format() == Some(Format::BouncesAndStays);
    let is_there = |quantity: &Quantity| {
        has_stays || !matches!(quantity, Quantity::Resting | Quantity::Pressed)
    };
    if asked.is_empty() {
        return Ok(vec![Quantity::Growth, Quantity::Error]);
    }
    match asked.iter().find(|quantity| !is_there(quantity)) {
        Some(missing) => Err(NotInTheMap::Quantity(*missing)),
        None => Ok(asked.to_vec()),
    }
}

/// Returns the methods that a figure of this map shows: the `asked` ones, or the default methods of a figure of many
/// methods.
///
/// # Errors
/// The map does not contain a requested method.
pub fn columns<'a>(
    map: &'a Map,
    asked: Option<&[MethodName]>,
) -> Result<Vec<&'a str>, NotInTheMap> {
    let all: Vec<&str> = map
        .value("methods")
        .unwrap_or_default()
        .split(' ')
        .collect();
    let Some(asked) = asked else {
        let shown = |name: &&str| SHOWN.iter().any(|method| method.name() == *name);
        let few: Vec<&str> = all.iter().copied().filter(shown).collect();
        return Ok(if all.len() > SHOWN.len() && !few.is_empty() {
            few
        } else {
            all
        });
    };
    // `all` selects all methods of the map.
    if asked.len() == MethodName::ALL.len() {
        return Ok(all);
    }
    if let Some(missing) = asked.iter().find(|method| !all.contains(&method.name())) {
        return Err(NotInTheMap::Method {
            method: *missing,
            has: all.join(", "),
        });
    }
    // The order of the map makes the figure independent of the order of the request.
    let is_asked = |name: &&str| asked.iter().any(|method| method.name() == *name);
    Ok(all.into_iter().filter(is_asked).collect())
}

/// States the share of the map on which each method keeps bounces stable from the worst start, on the damped device.
/// Sustained contacts are not counted.
fn finding(map: &Map, columns: &[&str]) -> String {
    let share = |method: &str| {
        let of_method = |row: &&Row| row.plant == Plant::Damped.name() && row.method == method;
        let rows: Vec<&Row> = map.rows.iter().filter(of_method).collect();
        let stable = rows.iter().filter(|row| is_stable(row)).count();
        100.0 * stable as f64 / rows.len().max(1) as f64
    };
    let mut shares: Vec<(&str, f64)> = columns.iter().map(|name| (*name, share(name))).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let named: Vec<String> = shares
        .iter()
        .take(SHOWN.len())
        .map(|(name, share)| format!("{name} {share:.0} %"))
        .collect();
    format!(
        "Stable bounces, share of the damped map: {}",
        named.join(", ")
    )
}

/// Returns the figure of a whole map.
pub fn figure(
    map: &Map,
    show: &[Quantity],
    methods: Option<&[MethodName]>,
) -> Result<FieldFigure, NotInTheMap> {
    let columns = columns(map, methods)?;
    let loop_numbers = LoopNumbers::new(map)?;
    let mut rows = Vec::new();
    let show = quantities(map, show)?;
    for quantity in &show {
        for plant in Plant::ALL {
            rows.push(FieldRow {
                name: plant.name().into(),
                scale: scale(*quantity),
                panels: columns
                    .iter()
                    .map(|method| panel(map, *quantity, plant, method, &loop_numbers))
                    .collect(),
            });
        }
    }
    Ok(FieldFigure {
        title: finding(map, &columns),
        subtitle: "Stiffness against the inertia of object and device".into(),
        footnote: footnote(map, &loop_numbers, &show) + about_bounds(&rows),
        x_label: "Kc = K T²/M [1]".into(),
        y_label: "κ = K T²/m [1]".into(),
        zero_label: "wall".into(),
        range: (1e-3, 10.0),
        columns: columns.into_iter().map(str::to_owned).collect(),
        rows,
    })
}

/// Parameters of the bounds.
struct LoopNumbers {
    /// b T/m of the damped plant.
    damping: f64,
    delay: f64,
    /// T²/m `[s²/kg]`
    per_stiffness: f64,
    friction: f64,
    period: f64,
    quantum: f64,
}

impl LoopNumbers {
    fn new(map: &Map) -> Result<Self, NoNumber> {
        let number = |key| metadata::number(map, key);
        let (mass, period) = (number("device_mass_kg")?, number("period_s")?);
        let friction = number("viscous_friction_n_s_per_m")?;
        Ok(Self {
            damping: friction * period / mass,
            delay: number("delay_samples")?,
            per_stiffness: period * period / mass,
            friction,
            period,
            quantum: number("encoder_quantum_m")?,
        })
    }
}

fn panel(
    map: &Map,
    quantity: Quantity,
    plant: Plant,
    method: &str,
    numbers: &LoopNumbers,
) -> FieldPanel {
    let of_panel = |row: &&Row| row.plant == plant.name() && row.method == method;
    let rows: Vec<&Row> = map.rows.iter().filter(of_panel).collect();
    let columns = rows
        .iter()
        .take_while(|row| row.kappa == rows[0].kappa)
        .count();
    let marked = |row: &Row| match quantity {
        Quantity::Growth => is_stable(row),
        Quantity::Error | Quantity::OverFloor => is_faithful(row),
        Quantity::Resting => stay(row).is_some_and(|stay| stay.resting.is_some() && stay.rests()),
        Quantity::Pressed => stay(row).is_some_and(|stay| stay.is_steady_pressed()),
    };
    FieldPanel {
        columns,
        values: rows
            .iter()
            .map(|row| match quantity {
                Quantity::Growth => row.growth[0],
                Quantity::Error => row.error[0],
                Quantity::OverFloor => row.error_over_bound[0],
                // Walls cannot rest on the device, so their strip stays blank.
                Quantity::Resting => stay(row).and_then(|stay| stay.resting).unwrap_or(f64::NAN),
                Quantity::Pressed => stay(row).map_or(f64::NAN, |stay| stay.pressed),
            })
            .collect(),
        marked: rows.iter().map(|row| marked(row)).collect(),
        bounds: if quantity == Quantity::Growth {
            bounds_on(plant, method, numbers)
        } else {
            Vec::new()
        },
    }
}

/// Returns the classical bounds of walls that apply to `method` on `plant`.
fn bounds_on(plant: Plant, method: &str, numbers: &LoopNumbers) -> Vec<Bound> {
    let bound = |name: &str, at: f64, look| Bound {
        name: name.into(),
        at,
        to: NEARLY_A_WALL,
        look,
    };
    if plant == Plant::Undamped {
        // The bound holds for the best virtual damper, whatever its B; the methods are drawn beside it.
        let name = "undamped wall with the best virtual damper: κ = 0.686";
        return vec![bound(name, bounds::stiffest_undamped_wall(), 0)];
    }
    let mut drawn = Vec::new();
    let without_dissipation = [MethodName::HfcrMod, MethodName::HfcrModSt];
    if numbers.delay == 0.0 && without_dissipation.iter().any(|of| method == of.name()) {
        // This is the only bound that also applies to objects, so it spans all of them.
        let name = "HFCR while contact is sustained, any mass: κ = b T/m";
        drawn.push(Bound {
            to: f64::INFINITY,
            ..bound(name, bounds::hfcr_sustained(numbers.damping), 2)
        });
    }
    if method == MethodName::VirtualDamper.name() {
        // The map's B is K T/2, so beta_B is kappa/2: kappa < 2 (beta_b - kappa/2).
        let name = "Colgate-Schenkel with B = K T/2: κ = b T/m";
        drawn.push(bound(name, numbers.damping, 3));
        return drawn;
    }
    let name = "Colgate-Schenkel: κ = 2 b T/m";
    let colgate = bounds::colgate_schenkel(numbers.damping, 0.0);
    drawn.push(bound(name, colgate, 1));
    let mut unless_equal = |name: &str, at: f64, look| {
        if (at / colgate - 1.0).abs() > 1e-6 {
            drawn.push(bound(name, at, look));
        }
    };
    let gil = bounds::gil(numbers.damping, 0.0, numbers.delay);
    unless_equal("Gil: κ = (b T/m)/(1/2 + delay)", gil, 2);
    let coulomb = 0.0;
    let abbott = numbers.per_stiffness
        * bounds::abbott_okamura(numbers.friction, coulomb, numbers.period, numbers.quantum);
    if abbott > 0.0 {
        unless_equal("Abbott-Okamura", abbott, 0);
    }
    drawn
}

fn scale(quantity: Quantity) -> Scale {
    match quantity {
        Quantity::Growth => Scale {
            name: "Energy growth per collision [1], median start".into(),
            steps: steps(&[
                ("#08306b", "≤ 0.5"),
                ("#3b7dbc", "≤ 0.9"),
                ("#9ecae1", "≤ 0.99"),
                ("#deebf7", "≤ 1.01: stable"),
                ("#fee391", "≤ 1.03"),
                ("#fe9929", "more: growing"),
                ("#7f2704", "diverged"),
            ]),
            limits: vec![0.5, 0.9, 0.99, STABLE_UP_TO, 1.03, f64::MAX],
            border: "border of stability from the worst start".into(),
        },
        Quantity::Error => Scale {
            name: "Mean-force error E [%], median start".into(),
            steps: steps(&[
                ("#00224e", "≤ 1"),
                ("#1f3f6e", "≤ 5"),
                ("#575d6d", "≤ 10"),
                ("#8a8779", "≤ 20"),
                ("#c3b369", "≤ 50"),
                ("#e8d35a", "≤ 100"),
                ("#fff3b0", "more: worse than zero force"),
            ]),
            limits: vec![1.0, 5.0, 10.0, FAITHFUL_PERCENT, 50.0, 100.0],
            border: "border of E < 20 % and stable, from the worst start".into(),
        },
        Quantity::OverFloor => Scale {
            name: "Force rendering error over the hold bound [1], median start".into(),
            steps: steps(&[
                ("#00224e", "≤ 1.05"),
                ("#1f3f6e", "≤ 1.2"),
                ("#575d6d", "≤ 1.5"),
                ("#8a8779", "≤ 2"),
                ("#c3b369", "≤ 5"),
                ("#e8d35a", "≤ 10"),
                ("#fff3b0", "more"),
            ]),
            limits: vec![1.05, 1.2, 1.5, 2.0, 5.0, 10.0],
            border: "border of E < 20 % and stable, from the worst start".into(),
        },
        Quantity::Resting => swing_scale(
            "Resting by its weight: standard deviation of the force over the weight, worse hand",
            "≤ 10 %: rests",
            "border of resting contacts, below 10 %",
        ),
        Quantity::Pressed => swing_scale(
            "Pressed with 3 N: standard deviation of the force over 3 N, worse hand",
            "≤ 10 %: steady",
            "border of steady contacts, below 10 %",
        ),
    }
}

fn swing_scale(name: &str, last: &str, border: &str) -> Scale {
    Scale {
        name: name.into(),
        steps: steps(&[
            ("#08306b", "≤ 0.1 %"),
            ("#3b7dbc", "≤ 1 %"),
            ("#9ecae1", "≤ 5 %"),
            ("#deebf7", last),
            ("#fee391", "≤ 100 %"),
            ("#fe9929", "more"),
            ("#7f2704", "lost or diverged"),
        ]),
        limits: vec![0.001, 0.01, 0.05, RESTS_BELOW, 1.0, f64::MAX],
        border: border.into(),
    }
}

fn steps(steps: &[(&'static str, &str)]) -> Vec<(&'static str, String)> {
    steps
        .iter()
        .map(|(colour, says)| (*colour, (*says).to_owned()))
        .collect()
}

/// Returns the note on the drawn bounds.
fn about_bounds(rows: &[FieldRow]) -> &'static str {
    let mut drawn = rows
        .iter()
        .flat_map(|row| &row.panels)
        .flat_map(|panel| &panel.bounds)
        .peekable();
    if drawn.peek().is_none() {
        return "";
    }
    if drawn.any(|bound| bound.to > NEARLY_A_WALL) {
        " Bounds are of walls and drawn up to Kc = 0.03, except the bound of HFCR's sustained contact."
    } else {
        " Bounds are of walls and drawn up to Kc = 0.03."
    }
}

fn footnote(map: &Map, numbers: &LoopNumbers, show: &[Quantity]) -> String {
    let value = |key: &str| map.value(key).unwrap_or("?");
    let forces = if value("forces") == "balanced" {
        format!(
            "equal and opposite forces ({} m/s² of approach)",
            value("approach_m_per_s2")
        )
    } else {
        format!(
            "a hand of {} N and gravity of {} m/s²",
            value("user_force_n"),
            value("gravity_m_per_s2")
        )
    };
    let mut unusual = String::new();
    for (key, usual, name) in [
        ("encoder_quantum_m", "0", "encoder quantum [m]"),
        ("delay_samples", "0", "delay [periods]"),
        ("lag_periods", "0", "lag [periods]"),
        (
            "delay_deviation_periods",
            "0",
            "deviation of the delay in the renderer's model [periods]",
        ),
        (
            "lag_deviation_periods",
            "0",
            "deviation of the lag in the renderer's model [periods]",
        ),
        ("model_mass_factor", "1", "model mass over the true one"),
        ("model_period_factor", "1", "model period over the true one"),
    ] {
        if let Some(value) = map.value(key)
            && value != usual
        {
            unusual.push_str(&format!(", {name} {value}"));
        }
    }
    let stays = if show.contains(&Quantity::Resting) || show.contains(&Quantity::Pressed) {
        format!(
            " A sustained contact begins {} of its deflection away from its rest position, in each of two hands ({}); \
             these rows therefore hold only for this device and period.",
            value("stay_begins_off"),
            value("stay_hands")
        )
    } else {
        String::new()
    };
    format!(
        "An object bounces on a point-mass device ({} kg, {} s, gap {} m ± 5 % in {} start heights) \
         under {forces}{unusual}. Damped: viscous friction b T/m = {:.4} of the device. Growth: over \
         {} ideal collisions; E: over the first {}.{stays}",
        value("device_mass_kg"),
        value("period_s"),
        value("gap_m"),
        value("start_heights"),
        numbers.damping,
        value("growth_collisions"),
        value("error_collisions"),
    )
}
