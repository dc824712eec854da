//! What a recording has beside the motion.

/// What a recording has beside the motion, tick by tick.
#[derive(Clone, Debug, Default)]
pub struct RecordedCurves {
    /// Time `[s]`.
    pub time: Vec<f64>,
    /// Device position `[m]`.
    pub device_position: Vec<f64>,
    /// Object position `[m]`.
    pub object_position: Vec<f64>,
    /// Force on the object that was really held `[N]`.
    pub force_on_object: Vec<f64>,
    /// Leak of the held force since the first tick `[J]`.
    pub held_leak: Vec<f64>,
}

impl RecordedCurves {
    /// Lets time count from `start` `[s]`.
    pub fn count_from(&mut self, start: f64) {
        self.time.iter_mut().for_each(|time| *time -= start);
    }
}
