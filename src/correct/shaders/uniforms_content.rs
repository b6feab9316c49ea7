//! The constants of content: the place of a direction in the program's window.

use crate::correct::shaders::constants::Content;
use crate::correct::single;
use crate::geom::{ContentMap, ContentPicture, Panorama, Projection};
use crate::views::{View, ViewPlan};
use glam::{DVec2, DVec4};
use std::f64::consts::TAU;

/// Returns the constants of `map` over the tile of `view`, the program's window.
pub(super) fn values(map: &ContentMap, view: &View, plan: &ViewPlan) -> Content {
    let atlas = plan.picture_size(view);
    let step = DVec2::new(f64::from(atlas.0), f64::from(atlas.1)).recip();
    let tile = DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
    // A mirrored picture has its rows in the other order.
    let upright = view.rotation.determinant() > 0.0;
    let mut origin = map.region.origin;
    if !upright {
        origin.y = 1.0 - origin.y - map.region.size.y;
    }
    let half_size = 0.5 * map.region.size * tile * step;
    let corner = (DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y)) + origin * tile) * step;
    Content {
        offset: single::values((corner + half_size).to_array()),
        half_size: single::values([half_size.x, if upright { half_size.y } else { -half_size.y }]),
        step: single::values(step.to_array()),
        ..of_picture(&map.picture)
    }
}

fn of_picture(picture: &ContentPicture) -> Content {
    let unrolled = |kind, width: f64, (middle, half): (f64, f64)| Content {
        kind,
        middle: single::value(middle),
        scale: single::values([2.0 / width, 1.0 / half]),
        wraps: (width >= TAU).into(),
        ..Content::default()
    };
    match picture {
        ContentPicture::Directions(Panorama::Fisheye(lens)) => {
            let rim = lens.radius(0.5 * lens.aperture);
            let (curve, factors) = match lens.projection {
                Projection::Equidistant => (0, DVec4::X),
                Projection::Polynomial(factors) => (0, DVec4::from(factors)),
                Projection::Equisolid => (1, DVec4::X),
                Projection::Stereographic => (2, DVec4::X),
                Projection::Orthographic => (3, DVec4::X),
                // A rig with such content is refused.
                Projection::Measured(_) => (0, DVec4::X),
            };
            Content { kind: 1, curve, radius: single::values((factors / rim).to_array()), ..Content::default() }
        }
        ContentPicture::Directions(Panorama::Equirectangular(span)) => unrolled(2, span.width, span.latitudes()),
        ContentPicture::Directions(Panorama::Cylindrical(span)) => unrolled(3, span.width, span.heights()),
        ContentPicture::Directions(Panorama::CubeStrip) => Content { kind: 4, ..Content::default() },
        ContentPicture::Flat { half } => {
            Content { kind: 5, scale: single::values(half.recip().to_array()), ..Content::default() }
        }
    }
}
