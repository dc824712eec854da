//! Device with a position-dependent mass matrix.
//!
//! ```text
//! M v' = f + g(x, v)      g = v^T (grad M) v/2 - (v . grad M) v
//! ```
//!
//! The observers estimate one mobility theta along each axis of the matrix at the table's reference, where the matrix
//! is D. The hand is represented by the acceleration e that it would cause there. At another position the mobility is
//! that of the table, scaled on both sides by the estimates:
//!
//! ```text
//! v' = W f + T e + M^-1 g      W = theta^1/2 N theta^1/2   T = theta^1/2 N theta^-1/2   N = D^1/2 M^-1 D^1/2
//! ```
//!
//! N is the unit matrix at the reference. Over an interval a device uses the mean over beginning, middle and end by
//! Simpson's rule. A proxy uses a series expansion of the matrix about the middle of the interval in each sub-step:
//! of first order perpendicular to the proxy's displacement, and of second order along it.

use std::sync::Arc;

use crate::Tool;
use crate::description::mass_table::{MassTable, principal};
use crate::dynamics::moving_body::Part;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::{Matrix3, Vector3};

/// A device with a mass table.
#[derive(Clone, Debug)]
pub(crate) struct Linkage {
    table: Arc<MassTable>,
    axes: Axes,
    /// Square roots of the masses at the reference, along the axes there.
    roots: Vector3,
}

/// A linkage at a position, along the device's axes.
#[derive(Clone, Copy, Debug)]
struct Local {
    /// Mass matrix M.
    mass: Matrix3,
    /// Derivatives of M along each axis.
    slopes: [Matrix3; 3],
    /// D^1/2.
    roots: Vector3,
}

/// Response of the linkage at a position.
#[derive(Clone, Copy, Debug)]
struct Answer {
    /// N.
    shape: Matrix3,
    /// M^-1 g: acceleration due to the change in mass `[m/s^2]`.
    change: Vector3,
}

/// Response of a linkage at the beginning, middle and end of an interval, along the device's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    answers: [Answer; 3],
    duration: f64,
}

/// A quantity that varies over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Changing {
    pub mean: Vector3,
    /// Moment by which its integral comes earlier than that of a constant quantity, times the duration.
    pub lead: Vector3,
}

/// State of a device at the beginning of an interval, and the forces on it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// Position `[m]`.
    pub position: Vector3,
    /// Velocity `[m/s]`.
    pub velocity: Vector3,
    /// e along the axes `[m/s^2]`.
    pub external: Vector3,
    /// Force without e `[N]`.
    pub force: Vector3,
}

/// Returns the componentwise quotients, 0 for a divisor of 0.
fn over(of: &Vector3, by: &Vector3) -> Vector3 {
    of.zip_map(by, |of, by| if by > 0.0 { of / by } else { 0.0 })
}

fn diagonal(of: &Vector3) -> Matrix3 {
    Matrix3::from_diagonal(of)
}

impl Local {
    /// Returns the response at a velocity `velocity` along the axes.
    fn answer(&self, velocity: &Vector3) -> Answer {
        let mut push = Vector3::zeros();
        for (axis, slope) in self.slopes.iter().enumerate() {
            let by_axis = slope * velocity;
            push[axis] += 0.5 * velocity.dot(&by_axis);
            push -= by_axis * velocity[axis];
        }
        // Every matrix of a table has an inverse.
        let inverse = self.mass.cholesky().map(|of| of.inverse());
        let inverse = inverse.unwrap_or_else(Matrix3::zeros);
        let roots = diagonal(&self.roots);
        Answer {
            shape: roots * inverse * roots,
            change: inverse * push,
        }
    }

    /// Returns the linkage after a displacement along the axes `[m]` with a change of the slopes by a `share` of
    /// `bend`.
    fn moved(&self, way: &Vector3, bend: &[Matrix3; 3], share: f64) -> Self {
        let mut moved = *self;
        for (axis, slope) in moved.slopes.iter_mut().enumerate() {
            moved.mass += (*slope + bend[axis] * (0.5 * share)) * way[axis];
            *slope += bend[axis] * share;
        }
        moved
    }

    /// Returns the momentum of a velocity, both along the axes `[N s]`; 0 along an axis without mobility.
    fn momentum(&self, theta: &Vector3, velocity: &Vector3) -> Vector3 {
        let scale = self.roots.component_mul(&theta.map(f64::sqrt));
        over(&(self.mass * over(velocity, &scale)), &scale)
    }
}

impl Answer {
    /// Returns the force along the axes that accelerates a device at the reference like `force` accelerates this one
    /// here `[N]`.
    fn equivalent(&self, roots: &Vector3, force: &Vector3) -> Vector3 {
        over(&(self.shape * roots.component_mul(force)), roots)
    }

    /// Returns the acceleration along each axis per unit of e along it.
    fn share(&self) -> Vector3 {
        self.shape.diagonal()
    }

    /// Returns the acceleration without contacts, along the axes `[m/s^2]`.
    fn acceleration(&self, roots: &Vector3, external: &Vector3) -> Vector3 {
        roots.component_mul(&(self.shape * over(external, roots))) + self.change
    }
}

impl Passage {
    fn changing(&self, of: impl Fn(&Answer) -> Vector3) -> Changing {
        let [start, middle, end] = self.answers.each_ref().map(of);
        let h = self.duration;
        Changing {
            mean: (start + middle * 4.0 + end) / 6.0,
            lead: (start - end) * (h * h / 12.0),
        }
    }

    /// Returns the force along the axes that accelerates a device of mobility `theta` along each axis like `force`
    /// accelerates this one `[N]`.
    pub fn equivalent(&self, theta: &Vector3, force: &Vector3) -> Changing {
        let roots = theta.map(f64::sqrt);
        self.changing(|answer| answer.equivalent(&roots, force))
    }

    /// Returns the acceleration along each axis per unit of e along it.
    pub fn share(&self) -> Vector3 {
        self.changing(Answer::share).mean
    }

    /// Returns the acceleration without contacts in excess of the share of e, along the axes `[m/s^2]`.
    pub fn bias(&self, theta: &Vector3, external: &Vector3) -> Changing {
        let roots = theta.map(f64::sqrt);
        let share = self.share();
        self.changing(|answer| {
            answer.acceleration(&roots, external) - share.component_mul(external)
        })
    }
}

impl Linkage {
    /// Returns `None` for a device with a constant mass.
    pub fn new(tool: &Tool) -> Option<Self> {
        let table = tool.mass_table.as_ref()?;
        let (_, masses) = table.principal();
        Some(Self {
            table: table.clone(),
            axes: Axes::new(tool.axes, tool.own_axes),
            roots: masses.map(f64::sqrt),
        })
    }

    /// Evaluates the linkage at a position in the world.
    fn at(&self, place: &Vector3) -> Local {
        let local = self.table.at(&self.table.own(place));
        // Rotation from the table's axes to the device's.
        let turn = Matrix3::from_columns(&[0, 1, 2].map(|axis| {
            let mut unit = Vector3::zeros();
            unit[axis] = 1.0;
            self.table.own(&self.axes.out(&unit))
        }));
        let has = self.axes.where_there(1.0);
        let own = |of: &Matrix3, lacking_mass: &Vector3| {
            let mut own = turn.tr_mul(&(of * turn));
            for lacking in (0..3).filter(|&axis| has[axis] == 0.0) {
                own.row_mut(lacking).fill(0.0);
                own.column_mut(lacking).fill(0.0);
                own[(lacking, lacking)] = lacking_mass[lacking];
            }
            own
        };
        let slopes = local.slopes.each_ref().map(|of| own(of, &Vector3::zeros()));
        Local {
            mass: own(&local.mass, &self.roots.component_mul(&self.roots)),
            slopes: [0, 1, 2].map(|axis| {
                let mut along = Matrix3::zeros();
                for (of_table, slope) in slopes.iter().enumerate() {
                    along += slope * turn[(of_table, axis)];
                }
                along * has[axis]
            }),
            roots: self.roots,
        }
    }

    /// Returns the momentum of a device at a position with a velocity, along its axes `[N s]`.
    pub fn momentum(&self, theta: &Vector3, [place, velocity]: [&Vector3; 2]) -> Vector3 {
        self.at(place).momentum(theta, &self.axes.own(velocity))
    }

    /// Returns the kinetic energy `[J]`.
    pub fn kinetic_energy(&self, theta: &Vector3, [place, velocity]: [&Vector3; 2]) -> f64 {
        let momentum = self.momentum(theta, [place, velocity]);
        0.5 * momentum.dot(&self.axes.own(velocity))
    }

    /// Evaluates the linkage over an interval of `h` `[s]` from `start`.
    pub fn over(&self, theta: &Vector3, start: &Start, h: f64) -> Passage {
        let pushed = start.external + theta.component_mul(&self.axes.own(&start.force));
        let roots = theta.map(f64::sqrt);
        let Start {
            position, velocity, ..
        } = start;
        let answer =
            |place: &Vector3, velocity: &Vector3| self.at(place).answer(&self.axes.own(velocity));
        let gained =
            |answer: &Answer, h: f64| self.axes.out(&answer.acceleration(&roots, &pushed)) * h;
        let first = answer(position, velocity);
        let half = 0.5 * h;
        let by_middle = gained(&first, half);
        let at_middle = position + (velocity + by_middle * 0.5) * half;
        let middle = answer(&at_middle, &(velocity + by_middle));
        let by_end = gained(&middle, h);
        let at_end = position + (velocity + by_end * 0.5) * h;
        let end = answer(&at_end, &(velocity + by_end));
        Passage {
            answers: [first, middle, end],
            duration: h,
        }
    }

    /// Returns the motion parameters of a proxy over an interval of `h` `[s]` that begins. Its device has the
    /// mobility `theta`; its drive is that of `part`.
    pub fn carried(&self, part: &Part, theta: &Vector3, h: f64) -> Carried {
        let half = part.rigid.velocity * (0.5 * h);
        let middle = part.rigid.position + half;
        let [start, end] = [-half, half].map(|way| self.at(&(middle + way)));
        let way = self.axes.own(&half) * 2.0;
        let square = way.norm_squared();
        Carried {
            axes: self.axes,
            middle,
            local: self.at(&middle),
            bend: [0, 1, 2].map(|axis| end.slopes[axis] - start.slopes[axis]),
            per_bend: if square > 0.0 {
                way / square
            } else {
                Vector3::zeros()
            },
            roots: theta.map(f64::sqrt),
            external: self.axes.own(&part.drive.acceleration),
            damping_rate: part.drive.damping_rate,
            spring_rate: part.drive.spring_rate,
        }
    }
}

/// Proxy of a linkage over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    axes: Axes,
    /// Approximate position in the middle of the interval `[m]`.
    middle: Vector3,
    /// Linkage at that position.
    local: Local,
    /// Change of the slopes from beginning to end.
    bend: [Matrix3; 3],
    /// Inverse of the displacement along the axes: times a displacement it is the fraction of that change `[1/m]`.
    per_bend: Vector3,
    /// theta^1/2.
    roots: Vector3,
    /// e.
    external: Vector3,
    /// Derivatives of e with respect to velocity and displacement, along the axes, with negative sign.
    damping_rate: Vector3,
    spring_rate: Vector3,
}

impl Carried {
    /// Sets mobility and drive of the proxy for the next sub-step of `h` `[s]`.
    pub fn carry(&self, part: &mut Part, h: f64) {
        let way = part.rigid.position + part.rigid.velocity * (0.5 * h) - self.middle;
        // Extrapolated half a sub-step ahead with the velocity change of the last half.
        let velocity = part.rigid.velocity + part.gained;
        let way = self.axes.own(&way);
        let share = self.per_bend.dot(&way);
        let moved = self.local.moved(&way, &self.bend, share);
        let answer = moved.answer(&self.axes.own(&velocity));
        let roots = diagonal(&self.roots);
        let (mobility, turn) = principal(&(roots * answer.shape * roots));
        let axes = self.axes.own_axes().unwrap_or_else(Matrix3::identity);
        part.mobility.linear = mobility.map(|along| along.max(0.0));
        part.mobility.linear_axes = Some(axes * turn);
        let share = answer.share();
        part.drive.axes = Some(axes);
        part.drive.damping_rate = self.damping_rate.component_mul(&share);
        part.drive.spring_rate = self.spring_rate.component_mul(&share);
        part.drive.acceleration = axes * answer.acceleration(&self.roots, &self.external);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::moving_body::Drive;
    use crate::geometry::rigid::{Mobility, Rigid, Rotation};
    use crate::{Shape, Vector};

    const START: Vector = [-0.06, -0.03, 0.075];

    fn tool() -> Tool {
        let places = [(-0.08, 9), (-0.06, 7), (0.0, 6)];
        let places =
            places.map(|(first, count)| (0..count).map(|n| first + 0.02 * f64::from(n)).collect());
        let places: [Vec<f64>; 3] = places;
        let mut masses = Vec::new();
        for x in &places[0] {
            for y in &places[1] {
                for z in &places[2] {
                    let (s, c) = ((9.0 * x + 4.0 * z).sin(), (8.0 * y - 6.0 * z).cos());
                    let diagonal = [0.2 + 0.08 * s, 0.25 + 0.1 * c, 0.3 + 0.1 * s * c];
                    let [xx, yy, zz] = diagonal;
                    masses.push([xx, yy, zz, 0.05 * s, 0.04 * c, 0.05 * s * s]);
                }
            }
        }
        let tool = Tool::new("tool", Shape::Sphere { radius: 0.0 });
        tool.with_mass_table(&places, &masses, START).unwrap()
    }

    fn theta(tool: &Tool) -> Vector3 {
        let table = tool.mass_table.as_ref().unwrap();
        Vector3::from(table.masses_at_reference()).map(f64::recip)
    }

    /// Over a displacement of 2.6 mm, compared with 64 times finer intervals of the device.
    #[test]
    fn device_and_proxy_follow_the_path_of_finer_intervals() {
        let tool = tool();
        let (linkage, theta, h) = (Linkage::new(&tool).unwrap(), theta(&tool), 0.004);
        let begin = Start {
            position: Vector3::new(-0.03, -0.013, 0.045),
            velocity: Vector3::new(0.4, 0.2, -0.5),
            external: Vector3::new(5.0, 2.0, -7.0),
            force: Vector3::zeros(),
        };
        let step = |start: &Start, h: f64| {
            let over = linkage.over(&theta, start, h);
            let bias = over.bias(&theta, &start.external);
            let own = over.share().component_mul(&start.external) + bias.mean;
            let gained = linkage.axes.out(&own) * h;
            Start {
                position: start.position
                    + (start.velocity + gained * 0.5) * h
                    + linkage.axes.out(&bias.lead),
                velocity: start.velocity + gained,
                ..*start
            }
        };
        let whole = step(&begin, h);
        let mut fine = begin;
        for _ in 0..64 {
            fine = step(&fine, h / 64.0);
        }
        let straight = begin.position + begin.velocity * h;
        let accelerated = linkage.axes.out(&begin.external) * (0.5 * h * h);
        let by_change = (fine.position - straight - accelerated).norm();
        assert!(by_change > 5e-6, "{by_change:e}");
        let off = (whole.position - fine.position).norm();
        assert!(off < 3e-9, "{off:e}");

        let rigid = Rigid {
            position: begin.position,
            velocity: begin.velocity,
            orientation: Rotation::identity(),
            spin: Vector3::zeros(),
        };
        let drive = Drive::constant(linkage.axes.out(&begin.external));
        let mut part = Part::new(rigid, Mobility::none(), drive);
        let carried = linkage.carried(&part, &theta, h);
        part.begin();
        let sub_step = h / 64.0;
        for _ in 0..64 {
            carried.carry(&mut part, sub_step);
            part.first_push::<true>(0.5 * sub_step);
            part.drift(sub_step);
            part.second_push::<true>(0.5 * sub_step);
        }
        let off = (part.rigid.position - fine.position).norm();
        let faster = (part.rigid.velocity - fine.velocity).norm();
        assert!(off < 3e-10 && faster < 2e-7, "{off:e} {faster:e}");
    }

    #[test]
    fn at_its_reference_it_is_a_device_of_the_masses_there() {
        let tool = tool();
        let (linkage, theta) = (Linkage::new(&tool).unwrap(), theta(&tool));
        let rest = Start {
            position: Vector3::from(START),
            velocity: Vector3::zeros(),
            external: Vector3::new(1.0, -2.0, 3.0),
            force: Vector3::zeros(),
        };
        let over = linkage.over(&theta, &rest, 1e-9);
        let force = Vector3::new(0.3, 0.7, -0.2);
        assert!((over.equivalent(&theta, &force).mean - force).norm() < 1e-12);
        assert!(over.bias(&theta, &rest.external).mean.norm() < 1e-12);
        let velocity = Vector3::new(0.1, 0.2, 0.3);
        let momentum = linkage.momentum(&theta, [&rest.position, &velocity]);
        let own = linkage.axes.own(&velocity);
        assert!((momentum - own.component_div(&theta)).norm() < 1e-12);
    }
}
