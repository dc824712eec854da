//! Force errors of many scenes and methods as dot plots.

use crate::figure::{Dot, DotFigure, DotPanel};
use palpate_study::compare::{Comparison, MethodRow, Outcome, SceneRows};

/// FRE above which a dot is drawn at the edge `[%]`: the force is unusable in any case.
const LARGEST: f64 = 1000.0;

/// Results of the methods on one scene.
#[derive(Debug, Clone)]
struct ComparedScene<'a> {
    /// Title of the scene.
    title: &'a str,
    /// Zero-order-hold bound: minimum FRE of any held force `[%]`.
    hold_bound: Option<f64>,
    /// Results of each method.
    methods: Vec<ComparedMethod>,
}

/// Result of a method on one scene.
#[derive(Debug, Clone)]
struct ComparedMethod {
    /// Name of the method.
    name: &'static str,
    /// FRE `[%]`.
    error: Option<f64>,
    /// Whether the run stayed bounded, inside the safety box and off the end stops of the mechanism.
    holds_together: bool,
    /// Whether the method can be set up.
    ran: bool,
}

impl<'a> ComparedScene<'a> {
    fn new(scene: &'a SceneRows) -> Self {
        let of_method = |method: &MethodRow| {
            let run = match &method.result {
                Outcome::Ran(run) => Some(run),
                Outcome::Cannot { .. } | Outcome::NoneFound { .. } => None,
            };
            ComparedMethod {
                name: method.method,
                error: run.and_then(|run| run.force_rendering_error_percent),
                holds_together: run.is_some_and(|run| run.is_whole),
                ran: run.is_some(),
            }
        };
        Self {
            title: &scene.title,
            hold_bound: scene.hold_bound_percent,
            methods: scene.methods.iter().map(of_method).collect(),
        }
    }
}

/// Returns the figure of the force errors of a comparison.
pub fn compared(comparison: &Comparison) -> DotFigure {
    let scenes: Vec<_> = comparison.scenes.iter().map(ComparedScene::new).collect();
    let mut figure = figure(&scenes);
    if comparison.scenes.iter().any(|scene| scene.is_world) {
        figure.ring_label += ", or refused samples";
    }
    figure
}

/// Returns a figure with one panel per scene and one line per method.
fn figure(scenes: &[ComparedScene]) -> DotFigure {
    let dot = |method: &ComparedMethod| Dot {
        name: method.name.into(),
        value: method.error,
        ring: method.ran && !method.holds_together,
        note: match method {
            ComparedMethod { ran: false, .. } => "cannot be set up".into(),
            ComparedMethod { error: None, .. } => "no contact".into(),
            _ => String::new(),
        },
    };
    DotFigure {
        title: finding(scenes),
        subtitle: "Force rendering error of each method on each scene".into(),
        footnote: "FRE: error of the held force to the ideal force, over the window of the scene. Hold bound: the \
                   least FRE of any force that is held over the periods of the loop."
            .into(),
        x_label: "FRE [%]".into(),
        largest: LARGEST,
        floor_label: "hold bound".into(),
        ring_label: "diverged, left the safety box or jammed".into(),
        panels: scenes
            .iter()
            .map(|scene| DotPanel {
                head: scene.title.into(),
                floor: scene.hold_bound,
                dots: scene.methods.iter().map(dot).collect(),
            })
            .collect(),
    }
}

/// Names the method that is nearest to the ideal on most of the scenes.
fn finding(scenes: &[ComparedScene]) -> String {
    let nearest: Vec<&str> = scenes.iter().filter_map(nearest).collect();
    let wins = |name: &str| nearest.iter().filter(|winner| **winner == name).count();
    // Ties go to the first method in the usual order.
    let names = scenes.first().into_iter().flat_map(|scene| &scene.methods);
    let Some(best) = names.rev().max_by_key(|method| wins(method.name)) else {
        return String::new();
    };
    match nearest.len() {
        0 => "No method has a bounded run with a force error on any scene".into(),
        evaluated => format!(
            "{} has the least force error on {} of {evaluated} scenes",
            best.name,
            wins(best.name)
        ),
    }
}

/// Returns the method with the lowest error among the runs that stayed bounded.
fn nearest(scene: &ComparedScene) -> Option<&'static str> {
    let whole = scene.methods.iter().filter(|method| method.holds_together);
    let errors = whole.filter_map(|method| Some((method.name, method.error?)));
    errors
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(name: &'static str, error: f64, holds_together: bool) -> ComparedMethod {
        ComparedMethod {
            name,
            error: Some(error),
            holds_together,
            ran: true,
        }
    }

    #[test]
    fn the_title_counts_the_scenes_where_a_method_is_nearest_and_whole() {
        let scene = |methods| ComparedScene {
            title: "a scene",
            hold_bound: Some(1.0),
            methods,
        };
        let scenes = [
            scene(vec![method("a", 20.0, true), method("b", 10.0, true)]),
            scene(vec![method("a", 20.0, true), method("b", 30.0, true)]),
            scene(vec![method("a", 20.0, true), method("b", 10.0, false)]),
        ];
        let drawn = figure(&scenes);
        assert_eq!(drawn.title, "a has the least force error on 2 of 3 scenes");
        assert!(drawn.panels[2].dots[1].ring && !drawn.panels[1].dots[1].ring);
        assert_eq!(figure(&[]).title, "");
    }
}
