//! The advice as text, then as tables.

use std::fmt;

use crate::map::bounds::least_explicit_mass;
use crate::map::{PRESSED_WITH, RESTS_BELOW};
use comfy_table::{Cell, CellAlignment};

use super::{Advice, ContactReport, Evaluated, FAITHFUL_PERCENT, Reach, Verdict};
use crate::text::{E, counted, digits, legend, lines, number, percent, plain_table, wrapped};

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", wrapped(&self.answer()))?;
        writeln!(f, "{}\n", wrapped(&self.conditions()))?;
        if self.contact.is_some() {
            writeln!(f, "{}\n", lines(&self.contact_table()))?;
            writeln!(f, "{}\n", legend(&[E]))?;
        }
        writeln!(f, "{}\n", lines(&self.limit_table()))?;
        writeln!(f, "{}", wrapped(&self.bounds_in_words()))?;
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}

/// Returns the words for a contact whose ideal force no force held for a `period` `[s]` follows, with the remedies.
#[must_use]
pub fn too_coarse(period: f64) -> String {
    format!(
        "no force held for {period} s is within {FAITHFUL_PERCENT} % of the ideal's. A higher rate, a softer contact or \
         a heavier object would help."
    )
}

impl Advice {
    /// Returns the object in words: `an object of 0.1 kg`, `a wall`.
    #[must_use]
    pub fn object(&self) -> String {
        match self.device.object_mass_kg {
            Some(mass) => format!("an object of {mass} kg"),
            None => "a wall".into(),
        }
    }

    fn answer(&self) -> String {
        let Some(contact) = &self.contact else {
            return self.reach_in_words();
        };
        let what = format!(
            "{} N/m for {} (kappa {}, Kc {})",
            contact.stiffness_n_per_m,
            self.object(),
            digits(contact.kappa),
            digits(contact.object_kappa)
        );
        let mut answer = self.verdict_in_words(&what);
        if let (Verdict::Yes { .. }, Some((method, nearer))) = (self.verdict, self.nearer()) {
            answer.push_str(&format!(
                " It needs no tuning; {} has a smaller error, {} %.",
                with_damping(method, nearer.damping_n_s_per_m),
                nearer.error_percent[1].map_or_else(|| "-".into(), percent)
            ));
        }
        if let Some(reason) = self.reason_against_coupled() {
            answer.push_str(&reason);
        }
        if contact.force_per_count_n > 0.0 {
            answer.push_str(&format!(
                " One count of the encoder is {} N.",
                digits(contact.force_per_count_n)
            ));
        }
        answer.push_str(&format!(
            " Within the {} s for which a force is held, the ideal force changes: no held force is nearer to it than \
             the hold bound, {} %.",
            self.device.period_s,
            percent(contact.hold_bound_percent)
        ));
        answer
    }

    /// Returns the verdict on `what`, the contact in words.
    fn verdict_in_words(&self, what: &str) -> String {
        let error = self
            .chosen()
            .and_then(|(_, evaluated)| evaluated.error_percent[1])
            .map_or_else(|| "-".into(), percent);
        match self.verdict {
            Verdict::Yes {
                method,
                damping_n_s_per_m,
            } => format!(
                "Yes: {what} can be rendered. Use {}: no bounce gains more than 1 % of energy, the \
                 mean force is within {error} % of the ideal's from every start height, and in a hand \
                 the contact is steady {}.",
                with_damping(method, damping_n_s_per_m),
                if self.device.object_mass_kg.is_some() {
                    "at rest and pressed"
                } else {
                    "pressed"
                }
            ),
            Verdict::Swings {
                method,
                damping_n_s_per_m,
                resting,
                pressed,
            } => format!(
                "No: {what} does not come to rest {} by {}, the steadiest method here, although its bounces gain no \
                 energy: the force keeps swinging by more than {} % of the pressing force, or the contact is lost. \
                 Use a softer contact, a heavier object, a higher rate or a finer encoder.",
                match (resting, pressed) {
                    (true, true) => "on the device or pressed",
                    (true, false) => "on the device",
                    _ => "when pressed",
                },
                with_damping(method, damping_n_s_per_m),
                percent(100.0 * RESTS_BELOW)
            ),
            Verdict::HoldTooCoarse {
                method,
                damping_n_s_per_m,
            } => format!(
                "The period is too long: {what} is stable and steady by {}, but {}",
                with_damping(method, damping_n_s_per_m),
                too_coarse(self.device.period_s)
            ),
            Verdict::StableOnly {
                method,
                damping_n_s_per_m,
            } => format!(
                "Stable, but not faithful: {what} can be rendered by {} without gaining energy, but its \
                 force is up to {error} % off the ideal's. A higher rate or a softer contact would help.",
                with_damping(method, damping_n_s_per_m)
            ),
            Verdict::TooFlexible { stiffest_n_per_m } => format!(
                "No: {what} is beyond the device's first resonance, which allows {} N/m at this period. \
                 The trials below are of a rigid device. Use a softer contact, or a stiffer transmission.",
                digits(stiffest_n_per_m)
            ),
            Verdict::No { method, growth } => {
                let how = match growth {
                    Some(growth) => format!(
                        "the nearest, {method}, gains {} % of energy per bounce, which a hand may or may not absorb",
                        digits(100.0 * (growth - 1.0))
                    ),
                    None => format!("even the nearest, {method}, diverges from some start height"),
                };
                format!(
                    "No: no method here renders {what} stably; {how}. Use a softer contact, a heavier object or a \
                     higher rate."
                )
            }
            Verdict::NotAsked => self.reach_in_words(),
        }
    }

    /// Returns why another method than coupled rendering is recommended despite its larger force error: coupled
    /// rendering oscillates.
    fn reason_against_coupled(&self) -> Option<String> {
        let Verdict::Yes { method, .. } = self.verdict else {
            return None;
        };
        let coupled = self.methods.iter().find(|one| one.method == "coupled")?;
        let own = coupled.by_itself?;
        let error = own.error_percent[1]?;
        let (_, chosen) = self.chosen()?;
        if method == "coupled" || error >= chosen.error_percent[1]? {
            return None;
        }
        let swings = [
            (own.resting_swing, "at rest", "the weight"),
            (own.pressed_swing, "pressed", "the pressing force"),
        ];
        let swings: Vec<String> = swings
            .into_iter()
            .filter_map(|(swing, when, of)| {
                let swing = swing.filter(|swing| *swing >= RESTS_BELOW)?;
                Some(format!("{when} by {} % of {of}", percent(100.0 * swing)))
            })
            .collect();
        (!swings.is_empty()).then(|| {
            format!(
                " coupled has a smaller error, {} %, but its force swings {}; allowed are {} %.",
                percent(error),
                swings.join(" and "),
                percent(100.0 * RESTS_BELOW)
            )
        })
    }

    fn reach_in_words(&self) -> String {
        let stiffest = self
            .methods
            .iter()
            .filter_map(|advice| {
                let value = advice.stiffest_n_per_m.value?;
                Some((advice.method, value, advice.stiffest_n_per_m.or_beyond))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match stiffest {
            Some((method, value, beyond)) => format!(
                "The stiffest contact with {} that this device renders without gaining energy is {} N/m{}, by \
                 {method}. Pass --stiffness to check a contact.",
                self.object(),
                digits(value),
                if beyond { " or more" } else { "" }
            ),
            None => format!(
                "No method here renders a contact with {} without gaining energy, not even a very soft one: the \
                 device needs friction, a damping hand or a damper.",
                self.object()
            ),
        }
    }

    fn conditions(&self) -> String {
        let device = &self.device;
        let mut friction = String::new();
        if device.viscous_friction_n_s_per_m > 0.0 {
            friction.push_str(&format!(", {} N s/m", device.viscous_friction_n_s_per_m));
        }
        if device.coulomb_friction_n > 0.0 {
            friction.push_str(&format!(
                ", {} N of dry friction",
                device.coulomb_friction_n
            ));
        }
        if friction.is_empty() {
            friction = ", without friction".into();
        }
        let quantum = match device.encoder_quantum_m {
            quantum if quantum > 0.0 => format!(", encoder of {quantum} m"),
            _ => String::new(),
        };
        let mut delay = match (device.delay_samples, device.delay_fraction) {
            (0, 0.0) => String::new(),
            (samples, 0.0) => format!(", delay of {}", counted(samples as f64, "sample")),
            (samples, fraction) => format!(", delay of {} periods", samples as f64 + fraction),
        };
        if device.lag_s > 0.0 {
            delay.push_str(&format!(", lag of {} s", device.lag_s));
        }
        for (what, deviation, unit) in [
            ("delay", device.delay_deviation_s, " s"),
            ("lag", device.lag_deviation_s, " s"),
            ("gain", 100.0 * device.gain_deviation, " %"),
            ("sensor", device.sensor_noise_m, " m"),
        ] {
            if deviation > 0.0 {
                let deviation = digits(deviation);
                delay.push_str(&format!(", {what} known to {deviation}{unit}"));
            }
        }
        if let Some(stiffest) = device.stiffest_by_resonance_n_per_m {
            delay.push_str(&format!(
                ", a resonance that allows {} N/m",
                digits(stiffest)
            ));
        }
        format!(
            "Device of {} kg at {} s{friction}{quantum}{delay}; {} bounces on it from {} m ± 5 % in {} start heights, \
             in a hand with force but without damping. Resting: an object on the device under its weight. Pressed: a \
             contact under {PRESSED_WITH} N. Both are in a light and in a firm hand.",
            device.mass_kg,
            device.period_s,
            self.object(),
            device.gap_m,
            device.start_heights
        )
    }

    fn contact_table(&self) -> comfy_table::Table {
        let header = [
            "method",
            "N s/m",
            "",
            "growth",
            "worst",
            "E %",
            "worst",
            "resting\n%",
            "pressed\n%",
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for advice in &self.methods {
            let tuned = advice.tuned.as_ref();
            for (name, evaluated) in [
                (advice.method.to_owned(), advice.by_itself.as_ref()),
                ("  tuned".to_owned(), tuned),
            ] {
                if let Some(evaluated) = evaluated {
                    table.add_row(row(name, evaluated));
                }
            }
        }
        table
    }

    fn limit_table(&self) -> comfy_table::Table {
        let lightest = self
            .contact
            .as_ref()
            .map(|contact| format!("lightest kg at {} N/m", contact.stiffness_n_per_m));
        let stiffest = format!("stiffest N/m for {}", self.object());
        let mut header = vec!["method", &*stiffest];
        header.extend(lightest.as_deref());
        let mut table = plain_table(CellAlignment::Left, &header);
        for advice in &self.methods {
            let mut cells = vec![
                Cell::new(advice.method),
                reach(&advice.stiffest_n_per_m, "≥ "),
            ];
            cells.extend(advice.lightest_kg.iter().map(|limit| reach(limit, "≤ ")));
            table.add_row(cells);
        }
        table
    }

    /// Returns the least mass of an explicitly integrated object, for comparison with the lightest one.
    fn least_mass_in_words(&self) -> String {
        let least = |contact: &ContactReport| {
            let least = least_explicit_mass(contact.stiffness_n_per_m, self.device.period_s);
            format!(
                "An object moved by an explicit integrator is passive from K T²/4 = {} kg (Brown-Colgate); here it is \
                 moved exactly. ",
                digits(least)
            )
        };
        self.contact.as_ref().map(least).unwrap_or_default()
    }

    fn bounds_in_words(&self) -> String {
        let bounds = &self.bounds;
        let without = |value: f64| {
            if value > 0.0 {
                format!("{} N/m", digits(value))
            } else {
                "none without friction".into()
            }
        };
        format!(
            "Classical bounds, of walls and the plain spring: Colgate-Schenkel {}, Gil {}, Abbott-Okamura {}. An \
             undamped device on a wall with its best virtual damper, {} N s/m: {} N/m. {}All of these assume the \
             friction of the device alone; \"tuned\" tries {} dampings on this scene. Stiffest and lightest are \
             limits of stability alone: the force deviates far from the ideal's earlier. Faithful: mean-force error E \
             and hold bound are below {} %. Resting and pressed: standard deviation of the force over the pressing \
             force, pressed with 3 N and after a tap with 13 N that a limit of 20 N clips; a dash: the bounce is not stable, or the contact is lost or diverges. A dash elsewhere: unstable \
             even at kappa or Kc = 1e-4.",
            without(bounds.colgate_schenkel_n_per_m),
            without(bounds.gil_n_per_m),
            without(bounds.abbott_okamura_n_per_m),
            digits(bounds.undamped_wall_damping_n_s_per_m),
            digits(bounds.undamped_wall_n_per_m),
            self.least_mass_in_words(),
            24,
            FAITHFUL_PERCENT
        )
    }
}

fn with_damping(method: &str, damping: Option<f64>) -> String {
    match damping {
        Some(damping) => format!("{method} with a damping of {} N s/m", digits(damping)),
        None => format!("{method} with its defaults"),
    }
}

fn row(name: String, evaluated: &Evaluated) -> Vec<Cell> {
    let growth = |value: Option<f64>| number(value, |growth| format!("{growth:.3}"));
    vec![
        Cell::new(name),
        number(evaluated.damping_n_s_per_m, digits),
        Cell::new(evaluated.class),
        growth(evaluated.growth[0]),
        growth(evaluated.growth[1]),
        number(evaluated.error_percent[0], percent),
        number(evaluated.error_percent[1], percent),
        number(evaluated.resting_swing, |swing| percent(100.0 * swing)),
        number(evaluated.pressed_swing, |swing| percent(100.0 * swing)),
    ]
}

fn reach(limit: &Reach, beyond: &str) -> Cell {
    number(limit.value, |value| {
        let sign = if limit.or_beyond { beyond } else { "" };
        format!("{sign}{}", digits(value))
    })
}
