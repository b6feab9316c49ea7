//! The first byte says which stage and dialect; the text of a shader follows.
#![no_main]

use cupola::intercept::gl::projected_vertices::{carry, read_interface};
use cupola::intercept::gl::shader::source::patch::{Stage, has_main, mentions, patch, strip_comments};
use cupola::intercept::gl::shader::source::prover::prove;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, text)) = bytes.split_first() else { return };
    let Ok(text) = std::str::from_utf8(text) else { return };
    let stage = [Stage::Vertex, Stage::TessellationEvaluation, Stage::Geometry][usize::from(kind & 3) % 3];
    let (es, curved) = (kind & 4 != 0, kind & 8 != 0);
    let bare = strip_comments(text);
    assert_eq!(bare.len(), text.len(), "offsets stay");
    if let Some(patched) = patch(text, stage, es, curved) {
        assert!(has_main(text));
        // Every line of the program's is still there, in its order.
        let mut ours = patched.lines();
        for line in text.lines().map(|line| line.trim_end_matches('\r')) {
            assert!(ours.any(|own| own.trim_end_matches('\r') == line), "a line is lost: {line:?}");
        }
    }
    let _ = mentions(text, "ftransform");
    let _ = prove(text, es);
    if let Ok(mut interface) = read_interface(&bare) {
        let _ = interface.add_texture_coordinates(&bare);
        let _ = interface.edited(&bare);
        let _ = carry(&bare, &interface);
    }
});
