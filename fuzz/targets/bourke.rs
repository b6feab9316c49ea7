#![no_main]

use cupola::formats::bourke;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = bourke::read("file", bytes) {
        let _ = mesh.value.mesh("file");
    }
});
