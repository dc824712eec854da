//! Holds only the test in `tests/`.
