//! One panel: its curves and its axes.

use std::sync::Arc;

use kuva::plot::scatter::MarkerShape;
use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::theme::Theme;

use super::ink::{self, dash_array, ink};
use super::stroke::{Strokes, Window, strokes};
use super::{Kind, Panel, Role, Series, axis, text};

/// Size of the numbers at the ticks `[px]`.
pub(super) const TICK_SIZE: u32 = 11;
/// Size of the labels of the axes `[px]`.
pub(super) const LABEL_SIZE: u32 = 12;

/// Half the height of the marker of a series that leaves the panel `[px]`.
const MARK: f64 = 4.0;

/// The content of a panel, ready to be drawn.
pub(super) struct Drawn {
    /// The curves, lowest first.
    pub plots: Vec<Plot>,
    /// The series that leave the panel: name, above, below.
    pub leaving: Vec<(String, bool, bool)>,
    /// Number of series.
    pub series: usize,
}

/// Prepares the curves of a panel of `height` `[px]`.
pub(super) fn draw(panel: &Panel, window: &Window, height: f64) -> Drawn {
    let mut plots = Vec::new();
    let (low, high) = window.y;
    if panel.series.is_empty() {
        // A place of the grid that no panel needs stays blank.
    } else if low < 0.0 && 0.0 < high {
        let zero = LinePlot::new().with_data([(window.x.0, 0.0), (window.x.1, 0.0)]);
        plots.push(zero.with_color(ink::ZERO).with_stroke_width(0.9).into());
    } else {
        // The library draws no axes for an empty plot.
        plots.push(LinePlot::new().into());
    }
    let is_reference = |series: &&Series| series.role.is_reference();
    let references = panel.series.iter().filter(is_reference);
    let others = panel.series.iter().filter(|series| !is_reference(series));
    let mut leaving = Vec::new();
    let mut marks = Vec::new();
    let unit = (high - low) / height;
    for series in references.chain(others) {
        let Strokes {
            pieces,
            above,
            below,
        } = strokes(series, window);
        plots.extend(pieces.into_iter().map(|piece| curve(series, piece)));
        if above.is_some() || below.is_some() {
            leaving.push((text::clean(&series.name), above.is_some(), below.is_some()));
        }
        let marker = |x: f64, y: f64, shape| {
            let margin = 1.5 * MARK * window.pixel;
            let x = x.clamp(window.x.0 + margin, window.x.1 - margin);
            let mark = ScatterPlot::new()
                .with_data([(x, y)])
                .with_color(ink(series.role).colour);
            Plot::from(mark.with_size(MARK).with_marker(shape))
        };
        marks.extend(above.map(|x| marker(x, high - 1.5 * MARK * unit, MarkerShape::Triangle)));
        marks.extend(below.map(|x| marker(x, low + 1.5 * MARK * unit, MarkerShape::TriangleDown)));
    }
    plots.extend(marks);
    Drawn {
        plots,
        leaving,
        series: panel.series.len(),
    }
}

fn curve(series: &Series, points: Vec<(f64, f64)>) -> Plot {
    let ink = ink(series.role);
    if series.kind == Kind::Points {
        let dots = ScatterPlot::new().with_data(points);
        if series.role == Role::Mark {
            let ring = dots.with_color(ink.colour).with_size(MARK + 1.0);
            let ring = ring.with_marker(ink.marker).with_marker_opacity(0.0);
            return ring.with_marker_stroke_width(1.6).into();
        }
        let dots = dots.with_color(ink.colour).with_size(2.5);
        return dots.with_marker(ink.marker).into();
    }
    let mut line = LinePlot::new().with_data(points);
    if let Some(dashes) = dash_array(ink.dashes) {
        line = line.with_line_style(kuva::plot::LineStyle::Custom(dashes));
    }
    line.with_color(ink.colour)
        .with_stroke_width(ink.width)
        .into()
}

/// Returns the axes of a panel of the given size `[px]`, without their labels. `decades` selects powers of ten for
/// the horizontal and the vertical axis.
pub(super) fn axes(window: &Window, width: f64, height: f64, decades: (bool, bool)) -> Layout {
    let step = |range: (f64, f64), length: f64, room: f64, decades: bool| {
        let step = axis::tick_step(range, length, room);
        if decades { step.ceil().max(1.0) } else { step }
    };
    let x_step = step(window.x, width, 48.0, decades.0);
    let y_step = step(window.y, height, 26.0, decades.1);
    let label = |step: f64, decades: bool| {
        if decades {
            return TickFormat::Custom(Arc::new(axis::decade_label));
        }
        TickFormat::Custom(Arc::new(move |value| axis::tick_label(value, step)))
    };
    let mut layout = Layout::new(window.x, window.y)
        .with_x_axis_min(window.x.0)
        .with_x_axis_max(window.x.1)
        .with_y_axis_min(window.y.0)
        .with_y_axis_max(window.y.1)
        .with_x_tick_step(x_step)
        .with_y_tick_step(y_step)
        .with_x_tick_format(label(x_step, decades.0))
        .with_y_tick_format(label(y_step, decades.1))
        .with_tick_size(TICK_SIZE)
        .with_label_size(LABEL_SIZE)
        .with_tick_length(4.0)
        .with_axis_line_width(0.8)
        .with_tick_width(0.8)
        .with_grid_line_width(0.7)
        .with_box_axes()
        .with_font_family(text::FAMILY)
        .with_theme(Theme {
            axis_color: ink::FRAME.into(),
            tick_color: ink::FRAME.into(),
            grid_color: ink::GRID.into(),
            ..Theme::light()
        });
    layout.show_legend = false;
    layout
}
