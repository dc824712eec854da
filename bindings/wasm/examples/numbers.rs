//! Prints every number of a run on this machine: `cargo run --example numbers -- SCENE.toml`.

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: numbers SCENE.toml")?;
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
    let numbers = palpate_wasm::numbers(&text)?;
    std::io::Write::write_all(&mut std::io::stdout(), numbers.as_bytes())?;
    Ok(())
}
