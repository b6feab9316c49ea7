// A flat perspective picture: pixel → direction is a homography.

// Normalised coordinates of the output.
alias Source = vec2<f32>;

struct Constants {
    shared_part: Shared,
    matrix: mat3x3<f32>,
    // The same in dome axes, for ramps.
    dome: mat3x3<f32>,
}

fn trace(source: Source) -> Ray {
    let pixel = vec3<f32>(source, 1.0);
    return Ray(constants.matrix * pixel, true, constants.dome * pixel, 1.0, 0.0);
}
