//! Schematic drawings: lines, arrows, springs and words at positions on a page.
//!
//! Positions are in `[px]` from the upper left corner, y down. Words may have subscripts, `f_V`: the characters after
//! an underscore, up to the next character that is neither letter nor digit, are lowered.

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use crate::figure::drawn::Drawn;
use crate::figure::page::Page;
use crate::figure::{Picture, Size, SizeError, ink, text};

/// A position on the page `[px]`.
pub type PagePoint = (f64, f64);

/// Colour, width and dashes of a line.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    /// Colour as `#rrggbb`.
    pub colour: &'static str,
    /// Width of the line `[px]`.
    pub width: f64,
    /// Lengths of dashes and gaps `[px]`; empty for a line without gaps.
    pub dashes: &'static [f64],
}

impl Pen {
    /// Outlines of bodies.
    pub const BODY: Self = Self::new("#111111", 1.8);
    /// Dimension lines and axes.
    pub const THIN: Self = Self::new("#555555", 1.0);
    /// Auxiliary lines.
    pub const THOUGHT: Self = Self {
        dashes: &[5.0, 3.5],
        ..Self::THIN
    };
    /// Forces.
    pub const FORCE: Self = Self::new("#d55e00", 2.4);
    /// Motions and their dimensions.
    pub const MOTION: Self = Self::new("#0072b2", 1.4);

    const fn new(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dashes: &[],
        }
    }
}

/// Alignment of words relative to their position.
#[derive(Debug, Clone, Copy)]
pub enum Beside {
    /// The words begin at the position.
    Right,
    /// The words end at the position.
    Left,
    /// The words are centred on the position.
    Middle,
}

/// Size of words `[px]`.
pub const WORDS: u32 = 14;
/// Size of a heading `[px]`.
pub const HEAD: u32 = 16;
/// Size of small print `[px]`.
pub const SMALL: u32 = 12;

/// A page with drawn elements.
#[derive(Debug, Clone)]
pub struct Drawing {
    size: (f64, f64),
    elements: Vec<Primitive>,
}

impl Drawing {
    /// Creates an empty page of a width and a height `[px]`.
    #[must_use]
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            size: (width, height),
            elements: Vec::new(),
        }
    }

    /// Draws a polyline through the positions.
    pub fn line(&mut self, places: &[PagePoint], pen: Pen) {
        self.elements.push(Primitive::PolyLine {
            points: places.to_vec(),
            stroke: Color::from(pen.colour),
            stroke_width: pen.width,
            stroke_dasharray: ink::dash_array(pen.dashes),
        });
    }

    /// Draws a closed, filled shape through the positions.
    pub fn shape(&mut self, places: &[PagePoint], pen: Pen, fill: &str) {
        let mut path = String::new();
        for (number, (x, y)) in places.iter().enumerate() {
            let begin = if number == 0 { 'M' } else { 'L' };
            path += &format!("{begin}{x:.2} {y:.2}");
        }
        path.push('Z');
        self.elements.push(Primitive::Path(Box::new(PathData {
            d: path,
            fill: Some(Color::from(fill)),
            stroke: Color::from(pen.colour),
            stroke_width: pen.width,
            opacity: None,
            stroke_dasharray: ink::dash_array(pen.dashes),
        })));
    }

    /// Draws a filled rectangle around its centre.
    pub fn block(&mut self, (x, y): PagePoint, (width, height): (f64, f64), fill: &str) {
        let (w, h) = (0.5 * width, 0.5 * height);
        let corners = [
            (x - w, y - h),
            (x + w, y - h),
            (x + w, y + h),
            (x - w, y + h),
        ];
        self.shape(&corners, Pen::BODY, fill);
    }

    /// Draws a filled circle.
    pub fn circle(&mut self, (cx, cy): PagePoint, r: f64, pen: Pen, fill: &str) {
        self.elements.push(Primitive::Circle {
            cx,
            cy,
            r,
            fill: Color::from(fill),
            fill_opacity: None,
            stroke: Some(Color::from(pen.colour)),
            stroke_width: Some(pen.width),
        });
    }

    /// Draws an arrow with its head at `to`.
    pub fn arrow(&mut self, from: PagePoint, to: PagePoint, pen: Pen) {
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        if length <= 0.0 {
            return;
        }
        let along = ((to.0 - from.0) / length, (to.1 - from.1) / length);
        let head = (6.0 + 2.0 * pen.width).min(length);
        let neck = (to.0 - head * along.0, to.1 - head * along.1);
        let half = 0.36 * head;
        self.line(&[from, neck], pen);
        let sides = [
            (neck.0 - half * along.1, neck.1 + half * along.0),
            to,
            (neck.0 + half * along.1, neck.1 - half * along.0),
        ];
        let outline = Pen {
            width: 0.5,
            dashes: &[],
            ..pen
        };
        self.shape(&sides, outline, pen.colour);
    }

    /// Draws a dimension line: a line with a head at each end.
    pub fn length(&mut self, from: PagePoint, to: PagePoint, pen: Pen) {
        let middle = (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1));
        self.arrow(middle, from, pen);
        self.arrow(middle, to, pen);
    }

    /// Draws an arc about `middle`, from one angle to another `[rad]`, counter-clockwise as seen, with a head at its
    /// end.
    pub fn turn(&mut self, middle: PagePoint, radius: f64, (from, to): (f64, f64), pen: Pen) {
        const STEPS: u32 = 40;
        const HEAD_LENGTH: f64 = 10.0;
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            (middle.0 + radius * cos, middle.1 - radius * sin)
        };
        // The head lies on a chord at the end.
        let back = to - (to - from).signum() * (HEAD_LENGTH / radius).min((to - from).abs());
        let angle = |step: u32| from + (back - from) * (f64::from(step) / f64::from(STEPS));
        let arc: Vec<PagePoint> = (0..=STEPS).map(|step| at(angle(step))).collect();
        self.line(&arc, pen);
        self.arrow(at(back), at(to), pen);
    }

    /// Draws a spring between two positions with `turns` turns, `width` across `[px]`.
    pub fn spring(&mut self, from: PagePoint, to: PagePoint, turns: u32, width: f64, pen: Pen) {
        let length = (to.0 - from.0).hypot(to.1 - from.1).max(f64::MIN_POSITIVE);
        let along = ((to.0 - from.0) / length, (to.1 - from.1) / length);
        let across = (-along.1, along.0);
        let at = |share: f64, side: f64| {
            let (s, w) = (share * length, 0.5 * width * side);
            (
                from.0 + s * along.0 + w * across.0,
                from.1 + s * along.1 + w * across.1,
            )
        };
        // Straight segments at both ends.
        const END: f64 = 0.12;
        let corners = 2 * turns;
        let mut places = vec![from, at(END, 0.0)];
        for corner in 0..corners {
            let share = (f64::from(corner) + 0.5) / f64::from(corners);
            let side = if corner % 2 == 0 { 1.0 } else { -1.0 };
            places.push(at(END + (1.0 - 2.0 * END) * share, side));
        }
        places.extend([at(1.0 - END, 0.0), to]);
        self.line(&places, pen);
    }

    /// Draws hatched solid ground below a horizontal line.
    pub fn ground(&mut self, left: PagePoint, width: f64) {
        const STROKE: f64 = 9.0;
        self.line(&[left, (left.0 + width, left.1)], Pen::BODY);
        let mut x = left.0 + STROKE;
        while x <= left.0 + width {
            self.line(&[(x, left.1), (x - STROKE, left.1 + STROKE)], Pen::THIN);
            x += STROKE;
        }
    }

    /// Draws words of a size at a position, on their baseline.
    pub fn words(&mut self, words: &str, place: PagePoint, beside: Beside, size: u32) {
        self.coloured(words, place, beside, size, None);
    }

    /// Draws words in a colour.
    pub fn coloured(
        &mut self,
        words: &str,
        (x, y): PagePoint,
        beside: Beside,
        size: u32,
        colour: Option<&'static str>,
    ) {
        let runs = pieces(words);
        let mut write = |(words, lowered): &(String, bool), x: f64, anchor: TextAnchor| {
            let words = words.trim_end();
            if words.is_empty() {
                return;
            }
            let below = if *lowered {
                0.28 * f64::from(size)
            } else {
                0.0
            };
            self.elements.push(Primitive::Text {
                x,
                y: y + below,
                content: words.to_owned(),
                size: size_of(*lowered, size),
                anchor,
                rotate: None,
                bold: size == HEAD,
                color: colour.map(Color::from),
            });
        };
        if let [words] = &runs[..] {
            // A single piece is anchored by the viewer, which knows the width of its font.
            let anchor = match beside {
                Beside::Right => TextAnchor::Start,
                Beside::Left => TextAnchor::End,
                Beside::Middle => TextAnchor::Middle,
            };
            return write(words, x, anchor);
        }
        let width = |(words, lowered): &(String, bool)| width_of(words, size_of(*lowered, size));
        let whole: f64 = runs.iter().map(width).sum();
        let mut left = match beside {
            Beside::Right => x,
            Beside::Left => x - whole,
            Beside::Middle => x - 0.5 * whole,
        };
        for run in &runs {
            write(run, left, TextAnchor::Start);
            left += width(run);
        }
    }
}

impl Picture for Drawing {}

impl Drawn for Drawing {
    fn page(&self, size: Size) -> Result<Page, SizeError> {
        let mut page = Scene::new(self.size.0, self.size.1);
        page.font_family = Some(text::FAMILY.to_owned());
        page.text_color = Some("#111111".to_owned());
        for element in &self.elements {
            page.add(element.clone());
        }
        // A drawing keeps its proportions: it is scaled to the largest size that fits.
        let fits = |asked: Option<f64>, own: f64| asked.map_or(f64::INFINITY, |asked| asked / own);
        let scale = fits(size.width, self.size.0).min(fits(size.height, self.size.1));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Ok(Page { scene: page, scale })
    }
}

/// Width of a run of any length `[px]`. The padding removes a bias: the library counts a short run alone as broad as
/// a tick label.
fn width_of(run: &str, size: u32) -> f64 {
    const BROAD: &str = "MMMM";
    let together = format!("{BROAD}{run}{BROAD}");
    text::width(&together, size) - text::width(&[BROAD, BROAD].concat(), size)
}

fn size_of(subscript: bool, size: u32) -> u32 {
    if subscript { size * 7 / 10 } else { size }
}

/// Splits words into separately placed pieces, and marks subscripts. Words without a subscript are one piece. Other
/// words are split at each blank, so that a font narrower than estimated leaves its gap there and not before the
/// subscript.
fn pieces(words: &str) -> Vec<(String, bool)> {
    let runs = runs(words);
    if runs.len() == 1 {
        return runs;
    }
    let parts = |(run, subscript): &(String, bool)| -> Vec<(String, bool)> {
        run.split_inclusive(' ')
            .map(|part| (part.to_owned(), *subscript))
            .collect()
    };
    runs.iter().flat_map(parts).collect()
}

/// Splits words into runs, and marks subscripts.
fn runs(words: &str) -> Vec<(String, bool)> {
    let mut runs = vec![(String::new(), false)];
    for c in words.chars() {
        let (run, subscript) = runs.last_mut().expect("one at least");
        if c == '_' {
            runs.push((String::new(), true));
        } else if *subscript && !c.is_alphanumeric() {
            runs.push((c.to_string(), false));
        } else {
            run.push(c);
        }
    }
    runs.retain(|(run, _)| !run.is_empty());
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_subscript_ends_at_the_next_sign() {
        let split = |words| -> Vec<(String, bool)> { runs(words) };
        let run = |text: &str, low| (text.to_owned(), low);
        assert_eq!(
            split("f_V = 0"),
            [run("f", false), run("V", true), run(" = 0", false)]
        );
        assert_eq!(split("x"), [run("x", false)]);
        assert_eq!(
            split("m ξ″ = f_u − f"),
            [run("m ξ″ = f", false), run("u", true), run(" − f", false)]
        );
    }

    /// PDF readers use Helvetica, which is narrower than the font of the width estimate.
    #[test]
    fn a_subscript_stands_beside_its_letter_in_a_narrow_font() {
        let mut drawing = Drawing::new(300.0, 50.0);
        drawing.words("object: M η″ = f_V + f", (10.0, 20.0), Beside::Right, 14);
        let texts: Vec<(f64, &str)> = drawing
            .elements
            .iter()
            .filter_map(|element| match element {
                Primitive::Text { x, content, .. } => Some((*x, content.as_str())),
                _ => None,
            })
            .collect();
        let at = texts.iter().position(|(_, text)| *text == "V").unwrap();
        let ((letter, base), (low, _)) = (texts[at - 1], texts[at]);
        assert_eq!(base, "f");
        // The advance of f in Helvetica, from its font metrics file.
        let gap = low - letter - 0.278 * 14.0;
        assert!((0.0..2.0).contains(&gap), "{gap} px");
        let all: Vec<&str> = texts.iter().map(|(_, text)| *text).collect();
        assert_eq!(all, ["object:", "M", "η″", "=", "f", "V", "+", "f"]);
        // The viewer centres words without a subscript.
        drawing.words("object, M", (50.0, 40.0), Beside::Middle, 14);
        assert!(matches!(
            drawing.elements.last(),
            Some(Primitive::Text { x, anchor: TextAnchor::Middle, .. }) if *x == 50.0
        ));
    }

    #[test]
    fn an_arrow_ends_where_it_points() {
        let mut drawing = Drawing::new(100.0, 100.0);
        drawing.arrow((10.0, 90.0), (10.0, 20.0), Pen::FORCE);
        let Some(Primitive::Path(head)) = drawing.elements.last() else {
            panic!("an arrow has a head");
        };
        assert!(head.d.contains("10.00 20.00"), "{}", head.d);
        // An arrow without a length draws nothing.
        let before = drawing.elements.len();
        drawing.arrow((1.0, 1.0), (1.0, 1.0), Pen::FORCE);
        assert_eq!(drawing.elements.len(), before);
    }

    #[test]
    fn a_spring_reaches_from_end_to_end_and_turns_between() {
        let mut drawing = Drawing::new(100.0, 100.0);
        drawing.spring((50.0, 10.0), (50.0, 90.0), 4, 20.0, Pen::BODY);
        let Some(Primitive::PolyLine { points, .. }) = drawing.elements.last() else {
            panic!("a spring is a line");
        };
        assert_eq!(
            (points[0], points[points.len() - 1]),
            ((50.0, 10.0), (50.0, 90.0))
        );
        let widest = points
            .iter()
            .map(|(x, _)| (x - 50.0).abs())
            .fold(0.0, f64::max);
        assert!((widest - 10.0).abs() < 1e-9);
        assert!(points.iter().all(|&(_, y)| (10.0..=90.0).contains(&y)));
    }
}
