//! Valid and invalid traces.

use std::io;

use super::*;
use crate::unit::{LengthUnit, TimeUnit};

fn parse(text: &str) -> Result<Trace, TraceError> {
    read(text.as_bytes(), "hand.csv")
}

fn message(text: &str) -> String {
    parse(text).unwrap_err().to_string()
}

#[test]
fn the_two_columns_are_read_in_any_order_beside_others() {
    let trace = parse("note,position_m,t_s\na,0.5,0\nb,-1e-3,0.001\n").unwrap();
    assert_eq!(trace.t_s, [0.0, 0.001]);
    assert_eq!(trace.position_m, [0.5, -1e-3]);
}

#[test]
fn positions_come_in_the_unit_of_their_column_or_in_the_one_that_is_said() {
    let in_unit = |text: &str, unit| {
        read_part(
            text.as_bytes(),
            "hand.csv",
            &Part::WHOLE,
            &Layout::in_unit(unit),
        )
        .map(|held| held.trace)
    };
    let millimetres = Some(LengthUnit::Millimetre);
    for (header, unit) in [
        ("position_mm", None),
        ("position_mm", millimetres),
        ("position_m", millimetres),
    ] {
        let trace = in_unit(&format!("t_s,{header}\n0,12\n1,-3\n"), unit).unwrap();
        assert_eq!(trace.position_m, [0.012, -0.003], "{header}");
    }
    let both = "t_s,position_mm,position_m\n0,12,5\n1,-3,6\n";
    assert_eq!(in_unit(both, None).unwrap().position_m, [5.0, 6.0]);
    assert_eq!(in_unit(both, millimetres).unwrap().position_m[0], 0.012);
    let error = in_unit("t_s,position_cm\n0,12\n1,-3\n", millimetres).unwrap_err();
    assert!(
        error.to_string().contains("no column `position_m`"),
        "{error}"
    );
}

#[test]
fn comments_blank_lines_crlf_and_a_byte_order_mark_are_accepted() {
    let text = "\u{feff}# device 3\r\n\r\n t_s , position_m \r\n0,1\r\n# pause\r\n\r\n1, 2\r\n";
    let trace = parse(text).unwrap();
    assert_eq!(trace.t_s, [0.0, 1.0]);
    assert_eq!(trace.position_m, [1.0, 2.0]);
}

/// Returns a layout with `change`, of a caller with flags.
fn laid_out(change: impl FnOnce(&mut Layout)) -> Layout {
    let mut layout = Layout {
        ways: Ways::Flags,
        ..Layout::default()
    };
    change(&mut layout);
    layout
}

fn parse_as(text: &str, layout: &Layout) -> Result<HeldTrace, String> {
    read_part(text.as_bytes(), "hand.csv", &Part::WHOLE, layout).map_err(|error| error.to_string())
}

#[test]
fn a_sample_whose_last_number_may_be_cut_off_is_left_out_and_that_is_said() {
    let text = "t_s,position_m\n0,0.01\n0.001,0.02\n0.002,0.01";
    let held = parse_as(text, &laid_out(|_| ())).unwrap();
    assert_eq!(held.trace.position_m, [0.01, 0.02]);
    assert_eq!(held.trace.t_s, [0.0, 0.001]);
    assert_eq!(held.notes.unended.as_deref(), Some("0.01"));
    // A last line that is left out already leaves its neighbour alone.
    let skipping = laid_out(|layout| layout.skip_missing = true);
    let held = parse_as("t_s,position_m\n0,1\n1,2\n2,", &skipping).unwrap();
    assert_eq!(held.trace.position_m, [1.0, 2.0]);
    assert_eq!((held.notes.left_out, held.notes.unended), (1, None));
    // With too few samples left, the error has the reason.
    let short = parse_as("t_s,position_m\n0,0.01\n0.001,0.02", &laid_out(|_| ())).unwrap_err();
    assert_eq!(
        short,
        "hand.csv:3:11: a trace needs at least 2 samples, this one has 1; the sample of the last line was left out, \
         because the line has no line end and its last number, `0.02`, may be cut off: if the file is complete, end \
         it with a line end"
    );
    let part = Part {
        from: 0.0005,
        ..Part::WHOLE
    };
    let short = read_part(text.as_bytes(), "hand.csv", &part, &laid_out(|_| ())).unwrap_err();
    assert!(
        short.to_string().contains("`0.01`, may be cut off"),
        "{short}"
    );
    let short = parse_as("t_s,position_m\n0,1\n1,\n2,\n", &skipping).unwrap_err();
    assert!(
        short.ends_with("has 1; 2 without a value were left out"),
        "{short}"
    );
    // A caller that receives no notes gets an error.
    assert_eq!(
        message(text),
        "hand.csv:4:7: the last line has no line end, so its last number, `0.01`, may be cut off; if the file \
         is complete, end it with a line end"
    );
    // The last line is not read, is a comment, or lies beyond the part.
    for whole in [
        "t_s,position_m,note\n0,1,a\n1,2,b",
        "t_s,position_m\n0,1\n1,2\n# en",
        "t_s,position_m\n0,1\n1,2\r\n",
    ] {
        assert_eq!(parse(whole).unwrap().position_m, [1.0, 2.0], "{whole:?}");
    }
    let part = Part {
        to: 1.0,
        ..Part::WHOLE
    };
    let text = "t_s,position_m\n0,1\n1,2\n2,3".as_bytes();
    assert!(read_part(text, "hand.csv", &part, &Layout::default()).is_ok());
}

#[test]
fn columns_delimiters_units_and_decimal_commas_are_read_as_they_are_or_as_is_said() {
    let nothing = laid_out(|_| ());
    for text in [
        "t_s;position_m\n0;0.012\n0.001;-0.003\n",
        "t_s\tposition_mm\tnote, long\n0\t12\ta\n0.001\t-3\tb\n",
        "t_ms,note,position_cm\n0,a,1.2\n1,b,-0.3\n",
        "t,position_m\n s , [m] \n0,0.012\n0.001,-0.003\n",
    ] {
        let trace = parse_as(text, &nothing).unwrap().trace;
        assert_eq!(
            (trace.t_s[1], trace.position_m[0]),
            (0.001, 0.012),
            "{text:?}"
        );
        assert_eq!(trace.position_m[1], -0.003, "{text:?}");
    }
    let recorder = "Time [ms];Pos X;Pos Y\n0,0;12,0;7\n1,0;-3,0;7\n";
    let said = laid_out(|layout| {
        layout.columns = Layout::parse_columns("t=Time [ms], x=Pos X").unwrap();
        layout.unit = Some(LengthUnit::Millimetre);
        layout.decimal_comma = true;
    });
    let trace = parse_as(recorder, &said).unwrap().trace;
    assert_eq!((trace.t_s[1], trace.position_m[1]), (0.001, -0.003));
    // Without a layout nothing is guessed.
    let without = laid_out(|layout| layout.columns = said.columns.clone());
    let error = parse_as(recorder, &without).unwrap_err();
    assert!(
        error.ends_with("; --decimal-comma reads numbers with a decimal comma"),
        "{error}"
    );
    let error = parse_as(recorder, &nothing).unwrap_err();
    assert!(error.contains("--columns t=NAME,x=NAME"), "{error}");
    let error = parse_as(
        "t_s;position_m\n0;0.5\n",
        &laid_out(|layout| layout.decimal_comma = true),
    );
    assert!(
        error
            .unwrap_err()
            .contains("`0.5` in column `position_m` is not a number")
    );
    let in_ms = laid_out(|layout| layout.time_unit = Some(TimeUnit::Millisecond));
    let trace = parse_as("t_s,position_m\n0,1\n2,1\n", &in_ms)
        .unwrap()
        .trace;
    assert_eq!(trace.t_s, [0.0, 0.002]);
}

#[test]
fn units_that_contradict_each_other_are_refused() {
    let in_mm = laid_out(|layout| layout.unit = Some(LengthUnit::Millimetre));
    let nothing = laid_out(|_| ());
    for (text, layout, words) in [
        (
            "t_s,position_m\ns,mm\n0,1\n",
            &nothing,
            "is mm according to the unit row, but m according to its name",
        ),
        (
            "t_s,position_m\ns,cm\n0,1\n",
            &in_mm,
            "is mm according to the caller, but cm according to the unit row",
        ),
        (
            "t_s,position_m\ns,inch\n0,1\n",
            &nothing,
            "`inch` in the unit row is not a unit of column `position_m`",
        ),
    ] {
        let error = parse_as(text, layout).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    let trace = parse_as("t_s,position_m\ns,mm\n0,1\n1,2\n", &in_mm)
        .unwrap()
        .trace;
    assert_eq!(trace.position_m, [0.001, 0.002]);
}

#[test]
fn the_time_is_no_value() {
    let layout = laid_out(|layout| {
        layout.columns = Layout::parse_columns("t=t_s,x=t_s").unwrap();
    });
    let error = parse_as("t_s,position_m\n0,0.01\n0.001,0.02\n", &layout).unwrap_err();
    let said = "hand.csv:1:1: the column `t_s` is selected as the time and as `position_m`; select another";
    assert!(error.contains(said), "{error}");
}

#[test]
fn samples_without_a_value_are_left_out_where_that_is_asked_for_and_counted() {
    let text = "t_s,position_m,note\n0,1,\n1,,a\n2,NaN,\n,5,\n3,4,\n";
    let held = parse_as(text, &laid_out(|layout| layout.skip_missing = true)).unwrap();
    assert_eq!(held.trace.t_s, [0.0, 3.0]);
    assert_eq!(held.notes.left_out, 3);
    let error = parse_as(text, &laid_out(|_| ())).unwrap_err();
    assert!(
        error.starts_with("hand.csv:3:3: ``") && error.contains("--skip-missing"),
        "{error}"
    );
}

#[test]
fn quoted_fields_are_read() {
    let trace = parse("t_s,note,position_m\n\"0\",\"a,b\",\"1\"\n1,,2\n").unwrap();
    assert_eq!(trace.position_m, [1.0, 2.0]);
}

#[test]
fn a_quote_that_nothing_closes_is_shown_where_it_opens() {
    let error = "the quote that opens here is not closed before the end of the file; close the \
                 field with `\"`, or remove the quote";
    for (text, place) in [
        ("t_s,position_m\n0,1\n1,\"2\n", "3:3"),
        ("t_s,position_m\n0,1\n1,\"2", "3:3"),
        // The open quote includes the following text.
        ("t_s,position_m\n0,\"1\n1,2\n2,3\n", "2:3"),
        ("t_s,position_m\n\"0,1\n1,2\n", "2:1"),
        ("t_s,position_m\n0,1\n# two\n\n1,\"\"\"2\n", "5:3"),
        ("t_s,position_m,note\n0,1,\n1,2,\"fast\n", "3:5"),
        ("t_s,\"position_m\n0,1\n", "1:5"),
        ("\u{feff}t_s,position_m\n0,1\n1,\"2\n", "3:3"),
    ] {
        assert_eq!(
            message(text),
            format!("hand.csv:{place}: {error}"),
            "{text:?}"
        );
    }
    // These quotes are closed, or are literal characters.
    for text in [
        "t_s,position_m\n0,1\n1,\"2\"",
        "t_s,note,position_m\n0,\"a \"\"b\"\"\",1\n1,\"\",2\n",
        "t_s,note,position_m\n0,5\" long,1\n1,\"c\" \",2\n",
    ] {
        assert_eq!(
            parse(&format!("{text}\n")).unwrap().t_s.len(),
            2,
            "{text:?}"
        );
    }
}

#[test]
fn a_long_field_is_not_repeated_whole() {
    let long = "x".repeat(100);
    let error = message(&format!("t_s,position_m\n0,\"{long}\n{long}\"\n"));
    let short = "x".repeat(LONGEST_FIELD);
    assert!(error.contains(&format!("`{short}…` in column")), "{error}");
}

/// Text without an end: a reader that continues after the needed part never ends.
struct Endless {
    time: u32,
    line: Vec<u8>,
}

impl Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.line.is_empty() {
            self.time += 1;
            assert!(self.time < 100_000, "read on for ever");
            self.line = format!("{},0\n", self.time).into_bytes();
        }
        let length = self.line.len().min(buffer.len());
        buffer[..length].copy_from_slice(&self.line[..length]);
        self.line.drain(..length);
        Ok(length)
    }
}

fn endless() -> Endless {
    Endless {
        time: 0,
        line: b"t_s,position_m\n0,0\n".to_vec(),
    }
}

#[test]
fn a_part_is_read_no_further_than_its_end() {
    let part = Part {
        from: 3.0,
        to: 5.5,
        longest: 2.0,
    };
    let held = read_part(endless(), "endless", &part, &Layout::default()).unwrap();
    assert_eq!(held.trace.t_s, [3.0, 4.0, 5.0]);
    assert_eq!(held.force_on_device_n, None);
}

#[test]
fn a_trace_that_is_too_long_is_refused_as_soon_as_that_shows() {
    let part = Part {
        from: 10.0,
        longest: 50.0,
        ..Part::WHOLE
    };
    let error = read_part(endless(), "endless", &part, &Layout::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "endless:63:1: the trace continues for more than 50 s after its first sample at 10 s"
    );
}

#[test]
fn a_table_without_a_header_keeps_its_first_sample() {
    let by_number = |layout: &mut Layout| {
        layout.columns = vec![("t".into(), "#1".into()), ("x".into(), "#3".into())];
    };
    let read = |text: &str, layout: &Layout| {
        read_part(text.as_bytes(), "hand.csv", &Part::WHOLE, layout).map(|held| held.trace)
    };
    let plain = laid_out(by_number);
    let trace = read("0,9,0.5\n1,9,0.25\n2,9,-1\n", &plain).unwrap();
    assert_eq!(trace.t_s, [0.0, 1.0, 2.0]);
    assert_eq!(trace.position_m, [0.5, 0.25, -1.0]);
    // A header may contain a number or a unit.
    for header in ["t,9,nan", "t_s,y,x", "0,9,x"] {
        let trace = read(&format!("{header}\n1,9,0.25\n2,9,-1\n"), &plain).unwrap();
        assert_eq!(trace.t_s, [1.0, 2.0], "{header}");
    }
    let comma = laid_out(|layout| {
        by_number(layout);
        layout.delimiter = Some(Delimiter::Semicolon);
        layout.decimal_comma = true;
    });
    let trace = read("0;9;0,5\n1;9;0,25\n", &comma).unwrap();
    assert_eq!(trace.position_m, [0.5, 0.25]);
}

#[test]
fn forces_are_those_of_the_part() {
    let text = "force_on_device_n,t_s,virtual_force_n,position_m\n-1,0,5,0\n-2,1,6,0\n-3,2,7,0\n-4,3,8,0\n";
    let part = Part {
        from: 1.0,
        to: 2.0,
        ..Part::WHOLE
    };
    let held = read_part(text.as_bytes(), "hand.csv", &part, &Layout::default()).unwrap();
    assert_eq!(held.force_on_device_n.unwrap(), [-2.0, -3.0]);
    assert_eq!(held.virtual_force_n.unwrap(), [6.0, 7.0]);
    let alone = text.replace("force_on_device_n,", "other,");
    let held = read_part(alone.as_bytes(), "hand.csv", &part, &Layout::default()).unwrap();
    assert_eq!(held.force_on_device_n, None);
    assert_eq!(held.virtual_force_n.unwrap(), [6.0, 7.0]);
}

#[test]
fn a_part_without_motion_says_where_the_trace_is() {
    let text = "t_s,position_m\n1,0\n2,0\n3,0\n";
    let needed = "of at least 2 required samples lie";
    for (from, to, words) in [
        (
            5.0,
            9.0,
            "0 {needed} from 5 s to 9 s; the times of the trace begin at 1 s and end at 3 s",
        ),
        (
            f64::NEG_INFINITY,
            0.5,
            "0 {needed} up to 0.5 s; the times of the trace begin at 1 s",
        ),
        (
            1.5,
            2.5,
            "1 {needed} from 1.5 s to 2.5 s; the times of the trace begin at 1 s",
        ),
        (
            2.5,
            f64::INFINITY,
            "1 {needed} from 2.5 s on; the times of the trace begin at 1 s and end at 3 s",
        ),
    ] {
        let part = Part {
            from,
            to,
            ..Part::WHOLE
        };
        let error = read_part(text.as_bytes(), "hand.csv", &part, &Layout::default()).unwrap_err();
        let words = words.replace("{needed}", needed);
        assert!(error.to_string().ends_with(&words), "{error}");
    }
}

#[test]
fn a_missing_column_names_the_nearest() {
    assert_eq!(
        message("# x\nposition_m,time_s\n0,1\n"),
        "hand.csv:2:12: the header has no column `t_s`, the nearest is `time_s`; needed: \
         `t_s` [s] and `position_m` [m], separated by commas, semicolons or tabs, in any order"
    );
    assert_eq!(
        message("t_s,posiiton_m\n0,1\n"),
        "hand.csv:1:5: the header has no column `position_m`, the nearest is `posiiton_m`; \
         needed: `t_s` [s] and `position_m` [m], separated by commas, semicolons or tabs, in any order"
    );
}

#[test]
fn a_header_that_is_nothing_like_it_is_marked_whole() {
    let error = parse("0,1\n2,3\n").unwrap_err();
    let place = error.place().unwrap();
    assert_eq!(&place.text()[place.span()], "0,1");
    assert_eq!(
        error.to_string(),
        "hand.csv:1:1: the header has no column `t_s`; needed: `t_s` [s] and `position_m` \
         [m], separated by commas, semicolons or tabs, in any order"
    );
}

#[test]
fn a_column_that_stands_twice_is_refused() {
    assert_eq!(
        message("t_s,position_m,t_s\n0,1,0\n"),
        "hand.csv:1:16: the header names the column `t_s` twice; one is needed"
    );
}

#[test]
fn a_word_is_not_a_number() {
    let error = parse("# one\n\nt_s,position_m\n0,1\n\n# two\n0.5, fast\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "hand.csv:7:6: `fast` in column `position_m` is not a number; allowed: decimals \
         such as 0.001 or 1e-3"
    );
    let place = error.place().unwrap();
    assert_eq!(&place.text()[place.span()], "fast");
}

#[test]
fn an_empty_field_is_not_a_number() {
    assert_eq!(
        message("t_s,position_m\n0,\n"),
        "hand.csv:2:3: `` in column `position_m` is not a number; allowed: decimals such \
         as 0.001 or 1e-3"
    );
}

#[test]
fn nan_and_infinity_are_refused() {
    for text in ["NaN", "inf", "-inf", "1e999"] {
        assert_eq!(
            message(&format!("t_s,position_m\n0,{text}\n")),
            format!(
                "hand.csv:2:3: `{text}` in column `position_m` is not finite; every sample \
                 needs a finite value"
            )
        );
    }
}

#[test]
fn time_must_increase() {
    assert_eq!(
        message("t_s,position_m\n0,1\n0.002,1\n0.002,1\n"),
        "hand.csv:4:1: the time 0.002 s does not come after 0.002 s; times must increase from \
         line to line"
    );
    assert_eq!(
        message("t_s,position_m\r\n0.5,1\r\n0.25,1\r\n"),
        "hand.csv:3:1: the time 0.25 s does not come after 0.5 s; times must increase from \
         line to line"
    );
}

#[test]
fn fewer_than_two_samples_are_no_trace() {
    assert_eq!(
        message("t_s,position_m\n"),
        "hand.csv:1:15: a trace needs at least 2 samples, this one has 0"
    );
    assert_eq!(
        message("t_s,position_m\n0,1\n"),
        "hand.csv:2:4: a trace needs at least 2 samples, this one has 1"
    );
}

#[test]
fn each_line_has_one_field_per_column() {
    let error = parse("t_s,position_m\n0,1\n0,5,1\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "hand.csv:3:1: the line has 3 fields, the header 2; each line has one field per column"
    );
    let place = error.place().unwrap();
    assert_eq!(&place.text()[place.span()], "0,5,1");
}

#[test]
fn an_empty_file_is_no_trace() {
    for text in ["", "\n\n", "# nothing\n", "\u{feff}"] {
        let error = message(text);
        assert!(
            error.ends_with(
                "the file is empty; a trace begins with a header that names its columns: `t_s` and \
                 `position_m`, or in a world t, x, y and z"
            ),
            "{error}"
        );
    }
    assert!(message("").starts_with("hand.csv:1:1: "));
}

#[test]
fn other_encodings_are_named_by_their_byte() {
    let error = read(&b"t_s,position_m\n0,1 \xb5m\n"[..], "hand.csv").unwrap_err();
    assert_eq!(
        error.to_string(),
        "hand.csv:2:5: the byte 0xB5 is not UTF-8; save the trace as UTF-8 text"
    );
    assert_eq!(error.place().unwrap().span().start, 19);
    let utf16 = read(&b"\xff\xfet\0_\0s\0"[..], "hand.csv").unwrap_err();
    assert_eq!(
        utf16.to_string(),
        "hand.csv:1:1: the byte 0xFF is not UTF-8; save the trace as UTF-8 text"
    );
}

#[test]
fn a_line_without_end_is_refused() {
    let error = read(io::repeat(0), "zero.csv").unwrap_err();
    assert!(matches!(error, TraceError::Unreadable { .. }), "{error:?}");
    let words = error.to_string();
    assert!(
        words.contains("zero.csv") && words.contains("1 MiB"),
        "{words}"
    );
    // The same bytes in a terminated line are a header with wrong names.
    let ends = read("x,".repeat(1000).as_bytes(), "x.csv").unwrap_err();
    assert!(matches!(ends, TraceError::Invalid { .. }), "{ends:?}");
}

#[test]
fn a_reader_that_fails_is_reported_by_name() {
    struct Broken;
    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("the cable came off"))
        }
    }
    let error = read(Broken, "hand.csv").unwrap_err();
    assert_eq!(
        error.to_string(),
        "hand.csv: cannot be read: the cable came off"
    );
    assert!(error.place().is_none());
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes: Vec<u8>) {
        let _ = read(&bytes[..], "any");
    }

    #[test]
    fn no_text_of_csv_characters_makes_the_reader_panic(
        tail in "[t_s,position_m0-9.\"#\r\n µ;-]{0,80}",
    ) {
        let _ = parse(&format!("t_s,position_m\n{tail}"));
    }
}
