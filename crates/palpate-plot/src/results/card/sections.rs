//! Sections of the page, each from a part of the device report.

use std::fmt::Write as _;

use palpate_study::advise::Reach;
use palpate_study::card::{
    CalibrationCard, Card, Check, ContactCard, DeviceCard, Distribution, FeltCard, Outcome,
    ReachCard, TimingCard,
};
use palpate_study::text::{digits, percent};

use super::escape::escaped;
use super::figures::Figures;
use crate::figure::SizeError;

/// Returns a table; the cells are markup.
fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = String::from("<div class=\"wide\"><table><thead><tr>");
    for cell in head {
        let _ = write!(text, "<th>{cell}</th>");
    }
    text.push_str("</tr></thead><tbody>");
    for row in rows {
        text.push_str("<tr>");
        for cell in row {
            let _ = write!(text, "<td>{cell}</td>");
        }
        text.push_str("</tr>");
    }
    text + "</tbody></table></div>\n"
}

fn figure(drawn: &str, caption: &str) -> String {
    format!("<figure>{drawn}<figcaption>{caption}</figcaption></figure>\n")
}

/// Returns the name of a key in words, with the factor and the symbol of its display unit.
fn readable(key: &str) -> (String, f64, &'static str) {
    let units = [
        ("_n_s_per_m", 1.0, "N s/m"),
        ("_n_per_m", 1.0, "N/m"),
        ("_kg", 1.0, "kg"),
        ("_hz", 1.0, "Hz"),
        ("_s", 1e3, "ms"),
        ("_m", 1e6, "µm"),
        ("_n", 1.0, "N"),
    ];
    let unit = units
        .iter()
        .find_map(|(end, factor, symbol)| Some((key.strip_suffix(end)?, *factor, *symbol)));
    let (name, factor, symbol) = unit.unwrap_or((key, 1.0, ""));
    (name.replace('_', " "), factor, symbol)
}

fn value(key: &str, value: f64, deviation: Option<f64>) -> (String, String) {
    let (name, factor, symbol) = readable(key);
    let deviation = deviation.filter(|deviation| *deviation > 0.0);
    let deviation = deviation.map_or_else(String::new, |deviation| {
        format!("\u{a0}±\u{a0}{}", digits(factor * deviation))
    });
    (
        name,
        format!("{}{deviation}\u{a0}{symbol}", digits(factor * value))
            .trim_end()
            .to_owned(),
    )
}

/// Lists the warnings with their remedies, then the passed and the skipped checks.
pub fn checks(card: &Card) -> String {
    let mut text = String::new();
    let warnings: Vec<&Check> = card.warnings().collect();
    if warnings.is_empty() {
        text.push_str("<p class=\"calm\">No warnings.</p>\n");
    } else {
        text.push_str("<ul class=\"warnings\">\n");
        for check in warnings {
            let _ = writeln!(
                text,
                "<li><b>{}.</b> {}. <span class=\"remedy\"><b>Remedy:</b> {}.</span></li>",
                escaped(&capital(check.name)),
                prose(&check.finding),
                prose(check.remedy.as_deref().unwrap_or_default())
            );
        }
        text.push_str("</ul>\n");
    }
    for (outcome, words) in [
        (Outcome::InOrder, "Checked and in order"),
        (Outcome::NotChecked, "Not checked"),
    ] {
        let of: Vec<String> = card
            .checks
            .iter()
            .filter(|check| check.outcome == outcome)
            .map(|check| format!("<b>{}</b>: {}", escaped(check.name), prose(&check.finding)))
            .collect();
        if !of.is_empty() {
            let _ = writeln!(text, "<p class=\"small\">{words}. {}.</p>", of.join("; "));
        }
    }
    text
}

/// Converts text with commands in backticks to markup.
pub fn prose(text: &str) -> String {
    let safe = escaped(text);
    let mut parts = safe.split('`');
    let mut prose = parts.next().unwrap_or_default().to_owned();
    for (index, part) in parts.enumerate() {
        prose.push_str(if index % 2 == 0 { "<code>" } else { "</code>" });
        prose.push_str(part);
    }
    if safe.matches('`').count() % 2 == 1 {
        prose.push_str("</code>");
    }
    prose
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + characters.as_str()
    })
}

/// Lists the known properties of the device.
pub fn device(device: &DeviceCard) -> String {
    let rows: Vec<Vec<String>> = device
        .numbers
        .iter()
        .map(|number| {
            let (name, value) = value(number.key, number.value, number.standard_deviation);
            vec![name, value, escaped(&number.source)]
        })
        .collect();
    let mut text = String::new();
    if device.is_simulated {
        text.push_str("<p>This device is simulated.</p>\n");
    }
    if device.holds_last_force == Some(true) {
        text.push_str("<p>Its motors hold their last force until the next command.</p>\n");
    }
    if rows.is_empty() {
        return text + "<p>None of its properties is known.</p>\n";
    }
    text + &table(&["quantity", "value", "from"], &rows)
}

/// Describes the timing of the loops.
pub fn timing(all: &[TimingCard], figures: &mut Figures) -> Result<String, SizeError> {
    let mut text = String::new();
    type Of = fn(&TimingCard) -> &Option<Distribution>;
    let quantities: [(&str, Of); 4] = [
        ("period", |of| &of.period_s),
        ("lateness", |of| &of.lateness_s),
        ("tick time", |of| &of.tick_s),
        ("device response", |of| &of.round_trip_s),
    ];
    // Captions of the first three distributions, which have a histogram.
    let captions = [
        "Period: from a sample to the next.",
        "Lateness: from the planned instant of a sample to the sample; early samples count in the leftmost bin.",
        "Tick time: from a sample to its command.",
    ];
    for of in all {
        let scene = of.scene.as_deref().unwrap_or("unknown scene");
        let _ = writeln!(
            text,
            "<p>{}: {} on “{}”, recorded by palpate {}. {}.</p>",
            escaped(&of.recording),
            escaped(of.method.as_deref().unwrap_or("unknown method")),
            escaped(scene),
            escaped(&of.palpate_version),
            escaped(&of.in_words())
        );
    }
    let microseconds = |seconds: f64| digits(1e6 * seconds);
    let mut rows = Vec::new();
    for of in all {
        for (name, distribution) in quantities {
            if let Some(found) = distribution(of) {
                let mut row = vec![if all.len() > 1 {
                    format!("{name}, {}", escaped(&of.recording))
                } else {
                    name.to_owned()
                }];
                row.extend([found.median, found.p99, found.largest].map(microseconds));
                rows.push(row);
            }
        }
    }
    text.push_str(&table(
        &["[µs]", "median (p50)", "99 % (p99)", "max"],
        &rows,
    ));
    text.push_str("<div class=\"three\">\n");
    for ((name, distribution), caption) in quantities.iter().zip(captions) {
        let of: Vec<(String, &Distribution)> = all
            .iter()
            .filter_map(|of| Some((of.recording.clone(), distribution(of).as_ref()?)))
            .collect();
        if !of.is_empty() {
            text.push_str(&figure(&figures.histogram(name, &of)?, caption));
        }
    }
    Ok(text + "</div>\n")
}

/// Lists the values of a device file and how they were identified.
pub fn calibration(of: &CalibrationCard, figures: &mut Figures) -> Result<String, SizeError> {
    // Several quantities can share an identification method.
    let mut ways: Vec<&str> = Vec::new();
    let rows: Vec<Vec<String>> = of
        .found
        .iter()
        .map(|found| {
            let (name, value) = value(found.key, found.value, found.standard_deviation);
            let by = found.found_by.as_deref().unwrap_or("unknown");
            let way = ways.iter().position(|way| *way == by).unwrap_or_else(|| {
                ways.push(by);
                ways.len() - 1
            });
            vec![name, value, (way + 1).to_string()]
        })
        .collect();
    let mut text = format!("<p>Device file {}", escaped(&of.file));
    if let Some(date) = &of.date {
        let _ = write!(text, " of {}", escaped(date));
    }
    if let Some(axis) = &of.axis {
        let _ = write!(text, ", along {}", escaped(axis));
    }
    if let Some(command) = &of.command {
        let _ = write!(text, ", found by <code>{}</code>", escaped(command));
    }
    text.push_str(".</p>\n<div class=\"two\">\n<div>\n");
    text.push_str(&table(
        &["quantity", "value ± standard deviation", "found by"],
        &rows,
    ));
    text.push_str("<ol class=\"small\">\n");
    for way in ways {
        let _ = writeln!(text, "<li>{}</li>", escaped(&capital(way)));
    }
    text.push_str("</ol>\n");
    text.push_str("</div>\n");
    if let Some(motion) = &of.motion {
        text.push_str(&figure(
            &figures.calibration(motion)?,
            "Measured against fitted: positions under random force steps, and their predictions by the fit from \
             earlier samples.",
        ));
    }
    Ok(text + "</div>\n")
}

/// Describes the renderable contacts.
pub fn reach(of: &ReachCard, figures: &mut Figures) -> Result<String, SizeError> {
    let limit = |limit: &Reach, factor: f64, beyond: &str| match limit.value {
        Some(value) if limit.or_beyond => format!("{beyond}\u{a0}{}", digits(factor * value)),
        Some(value) => digits(factor * value),
        None => "none".to_owned(),
    };
    let rows: Vec<Vec<String>> = of
        .methods
        .iter()
        .map(|method| {
            vec![
                escaped(method.method),
                limit(&method.good_wall_n_per_m, 1e-3, "≥"),
                limit(&method.stable_wall_n_per_m, 1e-3, "≥"),
                limit(&method.good_object_kg, 1e3, "≤"),
                limit(&method.stable_object_kg, 1e3, "≤"),
            ]
        })
        .collect();
    let head = [
        "method",
        "wall, good [N/mm]",
        "wall, stable [N/mm]",
        "object, good [g]",
        "object, stable [g]",
    ];
    let mut text = String::from("<div class=\"two\">\n<div>\n");
    let _ = writeln!(
        text,
        "<p>The stiffest wall, and the lightest object at {} N/mm, of each method.</p>",
        digits(1e-3 * of.stiffness_n_per_m)
    );
    text.push_str(&table(&head, &rows));
    let _ = writeln!(text, "<p class=\"small\">{}</p>", escaped(&of.in_words()));
    text.push_str("</div>\n");
    text.push_str(&figure(
        &figures.reach(of)?,
        "Stiffest contact over the mass of the object. A method without a line renders no contact; a line at the top \
         continues beyond the plot.",
    ));
    Ok(text + "</div>\n")
}

/// Describes what a hand feels in contacts.
pub fn felt(of: &FeltCard, figures: &mut Figures) -> Result<String, SizeError> {
    let [wall, object] = figures.felt(of)?;
    let mut text = format!("<p class=\"small\">{}</p>\n", escaped(&of.in_words()));
    text.push_str("<div class=\"three\">\n");
    text.push_str(&figure(&wall, "A wall: stiffness and damping."));
    text.push_str(&figure(&object, "An object: mass and damping."));
    text.push_str(&figure(
        &figures.z_width(of)?,
        "Z-width: stiffest stable wall over its damping.",
    ));
    Ok(text + "</div>\n")
}

/// States the reason for a missing contact, or for a missing recording of it.
pub fn no_contact(card: &Card) -> String {
    let why = card.no_contact.iter().map(|why| escaped(why));
    let why: Vec<String> = why.collect();
    if why.is_empty() {
        return String::new();
    }
    format!("<p>{}.</p>\n", capital(&why.join("; ")))
}

/// Describes one contact.
pub fn contact(of: &ContactCard, figures: &mut Figures) -> Result<String, SizeError> {
    let in_percent = |value: Option<f64>| {
        value.map_or_else(|| "-".into(), |value| format!("{} %", percent(value)))
    };
    let object = of.object_mass_kg.map_or_else(
        || "a wall".to_owned(),
        |mass| format!("an object of {} kg", digits(mass)),
    );
    let mut rows = vec![
        (
            "contact",
            format!(
                "{} N/m, {object}, by {}",
                digits(of.stiffness_n_per_m),
                of.method
            ),
        ),
        (
            "E: error that a method can avoid",
            in_percent(of.mean_force_error_percent),
        ),
        (
            "hold bound: least error of a held force",
            in_percent(of.hold_bound_percent),
        ),
        (
            "FRE: whole error, FRE² = bound² + E²",
            in_percent(of.force_rendering_error_percent),
        ),
        ("strongest force", format!("{} N", digits(of.peak_force_n))),
        (
            "deepest penetration",
            format!("{} mm", digits(1e3 * of.deepest_penetration_m)),
        ),
        (
            "energy that the held force created",
            format!("{} mJ", digits(1e3 * of.leak_held_j)),
        ),
    ];
    if let Some(leak) = of.recorded_leak_held_j {
        rows.push((
            "the same, in the recorded loop's ledger",
            format!("{} mJ", digits(1e3 * leak)),
        ));
    }
    if let Some(force) = of.recorded_peak_force_n {
        rows.push(("strongest sent force", format!("{} N", digits(force))));
    }
    let rows: Vec<Vec<String>> = rows
        .into_iter()
        .map(|(name, value)| vec![name.to_owned(), escaped(&value)])
        .collect();
    let mut text = format!(
        "<div class=\"two\">\n<div>\n<p>{}, from {} s on, for {} s.</p>\n",
        escaped(&capital(&of.source)),
        format_args!("{:.3}", of.begins_s),
        digits(of.lasts_s)
    );
    text.push_str(
        &table(&["", ""], &rows).replace("<thead><tr><th></th><th></th></tr></thead>", ""),
    );
    text.push_str("</div>\n");
    text.push_str(&figure(
        &figures.contact(of)?,
        "Positions, force on the object beside the ideal one, and energy that the held force created.",
    ));
    Ok(text + "</div>\n")
}
