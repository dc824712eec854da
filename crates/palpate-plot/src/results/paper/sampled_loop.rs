//! Fig. 1b: the sampled loop as a block diagram.

use crate::figure::{Beside, Drawing, Pen, drawing};

/// Fills of the device and of the blocks of the renderer.
const FILLS: (&str, &str) = ("#d5e6f2", "#fbe3cf");
const BLOCK: (f64, f64) = (170.0, 46.0);

/// Draws the loop below the height `top` `[px]`: device, sampler, renderer, hold and negative feedback.
pub fn draw(page: &mut Drawing, top: f64) {
    let (forward, back) = (top + 50.0, top + 130.0);
    page.words(
        "(b) sampled loop",
        (430.0, top),
        Beside::Middle,
        drawing::HEAD,
    );
    // The device, pushed by the hand and by the negative held force.
    let sum = (170.0, forward);
    page.arrow((80.0, forward), (156.0, forward), Pen::FORCE);
    page.words(
        "f_u",
        (110.0, forward - 10.0),
        Beside::Middle,
        drawing::WORDS,
    );
    page.circle(sum, 14.0, Pen::BODY, "#ffffff");
    page.words("+", (146.0, forward - 10.0), Beside::Middle, drawing::SMALL);
    page.words("−", (182.0, forward + 30.0), Beside::Right, drawing::HEAD);
    let device = (430.0, forward);
    page.arrow((184.0, forward), (345.0, forward), Pen::FORCE);
    page.words(
        "f_u − f",
        (264.0, forward - 10.0),
        Beside::Middle,
        drawing::WORDS,
    );
    block(page, device, "device, 1/(m s²)", FILLS.0);
    // The sampler.
    page.line(
        &[
            (515.0, forward),
            (760.0, forward),
            (760.0, back),
            (700.0, back),
        ],
        Pen::MOTION,
    );
    page.words(
        "ξ(t)",
        (638.0, forward - 10.0),
        Beside::Middle,
        drawing::WORDS,
    );
    page.line(&[(700.0, back), (664.0, back - 18.0)], Pen::BODY);
    page.words("T", (684.0, back - 22.0), Beside::Middle, drawing::WORDS);
    page.words(
        "sampler",
        (682.0, back + 22.0),
        Beside::Middle,
        drawing::SMALL,
    );
    page.arrow((660.0, back), (595.0, back), Pen::MOTION);
    page.words("ξ_i", (628.0, back - 10.0), Beside::Middle, drawing::WORDS);
    // Renderer and hold.
    block(page, (510.0, back), "object and contact", FILLS.1);
    page.arrow((425.0, back), (375.0, back), Pen::FORCE);
    page.words("f_i", (400.0, back - 10.0), Beside::Middle, drawing::WORDS);
    block(page, (290.0, back), "zero-order hold", FILLS.1);
    page.line(&[(205.0, back), (170.0, back)], Pen::FORCE);
    page.arrow((170.0, back), (170.0, forward + 14.0), Pen::FORCE);
    page.words("f(t)", (160.0, back - 6.0), Beside::Left, drawing::WORDS);
}

fn block(page: &mut Drawing, middle: drawing::PagePoint, name: &str, fill: &str) {
    page.block(middle, BLOCK, fill);
    let (x, y) = middle;
    page.words(name, (x, y + 5.0), Beside::Middle, drawing::WORDS);
}
