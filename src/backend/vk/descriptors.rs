//! Images that the shaders of a plan read: a descriptor set for each draw, each set of pictures and
//! each filter.

use super::images::SourceImage;
use super::program::{Common, picture_bindings};
use crate::backend::vk::driver::api::{Api, refused};
use crate::correct::shaders::spirv::binding;
use crate::correct::{Arrangement, ImageSize};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;

/// Images that one draw reads.
#[derive(Clone, Debug, Default)]
pub(super) struct Reads {
    /// Views that the draw samples, as indices into the plan's views.
    pub views: Vec<usize>,
    /// Mask, table and picture of black, as 2D images. `None`: the draw reads none, and the first
    /// picture is bound in its place; it must then be a 2D image.
    pub mask: Option<vk::ImageView>,
    pub table: Option<vk::ImageView>,
    pub black: Option<vk::ImageView>,
}

/// A set of pictures with all views, and its descriptors.
pub(super) struct Source {
    /// Images of the set, each with its number of layers.
    pub images: Vec<(SourceImage, u32)>,
    /// Descriptor sets of each draw, for linear and nearest filtering.
    pub sets: Vec<[vk::DescriptorSet; 2]>,
}

/// Descriptors of all sets of pictures.
#[derive(Default)]
pub(super) struct Descriptors {
    pool: vk::DescriptorPool,
    pub sources: Vec<Source>,
}

impl Descriptors {
    /// Makes descriptors for draws that read `reads`. `images` contains `sizes.len()` images for
    /// each set of pictures.
    pub fn new(
        api: &Api,
        common: &Common,
        arrangement: Arrangement,
        reads: &[Reads],
        sizes: &[ImageSize],
        images: &[SourceImage],
    ) -> Result<Self> {
        if sizes.is_empty() || !images.len().is_multiple_of(sizes.len()) {
            let message = format!("{} images; expected {} for each set of views", images.len(), sizes.len());
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        for pictures in images.chunks_exact(sizes.len()) {
            pictures.iter().zip(sizes).try_for_each(|(image, size)| image.check(api, *size))?;
        }
        let count = (images.len() / sizes.len() * reads.len() * 2) as u32;
        if count == 0 {
            return Ok(Self::default());
        }
        let pictures = picture_bindings(arrangement).count() as u32;
        let of = |ty, each| vk::DescriptorPoolSize { ty, descriptor_count: each * count };
        let kinds = [of(vk::DescriptorType::SAMPLED_IMAGE, pictures + 3), of(vk::DescriptorType::SAMPLER, 2)];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&kinds);
        let layouts = vec![common.set_layout; count as usize];
        // SAFETY: the device is live; the structures are complete; the pool is destroyed if its
        // sets cannot be allocated.
        let (pool, sets) = unsafe {
            let pool = api.device.create_descriptor_pool(&info, None).map_err(refused("descriptors"))?;
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let sets =
                api.device.allocate_descriptor_sets(&info).map_err(refused("descriptors")).inspect_err(|_| {
                    api.device.destroy_descriptor_pool(pool, None);
                })?;
            (pool, sets)
        };
        let sets = sets.as_chunks::<2>().0.chunks_exact(reads.len());
        let source = |(images, sets): (&[SourceImage], &[[vk::DescriptorSet; 2]])| Source {
            images: images.iter().copied().zip(sizes.iter().map(|size| size.layers)).collect(),
            sets: sets.to_vec(),
        };
        let descriptors = Self { pool, sources: images.chunks_exact(sizes.len()).zip(sets).map(source).collect() };
        for source in &descriptors.sources {
            for (reads, sets) in reads.iter().zip(&source.sets) {
                for (set, sampler) in sets.iter().zip(common.samplers) {
                    write(api, common, arrangement, *set, source, reads, sampler);
                }
            }
        }
        Ok(descriptors)
    }

    /// Destroys the descriptors. No pending commands may use them.
    pub fn destroy(&mut self, api: &Api) {
        let old = std::mem::take(self);
        // SAFETY: an object of Cupola or null.
        unsafe { api.device.destroy_descriptor_pool(old.pool, None) };
    }
}

/// Writes all bindings of a set. A binding that the shader does not read needs a valid image, too.
fn write(
    api: &Api,
    common: &Common,
    arrangement: Arrangement,
    set: vk::DescriptorSet,
    source: &Source,
    reads: &Reads,
    sampler: vk::Sampler,
) {
    let Some((first, _)) = source.images.first() else { return };
    let picture = |slot: usize| {
        let index = if arrangement == Arrangement::Images { reads.views.get(slot).copied().unwrap_or(0) } else { 0 };
        let image = source.images.get(index).map_or(first, |(image, _)| image);
        [vk::DescriptorImageInfo::default().image_view(image.view).image_layout(image.sampled_layout())]
    };
    let texture = |view: Option<vk::ImageView>| match view {
        None => picture(0),
        Some(view) => [vk::DescriptorImageInfo::default()
            .image_view(view)
            .image_layout(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL)],
    };
    let pictures: Vec<_> = picture_bindings(arrangement).enumerate().map(|(i, at)| (at, picture(i))).collect();
    let (mask, table, black) = (texture(reads.mask), texture(reads.table), texture(reads.black));
    let filters = [sampler, common.samplers[0]].map(|s| [vk::DescriptorImageInfo::default().sampler(s)]);
    let write = |binding, kind, info| {
        vk::WriteDescriptorSet::default().dst_set(set).dst_binding(binding).descriptor_type(kind).image_info(info)
    };
    let (image, filter) = (vk::DescriptorType::SAMPLED_IMAGE, vk::DescriptorType::SAMPLER);
    let mut writes = vec![
        write(binding::ATLAS_SAMPLER, filter, &filters[0]),
        write(binding::MASK, image, &mask),
        write(binding::MASK_SAMPLER, filter, &filters[1]),
        write(binding::TABLE, image, &table),
        write(binding::BLACK, image, &black),
    ];
    writes.extend(pictures.iter().map(|(at, info)| write(*at, image, info)));
    // SAFETY: the set is one of Cupola's and not in use; the views are live.
    unsafe { api.device.update_descriptor_sets(&writes, &[]) };
}
