use serde::Deserialize;

use super::*;

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Shape {
    Point,
    Ball { radius: f64 },
    Cloud(Vec<f64>),
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    number: Spanned<f64>,
    count: Option<u64>,
    shapes: Option<Vec<Spanned<Shape>>>,
    pair: Option<[i64; 2]>,
}

/// Returns the value, or the span and the error.
fn read(source: &str) -> Result<File, String> {
    from_text(source).map_err(|error| format!("{}: {error}", &source[error.span().unwrap_or(0..0)]))
}

#[test]
fn what_the_toml_crate_reads_is_read_as_it_does() {
    for source in [
        "number = 1",
        "number = 0xff",
        "number = 1_000.5",
        "number = -inf",
        "number = 1e-400",
        "number = 18446744073709551615\ncount = 18446744073709551615",
        "number = 1\nshapes = [\"point\", { ball = { radius = 2 } }, { cloud = [1, 2.5] }, { point = {} }]",
        "number = 1\npair = [-9223372036854775808, 3]\n[[shapes]]\nball.radius = 1",
    ] {
        let by_toml: File = toml::from_str(source).unwrap();
        let read = read(source).unwrap();
        assert_eq!(read, by_toml, "{source}");
        assert_eq!(read.number.span(), by_toml.number.span(), "{source}");
    }
}

#[test]
fn a_fault_stands_where_the_innermost_value_is() {
    for (source, said) in [
        (
            "number = 1e999",
            "1e999: the number is too large to be read",
        ),
        (
            "number = 99999999999999999999",
            "99999999999999999999: the number is too large to be read",
        ),
        (
            "number = 2026-11-25",
            "2026-11-25: invalid type: date, expected f64",
        ),
        (
            "number = \"1\"",
            "\"1\": invalid type: string \"1\", expected f64",
        ),
        (
            "number = 1\ncount = -1",
            "-1: invalid value: integer `-1`, expected u64",
        ),
        (
            "number = 1\nnumbr = 2",
            "numbr: unknown field `numbr`, expected one of `number`, `count`, `shapes`, `pair`",
        ),
        (
            "number = 1\nshapes = [{ ball = { radius = 1, colour = 2 } }]",
            "colour: unknown field `colour`, expected `radius`",
        ),
        (
            "number = 1\nshapes = [\"square\"]",
            "\"square\": unknown variant `square`, expected one of `point`, `ball`, `cloud`",
        ),
        (
            "number = 1\nshapes = [\"ball\"]",
            "\"ball\": invalid type: unit variant, expected struct variant",
        ),
        ("number = 1\nshapes = [3]", "3: wanted string or table"),
        (
            "number = 1\nshapes = [[\"point\"]]",
            "[\"point\"]: there is a list, and exactly one string or table is expected",
        ),
        (
            "number = 1\nshapes = [{ point = {}, cloud = [] }]",
            "{ point = {}, cloud = [] }: there is more than one key, and exactly one is expected",
        ),
        (
            "number = 1\npair = [1]",
            "[1]: invalid length 1, expected an array of length 2",
        ),
        (
            "number = 1\npair = [1, 2, 3]",
            "[1, 2, 3]: invalid length 3, expected an array of length 2",
        ),
        (
            "number = 1\nshapes = [{ ball = [1] }]",
            "[1]: invalid type: sequence, expected a table",
        ),
        (
            "number = 1\nshapes = [{ ball = true }]",
            "true: invalid type: boolean `true`, expected struct variant Shape::Ball",
        ),
    ] {
        assert_eq!(read(source).unwrap_err(), said, "{source}");
    }
    assert!(read("number = ").is_err());
}
