//! Copies of the program's descriptor sets, one for each view, that show its shaders the view's print in the place of a
//! picture of the scene, and the twin in the place of an attachment that they read.

use crate::intercept::vk::descriptors::sets::SetLayout;
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::offscreen::scenes::Prints;
use crate::intercept::vk::swapchain::atlas_layout::Layout;
use ash::vk;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A descriptor: binding and element of its array.
pub type Place = (u32, u32);

/// What a descriptor shows a picture by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The view of its image.
    pub view: vk::ImageView,
    /// The sampler, where the layout has none.
    pub sampler: vk::Sampler,
    /// Of an attachment that is read at the pixel that is drawn: the layout that it is in then.
    pub attachment: Option<vk::ImageLayout>,
}

/// What was written to a set.
#[derive(Default)]
pub struct Contents {
    written: BTreeSet<Place>,
    pictures: BTreeMap<Place, Picture>,
    /// Grows with each change.
    version: u64,
}

impl Contents {
    /// A descriptor is written; with a picture, or with something else.
    pub fn write(&mut self, place: Place, picture: Option<Picture>) {
        self.version += 1;
        self.written.insert(place);
        match picture {
            Some(picture) => self.pictures.insert(place, picture),
            None => self.pictures.remove(&place),
        };
    }

    /// The descriptor of another set is copied to one of this.
    pub fn copy(&mut self, from: &Self, (source, target): (Place, Place)) {
        if from.written.contains(&source) {
            self.write(target, from.pictures.get(&source).copied());
        }
    }

    /// Views of the images that shaders can sample.
    pub fn views(&self) -> impl Iterator<Item = vk::ImageView> + '_ {
        self.pictures.values().filter(|picture| picture.attachment.is_none()).map(|picture| picture.view)
    }

    /// Whether shaders can read attachments.
    pub fn reads_attachments(&self) -> bool {
        self.pictures.values().any(|picture| picture.attachment.is_some())
    }
}

/// The copies of a set.
pub struct Copies {
    pool: vk::DescriptorPool,
    version: u64,
    prints: Vec<Print>,
    sets: Arc<[vk::DescriptorSet]>,
    /// Pools of copies that may still be in use.
    retired: Vec<vk::DescriptorPool>,
}

/// A descriptor that shows the scene, and what each view sees in its place.
type Print = (Place, Picture, Prints);

/// A set of the program.
pub struct Original<'a> {
    /// The set.
    pub set: vk::DescriptorSet,
    /// Its layout, if the program still has it.
    pub handle: Option<vk::DescriptorSetLayout>,
    /// What that holds.
    pub layout: &'a SetLayout,
    /// What was written.
    pub contents: &'a Contents,
}

impl Copies {
    /// The copies of a set for the views of `layout`, made or brought up to date; `None` where it shows nothing of the
    /// scene. The program changes a set only while no commands that use it run, so that its copies are not in use then, either.
    ///
    /// # Errors
    /// Why there are none.
    pub fn of(
        kept: &mut Option<Self>,
        device: &Device,
        original: &Original<'_>,
        layout: &Layout,
    ) -> Result<Option<Arc<[vk::DescriptorSet]>>, String> {
        let mut prints = Vec::new();
        for (place, picture) in &original.contents.pictures {
            let print = match picture.attachment {
                Some(_) => Some(Prints::same(device.images.twin(device, picture.view, layout)?, layout.views.len())),
                None => device.images.prints(device, picture.view, layout)?,
            };
            prints.extend(print.map(|print| (*place, *picture, print)));
        }
        if prints.is_empty() {
            return Ok(None);
        }
        let views = layout.views.len();
        let version = original.contents.version;
        // Without a change by the program the copies may be in use.
        let in_use = |kept: &Self| kept.version == version && kept.prints != prints;
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
            copies.update(device, original, &prints);
            copies.prints = prints;
        }
        Ok(Some(Arc::clone(&copies.sets)))
    }

    fn new(device: &Device, original: &Original<'_>, views: usize) -> Result<Self, String> {
        let handle = original.handle.ok_or("a descriptor set whose layout is gone")?;
        if original.layout.changes_later {
            return Err("its descriptors may change after they are bound".to_owned());
        }
        let mut sizes: BTreeMap<vk::DescriptorType, u32> = BTreeMap::new();
        for (kind, count) in original.layout.bindings.values().filter(|(_, count)| *count > 0) {
            *sizes.entry(*kind).or_default() += count * views as u32;
        }
        let size = |(ty, descriptor_count)| vk::DescriptorPoolSize { ty, descriptor_count };
        let sizes: Vec<_> = sizes.into_iter().map(size).collect();
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(views as u32).pool_sizes(&sizes);
        let refused = |error: vk::Result| format!("the driver refuses descriptors: {error}");
        // SAFETY: the device is live; the layout is the program's, which it has not destroyed.
        unsafe {
            let pool = device.functions.create_descriptor_pool(&info, None).map_err(refused)?;
            let layouts = vec![handle; views];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let sets = device.functions.allocate_descriptor_sets(&info);
            let sets = sets.inspect_err(|_| device.functions.destroy_descriptor_pool(pool, None)).map_err(refused)?;
            Ok(Self { pool, version: 0, prints: Vec::new(), sets: sets.into(), retired: Vec::new() })
        }
    }

    fn update(&self, device: &Device, original: &Original<'_>, prints: &[Print]) {
        for (view, set) in self.sets.iter().enumerate() {
            let copy = |(binding, element): &Place| {
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
            let infos: Vec<_> = prints
                .iter()
                .filter_map(|(place, picture, prints)| {
                    let image = [vk::DescriptorImageInfo {
                        sampler: picture.sampler,
                        image_view: *prints.views.get(view)?,
                        image_layout: picture
                            .attachment
                            .unwrap_or(crate::intercept::vk::offscreen::view_copies::SAMPLED),
                    }];
                    Some((*place, image))
                })
                .collect();
            let write = |((binding, element), image): &'_ (Place, [vk::DescriptorImageInfo; 1])| {
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
            // SAFETY: sets of ours that nothing uses now, laid out as the program's; what `writes` points at lives.
            unsafe {
                device.functions.update_descriptor_sets(&[], &copies);
                device.functions.update_descriptor_sets(&writes, &[]);
            }
        }
    }

    /// The program's set is gone.
    pub fn destroy(self, device: &Device) {
        // SAFETY: ours; the program says by giving its own up that nothing uses them.
        unsafe {
            self.retired
                .iter()
                .chain([&self.pool])
                .for_each(|pool| device.functions.destroy_descriptor_pool(*pool, None))
        };
    }
}

#[cfg(test)]
mod tests {
    use super::{Contents, Picture};
    use ash::vk::{self, Handle};

    #[test]
    fn what_was_written_last_counts() {
        let picture =
            |number| Picture { view: vk::ImageView::from_raw(number), sampler: vk::Sampler::null(), attachment: None };
        let (mut from, mut to) = (Contents::default(), Contents::default());
        from.write((3, 1), Some(picture(7)));
        to.copy(&from, ((3, 1), (0, 0)));
        to.copy(&from, ((9, 9), (1, 0)));
        assert_eq!(to.views().collect::<Vec<_>>(), [vk::ImageView::from_raw(7)]);
        assert_eq!(to.written.len(), 1, "what was never written is not copied");
        let version = to.version;
        to.write((0, 0), None);
        assert!(to.views().next().is_none() && to.version > version);
        to.write((0, 0), Some(Picture { attachment: Some(vk::ImageLayout::GENERAL), ..picture(8) }));
        assert!(to.views().next().is_none() && to.reads_attachments(), "an attachment is not sampled");
    }
}
