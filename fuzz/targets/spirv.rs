//! The first byte says which stage and options; the words of a module follow.
#![no_main]

use cupola::correct::projected::division::Input;
use cupola::intercept::vk::projected_vertices::{Limits, divide, stage_outputs};
use cupola::intercept::vk::spirv::{asks_place, camera_matrices, frag_coord, matrices, splice, texels};
use spirv::ExecutionModel;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let (chunks, _) = bytes.as_chunks::<4>();
    let words: Vec<u32> = chunks.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let models = [ExecutionModel::Vertex, ExecutionModel::TessellationEvaluation, ExecutionModel::Geometry];
    let model = models[usize::from(kind & 3) % 3];
    let _ = matrices(&words, kind & 64 != 0);
    let _ = asks_place(&words);
    if let Ok(spliced) = splice(&words, model, "main", 3, kind & 4 != 0) {
        assert!(spliced.len() >= words.len() && spliced.len() < words.len() + (1 << 14), "what is added is bounded");
    }
    if let Ok(Some(placed)) = frag_coord(&words, "main", 3, 64) {
        assert!(placed.len() >= words.len() && placed.len() < words.len() + (1 << 14), "what is added is bounded");
    }
    if let Ok(Some(followed)) = texels(&words, "main", 3, 64) {
        // Each place gets a few words.
        assert!(followed.words.len() >= words.len() && followed.words.len() < 12 * words.len() + (1 << 14));
    }
    let stage = if kind & 8 != 0 { ExecutionModel::Fragment } else { ExecutionModel::Vertex };
    if let Ok(Some(chosen)) = camera_matrices(&words, stage, "main", 3, 208) {
        assert!(chosen.words.len() >= words.len() && chosen.words.len() < words.len() + (1 << 14));
    }
    let fragment = (kind & 8 != 0).then_some((&words[..], ExecutionModel::Fragment, "main"));
    if let Ok(outputs) = stage_outputs((&words, ExecutionModel::Vertex, "main"), fragment) {
        let limits = Limits { vertices: 256, all_components: 1024, components: [64, 128], runs: 32 };
        let _ = divide(Input::Triangles, &outputs, u32::from(kind >> 4 & 1), 3, kind & 32 != 0, &limits);
    }
});
