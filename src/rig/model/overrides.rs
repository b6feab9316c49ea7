//! Values of a rig that are replaced for one run.

use crate::error::Result;
use crate::rig::Rig;

/// Keys of a rig in their one-line forms, as on the command line and in the environment.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// See [`Camera::apply_override`](crate::rig::Camera::apply_override).
    pub camera: Option<String>,
    /// See [`Rig::with_viewer_override`].
    pub viewer: Option<String>,
    /// See [`Rig::with_content_override`].
    pub content: Option<String>,
    /// See [`Rig::with_method_override`].
    pub method: Option<String>,
}

impl Overrides {
    /// Applies them to a rig.
    ///
    /// # Errors
    /// [`InvalidArgument`](crate::ErrorKind::InvalidArgument) for the first wrong one.
    pub fn apply(&self, mut rig: Rig) -> Result<Rig> {
        if let Some(camera) = &self.camera {
            rig.camera = rig.camera.apply_override(camera)?;
        }
        if let Some(viewer) = &self.viewer {
            rig = rig.with_viewer_override(viewer)?;
        }
        if let Some(content) = &self.content {
            rig = rig.with_content_override(content)?;
        }
        if let Some(method) = &self.method {
            rig = rig.with_method_override(method)?;
        }
        Ok(rig)
    }
}
