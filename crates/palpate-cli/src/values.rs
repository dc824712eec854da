//! Values of arguments, with messages for invalid ones.

use std::fmt;
use std::time::Duration;

use palpate_core::Side;
use palpate_record::trace::{Delimiter, Layout};
use palpate_record::unit::{LengthUnit, TimeUnit};
use palpate_rt::WorldAxis;
use palpate_scene::method::{MethodName, method_named};
use palpate_scene::world::WorldScene;
use palpate_scene::{GuardMode, HandForceAt, lag_question, period_question};
use palpate_study::suite::Set;
use palpate_study::sweep::Quantity;
use palpate_study::world::suite::WorldSet;
use palpate_testbed::hold::DelayedHold;

use crate::failure::{Failure, tell};

/// The methods to run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Methods(pub Vec<MethodName>);

/// The methods to run on a contact or on a world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AnyMethods {
    /// Whether the argument is `all`.
    pub are_all: bool,
    /// The named methods.
    pub names: Vec<&'static str>,
}

impl AnyMethods {
    /// Returns the methods that render one contact.
    pub fn of_contact(&self) -> Vec<MethodName> {
        let names = self.names.iter();
        names.filter_map(|name| MethodName::named(name)).collect()
    }

    /// Returns a named method that renders worlds only.
    pub fn of_worlds_only(&self) -> Option<&'static str> {
        let mut names = self.names.iter().copied();
        names.find(|name| MethodName::named(name).is_none())
    }
}

/// Parses `all`, or names separated by commas, of methods that render a contact or a world.
pub fn any_methods(text: &str) -> Result<AnyMethods, String> {
    if text == "all" {
        return Ok(AnyMethods {
            are_all: true,
            names: MethodName::ALL.map(MethodName::name).into(),
        });
    }
    let mut names = Vec::new();
    for name in text.split(',').map(str::trim) {
        let mut of_worlds = WorldScene::METHODS.into_iter();
        let name = match of_worlds.find(|known| *known == name) {
            Some(name) => name,
            None => method_named(name)
                .map_err(|error| {
                    let of_worlds = WorldScene::METHODS.join(", ");
                    format!("{error}; of a world: {of_worlds}")
                })?
                .name(),
        };
        if names.contains(&name) {
            return Err(format!("{name} is named twice"));
        }
        names.push(name);
    }
    Ok(AnyMethods {
        are_all: false,
        names,
    })
}

/// The values of a quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers(pub Vec<f64>);

/// Parses `all`, or names separated by commas.
pub fn methods(text: &str) -> Result<Methods, String> {
    if text == "all" {
        return Ok(Methods(MethodName::ALL.to_vec()));
    }
    let mut methods = Vec::new();
    for name in text.split(',') {
        let method = method_named(name.trim()).map_err(|error| error.to_string())?;
        if methods.contains(&method) {
            return Err(format!("{method} is named twice"));
        }
        methods.push(method);
    }
    Ok(Methods(methods))
}

/// Parses any number; the caller checks its range.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| "a number is needed, such as 0.01 or 1e-2".into())
}

/// Parses a period `[s]`, and warns of one that is probably in milliseconds.
pub fn period(text: &str) -> Result<f64, String> {
    let period = number(text)?;
    if let Some(question) = period_question("--period", "--period 0.001", period) {
        tell(format_args!("warning: {question}"));
    }
    Ok(period)
}

/// Parses a lag `[s]`, and warns of one that is probably in milliseconds.
pub fn lag(text: &str) -> Result<f64, String> {
    let lag = number(text)?;
    if let Some(question) = lag_question("--lag", "--lag 0.001", lag) {
        tell(format_args!("warning: {question}"));
    }
    Ok(lag)
}

/// Parses an integer of 0 or above.
pub fn whole<N: std::str::FromStr>(text: &str) -> Result<N, String> {
    text.parse()
        .map_err(|_| "a whole number from 0 on is needed".into())
}

/// Parses a limit above 0; infinite for no limit.
pub fn limit(text: &str) -> Result<f64, String> {
    number(text).and_then(|limit| {
        if limit > 0.0 {
            Ok(limit)
        } else {
            Err("a number above 0 is needed, or inf for no limit".into())
        }
    })
}

/// Parses the point of action of the hand's force on a pantograph.
pub fn force_place(text: &str) -> Result<HandForceAt, String> {
    let places = [HandForceAt::EndPoint, HandForceAt::Motors];
    places
        .into_iter()
        .find(|place| place.name() == text)
        .ok_or_else(|| {
            format!(
                "the places are {}",
                places.map(HandForceAt::name).join(", ")
            )
        })
}

/// Parses numbers separated by commas; the caller checks their range.
pub fn numbers(text: &str) -> Result<Numbers, String> {
    let values: Result<_, _> = text.split(',').map(|value| number(value.trim())).collect();
    values.map(Numbers)
}

/// The varied quantity or key.
#[derive(Clone, Debug, PartialEq)]
pub enum Over {
    /// A quantity of a scene.
    Quantity(Quantity),
    /// A key of a scene.
    Key(String),
}

impl Over {
    /// Returns the name of the quantity, or the key.
    pub fn name(&self) -> &str {
        match self {
            Self::Quantity(quantity) => quantity.name(),
            Self::Key(key) => key,
        }
    }
}

/// Parses a quantity or a key of a scene that can be varied.
pub fn over(text: &str) -> Result<Over, String> {
    let mut all = Quantity::ALL.into_iter();
    if let Some(quantity) = all.find(|quantity| quantity.name() == text) {
        return Ok(Over::Quantity(quantity));
    }
    if text.contains(['.', '[']) {
        return Ok(Over::Key(text.into()));
    }
    Err(format!(
        "the quantities are {}; a key is a path, such as body.0.mass_kg",
        Quantity::ALL.map(Quantity::name).join(", ")
    ))
}

/// Parses a family of random plants.
pub fn plant_set(text: &str) -> Result<PlantSet, String> {
    let mut worlds = WorldSet::ALL.into_iter();
    if let Some(set) = worlds.find(|set| set.name() == text) {
        return Ok(PlantSet::Worlds(set));
    }
    let mut sets = Set::ALL.into_iter();
    let set = sets.find(|set| set.name() == text);
    set.map(PlantSet::Contact).ok_or_else(|| {
        let names = Set::ALL.map(Set::name).join(", ");
        let worlds = WorldSet::ALL.map(WorldSet::name).join(", ");
        format!("the sets are {names}, {worlds}")
    })
}

/// A family of random scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantSet {
    /// One contact along one axis.
    Contact(Set),
    /// Several bodies in space.
    Worlds(WorldSet),
}

/// Parses a unit of positions.
pub fn length_unit(text: &str) -> Result<LengthUnit, String> {
    LengthUnit::of_symbol(text).ok_or_else(|| {
        let units = LengthUnit::ALL.map(LengthUnit::symbol).join(", ");
        format!("the units are {units}")
    })
}

/// Parses a unit of times.
pub fn time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::of_symbol(text).ok_or_else(|| {
        let units = TimeUnit::ALL.map(TimeUnit::symbol).join(", ");
        format!("the units are {units}")
    })
}

/// Parses the separator of a table's fields.
pub fn delimiter(text: &str) -> Result<Delimiter, String> {
    Delimiter::named(text).ok_or_else(|| "comma, semicolon or tab is needed".into())
}

/// Quantities, and the columns of a table that hold them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceColumns(pub Vec<(String, String)>);

/// Parses quantities and columns, such as `t=time,x=X`.
pub fn trace_columns(text: &str) -> Result<TraceColumns, String> {
    Layout::parse_columns(text).map(TraceColumns)
}

/// Parses two numbers of a range; the caller checks their order.
pub fn range(text: &str) -> Result<(f64, f64), String> {
    text.split_once(',')
        .and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)))
        .ok_or_else(|| "two numbers are needed, with a comma between, such as -0.05,0.05".into())
}

/// A position or a direction in the frame of a device with several axes.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameVector(pub Vec<f64>);

impl fmt::Display for FrameVector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<_> = self.0.iter().map(f64::to_string).collect();
        f.write_str(&numbers.join(","))
    }
}

/// Parses two or three finite numbers.
pub fn place(text: &str) -> Result<FrameVector, String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|number| number.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    numbers
        .filter(|numbers| (2..=3).contains(&numbers.len()))
        .map(FrameVector)
        .ok_or_else(|| "two or three numbers are needed, with commas between, such as 0,0.1".into())
}

/// World axes of a device's axes, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldAxes(pub Vec<WorldAxis>);

impl fmt::Display for WorldAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, along) in self.0.iter().enumerate() {
            let comma = if place > 0 { "," } else { "" };
            let sign = if along.is_reversed { "-" } else { "" };
            write!(f, "{comma}{sign}{}", ["x", "y", "z"][along.axis])?;
        }
        Ok(())
    }
}

/// Parses one to three different axes of a world.
pub fn world_axes(text: &str) -> Result<WorldAxes, String> {
    let axis = |word: &str| {
        let (name, is_reversed) = match word.trim().strip_prefix('-') {
            Some(rest) => (rest, true),
            None => (word.trim(), false),
        };
        let axis = ["x", "y", "z"].iter().position(|known| *known == name)?;
        Some(WorldAxis { axis, is_reversed })
    };
    let axes: Option<Vec<_>> = text.split(',').map(axis).collect();
    axes.filter(|axes| {
        let is_new = |(place, along): (usize, &WorldAxis)| {
            axes[..place].iter().all(|before| before.axis != along.axis)
        };
        (1..=3).contains(&axes.len()) && axes.iter().enumerate().all(is_new)
    })
    .map(WorldAxes)
    .ok_or_else(|| "one to three of x, y and z are needed, each once, with commas between and - for the opposite \
         direction, such as x,-z".into())
}

/// Boards of the 2DIY.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardName {
    /// Haply M0: an Arduino Zero
    M0,
    /// Haply M3: an Arduino Due
    M3,
    /// The modular development kit
    Dev,
}

/// Pose of an arm while its device is opened.
#[derive(Clone, Debug, PartialEq)]
pub enum StartPose {
    Retracted,
    Extended,
    /// Angles of its joints [degrees].
    Angles([f32; 2]),
}

/// Parses `retracted`, `extended` or two angles.
pub fn start_pose(text: &str) -> Result<StartPose, String> {
    match text {
        "retracted" => return Ok(StartPose::Retracted),
        "extended" => return Ok(StartPose::Extended),
        _ => {}
    }
    let angle = |text: &str| {
        text.trim()
            .parse()
            .ok()
            .filter(|angle: &f32| angle.is_finite())
    };
    text.split_once(',')
        .and_then(|(first, second)| Some(StartPose::Angles([angle(first)?, angle(second)?])))
        .ok_or_else(|| "retracted, extended or two angles are needed, such as 168,12".into())
}

/// Parses two finite numbers.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    match place(text) {
        Ok(FrameVector(numbers)) if numbers.len() == 2 => Ok([numbers[0], numbers[1]]),
        _ => Err("two numbers are needed, with a comma between, such as 0.02,0.12".into()),
    }
}

/// Converts the time of a flag.
pub fn duration(flag: &str, seconds: f64) -> Result<Duration, Failure> {
    Duration::try_from_secs_f64(seconds).map_err(|_| no_time(flag, seconds))
}

/// Explains a number of seconds that is not a valid time.
pub fn no_time(flag: &str, seconds: f64) -> Failure {
    Failure::Arguments(format!(
        "{flag}: {seconds} s is out of range; allowed: 0 to 1e19"
    ))
}

/// Parses a delay in periods that the simulation supports.
pub fn periods(text: &str) -> Result<f64, String> {
    const MOST: usize = DelayedHold::LONGEST_DELAY;
    match text.parse() {
        Ok(periods) if (0.0..=MOST as f64).contains(&periods) => Ok(periods),
        _ => Err(format!(
            "a number of periods is needed, from 0 to {MOST}, such as 1 or 0.5"
        )),
    }
}

/// Parses a side of the device.
pub fn side(text: &str) -> Result<Side, String> {
    Side::named(text)
        .ok_or_else(|| format!("the sides are {}", Side::ALL.map(Side::name).join(" and ")))
}

/// Parses the mode of a guard.
pub fn guard(text: &str) -> Result<GuardMode, String> {
    GuardMode::named(text).ok_or_else(|| {
        let [off, report, limit] = GuardMode::ALL.map(GuardMode::name);
        format!("the guard is {off}, {report} or {limit}")
    })
}
