//! Names of result codes, for messages and files.

use core::ffi::{CStr, c_char};

use crate::output::Fault;
use crate::status::Status;

const UNKNOWN: &CStr = c"unknown";

impl Status {
    const ALL: [Self; 11] = [
        Self::Ok,
        Self::Null,
        Self::StructSize,
        Self::Parameter,
        Self::Setting,
        Self::Change,
        Self::Memory,
        Self::Internal,
        Self::Scene,
        Self::Count,
        Self::Recording,
    ];

    fn name(self) -> &'static CStr {
        match self {
            Self::Ok => c"ok",
            Self::Null => c"null",
            Self::StructSize => c"struct-size",
            Self::Parameter => c"parameter",
            Self::Setting => c"setting",
            Self::Change => c"change",
            Self::Memory => c"memory",
            Self::Internal => c"internal",
            Self::Scene => c"scene",
            Self::Count => c"count",
            Self::Recording => c"recording",
        }
    }
}

impl Fault {
    const ALL: [Self; 11] = [
        Self::None,
        Self::PositionNotFinite,
        Self::VirtualForceNotFinite,
        Self::ElapsedNotPositive,
        Self::GapTooLong,
        Self::JumpTooFast,
        Self::Overflow,
        Self::OrientationNotUnit,
        Self::Other,
        Self::Argument,
        Self::Internal,
    ];

    fn name(self) -> &'static CStr {
        match self {
            Self::None => c"none",
            Self::PositionNotFinite => c"position-not-finite",
            Self::VirtualForceNotFinite => c"virtual-force-not-finite",
            Self::ElapsedNotPositive => c"elapsed-not-positive",
            Self::GapTooLong => c"gap-too-long",
            Self::JumpTooFast => c"jump-too-fast",
            Self::Overflow => c"overflow",
            Self::OrientationNotUnit => c"orientation-not-unit",
            Self::Other => c"other",
            Self::Argument => c"argument",
            Self::Internal => c"internal",
        }
    }
}

/// Returns the name of a palpate_status, such as "struct-size", or "unknown". The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_status_name(status: u32) -> *const c_char {
    let mut all = Status::ALL.into_iter();
    let known = all.find(|known| *known as u32 == status);
    known.map_or(UNKNOWN, Status::name).as_ptr()
}

/// Returns the name of a palpate_fault as in files of the program, such as "gap-too-long", or "unknown".
/// The text is static.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_fault_name(fault: u32) -> *const c_char {
    let mut all = Fault::ALL.into_iter();
    let known = all.find(|known| *known as u32 == fault);
    known.map_or(UNKNOWN, Fault::name).as_ptr()
}

#[cfg(test)]
mod tests {
    use palpate_core::Fault as Core;

    use super::*;

    #[test]
    fn a_fault_has_its_name_of_the_core() {
        let of_core = [
            Core::PositionNotFinite,
            Core::VirtualForceNotFinite,
            Core::ElapsedNotPositive,
            Core::GapTooLong,
            Core::JumpTooFast,
            Core::OrientationNotUnit,
            Core::Overflow,
        ];
        for fault in of_core {
            let own = Fault::new(Some(fault));
            assert_ne!(own, Fault::Other);
            assert_eq!(own.name().to_str(), Ok(fault.name()));
        }
    }

    #[test]
    fn every_number_has_one_name() {
        let of = |name: extern "C" fn(u32) -> *const c_char, number| {
            // SAFETY: the text is static and terminated by a 0.
            unsafe { CStr::from_ptr(name(number)) }.to_str().unwrap()
        };
        let known = |name: extern "C" fn(u32) -> *const c_char| {
            let names = (0..1000).map(|number| of(name, number));
            let names: Vec<_> = names.filter(|name| *name != "unknown").collect();
            let different: std::collections::HashSet<_> = names.iter().copied().collect();
            assert_eq!(different.len(), names.len());
            names.len()
        };
        assert_eq!(known(palpate_status_name), Status::ALL.len());
        assert_eq!(known(palpate_fault_name), Fault::ALL.len());
        assert_eq!(of(palpate_status_name, u32::MAX), "unknown");
        assert_eq!(of(palpate_fault_name, Fault::Argument as u32), "argument");
    }
}
