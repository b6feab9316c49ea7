#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(levels) = cupola::formats::pictures::levels::read("file", bytes) {
        assert_eq!(u64::from(levels.size.0) * u64::from(levels.size.1), levels.values.len() as u64);
    }
});
