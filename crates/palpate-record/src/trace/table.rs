//! Common reader of tables of recorded motions.

use std::io::Read;
use std::ops::Range;

use crate::files::bounded::{Bounded, TABLE};
use csv::StringRecord;

use super::columns::{Column, Kind, Wanted};
use super::fault::{TraceError, TraceFault};
use super::growing::{Growing, Unread};
use super::layout::{Delimiter, Layout, Way, Ways};
use super::{Part, ReadNotes, shortened};
use crate::place::{TextPosition, field_span, first_byte, open_quote, record_span};

/// Contents of a table.
pub(super) struct Request<'a> {
    pub part: &'a Part,
    pub layout: &'a Layout,
    /// Columns after the time.
    pub wanted: &'a [Wanted],
    /// Description of all required columns.
    pub needed: &'a str,
    /// Checks the numbers of a sample, in the order of `wanted`; returns a fault and its column.
    pub check: &'a Check<'a>,
}

/// Returns a fault in the numbers of a sample, with its column.
pub(super) type Check<'a> = dyn Fn(&[f64]) -> Option<(usize, TraceFault)> + 'a;

/// The samples of a table.
#[derive(Debug, Default)]
pub(super) struct Samples {
    pub t_s: Vec<f64>,
    /// Numbers of each sample, in the order of the requested columns.
    pub numbers: Vec<f64>,
    /// Whether each requested column exists.
    pub is_there: Vec<bool>,
    pub notes: ReadNotes,
}

/// Text of a trace as far as read, and its name.
pub(super) struct Text<'a, R: Read> {
    file: &'a str,
    delimiter: u8,
    records: csv::Reader<Growing<R>>,
    /// Offset of the first byte read for the last record.
    last: usize,
}

/// One record and the offset of the first byte read for it.
struct Line {
    from: usize,
    fields: StringRecord,
}

impl Line {
    fn new() -> Self {
        Self {
            from: 0,
            fields: StringRecord::new(),
        }
    }
}

/// A table as far as its samples are read.
struct Reading {
    /// Number of fields of the header.
    field_count: usize,
    time: Column,
    /// Requested columns; `None` where the table has none.
    found: Vec<Option<Column>>,
    samples: Samples,
    /// First time of the table `[s]`.
    first: Option<f64>,
    /// Time of the line before, up to the end of the part `[s]`.
    before: Option<f64>,
    /// Whether the next line is the first after the header.
    is_first_line: bool,
    is_read_to_its_end: bool,
    /// Whether the last line read gave a sample of the part.
    ends_in_sample: bool,
    /// Numbers of the current line.
    numbers: Vec<f64>,
}

impl Reading {
    /// Starts after a header with `field_count` fields.
    fn new(field_count: usize, time: Column, found: Vec<Option<Column>>) -> Self {
        Self {
            field_count,
            samples: Samples {
                is_there: found.iter().map(Option::is_some).collect(),
                ..Samples::default()
            },
            first: None,
            before: None,
            is_first_line: true,
            is_read_to_its_end: true,
            ends_in_sample: false,
            numbers: Vec::with_capacity(found.len()),
            time,
            found,
        }
    }

    /// Returns whether `line` is a sample, although it is where a header is expected: all columns are given by their
    /// number, and their fields are numbers.
    fn is_sample(&self, line: &Line, layout: &Layout) -> bool {
        let mut columns = std::iter::once(&self.time).chain(self.found.iter().flatten());
        !layout.columns.is_empty()
            && layout.columns.iter().all(|(_, name)| name.starts_with('#'))
            && columns.all(|column| {
                parsed(line.fields[column.at].trim(), layout).is_some_and(f64::is_finite)
            })
    }
}

/// A fault and the bytes at fault.
type Fault = (Range<usize>, TraceFault);

impl<'a, R: Read> Text<'a, Bounded<R>> {
    pub fn new(reader: R, file: &'a str, layout: &Layout) -> Self {
        let mut growing = Growing::new(TABLE.reader(reader));
        let delimiter = layout
            .delimiter
            .unwrap_or_else(|| delimiter_of(growing.first_line(), layout))
            .byte();
        let records = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .comment(Some(b'#'))
            .from_reader(growing);
        Self {
            file,
            delimiter,
            records,
            last: 0,
        }
    }

    fn source(&self) -> &str {
        self.records.get_ref().text()
    }

    fn fault(&mut self, (span, fault): Fault) -> TraceError {
        self.records.get_mut().read_past(span.end);
        let place = Box::new(TextPosition::new(self.file, self.source(), span));
        TraceError::Invalid { place, fault }
    }

    /// Returns a fault of a field of a line, or of the whole line; an unclosed quote in the line takes precedence.
    fn fault_in(&mut self, line: &Line, at: Option<usize>, fault: TraceFault) -> TraceError {
        let delimiter = self.delimiter;
        let start = skip_to_record(self.source(), line.from);
        let found = match (open_quote(self.source(), start, delimiter), at) {
            (Some(at), _) => (at..at + 1, TraceFault::OpenQuote),
            (None, Some(at)) => (field_span(self.source(), start, at, delimiter), fault),
            (None, None) => (record_span(self.source(), start, delimiter), fault),
        };
        self.fault(found)
    }

    /// Reads the next record into `line`; returns whether there is one.
    fn next(&mut self, line: &mut Line) -> Result<bool, TraceError> {
        let read = self.records.read_record(&mut line.fields);
        let mark = self.records.get_ref().mark();
        line.from = mark + first_byte(&line.fields);
        match self.records.get_mut().take_fault() {
            Some(Unread::Io(source)) => {
                let file = self.file.to_owned();
                return Err(TraceError::Unreadable { file, source });
            }
            Some(Unread::NotUtf8(byte)) => {
                let text = format!("{}\u{fffd}", self.source());
                let span = self.source().len()..text.len();
                let place = Box::new(TextPosition::new(self.file, &text, span));
                let fault = TraceFault::NotUtf8 { byte };
                return Err(TraceError::Invalid { place, fault });
            }
            None => {}
        }
        // The text may have any number of fields, so no other error is possible. The library takes a comment at the
        // end of the text without a line end for a record.
        let is_there =
            read.unwrap_or(false) && skip_to_record(self.source(), line.from) < self.source().len();
        if is_there {
            self.last = line.from;
        }
        Ok(is_there)
    }

    /// Finds the time and the other columns in the header.
    fn columns(
        &mut self,
        header: &Line,
        request: &Request,
    ) -> Result<(Column, Vec<Option<Column>>), TraceError> {
        let mut found = Vec::new();
        for wanted in std::iter::once(&Wanted::time()).chain(request.wanted) {
            let column = Column::find(&header.fields, wanted, request.layout, request.needed);
            found.push(column.map_err(|(at, fault)| self.fault_in(header, at, fault))?);
        }
        let others = found.split_off(1);
        let time = found.pop().flatten();
        let time: Column = time.expect("the time column is required");
        let mut taken = vec![("the time".to_owned(), time.at)];
        for (wanted, column) in request.wanted.iter().zip(&others) {
            let Some(column) = column else {
                continue;
            };
            if let Some((one, at)) = taken.iter().find(|(_, at)| *at == column.at) {
                let fault = TraceFault::SharedColumn {
                    name: column.name.clone(),
                    one: one.clone(),
                    other: wanted.shown.clone(),
                };
                return Err(self.fault_in(header, Some(*at), fault));
            }
            taken.push((format!("`{}`", wanted.shown), column.at));
        }
        Ok((time, others))
    }

    /// Reads the samples of the part.
    pub fn samples(&mut self, request: &Request) -> Result<Samples, TraceError> {
        check_keys(self.file, request)?;
        let mut header = Line::new();
        if !self.next(&mut header)? {
            let end = self.source().len();
            return Err(self.fault((end..end, TraceFault::Empty)));
        }
        let (time, found) = self.columns(&header, request)?;
        let mut reading = Reading::new(header.fields.len(), time, found);
        let mut line = Line::new();
        // Columns that are given by their number need no header: a first line of numbers is a sample.
        let mut is_read = reading.is_sample(&header, request.layout);
        if is_read {
            line = header;
        }
        while std::mem::take(&mut is_read) || self.next(&mut line)? {
            reading.ends_in_sample = false;
            self.check_field_count(&line, reading.field_count)?;
            if self.skips_line(&line, request.layout, &mut reading)? {
                continue;
            }
            let now = self.next_time(&line, request.layout, &mut reading)?;
            if now > request.part.to {
                reading.is_read_to_its_end = false;
                break;
            }
            reading.before = Some(now);
            if now < request.part.from {
                continue;
            }
            self.check_duration(&line, request.part, now, &reading)?;
            self.add_sample(&line, request, now, &mut reading)?;
            reading.ends_in_sample = true;
        }
        if reading.is_read_to_its_end {
            self.check_end(request.layout, &mut reading)?;
        }
        self.check_count(request.part, &reading)?;
        Ok(reading.samples)
    }

    /// Rejects a line whose number of fields is not that of the header.
    fn check_field_count(&mut self, line: &Line, expected: usize) -> Result<(), TraceError> {
        let count = line.fields.len();
        if expected != count {
            let fault = TraceFault::FieldCount {
                expected,
                found: count,
            };
            return Err(self.fault_in(line, None, fault));
        }
        Ok(())
    }

    /// Reads a line of units and counts a left-out line; returns whether the line has no sample.
    fn skips_line(
        &mut self,
        line: &Line,
        layout: &Layout,
        reading: &mut Reading,
    ) -> Result<bool, TraceError> {
        let Reading { time, found, .. } = reading;
        let is_units = reading.is_first_line && Column::is_unit_of_time(&line.fields[time.at]);
        reading.is_first_line = false;
        if is_units {
            for column in std::iter::once(time).chain(found.iter_mut().flatten()) {
                let taken = column.take_unit(&line.fields[column.at], layout);
                taken.map_err(|fault| self.fault_in(line, Some(column.at), fault))?;
            }
            return Ok(true);
        }
        let is_missing = |column: &Column| is_missing(line.fields[column.at].trim());
        if layout.skip_missing && (is_missing(time) || found.iter().flatten().any(is_missing)) {
            reading.samples.notes.left_out += 1;
            return Ok(true);
        }
        Ok(false)
    }

    /// Returns the time of a line `[s]`; rejects a time that does not increase.
    fn next_time(
        &mut self,
        line: &Line,
        layout: &Layout,
        reading: &mut Reading,
    ) -> Result<f64, TraceError> {
        let now = self.number(line, &reading.time, layout)?;
        if let Some(before) = reading.before
            && now <= before
        {
            let fault = TraceFault::TimeNotIncreasing { before, now };
            return Err(self.fault_in(line, Some(reading.time.at), fault));
        }
        reading.first = reading.first.or(Some(now));
        Ok(now)
    }

    /// Rejects a sample at `now` `[s]` that is too long after the first sample of the part.
    fn check_duration(
        &mut self,
        line: &Line,
        part: &Part,
        now: f64,
        reading: &Reading,
    ) -> Result<(), TraceError> {
        let begin = reading.samples.t_s.first().copied().unwrap_or(now);
        if now - begin > part.longest {
            let fault = TraceFault::TooLong {
                longest: part.longest,
                first: begin,
            };
            return Err(self.fault_in(line, Some(reading.time.at), fault));
        }
        Ok(())
    }

    /// Reads and checks the numbers of a line, and adds its sample at `now` `[s]`.
    fn add_sample(
        &mut self,
        line: &Line,
        request: &Request,
        now: f64,
        reading: &mut Reading,
    ) -> Result<(), TraceError> {
        let Reading { found, numbers, .. } = reading;
        numbers.clear();
        for column in found.iter().flatten() {
            numbers.push(self.number(line, column, request.layout)?);
        }
        if let Some((at, fault)) = (request.check)(numbers) {
            let at = found.iter().flatten().nth(at).map(|column| column.at);
            return Err(self.fault_in(line, at, fault));
        }
        reading.samples.t_s.push(now);
        reading.samples.numbers.extend_from_slice(numbers);
        Ok(())
    }

    /// Rejects an unclosed quote at the end of the text, and leaves out a last sample whose number may be cut off.
    fn check_end(&mut self, layout: &Layout, reading: &mut Reading) -> Result<(), TraceError> {
        // Only the last record can have an unclosed quote.
        let start = skip_to_record(self.source(), self.last);
        if let Some(at) = open_quote(self.source(), start, self.delimiter) {
            return Err(self.fault((at..at + 1, TraceFault::OpenQuote)));
        }
        let last = reading.field_count - 1;
        let reads_last = std::iter::once(&reading.time)
            .chain(reading.found.iter().flatten())
            .any(|column| column.at == last);
        if !reads_last {
            return Ok(());
        }
        let Some(number) = self.cut_off(last, layout)? else {
            return Ok(());
        };
        let samples = &mut reading.samples;
        if reading.ends_in_sample {
            samples.t_s.pop();
            let width = reading.found.iter().flatten().count();
            samples.numbers.truncate(width * samples.t_s.len());
            samples.notes.unended = Some(number);
        }
        Ok(())
    }

    /// Rejects a part with fewer than two samples.
    fn check_count(&mut self, part: &Part, reading: &Reading) -> Result<(), TraceError> {
        let count = reading.samples.t_s.len();
        if count < 2 {
            let end = self.source().trim_end().len();
            let notes = reading.samples.notes.clone();
            let fault = match reading.first {
                Some(first) if (part.from, part.to) != (Part::WHOLE.from, Part::WHOLE.to) => {
                    TraceFault::TooFewInPart {
                        from: part.from,
                        to: part.to,
                        found: count,
                        first,
                        last: reading.before.filter(|_| reading.is_read_to_its_end),
                        notes,
                    }
                }
                _ => TraceFault::TooFewSamples {
                    found: count,
                    notes,
                },
            };
            return Err(self.fault((end..end, fault)));
        }
        Ok(())
    }

    /// Returns the last number of a text whose last line has no line end; returns an error if the caller receives no
    /// notes.
    fn cut_off(&mut self, last: usize, layout: &Layout) -> Result<Option<String>, TraceError> {
        let source = self.source();
        if source.is_empty() || source.ends_with(['\n', '\r']) {
            return Ok(None);
        }
        let start = skip_to_record(source, self.last);
        let span = field_span(source, start, last, self.delimiter);
        // A truncated comment is harmless.
        if source[span.end..].contains(['\n', '\r']) {
            return Ok(None);
        }
        let text = shortened(&source[span.clone()]);
        if layout.ways == Ways::Nothing {
            return Err(self.fault((span, TraceFault::CutOff { text })));
        }
        Ok(Some(text))
    }

    fn number(&mut self, line: &Line, column: &Column, layout: &Layout) -> Result<f64, TraceError> {
        let text = line.fields[column.at].trim();
        let parsed = parsed(text, layout);
        if let Some(value) = parsed
            && value.is_finite()
        {
            return Ok(column.si(value));
        }
        let ways = layout.ways;
        let way = if is_missing(text) {
            ways.skip_missing()
        } else if !layout.decimal_comma && text.replacen(',', ".", 1).parse::<f64>().is_ok() {
            ways.decimal_comma()
        } else {
            NO_WAY
        };
        let name = column.name.clone();
        let text = shortened(text);
        let fault = match parsed {
            _ if column.kind == Kind::Force => TraceFault::NotAForce { name, text },
            Some(_) => TraceFault::NotFinite { name, text, way },
            None => TraceFault::NotANumber { name, text, way },
        };
        Err(self.fault_in(line, Some(column.at), fault))
    }
}

fn parsed(text: &str, layout: &Layout) -> Option<f64> {
    if !layout.decimal_comma {
        text.parse().ok()
    } else if text.contains('.') {
        None
    } else {
        text.replace(',', ".").parse().ok()
    }
}

/// Caller without an interface.
const NO_WAY: Way = Ways::Nothing.skip_missing();

/// Rejects a layout that selects a quantity that tables of this kind do not have.
fn check_keys(file: &str, request: &Request) -> Result<(), TraceError> {
    let mut known = vec!["t".to_owned()];
    known.extend(
        request
            .wanted
            .iter()
            .filter_map(|wanted| wanted.keys.first().cloned()),
    );
    let wanted = request.wanted.iter().flat_map(|wanted| &wanted.keys);
    let keys: Vec<&String> = wanted.collect();
    let unknown = request
        .layout
        .columns
        .iter()
        .find(|(key, _)| key != "t" && !keys.contains(&key));
    let Some((key, name)) = unknown else {
        return Ok(());
    };
    Err(TraceError::Layout {
        file: file.to_owned(),
        fault: format!(
            "column `{name}` is given as `{key}`, which is not a quantity of this motion; allowed: {}",
            known.join(", ")
        ),
    })
}

/// Returns the delimiter of a header's fields, from the layout or the header.
fn delimiter_of(header: &str, layout: &Layout) -> Delimiter {
    let mut quoted = false;
    let plain: String = header
        .chars()
        .filter(|&letter| {
            quoted ^= letter == '"';
            !quoted
        })
        .collect();
    let there = |delimiter: &Delimiter| plain.contains(char::from(delimiter.byte()));
    let found: Vec<Delimiter> = Delimiter::ALL.into_iter().filter(there).collect();
    if let [only] = found[..] {
        return only;
    }
    // Of several, prefer one that gives a time column.
    let has_time = |delimiter: &&Delimiter| {
        let fields = header.split(char::from(delimiter.byte()));
        let record: StringRecord = fields.map(|field| field.trim_matches('"')).collect();
        Column::find(&record, &Wanted::time(), layout, "").is_ok()
    };
    found
        .iter()
        .find(has_time)
        .copied()
        .unwrap_or(Delimiter::Comma)
}

/// Returns whether a cell marks a missing value.
fn is_missing(text: &str) -> bool {
    const WORDS: [&str; 7] = ["", "-", "nan", "na", "n/a", "null", "none"];
    WORDS.iter().any(|word| text.eq_ignore_ascii_case(word))
}

/// Skips comments and empty lines from `start` to the record itself.
fn skip_to_record(source: &str, mut start: usize) -> usize {
    while let Some(&byte) = source.as_bytes().get(start) {
        match byte {
            b'\n' | b'\r' => start += 1,
            b'#' => {
                start += source[start..]
                    .find('\n')
                    .map_or(source.len() - start, |at| at + 1)
            }
            _ => break,
        }
    }
    start
}
