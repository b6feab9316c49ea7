// Arrangement in which the views' pictures are layers of one image, in the views' order.

@group(0) @binding(1) var atlas: texture_2d_array<f32>;

// `at`: coordinates in the layer, number of the view. Without a view the first layer is read.
fn texel(at: vec3<f32>) -> vec4<f32> {
    return textureSampleLevel(atlas, atlas_sampler, at.xy, i32(max(at.z - 0.5, 0.0)), 0.0);
}

// Width and height in texels of the picture that has view `number`.
fn picture_size(number: f32) -> vec2<f32> {
    return vec2<f32>(textureDimensions(atlas));
}
