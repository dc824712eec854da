//! `palpate map merge`.

use std::fs::File;
use std::path::PathBuf;

use palpate_record::map::{Map, merge};

use super::arguments::MergeArguments;
use super::deliver;
use super::files::Files;
use crate::failure::Failure;
use crate::values::Methods;
use palpate_plot::map;

/// Joins parts into a whole map.
pub fn run(arguments: &MergeArguments) -> Result<(), Failure> {
    let results = &arguments.results;
    let mut files = Files::new(results)?;
    files.protect(&arguments.parts);
    // A single file is a whole map or an error; it is not copied without a request.
    let beside = match (&results.out, &arguments.parts[..]) {
        (None, [whole]) => whole.clone(),
        (out, _) => {
            let out = out.clone().unwrap_or_else(|| PathBuf::from("map.csv"));
            files.join(&out)?;
            out
        }
    };
    let plot = results.plot.clone();
    let plot = plot.unwrap_or_else(|| beside.with_extension("svg"));
    files.show(results, Some(plot), false)?;
    let mut parts = Vec::new();
    for path in &arguments.parts {
        let name = path.display().to_string();
        let file = File::open(path)
            .map_err(|error| Failure::System(format!("cannot read part `{name}`: {error}")))?;
        palpate_record::files::inputs::note(path);
        let part = Map::read(file, &name).map_err(Failure::input)?;
        parts.push((name, part));
    }
    let map = merge(parts).map_err(Failure::input)?;
    let methods = arguments.method.as_ref();
    map::quantities(&map, &results.show)?;
    map::columns(&map, methods.map(|Methods(methods)| &methods[..]))?;
    files.write_map(&map)?;
    deliver((results, methods), &map, &files, None)
}
