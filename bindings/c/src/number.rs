//! Number type of a tick: `double` or `float` in C.

use palpate_core::Scalar;

/// A number type of a tick, with the C names of its structs.
pub trait Number: Scalar {
    /// C name of the sample struct.
    const SAMPLE: &'static str;
    /// C name of the output struct.
    const OUTPUT: &'static str;
    /// C name of the energy ledger struct.
    const LEDGER: &'static str;
}

impl Number for f64 {
    const SAMPLE: &'static str = "palpate_sample";
    const OUTPUT: &'static str = "palpate_output";
    const LEDGER: &'static str = "palpate_ledger";
}

impl Number for f32 {
    const SAMPLE: &'static str = "palpate_sample_f32";
    const OUTPUT: &'static str = "palpate_output_f32";
    const LEDGER: &'static str = "palpate_ledger_f32";
}
