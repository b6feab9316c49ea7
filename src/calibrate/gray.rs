//! Gray codes: patterns that tell a camera which pixel of an output it sees.
//!
//! Columns and rows are numbered in cells. Each bit of the reflected code (Gray 1953) of a cell's
//! number is one picture, followed by its inverse. A pixel of the photograph is compared with
//! itself in the inverse, so that neither the lens' vignetting nor the screen's brightness matter.
//! At an edge between cells only one bit is uncertain, and each of its values means one of the two
//! cells.
//!
//! One pixel of the photograph gives its place in the output only to half a cell. Means are much
//! more precise: the mean place of a window of cells in the photograph belongs to the window's mean
//! place in the output.

use super::Sighting;
use glam::DVec2;

/// The codes of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Codes {
    /// Width and height of the output in pixels.
    size: (u32, u32),
    /// Width and height of a cell in pixels.
    cell: u32,
}

/// One picture of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Picture {
    /// White all over.
    White,
    /// Black all over.
    Black,
    /// A bit of the code of columns (axis 0) or rows (axis 1), or its inverse.
    Bit {
        /// 0 or 1.
        axis: usize,
        /// 0 is the finest.
        bit: u32,
        /// White where the bit is 0.
        inverse: bool,
    },
}

impl Codes {
    /// Codes for an output, with cells of `cell` pixels.
    pub fn new(size: (u32, u32), cell: u32) -> Self {
        Self { size, cell: cell.max(1) }
    }

    /// All pictures in their order: white, black, columns, rows.
    pub fn pictures(&self) -> Vec<Picture> {
        let mut pictures = vec![Picture::White, Picture::Black];
        for (axis, length) in [self.size.0, self.size.1].into_iter().enumerate() {
            let cells = length.div_ceil(self.cell);
            let bits = u32::BITS - cells.saturating_sub(1).leading_zeros();
            for bit in (0..bits).rev() {
                pictures.extend([false, true].map(|inverse| Picture::Bit { axis, bit, inverse }));
            }
        }
        pictures
    }

    /// True if a pixel is white in a picture.
    pub fn is_white(&self, picture: Picture, (x, y): (u32, u32)) -> bool {
        match picture {
            Picture::White => true,
            Picture::Black => false,
            Picture::Bit { axis, bit, inverse } => {
                let cell = [x, y][axis.min(1)] / self.cell;
                let code = cell ^ (cell >> 1);
                (((code >> bit) & 1) == 1) != inverse
            }
        }
    }
}

/// A photograph in grey, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Values of any response that grows with light.
    pub values: Vec<u16>,
}

/// Photographs of one output's series, decoded.
#[derive(Clone, Debug)]
pub struct Decoder {
    codes: Codes,
    size: (u32, u32),
    /// True for each pixel that the output lights.
    lit: Vec<bool>,
    /// The codes of column and row.
    code: [Vec<u16>; 2],
}

/// Side of the windows in which places are averaged, cells. In larger ones the mean is off, because
/// the map is not straight.
pub const CELLS: u32 = 4;
/// Least contrast of a pixel that the output lights, as a part of the contrast at its brightest
/// places.
const LEAST_CONTRAST: f64 = 0.1;
/// Least contrast of any lit pixel, of 65535. Less is noise.
const NOISE: u16 = 1000;
/// Distance from unlit pixels of the photograph within which pixels are left out.
const BORDER: usize = 2;
/// Fewest pixels of the photograph in a window of cells.
const FEWEST: usize = 25;

impl Decoder {
    /// Makes a decoder from the photographs of white and of black; `None` if their sizes differ.
    pub fn new(codes: Codes, white: &Photograph, black: &Photograph) -> Option<Self> {
        let contrast = |(white, black): (&u16, &u16)| white.saturating_sub(*black);
        let contrasts: Vec<u16> = white.values.iter().zip(&black.values).map(contrast).collect();
        let mut sorted = contrasts.clone();
        sorted.sort_unstable();
        let bright = sorted.get(sorted.len().saturating_sub(1 + sorted.len() / 500)).copied().unwrap_or(0);
        let least = ((LEAST_CONTRAST * f64::from(bright)) as u16).max(NOISE);
        let lit: Vec<bool> = contrasts.iter().map(|contrast| *contrast >= least).collect();
        let lit = eroded(&lit, white.size.0 as usize);
        let code = [vec![0; lit.len()], vec![0; lit.len()]];
        (white.size == black.size).then_some(Self { codes, size: white.size, lit, code })
    }

    /// Adds a bit of a code, from its photograph and that of its inverse. Returns whether their
    /// sizes are right.
    pub fn add(&mut self, axis: usize, bit: u32, picture: &Photograph, inverse: &Photograph) -> bool {
        if picture.size != self.size || inverse.size != self.size {
            return false;
        }
        let pairs = picture.values.iter().zip(&inverse.values);
        for (code, (picture, inverse)) in self.code[axis].iter_mut().zip(pairs) {
            *code |= u16::from(picture > inverse) << bit;
        }
        true
    }

    /// Sightings of the output, one place for each window of `window` pixels.
    pub fn sightings(&self, output: usize, window: u32) -> Vec<Sighting> {
        let cells = self.cells(window);
        let mut windows: Vec<Vec<(DVec2, DVec2)>> = vec![Vec::new(); self.windows(cells)];
        for (index, window, cell) in self.decoded(cells) {
            let middle = |cell: u32| (f64::from(cell) + 0.5) * f64::from(self.codes.cell);
            let seen = DVec2::new((index % self.size.0 as usize) as f64, (index / self.size.0 as usize) as f64) + 0.5;
            windows[window].push((seen, DVec2::new(middle(cell[0]), middle(cell[1]))));
        }
        windows.iter().filter_map(|window| mean(window, output)).collect()
    }

    /// Mean light of another photograph in the places of [`Self::sightings`], in their order;
    /// `light` gives the light of each of its values. `None` if the photograph has another size.
    pub fn light(&self, window: u32, photograph: &Photograph, light: &[f32]) -> Option<Vec<f64>> {
        let cells = self.cells(window);
        let mut windows = vec![(0.0, 0usize); self.windows(cells)];
        if photograph.size != self.size {
            return None;
        }
        for (index, window, _) in self.decoded(cells) {
            let value = light.get(usize::from(photograph.values[index])).copied().unwrap_or_default();
            windows[window].0 += f64::from(value);
            windows[window].1 += 1;
        }
        let seen = windows.into_iter().filter(|(_, count)| *count >= FEWEST);
        Some(seen.map(|(sum, count)| sum / count as f64).collect())
    }

    /// Number of cells in a side of a window.
    fn cells(&self, window: u32) -> u32 {
        (window / self.codes.cell).max(1)
    }

    /// Number of windows in a row, and of rows.
    fn grid(&self, cells: u32) -> [u32; 2] {
        [self.codes.size.0, self.codes.size.1].map(|length| length.div_ceil(self.codes.cell).div_ceil(cells))
    }

    fn windows(&self, cells: u32) -> usize {
        let [columns, rows] = self.grid(cells);
        columns as usize * rows as usize
    }

    /// For each lit pixel of the photograph its index, the number of its window, and its cell.
    fn decoded(&self, cells: u32) -> impl Iterator<Item = (usize, usize, [u32; 2])> {
        let [columns, rows] = self.grid(cells);
        let lit = self.lit.iter().enumerate().filter(|(_, lit)| **lit);
        lit.filter_map(move |(index, _)| {
            let cell = [0, 1].map(|axis| u32::from(plain(self.code[axis][index])));
            let [column, row] = cell.map(|cell| cell / cells);
            (column < columns && row < rows).then(|| (index, (row * columns + column) as usize, cell))
        })
    }
}

/// Returns only the lit pixels whose neighbours are lit as well. At the border of a picture only a
/// part of a pixel is lit, which moves its mean place.
fn eroded(lit: &[bool], width: usize) -> Vec<bool> {
    let all_near = |lit: &[bool], step: usize| -> Vec<bool> {
        let near = |index: usize| (index.saturating_sub(BORDER * step)..=index + BORDER * step).step_by(step);
        (0..lit.len()).map(|index| near(index).all(|at| lit.get(at).copied().unwrap_or(false))).collect()
    };
    all_near(&all_near(lit, 1), width.max(1))
}

/// Number that a Gray code stands for.
fn plain(code: u16) -> u16 {
    [8, 4, 2, 1].into_iter().fold(code, |code, shift| code ^ (code >> shift))
}

/// Mean place of a window, without pixels far from the others: those were decoded wrongly.
fn mean(window: &[(DVec2, DVec2)], output: usize) -> Option<Sighting> {
    if window.len() < FEWEST {
        return None;
    }
    let median = |of: fn(DVec2) -> f64| {
        let mut values: Vec<f64> = window.iter().map(|(seen, _)| of(*seen)).collect();
        super::least_squares::median(&mut values)
    };
    let middle = DVec2::new(median(|seen| seen.x), median(|seen| seen.y));
    let mut distances: Vec<f64> = window.iter().map(|(seen, _)| seen.distance(middle)).collect();
    // In a square the corners are about twice as far from the middle as the median place.
    let reach = 3.0 * super::least_squares::median(&mut distances);
    let near = window.iter().filter(|(seen, _)| seen.distance(middle) <= reach);
    let (sums, count) = near.fold(((DVec2::ZERO, DVec2::ZERO), 0.0), |((seen, pixel), count), place| {
        ((seen + place.0, pixel + place.1), count + 1.0)
    });
    Some(Sighting { output, pixel: sums.1 / count, seen: sums.0 / count })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    const OUTPUT: (u32, u32) = (320, 200);
    const CAMERA: (u32, u32) = (360, 240);

    /// Place in the output of a place in the photograph: turned, and a little in perspective.
    fn pixel(seen: DVec2) -> DVec2 {
        let turned = DVec2::from_angle(0.1).rotate(seen - DVec2::new(180.0, 120.0));
        DVec2::new(160.0, 100.0) + 1.1 * turned / (1.0 + 0.0004 * turned.x)
    }

    /// A photograph of a picture: mean of 5 × 5 places over a blurred pixel, vignetting, light of
    /// the room, noise.
    fn photograph(codes: &Codes, picture: Picture, random: &mut Random) -> Photograph {
        let mut values = Vec::new();
        for index in 0..CAMERA.0 * CAMERA.1 {
            let seen = DVec2::new(f64::from(index % CAMERA.0), f64::from(index / CAMERA.0)) + 0.5;
            let mut light = 0.0;
            for place in 0..25 {
                let blur = 1.4 * (DVec2::new(f64::from(place % 5), f64::from(place / 5)) / 2.0 - 1.0);
                let at = pixel(seen + blur);
                let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < 320.0 && at.y < 200.0;
                light += f64::from(u8::from(inside && codes.is_white(picture, (at.x as u32, at.y as u32)))) / 25.0;
            }
            let vignetting = 1.0 - 0.5 * seen.distance(DVec2::new(180.0, 120.0)) / 216.0;
            let noise = 0.03 * (random.unit() + random.unit() - 1.0);
            values.push(((0.05 + 0.7 * light * vignetting + noise).clamp(0.0, 1.0) * 65535.0) as u16);
        }
        Photograph { size: CAMERA, values }
    }

    #[test]
    fn photographs_tell_places_to_a_part_of_a_pixel() {
        let mut random = Random::new(111);
        let codes = Codes::new(OUTPUT, 4);
        let mut photographs =
            codes.pictures().into_iter().map(|picture| (picture, photograph(&codes, picture, &mut random)));
        let (white, black) = (photographs.next().expect("white").1, photographs.next().expect("black").1);
        let mut decoder = Decoder::new(codes, &white, &black).expect("alike");
        while let (Some((Picture::Bit { axis, bit, inverse: false }, lit)), Some((_, inverse))) =
            (photographs.next(), photographs.next())
        {
            assert!(decoder.add(axis, bit, &lit, &inverse));
        }
        let sightings = decoder.sightings(3, 32);
        assert!(sightings.len() > 40, "{} windows", sightings.len());
        let errors: Vec<f64> = sightings.iter().map(|place| pixel(place.seen).distance(place.pixel)).collect();
        let rms = crate::calibrate::marks::rms(errors.iter().copied());
        assert!(rms < 0.15, "{rms} px");
        assert!(sightings.iter().all(|sighting| sighting.output == 3));
        // The check notices a moved photograph: the codes are not those of other cells.
        let shifted = sightings.iter().map(|place| pixel(place.seen + 1.0).distance(place.pixel));
        assert!(crate::calibrate::marks::rms(shifted) > 1.0);
    }

    #[test]
    fn codes_are_unique_and_undone() {
        assert!((0..=4095).all(|number: u16| plain(number ^ (number >> 1)) == number));
        let codes = Codes::new((1920, 1080), 4);
        assert_eq!(codes.pictures().len(), 2 + 2 * (9 + 9));
        let columns = [0, 3, 4, 1919].map(|x| codes.is_white(Picture::Bit { axis: 0, bit: 0, inverse: false }, (x, 7)));
        assert_eq!(columns, [false, false, true, false]);
    }
}
