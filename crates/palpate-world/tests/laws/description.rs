//! World descriptions: contact law of a pair, and faults.
#![allow(missing_docs)]

use palpate_world::{
    Body, Contact, ContactLaw, Free, Motion, Party, Shape, Tool, World, WorldPart,
};

const BALL: Shape = Shape::Sphere { radius: 0.03 };

fn named(name: &str) -> Party {
    Party::Named(name.into())
}

fn between(one: Party, other: Party, stiffness: f64) -> Contact {
    Contact {
        between: [one, other],
        law: ContactLaw::spring(stiffness),
    }
}

fn a_world(contacts: Vec<Contact>) -> World {
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
        bodies: vec![Body::new("ball", BALL, Motion::Free(Free::of_mass(0.1)))],
        contacts,
    }
}

#[test]
fn a_law_between_two_names_goes_before_one_between_any() {
    let world = a_world(vec![
        between(named("ball"), named("tool"), 3.0),
        between(named("ball"), Party::Any, 2.0),
        between(Party::Any, Party::Any, 1.0),
    ]);
    let stiffness = |one, other| world.law(one, other).map(|law| law.stiffness);
    assert_eq!(stiffness("tool", "ball"), Some(3.0));
    assert_eq!(stiffness("floor", "ball"), Some(2.0));
    assert_eq!(stiffness("floor", "wall"), Some(1.0));
}

#[test]
fn of_two_laws_for_a_pair_the_last_one_holds_and_a_pair_without_one_does_not_touch() {
    let world = a_world(vec![
        between(named("ball"), named("tool"), 3.0),
        between(named("tool"), named("ball"), 4.0),
    ]);
    assert_eq!(world.law("ball", "tool").unwrap().stiffness, 4.0);
    assert_eq!(world.law("ball", "floor"), None);
}

#[test]
fn every_fault_of_a_world_is_said_with_its_place() {
    let mut world = a_world(vec![between(named("bal"), Party::Any, -5.0)]);
    world.bodies[0].motion = Motion::Free(Free::of_mass(0.0));
    world.bodies.push(Body::new("tool", BALL, Motion::Fixed));
    let faults = world.check().unwrap_err();
    let said: Vec<_> = faults
        .iter()
        .map(|fault| (fault.part, fault.field.name(), fault.to_string()))
        .collect();
    let expected = [
        (
            WorldPart::Body(0),
            "mass",
            "body \"ball\": mass is 0, and has to be above 0",
        ),
        (
            WorldPart::Body(1),
            "name",
            "body \"tool\": the name is taken by another tool or body",
        ),
        (
            WorldPart::Contact(0),
            "between",
            "contact between \"bal\" and \"*\": \"bal\" is neither a tool nor a body of this world",
        ),
        (
            WorldPart::Contact(0),
            "stiffness",
            "contact between \"bal\" and \"*\": stiffness is -5, and has to be above 0",
        ),
        (
            WorldPart::Contact(0),
            "friction_stiffness",
            "contact between \"bal\" and \"*\": friction_stiffness is -5, and has to be above 0",
        ),
    ];
    assert_eq!(
        said,
        expected.map(|(place, field, text)| (place, field, text.to_owned()))
    );
}
