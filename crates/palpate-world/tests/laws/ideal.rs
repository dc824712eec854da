//! Independent reference solution for worlds of spheres and half-spaces in continuous time, and for devices under
//! held forces. It uses fourth-order Runge-Kutta steps, short enough for a contact to begin between two steps. It
//! shares no code with the renderer.

use palpate_world::{Sample, Vector, WorldRenderer};

const STEPS: usize = 200;
/// Subdivision of a step in which a contact begins or ends.
const FINER: usize = 500;

/// A sphere: a tool with a mass per axis and a hand, or a body.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    pub position: Vector,
    pub velocity: Vector,
    pub mass: Vector,
    pub radius: f64,
    /// Constant force `[N]`.
    pub force: Vector,
    /// Spring `[N/m]` and damper `[N s/m]` of the hand, and its rest position.
    pub hand: (f64, f64, Vector),
    pub turning: Vector,
    pub is_tool: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: Vector,
    pub offset: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Law {
    pub stiffness: f64,
    pub damping: f64,
    pub friction: f64,
}

#[derive(Clone, Debug)]
pub struct Ideal {
    pub balls: Vec<Ball>,
    pub planes: Vec<Plane>,
    pub law: Law,
    /// Bristle of each pair: of balls with planes, then with later balls.
    pub bristles: Vec<Vector>,
}

fn add(a: Vector, b: Vector, by: f64) -> Vector {
    [a[0] + by * b[0], a[1] + by * b[1], a[2] + by * b[2]]
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Derivatives of a ball (velocity, acceleration, angular acceleration), and the contact force on it.
#[derive(Clone, Copy, Default)]
struct Rate {
    velocity: Vector,
    acceleration: Vector,
    spin: Vector,
    contact: Vector,
}

impl Ideal {
    pub fn new(balls: Vec<Ball>, planes: Vec<Plane>, law: Law) -> Self {
        let pairs = balls.len() * (planes.len() + balls.len());
        Self {
            balls,
            planes,
            law,
            bristles: vec![[0.0; 3]; pairs],
        }
    }

    fn rates(&self) -> (Vec<Rate>, Vec<Vector>) {
        let mut loads = vec![([0.0; 3], [0.0; 3]); self.balls.len()];
        let mut slides = Vec::new();
        let mut pair = 0;
        for (i, ball) in self.balls.iter().enumerate() {
            for plane in &self.planes {
                let depth = ball.radius - (dot(ball.position, plane.normal) - plane.offset);
                let place = add(ball.position, plane.normal, 0.5 * depth - ball.radius);
                slides.push(self.push(&mut loads, i, None, depth, plane.normal, place, pair));
                pair += 1;
            }
            for (j, other) in self.balls.iter().enumerate() {
                if j > i && !(ball.is_tool && other.is_tool) {
                    let off = add(ball.position, other.position, -1.0);
                    let length = dot(off, off).sqrt();
                    let normal = off.map(|x| x / length);
                    let depth = ball.radius + other.radius - length;
                    let place = add(ball.position, normal, 0.5 * depth - ball.radius);
                    slides.push(self.push(&mut loads, i, Some(j), depth, normal, place, pair));
                } else {
                    slides.push([0.0; 3]);
                }
                pair += 1;
            }
        }
        let rates = self
            .balls
            .iter()
            .zip(&loads)
            .map(|(ball, (force, torque))| {
                let (k, b, rest) = ball.hand;
                let own = |axis: usize| {
                    ball.force[axis]
                        - k * (ball.position[axis] - rest[axis])
                        - b * ball.velocity[axis]
                };
                let moment = 0.4 * ball.mass[0] * ball.radius * ball.radius;
                Rate {
                    velocity: ball.velocity,
                    acceleration: [0, 1, 2].map(|axis| (own(axis) + force[axis]) / ball.mass[axis]),
                    spin: if ball.is_tool {
                        [0.0; 3]
                    } else {
                        torque.map(|t| t / moment)
                    },
                    contact: *force,
                }
            });
        (rates.collect(), slides)
    }

    #[allow(clippy::too_many_arguments)]
    fn push(
        &self,
        loads: &mut [(Vector, Vector)],
        i: usize,
        j: Option<usize>,
        depth: f64,
        normal: Vector,
        place: Vector,
        pair: usize,
    ) -> Vector {
        if depth <= 0.0 {
            return [f64::NAN; 3];
        }
        let velocity = |ball: &Ball| {
            let turning = if ball.is_tool { [0.0; 3] } else { ball.turning };
            add(
                ball.velocity,
                cross(turning, add(place, ball.position, -1.0)),
                1.0,
            )
        };
        let mut relative = velocity(&self.balls[i]);
        if let Some(j) = j {
            relative = add(relative, velocity(&self.balls[j]), -1.0);
        }
        let Law {
            stiffness,
            damping,
            friction,
        } = self.law;
        let rate = -dot(relative, normal);
        let pressed = (stiffness * depth + damping * rate).max(0.0);
        let mut bristle = self.bristles[pair];
        bristle = add(bristle, normal, -dot(bristle, normal));
        let length = dot(bristle, bristle).sqrt();
        let most = friction * pressed / stiffness;
        if length > most {
            bristle = bristle.map(|x| x * most / length);
        }
        let force = add(normal.map(|n| n * pressed), bristle, -stiffness);
        let mut load = |number: usize, sign: f64| {
            let arm = add(place, self.balls[number].position, -1.0);
            loads[number].0 = add(loads[number].0, force, sign);
            loads[number].1 = add(loads[number].1, cross(arm, force), sign);
        };
        load(i, 1.0);
        if let Some(j) = j {
            load(j, -1.0);
        }
        add(relative, normal, rate)
    }

    fn moved(&self, rates: &[Rate], slides: &[Vector], h: f64) -> Self {
        let mut next = self.clone();
        for (ball, rate) in next.balls.iter_mut().zip(rates) {
            ball.position = add(ball.position, rate.velocity, h);
            ball.velocity = add(ball.velocity, rate.acceleration, h);
            ball.turning = add(ball.turning, rate.spin, h);
        }
        if self.law.friction > 0.0 {
            for (bristle, slide) in next.bristles.iter_mut().zip(slides) {
                *bristle = if slide[0].is_nan() {
                    [0.0; 3]
                } else {
                    add(*bristle, *slide, h)
                };
            }
        }
        next
    }

    /// Performs one step of `h` `[s]`. Returns the mean contact force on each ball.
    fn step(&mut self, h: f64) -> Vec<Vector> {
        let (a, sa) = self.rates();
        let (b, sb) = self.moved(&a, &sa, 0.5 * h).rates();
        let (c, sc) = self.moved(&b, &sb, 0.5 * h).rates();
        let (d, sd) = self.moved(&c, &sc, h).rates();
        let mix = |a: Vector, b: Vector, c: Vector, d: Vector| {
            [0, 1, 2].map(|k| (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0)
        };
        let mean: Vec<_> = (0..a.len())
            .map(|i| Rate {
                velocity: mix(a[i].velocity, b[i].velocity, c[i].velocity, d[i].velocity),
                acceleration: mix(
                    a[i].acceleration,
                    b[i].acceleration,
                    c[i].acceleration,
                    d[i].acceleration,
                ),
                spin: mix(a[i].spin, b[i].spin, c[i].spin, d[i].spin),
                contact: mix(a[i].contact, b[i].contact, c[i].contact, d[i].contact),
            })
            .collect();
        let slides: Vec<_> = (0..sa.len())
            .map(|i| mix(sa[i], sb[i], sc[i], sd[i]))
            .collect();
        *self = self.moved(&mean, &slides, h);
        if self.law.friction > 0.0 {
            self.cut();
        }
        mean.iter().map(|rate| rate.contact).collect()
    }

    /// Limits the bristles to what the normal forces hold.
    fn cut(&mut self) {
        let mut pair = 0;
        for i in 0..self.balls.len() {
            for number in 0..self.planes.len() + self.balls.len() {
                let ball = self.balls[i];
                let (depth, normal, rate) = if let Some(plane) = self.planes.get(number) {
                    let depth = ball.radius - (dot(ball.position, plane.normal) - plane.offset);
                    (depth, plane.normal, -dot(ball.velocity, plane.normal))
                } else {
                    let other = self.balls[number - self.planes.len()];
                    let off = add(ball.position, other.position, -1.0);
                    let length = dot(off, off).sqrt();
                    let normal = off.map(|x| x / length.max(1e-12));
                    let relative = add(ball.velocity, other.velocity, -1.0);
                    (
                        ball.radius + other.radius - length,
                        normal,
                        -dot(relative, normal),
                    )
                };
                let Law {
                    stiffness,
                    damping,
                    friction,
                } = self.law;
                let pressed = (stiffness * depth + damping * rate).max(0.0);
                let most = if depth > 0.0 {
                    friction * pressed / stiffness
                } else {
                    0.0
                };
                let bristle = &mut self.bristles[pair];
                *bristle = add(*bristle, normal, -dot(*bristle, normal));
                let length = dot(*bristle, *bristle).sqrt();
                if length > most {
                    *bristle = bristle.map(|x| x * most / length);
                }
                pair += 1;
            }
        }
    }

    /// Returns whether each pair touches.
    fn touching(&self) -> Vec<bool> {
        let (_, slides) = self.rates();
        slides.iter().map(|slide| !slide[0].is_nan()).collect()
    }

    /// Returns the mean contact force on each ball over an interval, and the integral of the squared forces on tools.
    pub fn interval(&mut self, h: f64) -> (Vec<Vector>, f64) {
        self.interval_in(h, STEPS)
    }

    /// Returns the same in `steps` steps.
    pub fn interval_in(&mut self, h: f64, steps: usize) -> (Vec<Vector>, f64) {
        let mut sum = vec![[0.0; 3]; self.balls.len()];
        let mut squares = 0.0;
        let mut take = |ideal: &mut Self, step: f64| {
            let forces = ideal.step(step);
            for ((sum, force), ball) in sum.iter_mut().zip(forces).zip(&ideal.balls) {
                *sum = add(*sum, force, step / h);
                if ball.is_tool {
                    squares += dot(force, force) * step;
                }
            }
        };
        let step = h / steps as f64;
        for _ in 0..steps {
            let touching = self.touching();
            let mut next = self.clone();
            next.step(step);
            if next.touching() == touching {
                take(self, step);
                continue;
            }
            for _ in 0..FINER {
                take(self, step / FINER as f64);
            }
        }
        (sum, squares)
    }
}

impl Ideal {
    /// Advances by one step of `h` `[s]`.
    pub fn advance(&mut self, h: f64) {
        self.step(h);
    }
}

/// Advances devices alone under held forces.
pub fn hold(tools: &mut Ideal, forces: &[Vector], h: f64) {
    let own: Vec<_> = tools.balls.iter().map(|ball| ball.force).collect();
    for (ball, force) in tools.balls.iter_mut().zip(forces) {
        ball.force = add(ball.force, *force, 1.0);
    }
    for _ in 0..20 {
        tools.step(h / 20.0);
    }
    for (ball, own) in tools.balls.iter_mut().zip(own) {
        ball.force = own;
    }
}

/// Actuators with one axis each: commands begin after a delay and pass through a lag, with a gain.
pub struct Actuators {
    pub delay: f64,
    pub lag: f64,
    pub gain: f64,
    /// Commands, each with the time of its sample.
    pub sent: Vec<(f64, Vec<Vector>)>,
    pub felt: Vec<Vector>,
    /// Constant force of each hand `[N]`.
    pub own: Vec<Vector>,
}

impl Actuators {
    /// Moves the devices from `from` to `to` `[s]`. Returns the impulse on each.
    pub fn hold(&mut self, devices: &mut Ideal, from: f64, to: f64) -> Vec<Vector> {
        const PARTS: usize = 50;
        let h = (to - from) / PARTS as f64;
        let mut impulses = vec![[0.0; 3]; devices.balls.len()];
        for part in 0..PARTS {
            let middle = from + (part as f64 + 0.5) * h;
            let acts = self
                .sent
                .iter()
                .rev()
                .find(|(sample, _)| sample + self.delay <= middle);
            let aim = acts.map_or_else(
                || vec![[0.0; 3]; impulses.len()],
                |(_, forces)| forces.clone(),
            );
            let kept = if self.lag > 0.0 {
                (-h / self.lag).exp()
            } else {
                0.0
            };
            let mut means = Vec::new();
            for (felt, aim) in self.felt.iter_mut().zip(aim) {
                let aim = aim.map(|force| self.gain * force);
                let before = *felt;
                *felt = add(aim, add(before, aim, -1.0), kept);
                let carried = if self.lag > 0.0 {
                    self.lag * (1.0 - kept) / h
                } else {
                    0.0
                };
                means.push(add(aim, add(before, aim, -1.0), carried));
            }
            for (impulse, mean) in impulses.iter_mut().zip(&means) {
                *impulse = add(*impulse, *mean, h);
            }
            for ((ball, mean), own) in devices.balls.iter_mut().zip(&means).zip(&self.own) {
                ball.force = add(*own, *mean, 1.0);
            }
            devices.step(h);
        }
        impulses
    }
}

/// Comparison of a renderer in a world with its reference solution.
#[derive(Clone, Debug)]
pub struct Trial {
    pub ideal: Ideal,
    pub period: f64,
    pub quantum: f64,
    /// Delay from a force to its beginning, in samples.
    pub delay: usize,
    pub samples: usize,
}

impl Trial {
    /// Returns E in percent: the mean-force error over all tools.
    pub fn error(&self, renderer: &WorldRenderer) -> f64 {
        let mut ideal = self.ideal.clone();
        let mut devices = Ideal::new(
            ideal
                .balls
                .iter()
                .filter(|ball| ball.is_tool)
                .copied()
                .collect(),
            Vec::new(),
            ideal.law,
        );
        let mut state = renderer.start();
        let tools = devices.balls.len();
        let mut queue = vec![vec![[0.0; 3]; tools]; self.delay];
        let (mut errors, mut all) = (0.0, 0.0);
        for _ in 0..self.samples {
            let positions: Vec<Vector> = devices
                .balls
                .iter()
                .map(|ball| {
                    ball.position.map(|x| {
                        if self.quantum > 0.0 {
                            (x / self.quantum).round() * self.quantum
                        } else {
                            x
                        }
                    })
                })
                .collect();
            let output = renderer.step(&mut state, &Sample::at(&positions));
            assert_eq!(output.fault, None);
            queue.push(output.forces.to_vec());
            let forces = queue.remove(0);
            let (means, squares) = ideal.interval(self.period);
            for (force, mean) in forces.iter().zip(&means) {
                let off = add(*force, *mean, -1.0);
                errors += dot(off, off) * self.period;
            }
            all += squares;
            hold(&mut devices, &forces, self.period);
        }
        100.0 * (errors / all).sqrt()
    }
}
