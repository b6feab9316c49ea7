//! Transformation of a draw's positions to clip coordinates: the array of positions, and matrices.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::compat::projection::multiply;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{Array, Factor, Position, Program};
use crate::intercept::gl::vertex_input::buffers;
use crate::lock::Lock;

/// Product of matrices, in columns.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// The product.
    pub matrix: [f64; 16],
    /// Product of the entries' absolute values, which limits the error of 32-bit numbers.
    pub sizes: [f64; 16],
}

impl Transform {
    const NONE: Self = {
        let matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        Self { matrix, sizes: matrix }
    };

    /// Returns the transformation by one matrix.
    pub fn of(matrix: &[f64; 16]) -> Self {
        Self { matrix: *matrix, sizes: matrix.map(f64::abs) }
    }

    /// Returns the transformation by `first` and then `self`.
    pub fn after(&self, first: &Self) -> Self {
        Self { matrix: multiply(&self.matrix, &first.matrix), sizes: multiply(&self.sizes, &first.sizes) }
    }
}

/// Transformation from eye or clip coordinates of the program to clip coordinates of a view.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Rows of x, y and w.
    pub rows: [[f64; 4]; 3],
    /// Absolute values of the entries, as in [`Transform`].
    pub sizes: [[f64; 4]; 3],
}

impl View {
    /// Returns the transformation by a matrix in columns.
    pub fn of(matrix: &[f64; 16]) -> Self {
        let rows = [0, 1, 3].map(|row| std::array::from_fn(|column| matrix[4 * column + row]));
        Self { rows, sizes: rows.map(|row: [f64; 4]| row.map(f64::abs)) }
    }

    /// Returns the transformation that a patched shader applies with this reprojection matrix
    /// (`shader::source::patch`).
    pub fn of_reprojection(matrix: &ReprojectionMatrix) -> Self {
        let e = f64::from(matrix.depth.pole);
        let rows = [matrix.x, matrix.y, matrix.w].map(|row| row.map(f64::from));
        Self {
            rows: rows.map(|[x, y, w, q]| [x, y, q, w + q * e]),
            sizes: rows.map(|[x, y, w, q]| [x.abs(), y.abs(), q.abs(), w.abs() + (q * e).abs()]),
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

    /// Compares the rows with the epilogue of patched shaders, step by step.
    #[test]
    fn rows_become_those_that_shaders_apply() {
        let rows: [f32; 16] = std::array::from_fn(|i| ((i * 7 + 3) % 11) as f32 - 5.0);
        let view = View::of_reprojection(&ReprojectionMatrix::from_array(rows));
        let [x, y, z, w] = [0.3, -1.7, 2.2, 5.0];
        let q = z + f64::from(rows[12]) * w;
        for (index, [a, b, c, d]) in view.rows.into_iter().enumerate() {
            let r: [f64; 4] = std::array::from_fn(|k| rows[4 * index + k].into());
            let expected = r[0] * x + r[1] * y + r[2] * w + r[3] * q;
            assert!((a * x + b * y + c * z + d * w - expected).abs() < 1e-12);
        }
        assert!(view.sizes.as_flattened().iter().zip(view.rows.as_flattened()).all(|(size, m)| *size >= m.abs()));
    }
}
