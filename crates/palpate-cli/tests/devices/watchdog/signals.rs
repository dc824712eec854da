//! The signals of Linux, with their effects on a loop.

/// Effect of a signal on a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Does {
    /// The loop ends by itself, with its report.
    Ends,
    /// The signal kills the program.
    Kills,
    /// The program is suspended.
    Stops,
}

/// Returns every signal of Linux by its number, except those without effect on a program: PIPE, CHLD, CONT, URG, XFSZ,
/// WINCH, and 32 and 33, which the C library uses itself.
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
