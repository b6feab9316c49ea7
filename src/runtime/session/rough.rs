//! A rig that is being edited, over the views of the plan before.

use crate::correct::Plan;
use crate::correct::rough;
use crate::rig::{Output, Rig};
use crate::runtime::session::Session;

impl Session {
    /// Returns passes that show another rig over the views of this session; `None` if these cannot
    /// serve it. It takes a few milliseconds for an output, a plan of its own up to a second.
    pub fn rough(&self, rig: &Rig) -> Option<Plan> {
        let is_same = |(old, new): (&Output, &Output)| {
            (&old.name, old.here, old.size, old.publish, old.eye)
                == (&new.name, new.here, new.size, new.publish, new.eye)
        };
        let (old, new) = (self.rig.with_all_outputs(), rig.with_all_outputs());
        let serves = self.turns.is_none()
            && old.outputs.len() == new.outputs.len()
            && self.rig.outputs.len() == rig.outputs.len()
            && old.outputs.iter().zip(&new.outputs).all(is_same)
            && rig.views.duplicate == self.rig.views.duplicate
            && rig.layout(self.request.window) == self.rects;
        if !serves {
            return None;
        }
        rough::plan(&new, &self.request, &self.plan, self.needed)
    }
}
