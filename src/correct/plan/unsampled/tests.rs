//! Unsampled areas, compared with every pixel of random rigs.

use super::*;
use crate::correct::plan::builder::build;
use crate::testing::random::Random;
use crate::views::tests::{fisheye, random_rig, request, rig};
use crate::warp::exact_direction;

/// Number of pixels of a plan's outputs that read from an unsampled area.
fn wrongly_unsampled(rig: &crate::rig::Rig, plan: &Plan, unsampled: &[Vec<Tile>]) -> usize {
    let mut wrong = 0;
    for (output, pass) in plan.passes.iter().enumerate() {
        for (x, y) in (0..pass.size.1).flat_map(|y| (0..pass.size.0).map(move |x| (x, y))) {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(direction) = exact_direction(rig, output, pass.size, pixel) else { continue };
            let answers = |&&view: &&usize| Cone::of(&plan.views.views[view]).contains(direction);
            let Some(&index) = plan.views.output_views[output].iter().find(answers) else { continue };
            let view = &plan.views.views[index];
            let local = view.rotation * direction;
            let at = local.truncate() / -local.z - DVec2::new(view.frustum.left, view.frustum.bottom);
            let part = at / DVec2::new(view.frustum.width(), view.frustum.height());
            let corner = DVec2::new(f64::from(view.tile.x), f64::from(view.tile.y));
            let place = corner + part * DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
            // A bilinear filter reads the texels whose centres are less than one away.
            let reads = |tile: &Tile| {
                place.x > f64::from(tile.x) - 0.5
                    && place.x < f64::from(tile.x + tile.width) + 0.5
                    && place.y > f64::from(tile.y) - 0.5
                    && place.y < f64::from(tile.y + tile.height) + 0.5
            };
            wrong += usize::from(unsampled[index].iter().any(reads));
        }
    }
    wrong
}

#[test]
fn no_pixel_reads_from_a_hidden_part() {
    let mut random = Random::new(23);
    for round in 0..30 {
        let (rig, request) = random_rig(&mut random);
        let plan = build(&rig, &request).unwrap();
        assert_eq!(wrongly_unsampled(&rig, &plan, &unsampled_areas(&plan)), 0, "{round}");
    }
}

#[test]
fn of_a_dome_in_five_views_little_more_is_open_than_is_shown() {
    let plan = build(&rig(vec![fisheye(180.0, 90.0)]), &request(&[(4096, 4096)])).unwrap();
    let texels: u64 = plan.views.views.iter().map(|view| view.tile.area()).sum();
    let unsampled: u64 = unsampled_areas(&plan).iter().flatten().map(Tile::area).sum();
    let disc = std::f64::consts::PI * 2048.0 * 2048.0;
    let open = (texels - unsampled) as f64 / disc;
    assert!(plan.views.views.len() == 5 && open <= 1.27, "{open}");
}

#[test]
fn the_check_notices_what_is_hidden_too_much_and_much_of_a_dome_is_hidden() {
    let rig = rig(vec![fisheye(180.0, 90.0)]);
    let plan = build(&rig, &request(&[(1024, 1024)])).unwrap();
    let mut unsampled = unsampled_areas(&plan);
    let texels: u64 = unsampled.iter().flatten().map(Tile::area).sum();
    // Two of the four views are rectangles around triangles.
    assert!(texels > 200_000, "{texels}");
    assert_eq!(wrongly_unsampled(&rig, &plan, &unsampled), 0);
    let most = unsampled.iter_mut().max_by_key(|tiles| tiles.len()).unwrap();
    for tile in most.iter_mut() {
        (tile.x, tile.width) = (tile.x.saturating_sub(40), tile.width + 80);
    }
    assert!(wrongly_unsampled(&rig, &plan, &unsampled) > 0);
}
