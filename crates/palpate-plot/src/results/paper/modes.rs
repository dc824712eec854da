//! Fig. 1: device and object in their two modes, and the sampled loop.

use super::sampled_loop;
use crate::figure::{Beside, Drawing, Pen, drawing};

/// Layout and captions of one mode.
struct Mode {
    /// Centre of its column `[px]`.
    middle: f64,
    head: &'static str,
    condition: &'static str,
    equations: [&'static str; 3],
    /// Heights of the object's contact end, η, and of the device, ξ `[px]`.
    heights: (f64, f64),
}

/// Length of the unloaded contact spring `[px]`.
const FREE_LENGTH: f64 = 130.0;
const OBJECT: (f64, f64) = (110.0, 46.0);
const DEVICE: (f64, f64) = (150.0, 30.0);
const FILLS: (&str, &str) = ("#fbe3cf", "#d5e6f2");

/// Draws the two modes side by side, free motion and contact, and the sampled loop below them.
#[must_use]
pub fn drawing() -> Drawing {
    let mut page = Drawing::new(860.0, 760.0);
    let modes = [
        Mode {
            middle: 225.0,
            head: "(a) free motion",
            condition: "p = ξ − η ≤ 0",
            equations: ["f = 0", "object: M η″ = f_V", "device: m ξ″ = f_u"],
            heights: (320.0, 375.0),
        },
        Mode {
            middle: 635.0,
            head: "contact",
            condition: "p = ξ − η > 0",
            equations: [
                "f = K (ξ − η)",
                "object: M η″ = f_V + f",
                "device: m ξ″ = f_u − f",
            ],
            heights: (385.0, 330.0),
        },
    ];
    for mode in &modes {
        draw(&mut page, mode);
    }
    // Transitions between the modes.
    page.arrow((395.0, 245.0), (465.0, 245.0), Pen::THIN);
    page.words("device and", (430.0, 216.0), Beside::Middle, drawing::SMALL);
    page.words(
        "object meet",
        (430.0, 232.0),
        Beside::Middle,
        drawing::SMALL,
    );
    page.arrow((465.0, 275.0), (395.0, 275.0), Pen::THIN);
    page.words("they part", (430.0, 296.0), Beside::Middle, drawing::SMALL);
    sampled_loop::draw(&mut page, 590.0);
    page
}

fn draw(page: &mut Drawing, mode: &Mode) {
    let x = mode.middle;
    let (eta, xi) = mode.heights;
    let pressed = (eta - xi).max(0.0);
    page.words(mode.head, (x, 30.0), Beside::Middle, drawing::HEAD);
    page.words(mode.condition, (x, 54.0), Beside::Middle, drawing::WORDS);
    // The spring hangs below the object; its unloaded end is the object's position η.
    let object = eta - FREE_LENGTH - 0.5 * OBJECT.1;
    draw_bodies(page, mode, object, eta - pressed);
    draw_positions(page, mode, pressed);
    draw_forces(page, mode, object, pressed);
    write_equations(page, mode);
}

/// Draws the object, whose middle has the height `object` `[px]`, its spring down to the height `end` `[px]`, and the
/// device.
fn draw_bodies(page: &mut Drawing, mode: &Mode, object: f64, end: f64) {
    let x = mode.middle;
    let (_, xi) = mode.heights;
    page.spring((x, object + 0.5 * OBJECT.1), (x, end), 5, 30.0, Pen::BODY);
    page.line(&[(x - 26.0, end), (x + 26.0, end)], Pen::BODY);
    page.words(
        "K",
        (x - 24.0, 0.5 * (object + 23.0 + end) + 5.0),
        Beside::Left,
        drawing::WORDS,
    );
    page.block((x, object), OBJECT, FILLS.0);
    page.words(
        "object, M",
        (x, object + 5.0),
        Beside::Middle,
        drawing::WORDS,
    );
    page.block((x, xi + 0.5 * DEVICE.1), DEVICE, FILLS.1);
    page.words("device, m", (x, xi + 20.0), Beside::Middle, drawing::WORDS);
}

/// Draws the positions on a separate axis, and the compression `pressed` of the spring `[px]` if there is one.
fn draw_positions(page: &mut Drawing, mode: &Mode, pressed: f64) {
    let x = mode.middle;
    let (eta, xi) = mode.heights;
    let axis = x + 105.0;
    page.arrow((axis, 450.0), (axis, 92.0), Pen::THIN);
    page.words(
        "position",
        (axis + 7.0, 100.0),
        Beside::Right,
        drawing::SMALL,
    );
    for (height, name, reach) in [(eta, "η", 28.0), (xi, "ξ", 76.0)] {
        page.line(&[(x + reach, height), (axis + 6.0, height)], Pen::THOUGHT);
        let place = (axis + 12.0, height + 5.0);
        page.coloured(
            name,
            place,
            Beside::Right,
            drawing::WORDS,
            Some(Pen::MOTION.colour),
        );
    }
    if pressed > 0.0 {
        page.length((axis + 42.0, eta), (axis + 42.0, xi), Pen::MOTION);
        let place = (axis + 48.0, 0.5 * (eta + xi) + 5.0);
        page.coloured(
            "p",
            place,
            Beside::Right,
            drawing::WORDS,
            Some(Pen::MOTION.colour),
        );
    }
}

/// Draws the forces, each with its name beside the tail; `object` is the height of the object's middle and `pressed`
/// the compression of the spring `[px]`.
fn draw_forces(page: &mut Drawing, mode: &Mode, object: f64, pressed: f64) {
    let x = mode.middle;
    let (_, xi) = mode.heights;
    let force = |page: &mut Drawing, from: (f64, f64), to: (f64, f64), name: &str| {
        page.arrow(from, to, Pen::FORCE);
        let place = (from.0 - 9.0, 0.5 * (from.1 + to.1) + 5.0);
        let colour = Some(Pen::FORCE.colour);
        page.coloured(name, place, Beside::Left, drawing::WORDS, colour);
    };
    let (top, below) = (object - 0.5 * OBJECT.1, xi + DEVICE.1);
    force(page, (x, top - 50.0), (x, top - 2.0), "f_V");
    force(page, (x, below + 50.0), (x, below + 2.0), "f_u, the hand");
    if pressed > 0.0 {
        let beside = x - 0.5 * OBJECT.0 - 16.0;
        force(page, (beside, object + 23.0), (beside, object - 23.0), "f");
        let beside = x - 0.5 * DEVICE.0 - 16.0;
        let middle = xi + 0.5 * DEVICE.1;
        force(page, (beside, middle - 23.0), (beside, middle + 23.0), "−f");
    }
}

/// Writes the equations of a mode, one on each line.
fn write_equations(page: &mut Drawing, mode: &Mode) {
    let x = mode.middle;
    for (line, equation) in mode.equations.iter().enumerate() {
        let baseline = 492.0 + 22.0 * line as f64;
        page.words(
            equation,
            (x - 90.0, baseline),
            Beside::Right,
            drawing::WORDS,
        );
    }
}
