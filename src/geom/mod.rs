//! Pure geometry in f64: poses, frusta, lenses, spheres, cubes, clip-space re-projection.
//! Knows nothing of files, rigs or graphics APIs.

pub mod cube;
pub mod fisheye;
pub mod frustum;
pub mod lens;
pub mod optics;
pub mod pose;
pub mod quadratic;
pub mod random;
pub mod reprojection;
pub mod sphere;

pub use cube::Face;
pub use fisheye::Fisheye;
pub use frustum::Frustum;
pub use lens::Lens;
pub use optics::Optics;
pub use pose::Pose;
pub use quadratic::QuadraticForm;
pub use sphere::Sphere;
