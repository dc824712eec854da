//! Fields over two logarithmic axes, as small multiples: filled contours, the border of a region, and horizontal
//! bounds. A strip left of the axis shows the values at zero.

mod page;
mod panel;
mod region;

pub(super) use page::page;

/// A page of fields: rows of panels over the same axes.
#[derive(Debug, Clone, Default)]
pub struct FieldFigure {
    /// Title: the content of the figure.
    pub title: String,
    /// Subtitle: the subject of the figure.
    pub subtitle: String,
    /// Small print at the bottom.
    pub footnote: String,
    /// Quantity of the horizontal axis.
    pub x_label: String,
    /// Quantity of the vertical axis.
    pub y_label: String,
    /// Label of the strip at zero.
    pub zero_label: String,
    /// Range of both axes.
    pub range: (f64, f64),
    /// Headings of the columns.
    pub columns: Vec<String>,
    /// The rows, from top to bottom.
    pub rows: Vec<FieldRow>,
}

/// Panels of one quantity.
#[derive(Debug, Clone)]
pub struct FieldRow {
    /// Name that distinguishes this row from others of the same quantity.
    pub name: String,
    /// The quantity and its colours.
    pub scale: Scale,
    /// One panel per column.
    pub panels: Vec<FieldPanel>,
}

/// A quantity and its colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// The quantity and its unit.
    pub name: String,
    /// Colour and legend entry of each step, from small to large.
    pub steps: Vec<(&'static str, String)>,
    /// The limits between the steps; a value on a limit belongs below it.
    pub limits: Vec<f64>,
    /// Legend entry of the border of the marked region.
    pub border: String,
}

/// One field.
#[derive(Debug, Clone, Default)]
pub struct FieldPanel {
    /// Number of values along the horizontal axis, including the first one at zero.
    pub columns: usize,
    /// Values, row by row from the lower end of the vertical axis; a NaN is left blank.
    pub values: Vec<f64>,
    /// The region whose border is drawn.
    pub marked: Vec<bool>,
    /// Horizontal bounds.
    pub bounds: Vec<Bound>,
}

/// A horizontal line from zero to the end of its range of validity.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Name in the legend.
    pub name: String,
    /// Position on the vertical axis.
    pub at: f64,
    /// End on the horizontal axis.
    pub to: f64,
    /// Index of the line style.
    pub look: usize,
}

impl Scale {
    /// Returns the step of a value.
    fn step(&self, value: f64) -> Option<usize> {
        (!value.is_nan()).then(|| self.limits.partition_point(|limit| *limit < value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kuva::render::render::Primitive;

    fn figure() -> FieldFigure {
        let scale = Scale {
            name: "growth".into(),
            steps: vec![("#0072b2", "small".into()), ("#e69f00", "large".into())],
            limits: vec![1.0],
            border: "stable".into(),
        };
        let panel = FieldPanel {
            columns: 3,
            values: vec![0.5, 0.5, 2.0, 0.5, 2.0, f64::NAN],
            marked: vec![true, true, false, true, false, false],
            bounds: vec![Bound {
                name: "a bound".into(),
                at: 0.1,
                to: 0.1,
                look: 0,
            }],
        };
        FieldFigure {
            title: "A map".into(),
            range: (1e-3, 10.0),
            columns: vec!["one".into(), "two".into()],
            rows: vec![FieldRow {
                name: "undamped".into(),
                scale,
                panels: vec![panel.clone(), panel],
            }],
            ..FieldFigure::default()
        }
    }

    #[test]
    fn a_value_on_a_limit_belongs_below_and_what_is_no_number_nowhere() {
        let figure = figure();
        let scale = &figure.rows[0].scale;
        assert_eq!(scale.step(1.0), Some(0));
        assert_eq!(scale.step(1.0 + 1e-12), Some(1));
        assert_eq!(scale.step(f64::INFINITY), Some(1));
        assert_eq!(scale.step(f64::NAN), None);
    }

    #[test]
    fn everything_that_is_drawn_lies_on_the_page() {
        let scene = page(&figure(), crate::figure::Size::NATURAL).unwrap().scene;
        let mut texts = Vec::new();
        for element in &scene.elements {
            let (x, y) = match element {
                Primitive::Text { x, y, content, .. } => {
                    texts.push(content.clone());
                    (*x, *y)
                }
                Primitive::Line { x2, y2, .. } => (*x2, *y2),
                Primitive::Rect { x, y, .. } => (*x, *y),
                _ => continue,
            };
            assert!(0.0 <= x && x <= scene.width, "{element:?}");
            assert!(0.0 <= y && y <= scene.height, "{element:?}");
        }
        for word in ["A map", "one", "two", "small", "large", "stable", "a bound"] {
            assert!(
                texts.iter().any(|text| text.contains(word)),
                "{word}: {texts:?}"
            );
        }
    }
}
