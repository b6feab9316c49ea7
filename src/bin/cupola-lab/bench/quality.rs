//! Quality of the picture of a correction, compared with many samples per pixel of an analytic
//! scene.

use cupola::correct::Plan;
use cupola::views::View;
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};

/// Sample positions of a texel with four samples, as in multisampling.
const FOUR: [DVec2; 4] =
    [DVec2::new(0.125, 0.375), DVec2::new(-0.375, 0.125), DVec2::new(-0.125, -0.375), DVec2::new(0.375, -0.125)];
/// Number of samples per pixel in each direction for the reference picture.
const SAMPLES: u32 = 6;
/// Width in pixels of the squares whose means and variances are compared.
const BLOCK: usize = 8;
/// Number of cells of the checker pattern per radian.
const CELLS: f64 = 6.0 / std::f64::consts::PI;

/// Similarity of a picture to the reference picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Peak signal to noise ratio, dB.
    pub psnr: f64,
    /// Structural similarity (Wang et al. 2004), mean over squares of 8 pixels without overlap; 1
    /// for equal pictures.
    pub ssim: f64,
}

/// A black and white checker pattern in space. Its edges are not parallel to borders of pixels,
/// texels or views.
fn scene(direction: DVec3) -> f64 {
    let turned = DVec3::new(
        direction.dot(DVec3::new(0.64, 0.48, 0.6)),
        direction.dot(DVec3::new(-0.6, 0.8, 0.0)),
        direction.dot(DVec3::new(-0.48, -0.36, 0.8)),
    );
    let cell = (turned * (CELLS / direction.length()) + DVec3::new(0.1, 0.35, 0.63)).floor();
    f64::from(u8::from((cell.x + cell.y + cell.z) as i64 % 2 == 0))
}

/// A picture of the scene. `towards` maps a position in texels, from the first corner of the first
/// row, to a direction.
fn drawn(size: (u32, u32), towards: impl Fn(DVec2) -> Option<DVec3> + Sync) -> Vec<u32> {
    let texel = |x: u32, y: u32| {
        let centre = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let light = FOUR.iter().map(|place| towards(centre + *place).map_or(0.0, scene)).sum::<f64>();
        0xff00_0000 | ((255.0 * light / FOUR.len() as f64).round() as u32 * 0x0001_0101)
    };
    in_rows(size.1, |y| (0..size.0).map(|x| texel(x, y)).collect())
}

/// The atlas of a plan, the first row at the bottom.
pub fn atlas(plan: &Plan) -> Vec<u32> {
    let within = |view: &&View, at: DVec2| {
        let tile = view.tile;
        let (low, size) = (
            DVec2::new(f64::from(tile.x), f64::from(tile.y)),
            DVec2::new(f64::from(tile.width), f64::from(tile.height)),
        );
        at.cmpge(low).all() && at.cmplt(low + size).all()
    };
    drawn(plan.views.atlas, |at| {
        let view = plan.views.views.iter().find(|view| within(view, at))?;
        let (tile, frustum) = (view.tile, view.frustum);
        let part = (at - DVec2::new(f64::from(tile.x), f64::from(tile.y)))
            / DVec2::new(f64::from(tile.width), f64::from(tile.height));
        let tangent = DVec2::new(frustum.left, frustum.bottom) + part * DVec2::new(frustum.width(), frustum.height());
        Some(view.rotation.transpose() * tangent.extend(-1.0))
    })
}

/// The faces of a cube map in OpenGL's order and orientation.
pub fn cube(side: u32) -> Vec<Vec<u32>> {
    let axes: [fn(f64, f64) -> DVec3; 6] = [
        |s, t| DVec3::new(1.0, -t, -s),
        |s, t| DVec3::new(-1.0, -t, s),
        |s, t| DVec3::new(s, 1.0, t),
        |s, t| DVec3::new(s, -1.0, -t),
        |s, t| DVec3::new(s, -t, 1.0),
        |s, t| DVec3::new(-s, -t, -1.0),
    ];
    let face = |towards: fn(f64, f64) -> DVec3| {
        drawn((side, side), |at| {
            let place = 2.0 * at / f64::from(side) - 1.0;
            Some(towards(place.x, place.y))
        })
    };
    axes.map(face).into()
}

/// A domemaster, the first row at the bottom. `content` is its map with a size of 1 × 1.
pub fn domemaster(size: (u32, u32), content: &WarpMap) -> Vec<u32> {
    let whole = DVec2::new(f64::from(size.0), f64::from(size.1));
    drawn(size, |at| {
        let place = at / whole;
        content.direction(DVec2::new(place.x, 1.0 - place.y))
    })
}

/// The reference value of each pixel, 0…1, row by row from the top; NaN for pixels that show the
/// scene only in part.
pub fn truth(exact: &WarpMap) -> Vec<f64> {
    let (width, height) = exact.size();
    let pixel = |x: u32, y: u32| {
        let mut sum = 0.0;
        for sample in 0..SAMPLES * SAMPLES {
            let part = |index: u32| (f64::from(index) + 0.5) / f64::from(SAMPLES);
            let place = DVec2::new(f64::from(x) + part(sample % SAMPLES), f64::from(y) + part(sample / SAMPLES));
            sum += exact.direction(place).map_or(f64::NAN, scene);
        }
        sum / f64::from(SAMPLES * SAMPLES)
    };
    in_rows(height, |y| (0..width).map(|x| pixel(x, y)).collect())
}

/// The quality of a grey picture (0…255, row by row from the top) of the given width.
pub fn quality(picture: &[u8], truth: &[f64], width: usize) -> Quality {
    let pairs: Vec<(f64, f64)> =
        picture.iter().map(|value| f64::from(*value) / 255.0).zip(truth.iter().copied()).collect();
    let known = pairs.iter().filter(|(_, exact)| exact.is_finite());
    let (sum, count) =
        known.fold((0.0, 0.0), |(sum, count), (value, exact)| (sum + (value - exact).powi(2), count + 1.0));
    let (mut similarity, mut blocks) = (0.0, 0.0);
    for (top, left) in
        (0..truth.len() / width / BLOCK).flat_map(|y| (0..width / BLOCK).map(move |x| (y * BLOCK, x * BLOCK)))
    {
        let block = (0..BLOCK * BLOCK).map(|i| pairs[(top + i / BLOCK) * width + left + i % BLOCK]);
        if let Some(value) = structural(block) {
            similarity += value;
            blocks += 1.0;
        }
    }
    Quality { psnr: -10.0 * f64::log10(sum / count), ssim: similarity / blocks }
}

/// The structural similarity of a square; `None` if it contains pixels without a reference value.
fn structural(block: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (mut a, mut b, mut aa, mut bb, mut ab, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, y) in block {
        (a, b, count) = (a + x, b + y, count + 1.0);
        (aa, bb, ab) = (aa + x * x, bb + y * y, ab + x * y);
    }
    let (a, b) = (a / count, b / count);
    let (variance_a, variance_b, covariance) = (aa / count - a * a, bb / count - b * b, ab / count - a * b);
    // Constants of the paper for values up to 1.
    let (c1, c2) = (0.01f64.powi(2), 0.03f64.powi(2));
    let similarity =
        (2.0 * a * b + c1) * (2.0 * covariance + c2) / ((a * a + b * b + c1) * (variance_a + variance_b + c2));
    similarity.is_finite().then_some(similarity)
}

/// The values of all rows, computed on all processors.
pub fn in_rows<T: Send>(rows: u32, row: impl Fn(u32) -> Vec<T> + Sync) -> Vec<T> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from) as u32;
    let part = rows.div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let row = &row;
        let parts: Vec<_> = (0..threads)
            .map(|number| {
                let rows = (number * part).min(rows)..((number + 1) * part).min(rows);
                scope.spawn(move || rows.flat_map(row).collect::<Vec<T>>())
            })
            .collect();
        // A thread that panics has printed a message.
        parts.into_iter().flat_map(|part| part.join().unwrap_or_default()).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_is_the_same_and_noise_is_not() {
        let truth: Vec<f64> = (0..64 * 64).map(|i| f64::from(u8::from(i % 64 / 5 % 2 == i / 64 / 7 % 2))).collect();
        let picture = |noise: i32| -> Vec<u8> {
            let shift = |i: usize| if i * 7919 % 13 < 6 { noise } else { -noise };
            truth.iter().enumerate().map(|(i, value)| ((255.0 * value) as i32 + shift(i)).clamp(0, 255) as u8).collect()
        };
        let same = quality(&picture(0), &truth, 64);
        assert!(same.psnr.is_infinite() && (same.ssim - 1.0).abs() < 1e-9, "{same:?}");
        let (little, much) = (quality(&picture(10), &truth, 64), quality(&picture(80), &truth, 64));
        assert!(little.psnr > much.psnr + 10.0 && little.ssim > much.ssim, "{little:?} {much:?}");
    }

    #[test]
    fn rows_keep_their_order() {
        assert_eq!(in_rows(7, |y| vec![y, y]), [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6]);
        assert!(in_rows(0, |y| vec![y]).is_empty());
    }
}
