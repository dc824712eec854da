//! A checksum that detects incomplete text.

/// FNV-1a, 64 bits. It detects accidental damage, not tampering.
#[derive(Clone, Debug)]
pub struct Checksum(u64);

impl Default for Checksum {
    fn default() -> Self {
        Self::new()
    }
}

impl Checksum {
    /// Creates the checksum of an empty text.
    #[must_use]
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Appends bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Returns the checksum as 16 hexadecimal digits.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{:016x}", self.0)
    }

    /// Returns the digits of a whole text.
    #[must_use]
    pub fn of(text: &str) -> String {
        let mut checksum = Self::new();
        checksum.add(text.as_bytes());
        checksum.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values() {
        assert_eq!(Checksum::of(""), "cbf29ce484222325");
        assert_eq!(Checksum::of("a"), "af63dc4c8601ec8c");
        assert_eq!(Checksum::of("foobar"), "85944171f73967e8");
    }
}
