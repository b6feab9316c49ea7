//! Copies of the program's descriptor sets, one per view. The view copy replaces an image of the
//! scene, and the atlas copy replaces an attachment that shaders read.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::descriptors::SetLayout;
use crate::intercept::vk::state::descriptors::set_contents::{Contents, CopiedDescriptor, Copies, DescriptorSlot};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::ViewCopies;
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use ash::vk;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A set of the program.
pub struct ProgramSet<'a> {
    /// The set.
    pub set: vk::DescriptorSet,
    /// Its layout, if the program still has it.
    pub handle: Option<vk::DescriptorSetLayout>,
    /// Bindings of the layout.
    pub layout: &'a SetLayout,
    /// Descriptors that were written.
    pub contents: &'a Contents,
}

impl Copies {
    /// Returns the copies of a set for the views of `layout`, which are made or updated; `None` if
    /// the set does not refer to the scene. The program changes a set only while no running
    /// commands use it, so that its copies are not in use then, either.
    ///
    /// # Errors
    /// The reason why there are none.
    pub fn of(
        kept: &mut Option<Self>,
        device: &Device,
        original: &ProgramSet<'_>,
        layout: &AtlasLayout,
    ) -> Result<Option<Arc<[vk::DescriptorSet]>>, Obstacle> {
        let mut view_copies = Vec::new();
        for (place, picture) in &original.contents.pictures {
            let view_copy = match picture.attachment {
                Some(_) => {
                    Some(ViewCopies::same(device.images.atlas_copy(device, picture.view, layout)?, layout.views.len()))
                }
                None => device.images.view_copies(device, picture.view, layout)?,
            };
            view_copies.extend(view_copy.map(|view_copy| (*place, *picture, view_copy)));
        }
        if view_copies.is_empty() {
            return Ok(None);
        }
        let views = layout.views.len();
        let version = original.contents.version;
        // If the program has not changed the set, the copies may be in use.
        let in_use = |kept: &Self| kept.version == version && kept.view_copies != view_copies;
        if kept.as_ref().is_some_and(|kept| kept.sets.len() != views || in_use(kept)) {
            let mut new = Self::new(device, original, views)?;
            if let Some(old) = kept.take() {
                new.retired = old.retired;
                new.retired.push(old.pool);
            }
            *kept = Some(new);
        }
        let copies = match kept {
            Some(copies) => copies,
            None => kept.insert(Self::new(device, original, views)?),
        };
        if copies.version != version {
            copies.version = version;
            copies.update(device, original, &view_copies);
            copies.view_copies = view_copies;
        }
        Ok(Some(Arc::clone(&copies.sets)))
    }

    fn new(device: &Device, original: &ProgramSet<'_>, views: usize) -> Result<Self, Obstacle> {
        let handle = original.handle.ok_or("a descriptor set whose layout is gone")?;
        if original.layout.changes_later {
            return Err("its descriptors may change after they are bound".into());
        }
        let mut sizes: BTreeMap<vk::DescriptorType, u32> = BTreeMap::new();
        for (kind, count) in original.layout.bindings.values().filter(|(_, count)| *count > 0) {
            *sizes.entry(*kind).or_default() += count * views as u32;
        }
        let size = |(ty, descriptor_count)| vk::DescriptorPoolSize { ty, descriptor_count };
        let sizes: Vec<_> = sizes.into_iter().map(size).collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(views as u32).pool_sizes(&sizes);
        let refused = |error: vk::Result| format!("the driver refuses descriptors: {error}");
        // SAFETY: the device is live; the program has not destroyed its layout.
        unsafe {
            let pool = device.driver.functions.create_descriptor_pool(&info, None).map_err(refused)?;
            let layouts = vec![handle; views];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let sets = device.driver.functions.allocate_descriptor_sets(&info);
            let sets =
                sets.inspect_err(|_| device.driver.functions.destroy_descriptor_pool(pool, None)).map_err(refused)?;
            Ok(Self { pool, version: 0, view_copies: Vec::new(), sets: sets.into(), retired: Vec::new() })
        }
    }

    fn update(&self, device: &Device, original: &ProgramSet<'_>, view_copies: &[CopiedDescriptor]) {
        for (view, set) in self.sets.iter().enumerate() {
            let copy = |(binding, element): &DescriptorSlot| {
                vk::CopyDescriptorSet::default()
                    .src_set(original.set)
                    .src_binding(*binding)
                    .src_array_element(*element)
                    .dst_set(*set)
                    .dst_binding(*binding)
                    .dst_array_element(*element)
                    .descriptor_count(1)
            };
            let copies: Vec<_> = original.contents.written.iter().map(copy).collect();
            let infos: Vec<_> = view_copies
                .iter()
                .filter_map(|(place, picture, view_copies)| {
                    let image = [vk::DescriptorImageInfo {
                        sampler: picture.sampler,
                        image_view: *view_copies.views.get(view)?,
                        image_layout: picture.attachment.unwrap_or(view_copies.layout),
                    }];
                    Some((*place, image))
                })
                .collect();
            let write = |((binding, element), image): &'_ (DescriptorSlot, [vk::DescriptorImageInfo; 1])| {
                let kind = original.layout.bindings.get(binding).map_or(vk::DescriptorType::SAMPLED_IMAGE, |b| b.0);
                let mut write = vk::WriteDescriptorSet::default()
                    .dst_set(*set)
                    .dst_binding(*binding)
                    .dst_array_element(*element)
                    .descriptor_type(kind);
                write.descriptor_count = 1;
                write.p_image_info = image.as_ptr();
                write
            };
            let writes: Vec<_> = infos.iter().map(write).collect();
            // SAFETY: nothing uses these sets of Cupola now; they have the layout of the program's
            // set, and everything that `writes` points at lives.
            unsafe {
                device.driver.functions.update_descriptor_sets(&[], &copies);
                device.driver.functions.update_descriptor_sets(&writes, &[]);
            }
        }
    }

    /// Destroys the copies of a destroyed set.
    pub fn destroy(self, device: &Device) {
        // SAFETY: objects of Cupola; nothing uses them, since the program has destroyed its set.
        unsafe {
            self.retired
                .iter()
                .chain([&self.pool])
                .for_each(|pool| device.driver.functions.destroy_descriptor_pool(*pool, None))
        };
    }
}
