//! Places that several outputs light: their number, and the seams between outputs.

use super::{CROSS, Pattern, coverage};
use crate::canvas::Canvas;
use cupola::blend::Weights;
use glam::DVec2;

/// Side of the squares in which overlaps are drawn, pixels.
const SQUARE: u32 = 8;
/// Distance of places at which weights are computed for seams, pixels. Weights change slowly.
const COARSE: usize = 4;
/// Weights that differ by less are the same.
const SAME: f64 = 1e-9;
/// Opacity of an area in which two outputs have the same weight.
const AREA: f32 = 0.3;

impl Pattern<'_> {
    /// Draws squares in the colour of the number of outputs that light them.
    pub(super) fn overlap(&self, index: usize, canvas: &mut Canvas) {
        let (width, height) = self.maps[index].size();
        for (row, column) in
            (0..height.div_ceil(SQUARE)).flat_map(|row| (0..width.div_ceil(SQUARE)).map(move |column| (row, column)))
        {
            let middle = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * f64::from(SQUARE);
            let Some(point) = self.maps[index].hit(middle) else { continue };
            let others = self.maps.iter().enumerate();
            let others = others.filter(|(other, map)| *other != index && map.pixel(point).is_some()).count();
            let color = match others {
                0 => [0.25; 3],
                1 => [0.1, 0.45, 0.15],
                2 => [0.12, 0.2, 0.6],
                _ => [0.55, 0.12, 0.12],
            };
            canvas.rectangle((column * SQUARE, row * SQUARE), (SQUARE, SQUARE), color);
        }
    }

    /// Weight of an output at a place of its picture minus the greatest of another output's there.
    fn lead(&self, weights: &Weights, index: usize, place: DVec2) -> Option<f64> {
        let point = self.maps[index].hit(place)?;
        let others = self.maps.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.filter(|(_, map)| map.pixel(point).is_some()).map(|(other, _)| other);
        let greatest = others.map(|other| weights.weight_at(other, point)).fold(0.0, f64::max);
        Some(weights.weight_at(index, point) - greatest)
    }

    /// Draws lines where the output and another one have the same weight. In the middle of wide
    /// overlaps, where no ramp reaches, this is an area.
    pub(super) fn seams(&self, index: usize, canvas: &mut Canvas) {
        let Some(weights) = &self.weights else { return };
        let (width, height) = (canvas.width, canvas.height);
        let (columns, rows) = (width.div_ceil(COARSE) + 1, height.div_ceil(COARSE) + 1);
        let place = |at: usize| 0.5 + (at * COARSE) as f64;
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| DVec2::new(place(column), place(row))));
        let leads: Vec<Option<f64>> = places.map(|place| self.lead(weights, index, place)).collect();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let at = y / COARSE * columns + x / COARSE;
            let corners = [leads[at], leads[at + 1], leads[at + columns], leads[at + columns + 1]];
            let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
            let all = [a, b, c, d];
            if all.iter().all(|lead| lead.abs() < SAME) {
                canvas.blend(x as i64, y as i64, CROSS, AREA);
            }
            if all.iter().all(|lead| *lead > -SAME) || all.iter().all(|lead| *lead < SAME) {
                continue;
            }
            let part = |pixel: usize| (pixel % COARSE) as f64 / COARSE as f64;
            let (along, down) = (part(x), part(y));
            let (above, below) = (a + along * (b - a), c + along * (d - c));
            let slope = (b - a + down * (d - c - b + a)).hypot(below - above) / COARSE as f64;
            let covered = coverage((above + down * (below - above)).abs(), slope);
            canvas.blend(x as i64, y as i64, CROSS, covered as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Part;
    use super::*;
    use std::path::Path;

    /// Two projectors that mirror each other share the light equally in the plane between them.
    #[test]
    fn a_seam_is_where_two_outputs_share_the_light_equally() {
        let output = |side: i32| {
            format!(
                "[[output]]\nkind = \"projector\"\nposition = [{side}, 0, 1]\nyaw = {}\npitch = 30\nfov = [80, 60]\n",
                20 * side
            )
        };
        let rig =
            cupola::rig::parse(&format!("{}{}", output(-1), output(1)), "rig.toml", Path::new("")).expect("a rig");
        let pattern = Pattern::new(&rig, &[(320, 240); 2], &[Part::Seams], 10.0, &[]).expect("a pattern");
        let mut lines = 0;
        for index in 0..2 {
            let canvas = pattern.draw(index);
            for y in 0..240 {
                let lit: Vec<u32> = (0..320).filter(|x| canvas.at(*x as usize, y)[0] > 0.9).collect();
                for x in &lit {
                    let place = DVec2::new(f64::from(*x), y as f64) + 0.5;
                    let [here, beside] = [0.0, 1.0].map(|by| pattern.maps[index].hit(place + by * DVec2::X));
                    let (Some(here), Some(beside)) = (here, beside) else { panic!("{place} shows nothing") };
                    assert!(here.x.abs() < 2.0 * beside.distance(here), "{index} {place}: {here}");
                }
                lines += usize::from(!lit.is_empty());
            }
        }
        assert!(lines > 200, "{lines}");
    }
}
