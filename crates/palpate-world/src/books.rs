//! The books of a world's energy.

/// Energy at the contact of a pair, over all intervals that have ended `[J]`.
///
/// ```text
/// stored = stored at the start + observed + outside + handed - work - dissipated + step_error
/// leak   = held - work_on_avatar
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactBook {
    /// K p^2/2 + k_t |z|^2/2 at the last sample.
    pub stored: f64,
    /// What damping and friction took: never falls.
    pub dissipated: f64,
    /// Work of the contact on both of its sides.
    pub work: f64,
    /// W_c: work of the contact on the tool's avatar, if one of its sides is a tool.
    pub work_on_avatar: f64,
    /// Work of the contact's mean force on the device itself.
    pub held: f64,
    /// What the stored energy changed by because a sample put the avatar to another place than it was expected at, or
    /// a limit did.
    pub observed: f64,
    /// What changes of the running world have put into it.
    pub outside: f64,
    /// What came from the other points of the same pair, where two boxes touch by another face than before: the sum over
    /// the pair is 0.
    pub handed: f64,
    /// What finite sub-steps have made (positive) or lost.
    pub step_error: f64,
}

impl ContactBook {
    /// Energy that holding the mean of the force has given to the hand beyond the contact's own work `[J]`.
    #[must_use]
    pub fn leak(&self) -> f64 {
        self.held - self.work_on_avatar
    }

    /// Energy that is stored or was given away beyond the work on the tool's avatar, and that nobody put in `[J]`.
    pub(crate) fn created(&self) -> f64 {
        self.observed + self.step_error - self.work_on_avatar
    }
}

/// Energy of a joint, over all intervals that have ended `[J]`.
///
/// ```text
/// stored = the same at the start + outside - work - dissipated + step_error
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct JointBook {
    /// Energy of its springs at the last sample.
    pub stored: f64,
    /// What damping took: never falls.
    pub dissipated: f64,
    /// Work of the joint on both of its sides.
    pub work: f64,
    /// What changes of the running world have put into it.
    pub outside: f64,
    /// What finite sub-steps have made (positive) or lost.
    pub step_error: f64,
}

/// Energy of a body, over all intervals that have ended `[J]`.
///
/// ```text
/// kinetic + potential = the same at the start + work + outside + step_error
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BodyBook {
    /// Kinetic energy at the last sample.
    pub kinetic: f64,
    /// Less the work of its constant force since the start.
    pub potential: f64,
    /// Work of contacts and joints on it.
    pub work: f64,
    /// What changed it from outside: waiting for a sample that can be used, and changes of the running world.
    pub outside: f64,
    /// What finite sub-steps have made (positive) or lost.
    pub step_error: f64,
}

/// Energy at the port of a device, over all intervals that have ended `[J]`. Positive: to the hand.
///
/// ```text
/// port_work + carried  = held + unforeseen
/// held - work on avatar = offset - velocity_offset + unpaid      the contacts' leaks, where a force moves the device
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceBook {
    /// Work of the force that was held on the device as it was measured.
    pub port_work: f64,
    /// Work that no motor gives. Along the axes that the device lacks ([`Tool::axes`](crate::Tool::axes)) it is that of the
    /// contacts' mean force, which the mechanism carries: 0 while the tool stays where it is along them. Of a tool that its hand
    /// turns ([`Tool::turned_by_hand`](crate::Tool::turned_by_hand)) it is that of the contacts' torques, against which the hand
    /// turns it.
    pub carried: f64,
    /// Sum of the contacts' [`ContactBook::held`].
    pub held: f64,
    /// What the port's work differs by: the force that was held less the mean of the contacts as it was then known
    /// to be, and the device's path by its samples less that by the observer.
    pub unforeseen: f64,
    /// Work of the hand on the avatar less that on the device: F_u times the offset where F_u is constant
    /// and the force is held.
    pub offset: f64,
    /// By how much more kinetic energy the avatar has gained than the device.
    pub velocity_offset: f64,
    /// Work that the contacts' mean force does on the device and the force that was asked for does not.
    pub unpaid: f64,
    /// Work of the hand on the offset as it went back to zero, while nothing touched the tool.
    pub walked_back: f64,
}

/// The books of a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Books {
    /// Of each pair with a law that can touch, in the order of [`WorldState::contacts`](crate::WorldState::contacts).
    pub contacts: Vec<ContactBook>,
    /// Of each body, in the world's order; zero for fixed ones.
    pub bodies: Vec<BodyBook>,
    /// Of each joint, in the world's order.
    pub joints: Vec<JointBook>,
    /// Of each device, in the order of the tools.
    pub devices: Vec<DeviceBook>,
    /// Of what changes of the running world have taken out of it.
    pub gone: Gone,
}

/// Sums of the books of what is gone from a world. What it had when it went is taken out as outside work, so that nothing
/// is stored there and nothing moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Gone {
    /// Of all contacts that are gone.
    pub contacts: ContactBook,
    /// Of all bodies.
    pub bodies: BodyBook,
    /// Of all joints.
    pub joints: JointBook,
}

impl Gone {
    fn add_contact(&mut self, book: &ContactBook) {
        let sum = &mut self.contacts;
        sum.dissipated += book.dissipated;
        sum.work += book.work;
        sum.work_on_avatar += book.work_on_avatar;
        sum.held += book.held;
        sum.observed += book.observed;
        sum.outside += book.outside - book.stored;
        sum.handed += book.handed;
        sum.step_error += book.step_error;
    }

    fn add_body(&mut self, book: &BodyBook) {
        let sum = &mut self.bodies;
        sum.potential += book.potential;
        sum.work += book.work;
        sum.outside += book.outside - book.kinetic;
        sum.step_error += book.step_error;
    }

    fn add_joint(&mut self, book: &JointBook) {
        let sum = &mut self.joints;
        sum.dissipated += book.dissipated;
        sum.work += book.work;
        sum.outside += book.outside - book.stored;
        sum.step_error += book.step_error;
    }
}

impl Books {
    /// Sum of what the contacts' stored energy changed by from outside `[J]`.
    pub(crate) fn observed(&self) -> f64 {
        self.contacts.iter().map(|book| book.observed).sum()
    }

    /// Energy that damping and friction of all contacts and joints took, of those that are gone too `[J]`: never falls.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        let contacts = self.contacts.iter().chain([&self.gone.contacts]);
        let joints = self.joints.iter().chain([&self.gone.joints]);
        contacts.map(|book| book.dissipated).sum::<f64>()
            + joints.map(|book| book.dissipated).sum::<f64>()
    }

    /// Sums up what is gone of the `old` books: what none of the new ones has come from. The energy that was stored there
    /// `[J]`.
    pub(crate) fn take_leave(
        &mut self,
        old: &Self,
        contacts: &[Option<usize>],
        bodies: &[Option<usize>],
        joints: &[Option<usize>],
    ) -> f64 {
        let is_gone = |from: &[Option<usize>], number| !from.contains(&Some(number));
        let mut stored = 0.0;
        for (number, book) in old.contacts.iter().enumerate() {
            if is_gone(contacts, number) {
                stored += book.stored;
                self.gone.add_contact(book);
            }
        }
        for (number, book) in old.bodies.iter().enumerate() {
            if is_gone(bodies, number) {
                self.gone.add_body(book);
            }
        }
        for (number, book) in old.joints.iter().enumerate() {
            if is_gone(joints, number) {
                stored += book.stored;
                self.gone.add_joint(book);
            }
        }
        stored
    }

    /// Energy that held forces created `[J]`; negative where they took more than contacts and damping account for.
    ///
    /// ```text
    /// port work of all devices + carried - work of the contacts on their avatars + observed + step errors
    /// ```
    ///
    /// By the other identities it is what hands, bodies, contacts and dissipation have gained together, and nobody has
    /// put in. A force that is no contact's, such as that of a virtual damper, counts by its port work.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts: f64 = self.contacts.iter().map(ContactBook::created).sum();
        self.at_ports() + contacts + self.created_otherwise()
    }

    /// Work at the ports of all devices `[J]`.
    pub(crate) fn at_ports(&self) -> f64 {
        let devices = self.devices.iter();
        devices.map(|book| book.port_work + book.carried).sum()
    }

    /// Energy that sub-steps of bodies and joints created, and contacts that are gone `[J]`.
    pub(crate) fn created_otherwise(&self) -> f64 {
        let gone = &self.gone;
        let bodies = self.bodies.iter().chain([&gone.bodies]);
        let joints = self.joints.iter().chain([&gone.joints]);
        gone.contacts.created()
            + bodies.map(|book| book.step_error).sum::<f64>()
            + joints.map(|book| book.step_error).sum::<f64>()
    }
}

/// Energy that forces created at the ports of the devices, as they reached these. A contact whose force reached its device by a
/// part, because a limit cut it, counts by that part.
#[derive(Clone, Debug)]
pub(crate) struct CreatedAtPorts {
    /// Of each contact what its own force had created, up to the last sample `[J]`.
    contacts: Vec<f64>,
    others: f64,
    ports: f64,
    created: f64,
}

impl CreatedAtPorts {
    /// Nothing is created yet.
    pub fn none(contacts: usize) -> Self {
        Self {
            contacts: vec![0.0; contacts],
            others: 0.0,
            ports: 0.0,
            created: 0.0,
        }
    }

    /// Continues with other `books`, of as many contacts, at `created` `[J]`. It does not allocate.
    pub fn go_on(&mut self, books: &Books, created: f64) {
        for (before, book) in self.contacts.iter_mut().zip(&books.contacts) {
            *before = book.created();
        }
        self.others = books.created_otherwise();
        self.ports = books.at_ports();
        self.created = created;
    }

    /// Takes the books at a sample: of each contact what it created, and by which part its force reached its device since the last
    /// sample; the work at the ports; and what was created otherwise, with such a part `[J]`.
    pub fn close(
        &mut self,
        contacts: impl Iterator<Item = (f64, f64)>,
        ports: f64,
        (others, part): (f64, f64),
    ) {
        for (before, (now, part)) in self.contacts.iter_mut().zip(contacts) {
            self.created += part * (now - *before);
            *before = now;
        }
        self.created += ports - self.ports + part * (others - self.others);
        (self.ports, self.others) = (ports, others);
    }

    /// What it has come to be `[J]`.
    pub fn created(&self) -> f64 {
        self.created
    }
}
