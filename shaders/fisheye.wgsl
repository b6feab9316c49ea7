// An equidistant fisheye picture: pixel → direction by polynomials in the squared distance from
// the circle's centre. No square root, no division, no singular axis.

struct Constants {
    shared_part: Shared,
    // sin(r·α)/r and cos(r·α) as polynomials in r², r = 1 at the rim, lowest power first.
    sine: array<vec4<f32>, 2>,
    cosine: array<vec4<f32>, 2>,
    // Lens axes → base, and what the viewer's place adds.
    rotation: mat3x3<f32>,
    shift: vec3<f32>,
    // Lens axes → dome axes, for ramps.
    dome: mat3x3<f32>,
}

fn trace(source: vec2<f32>) -> Ray {
    let s = dot(source, source);
    let sine = polynomial(constants.sine[0], constants.sine[1], s);
    let cosine = polynomial(constants.cosine[0], constants.cosine[1], s);
    let lens = vec3<f32>(source * sine, -cosine);
    return Ray(constants.rotation * lens + constants.shift, s <= 1.0, constants.dome * lens, 1.0, 0.0);
}
