//! A figure as PDF: its lines and words, not an image of them.

mod font;
mod path;

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish, Pdf, Rect, Ref, Str};

use crate::figure::{Picture, Size, SizeError};
use font::{Font, Glyph, glyph};

/// Points of PDF per pixel.
const POINTS: f64 = 0.75;

/// Draws `figure` as a PDF document of one page, as large as the figure. Words are set in Helvetica, Symbol and Zapf
/// Dingbats, which every reader has: nothing is embedded, and words can be searched. A character that these fonts do
/// not contain becomes a question mark.
///
/// # Errors
///
/// The figure does not fit into `size`.
pub fn pdf(figure: &(impl Picture + ?Sized), size: Size) -> Result<Vec<u8>, SizeError> {
    let page = figure.page(size)?;
    let scale = POINTS * page.scale;
    let content = content(&page.scene, scale);
    let [catalog, tree, leaf, stream] = [1, 2, 3, 4].map(Ref::new);
    let font = |number: usize| Ref::new(5 + i32::try_from(number).unwrap_or(0));
    let mut document = Pdf::new();
    document.catalog(catalog).pages(tree);
    document.pages(tree).kids([leaf]).count(1);
    let mut sheet = document.page(leaf);
    let (width, height) = (scale * page.scene.width, scale * page.scene.height);
    sheet.media_box(Rect::new(0.0, 0.0, single(width), single(height)));
    sheet.parent(tree).contents(stream);
    let mut resources = sheet.resources();
    let mut fonts = resources.fonts();
    for (number, one) in Font::ALL.into_iter().enumerate() {
        fonts.pair(one.short(), font(number));
    }
    fonts.finish();
    resources.finish();
    sheet.finish();
    for (number, one) in Font::ALL.into_iter().enumerate() {
        let mut described = document.type1_font(font(number));
        described.base_font(one.base());
        if one.is_latin() {
            described.encoding_predefined(pdf_writer::Name(b"WinAnsiEncoding"));
        }
    }
    document.stream(stream, &content);
    Ok(document.finish())
}

/// Returns the operators that draw a scene. In a scene y points down, on a PDF page up.
fn content(scene: &Scene, scale: f64) -> Vec<u8> {
    let mut content = Content::new();
    content.save_state();
    let top = single(scale * scene.height);
    content.transform([single(scale), 0.0, 0.0, -single(scale), 0.0, top]);
    content.set_line_join(LineJoinStyle::RoundJoin);
    for element in &scene.elements {
        draw(&mut content, element, scene.text_color.as_deref());
    }
    content.restore_state();
    content.finish().to_vec()
}

fn draw(content: &mut Content, element: &Primitive, words: Option<&str>) {
    match element {
        Primitive::Text { .. } | Primitive::RichText { .. } => draw_words(content, element, words),
        Primitive::Line { .. } | Primitive::PolyLine { .. } => draw_line(content, element),
        Primitive::Path(path) => draw_path(content, path),
        Primitive::Rect { .. } | Primitive::RectBatch { .. } => draw_rectangles(content, element),
        Primitive::Circle { .. } | Primitive::CircleBatch { .. } => draw_circles(content, element),
        Primitive::GroupStart { transform, .. } => {
            content.save_state();
            if let Some((x, y)) = transform.as_deref().and_then(translation) {
                content.transform([1.0, 0.0, 0.0, 1.0, x, y]);
            }
        }
        Primitive::ClipStart {
            x,
            y,
            width,
            height,
            ..
        } => {
            content.save_state();
            content.rect(single(*x), single(*y), single(*width), single(*height));
            content.clip_nonzero().end_path();
        }
        Primitive::GroupEnd | Primitive::ClipEnd => {
            content.restore_state();
        }
    }
}

/// Draws plain or rich text, in the colour `words` if it has none of its own; nothing for another element.
fn draw_words(content: &mut Content, element: &Primitive, words: Option<&str>) {
    match element {
        Primitive::Text {
            x,
            y,
            content: text,
            size,
            anchor,
            rotate,
            bold,
            color,
        } => {
            let colour = color.clone().or_else(|| words.map(Color::from));
            fill_with(content, &colour.unwrap_or(Color::Rgb(0, 0, 0)));
            let place = (*x, *y, rotate.unwrap_or(0.0));
            write(content, text, place, (f64::from(*size), *anchor, *bold));
        }
        Primitive::RichText {
            x,
            y,
            spans,
            size,
            anchor,
            color,
        } => {
            let text: String = spans.iter().map(|span| &*span.text).collect();
            let colour = color.clone().or_else(|| words.map(Color::from));
            fill_with(content, &colour.unwrap_or(Color::Rgb(0, 0, 0)));
            write(
                content,
                &text,
                (*x, *y, 0.0),
                (f64::from(*size), *anchor, false),
            );
        }
        _ => {}
    }
}

/// Draws a line of two or of many points; nothing for another element.
fn draw_line(content: &mut Content, element: &Primitive) {
    match element {
        Primitive::Line {
            x1,
            y1,
            x2,
            y2,
            stroke,
            stroke_width,
            stroke_dasharray,
        } => {
            let points = [(*x1, *y1), (*x2, *y2)];
            line(
                content,
                &points,
                (stroke, *stroke_width, stroke_dasharray.as_deref()),
            );
        }
        Primitive::PolyLine {
            points,
            stroke,
            stroke_width,
            stroke_dasharray,
        } => line(
            content,
            points,
            (stroke, *stroke_width, stroke_dasharray.as_deref()),
        ),
        _ => {}
    }
}

/// Draws a path, filled and stroked as it states.
fn draw_path(content: &mut Content, path: &PathData) {
    let stroked = stroke_with(
        content,
        &path.stroke,
        path.stroke_width,
        path.stroke_dasharray.as_deref(),
    );
    let filled = path
        .fill
        .as_ref()
        .is_some_and(|fill| fill_with(content, fill));
    path::add(content, &path.d);
    paint(content, filled, stroked);
}

/// Draws one rectangle or a batch of them; nothing for another element.
fn draw_rectangles(content: &mut Content, element: &Primitive) {
    match element {
        Primitive::Rect {
            x,
            y,
            width,
            height,
            fill,
            stroke,
            stroke_width,
            ..
        } => {
            let filled = fill_with(content, fill);
            let stroked = stroke.as_ref().is_some_and(|stroke| {
                stroke_with(content, stroke, stroke_width.unwrap_or(1.0), None)
            });
            content.rect(single(*x), single(*y), single(*width), single(*height));
            paint(content, filled, stroked);
        }
        Primitive::RectBatch { x, y, w, h, fills } => {
            for ((((x, y), w), h), fill) in x.iter().zip(y).zip(w).zip(h).zip(fills) {
                if fill_with(content, fill) {
                    content.rect(single(*x), single(*y), single(*w), single(*h));
                    content.fill_nonzero();
                }
            }
        }
        _ => {}
    }
}

/// Draws one circle or a batch of them; nothing for another element.
fn draw_circles(content: &mut Content, element: &Primitive) {
    match element {
        Primitive::Circle {
            cx,
            cy,
            r,
            fill,
            fill_opacity,
            stroke,
            stroke_width,
        } => {
            let fill = inside(fill, *fill_opacity);
            circle(
                content,
                (*cx, *cy, *r),
                fill,
                (stroke.as_ref(), *stroke_width),
            );
        }
        Primitive::CircleBatch {
            cx,
            cy,
            r,
            fill,
            fill_opacity,
            stroke,
            stroke_width,
        } => {
            let fill = inside(fill, *fill_opacity);
            for (x, y) in cx.iter().zip(cy) {
                circle(
                    content,
                    (*x, *y, *r),
                    fill,
                    (stroke.as_ref(), *stroke_width),
                );
            }
        }
        _ => {}
    }
}

/// Parses `translate(x,y)`.
fn translation(transform: &str) -> Option<(f32, f32)> {
    let inside = transform.strip_prefix("translate(")?.strip_suffix(')')?;
    let (x, y) = inside.split_once([',', ' '])?;
    Some((x.trim().parse().ok()?, y.trim().parse().ok()?))
}

fn line(
    content: &mut Content,
    points: &[(f64, f64)],
    (stroke, width, dashes): (&Color, f64, Option<&str>),
) {
    if !stroke_with(content, stroke, width, dashes) {
        return;
    }
    for (number, &(x, y)) in points.iter().enumerate() {
        if number == 0 {
            content.move_to(single(x), single(y));
        } else {
            content.line_to(single(x), single(y));
        }
    }
    content.stroke();
}

/// Returns the fill colour of a shape. Figures contain only opaque and empty shapes.
fn inside(fill: &Color, opacity: Option<f64>) -> &Color {
    if opacity == Some(0.0) {
        &Color::None
    } else {
        fill
    }
}

/// Draws a circle as four cubic curves, with an error below a thousandth of its radius.
fn circle(
    content: &mut Content,
    (x, y, r): (f64, f64, f64),
    fill: &Color,
    (stroke, width): (Option<&Color>, Option<f64>),
) {
    const HANDLE: f64 = 0.552_284_75;
    let filled = fill_with(content, fill);
    let stroked =
        stroke.is_some_and(|stroke| stroke_with(content, stroke, width.unwrap_or(1.0), None));
    let at = |u: f64, v: f64| (single(x + r * u), single(y + r * v));
    let (first_x, first_y) = at(1.0, 0.0);
    content.move_to(first_x, first_y);
    for (u, v) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
        // A quarter turn starting at (u, v).
        let (next_u, next_v) = (-v, u);
        let (a, b) = at(u + HANDLE * next_u, v + HANDLE * next_v);
        let (c, d) = at(next_u + HANDLE * u, next_v + HANDLE * v);
        let (e, f) = at(next_u, next_v);
        content.cubic_to(a, b, c, d, e, f);
    }
    content.close_path();
    paint(content, filled, stroked);
}

fn paint(content: &mut Content, filled: bool, stroked: bool) {
    match (filled, stroked) {
        (true, true) => content.fill_nonzero_and_stroke(),
        (true, false) => content.fill_nonzero(),
        (false, true) => content.stroke(),
        (false, false) => content.end_path(),
    };
}

/// Sets the fill colour. Returns whether there is one.
fn fill_with(content: &mut Content, colour: &Color) -> bool {
    let Some([r, g, b]) = parts(colour) else {
        return false;
    };
    content.set_fill_rgb(r, g, b);
    true
}

/// Sets colour, width and dashes of lines. Returns whether they are visible.
fn stroke_with(content: &mut Content, colour: &Color, width: f64, dashes: Option<&str>) -> bool {
    let Some([r, g, b]) = parts(colour).filter(|_| width > 0.0) else {
        return false;
    };
    content.set_stroke_rgb(r, g, b);
    content.set_line_width(single(width));
    content.set_line_cap(LineCapStyle::ButtCap);
    let lengths = dashes.unwrap_or_default();
    let lengths = lengths
        .split([' ', ','])
        .filter_map(|length| length.parse().ok());
    content.set_dash_pattern(lengths, 0.0);
    true
}

/// Returns red, green and blue from 0 to 1.
fn parts(colour: &Color) -> Option<[f32; 3]> {
    match colour {
        Color::Rgb(r, g, b) => Some([r, g, b].map(|part| f32::from(*part) / 255.0)),
        Color::None => None,
        Color::Css(_) => Some([0.0; 3]),
    }
}

/// Writes words at a position, rotated clockwise by an angle `[deg]`.
fn write(
    content: &mut Content,
    words: &str,
    (x, y, turned): (f64, f64, f64),
    (size, anchor, bold): (f64, TextAnchor, bool),
) {
    let glyphs: Vec<Glyph> = words
        .chars()
        .map(|character| glyph(character, bold))
        .collect();
    let width: f64 = glyphs.iter().map(|glyph| f64::from(glyph.width)).sum();
    let before = match anchor {
        TextAnchor::Start => 0.0,
        TextAnchor::Middle => -0.5,
        TextAnchor::End => -1.0,
    } * (width * size / 1000.0);
    let (sin, cos) = turned.to_radians().sin_cos();
    let (x, y) = (x + before * cos, y + before * sin);
    content.begin_text();
    // The page is flipped vertically; the text matrix flips the letters back.
    let turn = [cos, sin, sin, -cos, x, y].map(single);
    content.set_text_matrix(turn);
    for run in glyphs.chunk_by(|a, b| a.font == b.font) {
        let codes: Vec<u8> = run.iter().map(|glyph| glyph.code).collect();
        content.set_font(run[0].font.short(), single(size));
        content.show(Str(&codes));
    }
    content.end_text();
}

/// Rounds a page coordinate to a hundredth.
#[expect(
    clippy::cast_possible_truncation,
    reason = "places on a page, to a hundredth of a pixel"
)]
fn single(value: f64) -> f32 {
    ((value * 1e4).round() / 1e4) as f32
}
