// Arrangement in which each view's picture is an image. They are bound in the order of the batch's
// views, the first as `atlas`.

@group(0) @binding(1) var atlas: texture_2d<f32>;
@group(0) @binding(6) var image_1: texture_2d<f32>;
@group(0) @binding(7) var image_2: texture_2d<f32>;
@group(0) @binding(8) var image_3: texture_2d<f32>;
@group(0) @binding(9) var image_4: texture_2d<f32>;
@group(0) @binding(10) var image_5: texture_2d<f32>;
@group(0) @binding(11) var image_6: texture_2d<f32>;
@group(0) @binding(12) var image_7: texture_2d<f32>;

// `at`: coordinates in the view's image, number of the view. Without a view any image is read.
fn texel(at: vec3<f32>) -> vec4<f32> {
    if constants.shared_part.view_count > 1u {
        if at.z == constants.shared_part.views[1].number {
            return textureSampleLevel(image_1, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 2u {
        if at.z == constants.shared_part.views[2].number {
            return textureSampleLevel(image_2, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 3u {
        if at.z == constants.shared_part.views[3].number {
            return textureSampleLevel(image_3, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 4u {
        if at.z == constants.shared_part.views[4].number {
            return textureSampleLevel(image_4, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 5u {
        if at.z == constants.shared_part.views[5].number {
            return textureSampleLevel(image_5, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 6u {
        if at.z == constants.shared_part.views[6].number {
            return textureSampleLevel(image_6, atlas_sampler, at.xy, 0.0);
        }
    }
    if constants.shared_part.view_count > 7u {
        if at.z == constants.shared_part.views[7].number {
            return textureSampleLevel(image_7, atlas_sampler, at.xy, 0.0);
        }
    }
    return textureSampleLevel(atlas, atlas_sampler, at.xy, 0.0);
}

// Width and height in texels of the image that has view `number`.
fn picture_size(number: f32) -> vec2<f32> {
    var size = textureDimensions(atlas);
    if constants.shared_part.view_count > 1u {
        if number == constants.shared_part.views[1].number {
            size = textureDimensions(image_1);
        }
    }
    if constants.shared_part.view_count > 2u {
        if number == constants.shared_part.views[2].number {
            size = textureDimensions(image_2);
        }
    }
    if constants.shared_part.view_count > 3u {
        if number == constants.shared_part.views[3].number {
            size = textureDimensions(image_3);
        }
    }
    if constants.shared_part.view_count > 4u {
        if number == constants.shared_part.views[4].number {
            size = textureDimensions(image_4);
        }
    }
    if constants.shared_part.view_count > 5u {
        if number == constants.shared_part.views[5].number {
            size = textureDimensions(image_5);
        }
    }
    if constants.shared_part.view_count > 6u {
        if number == constants.shared_part.views[6].number {
            size = textureDimensions(image_6);
        }
    }
    if constants.shared_part.view_count > 7u {
        if number == constants.shared_part.views[7].number {
            size = textureDimensions(image_7);
        }
    }
    return vec2<f32>(size);
}
