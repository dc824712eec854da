//! Fig. 3: the pantograph, its frame and its joints, and the ball above it.

use palpate_scene::Linkage;
use palpate_testbed::pantograph::ArmPose;
use palpate_testbed::pantograph::kinematics::NoPose;

use crate::figure::{Beside, Drawing, Pen, drawing};

/// Pixels per metre.
const SCALE: f64 = 480.0;
/// Position of the frame's origin on the page `[px]`.
const ORIGIN: (f64, f64) = (400.0, 545.0);
/// Radius of the ball in the drawing `[m]`: the paper's 0.01 m would appear as a dot.
const BALL: f64 = 0.055;
/// Gap between ball and end-point in the drawing `[m]`.
const GAP: f64 = 0.06;
const LINK: &str = "#d5e6f2";

/// Joints of the mechanism in a pose, in the frame `[m]`.
struct Joints {
    /// Shafts of the motors, one for each arm.
    motors: [(f64, f64); 2],
    /// Joints between proximal and distal links, one for each arm.
    elbows: [(f64, f64); 2],
    /// The end-point.
    tip: (f64, f64),
}

/// Draws the mechanism in its home pose, to scale.
///
/// # Errors
/// The home pose does not exist.
pub fn drawing(linkage: &Linkage) -> Result<Drawing, NoPose> {
    let geometry = linkage.params.geometry;
    let pose = geometry.forward(linkage.params.home)?;
    let half = 0.5 * geometry.base;
    let motors = [(-half, 0.0), (half, 0.0)];
    let elbow = |arm: usize| {
        let [dx, dy] = pose.proximal[arm];
        let (l, motor) = (geometry.proximal, motors[arm]);
        (motor.0 + l * dx, motor.1 + l * dy)
    };
    let elbows = [elbow(0), elbow(1)];
    let [px, py] = end_point(&pose, elbows[0], geometry.distal);
    let places = Joints {
        motors,
        elbows,
        tip: (px, py),
    };
    let tip = at(px, py);

    let mut page = Drawing::new(800.0, 620.0);
    draw_frame(&mut page);
    draw_links(&mut page, &places);
    joints(&mut page, motors.map(on_page), elbows.map(on_page), tip);
    for arm in 0..2 {
        name_arm(&mut page, &places, arm, linkage.params.home[arm]);
    }
    draw_base(&mut page, half);
    contact(&mut page, tip);
    Ok(page)
}

/// Returns the position on the page `[px]` of a place in the frame `[m]`.
fn at(x: f64, y: f64) -> (f64, f64) {
    (ORIGIN.0 + SCALE * x, ORIGIN.1 - SCALE * y)
}

/// Returns the position on the page `[px]` of a place in the frame `[m]`.
fn on_page(place: (f64, f64)) -> (f64, f64) {
    at(place.0, place.1)
}

/// Draws the ground and the axes of the frame.
fn draw_frame(page: &mut Drawing) {
    page.ground((ORIGIN.0 - 110.0, ORIGIN.1 + 22.0), 220.0);
    page.arrow(ORIGIN, (ORIGIN.0 + 190.0, ORIGIN.1), Pen::THIN);
    page.words(
        "x",
        (ORIGIN.0 + 196.0, ORIGIN.1 + 5.0),
        Beside::Right,
        drawing::WORDS,
    );
    page.arrow(ORIGIN, (ORIGIN.0, ORIGIN.1 - 130.0), Pen::THIN);
    page.words(
        "y",
        (ORIGIN.0 + 8.0, ORIGIN.1 - 120.0),
        Beside::Right,
        drawing::WORDS,
    );
    page.words(
        "O",
        (ORIGIN.0 + 4.0, ORIGIN.1 + 16.0),
        Beside::Right,
        drawing::SMALL,
    );
}

/// Draws the links of both arms.
fn draw_links(page: &mut Drawing, places: &Joints) {
    let tip = on_page(places.tip);
    // A thin line on a thick line gives each link an outline.
    for arm in 0..2 {
        let elbow = on_page(places.elbows[arm]);
        let links = [[on_page(places.motors[arm]), elbow], [elbow, tip]];
        let outline = Pen {
            width: 13.0,
            ..Pen::BODY
        };
        let body = Pen {
            colour: LINK,
            width: 10.0,
            ..Pen::BODY
        };
        for pen in [outline, body] {
            links.iter().for_each(|link| page.line(link, pen));
        }
    }
}

/// Writes the names of the links, the elbow and the motor of an arm, and draws its motor angle `[rad]`.
fn name_arm(page: &mut Drawing, places: &Joints, arm: usize, angle: f64) {
    let between = |a: (f64, f64), b: (f64, f64)| on_page((0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1)));
    let side = if arm == 0 { -1.0 } else { 1.0 };
    let beside = if arm == 0 {
        Beside::Left
    } else {
        Beside::Right
    };
    let low = between(places.motors[arm], places.elbows[arm]);
    page.words(
        "l",
        (low.0 + side * 12.0, low.1 + 18.0),
        beside,
        drawing::WORDS,
    );
    let high = between(places.elbows[arm], places.tip);
    page.words(
        "L",
        (high.0 + side * 14.0, high.1 - 8.0),
        beside,
        drawing::WORDS,
    );
    let elbow = on_page(places.elbows[arm]);
    let name = ["A", "B"][arm];
    page.words(
        name,
        (elbow.0 + side * 16.0, elbow.1 + 5.0),
        beside,
        drawing::WORDS,
    );
    let motor = on_page(places.motors[arm]);
    draw_angle(page, motor, arm, angle);
    let motor_name = ["motor 1, τ_1", "motor 2, τ_2"][arm];
    let place = (motor.0 + side * 20.0, motor.1 + 52.0);
    page.words(motor_name, place, beside, drawing::SMALL);
}

/// Draws the motor angle `[rad]` of an arm, around its motor on the page `[px]`.
fn draw_angle(page: &mut Drawing, motor: (f64, f64), arm: usize, angle: f64) {
    page.line(&[motor, (motor.0 + 66.0, motor.1)], Pen::THOUGHT);
    let radius = [62.0, 44.0][arm];
    page.turn(motor, radius, (0.0, angle), Pen::MOTION);
    let (sin, cos) = (0.55 * angle).sin_cos();
    let reach = radius + 18.0;
    let place = (motor.0 + reach * cos, motor.1 - reach * sin + 5.0);
    let name = ["θ_1", "θ_2"][arm];
    page.coloured(
        name,
        place,
        Beside::Middle,
        drawing::WORDS,
        Some(Pen::MOTION.colour),
    );
}

/// Draws the dimension of the base, whose half is `half` `[m]`.
fn draw_base(page: &mut Drawing, half: f64) {
    let base = (at(-half, 0.0), at(half, 0.0));
    let below = ORIGIN.1 + 58.0;
    for end in [base.0, base.1] {
        page.line(
            &[(end.0, ORIGIN.1 + 12.0), (end.0, below + 5.0)],
            Pen::THOUGHT,
        );
    }
    page.length((base.0.0, below), (base.1.0, below), Pen::MOTION);
    let place = (ORIGIN.0, below + 16.0);
    page.coloured(
        "d",
        place,
        Beside::Middle,
        drawing::WORDS,
        Some(Pen::MOTION.colour),
    );
}

/// Returns the end-point `[m]`, with x from half-way between the motors.
fn end_point(pose: &ArmPose, elbow: (f64, f64), distal: f64) -> [f64; 2] {
    let [dx, dy] = pose.distal[0];
    [elbow.0 + distal * dx, elbow.1 + distal * dy]
}

fn joints(page: &mut Drawing, motors: [(f64, f64); 2], elbows: [(f64, f64); 2], tip: (f64, f64)) {
    for motor in motors {
        page.circle(motor, 15.0, Pen::BODY, "#eeeeee");
        page.circle(motor, 4.0, Pen::BODY, "#ffffff");
    }
    for elbow in elbows {
        page.circle(elbow, 9.0, Pen::BODY, "#ffffff");
    }
    page.circle(tip, 10.0, Pen::BODY, "#fbe3cf");
}

/// Draws the ball above the end-point, the measured heights, and the forces.
fn contact(page: &mut Drawing, tip: (f64, f64)) {
    let height = |y_on_page: f64| (ORIGIN.1 - y_on_page) / SCALE;
    let top = height(tip.1);
    // The end-point is a point; only the ball has an extent.
    let (surface, centre) = (at(0.0, top + GAP), at(0.0, top + GAP + BALL));
    page.circle(centre, SCALE * BALL, Pen::BODY, "#f4f4f4");
    page.circle(centre, 2.5, Pen::BODY, "#111111");
    page.words(
        "ball, M",
        (centre.0 - 34.0, centre.1 - 14.0),
        Beside::Left,
        drawing::WORDS,
    );
    page.words(
        "end-point P, m",
        (tip.0 - 36.0, tip.1 - 14.0),
        Beside::Left,
        drawing::WORDS,
    );

    draw_heights(page, tip, surface, centre);
    draw_forces(page, tip, centre);
}

/// Draws the heights of end-point, ball surface and ball centre, radius and gap; all places on the page `[px]`.
fn draw_heights(page: &mut Drawing, tip: (f64, f64), surface: (f64, f64), centre: (f64, f64)) {
    let column = tip.0 + 205.0;
    for (place, from, name) in [
        (tip, 12.0, "ξ = y_P"),
        (surface, 4.0, "η = y_V − r"),
        (centre, 4.0, "y_V"),
    ] {
        page.line(
            &[(place.0 + from, place.1), (column, place.1)],
            Pen::THOUGHT,
        );
        let beside = (column + 8.0, place.1 + 5.0);
        page.coloured(
            name,
            beside,
            Beside::Right,
            drawing::WORDS,
            Some(Pen::MOTION.colour),
        );
    }
    let (x, colour) = (tip.0 + 120.0, Some(Pen::MOTION.colour));
    page.length((x, surface.1), (x, centre.1), Pen::MOTION);
    page.coloured(
        "r",
        (x + 8.0, 0.5 * (surface.1 + centre.1) + 5.0),
        Beside::Right,
        drawing::WORDS,
        colour,
    );
    page.length((x, tip.1), (x, surface.1), Pen::MOTION);
    page.coloured(
        "−p",
        (x + 8.0, 0.5 * (tip.1 + surface.1) + 5.0),
        Beside::Right,
        drawing::WORDS,
        colour,
    );
}

/// Draws the forces on the ball and the end-point, whose places are on the page `[px]`.
fn draw_forces(page: &mut Drawing, tip: (f64, f64), centre: (f64, f64)) {
    let forces = Some(Pen::FORCE.colour);
    page.arrow(
        (centre.0, centre.1 - 34.0),
        (centre.0, centre.1 - 4.0),
        Pen::FORCE,
    );
    page.coloured(
        "f_V",
        (centre.0 + 8.0, centre.1 - 40.0),
        Beside::Right,
        drawing::WORDS,
        forces,
    );
    page.arrow(
        (tip.0 - 9.0, tip.1 + 62.0),
        (tip.0 - 9.0, tip.1 + 13.0),
        Pen::FORCE,
    );
    page.coloured(
        "f_u",
        (tip.0 - 16.0, tip.1 + 62.0),
        Beside::Left,
        drawing::WORDS,
        forces,
    );
    page.arrow(
        (tip.0 + 9.0, tip.1 + 13.0),
        (tip.0 + 9.0, tip.1 + 62.0),
        Pen::FORCE,
    );
    page.coloured(
        "−f",
        (tip.0 + 16.0, tip.1 + 62.0),
        Beside::Right,
        drawing::WORDS,
        forces,
    );
}
