// Draws the places where an output shows nothing.

@vertex
fn rectangle(@location(0) clip: vec2<f32>) -> @builtin(position) vec4<f32> {
    return vec4<f32>(clip, 0.0, 1.0);
}

@vertex
fn rectangle_down(@location(0) clip: vec2<f32>) -> @builtin(position) vec4<f32> {
    return vec4<f32>(clip.x, -clip.y, 0.0, 1.0);
}

@fragment
fn present() -> @location(0) vec4<f32> {
    return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
