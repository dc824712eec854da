//! Compares the tables of columns in the documentation with the list from which the files are written.
//! `PALPATE_WRITE_DOCS=1 cargo test --release -p palpate-record --test recording documented` updates the documentation.

use std::fmt::Write;
use std::path::Path;

use palpate_record::recording::{
    BodyTick, Column, ContactTick, DeviceTick, Flags, Kind, Phase, Tick, columns,
};

/// Compares the text between `<!-- name -->` and `<!-- end -->` with `made`, or replaces it.
fn compare(document: &str, name: &str, made: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../docs")
        .join(document);
    let text = std::fs::read_to_string(&path).unwrap();
    let begin = format!("<!-- {name} -->\n");
    let from = text.find(&begin).expect("a place for the table") + begin.len();
    let to = from + text[from..].find("<!-- end -->").expect("an end of it");
    if std::env::var_os("PALPATE_WRITE_DOCS").is_some() {
        let written = [&text[..from], made, &text[to..]].concat();
        std::fs::write(&path, written).unwrap();
        return;
    }
    assert_eq!(
        &text[from..to],
        made,
        "docs/{document} is not up to date; PALPATE_WRITE_DOCS=1 cargo test --release -p palpate-record \
         --test recording documented writes it"
    );
}

fn meaning(column: &Column, flags: Flags) -> String {
    let numbered = |values: Vec<(u32, &str)>| {
        let named = values.iter().map(|(n, name)| format!("{n} `{name}`"));
        named.collect::<Vec<_>>().join(", ")
    };
    match column.kind {
        Kind::Flags => {
            let named = Flags::NAMED.iter().filter(|(flag, _)| flags.has(*flag));
            let bits = named.map(|(flag, name)| (flag.0.trailing_zeros(), *name));
            format!("{}: {}", column.meaning, numbered(bits.collect()))
        }
        Kind::Phase => {
            let phases = (0..).zip(Phase::ALL.map(Phase::name)).collect();
            format!("{}: {}", column.meaning, numbered(phases))
        }
        _ => column.meaning.to_owned(),
    }
}

fn unit(column: &Column) -> &str {
    match column.unit {
        "1" => "",
        unit => unit,
    }
}

/// Returns the fields of a message, each aligned to its size; `flags` are its possible flags. Neighbours with the same
/// type, unit and meaning share a row.
fn table(columns: &[Column], flags: Flags) -> String {
    let mut table =
        String::from("| byte | field | type | unit | meaning |\n|---|---|---|---|---|\n");
    let mut end = 0_usize;
    let shared = |one: &Column, other: &Column| {
        (one.kind.message_type(), unit(one), one.meaning)
            == (other.kind.message_type(), unit(other), other.meaning)
    };
    for row in columns.chunk_by(shared) {
        let mut bytes = Vec::new();
        for column in row {
            let at = end.next_multiple_of(column.kind.size());
            end = at + column.kind.size();
            bytes.push(at.to_string());
        }
        let names: Vec<_> = row
            .iter()
            .map(|column| format!("`{}`", column.name))
            .collect();
        let (kind, unit, meaning) = (
            row[0].kind.message_type(),
            unit(&row[0]),
            meaning(&row[0], flags),
        );
        let (bytes, names) = (bytes.join(", "), names.join(", "));
        let _ = writeln!(table, "| {bytes} | {names} | {kind} | {unit} | {meaning} |");
    }
    let _ = writeln!(table, "\nA message has {end} bytes after the first four.");
    table
}

#[test]
fn the_tables_of_ticks_and_contacts_are_up_to_date() {
    compare(
        "reference/recording.md",
        "columns of a tick",
        &table(Tick::COLUMNS, Flags::ALL),
    );
    compare(
        "reference/recording.md",
        "columns of a contact",
        &table(ContactTick::COLUMNS, Flags::OF_CONTACT),
    );
    compare(
        "reference/recording.md",
        "columns of a body",
        &table(BodyTick::COLUMNS, Flags::default()),
    );
    compare(
        "reference/recording.md",
        "columns of a device",
        &table(DeviceTick::COLUMNS, Flags::OF_DEVICE),
    );
}

#[test]
fn the_table_of_the_live_page_is_up_to_date() {
    let mut table = String::from("| column | unit |\n|---|---|\n");
    for column in columns().iter().filter(|column| column.is_live()) {
        let _ = writeln!(table, "| `{}` | {} |", column.name, unit(column));
    }
    compare(
        "reference/live-protocol.md",
        "columns that the page is sent",
        &table,
    );
}
