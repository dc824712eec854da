//! Claims of the paper, one test each.
//!
//! Each test names its source: an equation or a figure of *Energy-Consistent Haptic Rendering of Contact Forces* (IROS
//! 2013, DOI 10.1109/IROS.2013.6697005; "the paper"), a source the paper cites, or "derived here". A `DIFFERENCE` note
//! marks a departure from the letter of the paper; there are two, both in `closed_forms`.

mod trial;

mod acausal;
mod closed_forms;
mod colgate;
mod damping_estimate;
mod fidelity;
mod integrators;
mod leak_identity;
mod leak_order;
mod limits;
mod object_motion;
mod observers;
mod passivity;
mod readings;
mod robustness;
mod scenes;
mod wall;
