//! Recorded curves besides the motion.

/// Recorded curves, tick by tick.
#[derive(Clone, Debug, Default)]
pub struct RecordedCurves {
    /// Time `[s]`.
    pub time: Vec<f64>,
    /// Device position `[m]`.
    pub device_position: Vec<f64>,
    /// Object position `[m]`.
    pub object_position: Vec<f64>,
    /// Actually held force on the object `[N]`.
    pub force_on_object: Vec<f64>,
    /// Leak of the held force since the first tick `[J]`.
    pub held_leak: Vec<f64>,
}

impl RecordedCurves {
    /// Shifts the time so that it counts from `start` `[s]`.
    pub fn count_from(&mut self, start: f64) {
        self.time.iter_mut().for_each(|time| *time -= start);
    }
}
