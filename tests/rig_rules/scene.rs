//! The dome, the viewer, the camera, the views.

use super::*;

#[test]
fn ranges_of_the_dome() {
    refused("radius = 5", "radius = 0", "dome.radius", &["greater than 0", "metres"]);
    refused("radius = 5", "radius = -5", "dome.radius", &["-5", "greater than 0"]);
    refused("tilt = 20.0", "tilt = 181", "dome.tilt", &["at most 180"]);
    refused("coverage = 200", "coverage = 0", "dome.coverage", &["greater than 0", "degrees"]);
    refused("coverage = 200", "coverage = 361", "dome.coverage", &["at most 360"]);
}

#[test]
fn ranges_of_viewer_and_camera() {
    refused("yaw = 90", "yaw = 361", "camera.yaw", &["at most 360", "to the right"]);
    refused("pitch = -5", "pitch = -181", "viewer.pitch", &["at least -180", "upwards"]);
    refused("roll = 1", "roll = 400", "viewer.roll", &["at most 360", "clockwise"]);
    refused("zoom = 2", "zoom = 0", "camera.zoom", &["at least 0.001"]);
    refused("zoom = 2", "zoom = -1", "camera.zoom", &["at least 0.001"]);
    refused("move = [0, 0, -20]", "move = [0, 0, 1e10]", "camera.move[2]", &["program's own units"]);
}

#[test]
fn ranges_of_views_and_overlay() {
    refused("quality = 1.5", "quality = 0.05", "views.quality", &["at least 0.1 and at most 8"]);
    refused("quality = 1.5", "quality = 9", "views.quality", &["at least 0.1 and at most 8"]);
    refused("width = 70", "width = 0", "overlay.width", &["greater than 0 and less than 180"]);
    refused("width = 70", "width = 180", "overlay.width", &["greater than 0 and less than 180"]);
}

#[test]
fn the_viewer_is_inside_the_dome() {
    refused(
        "position = [0.5, -0.2, 1]",
        "position = [3, 4, 0]",
        "viewer.position",
        &["5 m", "radius 5 m", "at most 4.95 m"],
    );
    refused("position = [0.5, -0.2, 1]", "position = [0, 10, 0]", "viewer.position", &["10 m", "not inside the dome"]);
    // Without a screen that limits it, the viewer may be anywhere.
    read("[viewer]\nposition = [0, 10, 0]\n[[output]]\nkind = \"perspective\"\nfov = [60, 40]").unwrap();
}
