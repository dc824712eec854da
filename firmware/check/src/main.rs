//! The output of `firmware/run`: `trace`, `samples`, `table` and `figure FILE`.
#![allow(clippy::print_stdout)] // its output is what it is for

use std::error::Error;

#[cfg(feature = "figure")]
use palpate_firmware_check::drawn;
use palpate_firmware_check::{counted, trace};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["trace"] => print!("{}", trace::recorded()?),
        ["samples"] => print!("{}", trace::in_c()),
        ["table"] => print!("{}", counted::table()?),
        #[cfg(feature = "figure")]
        ["figure", file] => {
            std::fs::write(file, drawn::figure()?)?;
            println!("wrote {file}");
        }
        _ => return Err("say what to do: trace, samples, table or figure FILE".into()),
    }
    Ok(())
}
