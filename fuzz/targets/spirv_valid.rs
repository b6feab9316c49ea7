//! Modules that Khronos' validator accepts are accepted by it when they are changed. The input is that of `spirv`; without
//! the program `spirv-val` this target ends at once.
#![no_main]

use cupola::correct::projected::division::Input;
use cupola::intercept::vk::projected_vertices::{Limits, divide, stage_outputs};
use cupola::intercept::vk::spirv::{camera_matrices, frag_coord, splice, texels};
use spirv::ExecutionModel;
use std::io::Write;
use std::process::{Command, Stdio};

/// What the validator says against a module; `None` if nothing.
fn wrong(words: &[u32]) -> Option<String> {
    let mut run = Command::new("spirv-val")
        .args(["--target-env", "vulkan1.3", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("spirv-val: package spirv-tools");
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    // It may end before it has read everything.
    let _ = run.stdin.take().expect("a pipe").write_all(&bytes);
    let output = run.wait_with_output().expect("it ends");
    let said = [output.stdout, output.stderr].concat();
    (!output.status.success()).then(|| String::from_utf8_lossy(&said).into_owned())
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let (chunks, _) = bytes.as_chunks::<4>();
    let words: Vec<u32> = chunks.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let models = [ExecutionModel::Vertex, ExecutionModel::TessellationEvaluation, ExecutionModel::Geometry];
    let mut made = Vec::new();
    made.extend(splice(&words, models[usize::from(kind & 3) % 3], "main", 3, kind & 4 != 0));
    made.extend(frag_coord(&words, "main", 3, 64).ok().flatten());
    made.extend(texels(&words, "main", 3, 64).ok().flatten().map(|followed| followed.words));
    for stage in [ExecutionModel::Fragment, ExecutionModel::Vertex] {
        made.extend(camera_matrices(&words, stage, "main", 3, 208).ok().flatten().map(|chosen| chosen.words));
    }
    if let Ok(outputs) = stage_outputs((&words, ExecutionModel::Vertex, "main"), None) {
        let limits = Limits { vertices: 256, all_components: 1024, components: [64, 128], runs: 32 };
        made.extend(divide(Input::Triangles, &outputs, u32::from(kind >> 4 & 1), 3, kind & 32 != 0, &limits));
    }
    if made.is_empty() || wrong(&words).is_some() {
        return;
    }
    for module in made {
        if let Some(why) = wrong(&module) {
            panic!("{why}");
        }
    }
});
