//! Rows of a comparison as a file: CSV, Markdown or LaTeX.

use std::io::{self, Write};
use std::path::Path;

use crate::text::digits;

/// Format of a table in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Comma-separated values, with all digits.
    Csv,
    /// A pipe table, numbers with three significant digits.
    Markdown,
    /// A `tabular` with the rules of the package booktabs, numbers with three significant digits.
    Latex,
}

impl TableFormat {
    /// Returns the format that the extension of `path` names: `.md`, `.tex`; any other name is CSV.
    #[must_use]
    pub fn from_path(path: &Path) -> Self {
        let extension = path.extension().and_then(|extension| extension.to_str());
        match extension {
            Some(extension) if extension.eq_ignore_ascii_case("md") => Self::Markdown,
            Some(extension) if extension.eq_ignore_ascii_case("tex") => Self::Latex,
            _ => Self::Csv,
        }
    }

    /// Writes rows under the names of their columns.
    ///
    /// # Errors
    /// The writer fails.
    pub fn write<const N: usize>(
        self,
        writer: &mut dyn Write,
        columns: &[&str; N],
        rows: impl Iterator<Item = [String; N]>,
    ) -> io::Result<()> {
        match self {
            Self::Csv => {
                let mut csv = csv::Writer::from_writer(writer);
                csv.write_record(columns)?;
                for row in rows {
                    csv.write_record(row)?;
                }
                csv.flush()
            }
            Self::Markdown => write_markdown(writer, columns, &rows.collect::<Vec<_>>()),
            Self::Latex => write_latex(writer, columns, &rows.collect::<Vec<_>>()),
        }
    }
}

fn write_markdown<const N: usize>(
    writer: &mut dyn Write,
    columns: &[&str; N],
    rows: &[[String; N]],
) -> io::Result<()> {
    let line = |cells: &[String]| format!("| {} |", cells.join(" | "));
    let escaped = |cell: &str| cell.replace('|', "\\|");
    let rules = numeric(rows).map(|is_numeric| if is_numeric { "--:" } else { "---" });
    writeln!(writer, "{}", line(&columns.map(escaped)))?;
    writeln!(writer, "|{}|", rules.join("|"))?;
    for row in rows {
        writeln!(writer, "{}", line(&rounded(row).map(|cell| escaped(&cell))))?;
    }
    Ok(())
}

fn write_latex<const N: usize>(
    writer: &mut dyn Write,
    columns: &[&str; N],
    rows: &[[String; N]],
) -> io::Result<()> {
    let line = |cells: &[String]| format!("{} \\\\", cells.join(" & "));
    let alignments = numeric(rows).map(|is_numeric| if is_numeric { "r" } else { "l" });
    writeln!(writer, "% needs \\usepackage{{booktabs}}")?;
    writeln!(writer, "\\begin{{tabular}}{{{}}}", alignments.concat())?;
    writeln!(
        writer,
        "\\toprule\n{}\n\\midrule",
        line(&columns.map(escaped_latex))
    )?;
    for row in rows {
        writeln!(
            writer,
            "{}",
            line(&rounded(row).map(|cell| escaped_latex(&cell)))
        )?;
    }
    writeln!(writer, "\\bottomrule\n\\end{{tabular}}")
}

/// Returns whether each column has only numbers and empty cells.
fn numeric<const N: usize>(rows: &[[String; N]]) -> [bool; N] {
    std::array::from_fn(|column| {
        rows.iter()
            .all(|row| row[column].is_empty() || row[column].parse::<f64>().is_ok())
    })
}

/// Returns a row with its fractions rounded; whole numbers and texts are unchanged.
fn rounded<const N: usize>(row: &[String; N]) -> [String; N] {
    row.each_ref().map(|cell| match cell.parse::<f64>() {
        Ok(value) if value.is_finite() && cell.parse::<i64>().is_err() => digits(value),
        _ => cell.clone(),
    })
}

/// Returns a text with the special characters of LaTeX escaped.
fn escaped_latex(text: &str) -> String {
    let mut escaped = String::new();
    for character in text.chars() {
        match character {
            '_' | '%' | '&' | '#' | '$' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(character);
            }
            '\\' => escaped.push_str("\\textbackslash{}"),
            '~' => escaped.push_str("\\textasciitilde{}"),
            '^' => escaped.push_str("\\textasciicircum{}"),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(path: &str) -> String {
        let rows = [
            [
                "a_b|c & 5 %".to_owned(),
                "0.123456".to_owned(),
                "12".to_owned(),
            ],
            ["d".to_owned(), String::new(), "1234567".to_owned()],
        ];
        let mut file = Vec::new();
        TableFormat::from_path(Path::new(path))
            .write(&mut file, &["name", "error_percent", "n"], rows.into_iter())
            .unwrap();
        String::from_utf8(file).unwrap()
    }

    #[test]
    fn the_extension_chooses_the_format() {
        assert_eq!(
            written("t.csv"),
            "name,error_percent,n\na_b|c & 5 %,0.123456,12\nd,,1234567\n"
        );
        assert_eq!(written("t"), written("t.csv"));
        assert_eq!(
            written("t.md"),
            "| name | error_percent | n |\n|---|--:|--:|\n| a_b\\|c & 5 % | 0.123 | 12 |\n| d |  | 1234567 |\n"
        );
        assert_eq!(
            written("t.TEX"),
            "% needs \\usepackage{booktabs}\n\\begin{tabular}{lrr}\n\\toprule\nname & error\\_percent & n \\\\\n\
             \\midrule\na\\_b|c \\& 5 \\% & 0.123 & 12 \\\\\nd &  & 1234567 \\\\\n\\bottomrule\n\\end{tabular}\n"
        );
    }
}
