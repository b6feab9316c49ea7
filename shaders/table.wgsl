// Directions, weights and the light of black that were computed beforehand: for each pixel, or
// (without black) at a larger step, and interpolated.

// Pixels from the output's middle, y up.
alias Source = vec2<f32>;

struct Constants {
    shared_part: Shared,
    // The table's axes → base.
    rotation: mat3x3<f32>,
    // Half of the output's width and height in pixels.
    half_size: vec2<f32>,
    // 1: an entry for the middle of each pixel. Otherwise the distance of entries in pixels; the
    // first entry is at the output's corner, and values in between are interpolated.
    step: f32,
}

@group(0) @binding(5) var table: texture_2d<f32>;

// The table at a place of pixel `own`, interpolated between the centres of the four nearest pixels.
// A pixel that shows nothing counts as `own`.
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

// Interpolates between the four entries around a place; only pixels that show something are drawn.
fn among(place: vec2<f32>) -> vec4<f32> {
    let at = max(place, vec2<f32>(0.0)) * (1.0 / constants.step);
    let first = min(floor(at), vec2<f32>(textureDimensions(table)) - 2.0);
    let part = at - first;
    let corner = vec2<i32>(first);
    let upper = mix(textureLoad(table, corner, 0), textureLoad(table, corner + vec2<i32>(1, 0), 0), part.x);
    let lower =
        mix(textureLoad(table, corner + vec2<i32>(0, 1), 0), textureLoad(table, corner + vec2<i32>(1, 1), 0), part.x);
    return mix(upper, lower, part.y);
}

fn trace(source: Source) -> Ray {
    let place = vec2<f32>(constants.half_size.x + source.x, constants.half_size.y - source.y);
    if constants.step > 1.0 {
        let entry = among(place);
        return Ray(constants.rotation * entry.xyz, true, vec3<f32>(0.0, 1.0, 0.0), entry.w, 0.0);
    }
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
    // Where nothing is shown, the direction is not used.
    let direction = select(vec3<f32>(0.0, 0.0, -1.0), texel.xyz, shows);
    return Ray(constants.rotation * direction, shows, vec3<f32>(0.0, 1.0, 0.0), texel.w, dark);
}
