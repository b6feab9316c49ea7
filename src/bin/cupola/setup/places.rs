//! Positions of projectors: their descriptions, and the keys of the rig that follow.

use glam::DVec3;

/// Description of a projector. Angles in degrees, lengths in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// Direction to the projector from the dome's centre: 0 front, 90 right.
    pub azimuth: Option<f64>,
    /// Horizontal distance from the centre.
    pub distance: Option<f64>,
    /// Height above the centre.
    pub height: Option<f64>,
    /// Horizontal field of view.
    pub fov: Option<f64>,
    /// Azimuth and angle from the pole of the point in the middle of its picture.
    pub aim: Option<[f64; 2]>,
    /// Width and height in pixels.
    pub size: Option<(u32, u32)>,
    /// Name of the output.
    pub name: Option<String>,
}

/// The dome and the audience. Angles in degrees, lengths in metres.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Radius of the dome.
    pub radius: f64,
    /// Angle from the zenith to the pole, towards the front.
    pub tilt: f64,
    /// Opening angle.
    pub coverage: f64,
    /// Position of the heads.
    pub seat: [f64; 3],
}

/// Reads `KEY=VALUE,…`.
pub fn place(text: &str) -> Result<Place, String> {
    let mut place = Place::default();
    for part in text.split(',') {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("{part:?}: expected KEY=VALUE"))?;
        set(&mut place, key.trim(), value.trim())?;
    }
    Ok(place)
}

fn set(place: &mut Place, key: &str, value: &str) -> Result<(), String> {
    let number = |least: f64, most: f64| {
        value
            .parse::<f64>()
            .ok()
            .filter(|number| (least..=most).contains(number))
            .ok_or_else(|| format!("{key}={value}: expected a number from {least} to {most}"))
    };
    match key {
        "azimuth" => place.azimuth = Some(number(-360.0, 360.0)?),
        "distance" => place.distance = Some(number(0.0, 1000.0)?),
        "height" => place.height = Some(number(-1000.0, 1000.0)?),
        "fov" => place.fov = Some(number(1.0, 170.0)?),
        "throw" => place.fov = Some(field_of_throw(number(0.05, 50.0)?)),
        "size" => place.size = Some(crate::arguments::size(value).map_err(|why| format!("size={value}: {why}"))?),
        "name" => place.name = Some(value.to_owned()),
        "aim" => {
            let parts = value.split_once(':').and_then(|(a, p)| Some([a.parse().ok()?, p.parse().ok()?]));
            let valid = parts.filter(|[a, p]: &[f64; 2]| a.abs() <= 360.0 && (0.0..=180.0).contains(p));
            place.aim =
                Some(valid.ok_or_else(|| format!("aim={value}: expected AZIMUTH:POLAR in degrees, like 0:50"))?);
        }
        _ => {
            return Err(format!("{key}: unknown; expected azimuth, distance, height, throw, fov, aim, size or name"));
        }
    }
    Ok(())
}

/// Horizontal field of view of a throw ratio (distance divided by width), degrees.
pub fn field_of_throw(ratio: f64) -> f64 {
    2.0 * (0.5 / ratio).atan().to_degrees()
}

/// A projector in the rig's axes: metres, and degrees.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Position of the lens.
    pub position: DVec3,
    /// Angle to the right.
    pub yaw: f64,
    /// Angle upwards.
    pub pitch: f64,
}

impl Place {
    /// Completes a description. Projector `index` of `count` stands near the dome's rim, one behind
    /// the audience and the others at equal angles, and lights the opposite side.
    pub fn completed(&self, index: usize, count: usize, room: &Room) -> Self {
        let azimuth = self.azimuth.unwrap_or_else(|| (180.0 + 360.0 * index as f64 / count.max(1) as f64) % 360.0);
        let polar = if count == 1 { 30.0 } else { 50.0 };
        Self {
            azimuth: Some(azimuth),
            distance: Some(self.distance.unwrap_or(0.9 * room.radius)),
            height: Some(self.height.unwrap_or(0.0)),
            fov: Some(self.fov.unwrap_or_else(|| field_of_throw(0.6))),
            aim: Some(self.aim.unwrap_or([(azimuth + 180.0) % 360.0, polar])),
            size: self.size,
            name: Some(self.name.clone().unwrap_or_else(|| format!("projector-{}", index + 1))),
        }
    }

    /// Position and direction of a completed description. `None` if the projector stands where it
    /// aims.
    pub fn pose(&self, room: &Room) -> Option<Pose> {
        let azimuth = self.azimuth?.to_radians();
        let (distance, height) = (self.distance?, self.height?);
        let position = DVec3::new(distance * azimuth.sin(), height, -distance * azimuth.cos());
        let aim = on_dome(self.aim?, room) - position;
        // Below a centimetre, the direction comes from rounding or a typing error.
        let direction = Some(aim).filter(|aim| aim.length() > 0.01)?.try_normalize()?;
        let yaw = direction.x.atan2(-direction.z).to_degrees();
        Some(Pose { position, yaw, pitch: direction.y.asin().to_degrees() })
    }
}

/// The point of the dome at an azimuth and an angle from its pole, which is tilted to the front.
fn on_dome([azimuth, polar]: [f64; 2], room: &Room) -> DVec3 {
    let (azimuth, polar, tilt) = (azimuth.to_radians(), polar.to_radians(), room.tilt.to_radians());
    let level = DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos());
    glam::DQuat::from_rotation_x(-tilt) * level * room.radius
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Room = Room { radius: 4.0, tilt: 30.0, coverage: 180.0, seat: [0.0; 3] };

    #[test]
    fn a_tilted_pole_is_towards_the_front() {
        let pole = on_dome([0.0, 0.0], &ROOM) / 4.0;
        assert!((pole - DVec3::new(0.0, 30f64.to_radians().cos(), -0.5)).length() < 1e-12, "{pole}");
    }

    #[test]
    fn projectors_look_at_what_they_aim_at() {
        let place = place("azimuth=180,distance=3,height=0.5,throw=0.5,aim=0:30").unwrap();
        let pose = place.completed(0, 1, &ROOM).pose(&ROOM).unwrap();
        assert!((pose.position - DVec3::new(0.0, 0.5, 3.0)).length() < 1e-12);
        // The aim is 60° from the zenith: 3.46 m in front of the centre and 2 m above it.
        let expected = (1.5f64).atan2(3.0 + 4.0 * 60f64.to_radians().sin()).to_degrees();
        assert!(pose.yaw.abs() < 1e-9 && (pose.pitch - expected).abs() < 1e-9, "{pose:?}");
        assert!((place.fov.unwrap() - 90.0).abs() < 1e-12);
    }

    #[test]
    fn projectors_without_a_place_stand_around_the_dome() {
        let azimuths: Vec<_> = (0..4).map(|i| Place::default().completed(i, 4, &ROOM).azimuth.unwrap()).collect();
        assert_eq!(azimuths, [180.0, 270.0, 0.0, 90.0]);
        let right = Place::default().completed(3, 4, &ROOM).pose(&ROOM).unwrap();
        assert!(right.position.x > 3.0 && right.yaw < -60.0, "it looks to the left: {right:?}");
    }

    #[test]
    fn wrong_places_are_explained() {
        for (wrong, expected) in [
            ("azimuth", "KEY=VALUE"),
            ("bearing=3", "expected azimuth"),
            ("fov=400", "1 to 170"),
            ("size=10", "WIDTHxHEIGHT"),
            ("aim=3", "AZIMUTH:POLAR"),
            ("throw=0,8", "0.05"),
        ] {
            let why = place(wrong).unwrap_err();
            assert!(why.contains(expected), "{wrong}: {why}");
        }
    }
}
