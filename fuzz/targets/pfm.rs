#![no_main]

use cupola::formats::pictures::pfm;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(raster) = pfm::read("file", bytes) {
        let again = pfm::read("file", &pfm::write(raster.size().0, raster.values())).expect("what was written");
        assert_eq!(again.size(), raster.size());
    }
});
