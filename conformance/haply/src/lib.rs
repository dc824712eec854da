//! Holds only the tests in `tests/`.
