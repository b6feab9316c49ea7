//! Tests of every backend: the same plans, pictures and bounds, whatever the graphics API.

pub mod accuracy;
pub mod blacks;
pub mod content;
pub mod flips;
pub mod methods;
pub mod picture;
pub mod plans;
pub mod present;
pub mod presets;
pub mod quality;
pub mod rigs;
pub mod sharing;
pub mod tables;

use crate::correct::Plan;
use crate::correct::shaders::map::MapPixel;
use picture::Picture;

/// A backend on a driver.
pub trait Driver {
    /// Returns the map of an output, row 0 at the top.
    fn map(&self, plan: &Plan, output: usize) -> Vec<MapPixel>;
    /// Prepares the plan, presents each of `atlases` into a target of the first output's size, and
    /// returns the pictures. Panics on any error.
    fn show_each(&self, plan: &Plan, panel: bool, atlases: &[Picture]) -> Vec<Picture>;
    /// As [`Self::show_each`] for one atlas.
    fn show(&self, plan: &Plan, panel: bool, atlas: &Picture) -> Picture {
        self.show_each(plan, panel, std::slice::from_ref(atlas)).pop().expect("a picture for each")
    }
}

/// Makes a module of tests for each file of cases. Each case runs on all of `$drivers`, an
/// expression that returns an iterator.
macro_rules! run_cases {
    ($drivers:expr; $($module:ident: $($case:ident),+;)+) => {
        $(mod $module {
            $(#[test]
            fn $case() {
                for driver in $drivers {
                    $crate::backend::tests::$module::$case(&driver);
                }
            })+
        })+
    };
}

/// [`run_cases`] with all cases.
macro_rules! run_all_cases {
    ($drivers:expr) => {
        $crate::backend::tests::run_cases! { $drivers;
            accuracy:
                fisheye_180_at_4096,
                wide_fisheyes_not_square_and_off_centre,
                projectors_from_near_the_centre_to_near_the_screen,
                projectors_outside_however_far,
                several_views_and_one_agree,
                a_projector_outside_misses_around_the_sphere,
                a_perspective_picture;
            blacks:
                black_is_raised_pixel_by_pixel,
                a_rigs_picture_of_black_is_shown;
            content: places_are_those_of_f64, content_goes_on_across_its_seams;
            flips:
                a_mirrored_output_shows_the_mirrored_picture,
                a_mirrored_map_is_the_exact_one,
                a_mirrored_picture_of_four_places_is_nearly_the_same,
                a_mask_is_mirrored_with_its_picture;
            methods:
                tables_and_meshes_err_by_no_more_than_was_asked,
                a_mesh_of_the_dome_is_four_times_as_exact_with_half_the_cells;
            present:
                a_picture_1_to_1_is_copied_exactly,
                a_fisheye_shows_the_world_and_black_around_it,
                mask_ramps_black_level_and_response,
                the_panel_lies_over_the_scene;
            presets: every_preset_shows_every_pixel;
            quality:
                filters_are_as_good_as_they_should_be,
                one_resampling_is_better_than_two,
                filters_read_nothing_beyond_their_tiles;
            sharing:
                weights_are_those_of_f64_and_add_up_to_1,
                what_the_shaders_compute_for_one_point_adds_up_to_1,
                in_8_bits_the_sum_of_two_stays_within_the_quantisation,
                shapes_and_exponents_are_those_of_f64,
                blacks_are_evened_out,
                dithering_keeps_the_mean_light;
            tables:
                a_table_is_shown_as_it_was_computed,
                mirrors_and_lenses_show_what_the_exact_map_says,
                a_projector_that_looks_away_makes_no_ghosts,
                blacks_are_evened_out_by_tables_too;
        }
    };
}

pub(super) use {run_all_cases, run_cases};
