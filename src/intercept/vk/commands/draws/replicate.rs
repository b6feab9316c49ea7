//! A draw of the program becomes one draw per view, one on the panel and one in the primary view.
//!
//! ```text
//! draw_to_views ─ classify: facts about the draw that are known while it is recorded (DrawFacts)
//!               ─ select:   its draw group, with memory for the view constants of each tile
//!               ─ issue:    one draw per tile
//! ```
//!
//! The draw class, scene or flat, is decided when the command buffer is submitted
//! (`submit::draw_groups`). At recording, the draw is issued to every tile that may have to show
//! it.

use crate::intercept::process::settings;
use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::scene::to_window::Area;
use crate::intercept::vk::commands::bound_state::set_window;
use crate::intercept::vk::commands::draws::indirect;
use crate::intercept::vk::commands::draws::parts;
use crate::intercept::vk::commands::draws::rebind::{rebind, restore};
use crate::intercept::vk::commands::draws::tiles::{
    PerViewSet, ProgramWindow, TileDraws, cut_to_tile, is_main, is_whole, move_to_tile,
};
use crate::intercept::vk::commands::passes::panel_clears::clear_pending;
use crate::intercept::vk::offscreen::coverage::{self, Measurable, Shown};
use crate::intercept::vk::offscreen::scene_graph::{self, Cover};
use crate::intercept::vk::pipelines::matrix_sources::source;
use crate::intercept::vk::spirv::DescriptorPlace;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::coverage::QueryBlock;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::pipelines::{CameraMatrix, Pipeline, Variants};
use crate::intercept::vk::state::recording::draw_groups::{
    CameraSource, DrawFacts, DrawGroup, MatrixSource, ShownLayout,
};
use crate::intercept::vk::state::recording::draw_parameters::{DrawSize, IndirectDraw};
use crate::intercept::vk::state::recording::{Event, Recording, count_draw};
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect, ViewTile};
use crate::intercept::vk::state::views::view_constants::ChunkOffset;
use ash::vk;
use glam::Vec2;
use std::sync::Arc;

/// A draw of the program.
pub struct ProgramDraw<'a> {
    pub(in crate::intercept::vk) device: &'a Device,
    pub(in crate::intercept::vk) buffer: vk::CommandBuffer,
    pub(in crate::intercept::vk) pipeline: &'a Pipeline,
    pub(in crate::intercept::vk) size: DrawSize,
    /// Records the program's own draw.
    pub(in crate::intercept::vk) issue: &'a dyn Fn(),
}

/// Classification of a draw while it is recorded.
struct Classified {
    facts: DrawFacts,
    program: ProgramWindow,
    sets: Vec<PerViewSet>,
    /// Queries that measure it.
    measured: Option<Arc<QueryBlock>>,
}

/// Tiles that a draw goes to.
struct Selected {
    constants: ChunkOffset,
    /// Number of views that it may be issued to.
    views: usize,
    /// True if it is issued to all of them, also to those that only other machines show.
    all: bool,
    /// True if it is issued to the first view in any case, where its shaders write.
    writes: bool,
    on_panel: bool,
    indirect: Option<IndirectDraw>,
}

impl Selected {
    /// True if the draw is issued to a view.
    fn shows(&self, layout: &AtlasLayout, view: usize) -> bool {
        self.all || layout.is_needed(view) || (self.writes && view == 0)
    }
}

/// Issues a draw to each view, onto the panel and into the primary view.
///
/// # Safety
/// The command buffer is being recorded, within a pass that draws to an atlas.
pub unsafe fn draw_to_views(draw: &ProgramDraw<'_>, recording: &mut Recording) {
    // SAFETY: as promised.
    unsafe {
        rebind(draw.device, draw.buffer, recording, draw.pipeline);
        clear_pending(draw.device, draw.buffer, recording);
        let Some(layout) = recording.pass.as_ref().map(|pass| Arc::clone(&pass.target.layout)) else { return };
        let Some(variants) = &draw.pipeline.variants else {
            draw.device.show_flat(draw.device.flatness.pipeline_obstacle());
            return issue_flat(draw, recording, &layout);
        };
        let Some(classified) = classify(draw, recording, variants, &layout) else {
            return issue_flat(draw, recording, &layout);
        };
        let Classified { facts, program, sets, measured } = classified;
        let part = facts.part;
        let spreads = facts.off_screen && !is_whole(&program.viewport, layout.window);
        let Some(selected) = select(draw, recording, variants, &layout, facts) else {
            return issue_flat(draw, recording, &layout);
        };
        let Selected { constants, views, on_panel, indirect, .. } = selected;
        let (device, buffer, pipeline, window) = (draw.device, draw.buffer, draw.pipeline, layout.window);
        part.into_iter().for_each(|part| parts::clear_part(device, buffer, &layout, part));
        let mut tiles = TileDraws {
            device,
            buffer,
            recording,
            pipeline,
            variants,
            constants,
            program,
            window,
            part,
            spreads,
            indirect,
        };
        let shown = |view: &usize| selected.shows(&layout, *view);
        issue(&mut tiles, &layout, (views, &shown), on_panel, sets, draw.issue);
        if let Some(block) = measured {
            parts::measure(&mut tiles, &layout, views + 1, block, draw.issue);
        }
    }
}

/// Issues a draw that cannot be followed once, with the program's own pipeline, into the tile where
/// flat draws are shown. The pass draws to the atlas already, and may have been recorded for many
/// frames. If the viewport is part of the pipeline, it cannot be moved to the tile.
///
/// # Safety
/// As for [`draw_to_views`].
unsafe fn issue_flat(draw: &ProgramDraw<'_>, recording: &mut Recording, layout: &AtlasLayout) {
    let (device, buffer, pipeline, place) = (draw.device, draw.buffer, draw.pipeline, layout.flat_place());
    // SAFETY: as promised.
    unsafe {
        if (place.x, place.y) == (0, 0) {
            restore(device, buffer, recording);
        } else if pipeline.viewport.is_none() && pipeline.scissor.is_none() {
            let program = ProgramWindow::of(recording, pipeline, layout);
            restore(device, buffer, recording);
            let scissor = cut_to_tile(&program.scissor, place, layout.window);
            set_window(device, buffer, &move_to_tile(&program.viewport, place), &scissor, pipeline.with_count);
            recording.graphics.disturbed = true;
        } else {
            return;
        }
    }
    count_draw(recording, None, draw.size.vertices(), Some(1));
    (draw.issue)();
}

/// Collects the facts about a draw that are known while it is recorded; `None` if it cannot be
/// followed.
///
/// The values of its matrices are known only at submission, where `submit` chooses the draw class.
/// Here a draw is issued for every class that is still possible:
///
/// * With matrices (`sources`) it may be part of the scene, in all views, or flat, on the panel.
/// * Without matrices it is flat, with two exceptions: it covers the window with a picture of the
///   scene (`screen`), or its shaders use the lens that the rig gives (`deep`).
/// * A flat draw before the first draw of the scene may have to go behind the scene, so it needs
///   the views, too. A triangle or square off screen may have no matrices and no attributes, so
///   that the shader computes its positions from the vertex numbers. Such a draw covers each view
///   completely (`fills`); in the window, if no data of the program flow into its positions.
///
/// Matrices count only in the viewport of the main picture (`main`). In other viewports they may
/// belong to another camera.
fn classify(
    draw: &ProgramDraw<'_>,
    recording: &mut Recording,
    variants: &Variants,
    layout: &AtlasLayout,
) -> Option<Classified> {
    let device = draw.device;
    let program = ProgramWindow::of(recording, draw.pipeline, layout);
    let main = match recording.pass.as_ref().filter(|pass| !pass.target.window) {
        None => is_main(&program.viewport, layout.window),
        Some(pass) => {
            let facts = (layout.window, !variants.matrices.is_empty());
            device.scene_graph.is_main(pass.target.given, &program.viewport, facts)
        }
    };
    let covers = draw.size.may_cover_viewport();
    let first = draw.size.first_instance();
    let (sources, missing_lens) = lens_sources(draw, recording, variants, main);
    let ours = draw.pipeline.layout.as_ref().map_or(0, |layout| layout.ours);
    let sets = per_view_sets(device, recording, layout, ours).map_err(|why| device.show_flat(why)).ok()?;
    let (has_matrices, told_place) = (!sources.is_empty(), variants.moves_place);
    let shown = shown(draw, recording, variants, &program, layout);
    let cover = Cover { main_picture: main, few_vertices: covers, has_matrices, told_place };
    note_pictures(device, recording, cover, &shown);
    let pictures: Vec<_> = variants.pictures.iter().map(|place| shown_layout(device, recording, *place)).collect();
    let of_camera = |camera: &CameraMatrix| {
        let CameraMatrix { matrix, called, stage, inverted } = *camera;
        CameraSource { source: source(device, recording, &matrix, first).filter(|_| main), called, stage, inverted }
    };
    let cameras: Vec<_> = variants.cameras.iter().map(of_camera).collect();
    // A flat draw may be a sky, or another picture that is computed from pixel positions.
    let sky = main && sets.is_empty() && !cameras.is_empty();
    let pass = recording.pass.as_mut()?;
    let off_screen = !pass.target.window;
    let screen = !sets.is_empty() && main && covers && !shown.is_flat();
    let part = shown.part().filter(|_| screen);
    if !sets.is_empty() && main && variants.loses_place {
        device.show_flat("a shader that reads a picture of its scene uses its position on the screen");
    }
    let deep = variants.deep && main && layout.session.given_lens().is_some();
    // A flat draw may have to go behind the scene, if no scene has been drawn yet.
    let may_be_behind = !sources.is_empty() || !pass.scene || off_screen || deep;
    let own_lens = layout.views.iter().any(|view| view.own_lens);
    let in_views = own_lens || main && (screen || sky || variants.follows && may_be_behind);
    let given = !variants.matrices.is_empty() || !cameras.is_empty() || !sets.is_empty();
    let may_fill = off_screen || in_views && variants.backdrop && variants.fixed_position;
    let fills = may_fill
        && (!off_screen || is_whole(&program.viewport, layout.window))
        && main
        && covers
        && !pass.scene
        && !given
        && draw.pipeline.bare_triangles
        && program.is_uncut(layout.window);
    pass.scene |= sources.iter().any(|source| source.matrix.memory.has_matrix()) || screen || deep;
    let y_up = program.viewport.height < 0.0;
    if !sources.is_empty() {
        recording.y_up = y_up;
    }
    // Off screen, a smaller viewport is in the same part of the view's image.
    let whole = AtlasRect { x: 0, y: 0, width: layout.window.0 as i32, height: layout.window.1 as i32 };
    let shown_part = part.or(off_screen.then_some(whole));
    let viewport = variants.moves_place.then(|| shown_part.map_or_else(|| area(&program.viewport), Area::from));
    let facts = DrawFacts {
        sources,
        missing_lens,
        y_up,
        in_views,
        off_screen,
        deep,
        viewport,
        pictures,
        screen,
        part,
        fills,
        backdrop: variants.backdrop,
        cameras,
        sky,
    };
    Some(Classified { facts, program, sets, measured: shown.queries() })
}

/// Returns the matrices that may contain the lens of a draw, and the reason why it has none if they
/// cannot be read. `main`: its viewport shows the main picture.
fn lens_sources(
    draw: &ProgramDraw<'_>,
    recording: &Recording,
    variants: &Variants,
    main: bool,
) -> (Vec<MatrixSource>, MissingLens) {
    let of_draw = |matrix| source(draw.device, recording, matrix, draw.size.first_instance());
    let sources = match variants.follows && main {
        true => variants.matrices.iter().filter_map(of_draw).collect(),
        false => Vec::new(),
    };
    let missing_lens = match variants.matrices.first() {
        _ if !main => MissingLens::PartOfWindow,
        Some(matrix) if matrix.memory.has_matrix() => matrix.memory.if_unreadable(),
        _ => variants.missing_lens,
    };
    (sources, missing_lens)
}

/// Determines what a draw to the window shows of images of another shape.
fn shown(
    draw: &ProgramDraw<'_>,
    recording: &Recording,
    variants: &Variants,
    program: &ProgramWindow,
    layout: &AtlasLayout,
) -> Shown {
    let in_window = recording.pass.as_ref().is_some_and(|pass| pass.target.window && pass.colored);
    if !in_window || !draw.size.may_cover_viewport() {
        return Shown::Nothing;
    }
    let measurable = Measurable {
        pipeline: draw.pipeline.own,
        viewport: program.viewport,
        scissor: program.scissor,
        main_picture: is_main(&program.viewport, layout.window),
        repeats: variants.follows && !variants.deep && variants.pictures.is_empty(),
    };
    coverage::look(draw.device, recording, layout, &measurable)
}

/// Returns the layout of the image that a descriptor refers to, if each view has its own copy of
/// that image.
fn shown_layout(device: &Device, recording: &Recording, (set, binding): DescriptorPlace) -> Option<ShownLayout> {
    let bound = recording.graphics.bound.get(set as usize)?.as_ref()?;
    let image = device.images.of(device.descriptors.picture(bound.set, (binding, 0))?)?;
    let scene = device.images.scene(image).filter(|scene| !scene.view_copies.is_empty())?;
    Some(ShownLayout(Arc::clone(&scene.layout)))
}

/// Returns the area that a viewport covers, also if its height is negative.
fn area(viewport: &vk::Viewport) -> Area {
    let top = viewport.y + viewport.height.min(0.0);
    Area { origin: Vec2::new(viewport.x, top), size: Vec2::new(viewport.width, viewport.height.abs()) }
}

/// Notes the use of images that may hold a scene: the pass draws, and the draw's shaders can sample
/// them.
fn note_pictures(device: &Device, recording: &mut Recording, cover: Cover, shown: &Shown) {
    let pictures = scene_graph::pictures(device, recording);
    scene_graph::note_stored(device, recording);
    let Some(pass) = &recording.pass else { return };
    let (window, given) = (pass.target.window, pass.target.given);
    for picture in pictures {
        let made = match window {
            true => shown.made(device, picture, cover),
            false => cover.made(device, picture, Made::Image(given)),
        };
        made.into_iter().for_each(|made| device.scene_graph.note_made(picture, made));
        device.images.scene(picture).into_iter().for_each(|scene| recording.samples(scene));
    }
}

/// Returns the per-view copies of the program's sets that a draw needs.
///
/// # Errors
/// The reason why there are none.
fn per_view_sets(
    device: &Device,
    recording: &Recording,
    layout: &AtlasLayout,
    ours: u32,
) -> Result<Vec<PerViewSet>, Obstacle> {
    let mut all = Vec::new();
    if !device.images.has_candidates() && !device.descriptors.any_attachments() {
        return Ok(all);
    }
    for (number, bound) in (0..ours).zip(&recording.graphics.bound) {
        let Some(bound) = bound else { continue };
        if let Some(sets) = device.descriptors.of_views(device, bound.set, layout)? {
            let attachments = device.descriptors.reads_attachments(bound.set);
            all.push(PerViewSet { number, sets, dynamic: bound.dynamic.clone(), attachments });
        }
    }
    Ok(all)
}

/// Finds or makes the draw group of a draw, with memory for its view constants; `None` if there is
/// no memory.
fn select(
    draw: &ProgramDraw<'_>,
    recording: &mut Recording,
    variants: &Variants,
    layout: &Arc<AtlasLayout>,
    facts: DrawFacts,
) -> Option<Selected> {
    let device = draw.device;
    let views = if facts.in_views { layout.views.len() } else { 0 };
    // One for each view, one for the panel and one for the primary view.
    let slots = 2 + views;
    let same = recording.draw_groups.last_mut().filter(|group| group.takes(layout, &facts));
    if same.is_none() {
        let stride = device.slot_stride(facts.slot_parts());
        let taken = device.view_constants.take(&device.driver, &mut recording.constants, slots, stride);
        let constants = taken
            .inspect_err(|error| {
                device.show_flat(format!("there is no memory for the constants of {slots} tiles: {error}"))
            })
            .ok()?;
        recording.events.push(Event::DrawGroup(recording.draw_groups.len()));
        recording.draw_groups.push(DrawGroup::new(constants, Arc::clone(layout), facts));
    }
    // What queries count and what shaders write must not depend on the machine. Draws outside of a
    // query may hide what it counts.
    let counts = device.queries.have_counted();
    let repeats = variants.writes && variants.quiet.is_none();
    let all = counts || repeats || settings::settings().is_none_or(|settings| !settings.cull);
    let index = recording.draw_groups.len() - 1;
    let indirect = match &draw.size {
        DrawSize::Known(parameters) => indirect::place(device, recording, parameters, slots as u32, variants.writes),
        DrawSize::Unknown => None,
    };
    let group = &mut recording.draw_groups[index];
    group.draws += 1;
    let (constants, on_panel) = (group.constants, group.is_on_panel());
    let selected = Selected { constants, views, all, writes: variants.writes, on_panel, indirect };
    group.elsewhere += (0..views).filter(|view| !selected.shows(layout, *view)).count() as u64;
    group.indirect.extend(indirect);
    let times = views + usize::from(on_panel) + usize::from(layout.primary.is_some());
    count_draw(recording, Some(index), draw.size.vertices(), indirect.is_none().then_some(times as u32));
    Some(selected)
}

/// Issues a draw into the tiles of those of the first `views` views that are `shown`, onto the panel
/// and into the primary view.
///
/// # Safety
/// The command buffer is being recorded, within a pass that draws to the atlas.
unsafe fn issue(
    tiles: &mut TileDraws<'_>,
    layout: &AtlasLayout,
    (views, shown): (usize, &dyn Fn(&usize) -> bool),
    on_panel: bool,
    mut sets: Vec<PerViewSet>,
    own: &dyn Fn(),
) {
    // Shaders write once: in the primary view, or else in the first view, if the draw is part of the
    // scene, or on the panel, if it is flat.
    let (writing, quiet) = (tiles.variants.tiles, tiles.variants.without_writes());
    let others = if layout.primary.is_some() { quiet } else { writing };
    let window_space = |rect| ViewTile { rect, own_lens: true };
    // SAFETY: as promised.
    unsafe {
        for (index, tile) in layout.views.iter().enumerate().take(views).filter(|(index, _)| shown(index)) {
            let by = if index == 0 { others.view } else { quiet.view };
            tiles.issue(by, index, tile, &sets, index, own);
        }
        tiles.unbind(&sets);
        sets.retain(|set| set.attachments);
        if on_panel {
            tiles.issue(others.panel, views, &window_space(layout.panel), &sets, 0, own);
        }
        if let Some(primary) = layout.primary {
            tiles.issue(writing.view, views + 1, &window_space(primary), &sets, 0, own);
        }
        tiles.unbind(&sets);
    }
}
