//! A checksum that tells a whole text from a torn one.

/// FNV-1a, 64 bits: short, and enough against accidents; it protects from nobody.
#[derive(Clone, Debug)]
pub struct Checksum(u64);

impl Default for Checksum {
    fn default() -> Self {
        Self::new()
    }
}

impl Checksum {
    /// That of no bytes.
    #[must_use]
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds bytes after those before.
    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Sixteen hexadecimal digits.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{:016x}", self.0)
    }

    /// The digits of a whole text.
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
