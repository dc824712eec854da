//! Checks of a device and its loop, with a remedy for each warning.

use crate::calibrate::Quantity;
use serde::Serialize;

use super::ticks::Ticks;
use super::{Card, Sources};
use crate::recording::{motors_off, shortcomings};
use crate::text::{counted, digits};

/// Limits of a warning: share of late ticks, and lateness relative to the period.
const LATE_SHARE: f64 = 0.01;
const LATE: f64 = 0.1;
/// Unmodelled delay relative to the period from which coupled rendering loses its advantage.
const DELAY: f64 = 0.03;
/// Coulomb friction relative to the largest force from which it masks rendered forces.
const FRICTION: f64 = 0.2;
/// Minimum number of sensor counts in the deepest penetration of a contact.
const COUNTS: f64 = 20.0;
/// Frequency of a contact relative to the resonance from which the device is not rigid.
const RESONANCE: f64 = 1.0 / 3.0;
/// Limits of the standard deviations: delay and lag relative to the period, mass relative to the mass.
const DELAY_DEVIATION: f64 = 0.1;
const MASS_DEVIATION: f64 = 0.1;
/// Share of ticks with a force changed by the safety layer from which a warning is given.
const LIMITED_SHARE: f64 = 0.01;

/// A check and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Check {
    /// Name of the check.
    pub name: &'static str,
    /// Outcome of the check.
    pub outcome: Outcome,
    /// Finding, or the information that is missing for the check.
    pub finding: String,
    /// Remedy; none if there is no warning.
    pub remedy: Option<String>,
}

/// Outcome of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// A problem was found.
    Warning,
    /// No problem was found.
    InOrder,
    /// The check needs information that is not available.
    NotChecked,
}

/// Creates a check with a warning, or in order with the same finding.
fn check(name: &'static str, is_wrong: bool, finding: String, remedy: &str) -> Check {
    Check {
        name,
        outcome: if is_wrong {
            Outcome::Warning
        } else {
            Outcome::InOrder
        },
        finding,
        remedy: is_wrong.then(|| remedy.to_owned()),
    }
}

fn not_checked(name: &'static str, why: &str) -> Check {
    Check {
        name,
        outcome: Outcome::NotChecked,
        finding: why.to_owned(),
        remedy: None,
    }
}

/// Runs all checks; warnings come first.
pub(super) fn of(card: &Card, sources: &Sources<'_>, read: &[Ticks]) -> Vec<Check> {
    let mut checks = Vec::new();
    if sources.recordings.is_empty() {
        let why = "no recording of its loop";
        for name in ["late ticks", "lost samples", "motors off", "safety limits"] {
            checks.push(not_checked(name, why));
        }
    }
    for (number, ticks) in read.iter().enumerate() {
        checks.extend(of_recording(card, sources, number, ticks));
    }
    checks.push(delay(card, sources));
    checks.push(friction(card));
    checks.push(resonance(card));
    checks.push(quantum(card));
    checks.extend(calibration(card));
    checks.sort_by_key(|check| check.outcome as u8);
    checks
}

fn of_recording(card: &Card, sources: &Sources<'_>, number: usize, ticks: &Ticks) -> Vec<Check> {
    let recording = &sources.recordings[number];
    let timing = &card.timing[number];
    let name = &timing.recording;
    let all = ticks.all.len().max(1) as f64;
    let percent = |count: u64| digits(100.0 * count as f64 / all);
    let mut checks = Vec::new();
    let period = timing.period_asked_s;
    checks.push(match (period, &timing.lateness_s) {
        (Some(period), Some(lateness)) => check(
            "late ticks",
            ticks.missed_deadlines as f64 > LATE_SHARE * all || lateness.p99 > LATE * period,
            format!(
                "{name}: {} % of the ticks missed their deadline; 99 % were at most {} ms late, the latest {} ms, at \
                 a period of {} ms",
                percent(ticks.missed_deadlines),
                digits(1e3 * lateness.p99.max(0.0)),
                digits(1e3 * lateness.largest.max(0.0)),
                digits(1e3 * period)
            ),
            "run `palpate doctor` to check the machine's limits of a loop and how to raise them; then use --priority, \
             --spin, or a longer --period",
        ),
        _ => not_checked("late ticks", "the recording contains no lateness of its ticks"),
    });
    let lost = recording.lost();
    let unseen = ticks.unseen;
    let words = shortcomings(recording);
    let mut finding = format!(
        "{name}: {} lost, {} without a usable position ({} %)",
        counted(lost, "tick"),
        counted(unseen, "tick"),
        percent(unseen)
    );
    for shortcoming in &words {
        finding.push_str("; ");
        finding.push_str(shortcoming);
    }
    checks.push(check(
        "lost samples",
        !words.is_empty() || lost > 0 || unseen as f64 > LATE_SHARE * all,
        finding,
        "a longer --period, so that each has a new sample of the device; a disk and a processor that are not shared \
         during the recording; `palpate info --json` lists the gaps",
    ));
    let counted_ticks = recording.counted.as_ref();
    let off = counted_ticks.map_or(ticks.motors_off, |count| count.motors_off);
    let time = counted_ticks.and_then(|count| count.time);
    let made = recording.ticks_made().unwrap_or(recording.ticks);
    checks.push(check(
        "motors off",
        off > 0 || time.is_some_and(|time| !time.motors_off.is_zero()),
        if off > 0 || time.is_some_and(|time| !time.motors_off.is_zero()) {
            format!("{name}: {}", motors_off(time, off, made))
        } else {
            format!("{name}: the motors were on all the time")
        },
        "`palpate info` names the cause of the safety stop; a slower hand, a softer contact, or another limit \
         (--safe-force, --safe-speed, --oscillation) if the device allows it",
    ));
    checks.push(check(
        "safety limits",
        ticks.limited as f64 > LIMITED_SHARE * all,
        format!(
            "{name}: the safety layer changed the force of {} % of the ticks",
            percent(ticks.limited)
        ),
        "a softer contact, or a larger --safe-force if the device allows it: a wall with a limited force feels soft",
    ));
    checks
}

fn delay(card: &Card, sources: &Sources<'_>) -> Check {
    const NAME: &str = "modelled delay";
    let device = &card.device;
    let Some(period) = device.value("period_s") else {
        return not_checked(NAME, "the period of the loop is not known");
    };
    let model = sources
        .recordings
        .first()
        .map(crate::recording::report::model);
    let model_delay = model
        .as_ref()
        .and_then(|model| Some(model.get("delay_s")? + model.get("lag_s").copied().unwrap_or(0.0)));
    let found = sources.device_file.and_then(|(_, calibration)| {
        let together = calibration.delay_plus_lag();
        together.or_else(|| calibration.value(Quantity::Delay))
    });
    let ms = |seconds: f64| digits(1e3 * seconds);
    match (model_delay, found) {
        (Some(model), Some(found)) => check(
            NAME,
            (model - found).abs() > DELAY * period,
            format!(
                "the recorded loop's model has {} ms of delay and lag, but the device file has {} ms, {} periods",
                ms(model),
                ms(found),
                digits(found / period)
            ),
            "record with --device-file, which sets the model: coupled rendering loses its advantage from 0.03 periods \
             of unmodelled delay on",
        ),
        (Some(_), None) if device.is_simulated => Check {
            name: NAME,
            outcome: Outcome::InOrder,
            finding: "the device is simulated, and the renderer's model is that of the scene"
                .into(),
            remedy: None,
        },
        (Some(model), None) => check(
            NAME,
            model == 0.0,
            if model == 0.0 {
                "the recorded loop's model has no delay and no lag, and they are not measured"
                    .to_owned()
            } else {
                format!(
                    "the recorded loop's model has {} ms of delay and lag; no device file confirms it",
                    ms(model)
                )
            },
            "`palpate calibrate` measures them and writes a device file; record with --device-file",
        ),
        (None, Some(found)) => check(
            NAME,
            false,
            format!(
                "the device file has {} ms of delay and lag, {} periods; pass it to every command as --device-file",
                ms(found),
                digits(found / period)
            ),
            "",
        ),
        (None, None) => not_checked(
            NAME,
            "neither a recording nor a device file contains a delay",
        ),
    }
}

fn friction(card: &Card) -> Check {
    const NAME: &str = "dry friction";
    let device = &card.device;
    match (
        device.value("coulomb_friction_n"),
        device.value("largest_force_n"),
    ) {
        (Some(friction), Some(force)) => check(
            NAME,
            friction > FRICTION * force,
            format!(
                "{} N of dry friction, {} % of the largest force of {} N",
                digits(friction),
                digits(100.0 * friction / force),
                digits(force)
            ),
            "forces below the friction are not felt: reduce the bearing load, or use contacts with forces well above \
             it",
        ),
        (None, _) => not_checked(NAME, "no device file contains a friction"),
        (_, None) => not_checked(NAME, "the largest force of the device is not known"),
    }
}

fn resonance(card: &Card) -> Check {
    const NAME: &str = "resonance";
    let device = &card.device;
    if card.calibration.is_none() {
        return not_checked(NAME, "no device file");
    }
    let Some(resonance) = device.value("resonance_hz") else {
        return not_checked(
            NAME,
            "the device file has no resonance; a calibration finds resonances below a third of the loop rate",
        );
    };
    let (Some(reach), Some(mass)) = (&card.reach, device.value("device_mass_kg")) else {
        return not_checked(NAME, "the mass of the device is not known");
    };
    let rate = std::f64::consts::TAU * RESONANCE * resonance;
    let stiffest = mass * rate * rate;
    check(
        NAME,
        reach.stiffness_n_per_m > stiffest,
        format!(
            "{} Hz between motor and end-point; on a wall above about {} N/m, a third of that frequency, the device \
             is not rigid (this page is for {} N/m)",
            digits(resonance),
            digits(stiffest),
            digits(reach.stiffness_n_per_m)
        ),
        "softer contacts, a stiffer transmission, or less mass at the end-point",
    )
}

fn quantum(card: &Card) -> Check {
    const NAME: &str = "sensor step";
    let Some(quantum) = card.device.value("sensor_quantum_m") else {
        return not_checked(NAME, "the step of the position sensor is not known");
    };
    let Some(contact) = &card.contact else {
        return not_checked(NAME, "there is no contact");
    };
    if quantum == 0.0 {
        return check(NAME, false, "the position sensor has no steps".into(), "");
    }
    let steps = contact.deepest_penetration_m / quantum;
    check(
        NAME,
        steps < COUNTS,
        format!(
            "the contact below is {} sensor steps deep; one step of {} um is {} N",
            digits(steps),
            digits(1e6 * quantum),
            digits(contact.stiffness_n_per_m * quantum)
        ),
        "a softer contact, or a finer sensor: with few steps the force changes in jumps",
    )
}

fn calibration(card: &Card) -> Vec<Check> {
    const NAME: &str = "calibration";
    let Some(calibration) = &card.calibration else {
        return vec![not_checked(NAME, "no device file")];
    };
    let found = |key: &str| calibration.found.iter().find(|found| found.key == key);
    let mut checks = Vec::new();
    if let [(key, [of_file, of_run]), ..] = calibration.differing.as_slice() {
        checks.push(check(
            "one calibration",
            true,
            format!(
                "{key} is {} in the device file and {} in the report of the calibration",
                digits(*of_file),
                digits(*of_run)
            ),
            "use the file and the report of one calibration of this device",
        ));
    }
    let period = card.device.value("period_s");
    let delay = found("delay_plus_lag_s").and_then(|found| found.standard_deviation);
    let mass =
        found("device_mass_kg").and_then(|found| Some(found.standard_deviation? / found.value));
    if let (Some(delay), Some(period)) = (delay, period) {
        checks.push(check(
            NAME,
            delay > DELAY_DEVIATION * period || mass.is_some_and(|mass| mass > MASS_DEVIATION),
            format!(
                "delay and lag together are known to {} ms, {} periods{}",
                digits(1e3 * delay),
                digits(delay / period),
                mass.map_or_else(String::new, |mass| format!(
                    ", the mass to {} %",
                    digits(100.0 * mass)
                ))
            ),
            "calibrate again with a larger --largest-force, or more --seconds",
        ));
    }
    if let (Some(of_file), Some(period)) = (found("period_s"), period) {
        checks.push(check(
            "calibrated period",
            (of_file.value / period - 1.0).abs() > 1e-6,
            format!(
                "the device file was calibrated at a period of {} ms; the loop has {} ms",
                digits(1e3 * of_file.value),
                digits(1e3 * period)
            ),
            "calibrate at the period of the loop: a delay can depend on it",
        ));
    }
    if found("gain").is_none() {
        checks.push(not_checked(
            "gain of the motor",
            "no gain was measured: a spring or an added mass gives it (`palpate calibrate --spring`)",
        ));
    }
    checks
}
