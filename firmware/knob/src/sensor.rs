//! Conversion of 16-bit counts to a position that does not wrap.

/// A position sensor whose counter has 16 bits and wraps.
#[derive(Clone, Copy, Debug)]
pub struct Sensor {
    metres_per_count: f32,
    last: Option<u16>,
    counts: i32,
}

impl Sensor {
    /// Creates a sensor of `metres_per_count` at the rim `[m]`.
    pub fn new(metres_per_count: f32) -> Self {
        Self {
            metres_per_count,
            last: None,
            counts: 0,
        }
    }

    /// Returns the position of the rim `[m]` at `count`. The first count is absolute, -32768 to 32767; each later one
    /// is less than half a turn of the counter from the previous one.
    pub fn position(&mut self, count: u16) -> f32 {
        let moved = match self.last {
            None => count.cast_signed(),
            Some(last) => count.wrapping_sub(last).cast_signed(),
        };
        self.last = Some(count);
        self.counts = self.counts.wrapping_add(i32::from(moved));
        self.counts as f32 * self.metres_per_count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_that_wraps_does_not_move_the_rim() {
        let mut sensor = Sensor::new(1.0);
        assert_eq!(sensor.position(32_767), 32_767.0);
        assert_eq!(sensor.position(32_769), 32_769.0);
        assert_eq!(sensor.position(65_535), 65_535.0);
        assert_eq!(sensor.position(3), 65_539.0);
        assert_eq!(sensor.position(65_535), 65_535.0);
    }

    #[test]
    fn the_first_count_is_absolute() {
        assert_eq!(Sensor::new(0.5).position(65_535), -0.5);
    }
}
