//! Views that no pixel samples.
//!
//! The planner uses the continuous picture of an output. If the picture reaches into a cell by less
//! than a pixel, it may be that no pixel's centre lies in the cell. Where views overlap, an earlier
//! view may serve everything that a later one shows. Such a view would be drawn in vain.

use crate::geom::PixelSpan;
use crate::views::sampling::cone::{Cone, Relation, WIDEST, diameter};
use crate::views::sampling::output_map::OutputMap;
use crate::views::view_plan::ViewPlan;
use glam::{DVec2, DVec3};

/// Number of pixels of an output, across and down, that are tried first: most views that are not
/// idle serve one of them.
const FEW: u32 = 24;

/// Returns a view that serves no pixel of any output, if there is one.
pub(crate) fn find(plan: &ViewPlan, output_maps: &[OutputMap]) -> Option<usize> {
    (0..plan.views.len()).find(|&index| {
        !output_maps.iter().zip(&plan.output_views).any(|(output_map, views)| {
            let earlier =
                views.iter().take_while(|&&view| view != index).map(|&view| Cone::of(&plan.views[view])).collect();
            let search = Search { output_map, view: Cone::of(&plan.views[index]), earlier };
            views.contains(&index)
                && (search.finds_at_once() || search.finds(PixelSpan::new(0, 0, output_map.size.0, output_map.size.1)))
        })
    })
}

/// The search for a pixel of one output that a view serves.
struct Search<'a> {
    output_map: &'a OutputMap,
    view: Cone,
    /// The views that take precedence.
    earlier: Vec<Cone>,
}

impl Search<'_> {
    /// Returns the direction at a pixel's centre, unit length.
    fn direction(&self, x: u32, y: u32) -> Option<DVec3> {
        self.output_map.direction(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
    }

    /// True if the view serves a direction.
    fn answers(&self, direction: DVec3) -> bool {
        self.view.contains(direction) && !self.earlier.iter().any(|other| other.contains(direction))
    }

    /// True if the view serves one of a few pixels.
    fn finds_at_once(&self) -> bool {
        let pixel = |step: u32, length: u32| (u64::from(2 * step + 1) * u64::from(length) / u64::from(2 * FEW)) as u32;
        let (width, height) = self.output_map.size;
        let places = (0..FEW).flat_map(|row| (0..FEW).map(move |column| (pixel(column, width), pixel(row, height))));
        places.filter_map(|(x, y)| self.direction(x, y)).any(|direction| self.answers(direction))
    }

    /// True if the view serves a pixel of a block. The search goes by quarters, except for blocks
    /// that lie clear of the view or inside an earlier one.
    fn finds(&self, block: PixelSpan) -> bool {
        let PixelSpan { left, top, right, bottom } = block;
        let (middle_x, middle_y) = (left + (right - left) / 2, top + (bottom - top) / 2);
        if self.direction(middle_x, middle_y).is_some_and(|direction| self.answers(direction)) {
            return true;
        }
        if right - left <= 1 && bottom - top <= 1 || self.hopeless(block) {
            return false;
        }
        let (middle_x, middle_y) = (left + (right - left).div_ceil(2), top + (bottom - top).div_ceil(2));
        let quarters = [
            PixelSpan::new(left, top, middle_x, middle_y),
            PixelSpan::new(middle_x, top, right, middle_y),
            PixelSpan::new(left, middle_y, middle_x, bottom),
            PixelSpan::new(middle_x, middle_y, right, bottom),
        ];
        quarters
            .into_iter()
            .filter(|part| part.left < part.right && part.top < part.bottom)
            .any(|part| self.finds(part))
    }

    /// True if the corners of a block prove that the view serves no pixel of it.
    fn hopeless(&self, block: PixelSpan) -> bool {
        let PixelSpan { left, top, right, bottom } = block;
        let places = [(left, top), (right - 1, top), (left, bottom - 1), (right - 1, bottom - 1)];
        let mut corners = [DVec3::ZERO; 4];
        for (corner, (x, y)) in corners.iter_mut().zip(places) {
            match self.direction(x, y) {
                Some(direction) => *corner = direction,
                None => return false,
            }
        }
        let size = diameter(&corners);
        let departure = size * size;
        size < WIDEST
            && (self.view.relation(&corners, departure) == Relation::Outside
                || self.earlier.iter().any(|other| other.relation(&corners, departure) == Relation::Inside))
    }
}
