//! Conversion of core types to recording types. The two crates do not depend on each other.

use palpate_core::{Ledger, Output};
use palpate_device::Pose;
use palpate_record::recording::{ContactTick, Flags, Phase, Tick};

/// Converts an output of the core and its energy ledger up to the sample to a contact. Tick number, device position
/// and actually sent force are unknown here and set by the caller.
#[must_use]
pub fn answered(output: &Output<f64>, ledger: &Ledger<f64>) -> ContactTick {
    let limited = output.limited;
    ContactTick {
        object_position: output.object_position,
        object_velocity: output.object_velocity,
        penetration: output.penetration,
        proxy_shift: output.proxy_shift,
        force_on_object: output.force_on_object,
        force_on_device: output.force_on_device,
        phase: phase(output.phase),
        flags: Flags::default()
            .with(Flags::CONTACT, output.penetration > 0.0)
            .with(Flags::LIMITED_PULL, limited.pull)
            .with(Flags::LIMITED_FORCE, limited.force)
            .with(Flags::LIMITED_SLEW, limited.slew)
            .with(Flags::LIMITED_GUARD, limited.guard)
            .with(Flags::BEYOND_GUARD, limited.beyond_guard),
        ..recorded(ContactTick::UNKNOWN, ledger)
    }
}

/// Adds the values of the ledger to a contact.
pub(crate) fn recorded(contact: ContactTick, ledger: &Ledger<f64>) -> ContactTick {
    ContactTick {
        stored_energy: ledger.stored,
        port_work: ledger.port_work,
        virtual_force_work: ledger.virtual_force_work,
        outside_work: ledger.outside_work,
        original_leak: ledger.original_leak.accumulated,
        held_leak: ledger.held_leak.accumulated,
        ..contact
    }
}

/// Converts the pose of a device with `axes` axes to a tick.
pub(crate) fn posed(pose: &Pose, axes: usize) -> Tick {
    let mut tick = Tick::UNKNOWN;
    for (given, read) in tick.device_axes.iter_mut().zip(pose.position).take(axes) {
        *given = read;
    }
    if let Some(orientation) = pose.orientation {
        tick.device_orientation = orientation;
    }
    tick
}

fn phase(phase: palpate_core::Phase) -> Phase {
    match phase {
        palpate_core::Phase::Free => Phase::Free,
        palpate_core::Phase::Contact => Phase::Contact,
        palpate_core::Phase::Enters => Phase::Enters,
        palpate_core::Phase::Leaves => Phase::Leaves,
        palpate_core::Phase::Waiting => Phase::Waiting,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_of_the_core_has_its_own_place() {
        let leak = |accumulated| palpate_core::Leak {
            last: -1.0,
            accumulated,
            absolute: -1.0,
        };
        let output = Output {
            force_on_device: 1.0,
            force_on_object: 2.0,
            slope_on_device: 0.0,
            object_position: 3.0,
            object_velocity: 4.0,
            penetration: 5.0,
            phase: palpate_core::Phase::Enters,
            transition_after: -1.0,
            proxy_shift: 6.0,
            limited: palpate_core::Limited {
                slew: true,
                ..palpate_core::Limited::default()
            },
            fault: None,
        };
        let ledger = Ledger {
            opening: 6.5,
            stored: 7.0,
            port_work: 8.0,
            virtual_force_work: 9.0,
            outside_work: 10.0,
            original_leak: leak(11.0),
            held_leak: leak(12.0),
            limited_leak: leak(13.0),
        };
        let expected = ContactTick {
            force_on_device: 1.0,
            force_on_object: 2.0,
            object_position: 3.0,
            object_velocity: 4.0,
            penetration: 5.0,
            proxy_shift: 6.0,
            stored_energy: 7.0,
            port_work: 8.0,
            virtual_force_work: 9.0,
            outside_work: 10.0,
            original_leak: 11.0,
            held_leak: 12.0,
            phase: Phase::Enters,
            flags: Flags::CONTACT.with(Flags::LIMITED_SLEW, true),
            ..ContactTick::UNKNOWN
        };
        // NaN differs from NaN, but both have the same text.
        let said = answered(&output, &ledger);
        assert_eq!(format!("{said:?}"), format!("{expected:?}"));
    }

    #[test]
    fn a_pose_has_the_axes_of_its_device() {
        let time = std::time::Duration::ZERO;
        let tick = posed(&Pose::at([1.0, 2.0, 0.0], time), 2);
        assert!(tick.device_axes[..2] == [1.0, 2.0] && tick.device_axes[2].is_nan());
        assert!(tick.device_orientation.iter().all(|part| part.is_nan()));
        let turned = Pose {
            orientation: Some([0.6, 0.8, 0.0, 0.0]),
            ..Pose::at([0.0; 3], time)
        };
        assert_eq!(posed(&turned, 3).device_orientation, [0.6, 0.8, 0.0, 0.0]);
    }

    #[test]
    fn a_phase_keeps_its_name() {
        for of_core in [
            palpate_core::Phase::Free,
            palpate_core::Phase::Contact,
            palpate_core::Phase::Enters,
            palpate_core::Phase::Leaves,
            palpate_core::Phase::Waiting,
        ] {
            assert_eq!(phase(of_core).name(), of_core.name());
        }
    }
}
