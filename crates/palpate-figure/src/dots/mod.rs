//! Dot plots: a panel for each group, a line of it for each of those that are compared, over one
//! logarithmic axis.

mod page;

pub(super) use page::page;

/// A page of dot plots.
#[derive(Debug, Clone, Default)]
pub struct DotFigure {
    /// Line above everything: what the figure shows.
    pub title: String,
    /// Line below it: what it is a figure of.
    pub subtitle: String,
    /// Small print below everything.
    pub footnote: String,
    /// Quantity and unit of the axis.
    pub x_label: String,
    /// Values above it are drawn at the edge, with an arrow.
    pub largest: f64,
    /// What [`DotPanel::floor`] is, for the legend.
    pub floor_label: String,
    /// What a ring in place of a dot says, for the legend.
    pub ring_label: String,
    /// One panel for each group, in reading order.
    pub panels: Vec<DotPanel>,
}

/// One group.
#[derive(Debug, Clone, Default)]
pub struct DotPanel {
    /// Words above the panel.
    pub head: String,
    /// What no value can be below; drawn as a line.
    pub floor: Option<f64>,
    /// The compared ones; the same in all panels.
    pub dots: Vec<Dot>,
}

/// One of those that are compared.
#[derive(Debug, Clone, Default)]
pub struct Dot {
    /// Its name, at the left of the first panel.
    pub name: String,
    /// Its value, above 0; none is drawn where there is none.
    pub value: Option<f64>,
    /// Whether it is drawn as a ring.
    pub ring: bool,
    /// Words beside it, as few as there can be.
    pub note: String,
}
