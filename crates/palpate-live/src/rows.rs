//! Reduction of ticks to rows that a page can draw, with every peak preserved.

use palpate_record::recording::{self, Column, ContactTick, Flags, Kind, Row, Tick};

/// Smallest number of columns of a frame.
const WIDTH: usize = live(Tick::COLUMNS) + live(ContactTick::COLUMNS);

/// Returns the columns of a frame, in their order: those of a live row. The additional columns of
/// [`Rows::with_further`] follow.
pub fn columns() -> impl Iterator<Item = &'static Column> {
    let all = recording::columns().iter().copied();
    all.filter(|column| column.is_live())
}

/// Returns how many of these columns are part of a live row.
const fn live(columns: &[Column]) -> usize {
    let (mut at, mut count) = (0, 0);
    while at < columns.len() {
        if columns[at].is_live() {
            count += 1;
        }
        at += 1;
    }
    count
}

/// Below this period, ticks are taken together `[s]`.
const SHORTEST: f64 = 0.001;
/// Shortest duration of a group `[s]`.
const GROUP: f64 = 0.002;
/// A period that was rounded is not below another by less than this part.
const ROUNDING: f64 = 1e-9;

/// Pending rows of one rendering.
#[derive(Clone, Debug)]
pub struct Rows {
    period: f64,
    /// Columns of a row.
    width: usize,
    times: Vec<f64>,
    /// The rows, one behind the other.
    values: Vec<f32>,
    group: Option<Group>,
}

/// Ticks that are taken together.
#[derive(Clone, Debug)]
struct Group {
    first: f64,
    last: f64,
    extremes: Vec<Extremes>,
    flags: Flags,
}

/// The least and the greatest value of a column, in the order in which they came.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    earlier: f32,
    later: f32,
}

impl Extremes {
    fn at(value: f32) -> Self {
        Self {
            earlier: value,
            later: value,
        }
    }

    /// Adds a value; NaN is ignored.
    fn add(&mut self, value: f32) {
        if value.is_nan() {
            return;
        }
        if self.earlier.is_nan() {
            *self = Self::at(value);
            return;
        }
        let (least, greatest) = (self.earlier.min(self.later), self.earlier.max(self.later));
        if value < least {
            *self = Self {
                earlier: greatest,
                later: value,
            };
        } else if value > greatest {
            *self = Self {
                earlier: least,
                later: value,
            };
        }
    }
}

impl Rows {
    /// No rows yet, of a loop with this period `[s]`.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self::with_further(period, 0)
    }

    /// Creates rows with `further` additional columns after those of [`columns`].
    #[must_use]
    pub fn with_further(period: f64, further: usize) -> Self {
        Self {
            period,
            width: WIDTH + further,
            times: Vec::new(),
            values: Vec::new(),
            group: None,
        }
    }

    /// Adds a tick with one of its contacts.
    pub fn add(&mut self, row: &Row) {
        self.add_with(row, &[]);
    }

    /// The same, with the values of the further columns; NaN where one is not given.
    pub fn add_with(&mut self, row: &Row, further: &[f64]) {
        let own = columns().map(|column| column.value(row).number());
        let all = own.chain(further.iter().copied());
        let all = all.chain(std::iter::repeat(f64::NAN)).take(self.width);
        let values = all.map(single);
        let tick = &row.tick;
        if self.period >= SHORTEST * (1.0 - ROUNDING) {
            self.times.push(tick.time);
            self.values.extend(values);
            return;
        }
        let group = self.group.get_or_insert_with(|| Group {
            first: tick.time,
            last: tick.time,
            // No value is an extreme of none.
            extremes: vec![Extremes::at(f32::NAN); self.width],
            flags: Flags::default(),
        });
        group.last = tick.time;
        group.flags = group.flags.with(tick.flags, true);
        for (extremes, value) in group.extremes.iter_mut().zip(values) {
            extremes.add(value);
        }
        if group.last - group.first + self.period >= GROUP * (1.0 - ROUNDING) {
            self.close_group();
        }
    }

    fn close_group(&mut self) {
        let Some(group) = self.group.take() else {
            return;
        };
        let flags = number(group.flags);
        let mut extremes = group.extremes;
        for (extremes, column) in extremes.iter_mut().zip(columns()) {
            if column.kind == Kind::Flags {
                *extremes = Extremes::at(flags);
            }
        }
        self.times.extend([group.first, group.last]);
        self.values
            .extend(extremes.iter().map(|extremes| extremes.earlier));
        self.values
            .extend(extremes.iter().map(|extremes| extremes.later));
    }

    /// A frame of the rows there are, with number 0; none if there are none.
    #[must_use]
    pub fn take_frame(&mut self, lane: u8, run: u32) -> Option<Frame> {
        let first = *self.times.first()?;
        let rows = self.times.len();
        let mut bytes = Vec::with_capacity(HEADER + 4 * rows * (1 + self.width));
        bytes.extend([1, lane]);
        bytes.extend(u16::try_from(self.width).unwrap_or(u16::MAX).to_le_bytes());
        bytes.extend(u32::try_from(rows).unwrap_or(u32::MAX).to_le_bytes());
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend(run.to_le_bytes());
        bytes.extend(first.to_le_bytes());
        for time in &self.times {
            bytes.extend(single(time - first).to_le_bytes());
        }
        for column in 0..self.width {
            for row in self.values.chunks_exact(self.width) {
                bytes.extend(row[column].to_le_bytes());
            }
        }
        self.times.clear();
        self.values.clear();
        Some(Frame { lane, bytes })
    }
}

/// Bytes before the rows.
const HEADER: usize = 24;
/// Byte range of a frame's number.
const NUMBER: std::ops::Range<usize> = 8..12;

/// A frame of samples, as `docs/reference/live-protocol.md` lays it out.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Lane, from 0.
    pub lane: u8,
    bytes: Vec<u8>,
}

impl Frame {
    /// Creates a frame of these bytes; its number is inserted at the position that frames of samples use.
    #[cfg(feature = "server")]
    pub(crate) fn new(lane: u8, bytes: Vec<u8>) -> Self {
        Self { lane, bytes }
    }

    /// The bytes of this frame under a number.
    #[must_use]
    pub fn numbered(&self, number: u32) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        bytes[NUMBER].copy_from_slice(&number.to_le_bytes());
        bytes
    }
}

/// Enough for a screen.
#[expect(clippy::cast_possible_truncation, reason = "seven digits are shown")]
fn single(value: f64) -> f32 {
    value as f32
}

/// Ten bits, exact in a float.
fn number(flags: Flags) -> f32 {
    single(f64::from(flags.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(number: u64, period: f64) -> Tick {
        Tick {
            sequence: number,
            time: number as f64 * period,
            ..Tick::default()
        }
    }

    /// Times and the column of this name of a frame.
    fn read(frame: &Frame, name: &str) -> Vec<(f64, f32)> {
        let column = columns().position(|column| column.name == name).unwrap();
        let bytes = frame.numbered(7);
        assert_eq!(bytes[NUMBER], 7_u32.to_le_bytes());
        let rows = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
        assert_eq!(bytes.len(), HEADER + 4 * rows * (1 + WIDTH));
        let first = f64::from_le_bytes(bytes[16..24].try_into().unwrap());
        let float = |index: usize| {
            let at = HEADER + 4 * index;
            f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
        };
        (0..rows)
            .map(|row| {
                let time = first + f64::from(float(row));
                (time, float(rows * (1 + column) + row))
            })
            .collect()
    }

    #[test]
    fn up_to_a_kilohertz_each_row_is_a_tick() {
        let mut rows = Rows::new(0.001);
        for number in 0..20 {
            rows.add(&Row {
                tick: Tick {
                    flags: Flags::CONTACT,
                    ..tick(number, 0.001)
                },
                contact: ContactTick {
                    penetration: -1e-3 * number as f64,
                    ..ContactTick::default()
                },
                ..Row::default()
            });
        }
        let frame = rows.take_frame(1, 3).unwrap();
        let read_back = read(&frame, "penetration_m");
        assert_eq!(read_back.len(), 20);
        for (number, (time, penetration)) in read_back.iter().enumerate() {
            assert!((time - 1e-3 * number as f64).abs() < 1e-9);
            assert!((penetration + 1e-3 * number as f32).abs() < 1e-8);
        }
        assert_eq!(read(&frame, "flags")[0].1, 1.0);
        assert!(rows.take_frame(1, 3).is_none());
    }

    /// A peak of one tick at 4 kHz, up or down, is in the frame in its order.
    #[test]
    fn no_peak_of_a_fast_loop_is_lost() {
        let period = 1.0 / 4000.0;
        for peak in 0..64 {
            for height in [5.0, -5.0] {
                let mut rows = Rows::new(period);
                for number in 0..64 {
                    rows.add(&Row {
                        tick: Tick {
                            flags: Flags::default().with(Flags::FAULT, number == peak),
                            ..tick(number, period)
                        },
                        contact: ContactTick {
                            force_on_device: if number == peak { height } else { 0.25 },
                            ..ContactTick::default()
                        },
                        ..Row::default()
                    });
                }
                let frame = rows.take_frame(0, 0).unwrap();
                let forces = read(&frame, "force_on_device_n");
                // 8 ticks a group, 2 rows each
                assert_eq!(forces.len(), 16);
                let found: Vec<_> = forces
                    .iter()
                    .filter(|(_, force)| f64::from(*force) == height)
                    .collect();
                assert_eq!(found.len(), 1, "{peak}");
                assert!((found[0].0 - peak as f64 * period).abs() < 0.002);
                assert!(forces.windows(2).all(|pair| pair[0].0 <= pair[1].0));
                let flags = read(&frame, "flags");
                assert!(flags.iter().any(|(_, flags)| *flags == 32.0), "{peak}");
            }
        }
    }

    /// Additional columns follow the others, for ticks and for groups of ticks.
    #[test]
    fn further_columns_stand_behind_the_others() {
        for (period, ticks) in [(0.001, 4), (0.00025, 16)] {
            let mut rows = Rows::with_further(period, 2);
            for number in 0..ticks {
                let row = Row {
                    tick: tick(number, period),
                    ..Row::default()
                };
                rows.add_with(&row, &[number as f64]);
            }
            let bytes = rows.take_frame(0, 0).unwrap().numbered(0);
            assert_eq!(usize::from(bytes[2]), WIDTH + 2);
            // Each tick a row, or two groups of eight with two rows each.
            let count = 4;
            assert_eq!(bytes.len(), HEADER + 4 * count * (1 + WIDTH + 2));
            let column = |column: usize| -> Vec<f32> {
                let at = HEADER + 4 * count * (1 + column);
                let singles = bytes[at..at + 4 * count].chunks(4);
                singles
                    .map(|single| f32::from_le_bytes(single.try_into().unwrap()))
                    .collect()
            };
            let expected = match ticks {
                4 => [0.0, 1.0, 2.0, 3.0],
                _ => [0.0, 7.0, 8.0, 15.0],
            };
            assert_eq!(column(WIDTH), expected);
            assert!(column(WIDTH + 1).iter().all(|value| value.is_nan()));
        }
    }

    /// The page looks its curves up by name; one that is not sent would stay empty.
    #[test]
    fn every_curve_of_the_page_is_a_column_that_it_is_sent() {
        let curves = include_str!("../page/curves.js");
        let named: Vec<&str> = curves
            .split("column: \"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        assert!(named.len() > 10, "{named:?}");
        for name in named {
            assert!(columns().any(|column| column.name == name), "{name}");
        }
    }

    #[test]
    fn extremes_come_in_their_order_and_no_value_hides_none() {
        let of = |values: &[f32]| {
            let mut extremes = Extremes::at(values[0]);
            values[1..].iter().for_each(|value| extremes.add(*value));
            (extremes.earlier, extremes.later)
        };
        assert_eq!(of(&[1.0, 3.0, 2.0, -1.0, 0.0]), (3.0, -1.0));
        assert_eq!(of(&[1.0, -1.0, 3.0, 2.0]), (-1.0, 3.0));
        assert_eq!(of(&[f32::NAN, 2.0, f32::NAN, 1.0]), (2.0, 1.0));
        assert!(of(&[f32::NAN, f32::NAN]).0.is_nan());
    }
}
