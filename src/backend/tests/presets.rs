//! Every preset, planned, prepared and compared with the exact source of each output.

use super::Driver;
use super::rigs::planned;
use crate::rig;
use glam::DVec3;

pub fn every_preset_shows_every_pixel(driver: &dyn Driver) {
    for preset in rig::presets() {
        let name = preset.name;
        let rig = rig::load(name).expect("a preset loads");
        let plan = planned(&rig, (320, 240));
        for (index, pass) in plan.passes.iter().enumerate() {
            let map = driver.map(&plan, index);
            let (mut worst, mut holes, mut ghosts) = (0.0f64, 0, 0);
            for (at, pixel) in map.iter().enumerate() {
                let (column, row) = (at as u32 % pass.size.0, at as u32 / pass.size.0);
                let (x, y) = pass.source.normalised(pass.size, f64::from(column) + 0.5, f64::from(row) + 0.5);
                match (pass.source.direction(x, y), pixel.view) {
                    (Some(exact), Some(_)) => {
                        let found = DVec3::from_array(pixel.direction.map(f64::from));
                        worst = worst.max(found.distance(exact.normalize()));
                    }
                    (Some(_), None) => holes += 1,
                    (None, Some(_)) => ghosts += 1,
                    (None, None) => {}
                }
            }
            println!("{name} {}: error {worst:.2e} rad, {} views", pass.name, plan.views.views.len());
            // Half a thousandth of the widest pixel of 320.
            assert!(worst < 5e-6, "{name} {}: {worst:e}", pass.name);
            // On a rim, f32 may decide differently.
            assert!(holes + ghosts <= 2, "{name} {}: {holes} holes, {ghosts} ghosts", pass.name);
        }
    }
}
