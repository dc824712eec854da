//! Phases and flags of ticks.

/// Predicted contact phase of the next interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// No contact.
    #[default]
    Free,
    /// In contact during the whole interval.
    Contact,
    /// Contact begins within the interval.
    Enters,
    /// Contact ends within the interval.
    Leaves,
    /// The sample was rejected: the object does not move.
    Waiting,
}

impl Phase {
    /// All phases, in the order of their numbers in a recording.
    pub const ALL: [Self; 5] = [
        Self::Free,
        Self::Contact,
        Self::Enters,
        Self::Leaves,
        Self::Waiting,
    ];

    /// Returns the short name, as in run files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Contact => "contact",
            Self::Enters => "enters",
            Self::Leaves => "leaves",
            Self::Waiting => "waiting",
        }
    }

    pub(super) fn number(self) -> u8 {
        match self {
            Self::Free => 0,
            Self::Contact => 1,
            Self::Enters => 2,
            Self::Leaves => 3,
            Self::Waiting => 4,
        }
    }
}

/// Set of flags of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(pub u32);

impl Flags {
    /// Device and object are in contact at the sample.
    pub const CONTACT: Self = Self(1);
    /// The method's force would have been attractive.
    pub const LIMITED_PULL: Self = Self(1 << 1);
    /// The renderer's force limit was active.
    pub const LIMITED_FORCE: Self = Self(1 << 2);
    /// The renderer's slew limit was active.
    pub const LIMITED_SLEW: Self = Self(1 << 3);
    /// The passivity guard was active.
    pub const LIMITED_GUARD: Self = Self(1 << 4);
    /// The renderer rejected the sample; an event contains the reason.
    pub const FAULT: Self = Self(1 << 5);
    /// Safety changed the force on its way to the device.
    pub const SAFETY_LIMITED: Self = Self(1 << 6);
    /// A safety stop is active: no force is sent.
    pub const SAFETY_STOPPED: Self = Self(1 << 7);
    /// The tick started or ended after its deadline.
    pub const MISSED_DEADLINE: Self = Self(1 << 8);
    /// The device did not answer, or answered without a position.
    pub const DEVICE_FAULT: Self = Self(1 << 9);
    /// A device accelerated beyond the bound of the passivity guard, which then used the bound by speed.
    pub const BEYOND_GUARD: Self = Self(1 << 10);

    /// All flags.
    pub const ALL: Self = Self(u32::MAX);

    /// Flags of a contact; the others belong to the whole tick.
    pub const OF_CONTACT: Self = Self(
        Self::CONTACT.0
            | Self::LIMITED_PULL.0
            | Self::LIMITED_FORCE.0
            | Self::LIMITED_SLEW.0
            | Self::LIMITED_GUARD.0
            | Self::FAULT.0
            | Self::BEYOND_GUARD.0,
    );

    /// Flags of a device in a loop with several devices.
    pub const OF_DEVICE: Self =
        Self(Self::SAFETY_LIMITED.0 | Self::SAFETY_STOPPED.0 | Self::DEVICE_FAULT.0);

    /// Named flags, by bit.
    pub const NAMED: [(Self, &'static str); 11] = [
        (Self::CONTACT, "contact"),
        (Self::LIMITED_PULL, "limited-pull"),
        (Self::LIMITED_FORCE, "limited-force"),
        (Self::LIMITED_SLEW, "limited-slew"),
        (Self::LIMITED_GUARD, "limited-guard"),
        (Self::FAULT, "fault"),
        (Self::SAFETY_LIMITED, "safety-limited"),
        (Self::SAFETY_STOPPED, "safety-stopped"),
        (Self::MISSED_DEADLINE, "missed-deadline"),
        (Self::DEVICE_FAULT, "device-fault"),
        (Self::BEYOND_GUARD, "beyond-guard"),
    ];

    /// Adds `others` if `condition` holds.
    #[must_use]
    pub fn with(self, others: Self, condition: bool) -> Self {
        if condition {
            Self(self.0 | others.0)
        } else {
            self
        }
    }

    /// Returns whether all of `others` are set.
    #[must_use]
    pub fn has(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// Returns the active limits of the renderer, such as `pull` and `force`, and `beyond-guard`.
    pub fn limits(self) -> impl Iterator<Item = &'static str> {
        let set = Self::NAMED
            .into_iter()
            .filter(move |(flag, _)| self.has(*flag));
        set.filter_map(|(flag, name)| match flag {
            Self::BEYOND_GUARD => Some(name),
            _ => name.strip_prefix("limited-"),
        })
    }

    /// Returns the names of the flags, separated by spaces; a bit without a name as `bit-` and its number.
    #[must_use]
    pub fn names(self) -> String {
        let name = |bit: u32| {
            let named = Self::NAMED.iter().find(|(flag, _)| flag.0 == 1 << bit);
            named.map_or_else(|| format!("bit-{bit}"), |(_, name)| (*name).to_owned())
        };
        let names: Vec<String> = (0..u32::BITS)
            .filter(|bit| self.0 & (1 << bit) != 0)
            .map(name)
            .collect();
        names.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_named_and_none_is_hidden() {
        assert_eq!(Flags::default().names(), "");
        let flags = Flags::CONTACT.with(Flags::DEVICE_FAULT, true);
        assert_eq!(
            flags.with(Flags::FAULT, false).names(),
            "contact device-fault"
        );
        assert!(flags.has(Flags::CONTACT) && !flags.has(Flags::FAULT));
        assert_eq!(Flags(1 << 20).names(), "bit-20");
        let limits = flags.with(Flags::LIMITED_SLEW, true);
        let limits = limits
            .with(Flags::LIMITED_PULL, true)
            .with(Flags::SAFETY_LIMITED, true);
        assert!(limits.limits().eq(["pull", "slew"]));
    }
}
