//! `palpate map merge`.

use std::fs::File;
use std::path::PathBuf;

use palpate_io::map::{Map, merge};

use super::arguments::MergeArguments;
use super::deliver;
use crate::failure::Failure;

/// Joins parts into a whole map.
pub fn run(arguments: &MergeArguments) -> Result<(), Failure> {
    let results = &arguments.results;
    results.check()?;
    let mut parts = Vec::new();
    for path in &arguments.parts {
        let name = path.display().to_string();
        let file = File::open(path)
            .map_err(|error| Failure::System(format!("cannot read part `{name}`: {error}")))?;
        let part = Map::read(file, &name).map_err(Failure::input)?;
        parts.push((name, part));
    }
    let map = merge(parts).map_err(Failure::input)?;
    let out = results
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from("map.csv"));
    palpate_io::atomic::write(&out, |writer| map.write(writer))
        .map_err(|error| Failure::System(error.to_string()))?;
    deliver(results, &map, &out, None, true)
}
