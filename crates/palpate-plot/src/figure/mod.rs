//! Figures for a paper: panels in a grid over one time axis, [fields](FieldFigure), [dots](DotFigure) and schematic
//! [drawings](drawing); as SVG or PDF, and as PNG with the feature `png`.
//!
//! The panels of a column share their time axis and the panels of a row share their vertical range, so that columns
//! can be compared by eye. Colours are those of Okabe and Ito; dashes distinguish curves in greyscale. The same
//! figure gives the same bytes.

mod axis;
mod cut;
mod dots;
pub mod drawing;
mod element;
mod field;
mod grid;
mod ink;
mod legend;
mod page;
mod panel;
mod pdf;
#[cfg(feature = "png")]
mod png;
mod range;
mod size;
mod stroke;
mod svg;
mod text;
mod thin;
mod wording;

#[cfg(test)]
mod tests;

pub use dots::{Dot, DotFigure, DotPanel};
pub use drawing::{Beside, Drawing, Pen};
pub use field::{Bound, FieldFigure, FieldPanel, FieldRow, Scale};
pub use pdf::pdf;
#[cfg(feature = "png")]
pub use png::{PngError, png};
pub use size::{Size, SizeError};
pub use svg::svg;
pub use wording::Wording;

/// A drawable figure: a [`Figure`], a [`Sheet`], a [`FieldFigure`], a [`DotFigure`] or a [`Drawing`].
pub trait Picture: drawn::Drawn {
    /// Returns the figure with other words; `None` for a [`Drawing`], which has neither title nor small print.
    fn worded(&self, _: &Wording) -> Option<Box<dyn Picture>> {
        None
    }
}

/// Hides the types of the drawing library from the public API.
mod drawn {
    use super::page::Page;
    use super::{DotFigure, FieldFigure, Figure, Sheet, Size, SizeError, dots, field, page};

    /// A figure that can be laid out on a page.
    pub trait Drawn {
        /// Returns the page.
        fn page(&self, size: Size) -> Result<Page, SizeError>;
    }

    impl Drawn for Figure {
        fn page(&self, size: Size) -> Result<Page, SizeError> {
            page::page(&Sheet::from(self), size)
        }
    }

    impl Drawn for Sheet {
        fn page(&self, size: Size) -> Result<Page, SizeError> {
            page::page(self, size)
        }
    }

    impl Drawn for FieldFigure {
        fn page(&self, size: Size) -> Result<Page, SizeError> {
            field::page(self, size)
        }
    }

    impl Drawn for DotFigure {
        fn page(&self, size: Size) -> Result<Page, SizeError> {
            dots::page(self, size)
        }
    }
}

/// A figure: rows of panels over one time axis.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Title: the content of the figure; empty for no title.
    pub title: String,
    /// Subtitle: the subject of the figure; empty for no subtitle.
    pub subtitle: String,
    /// Small print at the bottom.
    pub footnote: Option<String>,
    /// Quantity and unit of the horizontal axis, `time [s]`.
    pub x_label: String,
    /// Whether the horizontal positions are decimal logarithms of the shown quantity.
    pub x_decades: bool,
    /// Headings of the columns; may be empty for a single column.
    pub columns: Vec<String>,
    /// The rows, from top to bottom.
    pub rows: Vec<Row>,
}

/// A figure of several grids: a line contains grids side by side, and the lines are below each other.
///
/// All panels share the time axis. In a line with fewer grids the frames are wider, so that the line spans the full
/// width.
#[derive(Debug, Clone, Default)]
pub struct Sheet {
    /// As of a [`Figure`].
    pub title: String,
    /// As of a [`Figure`].
    pub subtitle: String,
    /// As of a [`Figure`].
    pub footnote: Option<String>,
    /// As of a [`Figure`].
    pub x_label: String,
    /// As of a [`Figure`].
    pub x_decades: bool,
    /// Whether all rows with the same label, in any grid, have the same vertical axis.
    pub same_scales: bool,
    /// The lines of grids.
    pub lines: Vec<Vec<Grid>>,
}

/// Rows of panels with their headings.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// Headings of the columns; may be empty for a single column.
    pub columns: Vec<String>,
    /// Headings of the rows, above each row at its left; may be empty.
    pub heads: Vec<String>,
    /// Whether all rows have the same vertical axis, the union of their own.
    pub same_scale: bool,
    /// The rows, from top to bottom.
    pub rows: Vec<Row>,
}

impl From<&Figure> for Sheet {
    fn from(figure: &Figure) -> Self {
        Self {
            title: figure.title.clone(),
            subtitle: figure.subtitle.clone(),
            footnote: figure.footnote.clone(),
            x_label: figure.x_label.clone(),
            x_decades: figure.x_decades,
            same_scales: false,
            lines: vec![vec![Grid {
                columns: figure.columns.clone(),
                rows: figure.rows.clone(),
                ..Grid::default()
            }]],
        }
    }
}

impl Sheet {
    fn series(&self) -> impl Iterator<Item = &Series> {
        self.lines
            .iter()
            .flatten()
            .flat_map(|grid| &grid.rows)
            .flat_map(|row| &row.panels)
            .flat_map(|panel| &panel.series)
    }
}

/// Panels that share a vertical axis.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Quantity and unit of the vertical axis, `force [N]`.
    pub y_label: String,
    /// Whether the vertical positions are decimal logarithms of the shown quantity.
    pub y_decades: bool,
    /// Range of the vertical axis.
    pub limits: Limits,
    /// One panel per column, from left to right.
    pub panels: Vec<Panel>,
}

/// One plot of superimposed series. Without a series it is an empty frame.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// The series, from the lowest drawn; references are drawn below all others.
    pub series: Vec<Series>,
}

/// One curve.
///
/// Non-finite samples interrupt it. If `x` and `y` differ in length, the longer is truncated.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; a series without a name has no entry there.
    pub name: String,
    /// Interpolation between the samples.
    pub kind: Kind,
    /// Role of the series, which determines its colour, dashes and width.
    pub role: Role,
    /// Horizontal positions, not decreasing.
    pub x: Vec<f64>,
    /// Vertical positions.
    pub y: Vec<f64>,
}

/// Interpolation between the samples of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// By straight lines.
    Line,
    /// Each value holds until the next sample, a zero-order hold; the last sample ends the curve.
    Step,
    /// No connection.
    Points,
}

/// Role of a series. The same role looks the same in every figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Reference for the other series: a broad grey line behind them.
    Reference,
    /// Companion of the reference, for example its device: a narrower, darker grey line.
    BesideReference,
    /// Compared series, counted from 0.
    Compared(usize),
    /// Companion of a compared series: a thin line in its colour and dashes.
    Beside(usize),
    /// The device, if all series share one: a thin black line with long dashes.
    Device,
    /// Measured series: a thin black line without gaps.
    Recorded,
    /// Highlighted samples: a black ring, or a thin black dotted line.
    Mark,
}

impl Role {
    /// Whether the series is a reference or its companion.
    fn is_reference(self) -> bool {
        matches!(self, Self::Reference | Self::BesideReference)
    }
}

/// Range of the vertical axis of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limits {
    /// Range of all data.
    Data,
    /// Range of all data, limited to `times` the range of the reference, so that one diverging series does not
    /// flatten the others. Without a reference, or if it is constant, the narrower half of the series replaces it.
    /// Series that leave the panel are marked and named.
    Calm {
        /// Height of the axis as a multiple of the range of the reference.
        times: f64,
    },
}

impl Default for Limits {
    fn default() -> Self {
        Self::Calm { times: 3.0 }
    }
}
