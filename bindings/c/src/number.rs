//! The number type of a tick: `double` or `float` of C.

use palpate::Scalar;

/// A number that a tick can be made of, with what C calls the structs that are made of it.
pub trait Number: Scalar {
    /// A sample.
    const SAMPLE: &'static str;
    /// What comes out of a tick.
    const OUTPUT: &'static str;
    /// The books.
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
