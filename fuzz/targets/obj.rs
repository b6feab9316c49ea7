#![no_main]

use cupola::geom::screen::{Faces, Mesh};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(triangles) = cupola::formats::obj::read("file", bytes, 1 << 10) {
        assert!(triangles.len() <= 1 << 10);
        let _ = Mesh::new(triangles, Faces::Both);
    }
});
