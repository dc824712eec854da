//! Worlds in commands: which flags they take, which method, and their faults in words.

use std::path::Path;

use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::text::digits;
use palpate_world::{ContactState, Place, Side, World, WorldError};

use crate::arguments::{Flags, Given};
use crate::failure::Failure;

/// Refuses flags that a world does not take: its file says what they would.
pub fn only(given: &Given, known: &[&str], path: &Path) -> Result<(), Failure> {
    let Some(flag) = given.other_than(known) else {
        return Ok(());
    };
    Err(Failure::Arguments(format!(
        "{flag}: {} is a world, which says all of that in its file; beside it stand {}",
        path.display(),
        known
            .iter()
            .filter(|name| !["file", "scene"].contains(name))
            .map(|name| format!("--{}", name.replace('_', "-")))
            .collect::<Vec<_>>()
            .join(", ")
    )))
}

/// The methods by their names: those that were named, or the scene's own. All are those for which the scene has
/// every setting and shapes that they know.
pub fn methods<'a>(flags: &'a Flags, scene: &'a WorldScene) -> Vec<&'a str> {
    match &flags.method {
        None => vec![&scene.render.method],
        Some(methods) if methods.are_all => {
            let all = WorldScene::METHODS.into_iter();
            all.filter(|name| scene.method(name).is_ok()).collect()
        }
        Some(methods) => methods.names.clone(),
    }
}

/// The one method by its name.
pub fn one_method<'a>(flags: &'a Flags, scene: &'a WorldScene) -> Result<&'a str, Failure> {
    match methods(flags, scene)[..] {
        [method] => Ok(method),
        _ => Err(Failure::Arguments(
            "--method: here a world is rendered by one method; name it".into(),
        )),
    }
}

/// A method's name, as it lives as long as the program.
pub fn known(method: &str) -> &'static str {
    let mut all = WorldScene::METHODS.into_iter();
    all.find(|name| *name == method).unwrap_or("unknown")
}

/// What is wrong with a world that has been read: the fault lies in a flag if one gave the method, else in the
/// file.
pub fn wrong_world(flags: &Flags, file: &WorldFile, faults: &[WorldError]) -> Failure {
    let first = &faults[0];
    if flags.method.is_some() && first.place == Place::Method {
        return Failure::Arguments(format!("--method: {}", first.message));
    }
    let error = file.at(first.place, first.field, first.to_string());
    Failure::input_at(&error, &error.file, &error.source_text, error.span.clone())
}

/// The names of a world's tools and bodies.
pub struct Names {
    tools: Vec<String>,
    bodies: Vec<String>,
}

impl Names {
    pub fn of(world: &World) -> Self {
        Self {
            tools: world.tools.iter().map(|tool| tool.name.clone()).collect(),
            bodies: world.bodies.iter().map(|body| body.name.clone()).collect(),
        }
    }

    fn side(&self, side: Side) -> &str {
        match side {
            Side::Tool(number) => &self.tools[number],
            Side::Body(number) => &self.bodies[number],
        }
    }

    /// Two that overlap, in words.
    pub fn overlap(&self, contact: &ContactState) -> String {
        let [one, other] = contact.between.map(|side| self.side(side));
        format!(
            "\"{one}\" and \"{other}\" overlap by {} m",
            digits(contact.penetration)
        )
    }
}
