//! Values on the command line that several subcommands take.

use cupola::rig::Favour;

/// Parses a size in pixels such as `1920x1080`.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X', '×']);
    let pixels = |part: &str| part.trim().parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
    parts
        .and_then(|(width, height)| Some((pixels(width)?, pixels(height)?)))
        .ok_or_else(|| "expected WIDTHxHEIGHT in pixels, each from 1 to 16384, for example 1920x1080".to_owned())
}

/// Parses `cpu` or `gpu`, what a plan is to save.
pub fn favour(text: &str) -> Result<Favour, String> {
    match text {
        "cpu" => Ok(Favour::Processor),
        "gpu" => Ok(Favour::Graphics),
        _ => Err("expected cpu or gpu".to_owned()),
    }
}
