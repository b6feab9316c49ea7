//! Photographs of the screen, rendered from the exact geometry.
//!
//! A pixel of the photograph follows from the geometry at 3 × 3 places in it. Projectors are real
//! lamps, whose black is not quite dark. The lens is out of focus and darker at its rim, the room
//! is not quite dark, the picture sensor has shot noise and read noise, and values are sRGB of
//! 8 bits.

use super::lamps::Lamps;
use super::world::{PHOTOGRAPH, SIZE, World};
use crate::failure::Failure;
use crate::random::Random;
use cupola::calibrate::Camera;
use cupola::calibrate::gray::Photograph;
use glam::{DVec2, DVec3};

/// Side of a cell, pixels of an output.
pub const CELL: u32 = 4;
/// Number of places in a pixel of the photograph, along each axis.
const SAMPLES: usize = 3;
/// Standard deviation of the lens' blur, pixels.
const BLUR: f64 = 0.8;
/// Light of the room, and light that the dome throws onto itself, as a part of white.
const AMBIENT: f64 = 0.004;
/// Noise of black, and number of electrons that saturate a pixel.
const READ: f64 = 0.002;
const ELECTRONS: f64 = 20_000.0;
/// Number of steps of light whose values are computed once. Near black, 8 bits have 20 for a value.
const STEPS: usize = 65_535;

/// The screen with all its projectors, as the camera sees it.
pub struct Sight {
    scenes: Vec<Scene>,
    /// Light of the black of all projectors and of the room, for each pixel of the photograph.
    black: Vec<f32>,
    /// Brightness of the lens for each pixel.
    vignetting: Vec<f32>,
    /// Value of the brightest white in the middle of the sensor, as a part of the greatest value.
    exposure: f64,
    /// The photograph while all outputs show black, without noise.
    dark: Vec<u16>,
    /// Values of light, [`STEPS`] in equal steps from 0 to 1.
    encoded: Vec<u16>,
}

/// Part of the photograph that one output lights.
struct Scene {
    /// Left, top, width, height.
    part: [usize; 4],
    /// Columns and rows of the cells at the places in each pixel of the part; [`NOTHING`] beside the
    /// picture.
    cells: Vec<[Cell; SAMPLES * SAMPLES]>,
    /// Light of white for each pixel of the part, without its black.
    white: Vec<f32>,
}

/// Column and row of a cell.
type Cell = [u16; 2];

const NOTHING: Cell = [u16::MAX; 2];

impl Sight {
    /// The camera's sight of a rig.
    pub fn new(world: &World, lamps: &Lamps, camera: &Camera, exposure: f64) -> Result<Self, Failure> {
        let rays = rays(camera);
        let scenes: Vec<Scene> = (0..world.exact.outputs.len())
            .map(|output| Scene::new(world, output, lamps, camera, &rays))
            .collect::<Result<_, _>>()?;
        let (columns, rows) = (PHOTOGRAPH.0 as usize, PHOTOGRAPH.1 as usize);
        let mut black = vec![AMBIENT as f32; columns * rows];
        for (output, scene) in scenes.iter().enumerate() {
            let part = lamps.black(output) / (1.0 - lamps.black(output));
            for (index, white) in scene.white.iter().enumerate() {
                black[scene.place(index)] += part as f32 * white * scene.share(index, |_| true);
            }
        }
        let vignetting = (0..columns * rows).map(|index| {
            let seen = DVec2::new((index % columns) as f64, (index / columns) as f64);
            let away = seen.distance(camera.center) / (0.5 * f64::from(PHOTOGRAPH.1));
            (1.0 - 0.4 * away.powi(2).min(2.0)) as f32
        });
        let vignetting: Vec<f32> = vignetting.collect();
        let encoded = (0..=STEPS).map(|step| encoded(step as f64 / STEPS as f64)).collect();
        let mut sight = Self { scenes, black, vignetting, exposure, dark: Vec::new(), encoded };
        sight.dark = (0..columns * rows).map(|at| sight.value(sight.exposed(at, 0.0))).collect();
        Ok(sight)
    }

    /// Photograph while an output shows a picture whose cells have light or none, `level` of its
    /// white; the other outputs show black. The middle of a cell is asked.
    pub fn photograph(
        &self,
        output: usize,
        level: f64,
        is_lit: impl Fn((u32, u32)) -> bool,
        random: &mut Random,
    ) -> Photograph {
        let scene = &self.scenes[output];
        let lit = |cell: &Cell| is_lit((u32::from(cell[0]) * CELL, u32::from(cell[1]) * CELL));
        let light = scene.white.iter().enumerate().map(|(index, white)| level as f32 * white * scene.share(index, lit));
        let light = blurred(&light.collect::<Vec<_>>(), scene.part[2]);
        let mut values = self.dark.clone();
        for (index, light) in light.iter().enumerate() {
            let at = scene.place(index);
            let exact = self.exposed(at, f64::from(*light));
            let noise = (READ * READ + exact / ELECTRONS).sqrt() * random.gaussian().x;
            values[at] = self.value(exact + noise);
        }
        Photograph { size: PHOTOGRAPH, values }
    }

    /// Light on a pixel of the sensor, beside that of black.
    fn exposed(&self, at: usize, light: f64) -> f64 {
        self.exposure * f64::from(self.vignetting[at]) * (light + f64::from(self.black[at]))
    }

    /// Value of light.
    fn value(&self, light: f64) -> u16 {
        self.encoded[(light.clamp(0.0, 1.0) * STEPS as f64).round() as usize]
    }
}

impl Scene {
    fn new(world: &World, output: usize, lamps: &Lamps, camera: &Camera, rays: &[DVec3]) -> Result<Self, Failure> {
        let (projector, optics) = world.projector(output)?;
        let screen = world.exact.surface();
        let columns = PHOTOGRAPH.0 as usize + 1;
        let pixel = |ray: &DVec3| projector.pixel(&optics, screen.hit(camera.pose.position, *ray)?.point);
        let corners: Vec<Option<DVec2>> = rays.iter().map(pixel).collect();
        let is_lit = |place: &DVec2| {
            place.cmpge(DVec2::ZERO).all() && place.x < f64::from(SIZE.0) && place.y < f64::from(SIZE.1)
        };
        let lit = || corners.iter().enumerate().filter(|(_, place)| place.as_ref().is_some_and(is_lit));
        let edge = |of: fn(usize, usize) -> usize| lit().map(move |(index, _)| of(index, columns));
        let (left, right) = (edge(|i, n| i % n).min().unwrap_or(0), edge(|i, n| i % n).max().unwrap_or(0));
        let (top, bottom) = (edge(|i, n| i / n).min().unwrap_or(0), edge(|i, n| i / n).max().unwrap_or(0));
        const MARGIN: usize = 8;
        let (left, top) = (left.saturating_sub(MARGIN), top.saturating_sub(MARGIN));
        let (right, bottom) = ((right + MARGIN).min(columns - 1), (bottom + MARGIN).min(PHOTOGRAPH.1 as usize));
        let mut scene = Self { part: [left, top, right - left, bottom - top], cells: Vec::new(), white: Vec::new() };
        let whites = whites(lamps, output);
        for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
            let at = y * columns + x;
            let cells = cells([corners[at], corners[at + 1], corners[at + columns], corners[at + columns + 1]], is_lit);
            let cell = cells.iter().find(|cell| **cell != NOTHING);
            scene.white.push(cell.map_or(0.0, |[x, y]| whites[usize::from(*y) * across() + usize::from(*x)]));
            scene.cells.push(cells);
        }
        Ok(scene)
    }

    /// Index in the photograph of a pixel of the part.
    fn place(&self, index: usize) -> usize {
        let [left, top, width, _] = self.part;
        (top + index / width) * PHOTOGRAPH.0 as usize + left + index % width
    }

    /// Part of a pixel that is lit by such cells.
    fn share(&self, index: usize, is_lit: impl Fn(&Cell) -> bool) -> f32 {
        let cells = &self.cells[index];
        cells.iter().filter(|cell| **cell != NOTHING && is_lit(cell)).count() as f32 / cells.len() as f32
    }
}

/// Number of cells in a row of an output.
fn across() -> usize {
    SIZE.0.div_ceil(CELL) as usize
}

/// Light of white in the middle of each cell of an output, without its black.
fn whites(lamps: &Lamps, output: usize) -> Vec<f32> {
    let cells = (0..SIZE.1.div_ceil(CELL)).flat_map(|y| (0..SIZE.0.div_ceil(CELL)).map(move |x| (x, y)));
    let middle = |(x, y)| (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * f64::from(CELL);
    let white = |cell| (lamps.white(output, middle(cell)).unwrap_or(0.0) * (1.0 - lamps.black(output))) as f32;
    cells.map(white).collect()
}

/// Directions, dome axes, of the corners of all pixels of the photograph, row by row.
fn rays(camera: &Camera) -> Vec<DVec3> {
    let ray = |corner: DVec2| {
        // Uses the lens without coefficients; the place is moved until the lens with coefficients
        // sees the corner.
        let mut place = corner;
        for _ in 0..12 {
            let seen = camera.ideal_ray(place).and_then(|ray| camera.place(camera.pose.point_to_parent(ray)));
            let Some(seen) = seen else { break };
            place += corner - seen;
        }
        camera.pose.direction_to_parent(camera.ideal_ray(place).unwrap_or(DVec3::Z))
    };
    let (width, height) = PHOTOGRAPH;
    (0..=height).flat_map(|y| (0..=width).map(move |x| DVec2::new(f64::from(x), f64::from(y)))).map(ray).collect()
}

/// Cells at the places in a pixel with these corners.
fn cells(corners: [Option<DVec2>; 4], is_lit: impl Fn(&DVec2) -> bool) -> [Cell; SAMPLES * SAMPLES] {
    let [Some(a), Some(b), Some(c), Some(d)] = corners else { return [NOTHING; SAMPLES * SAMPLES] };
    std::array::from_fn(|sample| {
        let part = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
        let (x, y) = (part(sample % SAMPLES), part(sample / SAMPLES));
        let place = a.lerp(b, x).lerp(c.lerp(d, x), y);
        if is_lit(&place) { [place.x, place.y].map(|at| (at as u32 / CELL) as u16) } else { NOTHING }
    })
}

/// A picture of rows of `width` pixels, blurred.
fn blurred(picture: &[f32], width: usize) -> Vec<f32> {
    let reach = (3.0 * BLUR).ceil() as usize;
    let weights: Vec<f32> =
        (0..=2 * reach).map(|at| (-0.5 * ((at as f64 - reach as f64) / BLUR).powi(2)).exp() as f32).collect();
    let sum: f32 = weights.iter().sum();
    let along = |picture: &[f32], step: usize| -> Vec<f32> {
        let border = reach * step;
        let mut blurred = vec![0.0; picture.len()];
        for (index, pixel) in blurred.iter_mut().enumerate().take(picture.len() - border).skip(border) {
            let taps = picture[index - border..].iter().step_by(step).zip(&weights);
            *pixel = taps.map(|(value, weight)| value * weight).sum::<f32>() / sum;
        }
        blurred
    };
    along(&along(picture, 1), width)
}

/// Encodes light 0…1 as a value of 8 bits in sRGB, scaled to 16 bits.
fn encoded(light: f64) -> u16 {
    let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    257 * (255.0 * value + 0.5) as u16
}
