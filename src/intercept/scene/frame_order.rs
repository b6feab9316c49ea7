//! The order of flat drawing and scene in a frame.
//!
//! The panel lies over everything, which is right for menus and labels. Flat draws *before* the
//! scene (a sky, a gradient) belong behind the scene. Whether a scene will follow is predicted from
//! the frame before.

/// Order of flat drawing and scene, in the last frame and so far in this one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameOrder {
    /// Flat drawing came before the scene in the last frame.
    flat_was_first: bool,
    flat_first: bool,
    scene: bool,
}

impl FrameOrder {
    /// Notes a draw of the scene.
    pub fn note_scene(&mut self) {
        self.scene = true;
    }

    /// Notes a flat draw.
    pub fn note_flat(&mut self) {
        self.flat_first |= !self.scene;
    }

    /// True if a flat draw goes behind the scene now.
    pub fn is_behind(&self) -> bool {
        self.flat_was_first && !self.scene
    }

    /// Ends the frame.
    pub fn end_frame(&mut self) {
        *self = Self { flat_was_first: self.flat_first && self.scene, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::FrameOrder;

    #[test]
    fn flat_drawing_before_the_scene_is_behind_it_in_the_next_frame() {
        let mut order = FrameOrder::default();
        order.note_flat();
        assert!(!order.is_behind(), "it is not known yet that a scene follows");
        order.note_scene();
        order.note_flat();
        order.end_frame();
        assert!(order.is_behind());
        order.note_flat();
        order.note_scene();
        assert!(!order.is_behind(), "a label after the scene");
        order.end_frame();
        assert!(order.is_behind());
    }

    #[test]
    fn flat_frames_and_scenes_alone_have_nothing_behind() {
        for (flat, scene) in [(true, false), (false, true), (false, false)] {
            let mut order = FrameOrder::default();
            if scene {
                order.note_scene();
            }
            if flat {
                order.note_flat();
            }
            order.end_frame();
            assert!(!order.is_behind());
        }
        let mut order = FrameOrder::default();
        order.note_scene();
        order.note_flat();
        order.end_frame();
        assert!(!order.is_behind(), "labels after the scene are not behind it");
    }
}
