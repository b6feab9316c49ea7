//! A rig that is being edited, over the views of the plan before.

use crate::correct::{Plan, over, rough};
use crate::error::Result;
use crate::rig::{Output, Rig};
use crate::runtime::cache;
use crate::runtime::session::{Session, needed};
use std::sync::Mutex;

impl Session {
    /// Returns passes that show another rig roughly over the views of this session; `None` if these
    /// cannot serve it. It takes a few milliseconds for an output, a plan of its own up to a second.
    pub fn rough(&self, rig: &Rig) -> Option<Plan> {
        let rig = self.serves(rig).then(|| rig.with_all_outputs())?;
        rough::plan(&rig, &self.request, &self.plan, self.needed)
    }

    /// Returns a session that shows another rig as [`Session::rough`]; `None` if the views of this one
    /// cannot serve it.
    pub fn roughly_over(&self, rig: &Rig) -> Option<Self> {
        Some(self.with_plan(rig, self.rough(rig)?))
    }

    /// Returns a session that shows another rig exactly over the views of this one; `None` if these
    /// cannot serve it.
    ///
    /// # Errors
    /// As for [`Session::new`], without those of the views.
    pub fn over(&self, rig: &Rig) -> Result<Option<Self>> {
        if !self.serves(rig) {
            return Ok(None);
        }
        let plan = over::plan(&rig.with_all_outputs(), &self.request, &self.plan, self.needed, cache::of_process())?;
        Ok(plan.map(|plan| self.with_plan(rig, plan)))
    }

    /// Returns a session of another rig and its plan over the views of this one.
    fn with_plan(&self, rig: &Rig, plan: Plan) -> Self {
        Self {
            needed: needed(rig, &plan),
            camera: Mutex::new(rig.camera),
            plan,
            rig: rig.clone(),
            draws: self.draws,
            request: self.request.clone(),
            rects: self.rects.clone(),
            refused: self.refused.clone(),
            turns: None,
        }
    }

    /// True if the views of this session may serve another rig: its outputs have the same places,
    /// sizes and methods.
    fn serves(&self, rig: &Rig) -> bool {
        let is_same = |(old, new): (&Output, &Output)| {
            (&old.name, old.here, old.size, old.publish, old.eye, &old.method)
                == (&new.name, new.here, new.size, new.publish, new.eye, &new.method)
        };
        let (old, new) = (self.rig.with_all_outputs(), rig.with_all_outputs());
        self.turns.is_none()
            && old.outputs.len() == new.outputs.len()
            && self.rig.outputs.len() == rig.outputs.len()
            && old.outputs.iter().zip(&new.outputs).all(is_same)
            && rig.views.duplicate == self.rig.views.duplicate
            && rig.layout(self.request.window) == self.rects
    }
}
