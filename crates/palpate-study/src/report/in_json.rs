//! How values of the core stand in JSON, for the schema.

use schemars::JsonSchema;

/// A mass `[kg]`; `inf` for a wall.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[allow(dead_code, reason = "read by the derive alone")]
pub enum MassInJson {
    /// Of an object.
    Finite(f64),
    /// Of a wall.
    Infinite(Inf),
}

/// What stands for infinity.
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
