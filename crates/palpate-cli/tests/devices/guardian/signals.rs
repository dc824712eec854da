//! The signals of Linux, and what each does to a loop.

/// What a signal does to a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Does {
    /// The loop ends by itself, with its report.
    Ends,
    /// The program is ended by it.
    Kills,
    /// The program stands still.
    Stops,
}

/// Every signal of Linux by its number, but for those that do nothing to a program: PIPE, CHLD, CONT,
/// URG, XFSZ, WINCH, and 32 and 33, which are the C library's own.
pub fn signals() -> Vec<(i32, Does)> {
    let ignored = [13, 17, 18, 23, 25, 28, 32, 33];
    (1..=64)
        .filter(|number| !ignored.contains(number))
        .map(|number| {
            let does = match number {
                // ILL, BUS, FPE, KILL, SEGV.
                4 | 7 | 8 | 9 | 11 => Does::Kills,
                19 => Does::Stops,
                _ => Does::Ends,
            };
            (number, does)
        })
        .collect()
}
