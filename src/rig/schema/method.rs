//! `method`, `max_error` and `density` of an output.

use crate::rig::model::method::{
    DEFAULT_DENSITY, DEFAULT_DIVISION_ERROR, DEFAULT_ERROR, DENSITY, DIVISION_ERROR, MAX_ERROR, whole,
};
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Divider, Method};

#[derive(Clone, Copy, PartialEq)]
enum Word {
    Fragment,
    Table,
    Mesh,
    CubeMesh,
    Vertex,
    Primitive(Divider),
}

const WORDS: [(&str, Word); 7] = [
    ("fragment", Word::Fragment),
    ("table", Word::Table),
    ("mesh", Word::Mesh),
    ("cube-mesh", Word::CubeMesh),
    ("vertex", Word::Vertex),
    ("primitive", Word::Primitive(Divider::Geometry)),
    ("primitive-tessellation", Word::Primitive(Divider::Tessellation)),
];

pub(super) fn method(section: &mut Section, problems: &mut Problems) -> Method {
    let known = section.checked_choice("method", &WORDS, Word::Fragment, problems);
    if known.is_none() {
        // The keys of an unknown word are unknown too, and are accepted.
        let _ = section.optional_number("max_error", &MAX_ERROR, problems);
        let _ = section.optional_number("density", &DENSITY, problems);
    }
    match known.unwrap_or(Word::Fragment) {
        Word::Fragment => Method::Fragment,
        Word::Vertex => Method::Vertex,
        Word::Primitive(by) => {
            let max_error = section.number("max_error", &DIVISION_ERROR, DEFAULT_DIVISION_ERROR, problems);
            Method::Primitive { max_error, by }
        }
        Word::Table => Method::Table { max_error: section.number("max_error", &MAX_ERROR, DEFAULT_ERROR, problems) },
        Word::Mesh => Method::Mesh { max_error: section.number("max_error", &MAX_ERROR, DEFAULT_ERROR, problems) },
        Word::CubeMesh => {
            let density = section.number("density", &DENSITY, DEFAULT_DENSITY, problems);
            if whole(density).is_none() {
                problems.add(&section.path("density"), format!("{density} is not whole; expected whole cells"));
            }
            Method::CubeMesh { density: density as u32 }
        }
    }
}
