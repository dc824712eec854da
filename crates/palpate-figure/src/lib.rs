//! Figures for a paper: panels in a grid over one time axis, [fields](FieldFigure), [dots](DotFigure) and
//! [drawings](drawing) of what is no plot; as SVG or PDF, and as PNG with the feature `png`.
//!
//! The panels of a column stand on the same time axis, the panels of a row share their vertical
//! range, so that columns can be compared by eye. Colours are those of Okabe and Ito, told apart
//! by their dashes where colour is lost. The same figure gives the same bytes.

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

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

/// What can be drawn: a [`Figure`], a [`Sheet`], a [`FieldFigure`], a [`DotFigure`] or a [`Drawing`].
pub trait Picture: drawn::Drawn {}

impl Picture for Figure {}

impl Picture for Sheet {}

impl Picture for FieldFigure {}

impl Picture for DotFigure {}

/// Keeps the drawing library out of what users of this crate see.
mod drawn {
    use super::page::Page;
    use super::{DotFigure, FieldFigure, Figure, Sheet, Size, SizeError, dots, field, page};

    /// What has a page.
    pub trait Drawn {
        /// The page.
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
    /// Line above everything, what the figure shows; none where empty.
    pub title: String,
    /// Line below the title, what it is a figure of; none where empty.
    pub subtitle: String,
    /// Small print below everything.
    pub footnote: Option<String>,
    /// Quantity and unit of the horizontal axis, `time [s]`.
    pub x_label: String,
    /// Whether the horizontal positions are logarithms to the base 10 of what the axis shows.
    pub x_decades: bool,
    /// Heads of the columns; may be empty where there is one column.
    pub columns: Vec<String>,
    /// The rows, from top to bottom.
    pub rows: Vec<Row>,
}

/// A figure of several grids: those of a line stand side by side, the lines below each other.
///
/// All panels show the same time. The frames of a line with fewer grids are as much wider as it takes
/// to reach from edge to edge.
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
    /// Whether all rows with the same label, in whatever grid, have the same vertical axis.
    pub same_scales: bool,
    /// The lines of grids.
    pub lines: Vec<Vec<Grid>>,
}

/// Rows of panels with their heads.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// Heads of the columns; may be empty where there is one column.
    pub columns: Vec<String>,
    /// Words above each row, at its left; may be empty.
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
    /// Whether the vertical positions are logarithms to the base 10 of what the axis shows.
    pub y_decades: bool,
    /// How far the vertical axis reaches.
    pub limits: Limits,
    /// One panel per column, from left to right.
    pub panels: Vec<Panel>,
}

/// One plot: the series that are laid over each other. Without a series it is an empty frame.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// The series, the one to be drawn lowest first; references are drawn below them all.
    pub series: Vec<Series>,
}

/// One curve.
///
/// Samples that are not finite interrupt it. Where `x` and `y` differ in length, the longer is
/// cut.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; a series without a name has no entry there.
    pub name: String,
    /// How the samples are connected.
    pub kind: Kind,
    /// What the series is to the reader, which decides how it looks.
    pub role: Role,
    /// Horizontal positions, not decreasing.
    pub x: Vec<f64>,
    /// Vertical positions.
    pub y: Vec<f64>,
}

/// How the samples of a series are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// By straight lines.
    Line,
    /// Each value holds until the next sample, a zero-order hold; the last sample ends the curve.
    Step,
    /// Not at all.
    Points,
}

/// What a series is to the reader. The same role looks the same in every figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// What the others are measured against, the ideal: a broad grey line behind them.
    Reference,
    /// What moves with the reference, as the ideal's device: a narrower, darker grey line.
    BesideReference,
    /// One of those that are compared, counted from 0.
    Compared(usize),
    /// What moves with one of those that are compared: a thin line that looks the same otherwise.
    Beside(usize),
    /// The device where there is one for all: a thin black line with long dashes.
    Device,
    /// What was measured: a thin black line without gaps.
    Recorded,
    /// What the figure points at: a black ring, or a thin black line of dots.
    Mark,
}

impl Role {
    /// Whether it is what the others are measured against.
    fn is_reference(self) -> bool {
        matches!(self, Self::Reference | Self::BesideReference)
    }
}

/// How far the vertical axis of a row reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limits {
    /// Over all data.
    Data,
    /// Over all data, but no further than `times` the range of the reference (or, where there is
    /// none or it stays at one value, of the calmer half of the series), so that one series that
    /// diverges does not flatten the others. What leaves the panel is marked and named.
    Calm {
        /// Height of the axis in ranges of the reference.
        times: f64,
    },
}

impl Default for Limits {
    fn default() -> Self {
        Self::Calm { times: 3.0 }
    }
}
