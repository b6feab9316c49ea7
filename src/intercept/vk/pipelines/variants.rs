//! Variants of the program's pipelines. Libraries have variants, too. A pipeline that is linked
//! from libraries has variants that are linked from theirs.

use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::pipelines::create::{self, Sources};
use crate::intercept::vk::pipelines::{matrix_sources, view_stages};
use crate::intercept::vk::projected_vertices;
use crate::intercept::vk::spirv;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::create_info::Parts;
use crate::intercept::vk::state::pipelines::stages::{name_of, words_of};
use crate::intercept::vk::state::pipelines::{Pipeline, PipelineLayout, TilePipelines, Variants};
use ash::vk;
use spirv_words::ExecutionModel;
use std::sync::Arc;

/// The crate with SPIR-V's numbers; `spirv` is an internal module here.
use ::spirv as spirv_words;

/// Returns a pipeline of the program, with its variants if there are any.
pub fn pipeline(device: &Device, own: vk::Pipeline, parts: &Parts<'_>, variants: Option<Variants>) -> Pipeline {
    let linked: Vec<_> = parts.libraries.iter().filter_map(|library| device.pipelines.get(*library)).collect();
    Pipeline {
        own,
        layout: layout_of(device, parts, &linked),
        with_count: parts.dynamic.contains(&vk::DynamicState::VIEWPORT_WITH_COUNT)
            || parts.dynamic.contains(&vk::DynamicState::SCISSOR_WITH_COUNT)
            || linked.iter().any(|library| library.with_count),
        variants,
        viewport: parts.viewport().or_else(|| linked.iter().find_map(|library| library.viewport)),
        scissor: parts.scissor().or_else(|| linked.iter().find_map(|library| library.scissor)),
        columns: parts.columns().into_iter().chain(linked.iter().flat_map(|l| l.columns.iter().copied())).collect(),
        bare_triangles: parts.has_bare_triangles() || linked.iter().any(|library| library.bare_triangles),
    }
}

/// Returns the layout with a set of Cupola: of the pipeline itself, or of its libraries if the
/// pipeline names none.
fn layout_of(device: &Device, parts: &Parts<'_>, linked: &[Arc<Pipeline>]) -> Option<Arc<PipelineLayout>> {
    match parts.info.layout == vk::PipelineLayout::null() {
        true => linked.iter().find_map(|library| library.layout.clone()),
        false => device.layouts.layout(parts.info.layout),
    }
}

/// Returns the libraries that a pipeline is linked from, and the layout with a set of Cupola, if it
/// needs one.
///
/// # Errors
/// The reason why the pipeline has no variants.
fn linked_libraries(device: &Device, parts: &Parts<'_>) -> Result<Linked, Obstacle> {
    let linked = |library: &vk::Pipeline| device.pipelines.get(*library).filter(|known| known.variants.is_some());
    let linked: Option<Vec<Arc<Pipeline>>> = parts.libraries.iter().map(linked).collect();
    let linked = linked.ok_or_else(|| device.flatness.pipeline_obstacle())?;
    let layout = layout_of(device, parts, &linked);
    let layout = match parts.shades() || !linked.is_empty() {
        true => Some(layout.ok_or("there is no room for a descriptor set of Cupola")?),
        false => None,
    };
    let others = linked.iter().filter_map(|library| library.layout.as_ref());
    let alike = |a: &PipelineLayout, b: &PipelineLayout| (a.ours, a.counts) == (b.ours, b.counts);
    if others.clone().any(|other| layout.as_ref().is_some_and(|layout| !alike(layout, other))) {
        return Err("its libraries have layouts with different sets".into());
    }
    Ok((linked, layout))
}

/// Shaders of a pipeline.
type Stages<'a> = Vec<vk::PipelineShaderStageCreateInfo<'a>>;

/// The libraries that a pipeline is linked from, and its layout.
type Linked = (Vec<Arc<Pipeline>>, Option<Arc<PipelineLayout>>);

/// Makes the variants of a pipeline of the program.
///
/// # Errors
/// The reason why it has none.
///
/// # Safety
/// `parts` must be of a pipeline that the program has just made.
pub unsafe fn make(device: &Device, cache: vk::PipelineCache, parts: &Parts<'_>) -> Result<Variants, Obstacle> {
    if let Some(why) = parts.obstacle() {
        return Err(why);
    }
    let (linked, layout) = linked_libraries(device, parts)?;
    let mut made = inherited(parts, &linked);
    let mut modules = Modules::new(device);
    let mut stages = parts.stages.clone();
    let mut dividing = None;
    // Views with curved pictures cannot be filled. The vertices of a library are in another one.
    let may_fill = !device.view_constants.have_lenses()
        && (parts.attributes() == Some(0) || parts.shades() && !parts.places_vertices());
    // SAFETY: as promised; shader modules of Cupola are destroyed after the pipelines are made.
    unsafe {
        if parts.places_vertices() {
            let (matrices, missing) = matrix_sources::before_rasterisation(device, &stages, &parts.columns());
            made.matrices.extend(matrices);
            made.matrices.sort_by_key(|matrix| matrix.rank);
            made.missing_lens = missing;
            made.fixed_position = matrix_sources::has_fixed_position(device, &stages);
        }
        let vertex_words = match &layout {
            Some(layout) => change_stages(device, &mut stages, &mut modules, (layout.ours, may_fill), &mut made)?,
            None => None,
        };
        // The variant that divides also uses the program's own fragment shader.
        let own_stages = stages.clone();
        if let Some(layout) = layout.filter(|_| parts.places_vertices()) {
            match spliced(device, &parts.stages, vertex_words, layout.ours) {
                Ok((index, words)) => {
                    modules.replace(&mut stages[index], &words)?;
                    made.follows = true;
                    match projected_vertices::dividing_stage(device, parts, &layout) {
                        Ok(None) => {}
                        Ok(Some(words)) => dividing = Some(modules.make(&words)?),
                        Err(why) => device.pipelines.divided.note_undivided(&why),
                    }
                }
                Err(why) => {
                    if let Some(reason) = why.reason() {
                        log::once(&format!("Vulkan: the draws of a pipeline are flat: {reason}"));
                    }
                }
            }
        }
        create_all(device, cache, parts, &linked, &mut modules, (&stages, &own_stages, dividing), &mut made)?;
    }
    Ok(made)
}

/// Makes the pipelines of all tiles, and the same without writes if the shaders write. `stages`:
/// those that reproject, the program's own with changed fragments, and the geometry stage that
/// divides, which is combined with the latter.
///
/// # Errors
/// The driver's.
///
/// # Safety
/// As for [`make`].
unsafe fn create_all(
    device: &Device,
    cache: vk::PipelineCache,
    parts: &Parts<'_>,
    linked: &[Arc<Pipeline>],
    modules: &mut Modules<'_>,
    (stages, own, dividing): (&Stages<'_>, &Stages<'_>, Option<vk::ShaderModule>),
    made: &mut Variants,
) -> Result<(), Obstacle> {
    // SAFETY: as promised.
    unsafe {
        let quiet = modules.without_writes(stages)?;
        made.writes |= quiet.is_some();
        let create = |stages: [&[vk::PipelineShaderStageCreateInfo<'_>]; 2], of_library| {
            create::create(device, cache, parts, &Sources { stages, linked, of_library })
        };
        let mut dividing = dividing;
        let divided = dividing.map(|module| create([&with_stage(own, module), stages], |library| library.tiles));
        made.tiles = match divided {
            Some(Ok(tiles)) => tiles,
            failed => {
                if let Some(Err(why)) = failed {
                    device.pipelines.divided.note_undivided(&why);
                }
                dividing = None;
                create([stages, stages], |library| library.tiles)?
            }
        };
        if made.writes {
            device.pipelines.note_writes();
            let of_panel = quiet.as_ref().unwrap_or(stages);
            // The stage of Cupola counts for the statistics, which is no write of the program.
            let of_views = dividing.map(|module| {
                let own_quiet = modules.without_writes(own)?;
                Ok::<_, Obstacle>(with_stage(own_quiet.as_ref().unwrap_or(own), module))
            });
            let made_quiet = of_views.transpose().and_then(|of_views| {
                create([of_views.as_ref().unwrap_or(of_panel), of_panel], Variants::without_writes)
            });
            made.quiet = made_quiet.inspect_err(note_repeated).ok();
        }
    }
    Ok(())
}

/// Says that shaders write once for each view.
fn note_repeated(why: &Obstacle) {
    log::once(&format!("Vulkan: shaders of a pipeline write once for each view: {}", why.reason().unwrap_or_default()));
}

/// Returns the properties of variants whose pipelines are not made yet, from the variants of
/// libraries and the pipeline's own depth test.
fn inherited(parts: &Parts<'_>, linked: &[Arc<Pipeline>]) -> Variants {
    let libraries = || linked.iter().filter_map(|library| library.variants.as_ref());
    Variants {
        tiles: TilePipelines::default(),
        quiet: None,
        follows: libraries().any(|library| library.follows),
        matrices: libraries().flat_map(|library| library.matrices.iter().copied()).collect(),
        missing_lens: libraries().map(|library| library.missing_lens).max().unwrap_or_default(),
        moves_place: libraries().any(|library| library.moves_place),
        loses_place: libraries().any(|library| library.loses_place),
        pictures: libraries().flat_map(|library| library.pictures.iter().copied()).collect(),
        cameras: libraries().flat_map(|library| library.cameras.iter().copied()).collect(),
        deep: parts.dynamic.contains(&vk::DynamicState::DEPTH_TEST_ENABLE)
            || parts.depth.is_some_and(|state| state.depth_test_enable == vk::TRUE)
            || libraries().any(|library| library.deep),
        writes: libraries().any(|library| library.writes),
        fixed_position: libraries().any(|library| library.fixed_position),
        backdrop: libraries().any(|library| library.backdrop),
    }
}

/// Changes the fragment stage for views, and also the vertex stage if no matrix makes positions.
/// The stages read the view constants in set `ours`. `may_fill`: the draws may be backgrounds. Notes in
/// `made` the data that the stages read.
/// Returns the index and the words of the vertex stage, if it is changed.
///
/// # Errors
/// The driver's.
///
/// # Safety
/// `stages` must be the program's.
unsafe fn change_stages(
    device: &Device,
    stages: &mut [vk::PipelineShaderStageCreateInfo<'_>],
    modules: &mut Modules<'_>,
    (ours, may_fill): (u32, bool),
    made: &mut Variants,
) -> Result<Option<(usize, Vec<u32>)>, Obstacle> {
    let number = |flag| stages.iter().position(|stage| stage.stage == flag);
    let (fragment, vertex) = (number(vk::ShaderStageFlags::FRAGMENT), number(vk::ShaderStageFlags::VERTEX));
    if let Some(index) = fragment {
        // SAFETY: as promised.
        let changed = unsafe { view_stages::fragment(device, &stages[index], ours, may_fill) };
        if let Some(words) = &changed.words {
            modules.replace(&mut stages[index], words)?;
        }
        made.moves_place |= changed.moves_place;
        made.loses_place |= changed.loses_place;
        made.pictures.extend(changed.pictures);
        made.cameras.extend(changed.cameras);
        made.backdrop = changed.backdrop;
    }
    // In a draw of the scene, the outputs of the vertex stage have to fit its position.
    let Some(index) = vertex.filter(|_| made.matrices.is_empty()) else { return Ok(None) };
    // SAFETY: as promised.
    let Some((words, found)) = (unsafe { view_stages::vertex(device, &stages[index], ours) }) else { return Ok(None) };
    modules.replace(&mut stages[index], &words)?;
    made.cameras.extend(found);
    Ok(Some((index, words)))
}

/// Shader modules of Cupola, which are needed until the pipelines are made.
pub struct Modules<'a> {
    device: &'a Device,
    made: Vec<(vk::ShaderModule, Vec<u32>)>,
}

impl<'a> Modules<'a> {
    /// Returns an empty list.
    pub fn new(device: &'a Device) -> Self {
        Self { device, made: Vec::new() }
    }

    /// Makes a module of these words.
    ///
    /// # Errors
    /// The driver's.
    pub fn make(&mut self, words: &[u32]) -> Result<vk::ShaderModule, Obstacle> {
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the device is live.
        let made = unsafe { self.device.driver.functions.create_shader_module(&info, None) };
        self.made.extend(made.map(|module| (module, words.to_vec())));
        made.map_err(|error| error.to_string().into())
    }

    /// Gives a stage these words instead of the program's, which may be in its chain.
    ///
    /// # Errors
    /// The driver's.
    fn replace(&mut self, stage: &mut vk::PipelineShaderStageCreateInfo<'_>, words: &[u32]) -> Result<(), Obstacle> {
        stage.module = self.make(words)?;
        stage.p_next = std::ptr::null();
        Ok(())
    }

    /// Returns the stages with shaders that do not write to buffers and images; `None` if no shader
    /// does.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// `stages` must be the program's, or have modules of this list.
    unsafe fn without_writes<'s>(
        &mut self,
        stages: &[vk::PipelineShaderStageCreateInfo<'s>],
    ) -> Result<Option<Vec<vk::PipelineShaderStageCreateInfo<'s>>>, Obstacle> {
        let mut changed = None;
        for (index, stage) in stages.iter().enumerate() {
            let made = self.made.iter().find(|(module, _)| *module == stage.module);
            let words = match made {
                Some((_, words)) => spirv::without_writes(words),
                // SAFETY: as promised: the stage is the program's.
                None => unsafe { words_of(self.device, stage) }.and_then(|words| spirv::without_writes(&words)),
            };
            if let Some(words) = words {
                self.replace(&mut changed.get_or_insert_with(|| stages.to_vec())[index], &words)?;
            }
        }
        Ok(changed)
    }
}

impl Drop for Modules<'_> {
    fn drop(&mut self) {
        for (module, _) in self.made.drain(..) {
            // SAFETY: a module of Cupola; pipelines do not need it once they are made.
            unsafe { self.device.driver.functions.destroy_shader_module(module, None) };
        }
    }
}

/// Returns the stages of the program and the geometry stage `module`.
fn with_stage<'a>(
    stages: &[vk::PipelineShaderStageCreateInfo<'a>],
    module: vk::ShaderModule,
) -> Vec<vk::PipelineShaderStageCreateInfo<'a>> {
    let ours = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::GEOMETRY)
        .module(module)
        .name(projected_vertices::ENTRY);
    stages.iter().copied().chain([ours]).collect()
}

/// Returns the index of the last stage before rasterisation, and its SPIR-V name.
fn last_stage(stages: &[vk::PipelineShaderStageCreateInfo<'_>]) -> Option<(usize, ExecutionModel)> {
    let order = [
        (vk::ShaderStageFlags::GEOMETRY, ExecutionModel::Geometry),
        (vk::ShaderStageFlags::TESSELLATION_EVALUATION, ExecutionModel::TessellationEvaluation),
        (vk::ShaderStageFlags::VERTEX, ExecutionModel::Vertex),
    ];
    order.into_iter().find_map(|(flag, model)| stages.iter().position(|s| s.stage == flag).map(|at| (at, model)))
}

/// Returns the index of the last stage before rasterisation and its words with the epilogue, which
/// reads the view constants through set `ours`. `changed`: a stage whose words differ from the
/// program's.
///
/// # Errors
/// The reason why there are none.
///
/// # Safety
/// `stages` must be the program's.
unsafe fn spliced(
    device: &Device,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    changed: Option<(usize, Vec<u32>)>,
    ours: u32,
) -> Result<(usize, Vec<u32>), Obstacle> {
    let (index, model) = last_stage(stages).ok_or("a pipeline without a vertex shader")?;
    // SAFETY: as promised.
    let (words, entry) = unsafe { (words_of(device, &stages[index]), name_of(&stages[index])) };
    let changed = changed.filter(|(at, _)| *at == index).map(|(_, words)| words.into());
    let words = changed.or(words).ok_or("a shader whose words are not known")?;
    Ok((index, spirv::splice(&words, model, &entry, ours, device.view_constants.have_lenses())?))
}
