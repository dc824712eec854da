//! Tests only; see `tests/told.rs`.
