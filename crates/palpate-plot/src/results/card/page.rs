//! One self-contained HTML file without scripts and external resources.

use std::fmt::Write as _;

use palpate_study::card::Card;

use super::escape::escaped;
use super::figures::Figures;
use super::sections;
use crate::figure::SizeError;

/// Style sheet for screens, phones and paper.
const STYLE: &str = include_str!("style.css");

/// Returns the HTML page of a device report.
///
/// # Errors
/// A figure does not fit its size.
pub fn html(card: &Card) -> Result<String, SizeError> {
    let mut figures = Figures::default();
    let name = escaped(&card.device.name);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"generator\" content=\"palpate {version}\">\n<title>{name}: report of a haptic device</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<p class=\"kind\">Report of a haptic device</p>\n\
         <h1>{name}</h1>\n<p>Made on {made} by palpate {version}. {obtained}</p>\n</header>\n<main>\n",
        version = escaped(&card.palpate_version),
        made = escaped(&card.made),
        obtained = sections::prose(&card.obtained.join(" ")),
    );
    let mut section = |title: &str, body: &str| {
        let _ = write!(text, "<section>\n<h2>{title}</h2>\n{body}</section>\n");
    };
    let warnings = card.warnings().count();
    let title = match warnings {
        0 => "Checks".to_owned(),
        1 => "1 warning".to_owned(),
        more => format!("{more} warnings"),
    };
    section(&title, &sections::checks(card));
    section("Device", &sections::device(&card.device));
    if !card.timing.is_empty() {
        section("Timing", &sections::timing(&card.timing, &mut figures)?);
    }
    if let Some(felt) = &card.felt {
        section("Felt contacts", &sections::felt(felt, &mut figures)?);
    }
    if let Some(reach) = &card.reach {
        section(
            "Renderable contacts",
            &sections::reach(reach, &mut figures)?,
        );
    }
    if card.contact.is_none() {
        section("No contact", &sections::no_contact(card));
    }
    if let Some(contact) = &card.contact {
        let title = if contact.is_recorded {
            "A recorded contact"
        } else {
            "A simulated contact"
        };
        section(
            title,
            &(sections::no_contact(card) + &sections::contact(contact, &mut figures)?),
        );
    }
    if let Some(calibration) = &card.calibration {
        section(
            "Calibration",
            &sections::calibration(calibration, &mut figures)?,
        );
    }
    Ok(text + "</main>\n</body>\n</html>\n")
}
