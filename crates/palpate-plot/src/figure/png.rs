//! A figure as PNG.

use kuva::backend::raster::RasterBackend;
use kuva::render::color::Color;
use kuva::render::render::Primitive;

use crate::figure::page::Page;
use crate::figure::{Picture, Size, SizeError};

/// Draws `figure` as a PNG image with `scale` pixels for each pixel of the SVG.
///
/// # Errors
///
/// The figure does not fit into `size`, or the drawing library cannot encode the image.
pub fn png(figure: &(impl Picture + ?Sized), size: Size, scale: f32) -> Result<Vec<u8>, PngError> {
    let Page {
        mut scene,
        scale: of_page,
    } = figure.page(size).map_err(PngError::Size)?;
    let elements = std::mem::take(&mut scene.elements);
    scene.elements = elements.into_iter().flat_map(solid).collect();
    #[expect(clippy::cast_possible_truncation, reason = "a factor near 1")]
    let scale = scale * of_page as f32;
    let image = RasterBackend::new().with_scale(scale).render_scene(&scene);
    image.map_err(PngError::Image)
}

/// Reason for a failed PNG image.
#[derive(Debug)]
pub enum PngError {
    /// The figure does not fit.
    Size(SizeError),
    /// The image cannot be encoded; the message is that of the drawing library.
    Image(String),
}

/// Splits a dashed line into separate lines. The library restarts its dashes at every point of a line, so a line of
/// many points would be solid.
fn solid(element: Primitive) -> Vec<Primitive> {
    match element {
        Primitive::PolyLine {
            points,
            stroke,
            stroke_width,
            stroke_dasharray: Some(dashes),
        } => dashed(&points, &dashes, &stroke, stroke_width),
        Primitive::Line {
            x1,
            y1,
            x2,
            y2,
            stroke,
            stroke_width,
            stroke_dasharray: Some(dashes),
        } => dashed(&[(x1, y1), (x2, y2)], &dashes, &stroke, stroke_width),
        other => vec![other],
    }
}

fn dashed(points: &[(f64, f64)], dashes: &str, stroke: &Color, width: f64) -> Vec<Primitive> {
    let lengths = dashes
        .split(' ')
        .filter_map(|length| length.parse::<f64>().ok());
    // The library rounds the ends of a line, which adds half a width at each end.
    let between_ends = |(index, length): (usize, f64)| match index % 2 {
        0 => (length - width).max(0.1),
        _ => length + width,
    };
    let lengths: Vec<f64> = lengths.enumerate().map(between_ends).collect();
    dash(points, &lengths)
        .into_iter()
        .map(|points| Primitive::PolyLine {
            points,
            stroke: stroke.clone(),
            stroke_width: width,
            stroke_dasharray: None,
        })
        .collect()
}

/// Returns the parts of a polyline that its dashes cover.
fn dash(points: &[(f64, f64)], lengths: &[f64]) -> Vec<Vec<(f64, f64)>> {
    let mut lengths = lengths
        .iter()
        .copied()
        .filter(|length| *length > 0.0)
        .cycle();
    let Some(mut left) = lengths.next() else {
        return vec![points.to_vec()];
    };
    let mut inked = true;
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let ((mut x, mut y), end) = (pair[0], pair[1]);
        loop {
            let distance = (end.0 - x).hypot(end.1 - y);
            if distance <= left {
                left -= distance;
                if inked {
                    piece.push(end);
                }
                break;
            }
            (x, y) = (
                x + (end.0 - x) * left / distance,
                y + (end.1 - y) * left / distance,
            );
            piece.push((x, y));
            if inked {
                pieces.push(std::mem::take(&mut piece));
            }
            inked = !inked;
            left = lengths.next().unwrap_or(f64::INFINITY);
        }
    }
    if inked {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_run_on_round_corners() {
        let points = [(0.0, 0.0), (2.0, 0.0), (2.0, 5.0)];
        assert_eq!(
            dash(&points, &[3.0, 1.0]),
            [
                vec![(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)],
                vec![(2.0, 2.0), (2.0, 5.0)]
            ]
        );
    }

    #[test]
    fn many_short_segments_are_dashed_like_one_long() {
        let points: Vec<(f64, f64)> = (0..=100).map(|i| (0.1 * f64::from(i), 0.0)).collect();
        assert_eq!(dash(&points, &[3.0, 1.0]).len(), 3);
    }
}
