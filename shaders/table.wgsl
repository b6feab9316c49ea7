// A direction, a weight and the light of black for each pixel, computed beforehand: a pixel's middle reads its own texel.

struct Constants {
    shared_part: Shared,
    // The table's axes → base.
    rotation: mat3x3<f32>,
    // Half of the output's width and height in pixels.
    half_size: vec2<f32>,
}

@group(0) @binding(5) var table: texture_2d<f32>;

// The table at a place of pixel `own`, interpolated between the centres of the four nearest pixels; one that shows
// nothing is taken to go on as `own` does.
fn between(place: vec2<f32>, own: vec4<f32>) -> vec4<f32> {
    let first = floor(place - 0.5);
    let part = place - 0.5 - first;
    let corner = vec2<i32>(first);
    let upper = mix(known(corner, own), known(corner + vec2<i32>(1, 0), own), part.x);
    let lower = mix(known(corner + vec2<i32>(0, 1), own), known(corner + vec2<i32>(1, 1), own), part.x);
    return vec4<f32>(mix(upper, lower, part.y).xyz, own.w);
}

fn known(at: vec2<i32>, own: vec4<f32>) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(table)) - 1;
    let texel = textureLoad(table, clamp(at, vec2<i32>(0), last), 0);
    let found = select(own, texel, dot(texel.xyz, texel.xyz) > 0.5);
    return vec4<f32>(found.xyz / sqrt(max(dot(found.xyz, found.xyz), 0.5)), found.w);
}

// `source`: pixels from the output's middle, y up.
fn trace(source: vec2<f32>) -> Ray {
    let place = vec2<f32>(constants.half_size.x + source.x, constants.half_size.y - source.y);
    var texel = textureLoad(table, vec2<i32>(place), 0);
    // A direction is longer than 1 by the light of all blacks there.
    var dark = 0.0;
    if constants.shared_part.lift > 0.0 {
        dark = max(sqrt(dot(texel.xyz, texel.xyz)) - 1.0, 0.0);
    }
    if constants.shared_part.four_places != 0u {
        texel = between(place, texel);
    }
    let shows = dot(texel.xyz, texel.xyz) > 0.5;
    // Where nothing is shown any direction does; it is not looked at.
    let direction = select(vec3<f32>(0.0, 0.0, -1.0), texel.xyz, shows);
    return Ray(constants.rotation * direction, shows, vec3<f32>(0.0, 1.0, 0.0), texel.w, dark);
}
