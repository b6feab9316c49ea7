//! Tests of the rig file as a whole; those of single values are in `tests/rig_rules.rs`.

#[test]
fn presets_load() {
    for preset in super::presets() {
        let rig = super::load(preset.name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(rig.name, preset.name);
    }
}
