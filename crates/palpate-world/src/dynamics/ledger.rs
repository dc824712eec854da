//! Energy ledger of a world.

/// Energy of a contact pair over all completed intervals `[J]`.
///
/// ```text
/// stored = stored at the start + observed + outside + handed - work - dissipated + step_error
/// leak   = held - work_on_proxy
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactLedger {
    /// Stored energy K p^2/2 + k_t |z|^2/2 at the last sample.
    pub stored: f64,
    /// Energy dissipated by damping and friction; never decreases.
    pub dissipated: f64,
    /// Work of the contact on both of its sides.
    pub work: f64,
    /// W_c: work of the contact on the tool's proxy, if one of its sides is a tool.
    pub work_on_proxy: f64,
    /// Work of the contact's mean force on the device itself.
    pub held: f64,
    /// Change in stored energy due to samples or limits that displaced the proxy from its expected position.
    pub observed: f64,
    /// Energy added by changes of the running world.
    pub outside: f64,
    /// Energy transferred from the other points of the same pair at a switch of the contact face between two boxes.
    /// The sum over the pair is 0.
    pub handed: f64,
    /// Energy generated (positive) or lost by finite sub-steps.
    pub step_error: f64,
}

impl ContactLedger {
    /// Returns the energy that holding the mean force has given to the hand in excess of the contact's own work
    /// `[J]`.
    #[must_use]
    pub fn leak(&self) -> f64 {
        self.held - self.work_on_proxy
    }

    /// Returns the generated energy: stored or given away in excess of the work on the tool's proxy `[J]`.
    pub(crate) fn created(&self) -> f64 {
        self.observed + self.step_error - self.work_on_proxy
    }
}

/// Energy of a joint over all completed intervals `[J]`.
///
/// ```text
/// stored = the same at the start + outside - work - dissipated + step_error
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct JointLedger {
    /// Energy of its springs at the last sample.
    pub stored: f64,
    /// Energy dissipated by damping; never decreases.
    pub dissipated: f64,
    /// Work of the joint on both of its sides.
    pub work: f64,
    /// Energy added by changes of the running world.
    pub outside: f64,
    /// Energy generated (positive) or lost by finite sub-steps.
    pub step_error: f64,
}

/// Energy of a force field over all completed intervals `[J]`.
///
/// ```text
/// stored = observed + outside + supplied - work + step_error
/// leak   = held - work
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldLedger {
    /// Stored energy U at the last sample.
    pub stored: f64,
    /// Work of the field on the tool's proxy.
    pub work: f64,
    /// Work of the field's mean force on the device itself.
    pub held: f64,
    /// Change in stored energy due to samples or limits that displaced the proxy from its expected position.
    pub observed: f64,
    /// Energy added by changes of the running world.
    pub outside: f64,
    /// Work of a constant force, which is external.
    pub supplied: f64,
    /// Energy generated (positive) or lost by finite sub-steps.
    pub step_error: f64,
}

impl FieldLedger {
    /// Returns the energy that holding the mean force has given to the hand in excess of the field's own work `[J]`.
    #[must_use]
    pub fn leak(&self) -> f64 {
        self.held - self.work
    }

    /// Returns the generated energy: stored or given away in excess of the work on the tool's proxy `[J]`.
    pub(crate) fn created(&self) -> f64 {
        self.observed + self.step_error - self.work
    }
}

/// Energy of a body over all completed intervals `[J]`.
///
/// ```text
/// kinetic + potential = the same at the start + work + outside + step_error
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BodyLedger {
    /// Kinetic energy at the last sample.
    pub kinetic: f64,
    /// Potential energy: minus the work of its constant force since the start.
    pub potential: f64,
    /// Work of contacts and joints on the body.
    pub work: f64,
    /// External change: from waiting for a usable sample, and from changes of the running world.
    pub outside: f64,
    /// Energy generated (positive) or lost by finite sub-steps.
    pub step_error: f64,
}

/// Energy at the port of a device over all completed intervals `[J]`, positive towards the hand.
///
/// ```text
/// port_work + carried  = held + unforeseen
/// held - work on avatar = offset - velocity_offset + unpaid      the contacts' leaks, where a force moves the device
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceLedger {
    /// Work of the held force on the measured device motion.
    pub port_work: f64,
    /// Work that no motor performs. Along the axes that the device lacks ([`Tool::axes`](crate::Tool::axes)) it is
    /// the work of the contacts' mean force, which the mechanism carries: 0 if the tool does not move along them. For
    /// a tool turned by its hand ([`Tool::turned_by_hand`](crate::Tool::turned_by_hand)) it is the work of the
    /// contact torques, against which the hand turns the tool.
    pub carried: f64,
    /// Sum of the contacts' [`ContactLedger::held`] and the fields' [`FieldLedger::held`].
    pub held: f64,
    /// Unpredicted work at the port. It results from the difference between the held force and the mean contact force
    /// known later, and from that between the measured and the estimated path of the device.
    pub unforeseen: f64,
    /// Work of the hand on the proxy minus that on the device: F_u times the offset if F_u is constant and the force
    /// is held.
    pub offset: f64,
    /// Kinetic energy gained by the proxy minus that gained by the device.
    pub velocity_offset: f64,
    /// Work of the contacts' mean force on the device minus that of the commanded force.
    pub unpaid: f64,
    /// Work of the hand on the decaying proxy offset while nothing touches the tool.
    pub walked_back: f64,
}

/// Energy ledger of a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyLedger {
    /// Each pair that has a law and can touch, in the order of [`WorldState::contacts`](crate::WorldState::contacts).
    pub contacts: Vec<ContactLedger>,
    /// Each body, in the world's order; zero for fixed bodies.
    pub bodies: Vec<BodyLedger>,
    /// Each joint, in the world's order.
    pub joints: Vec<JointLedger>,
    /// Each field, in the world's order.
    pub fields: Vec<FieldLedger>,
    /// Each device, in the order of the tools.
    pub devices: Vec<DeviceLedger>,
    /// Elements removed by changes of the running world.
    pub gone: Departed,
}

/// Summed ledgers of the elements removed from a world. Their remaining energy is recorded as outside work, so their
/// stored and kinetic energies are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Departed {
    /// All removed contacts.
    pub contacts: ContactLedger,
    /// All removed bodies.
    pub bodies: BodyLedger,
    /// All removed joints.
    pub joints: JointLedger,
    /// All removed fields.
    pub fields: FieldLedger,
}

impl Departed {
    fn add_contact(&mut self, entry: &ContactLedger) {
        let sum = &mut self.contacts;
        sum.dissipated += entry.dissipated;
        sum.work += entry.work;
        sum.work_on_proxy += entry.work_on_proxy;
        sum.held += entry.held;
        sum.observed += entry.observed;
        sum.outside += entry.outside - entry.stored;
        sum.handed += entry.handed;
        sum.step_error += entry.step_error;
    }

    fn add_body(&mut self, entry: &BodyLedger) {
        let sum = &mut self.bodies;
        sum.potential += entry.potential;
        sum.work += entry.work;
        sum.outside += entry.outside - entry.kinetic;
        sum.step_error += entry.step_error;
    }

    fn add_joint(&mut self, entry: &JointLedger) {
        let sum = &mut self.joints;
        sum.dissipated += entry.dissipated;
        sum.work += entry.work;
        sum.outside += entry.outside - entry.stored;
        sum.step_error += entry.step_error;
    }

    fn add_field(&mut self, entry: &FieldLedger) {
        let sum = &mut self.fields;
        sum.work += entry.work;
        sum.held += entry.held;
        sum.observed += entry.observed;
        sum.outside += entry.outside - entry.stored;
        sum.supplied += entry.supplied;
        sum.step_error += entry.step_error;
    }
}

impl EnergyLedger {
    /// Returns the sum over all contacts and fields of the change in stored energy by samples and limits `[J]`.
    pub(crate) fn observed(&self) -> f64 {
        let contacts: f64 = self.contacts.iter().map(|entry| entry.observed).sum();
        contacts + self.fields.iter().map(|entry| entry.observed).sum::<f64>()
    }

    /// Returns the energy dissipated by damping and friction of all contacts and joints, including removed ones
    /// `[J]`. It never decreases.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        let contacts = self.contacts.iter().chain([&self.gone.contacts]);
        let joints = self.joints.iter().chain([&self.gone.joints]);
        contacts.map(|entry| entry.dissipated).sum::<f64>()
            + joints.map(|entry| entry.dissipated).sum::<f64>()
    }

    /// Adds the ledgers of removed elements of `old` to [`gone`](Self::gone), given their indices; of the fields, those
    /// beyond its own number. Returns the energy
    /// stored in them `[J]`.
    pub(crate) fn take_leave(
        &mut self,
        old: &Self,
        contacts: impl Iterator<Item = usize>,
        bodies: impl Iterator<Item = usize>,
        joints: impl Iterator<Item = usize>,
    ) -> f64 {
        let mut stored = 0.0;
        for number in contacts {
            let entry = &old.contacts[number];
            stored += entry.stored;
            self.gone.add_contact(entry);
        }
        for number in bodies {
            self.gone.add_body(&old.bodies[number]);
        }
        for number in joints {
            let entry = &old.joints[number];
            stored += entry.stored;
            self.gone.add_joint(entry);
        }
        for entry in old.fields.iter().skip(self.fields.len()) {
            stored += entry.stored;
            self.gone.add_field(entry);
        }
        stored
    }

    /// Returns the energy generated by held forces `[J]`; negative if they absorbed more than contacts and damping
    /// explain.
    ///
    /// ```text
    /// port work of all devices + carried - work of contacts and fields on their avatars + observed + step errors
    /// ```
    ///
    /// By the other identities it equals the total gain of hands, bodies, contacts and dissipation minus the external
    /// energy. A force without a contact, such as that of a virtual damper, is included through its port work.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts: f64 = self.contacts.iter().map(ContactLedger::created).sum();
        let fields: f64 = self.fields.iter().map(FieldLedger::created).sum();
        self.at_ports() + contacts + fields + self.created_otherwise()
    }

    /// Returns the work at the ports of all devices `[J]`.
    pub(crate) fn at_ports(&self) -> f64 {
        let devices = self.devices.iter();
        devices.map(|entry| entry.port_work + entry.carried).sum()
    }

    /// Returns the energy generated by sub-steps of bodies and joints, and by removed contacts and fields `[J]`.
    pub(crate) fn created_otherwise(&self) -> f64 {
        let gone = &self.gone;
        let bodies = self.bodies.iter().chain([&gone.bodies]);
        let joints = self.joints.iter().chain([&gone.joints]);
        gone.contacts.created()
            + gone.fields.created()
            + bodies.map(|entry| entry.step_error).sum::<f64>()
            + joints.map(|entry| entry.step_error).sum::<f64>()
    }
}

/// Energy generated at the ports of the devices. Each contact and field is weighted by the fraction of its force that
/// reached the device after limiting.
#[derive(Clone, Debug)]
pub(crate) struct CreatedAtPorts {
    /// Energy generated by the own force of each contact, then of each field, up to the last sample `[J]`.
    sources: Vec<f64>,
    others: f64,
    ports: f64,
    created: f64,
}

impl CreatedAtPorts {
    /// Creates a ledger with zero entries.
    pub fn none(sources: usize) -> Self {
        Self {
            sources: vec![0.0; sources],
            others: 0.0,
            ports: 0.0,
            created: 0.0,
        }
    }

    /// Continues with other `ledger` of the same number of contacts and fields, from `created` `[J]`. It does not allocate.
    pub fn resume(&mut self, ledger: &EnergyLedger, created: f64) {
        let contacts = ledger.contacts.iter().map(ContactLedger::created);
        let sources = contacts.chain(ledger.fields.iter().map(FieldLedger::created));
        for (before, created) in self.sources.iter_mut().zip(sources) {
            *before = created;
        }
        self.others = ledger.created_otherwise();
        self.ports = ledger.at_ports();
        self.created = created;
    }

    /// Updates the sum at a sample. `sources`: index of each contact or field with a changed entry, the energy that it generated,
    /// and the fraction of its force that reached the device since the last sample. `ports`: work at the ports.
    /// `others`: energy generated otherwise, with its `part` `[J]`.
    pub fn close(
        &mut self,
        sources: impl Iterator<Item = (usize, f64, f64)>,
        ports: f64,
        (others, part): (f64, f64),
    ) {
        for (number, now, part) in sources {
            let before = &mut self.sources[number];
            self.created += part * (now - *before);
            *before = now;
        }
        self.created += ports - self.ports + part * (others - self.others);
        (self.ports, self.others) = (ports, others);
    }

    /// Returns the generated energy `[J]`.
    pub fn created(&self) -> f64 {
        self.created
    }
}
