//! Figures of a device report, each as inline SVG of an HTML page.

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series, Size, SizeError, svg};
use palpate_study::advise::Reach;
use palpate_study::calibration::MotionCard;
use palpate_study::card::{
    ContactCard, Distribution, EffectiveCard, FeltCard, FeltPointCard, MethodFeltCard,
    MethodReachCard, ReachCard,
};

use super::escape::escaped;

/// Height of an empty bin, as the logarithm of a count: below the height of one tick.
const EMPTY: f64 = -0.4;

/// Counter of the figures on a page, for unique names inside them.
#[derive(Default)]
pub struct Figures {
    drawn: usize,
}

impl Figures {
    /// Draws a figure of `size` in millimetres; `says` is its text alternative. A figure whose legend and notes need
    /// more height gets it.
    fn draw(&mut self, figure: &Figure, size: &str, says: &str) -> Result<String, SizeError> {
        let size: Size = size.parse()?;
        let drawn = match svg(figure, size) {
            Err(SizeError::TooSmall {
                side: "height",
                least,
                ..
            }) => svg(figure, size.with_height(least))?,
            drawn => drawn?,
        };
        self.drawn += 1;
        let own = format!("figure-{}-panel-", self.drawn);
        let begin = drawn.find("<svg").unwrap_or(0);
        // HTML needs no SVG namespace, and its ids must be unique in the whole page.
        let inner = drawn[begin..]
            .replace(" xmlns=\"http://www.w3.org/2000/svg\"", "")
            .replace("\"panel-", &format!("\"{own}"))
            .replace("#panel-", &format!("#{own}"));
        let says = format!("<svg role=\"img\" aria-label=\"{}\"", escaped(says));
        Ok(inner.trim_end().replacen("<svg", &says, 1))
    }

    /// Draws histograms of durations, one curve per recording.
    pub fn histogram(
        &mut self,
        name: &str,
        of: &[(String, &Distribution)],
    ) -> Result<String, SizeError> {
        let is_logarithmic = of.iter().all(|(_, one)| one.histogram.is_logarithmic);
        let (scale, unit) = if is_logarithmic {
            (1e6, "us")
        } else {
            (1e3, "ms")
        };
        let place = |seconds: f64| {
            if is_logarithmic {
                (scale * seconds.max(1e-7)).log10()
            } else {
                scale * seconds
            }
        };
        let mut series: Vec<Series> = of
            .iter()
            .enumerate()
            .map(|(number, (recording, one))| {
                let edges = one.histogram.edges_s.iter().map(|edge| place(*edge));
                let first = one.histogram.edges_s.first().map(|edge| place(*edge));
                let counts = one.histogram.counts.iter().map(|count| match count {
                    0 => EMPTY,
                    count => (*count as f64).log10(),
                });
                Series {
                    name: if of.len() > 1 {
                        recording.clone()
                    } else {
                        String::new()
                    },
                    kind: Kind::Step,
                    role: Role::Compared(number),
                    x: first.into_iter().chain(edges).collect(),
                    y: std::iter::once(EMPTY)
                        .chain(counts)
                        .chain([EMPTY])
                        .collect(),
                }
            })
            .collect();
        if let [(_, one)] = of {
            let most = one.histogram.counts.iter().max().copied().unwrap_or(1);
            let top = (most.max(1) as f64).log10();
            series.push(Series {
                name: "99 % are below".into(),
                kind: Kind::Line,
                role: Role::Mark,
                x: vec![place(one.p99); 2],
                y: vec![EMPTY, top],
            });
        }
        let figure = Figure {
            x_label: format!("{name} [{unit}]"),
            x_decades: is_logarithmic,
            rows: vec![Row {
                y_label: "ticks".into(),
                y_decades: true,
                limits: Limits::Data,
                panels: vec![Panel { series }],
            }],
            ..Figure::default()
        };
        self.draw(&figure, "85x50", &format!("Histogram: {name}"))
    }

    /// Draws measured and fitted motion.
    pub fn calibration(&mut self, motion: &MotionCard) -> Result<String, SizeError> {
        let figure = crate::results::motion(motion);
        self.draw(&figure, "110x92", "Calibration: measured against fitted")
    }

    /// Draws the renderable stiffness over the object's mass.
    pub fn reach(&mut self, reach: &ReachCard) -> Result<String, SizeError> {
        // Units are grams and newtons per millimetre.
        let masses = reach
            .object_masses_kg
            .iter()
            .map(|mass| (1e3 * mass).log10());
        let masses: Vec<f64> = masses.collect();
        let row = |label: &str, of: fn(&MethodReachCard) -> &Vec<Reach>, is_named: bool| Row {
            y_label: label.into(),
            y_decades: true,
            limits: Limits::Data,
            panels: vec![Panel {
                series: (reach.methods.iter().enumerate())
                    .map(|(number, method)| Series {
                        name: if is_named {
                            method.method.into()
                        } else {
                            String::new()
                        },
                        kind: Kind::Line,
                        role: Role::Compared(number),
                        x: masses.clone(),
                        y: (of(method).iter())
                            .map(|limit| {
                                limit.value.map_or(f64::NAN, |value| (1e-3 * value).log10())
                            })
                            .collect(),
                    })
                    .collect(),
            }],
        };
        let figure = Figure {
            x_label: "object mass [g]".into(),
            x_decades: true,
            rows: vec![
                row("good below [N/mm]", |of| &of.good_n_per_m, true),
                row("stable below [N/mm]", |of| &of.stable_n_per_m, false),
            ],
            ..Figure::default()
        };
        self.draw(
            &figure,
            "110x92",
            "Stiffest contact over the mass of the object",
        )
    }

    /// Draws stiffness and damping of a wall, and mass and damping of an object, over the frequency.
    pub fn felt(&mut self, felt: &FeltCard) -> Result<[String; 2], SizeError> {
        let wall = felt_figure(
            felt,
            |method| &method.wall,
            ("[N/mm]", |part| 1e-3 * part.stiffness_n_per_m),
        );
        let object = felt_figure(
            felt,
            |method| &method.object,
            ("[g]", |part| 1e3 * part.mass_kg),
        );
        Ok([
            self.draw(&wall, "85x52", "Felt stiffness and damping of a wall")?,
            self.draw(&object, "85x52", "Felt mass and damping of an object")?,
        ])
    }

    /// Draws the stable stiffness over the damping of a wall.
    pub fn z_width(&mut self, felt: &FeltCard) -> Result<String, SizeError> {
        let limits = felt.stable_n_per_m.iter();
        let figure = Figure {
            x_label: "damping of the wall [N s/m]".into(),
            rows: vec![Row {
                y_label: "stable below [N/mm]".into(),
                limits: Limits::Data,
                panels: vec![Panel {
                    series: vec![Series {
                        name: String::new(),
                        kind: Kind::Line,
                        role: Role::Compared(0),
                        x: felt.damping_n_s_per_m.clone(),
                        y: limits
                            .map(|limit| 1e-3 * limit.value.unwrap_or(0.0))
                            .collect(),
                    }],
                }],
                ..Row::default()
            }],
            ..Figure::default()
        };
        self.draw(&figure, "85x50", "Stable stiffness over damping")
    }

    /// Draws positions, forces and energy of a contact.
    pub fn contact(&mut self, contact: &ContactCard) -> Result<String, SizeError> {
        let begins = contact.begins_s;
        let curve = |name: &str, quantity: &str, kind, role, unit: f64| {
            let curve = contact.curve(quantity)?;
            Some(Series {
                name: name.into(),
                kind,
                role,
                x: curve.t_s.iter().map(|time| 1e3 * (time - begins)).collect(),
                y: curve.values.iter().map(|value| unit * value).collect(),
            })
        };
        let row = |label: &str, series: Vec<Option<Series>>| Row {
            y_label: label.into(),
            limits: Limits::Data,
            panels: vec![Panel {
                series: series.into_iter().flatten().collect(),
            }],
            ..Row::default()
        };
        let method = contact.method;
        let own = Role::Compared(0);
        let figure = Figure {
            x_label: "time [ms]".into(),
            rows: vec![
                row(
                    "position [mm]",
                    vec![
                        curve("object", "object_m", Kind::Line, own, 1e3),
                        curve("device", "device_m", Kind::Line, Role::Device, 1e3),
                    ],
                ),
                row(
                    "force [N]",
                    vec![
                        curve("ideal", "ideal_force_n", Kind::Line, Role::Reference, 1.0),
                        curve(method, "force_n", Kind::Step, own, 1.0),
                    ],
                ),
                row(
                    "created [mJ]",
                    vec![curve("", "created_j", Kind::Line, own, 1e3)],
                ),
            ],
            ..Figure::default()
        };
        self.draw(
            &figure,
            "110x92",
            "A contact: positions, force and created energy",
        )
    }
}

/// Returns the figure of one contact by all methods: `first` is the label and the value of its upper row.
fn felt_figure(
    felt: &FeltCard,
    points: fn(&MethodFeltCard) -> &Vec<FeltPointCard>,
    first: (&str, fn(EffectiveCard) -> f64),
) -> Figure {
    let line = |name: &str,
                role: Role,
                method: &MethodFeltCard,
                of: fn(&FeltPointCard) -> Option<EffectiveCard>,
                value: fn(EffectiveCard) -> f64| Series {
        name: name.into(),
        kind: Kind::Line,
        role,
        x: (points(method).iter())
            .map(|point| point.frequency_hz.log10())
            .collect(),
        y: (points(method).iter())
            .map(|point| of(point).map_or(f64::NAN, value))
            .collect(),
    };
    let row = |label: &str, value: fn(EffectiveCard) -> f64, is_named: bool| {
        let name = |name: &'static str| if is_named { name } else { "" };
        let wanted = felt.methods.first().map(|method| {
            line(
                name("wanted"),
                Role::Reference,
                method,
                |point| point.wanted,
                value,
            )
        });
        let rendered = felt.methods.iter().enumerate().map(|(number, method)| {
            line(
                name(method.method),
                Role::Compared(number),
                method,
                |point| point.rendered,
                value,
            )
        });
        Row {
            y_label: label.into(),
            limits: Limits::Data,
            panels: vec![Panel {
                series: wanted.into_iter().chain(rendered).collect(),
            }],
            ..Row::default()
        }
    };
    Figure {
        x_label: "frequency of the hand [Hz]".into(),
        x_decades: true,
        rows: vec![
            row(first.0, first.1, true),
            row("[N\u{a0}s/m]", |part| part.damping_n_s_per_m, false),
        ],
        ..Figure::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The legend of many series takes several lines, which the wanted height has no room for.
    #[test]
    fn a_figure_that_needs_more_height_is_drawn_higher() {
        let series = |number: usize| Series {
            name: format!("a long name of the series {number}"),
            kind: Kind::Line,
            role: Role::Compared(number),
            x: vec![0.0, 1.0],
            y: vec![0.0, 1.0],
        };
        let figure = Figure {
            rows: vec![Row {
                panels: vec![Panel {
                    series: (0..12).map(series).collect(),
                }],
                ..Row::default()
            }],
            ..Figure::default()
        };
        assert!(svg(&figure, "85x40".parse().unwrap()).is_err());
        let drawn = Figures::default().draw(&figure, "85x40", "many").unwrap();
        assert!(drawn.starts_with("<svg role"), "{drawn}");
    }
}
