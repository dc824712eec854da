//! JSON representation of core values, for the schema.

use schemars::JsonSchema;

/// A mass `[kg]`; `inf` for a wall.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[allow(dead_code, reason = "read by the derive alone")]
pub enum MassInJson {
    /// Mass of an object.
    Finite(f64),
    /// Mass of a wall.
    Infinite(Inf),
}

/// Representation of infinity.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
#[allow(dead_code, reason = "read by the derive alone")]
pub enum Inf {
    /// Infinite.
    Inf,
}

/// On which side of the device the object is.
#[derive(JsonSchema)]
#[schemars(rename_all = "kebab-case")]
#[allow(dead_code, reason = "read by the derive alone")]
pub enum SideInJson {
    /// Above it.
    Positive,
    /// Below it.
    Negative,
}
