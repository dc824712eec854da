//! A comparison as text.

use std::fmt;

use comfy_table::{Cell, CellAlignment};

use super::{Comparison, Figures, Outcome};
use crate::text::{
    ABSOLUTE_LEAK, E, FRE, WIDTH, digits, legend, lines, percent, plain_table, short, within,
    wrapped,
};

/// Formats text below the line of a method, in the column of its name.
fn below(words: &str) -> String {
    const BLANKS: &str = "     ";
    let lines = within(words, WIDTH - BLANKS.len());
    format!("{BLANKS}{}", lines.join(&format!("\n{BLANKS}")))
}

/// Markers before the name of a method that did not stay bounded, and of the method with the lowest error.
const BROKEN: &str = "!";
const LEAST: &str = "*";

/// Returns the values of a run in the table.
fn values(run: &Figures) -> [Option<String>; 5] {
    let absolute = run.absolute_leak_held_j.map(|leak| digits(1e3 * leak));
    [
        run.mean_force_error_percent.map(percent),
        run.force_rendering_error_percent.map(percent),
        run.error_over_bound.map(digits),
        run.peak_over_ideal.map(digits),
        absolute.or(run.leak_j.map(|leak| short(1e3 * leak, 3))),
    ]
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let has_worlds = self.scenes.iter().any(|scene| scene.is_world);
        let has_contacts = self.scenes.iter().any(|scene| !scene.is_world);
        let header = [
            "",
            "method",
            "E %",
            "FRE %",
            "FRE/bound",
            "peak/ideal",
            if has_worlds { "leak mJ" } else { "|leak| mJ" },
        ];
        let mut table = plain_table(CellAlignment::Left, &header);
        for scene in &self.scenes {
            let least = scene.least();
            for method in &scene.methods {
                let (mark, cells) = match &method.result {
                    Outcome::Cannot { .. } | Outcome::NoneFound { .. } => ("-", Default::default()),
                    Outcome::Ran(run) if !run.is_whole => (BROKEN, values(run)),
                    Outcome::Ran(run) => {
                        let is_least = least.is_some() && run.mean_force_error_percent == least;
                        (if is_least { LEAST } else { "" }, values(run))
                    }
                };
                let mut row = vec![Cell::new(mark), Cell::new(method.method)];
                row.extend(cells.into_iter().map(|cell| {
                    Cell::new(cell.unwrap_or_else(|| "-".into()))
                        .set_alignment(CellAlignment::Right)
                }));
                table.add_row(row);
            }
        }
        let text = lines(&table);
        let mut text = text.lines();
        for line in text.by_ref().take(2) {
            writeln!(f, "{line}")?;
        }
        for scene in &self.scenes {
            writeln!(f, "\n{}\n  {}", wrapped(&scene.title), scene.conditions)?;
            for (line, method) in text.by_ref().take(scene.methods.len()).zip(&scene.methods) {
                let remarks = &method.remarks;
                if remarks.is_empty() {
                    writeln!(f, "{line}")?;
                } else if line.chars().count() + 2 + remarks.chars().count() <= WIDTH {
                    writeln!(f, "{line}  {remarks}")?;
                } else {
                    writeln!(f, "{line}\n{}", below(remarks))?;
                }
                match &method.result {
                    Outcome::Cannot { cannot } => {
                        writeln!(f, "{}", below(&format!("cannot be set up: {cannot}")))?;
                    }
                    Outcome::NoneFound { none_found } => writeln!(f, "{}", below(none_found))?,
                    Outcome::Ran(_) => {}
                }
            }
            if let Some(least) = scene.least_explicit_mass_kg {
                let words = format!(
                    "exact to implicit: the sampled spring, with an object that this integrator moves. An explicit one is \
                     passive from K T²/4 = {} kg (Brown-Colgate).",
                    digits(least)
                );
                writeln!(f, "{}", below(&words))?;
            }
            if let Some(seeded) = &scene.seeded {
                write!(f, "\n{seeded}")?;
            }
        }
        let mut marks = format!(
            "{LEAST} least E of the bounded runs, {BROKEN} diverged, left the safety box or jammed."
        );
        if has_worlds {
            marks = format!(
                "{LEAST} least E of the bounded runs, {BROKEN} diverged, left the safety box, jammed, or refused samples \
                 in a world. Best of N: the scene has no setting; of N tried settings, the one with the least E was \
                 selected, with knowledge of the ideal."
            );
        }
        writeln!(f, "\n{}", wrapped(&marks))?;
        let words: &[&str] = if has_contacts {
            &[E, FRE, ABSOLUTE_LEAK]
        } else {
            &[E, FRE]
        };
        writeln!(f, "{}", legend(words))?;
        if has_contacts {
            let settings = "A method without a setting in the scene uses its default; --json lists every parameter.";
            writeln!(f, "{}", wrapped(settings))?;
        }
        for file in &self.files {
            writeln!(f, "wrote {file}")?;
        }
        Ok(())
    }
}
