//! Instructions, stack and code size per method and core, from the output of the program `count`.

use std::error::Error;
use std::fmt::Write;
use std::fs;

use crate::qemu::{CORES, Core, Time};

/// Cost of one kind of ticks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counted {
    /// Method and scene: `coupled-block`.
    pub name: String,
    /// Median of the instructions per tick.
    pub median: u32,
    /// Largest number of instructions of a tick.
    pub largest: u32,
    /// The 99th percentile of them.
    pub percentile_99: u32,
    /// Deepest stack of a tick `[bytes]`.
    pub stack: u32,
}

/// Runs the program `count` or `count-in-c` on `core` and parses its counts.
///
/// # Errors
/// The program does not run, or its output is invalid.
pub fn counted(core: Core, program: &str) -> Result<Vec<Counted>, Box<dyn Error>> {
    let said = core.run(program, Time::Counted, &[])?;
    let mut names: Vec<&str> = Vec::new();
    let mut ticks: Vec<Vec<(u32, u32)>> = Vec::new();
    for line in said.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        if let ["count", name, _, _, instructions, stack] = words[..] {
            let at = names.iter().position(|known| *known == name);
            let at = at.unwrap_or_else(|| {
                names.push(name);
                ticks.push(Vec::new());
                names.len() - 1
            });
            ticks[at].push((instructions.parse()?, stack.parse()?));
        }
    }
    Ok(names
        .iter()
        .zip(ticks)
        .map(|(name, mut ticks)| {
            ticks.sort_unstable();
            let last = ticks.len() - 1;
            Counted {
                name: (*name).to_string(),
                median: ticks[last / 2].0,
                percentile_99: ticks[last * 99 / 100].0,
                largest: ticks[last].0,
                stack: ticks.iter().map(|tick| tick.1).max().unwrap_or(0),
            }
        })
        .collect())
}

/// Returns the loaded bytes of the program `name`: code, constants and the vector table.
///
/// # Errors
/// There is no such program, or it is not a 32-bit ELF file.
pub fn code_size(core: Core, name: &str) -> Result<u32, Box<dyn Error>> {
    let file = fs::read(core.program(name)?)?;
    let word = |at: usize| -> Option<u32> {
        Some(u32::from_le_bytes(file.get(at..at + 4)?.try_into().ok()?))
    };
    let half = |at: usize| -> Option<usize> {
        Some(usize::from(u16::from_le_bytes(
            file.get(at..at + 2)?.try_into().ok()?,
        )))
    };
    // The program headers of an ELF file: offset at 28, size and number at 42 and 44. Each header has its type at 0 (1:
    // loaded) and its size in the file at 16.
    let sizes = || -> Option<u32> {
        let (start, size, number) = (word(28)? as usize, half(42)?, half(44)?);
        let mut sum = 0;
        for header in (0..number).map(|index| start + index * size) {
            if word(header)? == 1 {
                sum += word(header + 16)?;
            }
        }
        Some(sum)
    };
    if !file.starts_with(b"\x7fELF\x01") {
        return Err(format!("{name} is no ELF file of 32 bits").into());
    }
    sizes().ok_or_else(|| format!("{name} ends within its headers").into())
}

/// Returns the table of the docs, in Markdown.
///
/// # Errors
/// As for [`counted`] and [`code_size`].
pub fn table() -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "| core, method | instructions per tick, median | 99 % | largest | stack, bytes | code, bytes |\n\
         |---|---:|---:|---:|---:|---:|\n",
    );
    for core in CORES {
        let nothing = code_size(core, "size")?;
        for counted in counted(core, "count")? {
            let (method, scene) = counted.name.split_once('-').ok_or("a name without scene")?;
            // The knob's tick includes more than a method.
            let code = match scene {
                "knob" => String::new(),
                _ => (code_size(core, &format!("size-{method}"))? - nothing).to_string(),
            };
            writeln!(
                text,
                "| {}, {method}, {scene} | {} | {} | {} | {} | {code} |",
                core.name, counted.median, counted.percentile_99, counted.largest, counted.stack
            )?;
        }
        // Without a C compiler there are no rows of the C program.
        if core.program("count-in-c")?.exists() {
            for counted in counted(core, "count-in-c")? {
                writeln!(
                    text,
                    "| {}, {}, from C | {} | {} | {} | | |",
                    core.name,
                    counted.name.replacen('-', ", ", 1),
                    counted.median,
                    counted.percentile_99,
                    counted.largest
                )?;
            }
        }
    }
    Ok(text)
}
