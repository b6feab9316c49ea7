//! Pure geometry in f64: poses, frusta, lenses, screens, cubes, clip-space reprojection.
//! Knows nothing of files, rigs or graphics APIs.

pub mod cube;
pub mod curve;
pub mod division;
pub mod frustum;
pub mod homography;
pub mod lenses;
pub mod pose;
pub mod quadratic;
pub mod quadric;
pub mod rectangle;
pub mod reprojection;
pub mod screen;
pub mod sphere;

pub use cube::Face;
pub use curve::Curve;
pub use division::Division;
pub use frustum::Frustum;
pub use lenses::content::{ContentMap, ContentPicture, Region};
pub use lenses::equidistant::Fisheye;
pub use lenses::fisheye::{FisheyeLens, Projection};
pub use lenses::lens::{Circle, Lens};
pub use lenses::optics::Optics;
pub use lenses::panorama::Panorama;
pub use lenses::picture_map::{PictureLens, PictureMap};
pub use lenses::pinhole_rays::PinholeRays;
pub use pose::Pose;
pub use quadratic::QuadraticForm;
pub use quadric::Quadric;
pub use rectangle::{LowerLeftRect, PixelRect, PixelSpan, Size, UpperLeftRect};
pub use screen::Screen;
pub use sphere::Sphere;
