//! Rectangles of a rig's outputs in a window.

use super::{Output, Rig};
use crate::geom::PixelRect;

impl Rig {
    /// Rectangles of the outputs, in their order, in a window of `window` pixels. Outputs with a
    /// `window` of their own have that, cropped to the window. Otherwise a single output has the
    /// whole window, and several share it in a near-square grid, row by row from the top left. A
    /// rectangle without pixels has width or height 0; so have outputs of other machines and outputs that are not shown in
    /// the window.
    pub fn layout(&self, window: (u32, u32)) -> Vec<PixelRect> {
        let columns = self.columns();
        let rows = self.outputs_here().div_ceil(columns);
        // Cells share their borders exactly: the end of a cell is computed as the start of the next
        // one.
        let cut =
            |extent: u32, index: u32, parts: u32| (u64::from(extent) * u64::from(index) / u64::from(parts)) as u32;
        let cell = |index: u32| {
            let (column, row) = (index % columns, index / columns);
            let (x, y) = (cut(window.0, column, columns), cut(window.1, row, rows));
            PixelRect::new(x, y, cut(window.0, column + 1, columns) - x, cut(window.1, row + 1, rows) - y)
        };
        let crop = |PixelRect { x, y, width, height }| {
            let (x, y) = (x.min(window.0), y.min(window.1));
            match (width.min(window.0 - x), height.min(window.1 - y)) {
                (0, _) | (_, 0) => PixelRect::new(x, y, 0, 0),
                (width, height) => PixelRect::new(x, y, width, height),
            }
        };
        let mut cells = (0..).map(cell);
        let place = |output: &Output| match output.window {
            _ if !output.has_place() => PixelRect::new(0, 0, 0, 0),
            Some(place) => crop(place),
            None => cells.next().unwrap_or(PixelRect::new(0, 0, 0, 0)),
        };
        self.outputs.iter().map(place).collect()
    }

    /// Sizes in pixels of the outputs, in their order, with a window of `window` pixels: those of
    /// their rectangles, and the own size of outputs that the window does not show.
    pub fn sizes(&self, window: (u32, u32)) -> Vec<(u32, u32)> {
        let places = self.layout(window);
        let size = |(output, place): (&Output, &PixelRect)| match output.has_place() {
            true => place.size(),
            false => output.size.unwrap_or_default(),
        };
        self.outputs.iter().zip(&places).map(size).collect()
    }

    /// Size in pixels of a window in which every output has its own resolution: the hull of the
    /// outputs' `window` rectangles, or the grid of their `size`. `None` if an output has neither.
    pub fn extent(&self) -> Option<(u32, u32)> {
        let here = || self.outputs.iter().filter(|output| output.has_place());
        here().next()?;
        if let Some(places) = here().map(|output| output.window).collect::<Option<Vec<_>>>() {
            let right = places.iter().map(|place| place.x.saturating_add(place.width)).max();
            let bottom = places.iter().map(|place| place.y.saturating_add(place.height)).max();
            return right.zip(bottom);
        }
        let sizes = here().map(|output| output.size).collect::<Option<Vec<_>>>()?;
        let columns = self.columns();
        let rows = (sizes.len() as u32).div_ceil(columns);
        let width = sizes.iter().map(|size| size.0).max()?;
        let height = sizes.iter().map(|size| size.1).max()?;
        Some((width.saturating_mul(columns), height.saturating_mul(rows)))
    }

    /// Returns a remark if outputs of `sizes` pixels, in a window of `window` pixels, have less than
    /// half of the width or height that the rig gives them.
    pub fn too_small(&self, window: (u32, u32), sizes: &[(u32, u32)]) -> Option<String> {
        let outputs = self.outputs.iter().zip(sizes).filter(|(output, _)| output.has_place());
        let short = outputs.filter_map(|(output, size)| {
            let wanted = output.window.map(|place| place.size()).or(output.size)?;
            (2 * u64::from(size.0) < wanted.0.into() || 2 * u64::from(size.1) < wanted.1.into())
                .then_some((output, *size, wanted))
        });
        let short: Vec<_> = short.collect();
        let (output, size, wanted) = short.first()?;
        let others = match short.len() - 1 {
            0 => String::new(),
            others => format!(", and {others} more outputs too few"),
        };
        let cure = match self.extent() {
            Some((width, height)) => format!("; make the window {width} × {height}, with --size {width}x{height}"),
            None => "; make the window larger, with --size WxH".to_owned(),
        };
        Some(format!(
            "a window of {} × {} pixels gives output {} {} × {} of its {} × {} pixels{others}{cure}",
            window.0, window.1, output.name, size.0, size.1, wanted.0, wanted.1
        ))
    }

    /// Number of columns of the grid of outputs, at least one.
    fn columns(&self) -> u32 {
        (1..).find(|columns| columns * columns >= self.outputs_here()).unwrap_or(1)
    }

    /// Number of outputs that the window shows.
    fn outputs_here(&self) -> u32 {
        self.outputs.iter().filter(|output| output.has_place()).count() as u32
    }
}

impl Output {
    /// True if this machine's window shows the output.
    fn has_place(&self) -> bool {
        self.here && self.shown
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn outputs_that_the_window_does_not_show_have_their_own_size() {
        let output = |keys: &str| format!("[[output]]\nkind = \"domemaster\"\nsize = [30, 20]\n{keys}\n");
        let text = output("shown = false") + &output("") + &output("fullscreen = true");
        let rig = crate::rig::parse(&text, "rig.toml", Path::new("")).expect("a rig");
        assert_eq!(rig.sizes((100, 50)), [(100, 50)]);
        assert_eq!(rig.with_all_outputs().sizes((100, 50)), [(100, 50), (30, 20), (30, 20)]);
    }

    #[test]
    fn outputs_with_far_too_few_pixels_are_remarked_with_the_size_that_fits() {
        let rig = crate::rig::load("planetarium-6").expect("a preset");
        let remark = |window| {
            let sizes: Vec<_> = rig.layout(window).iter().map(|rect| rect.size()).collect();
            rig.too_small(window, &sizes)
        };
        let words = remark((300, 300)).expect("100 × 150 pixels are too few");
        for part in ["front 100 × 150 of its 1920 × 1080", "5 more", "--size 5760x2160"] {
            assert!(words.contains(part), "{words}");
        }
        // Half of the pixels in each direction is enough, and so is the window that is proposed.
        assert_eq!([remark((2880, 1080)), remark((5760, 2160))], [None, None]);
        assert!(remark((2870, 1080)).is_some() && remark((2880, 1070)).is_some());
        // A rig that gives no sizes asks for none.
        let text = "[[output]]\nkind = \"domemaster\"\n";
        let plain = crate::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        assert_eq!(plain.too_small((10, 10), &[(10, 10)]), None);
    }
}
