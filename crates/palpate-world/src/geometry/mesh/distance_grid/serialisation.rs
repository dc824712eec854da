//! Serialisation of a grid, which takes long to compute.

use super::super::build::Mesh;
use super::super::tree::size;
use super::{DistanceGrid, GridError, Nodes};
use crate::geometry::rigid::Vector3;

/// Fault of serialised grid data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridBytesError {
    /// The data are not a grid.
    #[error("it is not a distance grid of palpate: its first bytes are wrong")]
    NotAGrid,
    /// The data are truncated or corrupted.
    #[error("the distance grid is truncated or corrupted: its length or its checksum is wrong")]
    Broken,
}

/// Magic bytes at the start of a grid.
const MAGIC: &[u8] = b"palpate distance grid 1\n";
/// Size of the header after the magic: nine numbers of eight bytes.
const HEADER: usize = 9 * 8;

/// 64-bit FNV-1a hash (Fowler, Noll, Vo).
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Returns the hash of all inputs of a grid.
pub(super) fn fingerprint(mesh: &Mesh, spacing: f64) -> u64 {
    let mut of = Fnv::new();
    of.take(&spacing.to_le_bytes());
    for vertex in mesh.places() {
        for x in vertex.iter() {
            of.take(&x.to_le_bytes());
        }
    }
    for corner in mesh.faces().iter().flatten() {
        of.take(&corner.to_le_bytes());
    }
    of.0
}

impl DistanceGrid {
    /// Serialises the grid for storage with the mesh, because computing it takes long.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let nodes = &*self.nodes;
        let mut bytes = Vec::with_capacity(MAGIC.len() + HEADER + 4 * nodes.coefficients.len() + 8);
        bytes.extend(MAGIC);
        bytes.extend(nodes.made_from.to_le_bytes());
        let numbers = [
            nodes.spacing,
            nodes.least.x,
            nodes.least.y,
            nodes.least.z,
            nodes.error.largest,
            nodes.error.root_mean_square,
        ];
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        let counts = nodes.counts.map(size);
        bytes.extend(counts.iter().flat_map(|count| count.to_le_bytes()));
        bytes.extend([0; 4]);
        let coefficients = nodes.coefficients.iter();
        bytes.extend(coefficients.flat_map(|number| number.to_le_bytes()));
        let mut sum = Fnv::new();
        sum.take(&bytes);
        bytes.extend(sum.0.to_le_bytes());
        bytes
    }

    /// Restores a grid from the data of [`to_bytes`](Self::to_bytes) if it belongs to this mesh and spacing `[m]`, or
    /// returns `None` if it does not.
    ///
    /// # Errors
    /// The data are not a complete grid.
    pub fn from_bytes(
        bytes: &[u8],
        mesh: &Mesh,
        spacing: f64,
    ) -> Result<Option<Self>, GridBytesError> {
        let after = bytes.strip_prefix(MAGIC).ok_or(GridBytesError::NotAGrid)?;
        let (before, sum) = bytes
            .split_last_chunk::<8>()
            .ok_or(GridBytesError::Broken)?;
        let mut of = Fnv::new();
        of.take(before);
        if of.0 != u64::from_le_bytes(*sum) || after.len() < HEADER + 8 {
            return Err(GridBytesError::Broken);
        }
        let (header, rest) = after.split_at(HEADER);
        let eight =
            |number: usize| -> [u8; 8] { std::array::from_fn(|byte| header[8 * number + byte]) };
        let number = |place: usize| f64::from_le_bytes(eight(place));
        let count = |place: usize| -> usize {
            let from = 7 * 8 + 4 * place;
            u32::from_le_bytes(std::array::from_fn(|byte| header[from + byte])) as usize
        };
        let counts = [0, 1, 2].map(count);
        let all = counts
            .iter()
            .try_fold(4_usize, |product, &count| product.checked_mul(count));
        if all != Some(rest.len() - 8) || counts.iter().any(|&count| count < 4) {
            return Err(GridBytesError::Broken);
        }
        let made_from = u64::from_le_bytes(eight(0));
        if made_from != fingerprint(mesh, spacing) {
            return Ok(None);
        }
        let coefficients = rest[..rest.len() - 8].chunks_exact(4);
        let nodes = Nodes {
            made_from,
            spacing,
            least: Vector3::new(number(2), number(3), number(4)),
            counts,
            coefficients: coefficients
                .map(|bytes| f32::from_le_bytes(std::array::from_fn(|byte| bytes[byte])))
                .collect(),
            error: GridError {
                largest: number(5),
                root_mean_square: number(6),
            },
        };
        Ok(Some(Self::in_its_own_axes(nodes)))
    }
}
