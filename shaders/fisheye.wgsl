// A fisheye picture: pixel → direction by polynomials in the squared distance from the circle's
// centre, and a root for the lenses that need one. No division, no singular axis.

// Normalised coordinates of the output.
alias Source = vec2<f32>;

struct Constants {
    shared_part: Shared,
    // Components across and along the axis as polynomials in r², r = 1 at the rim, lowest power
    // first.
    sine: array<vec4<f32>, 2>,
    cosine: array<vec4<f32>, 2>,
    // √(1 − x·r²) times y is added across, times z along the axis.
    root: vec3<f32>,
    // The viewer is not at the lens: directions need unit length.
    off_centre: u32,
    // Lens axes → base, and the shift by the viewer's position.
    rotation: mat3x3<f32>,
    shift: vec3<f32>,
    // Lens axes → dome axes, for ramps.
    dome: mat3x3<f32>,
}

fn trace(source: Source) -> Ray {
    let s = dot(source, source);
    var lens = radial(source, s, constants.sine, constants.cosine, constants.root);
    if constants.off_centre != 0u {
        lens = lens / sqrt(dot(lens, lens));
    }
    return Ray(constants.rotation * lens + constants.shift, s <= 1.0, constants.dome * lens, 1.0, 0.0);
}
