//! Contact laws and the pairs to which they apply.

/// A contact law and its pair of tools or bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// The unordered pair. Two tools never collide, and neither do two fixed bodies.
    pub between: [Party; 2],
    /// Contact law.
    pub law: ContactLaw,
}

/// One side of a contact.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Party {
    /// Every tool and body; written `"*"` in files.
    Any,
    /// The tool or body with this name.
    Named(String),
}

impl Party {
    /// Returns its name, or `*` for all.
    #[must_use]
    pub fn as_str(&self) -> &str {
        match self {
            Self::Any => "*",
            Self::Named(name) => name,
        }
    }
}

/// Contact law: force between two surfaces as a function of their overlap.
///
/// For penetration p `[m]` with rate p', the normal force is max(0, K p + B p') while p > 0. Friction is an
/// elasto-plastic bristle. Its deflection z follows the tangential displacement at the contact point, midway between
/// the two surfaces, and is limited to mu N / k_t. Its force is k_t z + B_t v_t with the tangential velocity v_t,
/// limited to mu N.
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
    /// B_t, damping of the bristle, at least 0 `[N s/m]`. Without it a body held by friction oscillates undamped.
    pub friction_damping: f64,
}

impl ContactLaw {
    /// Creates a spring of this stiffness `[N/m]` without damping and friction.
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

    /// Returns the bristle damping for a material with equal damping ratio in both directions, B k_t / K `[N s/m]`:
    /// the default of scene files and bindings. 0 if the stiffness is not above 0.
    #[must_use]
    pub fn usual_friction_damping(stiffness: f64, damping: f64, friction_stiffness: f64) -> f64 {
        if stiffness > 0.0 {
            damping * friction_stiffness / stiffness
        } else {
            0.0
        }
    }

    /// Sets the friction coefficient `[1]`.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// Sets the material damping `[N s/m]`.
    #[must_use]
    pub fn with_damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }
}
