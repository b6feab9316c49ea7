//! Pure geometry in f64: poses, frusta, lenses, screens, cubes, clip-space re-projection.
//! Knows nothing of files, rigs or graphics APIs.

pub mod cube;
pub mod curve;
pub mod division;
pub mod fisheye;
pub mod frustum;
pub mod homography;
pub mod lens;
pub mod optics;
pub mod panorama;
pub mod picture_map;
pub mod pinhole_rays;
pub mod pose;
pub mod projection;
pub mod quadratic;
pub mod quadric;
pub mod rectangle;
pub mod reprojection;
pub mod screen;
pub mod sphere;

pub use cube::Face;
pub use curve::Curve;
pub use division::Division;
pub use fisheye::Fisheye;
pub use frustum::Frustum;
pub use lens::{Circle, Lens};
pub use optics::Optics;
pub use panorama::Panorama;
pub use picture_map::{PictureLens, PictureMap};
pub use pinhole_rays::PinholeRays;
pub use pose::Pose;
pub use projection::{FisheyeLens, Projection};
pub use quadratic::QuadraticForm;
pub use quadric::Quadric;
pub use rectangle::{LowerLeftRect, PixelRect, PixelSpan, UpperLeftRect};
pub use screen::Screen;
pub use sphere::Sphere;
