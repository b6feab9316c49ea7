#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = cupola::rig::parse(text, "rig.toml", Path::new("/nonexistent"));
});
