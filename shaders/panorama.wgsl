// Unrolled pictures of all directions: equirectangular, cylindrical, the faces of a cube side by
// side.

// Normalised coordinates of the output.
alias Source = vec2<f32>;

struct Constants {
    shared_part: Shared,
    // 0: equirectangular. 1: cylindrical. 2: cube.
    kind: u32,
    // sin and cos of the longitude over x, as in fisheye.wgsl.
    sine: array<vec4<f32>, 2>,
    cosine: array<vec4<f32>, 2>,
    // The same for the latitude over y, from the middle latitude.
    up_sine: array<vec4<f32>, 2>,
    up_cosine: array<vec4<f32>, 2>,
    // Equirectangular: sin and cos of the middle latitude. Cylindrical: middle height and half of
    // the height.
    middle: vec2<f32>,
    // Picture axes → base, and the shift by the viewer's position.
    rotation: mat3x3<f32>,
    shift: vec3<f32>,
    // Picture axes → dome axes, for ramps.
    dome: mat3x3<f32>,
}

fn unit(direction: vec3<f32>) -> vec3<f32> {
    return direction / sqrt(dot(direction, direction));
}

// Right, left, up, down, front, back.
fn cube(source: vec2<f32>) -> vec3<f32> {
    let along = 3.0 * (source.x + 1.0);
    let face = min(floor(along), 5.0);
    let x = 2.0 * (along - face) - 1.0;
    let y = source.y;
    let side = select(vec3<f32>(1.0, y, x), vec3<f32>(-1.0, y, -x), face == 1.0);
    let pole = select(vec3<f32>(x, 1.0, y), vec3<f32>(x, -1.0, -y), face == 3.0);
    let level = select(vec3<f32>(x, y, -1.0), vec3<f32>(-x, y, 1.0), face == 5.0);
    return select(select(side, pole, face > 1.0), level, face > 3.0);
}

fn trace(source: Source) -> Ray {
    var lens = vec3<f32>(0.0);
    if constants.kind == 2u {
        lens = unit(cube(source));
    } else {
        let s = source.x * source.x;
        let x = source.x * polynomial(constants.sine[0], constants.sine[1], s);
        let z = -polynomial(constants.cosine[0], constants.cosine[1], s);
        if constants.kind == 1u {
            lens = unit(vec3<f32>(x, constants.middle.x + constants.middle.y * source.y, z));
        } else {
            let t = source.y * source.y;
            let sine = source.y * polynomial(constants.up_sine[0], constants.up_sine[1], t);
            let cosine = polynomial(constants.up_cosine[0], constants.up_cosine[1], t);
            let level = constants.middle.y * cosine - constants.middle.x * sine;
            lens = vec3<f32>(x * level, constants.middle.x * cosine + constants.middle.y * sine, z * level);
        }
    }
    return Ray(constants.rotation * lens + constants.shift, true, constants.dome * lens, 1.0, 0.0);
}
