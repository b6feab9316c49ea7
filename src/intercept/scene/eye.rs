//! Shaders that keep the projection and the view matrix separate. The eye of a view is turned for
//! them.

use crate::runtime::session::{CameraFunction, Intrinsics, ViewMatrix, eye_axes};
use glam::DMat4;

/// A projection of a shader, and the kinds of its other matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Eye {
    /// Index of the projection, or of its inverse, among the matrices.
    pub projection: usize,
    /// Its lens.
    pub lens: Intrinsics,
    /// The matrices are written for row vectors.
    pub transposed: bool,
    /// For each matrix, whether it leads to eye space or from it, if it is a view matrix.
    pub views: Vec<Option<ViewMatrix>>,
}

impl Eye {
    /// Looks for a projection and view matrices among matrices with these values and `functions` of
    /// the camera. `called` returns the kind of view matrix that a matrix is by its name.
    pub fn of(
        values: &[Option<DMat4>],
        functions: &[Option<(CameraFunction, Intrinsics)>],
        called: impl Fn(usize) -> Option<ViewMatrix>,
    ) -> Option<Self> {
        let alone = |index: usize| {
            let (function, lens) = (*functions.get(index)?)?;
            let value = values.get(index)?.as_ref()?;
            function.is_of_projection(value, &lens).then_some((index, lens, function.is_transposed()))
        };
        let (projection, lens, transposed) = (0..values.len()).find_map(alone)?;
        let rigid = |index: usize| values[index].is_some_and(|value| eye_axes::is_rigid(&value, transposed));
        let view = |index: usize| called(index).filter(|_| functions[index].is_none() && rigid(index));
        let views: Vec<_> = (0..values.len().min(functions.len())).map(view).collect();
        views.iter().any(Option::is_some).then_some(Self { projection, lens, transposed, views })
    }
}

/// Returns the kind of view matrix that a name suggests. The matrix itself must only rotate and
/// translate.
pub fn view_matrix_called(name: &str) -> Option<ViewMatrix> {
    let name = name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    if has(&["inv", "toworld", "to_world", "2world", "c2w", "v2w"]) {
        Some(ViewMatrix::FromEye)
    } else if has(&["view", "toeye", "to_eye", "w2c", "w2v"]) {
        Some(ViewMatrix::ToEye)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{Eye, view_matrix_called};
    use crate::runtime::session::{CameraFunction, Intrinsics, ViewMatrix};
    use glam::{DMat4, DQuat, DVec3};

    #[test]
    fn a_projection_beside_a_view_matrix_is_found() {
        let lens = Intrinsics { a: 1.5, b: 0.0, c: 2.0, d: 0.0, e: -1.02, f: Some(-0.2) };
        let projection = lens.projection(-0.2);
        let turn = DMat4::from_rotation_translation(DQuat::from_rotation_y(0.6), DVec3::new(1.0, 2.0, 3.0));
        let values = [Some(turn), None, Some(projection)];
        let function = CameraFunction::of(&projection, &lens).expect("the projection");
        let functions = [None, None, Some((function, lens))];
        let names = ["camera.viewMatrix", "view", "projection"];
        let eye = Eye::of(&values, &functions, |index| view_matrix_called(names[index])).expect("both");
        assert_eq!((eye.projection, eye.transposed), (2, false));
        assert_eq!(eye.views, [Some(ViewMatrix::ToEye), None, None]);
        assert_eq!(Eye::of(&values, &functions, |_| None), None, "without a name nothing is known");
        assert_eq!(Eye::of(&values[..2], &functions[..2], |_| Some(ViewMatrix::ToEye)), None, "nor without a lens");
    }

    #[test]
    fn names_tell_where_matrices_lead() {
        assert_eq!(view_matrix_called("Camera.inverseView"), Some(ViewMatrix::FromEye));
        assert_eq!(view_matrix_called("u_ViewMatrix"), Some(ViewMatrix::ToEye));
        assert_eq!(view_matrix_called("model"), None);
    }
}
