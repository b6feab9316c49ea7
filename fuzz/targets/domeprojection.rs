#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = cupola::formats::domeprojection::read("file", bytes);
});
