//! The law of a contact, and between whom it holds.

/// A law, and the pair of tools or bodies for which it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The pair, in any order. Two tools do not touch each other, nor do two fixed bodies.
    pub between: [Party; 2],
    /// The law.
    pub law: ContactLaw,
}

/// One side of a contact.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Party {
    /// Every tool and body; written `"*"` in files.
    Any,
    /// The tool or body of that name.
    Named(String),
}

impl Party {
    /// Its name, or `*` for all.
    #[must_use]
    pub fn as_str(&self) -> &str {
        match self {
            Self::Any => "*",
            Self::Named(name) => name,
        }
    }
}

/// How two surfaces push each other, as a function of how they overlap.
///
/// With penetration p `[m]` and its rate p', the normal force is max(0, K p + B p') while p > 0. Friction is an
/// elasto-plastic bristle: its deflection z follows the tangential displacement at the contact's point, which is
/// midway between the two surfaces, and is cut to mu N / k_t. Its force is k_t z + B_t v_t, with v_t the tangential
/// velocity, and is limited to mu N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// K, above 0 `[N/m]`.
    pub stiffness: f64,
    /// B, at least 0 `[N s/m]`.
    pub damping: f64,
    /// mu, at least 0 `[1]`.
    pub friction: f64,
    /// k_t, above 0 `[N/m]`.
    pub friction_stiffness: f64,
    /// B_t, damping of the bristle, at least 0 `[N s/m]`. Without it a body that friction holds keeps swinging.
    pub friction_damping: f64,
}

impl ContactLaw {
    /// A spring of that stiffness `[N/m]` without damping and friction.
    #[must_use]
    pub fn spring(stiffness: f64) -> Self {
        Self {
            stiffness,
            damping: 0.0,
            friction: 0.0,
            friction_stiffness: stiffness,
            friction_damping: 0.0,
        }
    }

    /// The bristle's damping of a material that damps both directions alike, B k_t / K `[N s/m]`: the default of scene files
    /// and bindings. 0 for a stiffness that is not above 0.
    #[must_use]
    pub fn usual_friction_damping(stiffness: f64, damping: f64, friction_stiffness: f64) -> f64 {
        if stiffness > 0.0 {
            damping * friction_stiffness / stiffness
        } else {
            0.0
        }
    }

    /// The same law with friction of coefficient `friction` `[1]`.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// The same law with material damping `[N s/m]`.
    #[must_use]
    pub fn with_damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }
}
