//! Describes draws for `cupola inspect`.

use crate::intercept::inspection::{self, DrawNote, MatrixNote};
use crate::intercept::scene::lens::Candidate;
use crate::intercept::vk::spirv::{Matrix, Memory};
use crate::intercept::vk::state::recording::draw_groups::{DrawClass, DrawGroup, MatrixSource};
use glam::DMat4;

/// Describes the draws of a group. `how`: how the lens was found; `in_views`: the draws are issued
/// to views; `value` reads a matrix, if that is possible.
pub(in crate::intercept::vk) fn note(
    group: &DrawGroup,
    class: DrawClass,
    how: Option<&'static str>,
    in_views: bool,
    value: impl Fn(&MatrixSource) -> Option<DMat4>,
) {
    let facts = &group.facts;
    let (width, height) = group.layout.window;
    let target = match facts.off_screen {
        true => "an image that holds the scene".to_owned(),
        false => format!("window, {width} × {height}"),
    };
    let (name, why) = match class {
        DrawClass::Scene(_) => ("scene", how.unwrap_or_default().to_owned()),
        DrawClass::Backdrop(_) => ("background", "it fills the picture before the scene".to_owned()),
        DrawClass::Screen if group.facts.fills => ("background", "it fills an image before the scene".to_owned()),
        DrawClass::Screen => ("pass over the screen", "it shows an image of the scene".to_owned()),
        DrawClass::Behind => ("flat, behind the scene", "no matrix with a perspective, before the scene".to_owned()),
        DrawClass::Flat if !in_views => ("flat", "everything is shown flat".to_owned()),
        DrawClass::Flat => ("flat", group.missing_lens().reason().to_owned()),
    };
    let state = [(facts.deep, "depth test"), (facts.y_up, "y up")];
    let state: Vec<&str> = state.into_iter().filter_map(|(is_set, name)| is_set.then_some(name)).collect();
    let matrix = |source: &MatrixSource| {
        let Matrix { memory, offset, rank, row_major, .. } = source.matrix;
        let form = if row_major { "by rows" } else { "by columns" };
        let name = match memory {
            Memory::Push => format!("push constants, byte {offset}"),
            Memory::PushedAddress { at } => format!("address in push constants, byte {at}, then byte {offset}"),
            Memory::AddressInBuffer { set, binding, at } => {
                format!("address in set {set}, binding {binding}, byte {at}, then byte {offset}")
            }
            Memory::Attribute { location, .. } => format!("attribute of instances, location {location}"),
            Memory::Buffer { set, binding } => format!("set {set}, binding {binding}, byte {offset}"),
        };
        match value(source) {
            Some(value) => MatrixNote::new(name, form, &Candidate::either(rank, &value)),
            None => MatrixNote { name, form, says: "cannot be read".to_owned() },
        }
    };
    let draw = DrawNote {
        class: name,
        why,
        lens: match class {
            DrawClass::Scene(lens) => Some(lens),
            _ => None,
        },
        shaders: String::new(),
        state: state.join(", "),
        matrices: facts.sources.iter().map(matrix).collect(),
    };
    let views = group.layout.views.len();
    inspection::note_draw(0, &target, || format!("Draws of the scene are issued to {views} views."), draw, group.draws);
}
