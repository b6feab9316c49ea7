//! Direction that a pixel shows, in f64, computed only from the numbers of a rig.
//!
//! Written from the conventions in the description of the rig file, on purpose without
//! `cupola::geom`. Vectors are arrays: x right, y up, −z forward.

pub type Vector = [f64; 3];

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn add_scaled(a: Vector, b: Vector, factor: f64) -> Vector {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

pub fn normalised(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|component| component / length)
}

/// An orientation by three angles in degrees. Positive angles turn to the right, upwards and
/// clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    pub yaw: f64,
    pub pitch: f64,
    pub roll: f64,
}

impl Turn {
    /// From the turned axes to the axes of the parent: first roll, then pitch, then yaw.
    pub fn outward(self, [x, y, z]: Vector) -> Vector {
        let (sin, cos) = self.roll.to_radians().sin_cos();
        // Rolled clockwise, the up direction leans to the right.
        let (x, y) = (x * cos + y * sin, y * cos - x * sin);
        let (sin, cos) = self.pitch.to_radians().sin_cos();
        // Pitched up, the forward direction (−z) gains height.
        let (y, z) = (y * cos - z * sin, y * sin + z * cos);
        let (sin, cos) = self.yaw.to_radians().sin_cos();
        // Yawed to the right, the forward direction (−z) goes to +x.
        [x * cos - z * sin, y, x * sin + z * cos]
    }

    /// From the axes of the parent to the turned axes: components along the turned axes.
    pub fn inward(self, direction: Vector) -> Vector {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| dot(self.outward(axis), direction))
    }
}

/// The camera of a test program: converts directions from its eye axes to the world.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProgramCamera {
    pub yaw: f64,
    pub pitch: f64,
}

impl ProgramCamera {
    pub fn to_world(self, eye: Vector) -> Vector {
        Turn { yaw: self.yaw, pitch: self.pitch, roll: 0.0 }.outward(eye)
    }
}

/// Axis and sign of the cube's face that a direction hits: 0…5 for −x +x −y +y −z +z.
pub fn cube_face(direction: Vector) -> usize {
    let axis = (0..3).fold(0, |best, axis| if direction[axis].abs() > direction[best].abs() { axis } else { best });
    2 * axis + usize::from(direction[axis] > 0.0)
}

/// Point where a direction hits the cube [−1, 1]³.
pub fn cube_point(direction: Vector) -> Vector {
    let longest = direction.iter().fold(0.0_f64, |longest, component| longest.max(component.abs()));
    direction.map(|component| component / longest)
}

/// Colour 0…1 that the test programs give to a direction of the world.
pub fn cube_colour(direction: Vector) -> Vector {
    cube_point(direction).map(|component| 0.5 + 0.5 * component)
}

/// An equidistant fisheye. Its circle is centred and touches the edges of the picture.
#[derive(Clone, Copy, Debug)]
pub struct Fisheye {
    pub width: f64,
    pub height: f64,
    /// Full opening angle in degrees.
    pub aperture: f64,
    /// Angle from straight up to the centre of the circle, towards the front, in degrees.
    pub tilt: f64,
}

impl Fisheye {
    /// Distance of a place from the circle's rim in pixels, positive inside.
    pub fn inside_by(&self, x: f64, y: f64) -> f64 {
        let radius = 0.5 * self.width.min(self.height);
        radius - (x - 0.5 * self.width).hypot(y - 0.5 * self.height)
    }

    /// Direction, in the viewer's axes, of a place in the picture. Places are pixels from the top
    /// left.
    pub fn direction(&self, x: f64, y: f64) -> Vector {
        let radius = 0.5 * self.width.min(self.height);
        let (right, up) = ((x - 0.5 * self.width) / radius, (0.5 * self.height - y) / radius);
        let distance = right.hypot(up);
        let (sin, cos) = (distance * 0.5 * self.aperture.to_radians()).sin_cos();
        let unit = if distance > 0.0 { [right / distance, up / distance] } else { [0.0; 2] };
        Turn { yaw: 0.0, pitch: 90.0 - self.tilt, roll: 0.0 }.outward([sin * unit[0], sin * unit[1], -cos])
    }
}

/// Opening of a pinhole camera, as tangents.
#[derive(Clone, Copy, Debug)]
pub struct Opening {
    pub left: f64,
    pub right: f64,
    pub bottom: f64,
    pub top: f64,
}

impl Opening {
    /// A symmetric opening with the given field of view in height, in degrees.
    pub fn vertical(fov: f64, aspect: f64) -> Self {
        let top = (0.5 * fov.to_radians()).tan();
        Self { left: -top * aspect, right: top * aspect, bottom: -top, top }
    }

    /// Direction, not normalised, at a place of the picture (0…1 from the left, 0…1 from the top).
    pub fn direction(&self, x: f64, y: f64) -> Vector {
        [self.left + x * (self.right - self.left), self.top + y * (self.bottom - self.top), -1.0]
    }
}

/// A projector in a spherical dome that is centred at the origin.
#[derive(Clone, Debug)]
pub struct Projector {
    pub name: String,
    pub width: f64,
    pub height: f64,
    pub position: Vector,
    pub turn: Turn,
    pub opening: Opening,
}

/// A spherical dome, a viewer and the program's camera.
#[derive(Clone, Copy, Debug)]
pub struct Dome {
    pub radius: f64,
    pub tilt: f64,
    pub coverage: f64,
    pub viewer: Vector,
    pub viewer_turn: Turn,
    pub camera_turn: Turn,
}

impl Dome {
    /// Angle from a point of the sphere to the screen's rim in degrees, negative where there is no
    /// screen.
    pub fn within_screen(&self, point: Vector) -> f64 {
        let pole = Turn { yaw: 0.0, pitch: 90.0 - self.tilt, roll: 0.0 }.outward([0.0, 0.0, -1.0]);
        let cosine = dot(pole, normalised(point)).clamp(-1.0, 1.0);
        0.5 * self.coverage - cosine.acos().to_degrees()
    }

    /// Direction of a point of the dome in the eye axes of the program's camera.
    pub fn eye_direction(&self, point: Vector) -> Vector {
        let from_viewer = add_scaled(point, self.viewer, -1.0);
        normalised(self.camera_turn.inward(self.viewer_turn.inward(from_viewer)))
    }
}

impl Projector {
    /// Direction, in the dome, of the ray through a place in the picture, in pixels from the top
    /// left.
    pub fn ray(&self, x: f64, y: f64) -> Vector {
        normalised(self.turn.outward(self.opening.direction(x / self.width, y / self.height)))
    }

    /// Point of the sphere that a place in the picture lights: the point where the ray leaves the
    /// sphere.
    pub fn hit(&self, dome: &Dome, x: f64, y: f64) -> Option<Vector> {
        let ray = self.ray(x, y);
        let along = dot(self.position, ray);
        let discriminant = along * along - dot(self.position, self.position) + dome.radius * dome.radius;
        let distance = -along + discriminant.max(0.0).sqrt();
        (discriminant >= 0.0 && distance > 0.0).then(|| add_scaled(self.position, ray, distance))
    }

    /// Place in the picture, in pixels from the top left, that lights a point. `None` if there is
    /// no such place.
    pub fn place(&self, point: Vector) -> Option<[f64; 2]> {
        let [x, y, z] = self.turn.inward(add_scaled(point, self.position, -1.0));
        let Opening { left, right, bottom, top } = self.opening;
        let (x, y) = ((x / -z - left) / (right - left), (top - y / -z) / (top - bottom));
        (z < 0.0 && (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)).then_some([x * self.width, y * self.height])
    }
}
