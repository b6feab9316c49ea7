// Content: the only view is not a perspective one but a part of the program's window, which shows a
// picture of directions. Directions are in the picture's axes: x right, y up, −z its middle.

// Place in the picture that shows a direction, and the number of the cube's face plus one, or 1; 0:
// no place shows it.
fn content_place(d: vec3<f32>) -> vec3<f32> {
    let across = sqrt(d.x * d.x + d.y * d.y);
    if constants.shared_part.content.kind == 1u {
        let radius = content_radius(across, -d.z);
        // On the axis any way is right, and behind it one of them is.
        let way = select(d.xy / max(across, 1e-30), vec2<f32>(1.0, 0.0), across == 0.0);
        return vec3<f32>(way * radius, select(0.0, 1.0, radius <= 1.0));
    }
    if constants.shared_part.content.kind == 4u {
        return cube_place(d);
    }
    var value = d.xy / max(-d.z, 1e-30);
    var shown = d.z < 0.0;
    if constants.shared_part.content.kind != 5u {
        let level = sqrt(d.x * d.x + d.z * d.z);
        value.x = angle_of(d.x, -d.z);
        if constants.shared_part.content.kind == 2u {
            value.y = angle_of(d.y, level);
        } else {
            value.y = d.y / max(level, 1e-30);
        }
        shown = true;
    }
    let place = (value - vec2<f32>(0.0, constants.shared_part.content.middle)) * constants.shared_part.content.scale;
    // The sides count as inside, however they are rounded.
    shown = shown & all(abs(place) <= vec2<f32>(1.000001));
    return vec3<f32>(place, select(0.0, 1.0, shown));
}

// Radius in a fisheye of a direction with these distances from the axis and along it.
fn content_radius(across: f32, along: f32) -> f32 {
    let factors = constants.shared_part.content.radius;
    if constants.shared_part.content.curve == 0u {
        let angle = angle_of(across, along);
        let s = angle * angle;
        return angle * ((factors.x + factors.y * s) + (s * s) * (factors.z + factors.w * s));
    }
    let sine = across / sqrt(across * across + along * along);
    let cosine = along / sqrt(across * across + along * along);
    if constants.shared_part.content.curve == 3u {
        return select(2.0, factors.x * sine, cosine >= 0.0);
    }
    // Takes the one of the two forms that subtracts nothing.
    if constants.shared_part.content.curve == 1u {
        return factors.x * select(sqrt(0.5 - 0.5 * cosine), sine / sqrt(2.0 + 2.0 * max(cosine, 0.0)), cosine >= 0.0);
    }
    return factors.x * select((1.0 - cosine) / max(sine, 1e-30), sine / (1.0 + max(cosine, 0.0)), cosine >= 0.0);
}

// Place on a face, −1…1, and the face's number plus one: right, left, up, down, front, back.
fn cube_face(d: vec3<f32>) -> vec3<f32> {
    let a = abs(d);
    if a.x >= a.y && a.x >= a.z {
        return select(vec3<f32>(-d.z / a.x, d.y / a.x, 2.0), vec3<f32>(d.z / a.x, d.y / a.x, 1.0), d.x > 0.0);
    }
    if a.y >= a.z {
        return select(vec3<f32>(d.x / a.y, -d.z / a.y, 4.0), vec3<f32>(d.x / a.y, d.z / a.y, 3.0), d.y > 0.0);
    }
    return select(vec3<f32>(d.x / a.z, d.y / a.z, 5.0), vec3<f32>(-d.x / a.z, d.y / a.z, 6.0), d.z > 0.0);
}

// Direction of a place on a face.
fn cube_direction(p: vec2<f32>, face: f32) -> vec3<f32> {
    if face < 1.5 {
        return vec3<f32>(1.0, p.y, p.x);
    }
    if face < 2.5 {
        return vec3<f32>(-1.0, p.y, -p.x);
    }
    if face < 3.5 {
        return vec3<f32>(p.x, 1.0, p.y);
    }
    if face < 4.5 {
        return vec3<f32>(p.x, -1.0, -p.y);
    }
    if face < 5.5 {
        return vec3<f32>(p.x, p.y, -1.0);
    }
    return vec3<f32>(-p.x, p.y, 1.0);
}

// Place in the strip of all faces.
fn strip_place(on_face: vec3<f32>) -> vec3<f32> {
    return vec3<f32>((on_face.z + 0.5 * on_face.x - 0.5) / 3.0 - 1.0, on_face.y, on_face.z);
}

fn cube_place(d: vec3<f32>) -> vec3<f32> {
    return strip_place(cube_face(d));
}

// Atlas coordinates of a direction, and a number of at least 1 if it is shown.
fn locate_content(ray: Ray) -> vec3<f32> {
    let place = content_place(ray.base);
    let at = constants.shared_part.content.offset + constants.shared_part.content.half_size * place.xy;
    var shown = place.z;
    if constants.shared_part.edge != 0u {
        shown = select(0.0, shown, ray.on_screen);
    }
    return vec3<f32>(select(constants.shared_part.content.offset, at, shown > 0.0), shown);
}

// Keeps a place half a texel away from the sides of the rectangle with the middle `middle` and half
// the size `half_size`.
fn kept_inside(at: vec2<f32>, middle: vec2<f32>, half_size: vec2<f32>) -> vec2<f32> {
    let reach = max(abs(half_size) - 0.5 * constants.shared_part.content.step, vec2<f32>(0.0));
    return clamp(at, middle - reach, middle + reach);
}

// Sample of the picture at atlas coordinates on the face `at.z`. It reads nothing outside the
// picture; beyond a side it reads the side at which the picture goes on.
fn content_texel(at: vec3<f32>) -> vec4<f32> {
    let content = constants.shared_part.content;
    if content.kind == 4u {
        return cube_texel(at);
    }
    let kept = kept_inside(at.xy, content.offset, content.half_size);
    let here = texel(vec3<f32>(kept, 1.0));
    if content.wraps == 0u {
        return here;
    }
    // Distance beyond the middle of the last column, in texels. The next column is the last one of
    // the other side.
    let beyond = (at.x - kept.x) / content.step.x;
    let other = vec2<f32>(content.offset.x - sign(beyond) * (abs(content.half_size.x) - 0.5 * content.step.x), kept.y);
    return mix(here, texel(vec3<f32>(other, 1.0)), clamp(abs(beyond), 0.0, 1.0));
}

fn cube_texel(at: vec3<f32>) -> vec4<f32> {
    let content = constants.shared_part.content;
    let half_face = vec2<f32>(content.half_size.x / 6.0, content.half_size.y);
    let middle = face_middle(at.z);
    let kept = kept_inside(at.xy, middle, half_face);
    let here = texel(vec3<f32>(kept, 1.0));
    let beyond = (at.xy - kept) / content.step;
    let farther = max(abs(beyond.x), abs(beyond.y));
    if farther == 0.0 {
        return here;
    }
    // Beyond the farther one of the two sides, the first texel is on another face.
    let sideways = abs(beyond.x) >= abs(beyond.y);
    let next = kept + select(vec2<f32>(0.0, sign(beyond.y)), vec2<f32>(sign(beyond.x), 0.0), sideways) * content.step;
    let there = cube_face(cube_direction((next - middle) / half_face, at.z));
    let place = strip_place(there);
    let other = kept_inside(content.offset + content.half_size * place.xy, face_middle(there.z), half_face);
    return mix(here, texel(vec3<f32>(other, 1.0)), min(farther, 1.0));
}

// Atlas coordinates of the middle of a cube's face.
fn face_middle(face: f32) -> vec2<f32> {
    let content = constants.shared_part.content;
    return content.offset + content.half_size * strip_place(vec3<f32>(0.0, 0.0, face)).xy;
}
