//! End-to-end tests: small unmodified C programs run under `cupola run`, and their pictures are
//! compared with pictures predicted in f64.
//!
//! Nothing here uses Cupola's own geometry: [`reference`] computes the direction that a pixel shows
//! from a rig's numbers. See `docs/testing.md`.

// A test that is in no list is dead code.
#![deny(dead_code)]

mod backdrops;
mod behaviour;
mod blending;
mod cache;
mod calls;
mod camera_matrices;
mod clock;
mod compare;
mod computed;
mod content;
mod controls;
mod culling;
mod dialects;
mod display;
mod dynamic_size;
mod edited;
mod embedding;
mod ending;
mod faults;
mod finished;
mod frag_coord;
#[path = "../harness/mod.rs"]
mod harness;
mod held;
mod hidden;
mod in_turn;
mod injection;
mod inspection;
mod live;
mod load;
mod managed;
mod matrix_forms;
mod mirrors;
mod ndi;
mod nodes;
mod nodes_settings;
mod offscreen;
mod outlines;
mod photographed;
mod picture;
mod programs;
mod projected;
mod published;
mod random_order;
mod record;
mod reference;
mod rigs;
mod semantics;
mod steady;
mod steered;
mod stream;
mod vertices;
mod vkcube;
mod vulkan;
mod vulkan_calls;
mod vulkan_computed;
mod vulkan_faults;
mod vulkan_later;
mod vulkan_matrices;
mod vulkan_others;
mod vulkan_panes;
mod vulkan_primitives;
mod vulkan_queries;
mod vulkan_vertices;
mod wayland;
mod windows;

harness::tests! {
    ; modules
    backdrops,
    behaviour,
    blending,
    cache,
    calls,
    clock,
    held,
    camera_matrices,
    content,
    computed,
    controls,
    culling,
    dialects,
    dynamic_size,
    embedding,
    edited,
    ending,
    faults,
    hidden,
    injection,
    in_turn,
    inspection,
    live,
    load,
    frag_coord,
    managed,
    matrix_forms,
    mirrors,
    ndi,
    nodes,
    nodes_settings,
    offscreen,
    outlines,
    photographed,
    published,
    record,
    random_order,
    semantics,
    steady,
    steered,
    stream,
    vertices,
    vulkan,
    vulkan_calls,
    vulkan_computed,
    vulkan_faults,
    vulkan_later,
    vulkan_matrices,
    vulkan_others,
    vulkan_panes,
    vulkan_primitives,
    vulkan_queries,
    vulkan_vertices,
    wayland,
    windows,
}

fn main() -> std::process::ExitCode {
    harness::run(tests())
}
