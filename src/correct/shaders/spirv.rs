//! The correction shaders as SPIR-V: modules generated from WGSL at build time, and their
//! specialisation.
//!
//! As in [`crate::correct::shaders::glsl`], the values of a pass are constants of the program. They
//! replace constants of a module and are no specialisation constants: naga does not write those,
//! and drivers fold plain constants at least as early.

use crate::correct::passes::view_images::Arrangement;
use crate::correct::shaders::constants::{Constants, MAX_VIEWS, Pass};
use crate::correct::shaders::glsl::Stage;

/// A program in two modules, ready for a pipeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Modules {
    /// The vertex stage, entry point [`VERTEX_ENTRY`]. Attributes as in
    /// [`crate::correct::shaders::glsl::Specialised`].
    pub vertex: &'static [u32],
    /// The fragment stage.
    pub fragment: Vec<u32>,
    /// Name of the fragment stage's entry point.
    pub fragment_entry: &'static std::ffi::CStr,
}

/// Name of the vertex stages' entry point.
pub const VERTEX_ENTRY: &std::ffi::CStr = c"rectangle_down";

/// Bindings of the shaders' resources, all in descriptor set 0.
pub mod binding {
    /// The atlas, a 2D image; the layers, a 2D array; or the image of the batch's first view.
    pub const ATLAS: u32 = 1;
    /// Sampler of the atlas.
    pub const ATLAS_SAMPLER: u32 = 2;
    /// The mask's weights, a 2D image.
    pub const MASK: u32 = 3;
    /// Sampler of the mask.
    pub const MASK_SAMPLER: u32 = 4;
    /// The table of directions and weights, a 2D image that is not filtered.
    pub const TABLE: u32 = 5;
    /// The images of the batch's other views, 2D, one after another: only for
    /// [`Arrangement::Images`](super::Arrangement).
    pub const IMAGES: std::ops::Range<u32> = 6..5 + super::MAX_VIEWS as u32;
    /// The picture of black, a 2D image.
    pub const BLACK: u32 = IMAGES.end;
}

struct PassModules {
    pass: Pass,
    /// True if the picture is content, not views.
    content: bool,
    arrangement: Arrangement,
    vertex: &'static [u32],
    fragments: &'static [FragmentModule],
}

struct FragmentModule {
    stage: Stage,
    words: &'static [u32],
    /// For each scalar of the constants: index of its word, and whether it is unsigned.
    slots: &'static [(usize, bool)],
}

include!(concat!(env!("OUT_DIR"), "/spirv.rs"));

/// Returns the program of `constants` for pictures in `arrangement`.
///
/// [`Pass::Black`] has only the stage [`Stage::Present`], which serves for every stage, and reads
/// no picture. [`Stage::Map`] always has the modules of an atlas.
pub fn specialise(constants: &Constants, arrangement: Arrangement, stage: Stage) -> Modules {
    let black = constants.pass() == Pass::Black;
    let stage = if black { Stage::Present } else { stage };
    let arrangement = if black || stage == Stage::Map { Arrangement::Atlas } else { arrangement };
    let content = constants.shows_content();
    let wanted = |modules: &&PassModules| {
        modules.pass == constants.pass() && modules.arrangement == arrangement && modules.content == content
    };
    // MODULES has an entry for each; the build script and a test make sure of that.
    let pass = MODULES.iter().find(wanted).unwrap_or(&MODULES[0]);
    let module = pass.fragments.iter().find(|module| module.stage == stage).unwrap_or(&pass.fragments[0]);
    let mut fragment = module.words.to_vec();
    for (&(at, unsigned), &value) in module.slots.iter().zip(constants.scalars()) {
        fragment[at] = if unsigned { value as u32 } else { value.to_bits() };
    }
    let fragment_entry = if stage == Stage::Map { c"map" } else { c"present" };
    Modules { vertex: pass.vertex, fragment, fragment_entry }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::shaders::constants::members;

    #[test]
    fn every_pass_has_its_modules_and_a_place_for_each_constant() {
        for pass in
            [Pass::Fisheye, Pass::Projector, Pass::Optics, Pass::Perspective, Pass::Table, Pass::Mesh, Pass::Black]
        {
            let scalars: usize = members(pass).iter().map(|member| member.1).sum();
            let found: Vec<&PassModules> = MODULES.iter().filter(|modules| modules.pass == pass).collect();
            assert_eq!(found.len(), if pass == Pass::Black { 1 } else { 6 });
            assert_eq!(found[0].fragments.len(), if pass == Pass::Black { 1 } else { 2 });
            for module in found.iter().flat_map(|modules| modules.fragments) {
                assert_eq!(module.slots.len(), scalars, "{pass:?}");
                let distinct: std::collections::BTreeSet<usize> = module.slots.iter().map(|slot| slot.0).collect();
                assert_eq!(distinct.len(), scalars);
                // SPIR-V's magic number and version 1.0.
                assert_eq!(module.words[..2], [0x0723_0203, 0x0001_0000]);
            }
        }
    }

    #[test]
    fn values_are_put_in_bit_by_bit() {
        let black = specialise(&Constants::black(), Arrangement::Layers, Stage::Map);
        assert_eq!(black.fragment_entry, c"present");
        let module = &MODULES[0].fragments[0];
        let (at, unsigned) = module.slots[0];
        assert!(!unsigned && module.words[at] != 0, "the module has a marker there");
    }
}
