//! Checks that the committed header equals the header generated from the sources. `PALPATE_WRITE_HEADER=1 cargo test
//! --test header` writes it.

use std::fs;
use std::path::Path;

#[test]
fn the_header_is_what_the_sources_make() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config);
    let header = builder.with_src(folder.join("src/lib.rs")).generate();
    let mut made = Vec::new();
    header.unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = folder.join("include/palpate.h");
    if std::env::var_os("PALPATE_WRITE_HEADER").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let checked_in = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        made == checked_in,
        "include/palpate.h is not up to date: PALPATE_WRITE_HEADER=1 cargo test --test header writes it"
    );
}
