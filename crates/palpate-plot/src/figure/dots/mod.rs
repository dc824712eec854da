//! Dot plots: one panel per group and one line per compared item, over one logarithmic axis.

mod page;

pub(super) use page::page;

/// A page of dot plots.
#[derive(Debug, Clone, Default)]
pub struct DotFigure {
    /// Title: the content of the figure.
    pub title: String,
    /// Subtitle: the subject of the figure.
    pub subtitle: String,
    /// Small print at the bottom.
    pub footnote: String,
    /// Quantity and unit of the axis.
    pub x_label: String,
    /// Values above this limit are drawn at the edge, with an arrow.
    pub largest: f64,
    /// Legend entry of [`DotPanel::floor`].
    pub floor_label: String,
    /// Legend entry of a ring (a dot with [`Dot::ring`]).
    pub ring_label: String,
    /// One panel for each group, in reading order.
    pub panels: Vec<DotPanel>,
}

/// One group.
#[derive(Debug, Clone, Default)]
pub struct DotPanel {
    /// Heading of the panel.
    pub head: String,
    /// Lower bound of all values; drawn as a line.
    pub floor: Option<f64>,
    /// The compared items; the same in all panels.
    pub dots: Vec<Dot>,
}

/// A compared item.
#[derive(Debug, Clone, Default)]
pub struct Dot {
    /// Name, at the left of the first panel.
    pub name: String,
    /// Value, above 0; `None` draws no dot.
    pub value: Option<f64>,
    /// Whether it is drawn as a ring.
    pub ring: bool,
    /// Short annotation beside the dot.
    pub note: String,
}
