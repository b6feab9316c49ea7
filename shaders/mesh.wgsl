// Directions and weights that were computed at the corners of triangles, and are interpolated here.

// Direction in base, weight: linear over the triangle.
alias Source = vec4<f32>;

struct Constants {
    shared_part: Shared,
}

fn trace(source: Source) -> Ray {
    return Ray(source.xyz, true, vec3<f32>(0.0, 1.0, 0.0), source.w, 0.0);
}
