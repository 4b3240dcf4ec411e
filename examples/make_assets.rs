//! Makes the pictures in the folder `assets` that the program renders itself. Run it at the root of the repository:
//!
//! `cargo run --release --example make_assets -- balls` makes the balls of the library of materials, which takes minutes.

use std::error::Error;
use std::fs;

use sunroom::app::editor::picture::ball_picture::make_shipped;

fn main() -> Result<(), Box<dyn Error>> {
    match std::env::args().nth(1).as_deref() {
        Some("balls") => balls(),
        _ => Err("say what to make: balls".into()),
    }
}

fn balls() -> Result<(), Box<dyn Error>> {
    let (pictures, list) = make_shipped(|name| eprintln!("{name}"))?;
    fs::write("assets/library/balls.jpg", pictures)?;
    Ok(fs::write("assets/library/balls.txt", list)?)
}
