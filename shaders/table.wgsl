// A direction and a weight for each pixel, computed beforehand: one texel is read, none is interpolated.

struct Constants {
    shared_part: Shared,
    // The table's axes → base.
    rotation: mat3x3<f32>,
    // Half of the output's width and height in pixels.
    half_size: vec2<f32>,
}

@group(0) @binding(5) var table: texture_2d<f32>;

// `source`: pixels from the output's middle, y up.
fn trace(source: vec2<f32>) -> Ray {
    let place = vec2<f32>(constants.half_size.x + source.x, constants.half_size.y - source.y);
    let texel = textureLoad(table, vec2<i32>(place), 0);
    let shows = dot(texel.xyz, texel.xyz) > 0.5;
    // Where nothing is shown any direction does; it is not looked at.
    let direction = select(vec3<f32>(0.0, 0.0, -1.0), texel.xyz, shows);
    return Ray(constants.rotation * direction, shows, vec3<f32>(0.0, 1.0, 0.0), texel.w);
}
