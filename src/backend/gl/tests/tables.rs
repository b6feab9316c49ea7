//! Maps that come from a texture.

use super::contexts;
use crate::backend::cases::plans::*;
use crate::backend::gl::gpu_map;
use crate::correct::plan::{Plan, Source};
use crate::correct::{Table, TablePixel};
use glam::DVec3;
use std::sync::Arc;

/// What a bent projector shows at a pixel: a narrow picture with a hole, and weights.
fn shown(size: (u32, u32), opening: f64, column: u32, row: u32) -> Option<TablePixel> {
    let (x, y) = normalised(size, column, row);
    let direction = DVec3::new(opening * (x + 0.1 * y * y), opening * (y - 0.2 * x * y), -1.0);
    let hole = x * x + y * y < 0.01;
    (!hole).then(|| TablePixel { direction: viewer().rotation * direction * 3.0, weight: 0.25 + 0.25 * (x + 1.0) })
}

#[test]
fn a_table_is_shown_as_it_was_computed() {
    let size = (640, 400);
    for context in contexts() {
        // From a wide picture to one of two arc minutes: the error in pixels stays the same.
        for opening in [0.9, 0.01, 3e-4] {
            let table = Table::new(size, |column, row| shown(size, opening, column, row));
            assert!(table.is_weighted());
            let half = 1.5 * opening;
            let owned = crate::geom::Frustum { left: -half, right: half, bottom: -half, top: half };
            let tile = crate::views::Tile { x: 8, y: 4, width: 900, height: 900 };
            let views = view_plan(vec![view("one", viewer().rotation.transpose(), owned, tile)], (920, 910));
            let source = Source::Table(Arc::new(table));
            let plan = Plan { views, passes: vec![pass(size, source, vec![0], true)] };
            let map = gpu_map(&context.gl, context.is_gles, &plan, 0).expect("the map");
            let pixel = 2.0 * opening / f64::from(size.0);
            let mut wrong: f64 = 0.0;
            for (i, found) in map.iter().enumerate() {
                let (column, row) = (i as u32 % size.0, i as u32 / size.0);
                let expected = shown(size, opening, column, row);
                assert_eq!(expected.is_some(), found.view.is_some(), "{column} {row}");
                let Some(expected) = expected else { continue };
                // In view axes, where f64 keeps the angle even of the narrowest picture.
                let atlas = found.atlas.map(f64::from);
                let frustum = plan.views.views[0].frustum;
                let tangent = |atlas: f64, extent: f64, start: f64, low: f64, width: f64| {
                    low + (atlas * extent - start) / 900.0 * width
                };
                let (x, y) = (
                    tangent(atlas[0], 920.0, 8.0, frustum.left, frustum.width()),
                    tangent(atlas[1], 910.0, 4.0, frustum.bottom, frustum.height()),
                );
                let exact = viewer().rotation.transpose() * expected.direction;
                let error = (exact.x / -exact.z - x).hypot(exact.y / -exact.z - y) / pixel;
                assert!(error < 0.002, "{opening}: {error} at {column}, {row}");
                assert!((f64::from(found.weight) - expected.weight).abs() < 1e-6);
                let neighbour = shown(size, opening, column ^ 1, row);
                let mirrored = neighbour.map_or(0.0, |n| (n.weight - f64::from(found.weight)).abs());
                wrong = wrong.max(mirrored);
            }
            assert!(wrong > 5e-4, "the neighbouring pixel is not taken for this one");
        }
    }
}

#[test]
fn what_is_degenerate_shows_nothing() {
    let bad = [DVec3::ZERO, DVec3::NAN, DVec3::new(f64::INFINITY, 0.0, 0.0)];
    let table = Table::new((4, 1), |column, _| {
        let direction = bad.get(column as usize).copied().unwrap_or(DVec3::X * 1e300);
        Some(TablePixel { direction, weight: f64::NAN })
    });
    for column in 0..3 {
        assert_eq!(table.nearest((f64::from(column) + 0.5) / 4.0, 0.5), None);
    }
    let last = table.nearest(0.9, 0.5).expect("shows something");
    assert!(last.direction.distance(DVec3::X) < 1e-7 && last.weight == 0.0, "{last:?}");
    assert!(Table::new((0, 0), |_, _| None).nearest(0.0, 0.0).is_none());
}
