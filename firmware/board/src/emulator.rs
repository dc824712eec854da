//! Output to the emulator over semihosting: lines, the exit status, and panics.

use core::fmt::{self, Write};
use core::panic::PanicInfo;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::{heprintln, hio};

/// Longest line that is written in one piece `[bytes]`.
const LONGEST: usize = 256;

/// Buffer that writes a line in one piece: a call of the emulator costs far more than a byte.
pub struct Lines {
    line: [u8; LONGEST],
    filled: usize,
}

impl Default for Lines {
    fn default() -> Self {
        Self {
            line: [0; LONGEST],
            filled: 0,
        }
    }
}

impl Lines {
    fn say(&mut self) -> fmt::Result {
        let mut out = hio::hstdout().map_err(|()| fmt::Error)?;
        out.write_all(&self.line[..self.filled])
            .map_err(|()| fmt::Error)?;
        self.filled = 0;
        Ok(())
    }
}

impl Write for Lines {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.line[self.filled] = byte;
            self.filled += 1;
            if byte == b'\n' || self.filled == LONGEST {
                self.say()?;
            }
        }
        Ok(())
    }
}

/// Ends the emulator with 0 if all `is_well`, and with 1 if not.
pub fn exit(is_well: bool) -> ! {
    debug::exit(if is_well { EXIT_SUCCESS } else { EXIT_FAILURE });
    // The emulator has ended; on a board without one the program waits here.
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    exit(false)
}
