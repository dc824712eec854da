//! Convex solids with flat faces.

use crate::convex::{NoHull, Polygon, hull};
use crate::pairs::MOST_POINTS;
use crate::rigid::Vector3;

/// The least convex solid around some points: its corners and flat faces.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Corners {
    pub places: Vec<Vector3>,
    pub faces: Vec<Polygon>,
}

impl Corners {
    /// Of points, from which the solid may leave those out that are outside of it by no more than `within` `[m]`.
    pub fn around(points: &[Vector3], within: f64) -> Result<Self, NoHull> {
        let (places, faces) = hull(points, within, MOST_POINTS)?;
        Ok(Self { places, faces })
    }

    /// Corners of the face that has the most: a corner has the law of a contact over this, so that no face has more than
    /// the whole law.
    pub fn share(&self) -> f64 {
        let most = self.faces.iter().map(|face| face.corners.len()).max();
        most.unwrap_or(1) as f64
    }
}
