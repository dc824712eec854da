//! Values of arguments, and what is said of one that is not understood.

use palpate::{SehEstimate, Side};
use palpate_sim::method::{Damping, MethodName, Predictor};
use palpate_sim::scene::GuardMode;
use palpate_testbed::hold::DelayedHold;

/// The methods a command is to run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Methods(pub Vec<MethodName>);

/// `all`, or names separated by commas.
pub fn methods(text: &str) -> Result<Methods, String> {
    if text == "all" {
        return Ok(Methods(MethodName::ALL.to_vec()));
    }
    let mut methods = Vec::new();
    for name in text.split(',') {
        let method: MethodName = name.trim().parse().map_err(|error| format!("{error}"))?;
        if methods.contains(&method) {
            return Err(format!("{method} is named twice"));
        }
        methods.push(method);
    }
    Ok(Methods(methods))
}

/// Any number; its range is the business of what it is for.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| "a number is needed, such as 0.01 or 1e-2".into())
}

/// From one number to another; which of them is larger is the business of what it is for.
pub fn range(text: &str) -> Result<(f64, f64), String> {
    text.split_once(',')
        .and_then(|(from, to)| Some((from.trim().parse().ok()?, to.trim().parse().ok()?)))
        .ok_or_else(|| "two numbers are needed, with a comma between, such as -0.05,0.05".into())
}

/// A delay that the bench can hold.
pub fn samples(text: &str) -> Result<usize, String> {
    const MOST: usize = DelayedHold::LONGEST_DELAY;
    match text.parse() {
        Ok(samples) if samples <= MOST => Ok(samples),
        _ => Err(format!(
            "a whole number of samples is needed, from 0 to {MOST}"
        )),
    }
}

/// A number or `auto`.
pub fn damping(text: &str) -> Result<Damping, String> {
    if text == "auto" {
        return Ok(Damping::Auto);
    }
    text.parse()
        .map(Damping::Value)
        .map_err(|_| "a number in N s/m or \"auto\" is needed".into())
}

/// A side of the device.
pub fn side(text: &str) -> Result<Side, String> {
    match text {
        "positive" => Ok(Side::Positive),
        "negative" => Ok(Side::Negative),
        _ => Err("the sides are positive and negative".into()),
    }
}

/// A member of the SEH family.
pub fn estimate(text: &str) -> Result<SehEstimate, String> {
    match text {
        "ab2" => Ok(SehEstimate::Ab2),
        "differences" => Ok(SehEstimate::Differences),
        "ab3" => Ok(SehEstimate::Ab3),
        _ => Err("the estimates are ab2, differences and ab3".into()),
    }
}

/// A way to predict the device.
pub fn predictor(text: &str) -> Result<Predictor, String> {
    match text {
        "constant-velocity" => Ok(Predictor::ConstantVelocity),
        "observer" => Ok(Predictor::Observer),
        _ => Err("the predictions are constant-velocity and observer".into()),
    }
}

/// What a guard does.
pub fn guard(text: &str) -> Result<GuardMode, String> {
    match text {
        "off" => Ok(GuardMode::Off),
        "report" => Ok(GuardMode::Report),
        "limit" => Ok(GuardMode::Limit),
        _ => Err("the guard is off, report or limit".into()),
    }
}
