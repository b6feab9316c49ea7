//! Transformation of a draw's positions to clip coordinates: the array of positions, and matrices.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{Array, Factor, Position, Program};
use crate::intercept::gl::vertex_input::buffers;
use crate::lock::Lock;
use glam::{DMat4, DVec4};

/// Product of matrices.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// The product.
    pub matrix: DMat4,
    /// Product of the entries' absolute values, which limits the error of 32-bit numbers.
    pub sizes: DMat4,
}

impl Transform {
    const NONE: Self = Self { matrix: DMat4::IDENTITY, sizes: DMat4::IDENTITY };

    /// Returns the transformation by one matrix.
    pub fn of(matrix: &DMat4) -> Self {
        Self { matrix: *matrix, sizes: matrix.abs() }
    }

    /// Returns the transformation by `first` and then `self`.
    pub fn after(&self, first: &Self) -> Self {
        Self { matrix: self.matrix * first.matrix, sizes: self.sizes * first.sizes }
    }
}

/// Transformation from eye or clip coordinates of the program to clip coordinates of a view.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Rows of x, y and w.
    pub rows: [DVec4; 3],
    /// Absolute values of the entries, as in [`Transform`].
    pub sizes: [DVec4; 3],
}

impl View {
    /// Returns the transformation by a matrix.
    pub fn of(matrix: &DMat4) -> Self {
        let rows = [0, 1, 3].map(|row| matrix.row(row));
        Self { rows, sizes: rows.map(DVec4::abs) }
    }

    /// Returns the transformation that a patched shader applies with this reprojection matrix
    /// (`shader::source::patch`).
    pub fn of_reprojection(matrix: &ReprojectionMatrix) -> Self {
        let e = f64::from(matrix.depth.pole);
        let rows = [matrix.x, matrix.y, matrix.w].map(|row| row.map(f64::from));
        Self {
            rows: rows.map(|[x, y, w, q]| DVec4::new(x, y, q, w + q * e)),
            sizes: rows.map(|[x, y, w, q]| DVec4::new(x.abs(), y.abs(), q.abs(), w.abs() + (q * e).abs())),
        }
    }
}

/// Returns the array of positions of the next draw, and the number of components that it uses.
/// `None`: not known.
pub fn array(driver: &Driver, app: &AppState, shaders: &Shaders) -> Option<(Array, usize)> {
    match shaders.program().filter(|program| program.draws_vertices()) {
        Some(program) => {
            // In a pipeline a stage of another program may follow and change the position.
            let position = program.position.as_ref().filter(|_| shaders.used() == program.name)?;
            Some((position.array, position.components))
        }
        None => (driver.profile.compatibility() && !app.assembly()).then_some((Array::Conventional, 4)),
    }
}

/// Returns the transformation from positions to the program's eye or clip coordinates, from which
/// the transformations of the views start (see [`of_view`]). `None`: not known.
pub fn transform(ctx: &mut Context, class: DrawClass) -> Option<Transform> {
    match class {
        DrawClass::FixedScene => {
            (!ctx.app.assembly()).then(|| Transform::of(&ctx.compat.projection.model_view(ctx.driver.gl)))
        }
        DrawClass::Scene(_) => {
            let program = ctx.shaders.program().cloned().filter(|program| ctx.shaders.used() == program.name)?;
            clip(&ctx.share, &ctx.driver, &ctx.drawable, &mut ctx.compat, &program, program.position.as_ref()?)
        }
        DrawClass::Flat | DrawClass::Behind | DrawClass::Screen => None,
    }
}

fn clip(
    share: &ShareGroup,
    driver: &Driver,
    drawable: &Drawable,
    compat: &mut Compat,
    program: &Program,
    position: &Position,
) -> Option<Transform> {
    let mut product = Transform::NONE;
    for factor in &position.factors {
        let next = match factor {
            Factor::ModelView => compat.projection.model_view(driver.gl),
            Factor::Projection => {
                compat.projection.refresh(driver.gl, drawable.session());
                *compat.projection.matrix()
            }
            Factor::Uniform(number) => {
                let uniforms = program.uniforms.locked();
                let buffers = buffers::of(share);
                uniforms.matrix(*number, &buffers)?
            }
        };
        product = product.after(&Transform::of(&next));
    }
    Some(product)
}

/// Returns the transformation from the coordinates of [`transform`] to the clip coordinates of the
/// view `index`.
pub fn of_view(compat: &Compat, frame: &Frame, class: DrawClass, index: usize) -> Option<View> {
    match class {
        DrawClass::FixedScene => compat.projection.of_view(index).map(View::of),
        DrawClass::Scene(camera) => frame.cameras().get(camera)?.reprojections.get(index).map(View::of_reprojection),
        DrawClass::Flat | DrawClass::Behind | DrawClass::Screen => None,
    }
}

/// Returns the transformation from the coordinates of [`transform`] to the clip coordinates of the
/// program's own picture.
pub fn of_own_picture(compat: &Compat, class: DrawClass) -> Option<View> {
    match class {
        DrawClass::FixedScene => Some(View::of(compat.projection.matrix())),
        DrawClass::Scene(_) => Some(View::of(&Transform::NONE.matrix)),
        DrawClass::Flat | DrawClass::Behind | DrawClass::Screen => None,
    }
}

#[cfg(test)]
mod tests {
    use super::View;
    use crate::correct::projected::matrices::ReprojectionMatrix;
    use glam::DVec4;

    /// Compares the rows with the epilogue of patched shaders, step by step.
    #[test]
    fn rows_become_those_that_shaders_apply() {
        let numbers = std::array::from_fn(|i| ((i * 7 + 3) % 11) as f32 - 5.0);
        let matrix = ReprojectionMatrix::from_array(numbers);
        let view = View::of_reprojection(&matrix);
        let clip = DVec4::new(0.3, -1.7, 2.2, 5.0);
        let q = clip.z + f64::from(matrix.depth.pole) * clip.w;
        for (found, row) in view.rows.into_iter().zip([matrix.x, matrix.y, matrix.w]) {
            let expected = DVec4::from(row.map(f64::from)).dot(DVec4::new(clip.x, clip.y, clip.w, q));
            assert!((found.dot(clip) - expected).abs() < 1e-12);
        }
        assert!(view.sizes.into_iter().zip(view.rows).all(|(size, row)| size.cmpge(row.abs()).all()));
    }
}
