//! Vulkan shows what OpenGL shows.

use super::headless;
use crate::backend::gl::driver::headless::{Api, Headless};
use crate::backend::tests::Driver;
use crate::backend::tests::picture::Picture;
use crate::backend::tests::present::waves;
use crate::correct::build;
use crate::rig;
use crate::views::Request;

/// Returns the number of channels that differ by more than 1, and the greatest difference.
fn differences(a: &Picture, b: &Picture) -> (usize, u8) {
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let differences = pairs.map(|(a, b)| a.abs_diff(*b));
    differences.fold((0, 0), |(count, most), d| (count + usize::from(d > 1), most.max(d)))
}

#[test]
fn domemasters_and_projectors_differ_by_a_code_at_most() {
    let gl = Headless::new(Api::Core).expect("a driver that draws without a window (Mesa's llvmpipe will do)");
    let vk = headless();
    for name in ["fisheye", "fisheye-210", "planetarium-6"] {
        let rig = rig::load(name).expect("a preset loads");
        let request = Request {
            output_sizes: vec![(512, 512); rig.outputs.len()],
            window: (512, 512),
            panel: false,
            primary: false,
            max_atlas: 8192,
        };
        let mut plan = build(&rig, &request).expect("a preset can be planned");
        plan.passes.truncate(1);
        let atlas = waves(plan.views.atlas);
        let (first, second) = (gl.show(&plan, false, &atlas), vk.show(&plan, false, &atlas));
        let (beyond, most) = differences(&first, &second);
        println!("{name}: {beyond} channels beyond 1, at most {most}");
        // Where two views meet, either may be sampled; here they show unrelated waves.
        assert!(beyond <= 12, "{name}: {beyond} channels differ, by up to {most}");
        // Negative control: another atlas is another picture.
        let other = Picture::new(atlas.size, |x, y| atlas.at(x, atlas.size.1 - 1 - y));
        assert!(differences(&first, &vk.show(&plan, false, &other)).0 > 10_000);
    }
}
