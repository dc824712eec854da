//! A figure as SVG.

use std::fmt::Write;

use kuva::backend::svg::SvgBackend;
use kuva::render::render::{PathData, Primitive, Scene};

use crate::figure::page::Page;
use crate::figure::{Picture, Size, SizeError};

/// Draws `figure` as an SVG document. The same figure gives the same bytes.
///
/// # Errors
///
/// The figure does not fit into `size`.
pub fn svg(figure: &(impl Picture + ?Sized), size: Size) -> Result<String, SizeError> {
    let Page { mut scene, scale } = figure.page(size)?;
    number_clips(&mut scene);
    for element in &mut scene.elements {
        shorten(element);
    }
    let size = format!(r#"viewBox="0 0 {} {}" "#, scene.width, scene.height);
    let own = format!(r#"width="{}" height="{}""#, scene.width, scene.height);
    let scaled = format!(
        r#"width="{}" height="{}""#,
        hundredths(scale * scene.width),
        hundredths(scale * scene.height)
    );
    let mut document = SvgBackend::new().render_scene(&scene);
    // Without this attribute, a document that embeds the figure cannot scale it.
    if let Some(at) = document.find("width=") {
        document.insert_str(at, &size);
    }
    if scale != 1.0 {
        document = document.replacen(&own, &scaled, 1);
    }
    document.push('\n');
    Ok(document)
}

/// Numbers the clipping regions from 0; the library counts over the whole process.
fn number_clips(scene: &mut Scene) {
    let mut count = 0;
    for element in &mut scene.elements {
        if let Primitive::ClipStart { id, .. } = element {
            let old = std::mem::replace(id, format!("panel-{count}"));
            for definition in &mut scene.defs {
                *definition = definition.replace(&format!("\"{old}\""), &format!("\"{id}\""));
            }
            count += 1;
        }
    }
}

/// Rounds a polyline to a hundredth of a pixel, which halves the number of digits.
fn shorten(element: &mut Primitive) {
    if let Primitive::PolyLine {
        points,
        stroke,
        stroke_width,
        stroke_dasharray,
    } = element
    {
        *element = Primitive::Path(Box::new(PathData {
            d: path(points),
            fill: None,
            stroke: stroke.clone(),
            stroke_width: *stroke_width,
            opacity: None,
            stroke_dasharray: stroke_dasharray.take(),
        }));
    }
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn path(points: &[(f64, f64)]) -> String {
    let mut path = String::new();
    let mut before = None;
    for point in points {
        let (x, y) = (hundredths(point.0), hundredths(point.1));
        let written = match before {
            None => write!(path, "M{x} {y}"),
            Some(at) if at == (x, y) => Ok(()),
            Some((_, same)) if same == y => write!(path, "H{x}"),
            Some((same, _)) if same == x => write!(path, "V{y}"),
            Some(_) => write!(path, "L{x} {y}"),
        };
        debug_assert!(written.is_ok(), "a string takes every character");
        before = Some((x, y));
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_written_without_what_repeats() {
        let points = [
            (0.0, 1.0),
            (0.1 + 0.2, 1.0),
            (0.3, 2.5),
            (0.3001, 2.5),
            (4.0, -0.126),
        ];
        assert_eq!(path(&points), "M0 1H0.3V2.5L4 -0.13");
    }
}
