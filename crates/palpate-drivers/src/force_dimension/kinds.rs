//! Types of devices, with their published limits.

/// A type of device. `None` means that the device lacks it, or that it is not published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// Number of the type in the manufacturer's interface.
    pub code: i32,
    /// Name.
    pub name: &'static str,
    /// Whether the device measures the orientation of its handle.
    pub has_wrist: bool,
    /// Largest force `[N]`.
    pub largest_force: f64,
    /// Largest torque of a driven wrist `[N m]`.
    pub largest_torque: Option<f64>,
    /// Largest force of a driven gripper `[N]`.
    pub largest_grip: Option<f64>,
    /// Largest stiffness that CHAI3D recommends `[N/m]`.
    pub largest_stiffness: Option<f64>,
    /// Largest damping that CHAI3D recommends `[N s/m]`.
    pub largest_damping: Option<f64>,
}

/// Returns a device without a wrist.
const fn of_three(code: i32, name: &'static str, largest_force: f64) -> Kind {
    Kind {
        code,
        name,
        has_wrist: false,
        largest_force,
        largest_torque: None,
        largest_grip: None,
        largest_stiffness: None,
        largest_damping: None,
    }
}

const fn recommended(kind: Kind, stiffness: f64, damping: f64) -> Kind {
    Kind {
        largest_stiffness: Some(stiffness),
        largest_damping: Some(damping),
        ..kind
    }
}

const fn turning(kind: Kind, largest_torque: Option<f64>, largest_grip: Option<f64>) -> Kind {
    Kind {
        has_wrist: true,
        largest_torque,
        largest_grip,
        ..kind
    }
}

const OMEGA: Kind = recommended(of_three(33, "omega.3", 12.0), 5000.0, 30.0);
const DELTA: Kind = recommended(of_three(63, "delta.3", 20.0), 5000.0, 30.0);
const FALCON: Kind = recommended(of_three(60, "Falcon", 8.0), 3000.0, 20.0);

const fn omega(code: i32, name: &'static str, grip: Option<f64>) -> Kind {
    turning(
        Kind {
            code,
            name,
            ..OMEGA
        },
        None,
        grip,
    )
}

const fn seven(code: i32, name: &'static str, torque: f64) -> Kind {
    turning(of_three(code, name, 20.0), Some(torque), Some(8.0))
}

/// The types that the driver knows. The wrists of the omega.6 and omega.7 have no motors.
pub const KINDS: [Kind; 13] = [
    OMEGA,
    omega(34, "omega.6-right", None),
    omega(36, "omega.6-left", None),
    omega(35, "omega.7-right", Some(8.0)),
    omega(37, "omega.7-left", Some(8.0)),
    DELTA,
    of_three(206, "sigma.3", 20.0),
    seven(104, "sigma.7-right", 0.4),
    seven(105, "sigma.7-left", 0.4),
    of_three(203, "lambda.3", 20.0),
    seven(108, "lambda.7-right", 0.2),
    seven(109, "lambda.7-left", 0.2),
    FALCON,
];

impl Kind {
    /// Returns the type with this number.
    #[must_use]
    pub fn of_code(code: i32) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.code == code)
    }

    /// Returns the type with this name.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        KINDS.into_iter().find(|kind| kind.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_type_has_its_own_number_and_name() {
        for (place, kind) in KINDS.iter().enumerate() {
            assert_eq!(Kind::of_code(kind.code), Some(*kind));
            assert_eq!(Kind::of_name(kind.name), Some(*kind));
            let is_again = |other: &Kind| other.code == kind.code || other.name == kind.name;
            assert!(!KINDS[place + 1..].iter().any(is_again), "{kind:?}");
            assert!(kind.has_wrist || kind.largest_torque.is_none());
        }
        // Controllers without a known mechanism.
        assert_eq!(Kind::of_code(81), None);
    }
}
