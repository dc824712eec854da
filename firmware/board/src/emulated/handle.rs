//! The emulated handle: a rim of 50 g without friction, its motor and its sensor.

/// Mass at the rim `[kg]`.
pub const MASS: f32 = 0.05;
/// Displacement of the rim per count of the sensor `[m]`.
pub const METRES_PER_COUNT: f32 = 5e-6;
/// Force at the rim at full duty `[N]`.
pub const FULL_FORCE: f32 = 20.0;
/// Full duty.
pub const FULL_DUTY: i16 = 1000;
/// Step of the emulation `[s]`: 20 kHz.
pub const STEP: f32 = 0.000_05;

/// The rim.
#[derive(Clone, Copy, Debug)]
pub struct Handle {
    /// Position of the rim `[m]`; the wall is at 0, solid towards +.
    pub position: f32,
    /// Velocity of the rim `[m/s]`.
    pub velocity: f32,
    /// Work that the motor has done on the rim `[J]`.
    pub motor_work: f32,
    /// Work that the hand has done on the rim `[J]`.
    pub hand_work: f32,
}

impl Default for Handle {
    /// At rest, 5 mm in front of the wall.
    fn default() -> Self {
        Self {
            position: -0.005,
            velocity: 0.0,
            motor_work: 0.0,
            hand_work: 0.0,
        }
    }
}

impl Handle {
    /// Returns the sensor's count: 16 bits of the position, rounded down.
    pub fn count(&self) -> u16 {
        let counts = self.position / METRES_PER_COUNT + 32_768.0;
        // Within the counter's range while the rim is within 16 cm; beyond it, the count saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let counts = counts as u16;
        counts.wrapping_sub(32_768)
    }

    /// Advances by one [`STEP`] under the forces of motor and hand `[N]`, exactly.
    pub fn resume(&mut self, motor: f32, hand: f32) {
        let acceleration = (motor + hand) / MASS;
        let moved = (self.velocity + 0.5 * acceleration * STEP) * STEP;
        self.position += moved;
        self.velocity += acceleration * STEP;
        self.motor_work += motor * moved;
        self.hand_work += hand * moved;
    }
}
