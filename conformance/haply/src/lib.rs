//! Contains only the tests in `tests/`.
