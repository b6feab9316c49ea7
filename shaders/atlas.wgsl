// Arrangement in which the views' pictures are tiles of one image.

@group(0) @binding(1) var atlas: texture_2d<f32>;

// `at`: coordinates in the atlas, number of the view.
fn texel(at: vec3<f32>) -> vec4<f32> {
    return textureSampleLevel(atlas, atlas_sampler, at.xy, 0.0);
}

// Width and height in texels of the picture that has view `number`.
fn picture_size(number: f32) -> vec2<f32> {
    return vec2<f32>(textureDimensions(atlas));
}
