//! A program's finished picture, shown on the rig's panel without a graphics API.
//!
//! For programs whose draws cannot be issued once for each view. Where each pixel of the outputs looks is
//! traced once, in f64; a frame is then one bilinear sample for each pixel that sees the panel.

use super::session::{Extras, Session};
use crate::blend::Weights;
use crate::correct::plan::{Mask, OutputPass};
use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::views::View;
use glam::DVec2;

/// Parts that a texel is divided into between two samples, as on graphics cards.
const STEPS: f64 = 256.0;

/// Weights are in parts of this, so that full weight changes nothing.
const FULL: f64 = 32768.0;

/// A pixel that sees the program's picture.
struct Seen {
    /// Index of the window's pixel, rows from the top.
    pixel: u32,
    /// Indices of the four texels around, from the top left.
    texels: [u32; 4],
    /// Weights of the four, in 65536ths; their sum is 65536.
    parts: [u32; 4],
    /// Factor on the encoded value, in parts of [`FULL`].
    factor: u32,
}

/// Where the pixels of a window look, on a panel with the program's picture.
pub struct FlatPicture {
    size: (u32, u32),
    seen: Vec<Seen>,
    /// What a pixel shows beside the panel (the output's black), and the same as the start of a range: value, pixel count.
    base: Vec<u8>,
    session: Session,
}

impl FlatPicture {
    /// Traces `rig` in a window of `size` pixels, whose program draws a picture of the same size.
    ///
    /// # Errors
    /// Those of the planner, and of masks that cannot be read; [`ErrorKind::Internal`] if the plan has no panel.
    pub fn new(rig: &Rig, size: (u32, u32)) -> Result<Self> {
        // No texture holds these views: only the panel's place is used.
        let session = Session::new(rig, size, false, 1 << 20, Extras { panel: true, primary: false })?;
        let panel = session.plan().views.panel.as_ref();
        let panel = panel.ok_or_else(|| Error::new(ErrorKind::Internal, "the plan has no panel"))?;
        let sizes: Vec<(u32, u32)> = session.plan().passes.iter().map(|pass| pass.size).collect();
        let weights = Weights::new(rig, &sizes)?;
        let mut seen = Vec::new();
        let mut base = vec![0; size.0 as usize * size.1 as usize];
        for (index, (pass, [left, bottom, width, height])) in
            session.plan().passes.iter().zip(session.viewports()).enumerate()
        {
            let top = size.1 as i32 - bottom - height;
            let black = pass.black_level.powf(1.0 / pass.gamma);
            for row in 0..height.max(0) {
                for column in 0..width.max(0) {
                    let pixel = ((top + row) as u32) * size.0 + (left + column) as u32;
                    let at = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    let Some(direction) = direction(pass, at) else { continue };
                    base[pixel as usize] = (black * 255.0).round() as u8;
                    let Some(place) = on_panel(panel, direction) else { continue };
                    let light = weights.weight(index, at).unwrap_or(0.0)
                        * pass
                            .mask
                            .as_ref()
                            .map_or(1.0, |mask| mask_at(mask, at / DVec2::new(width.into(), height.into())));
                    let factor = (light.powf(1.0 / pass.gamma) * (1.0 - black) * FULL).round() as u32;
                    seen.push(sample(pixel, place, size, factor));
                }
            }
        }
        Ok(Self { size, seen, base, session })
    }

    /// Size of the window and of the program's picture, pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Names of the outputs and where they are in the window: x, y from the top left, width, height.
    pub fn outputs(&self) -> Vec<(String, [u32; 4])> {
        let names = self.session.rig().outputs.iter().map(|output| output.name.clone());
        names.zip(self.session.rig().layout(self.size)).collect()
    }

    /// Draws the window: `program` and `window` have four bytes for each pixel, rows from the top, three colours
    /// in any order and alpha last. Nothing is drawn where a buffer is too small.
    pub fn draw(&self, program: &[u8], window: &mut [u8]) {
        let bytes = self.base.len() * 4;
        if program.len() < bytes || window.len() < bytes {
            return;
        }
        for (pixel, value) in window.chunks_exact_mut(4).zip(&self.base) {
            pixel.copy_from_slice(&[*value, *value, *value, 255]);
        }
        for seen in &self.seen {
            let at = seen.pixel as usize * 4;
            for channel in 0..3 {
                let texel = |i: usize| u32::from(program[seen.texels[i] as usize * 4 + channel]) * seen.parts[i];
                let sum = texel(0) + texel(1) + texel(2) + texel(3);
                // At most 255 · 2¹⁶ · 2¹⁵, which needs 39 bits.
                let value = (u64::from(sum) * u64::from(seen.factor) + (1 << 30)) >> 31;
                window[at + channel] = window[at + channel].saturating_add(value as u8);
            }
        }
    }
}

/// Where a pixel of an output looks, viewer axes.
fn direction(pass: &OutputPass, pixel: DVec2) -> Option<glam::DVec3> {
    let (x, y) = pass.source.normalised(pass.size, pixel.x, pixel.y);
    pass.source.direction(x, y)
}

/// The place on the panel that a direction meets: 0…1 from the left and from the top; `None` beside it.
fn on_panel(panel: &View, direction: glam::DVec3) -> Option<DVec2> {
    let towards = panel.rotation * direction;
    if towards.z >= 0.0 {
        return None;
    }
    let frustum = &panel.frustum;
    let place = DVec2::new(
        (towards.x / -towards.z - frustum.left) / frustum.width(),
        (frustum.top - towards.y / -towards.z) / frustum.height(),
    );
    let inside = |v: f64| (0.0..=1.0).contains(&v);
    (inside(place.x) && inside(place.y)).then_some(place)
}

/// The four texels around `place`, clamped to the picture's border.
fn sample(pixel: u32, place: DVec2, size: (u32, u32), factor: u32) -> Seen {
    let axis = |part: f64, length: u32| {
        let at = (part * f64::from(length) - 0.5).clamp(0.0, f64::from(length - 1));
        let first = (at.floor() as u32).min(length - 1);
        let share = ((at - f64::from(first)) * STEPS).round() as u32;
        (first, (first + 1).min(length - 1), share)
    };
    let ((left, right, across), (top, bottom, down)) = (axis(place.x, size.0), axis(place.y, size.1));
    let whole = STEPS as u32;
    Seen {
        pixel,
        texels: [top * size.0 + left, top * size.0 + right, bottom * size.0 + left, bottom * size.0 + right],
        parts: [(whole - across) * (whole - down), across * (whole - down), (whole - across) * down, across * down],
        factor,
    }
}

/// A mask's weight at a place of the output, 0…1 from the left and from the top.
fn mask_at(mask: &Mask, place: DVec2) -> f64 {
    let seen = sample(0, place.clamp(DVec2::ZERO, DVec2::ONE), (mask.width, mask.height), 0);
    let texel = |i: usize| f64::from(mask.weights[seen.texels[i] as usize]) * f64::from(seen.parts[i]);
    (texel(0) + texel(1) + texel(2) + texel(3)) / (STEPS * STEPS * 65535.0)
}

#[cfg(test)]
mod tests {
    use super::FlatPicture;
    use crate::rig;

    const SIZE: (u32, u32) = (96, 96);

    fn drawn(picture: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
        let rig = rig::load("fisheye").expect("a preset");
        let flat = FlatPicture::new(&rig, SIZE).expect("a plan");
        let program: Vec<u8> = (0..SIZE.1)
            .flat_map(|y| (0..SIZE.0).flat_map(move |x| [x, y]))
            .collect::<Vec<u32>>()
            .chunks_exact(2)
            .flat_map(|at| picture(at[0], at[1]))
            .collect();
        let mut window = vec![7; program.len()];
        flat.draw(&program, &mut window);
        window
    }

    #[test]
    fn a_uniform_picture_stays_what_it_is() {
        let window = drawn(|_, _| [10, 200, 255, 3]);
        let middle = (48 * 96 + 48) * 4;
        assert_eq!(window[middle..middle + 4], [10, 200, 255, 255]);
        assert_eq!(window[..4], [0, 0, 0, 255], "outside the circle it is black");
    }

    /// Straight from the definition of the fisheye and of a pane as wide as the rig's overlay says.
    #[test]
    fn a_ramp_is_where_the_angles_say() {
        let window = drawn(|x, y| [(x * 2) as u8, (y * 2) as u8, 0, 255]);
        let half = (0.5 * rig::load("fisheye").expect("a preset").overlay.width).tan();
        let (mut checked, mut wrong) = (0, 0);
        for row in 0..96 {
            for column in 0..96 {
                let (x, y) = ((column as f64 + 0.5) / 48.0 - 1.0, 1.0 - (row as f64 + 0.5) / 48.0);
                let radius = x.hypot(y);
                let angle = radius * std::f64::consts::FRAC_PI_2;
                if angle > 1.4 {
                    continue;
                }
                let tangent = angle.tan() / radius;
                let (across, down) = (0.5 + 0.5 * x * tangent / half, 0.5 - 0.5 * y * tangent / half);
                // A texel within the border, where the sample is not clamped.
                if [across, down].iter().any(|part| *part < 0.011 || *part > 0.989) {
                    continue;
                }
                checked += 1;
                let at = (row * 96 + column) * 4;
                for (value, part) in [(window[at], across), (window[at + 1], down)] {
                    wrong += usize::from((f64::from(value) - 2.0 * (96.0 * part - 0.5)).abs() > 1.0);
                }
            }
        }
        assert!(checked > 500, "{checked}");
        assert_eq!(wrong, 0, "of {checked}");
    }
}
