//! What a rig that is valid makes the planner do, with pictures of few pixels.
#![no_main]

use cupola::views::Request;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let Ok(rig) = cupola::rig::parse(text, "rig.toml", Path::new("/nonexistent")) else { return };
    if rig.outputs.len() > 4 {
        return;
    }
    let output_sizes = vec![(24, 16); rig.outputs.len()];
    let request = Request { output_sizes, window: (48, 32), panel: false, primary: false, max_atlas: 2048 };
    if let Ok(plan) = cupola::correct::build(&rig, &request) {
        let _ = cupola::views::report(&plan.views, &rig, &request.output_sizes).to_string();
    }
});
