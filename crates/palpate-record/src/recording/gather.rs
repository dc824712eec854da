//! Reassembly of ticks and their contacts.

use super::{BodyTick, ContactTick, DeviceTick, Tick};

/// A complete tick with its contacts, bodies and devices.
pub(super) type Whole = (Tick, Vec<ContactTick>, Vec<BodyTick>, Vec<DeviceTick>);

/// The tick whose contacts and bodies are being read.
///
/// The devices of a tick precede it; its contacts and its bodies follow. A tick with missing devices, contacts or
/// bodies is discarded and counts as missing.
#[derive(Clone, Debug, Default)]
pub(super) struct Gather {
    waiting: Option<Whole>,
    /// Devices of the next tick.
    devices: Vec<DeviceTick>,
}

impl Gather {
    /// Adds the next tick; returns it if no contacts or bodies follow.
    pub fn tick(&mut self, tick: Tick) -> Result<Option<Whole>, String> {
        let mut devices = std::mem::take(&mut self.devices);
        devices.retain(|device| device.sequence == tick.sequence);
        let number = devices.first().map_or(0, |device| device.devices as usize);
        if devices.len() != number {
            return Err(format!(
                "tick {} has {} of its {number} devices",
                tick.sequence,
                devices.len()
            ));
        }
        self.waiting = Some((tick, Vec::new(), Vec::new(), devices));
        Ok(self.complete())
    }

    /// Adds a device of the next tick.
    pub fn device(&mut self, device: DeviceTick) -> Result<(), String> {
        self.devices
            .retain(|before| before.sequence == device.sequence);
        if device.device as usize != self.devices.len() {
            return Err(format!(
                "device {} of tick {} is in the position of device {}",
                device.device,
                device.sequence,
                self.devices.len()
            ));
        }
        self.devices.push(device);
        Ok(())
    }

    /// Adds a contact; returns the complete tick if nothing else follows. A contact without its tick is skipped: it
    /// is missing with its tick.
    pub fn contact(&mut self, contact: ContactTick) -> Result<Option<Whole>, String> {
        let Some((tick, contacts, ..)) = &mut self.waiting else {
            return Ok(None);
        };
        if contact.sequence != tick.sequence {
            return Ok(None);
        }
        if contact.contact as usize != contacts.len() {
            return Err(format!(
                "contact {} of tick {} is in the position of contact {}",
                contact.contact,
                contact.sequence,
                contacts.len()
            ));
        }
        contacts.push(contact);
        Ok(self.complete())
    }

    /// Adds a body in the same way.
    pub fn body(&mut self, body: BodyTick) -> Option<Whole> {
        let (_, _, bodies, _) = self
            .waiting
            .as_mut()
            .filter(|(tick, ..)| body.sequence == tick.sequence)?;
        bodies.push(body);
        self.complete()
    }

    fn complete(&mut self) -> Option<Whole> {
        self.waiting.take_if(|(tick, contacts, bodies, _)| {
            contacts.len() == tick.contacts as usize && bodies.len() == tick.bodies as usize
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(sequence: u64, contacts: u32) -> Tick {
        Tick {
            sequence,
            contacts,
            ..Tick::default()
        }
    }

    fn contact(sequence: u64, contact: u32) -> ContactTick {
        ContactTick {
            sequence,
            contact,
            ..ContactTick::default()
        }
    }

    #[test]
    fn a_tick_is_whole_with_its_last_contact() {
        let mut gather = Gather::default();
        let free = gather.tick(tick(0, 0)).unwrap();
        assert_eq!(free, Some((tick(0, 0), vec![], vec![], vec![])));
        assert_eq!(gather.tick(tick(1, 2)).unwrap(), None);
        assert_eq!(gather.contact(contact(1, 0)), Ok(None));
        let whole = (
            tick(1, 2),
            vec![contact(1, 0), contact(1, 1)],
            vec![],
            vec![],
        );
        assert_eq!(gather.contact(contact(1, 1)), Ok(Some(whole)));
        assert_eq!(gather.contact(contact(1, 2)), Ok(None), "it is whole");
    }

    #[test]
    fn a_tick_of_a_world_is_whole_with_its_last_body() {
        let body = |sequence, body| BodyTick {
            sequence,
            body,
            ..BodyTick::default()
        };
        let of_world = |sequence| Tick {
            bodies: 2,
            ..tick(sequence, 1)
        };
        let mut gather = Gather::default();
        assert_eq!(gather.tick(of_world(0)).unwrap(), None);
        assert_eq!(gather.contact(contact(0, 0)), Ok(None));
        assert_eq!(gather.body(body(0, 3)), None);
        assert_eq!(gather.body(body(1, 3)), None, "of another tick");
        let whole = (
            of_world(0),
            vec![contact(0, 0)],
            vec![body(0, 3), body(0, 5)],
            vec![],
        );
        assert_eq!(gather.body(body(0, 5)), Some(whole));
        assert_eq!(gather.body(body(0, 6)), None, "it is whole");
    }

    #[test]
    fn a_tick_whose_contacts_are_not_all_there_is_none() {
        let mut gather = Gather::default();
        assert_eq!(gather.tick(tick(1, 2)).unwrap(), None);
        assert_eq!(gather.contact(contact(1, 0)), Ok(None));
        assert_eq!(gather.tick(tick(2, 1)).unwrap(), None);
        assert_eq!(gather.contact(contact(1, 1)), Ok(None), "too late");
        let whole = (tick(2, 1), vec![contact(2, 0)], vec![], vec![]);
        assert_eq!(gather.contact(contact(2, 0)), Ok(Some(whole)));
        assert_eq!(gather.tick(tick(3, 2)).unwrap(), None);
        let error = gather.contact(contact(3, 1)).unwrap_err();
        assert_eq!(error, "contact 1 of tick 3 is in the position of contact 0");
    }

    #[test]
    fn a_tick_has_all_the_devices_that_stand_before_it_or_is_none() {
        let device = |sequence, device| DeviceTick {
            sequence,
            device,
            devices: 2,
            ..DeviceTick::default()
        };
        let mut gather = Gather::default();
        gather.device(device(0, 0)).unwrap();
        gather.device(device(0, 1)).unwrap();
        let devices = vec![device(0, 0), device(0, 1)];
        let whole = Some((tick(0, 0), vec![], vec![], devices));
        assert_eq!(gather.tick(tick(0, 0)), Ok(whole));
        // Devices of the tick before do not belong to the next one.
        let alone = Some((tick(1, 0), vec![], vec![], vec![]));
        assert_eq!(gather.tick(tick(1, 0)), Ok(alone));
        gather.device(device(2, 0)).unwrap();
        let error = gather.tick(tick(2, 0)).unwrap_err();
        assert_eq!(error, "tick 2 has 1 of its 2 devices");
        // The devices of a lost tick are discarded.
        gather.device(device(3, 0)).unwrap();
        gather.device(device(4, 0)).unwrap();
        let error = gather.device(device(4, 2)).unwrap_err();
        assert_eq!(error, "device 2 of tick 4 is in the position of device 1");
    }
}
